//! Whatever a peer sends: every line is answered, nothing panics, the ring goes on.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use common::{Ring, Server};
use encoring_control::Options;
use encoring_station::verbs::parse;
use proptest::prelude::*;
use serde_json::Value;

const VALID: [&str; 6] = [
    r#"{"verb":"set","position":1,"set":{"supply_v":24.0,"preset1_v":1.5}}"#,
    r#"{"id":"a","verb":"set","position":0,"set":{"magnet":true,"motion":{"kind":"sine","center":5,"amplitude":3,"period_s":0.1}}}"#,
    r#"{"verb":"set","position":2,"set":{"motion":{"kind":"moves","moves":[{"to":1,"in_s":1.0}],"repeat":true}}}"#,
    r#"{"verb":"set","position":2,"set":{"eeprom":{"fault":"stuck","cell":5,"value":255}}}"#,
    r#"{"verb":"line","segment":1,"fault":"silent","for_s":0.1}"#,
    r#"{"verb":"view","id":12}"#,
];

/// One answer a line, whatever the bytes behind a first line that is an object.
async fn answered(server: &Server, bytes: &[u8], lines: usize) {
    let answers = server.exchange(&[b"{}\n", bytes].concat()).await;
    assert_eq!(answers.len(), lines + 1, "{}", String::from_utf8_lossy(bytes));
    for answer in answers {
        assert!(answer["ok"] == true || answer["error"].is_string(), "{answer}");
    }
}

#[test]
fn every_single_byte_change_of_a_line_is_read_without_panic() {
    let units = Ring::start().controlled.units;
    let (mut read, mut refused) = (0, 0);
    for valid in VALID {
        assert!(parse(valid, &units[..]).command.is_ok(), "{valid}");
        for at in 0..valid.len() {
            for byte in 0..=u8::MAX {
                let mut changed = valid.as_bytes().to_vec();
                changed[at] = byte;
                let Ok(changed) = String::from_utf8(changed) else { continue };
                match parse(&changed, &units[..]).command {
                    Ok(_) => read += 1,
                    Err(why) => refused += usize::from(!why.to_string().is_empty()),
                }
            }
        }
    }
    assert!(read > VALID.len() && refused > 10 * read, "{read} read, {refused} refused");
}

#[test]
fn every_truncation_is_refused() {
    let units = Ring::start().controlled.units;
    for valid in VALID {
        for end in 0..valid.len() {
            assert!(parse(&valid[..end], &units[..]).command.is_err(), "{}", &valid[..end]);
        }
    }
}

