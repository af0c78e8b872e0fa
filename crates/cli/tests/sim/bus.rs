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
        (&["--record-bus", "nowhere/new.csv"], "--record-bus nowhere/new.csv: there is no such folder"),
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
