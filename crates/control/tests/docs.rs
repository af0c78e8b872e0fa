//! What the pages say of the control port is what it does.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use std::collections::BTreeSet;

use common::{Ring, Server};
use encoring_control::Options;
use serde_json::Value;

fn page(name: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/");
    std::fs::read_to_string(format!("{folder}{name}")).unwrap()
}

/// What is between single quotes and looks like a line of JSON.
fn requests(command: &str) -> String {
    let quoted = command.split('\'').skip(1).step_by(2);
    quoted.filter(|text| text.starts_with('{')).map(|text| format!("{text}\n")).collect()
}

/// What `jq` prints for `.a.b[1], .c`.
fn picked(answer: &Value, filter: &str) -> Vec<String> {
    let paths = filter.split(", ");
    let pick = |path: &str| {
        let keys = path.split(['.', '[', ']']).filter(|key| !key.is_empty());
        let value = keys.fold(answer, |value, key| match key.parse::<usize>() {
            Ok(index) => &value[index],
            Err(_) => &value[key],
        });
        value.to_string()
    };
    paths.map(pick).collect()
}

#[tokio::test]
async fn every_example_of_the_page_is_what_the_port_answers() {
    let server = Server::start(Options::default()).await;
    let page = page("control.md");
    let mut lines = page.lines().peekable();
    let mut examples = 0;
    while let Some(line) = lines.next() {
        let Some(command) = line.strip_prefix("$ ") else { continue };
        let mut documented = Vec::new();
        while let Some(line) = lines.next_if(|line| !line.starts_with("$ ") && *line != "```") {
            documented.push(line.to_owned());
        }
        let sent = requests(command);
        let filter =
            command.split_once("| jq ").map(|(_, jq)| jq.trim_start_matches("-c ").trim_matches('\''));
        let mut printed = Vec::new();
        // Some changes are seen a few cycles later, which is sooner than a person types.
        for _ in 0..10_000 {
            let answers = server.exchange(sent.as_bytes()).await;
            printed = match filter {
                Some(filter) => picked(&answers[0], filter),
                None => answers.iter().map(Value::to_string).collect(),
            };
            if filter.is_none() || printed == documented {
                break;
            }
        }
        if filter.is_none() {
            // The order of keys is no promise.
            let values = |lines: &[String]| -> Vec<Value> {
                lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect()
            };
            assert_eq!(values(&printed), values(&documented), "{command}");
        } else {
            assert_eq!(printed, documented, "{command}");
        }
        examples += 1;
    }
    assert!(examples >= 20, "{examples} examples");
}

fn keys_of(value: &Value, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                keys.insert(key.clone());
                keys_of(value, keys);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| keys_of(item, keys)),
        _ => {}
    }
}

#[test]
fn the_shapes_name_every_key_and_no_other() {
    let ring = Ring::start();
    let page = page("json.md");
    let (_, section) = page.split_once("\n## control\n").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let named: BTreeSet<&str> = section.split('`').skip(1).step_by(2).collect();

    let mut keys = BTreeSet::new();
    keys_of(&ring.ask(r#"{"verb":"view","id":1}"#), &mut keys);
    keys.extend(["trouble".to_owned(), "fault".to_owned()]);
    keys_of(&ring.ask("{}"), &mut keys);
    keys_of(&ring.ask(r#"{"verb":"gateway"}"#), &mut keys);
    keys_of(&ring.ask(r#"{"verb":"service","position":1,"service":8}"#), &mut keys);
    let help = ring.ask(r#"{"verb":"help"}"#);
    keys.extend(["verbs".to_owned(), "does".to_owned(), "verb".to_owned(), "examples".to_owned()]);
    assert!(help["verbs"][0].as_object().unwrap().keys().all(|key| keys.contains(key)));
    for key in &keys {
        assert!(named.contains(key.as_str()), "{key} is not in docs/json.md");
    }
    for row in section.lines().filter(|line| line.starts_with("| `")) {
        let first = row.split('|').nth(1).unwrap();
        for key in first.split('`').skip(1).step_by(2) {
            assert!(keys.contains(key), "docs/json.md names {key}, which is in no answer");
        }
    }
}
