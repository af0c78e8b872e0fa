//! The master's commands through a gateway that misbehaves, as their users run both.
#![allow(clippy::disallowed_methods, reason = "a test reads what was printed")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    missing_docs,
    reason = "a test may panic"
)]

mod common;

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");

/// The program; the journal of whoever runs the tests is left alone.
fn program() -> Command {
    let mut command = Command::new(PROGRAM);
    let states = format!("{}/states-{}", env!("CARGO_TARGET_TMPDIR"), std::process::id());
    command.env("XDG_STATE_HOME", states);
    command
}

/// A simulated ring behind a gateway with faults; it ends with the test.
struct Gateway {
    program: Child,
    /// Nobody reads on, but a pipe that is closed would end it.
    _lines: BufReader<ChildStdout>,
    address: String,
    /// The control port.
    control: String,
}

impl Gateway {
    /// A CE-65-M that stands at 5000 and one that moves.
    fn start(folder: &Path, faults: &[&str]) -> Self {
        let options: Vec<&str> = faults.iter().flat_map(|fault| ["--gateway-fault", fault]).collect();
        Self::with(folder, "", &options)
    }

    /// With more lines of the scenario, and more options.
    fn with(folder: &Path, more: &str, options: &[&str]) -> Self {
        let device = |position: usize, motion: &str| {
            format!("[[device]]\nposition = {position}\nmodel = \"ce-65-m\"\nmotion = {{ {motion} }}\n")
        };
        let (stands, moves) =
            ("kind = \"hold\", raw = 5000", "kind = \"speed\", per_s = 3000.0, start = 70000");
        let file = folder.join("ring.toml");
        fs::write(&file, format!("version = 1\n{}{}{more}", device(0, stands), device(1, moves))).unwrap();
        let mut command = program();
        command
            .args(["sim", "--format", "json", "--web", "off", "--modbus", "0", "--control", "0"])
            .arg(file);
        let (program, lines, listening) = common::listening(command.args(options));
        let [address, control] =
            ["modbus", "control"].map(|name| listening[name].as_str().unwrap().to_owned());
        Self { program, _lines: lines, address, control }
    }

    /// Runs a command on the encoder at `at`; short time-outs, as this machine answers at once.
    fn run(&self, command: &str, at: usize, options: &str) -> (Option<i32>, serde_json::Value, String) {
        let bus = format!("modbus-tcp://{}?timeout_ms=200&settle_ms=5{options}", self.address);
        let mut arguments: Vec<&str> = command.split(' ').collect();
        let at = at.to_string();
        arguments.extend(["--bus", &bus, "--at", &at, "--model", "ce-65-m", "--format", "json"]);
        let output = program().args(arguments).output().unwrap();
        let printed = serde_json::from_slice(&output.stdout).unwrap_or_default();
        (output.status.code(), printed, String::from_utf8(output.stderr).unwrap())
    }

    /// What the control port answers.
    fn tell(&self, line: &str) -> serde_json::Value {
        let mut control = TcpStream::connect(&self.control).unwrap();
        control.write_all(format!("{line}\n").as_bytes()).unwrap();
        let mut answer = String::new();
        BufReader::new(control).read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap()
    }