#[tokio::test]
async fn the_ring_goes_on_under_changed_bytes_and_truncations() {
    let server = Server::start(Options::default()).await;
    let before = server.ring.cycles();
    for valid in VALID {
        let mut sent = Vec::new();
        for at in 0..valid.len() {
            sent.extend_from_slice(&valid.as_bytes()[..at]);
            sent.push(b'\n');
            for byte in [0, b'"', b'-', b'0', b'9', b'[', b'{', b'}', b'\\', b'\n', b'\r', 0x80, 0xC3, 0xFF] {
                let mut changed = valid.as_bytes().to_vec();
                changed[at] = byte;
                sent.extend_from_slice(&changed);
                sent.push(b'\n');
            }
        }
        let lines = sent.iter().filter(|byte| **byte == b'\n').count();
        answered(&server, &sent, lines).await;
    }
    server.ring.done(r#"{"verb":"line","fault":"none"}"#);
    assert!(server.ring.cycles() > before);
    let outcome = server.stop().await.station.stop();
    assert!(outcome.is_ok(), "the ring's thread has not panicked");
}

#[test]
fn deep_nesting_and_huge_numbers_are_refused() {
    let ring = Ring::start();
    let deep = |open: &str, times: usize| open.repeat(times);
    let set = |set: &str| format!(r#"{{"verb":"set","position":1,"set":{set}}}"#);
    let lines = [
        deep("[", 60_000),
        deep("{\"verb\":", 8_000),
        set(&deep("{\"motion\":", 6_000)),
        set(&format!(
            "{{\"motion\":{{\"kind\":\"hold\",\"raw\":{}{}}}}}",
            deep("[", 20_000),
            deep("]", 20_000)
        )),
        format!(r#"{{"verb":{}{}}}"#, deep("[", 20_000), deep("]", 20_000)),
        format!(r#"{{"verb":"view","x":{}{}}}"#, deep("[", 20_000), deep("]", 20_000)),
        format!(r#"{{"verb":"view","{}":1}}"#, deep("x", 60_000)),
        format!(r#"{{"verb":"{}"}}"#, deep("\u{e9}", 30_000)),
        set(&format!("{{\"raw\":{}}}", deep("9", 60_000))),
        set("{\"raw\":9223372036854775807}"),
        set("{\"supply_v\":1e999}"),
        set("{\"supply_v\":1e308}"),
        set("{\"supply_v\":-1e-320}"),
        set("{\"motion\":{\"kind\":\"speed\",\"rpm\":1e308}}"),
        r#"{"verb":"line","segment":18446744073709551616,"fault":"bad"}"#.to_owned(),
        r#"{"verb":"line","segment":1,"fault":"bad","for_s":1e308}"#.to_owned(),
    ];
    for line in lines {
        let shown: String = line.chars().take(60).collect();
        assert!(ring.refused(&line).chars().count() <= 515, "{shown}");
    }
    // Times that add up beyond all bounds stay within.
    let moves = "{\"to\":4611686018427387904,\"in_s\":1e9,\"wait_s\":1e9},".repeat(1_000);
    let moves = moves.trim_end_matches(',');
    ring.done(&set(&format!("{{\"motion\":{{\"kind\":\"moves\",\"moves\":[{moves}],\"repeat\":true}}}}")));
    let speed = "{\"kind\":\"speed\",\"per_s\":-1e9,\"start\":-4611686018427387904}";
    ring.done(&set(&format!("{{\"motion\":{speed}}}")));
    let before = ring.cycles();
    ring.until(|view| view["counters"]["cycles"].as_u64() > Some(before + 1_000));
    assert_eq!(ring.view()["devices"][1]["raw"], -4_611_686_018_427_387_904_i64);
    assert!(ring.station.stop().is_ok());
}

fn json_like() -> impl Strategy<Value = String> {
    let scalar = prop_oneof![
        Just("null".to_owned()),
        any::<bool>().prop_map(|value| value.to_string()),
        any::<i64>().prop_map(|value| value.to_string()),
        any::<f64>().prop_map(|value| value.to_string()),
        "[a-z_0-9]{0,8}".prop_map(|text| format!("\"{text}\"")),
        prop::sample::select(vec![
            "\"set\"",
            "\"line\"",
            "\"hold\"",
            "\"speed\"",
            "\"cut\"",
            "\"none\"",
            "1"
        ])
        .prop_map(str::to_owned),
    ];
    scalar.prop_recursive(4, 32, 6, |inner| {
        let key = prop::sample::select(vec![
            "verb",
            "id",
            "position",
            "set",
            "segment",
            "fault",
            "for_s",
            "supply_v",
            "raw",
            "motion",
            "kind",
            "moves",
            "to",
            "in_s",
            "eeprom",
            "cell",
            "after_bytes",
            "magnet",
            "per_s",
            "start",
        ]);
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(|items| format!("[{}]", items.join(","))),
            prop::collection::vec((key, inner), 0..6).prop_map(|entries| {
                let entries: Vec<String> =
                    entries.iter().map(|(key, value)| format!("\"{key}\":{value}")).collect();
                format!("{{{}}}", entries.join(","))
            }),
        ]
    })
}

#[test]
fn any_text_is_answered_with_one_line_of_json() {
    let ring = Ring::start();
    let texts = prop_oneof![
        any::<String>(),
        json_like(),
        json_like().prop_map(|value| format!(r#"{{"verb":"set","position":1,"set":{value}}}"#)),
        json_like().prop_map(|value| format!(r#"{{"verb":"set","position":0,"set":{{"motion":{value}}}}}"#)),
        json_like().prop_map(|value| format!(r#"{{"verb":"line","segment":{value},"fault":"bad"}}"#)),
        json_like().prop_map(|value| format!(r#"{{"verb":"gateway","fault":{value}}}"#)),
    ];
    proptest!(|(text in texts)| {
        let answer = encoring_station::answer::answer(&text, &ring.controlled);
        prop_assert!(!answer.contains('\n'));
        let answer: Value = serde_json::from_str(&answer).unwrap();
        prop_assert!(answer["ok"] == true || answer["error"].is_string());
    });
    assert!(ring.station.stop().is_ok());
}

#[test]
fn any_bytes_are_answered_and_the_port_goes_on() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let server = runtime.block_on(Server::start(Options::default()));
    let pieces = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..200),
        prop::sample::select(VALID.to_vec()).prop_map(|line| line.as_bytes().to_vec()),
        Just(b"\r\n".to_vec()),
        Just(b"\n".to_vec()),
    ];
    proptest!(ProptestConfig::with_cases(64), |(pieces in prop::collection::vec(pieces, 0..8))| {
        let mut sent = pieces.concat();
        sent.push(b'\n');
        let lines = sent.iter().filter(|byte| **byte == b'\n').count();
        runtime.block_on(answered(&server, &sent, lines));
    });
    runtime.block_on(answered(&server, b"{\"verb\":\"view\"}\n", 1));
}
