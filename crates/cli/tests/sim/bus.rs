//! `--record-bus`: what a ring's master sees is in the file, whatever ends the simulation, and the referee reads it.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;

use crate::{Sim, ask, read_in, refused, run, service, write_out};

/// The rules that the referee finds broken in a file, and its exit code.
fn judged(folder: &Path, file: &str) -> (Option<i32>, Vec<String>) {
    let output = run(folder, &["referee", file, "--format", "json"]);
    let lines = String::from_utf8(output.stdout).unwrap();
    let rule = |line: &str| {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        assert_eq!(line["seen_from"], "w", "{line}");
        line["rule"].as_str().map(ToOwned::to_owned)
    };
    (output.status.code(), lines.lines().filter_map(rule).collect())
}

/// A service as the manuals have it: number and data first, the service bit in a write of its own.
fn right(client: &mut std::net::TcpStream, position: u8, request: u32) {
    write_out(client, position, request & 0x7FFF_FFFF);
    let before = read_in(client, position);
    // The shaft moves, so another position is another cycle.
    while read_in(client, position) == before {}
    service(client, position, request);
}

// [R33, R34]
#[test]
fn what_clients_write_and_the_ring_shows_is_in_the_file_and_the_referee_judges_it() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sim = Sim::start(here, &["--record-bus", "right.csv"]);
    let mut client = sim.connect("modbus");
    right(&mut client, 2, 0xC200_270F);
    right(&mut client, 2, 0x8800_0000);
    sim.end("-TERM");
    assert_eq!(judged(here, "right.csv"), (Some(0), vec![]));

    let sim = Sim::start(here, &["--record-bus", "wrong.csv"]);
    let mut client = sim.connect("modbus");
    service(&mut client, 2, 0xC200_270F);
    // The half with the service bit first.
    assert_eq!(ask(&mut client, &[6, 0, 4, 0xC6, 0]), [6, 0, 4, 0xC6, 0]);
    assert_eq!(ask(&mut client, &[6, 0, 5, 0, 5]), [6, 0, 5, 0, 5]);
    while read_in(&mut client, 2) >> 31 == 0 {}
    write_out(&mut client, 2, 0);
    sim.end("-INT");
    let (code, rules) = judged(here, "wrong.csv");
    assert_eq!(code, Some(1));
    assert!(rules.contains(&"data_with_service_bit".to_owned()), "{rules:?}");
    assert!(rules.contains(&"no_data_check".to_owned()), "{rules:?}");
    let file = fs::read_to_string(here.join("wrong.csv")).unwrap();
    let head = "# encoring-bus 1\n# device 0 la-66 ";
    assert!(file.starts_with(head), "{}", &file[..100]);
    for row in [",2,write,,,,1,both,C200270F\n", ",2,write,,,,1,high,C600\n", ",2,write,,,,1,low,0005\n"] {
        assert!(file.contains(row), "{row}");
    }
    assert!(!here.join("wrong.csv.partial").exists());
}

/// The next line but for what a loaded machine says.
fn next_line(lines: &mut impl BufRead) -> Option<serde_json::Value> {
    let lines = lines.lines().map(|line| serde_json::from_str::<serde_json::Value>(&line.unwrap()).unwrap());
    lines.into_iter().find(|line| line["event"] != "cycles_dropped")
}

/// The findings of a line, as the referee of a file prints them.
fn found(judged: &serde_json::Value) -> Vec<serde_json::Value> {
    judged["findings"].as_array().unwrap().clone()
}