    /// What OUT and IN of the encoder at 0 really are.
    fn truth(&self) -> (String, u64) {
        let view = self.tell(r#"{"verb":"view"}"#);
        let device = &view["view"]["devices"][0];
        let input = u64::from_str_radix(device["in"].as_str().unwrap(), 16).unwrap();
        (device["out"].as_str().unwrap().to_owned(), input)
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

#[test]
fn one_late_answer_ends_no_command_wherever_it_is() {
    let folder = tempfile::tempdir().unwrap();
    for late in [1, 4, 16, 40] {
        let gateway = Gateway::start(folder.path(), &[&format!("late=500#{late}")]);
        let (code, view, told) = gateway.run("write numerator 5000 --yes --no-backup", 0, "");
        assert_eq!((code, &view["result"]), (Some(0), &"verified".into()), "{late}: {view} {told}");
    }
    for late in (1..40).step_by(3) {
        let gateway = Gateway::start(folder.path(), &[&format!("late=500#{late}")]);
        let (code, view, told) = gateway.run("preset 7 --yes", 0, "");
        let (out, input) = gateway.truth();
        assert_eq!(u32::from_str_radix(&out, 16).unwrap() >> 31, 0, "{late}: {out}");
        assert_eq!(code == Some(0), input == 7, "{late}: {input} {view} {told}");
        assert_eq!(code, Some(0), "{late}: {view} {told}");
    }
}

#[test]
fn every_command_works_through_a_gateway_that_closes_behind_each_answer_or_sends_it_in_two() {
    let folder = tempfile::tempdir().unwrap();
    for fault in ["close", "split", "max=2", "busy@0s+50ms"] {
        let gateway = Gateway::start(folder.path(), &[fault]);
        for command in ["read all", "check --yes", "preset 7 --yes", "write numerator 5000 --yes --no-backup"]
        {
            let (code, view, told) = gateway.run(command, 0, "");
            assert_eq!(code, Some(0), "{fault}, {command}: {view} {told}");
        }
    }
}

#[test]
fn what_differs_in_an_answer_is_told_with_both_values_and_the_option() {
    let folder = tempfile::tempdir().unwrap();
    for (fault, says, option) in [
        ("unit=0", "unit 0 instead of 1", "&accept=unit"),
        ("transaction", "transaction number 1 instead of 0", "&accept=transaction"),
        (
            "swapped",
            "with its halves exchanged it is 00001388, a position. What cures it: order=low-first",
            "&order=low-first",
        ),
    ] {
        let gateway = Gateway::start(folder.path(), &[fault]);
        let (code, _, told) = gateway.run("read 02", 0, "");
        assert_eq!(code, Some(3), "{told}");
        assert!(told.contains(says) && told.contains(&gateway.address), "{told}");
        assert!(told.contains(option.trim_start_matches('&')), "{told}");
        let (code, view, told) = gateway.run("read 02", 0, option);
        assert_eq!(code, Some(0), "{fault}: {view} {told}");
    }
}

#[test]
fn a_service_bit_on_a_dead_link_is_told_and_can_be_released_when_it_is_back() {
    let folder = tempfile::tempdir().unwrap();
    for command in
        ["read 02 --patience 600ms", "check --yes --patience 600ms", "preset 7 --yes --patience 600ms"]
    {
        let gateway = Gateway::start(folder.path(), &["dead+4s"]);
        let (code, view, told) = gateway.run(command, 0, "");
        let (out, _) = gateway.truth();
        assert_eq!(u32::from_str_radix(&out, 16).unwrap() >> 31, 1, "{command}: {out}");
        assert_eq!((code, &view["service_bit_left"]), (Some(3), &out.clone().into()), "{command}: {told}");
        assert!(told.contains(&out) && told.contains("encoring release --at 0"), "{command}: {told}");
        // Until the link is back nobody answers.
        let released = loop {
            let bus = format!("modbus-tcp://{}?timeout_ms=200", gateway.address);
            let arguments = ["release", "--bus", &bus, "--at", "0", "--yes"];
            let output = program().args(arguments).output().unwrap();
            if output.status.code() != Some(3) {
                break output;
            }
        };
        assert_eq!(released.status.code(), Some(0), "{}", String::from_utf8(released.stderr).unwrap());
        assert_eq!(u32::from_str_radix(&gateway.truth().0, 16).unwrap() >> 31, 0);
    }
}

#[test]
fn every_kind_of_fault_is_taken_by_the_command_line_a_scenario_and_the_control_port() {
    let folder = tempfile::tempdir().unwrap();
    // None of them begins while this runs.
    let kinds = [
        ["silent", "busy", "drop", "dead", "close", "split", "garbled", "swapped", "transaction"].as_slice(),
        &["late=2500", "late=2500#17", "exception=0B", "unit=0", "max=16"],
    ]
    .concat();
    let later = |from: &str| -> Vec<_> { kinds.iter().map(|kind| format!("{kind}@{from}+1000ms")).collect() };
    let (by_scenario, by_option, told) = (later("7200000ms"), later("7300000ms"), later("7400000ms"));
    let table = |fault: &String| format!("[[gateway_fault]]\nfault = \"{fault}\"\n");
    let tables: String = by_scenario.iter().map(table).collect();
    let options: Vec<&str> = by_option.iter().flat_map(|fault| ["--gateway-fault", fault]).collect();
    let gateway = Gateway::with(folder.path(), &tables, &options);
    for fault in &told {
        let answer = gateway.tell(&format!(r#"{{"verb":"gateway","fault":"{fault}"}}"#));
        assert_eq!(answer["ok"], true, "{fault}: {answer}");
    }
    let all: Vec<String> = [by_scenario, by_option, told].concat();
    assert_eq!(gateway.tell(r#"{"verb":"gateway"}"#)["faults"], serde_json::json!(all));

    let file = folder.path().join("wrong.toml");
    let device = "[[device]]\nposition = 0\nmodel = \"ce-65-m\"\n";
    fs::write(&file, format!("version = 1\n{device}[[gateway_fault]]\nfault = \"slow\"\n")).unwrap();
    let output = program().args(["sim", "--modbus", "0"]).arg(&file).output().unwrap();
    let problem = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{problem}");
    assert!(problem.contains("wrong.toml, line 6: gateway fault \"slow\"; there are silent,"), "{problem}");
}

#[test]
fn the_control_port_begins_and_ends_what_masters_meet() {
    let folder = tempfile::tempdir().unwrap();
    let gateway = Gateway::start(folder.path(), &[]);
    let read = |patience: &str| gateway.run(&format!("read 02 --patience {patience}"), 0, "").0;
    assert_eq!(read("600ms"), Some(0));
    gateway.tell(r#"{"verb":"gateway","fault":"silent"}"#);
    assert_eq!(read("600ms"), Some(3));
    gateway.tell(r#"{"verb":"gateway","end":"silent"}"#);
    assert_eq!(read("600ms"), Some(0));
    // Once it is dead only the control port can bring it back.
    gateway.tell(r#"{"verb":"gateway","fault":"dead"}"#);
    assert_eq!(read("600ms"), Some(3));
    assert_eq!(gateway.tell(r#"{"verb":"gateway"}"#)["faults"], serde_json::json!(["dead"]));
    gateway.tell(r#"{"verb":"gateway","end":"all"}"#);
    let (code, view, told) = gateway.run("read 02", 0, "");
    assert_eq!(code, Some(1), "{view} {told}");
    assert!(told.contains("encoring release --at 0"), "the service bit still stands: {told}");
    let wrong = gateway.tell(r#"{"verb":"gateway","fault":"late=x"}"#);
    assert!(wrong["error"].as_str().unwrap().starts_with("gateway fault late: value \"x\""), "{wrong}");
}

#[test]
fn after_a_command_was_killed_the_next_one_says_what_it_found_and_what_takes_it_back() {
    let folder = tempfile::tempdir().unwrap();
    let gateway = Gateway::start(folder.path(), &["late=300"]);
    let bus = format!("modbus-tcp://{}?timeout_ms=5000", gateway.address);
    let mut killed = Command::new(PROGRAM)
        .args(["write", "numerator", "5000", "--yes", "--no-backup", "--bus", &bus, "--at", "0"])
        .args(["--model", "ce-65-m"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let service_bit = |out: &str| u32::from_str_radix(out, 16).unwrap() >> 31 == 1;
    while !service_bit(&gateway.truth().0) {}
    killed.kill().unwrap();
    killed.wait().unwrap();
    gateway.tell(r#"{"verb":"gateway","end":"all"}"#);
    // What it had sent last has arrived by then.
    let (out, _) = gateway.truth();
    assert!(service_bit(&out), "{out}");
    for command in ["read 02", "check --yes", "preset 7 --yes"] {
        let (code, view, told) = gateway.run(command, 0, "");
        assert_eq!(code, Some(1), "{command}: {view} {told}");
        let says = format!("{}: OUT holds {out}: another master's service", gateway.address);
        assert!(told.contains(&says) && told.contains("`encoring release --at 0`"), "{command}: {told}");
        assert_eq!(gateway.truth().0, out, "{command} has written");
    }
    let release = ["release", "--bus", &bus, "--at", "0", "--yes"];
    let output = Command::new(PROGRAM).args(release).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8(output.stderr).unwrap());
    assert_eq!(gateway.run("read 02", 0, "").0, Some(0));
}

#[test]
fn a_ring_with_its_low_half_first_is_told_as_that_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let gateway = Gateway::with(folder.path(), "", &["--word-order", "low-first"]);
    for command in ["read 02", "check --yes", "preset 7 --yes", "write numerator 5000 --yes --no-backup"] {
        for at in [0, 1] {
            let (code, view, told) = gateway.run(command, at, "");
            let told = format!("{view} {told}");
            assert_eq!(code, Some(3), "{command}: {told}");
            // One that moves may show a word that is none in any order.
            if at == 0 {
                assert!(
                    told.contains("with its halves exchanged it is 00001388, a position"),
                    "{command}: {told}"
                );
                assert!(
                    told.contains("order=low-first in the address, or in=input:1 if"),
                    "{command}: {told}"
                );
                assert!(told.contains(&gateway.address), "{command}: {told}");
            }
            assert!(!told.contains("carried it out: its reply was seen"), "{command}: {told}");
            assert!(!told.contains("make the machine safe"), "{command}: {told}");
        }
        assert_eq!(gateway.truth(), ("00000000".to_owned(), 0x1388), "{command}");
    }
    assert_eq!(gateway.run("preset 7 --yes", 0, "&order=low-first").0, Some(0));
    assert_eq!(gateway.truth().1, 7);
}

#[test]
fn log_and_watch_see_no_gap_through_a_gateway_that_closes_behind_each_answer() {
    let folder = tempfile::tempdir().unwrap();
    let gateway = Gateway::start(folder.path(), &["close"]);
    let bus = format!("modbus-tcp://{}?timeout_ms=5000", gateway.address);
    let file = folder.path().join("log.csv");
    let common = ["--bus", &bus, "--at", "0-1", "--model", "ce-65-m", "--for", "1s"];
    let run = |command: &mut Command| {
        let output = command.args(common).output().unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(!said.contains("connection lost") && !said.contains("no_answer"), "{said}");
    };
    run(Command::new(PROGRAM).arg("log").arg(&file));
    run(Command::new(PROGRAM).arg("watch"));
    let rows = fs::read_to_string(file).unwrap();
    assert!(rows.lines().filter(|line| !line.contains('#')).count() > 4, "{rows}");
    assert!(rows.contains("0x00001388"), "{rows}");
}

/// What nobody in a plant says.
fn is_no_plain_word(told: &str) -> bool {
    let banned = ["uncategorized", "entity not found", "after 1 requests", "no connection: no connection"];
    let fraction = |word: &str| word.split_once('.').is_some_and(|(_, decimals)| decimals.len() > 3);
    let words: Vec<_> = told.split_whitespace().collect();
    banned.iter().any(|banned| told.contains(banned))
        || words.windows(2).any(|pair| pair[1].starts_with("ms") && fraction(pair[0]))
}

#[test]
fn whatever_fails_is_told_with_host_and_port_in_plain_words() {
    let folder = tempfile::tempdir().unwrap();
    let nobody = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let faults =
        ["silent", "exception=01", "exception=02", "exception=04", "exception=0A", "exception=0B", "busy"];
    let more = ["unit=0", "transaction", "swapped", "drop", "dead"];
    let gateways: Vec<_> = faults
        .into_iter()
        .chain(more)
        .map(|fault| (fault, Gateway::start(folder.path(), &[fault])))
        .collect();
    let all = gateways.iter().map(|(fault, gateway)| (*fault, gateway.address.clone()));
    let commands = [
        "read 02 --at 0 --model ce-65-m",
        "check --yes --at 0 --model ce-65-m",
        "preset 7 --yes --at 0 --model ce-65-m",
        "write numerator 5000 --yes --no-backup --at 0 --model ce-65-m",
        "backup kept.toml --at 0 --model ce-65-m",
        "release --yes --at 0",
        "log FAULT.csv --for 300ms --at 0 --model ce-65-m",
        "scan",
    ];
    std::thread::scope(|scope| {
        for (fault, address) in all.chain([("nobody", nobody)]) {
            let folder = folder.path();
            scope.spawn(move || {
                for command in commands {
                    let layout = if command == "scan" { "&layout=inline" } else { "" };
                    let bus = format!("modbus-tcp://{address}?timeout_ms=100{layout}");
                    let line = command.replace("FAULT", fault);
                    let arguments = line.split(' ').chain(["--bus", &bus]);
                    let output = program().current_dir(folder).args(arguments).output().unwrap();
                    let told = [output.stderr, output.stdout].concat();
                    let told = String::from_utf8(told).unwrap();
                    assert!(!is_no_plain_word(&told), "{fault}, {command}: {told}");
                    // A log of exchanged words is one of words all the same.
                    let logged = command.starts_with("log") && fault == "swapped";
                    if output.status.code() != Some(0) && !logged {
                        assert!(told.contains(&address), "{fault}, {command}: {told}");
                    }
                }
            });
        }
    });
}