// [R33, R34]
#[test]
fn the_first_break_of_a_rule_is_told_at_once_and_everything_at_the_end_as_from_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut sim = Sim::start(here, &["--record-bus", "bus.csv", "--control", "127.0.0.1:0"]);
    let (mut client, mut control) = (sim.connect("modbus"), sim.connect("control"));
    service(&mut client, 1, 0x8200_0000);
    let told = next_line(&mut sim.lines).unwrap();
    let first = (told["event"].as_str(), told["rule"].as_str(), told["position"].as_u64());
    assert_eq!(first, (Some("finding"), Some("data_with_service_bit"), Some(1)), "{told}");
    assert!(told["number"].is_u64() && told["time_ns"].is_u64() && told["advice"].is_string(), "{told}");
    service(&mut client, 1, 0x8200_0000);
    writeln!(control, r#"{{"verb":"view"}}"#).unwrap();
    let mut answer = String::new();
    BufReader::new(control).read_line(&mut answer).unwrap();
    let view: serde_json::Value = serde_json::from_str(&answer).unwrap();
    let seen = &view["view"]["referee"];
    assert_eq!(
        (seen["services"].as_u64(), seen["findings"][0]["count"].as_u64()),
        (Some(2), Some(2)),
        "{seen}"
    );
    let pid = sim.program.id().to_string();
    assert!(std::process::Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    let rest: Vec<serde_json::Value> = std::iter::from_fn(|| next_line(&mut sim.lines)).collect();
    assert_eq!(sim.program.wait().unwrap().code(), Some(0));
    let events: Vec<_> = rest.iter().map(|line| line["event"].as_str().unwrap()).collect();
    assert_eq!(events, ["judged", "served", "stopped"]);
    let from_file = run(here, &["referee", "bus.csv", "--format", "json"]);
    let from_file: Vec<serde_json::Value> = String::from_utf8(from_file.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .filter(|line: &serde_json::Value| line["rule"].is_string())
        .collect();
    assert_eq!(found(&rest[0]), from_file);
}

// [R33]
#[test]
fn a_strict_referee_ends_the_simulation_with_1_and_everything_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let files = ["--state", "memories", "--record-bus", "bus.csv"];
    let mut sim = Sim::start(here, &[&files[..], &["--referee", "strict"]].concat());
    let mut client = sim.connect("modbus");
    right(&mut client, 2, 0xC200_270F);
    // The ring stops when the encoder has replied: until then the word may still change.
    write_out(&mut client, 2, 0xC300_000A);
    let events: Vec<serde_json::Value> = std::iter::from_fn(|| next_line(&mut sim.lines)).collect();
    assert_eq!(sim.program.wait().unwrap().code(), Some(1));
    assert_eq!(
        (&events[0]["event"], &events[0]["rule"]),
        (&"finding".into(), &"data_with_service_bit".into())
    );
    assert_eq!(judged(here, "bus.csv"), (Some(1), vec!["data_with_service_bit".to_owned()]));
    let sim = Sim::start(here, &["--state", "memories", "--referee", "off", "--control", "127.0.0.1:0"]);
    let (mut client, mut control) = (sim.connect("modbus"), sim.connect("control"));
    assert_eq!(service(&mut client, 2, 0x8200_0000), 0x8200_270F);
    writeln!(control, r#"{{"verb":"view"}}"#).unwrap();
    let mut answer = String::new();
    BufReader::new(control).read_line(&mut answer).unwrap();
    assert!(answer.contains(r#""referee":null"#), "{answer}");
    let [served, _] = sim.last_two("-TERM");
    assert_eq!(served["event"], "served");
}

#[test]
fn a_mode_that_there_is_not_is_refused() {
    let said = refused(Path::new("."), &["sim", "--referee", "loud"]);
    assert!(
        said.starts_with("error: invalid value 'loud' for '--referee <MODE>': it must be on, off or strict"),
        "{said}"
    );
}

// [D1]
#[test]
fn a_stop_of_the_ring_is_in_the_file_and_a_service_bit_that_stood_through_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut sim = Sim::start(here, &["--record-bus", "bus.csv", "--control", "127.0.0.1:0"]);
    let (mut client, mut control) = (sim.connect("modbus"), sim.connect("control"));
    let mut answers = BufReader::new(control.try_clone().unwrap());
    let mut say = |line: &str| -> serde_json::Value {
        writeln!(control, "{line}").unwrap();
        let mut answer = String::new();
        answers.read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap()
    };
    let mut event = |name: &str| loop {
        let mut line = String::new();
        sim.lines.read_line(&mut line).unwrap();
        let event: serde_json::Value = serde_json::from_str(&line).unwrap();
        if event["event"] == name {
            break event["time_ns"].as_u64().unwrap();
        }
    };
    write_out(&mut client, 2, 0x8200_0000);
    say(r#"{"verb":"set","position":0,"set":{"supply_v":5.0}}"#);
    let silent = event("line_silent");
    while say(r#"{"verb":"view"}"#)["view"]["time_ns"].as_u64().unwrap() < silent + 100_000_000 {}
    say(r#"{"verb":"set","position":0,"set":{"supply_v":24.0}}"#);
    event("line_good");
    write_out(&mut client, 2, 0);
    while read_in(&mut client, 2) >> 31 == 1 {}
    sim.end("-TERM");
    let (_, rules) = judged(here, "bus.csv");
    assert!(rules.contains(&"stale_service_bit".to_owned()), "{rules:?}");
    let file = fs::read_to_string(here.join("bus.csv")).unwrap();
    assert!(file.contains(",2,cycle,82000000,,silent,,,\n"));
}

#[test]
fn files_that_cannot_be_recorded_into_are_refused_before_anything_is_done() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("there.csv"), "precious").unwrap();
    let common = ["sim", "--modbus", "off", "--for", "20ms", "--speed", "max"];
    for (arguments, said) in [
        (
            &["--record-bus", "there.csv"][..],
            "--record-bus there.csv: it is there already; name a new one, or give --overwrite",
        ),
        (
            &["--record", "new.csv", "--record-bus", "./new.csv"],
            "--record-bus ./new.csv: --record names the same file",
        ),
        (
            &["--record-bus", "nowhere/new.csv"],
            "--record-bus nowhere/new.csv: there is no folder nowhere; make it first",
        ),
        (
            &["--overwrite"],
            "--overwrite: there is nothing to record; name a file with --record or --record-bus",
        ),
    ] {
        assert_eq!(refused(here, &[&common, arguments].concat()), format!("error: {said}\n"));
    }
    assert_eq!(fs::read_dir(here).unwrap().count(), 1);
    assert_eq!(fs::read(here.join("there.csv")).unwrap(), b"precious");
    let both = [&common[..], &["--record", "a.csv", "--record-bus", "b.csv"]].concat();
    assert_eq!(run(here, &both).status.code(), Some(0));
    assert_eq!(run(here, &["replay", "--at", "2", "a.csv"]).status.code(), Some(0));
    assert_eq!(run(here, &["referee", "b.csv"]).status.code(), Some(3), "nobody asked for anything");
}
