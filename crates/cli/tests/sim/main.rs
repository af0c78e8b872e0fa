//! `encoring sim` as its users run it: the program, sockets and files.
#![allow(clippy::disallowed_methods, reason = "a test reads what was printed")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    missing_docs,
    reason = "a test may panic"
)]

mod bus;
#[path = "../common/mod.rs"]
mod common;
mod kept;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output};

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(PROGRAM).current_dir(folder).args(arguments).output().unwrap()
}

/// What a refused call says; it ends with 2 and prints nothing else.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert_eq!(output.stdout, b"", "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// A simulation that runs in the background.
struct Sim {
    program: Child,
    lines: BufReader<ChildStdout>,
    listening: serde_json::Value,
}

impl Sim {
    /// Without the page, unless the arguments ask for it: whoever else runs may hold its default port.
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let no_page: &[&str] = if arguments.contains(&"--web") { &[] } else { &["--web", "off"] };
        let mut command = Command::new(PROGRAM);
        command
            .current_dir(folder)
            .args(["sim", "--format", "json", "--modbus", "127.0.0.1:0"])
            .args(no_page)
            .args(arguments);
        let (program, lines, listening) = common::listening(&mut command);
        Self { program, lines, listening }
    }

    fn connect(&self, name: &str) -> TcpStream {
        TcpStream::connect(self.listening[name].as_str().unwrap()).unwrap()
    }

    /// Ends it as `signal` would, and gives its last line.
    fn end(self, signal: &str) -> serde_json::Value {
        let [_, last] = self.last_two(signal);
        last
    }

    /// The same with the line before it.
    fn last_two(mut self, signal: &str) -> [serde_json::Value; 2] {
        let pid = self.program.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        let mut rest = String::new();
        self.lines.read_to_string(&mut rest).unwrap();
        assert_eq!(self.program.wait().unwrap().code(), Some(0));
        let lines: Vec<&str> = rest.lines().collect();
        lines.last_chunk().unwrap().map(|line| serde_json::from_str(line).unwrap())
    }
}

/// One Modbus request.
fn ask(client: &mut TcpStream, pdu: &[u8]) -> Vec<u8> {
    let length = u16::try_from(pdu.len() + 1).unwrap().to_be_bytes();
    client.write_all(&[&[0, 1, 0, 0][..], &length, &[1], pdu].concat()).unwrap();
    let mut header = [0; 7];
    client.read_exact(&mut header).unwrap();
    let mut answer = vec![0; usize::from(u16::from_be_bytes([header[4], header[5]])) - 1];
    client.read_exact(&mut answer).unwrap();
    answer
}

fn write_out(client: &mut TcpStream, position: u8, word: u32) {
    let pdu = [&[16, 0, 2 * position, 0, 2, 4][..], &word.to_be_bytes()].concat();
    assert_eq!(ask(client, &pdu), pdu[..5]);
}

fn read_in(client: &mut TcpStream, position: u8) -> u32 {
    let answer = ask(client, &[4, 0, 2 * position, 0, 2]);
    u32::from_be_bytes(answer[2..6].try_into().unwrap())
}

/// A whole service; waits for its reply and its end.
fn service(client: &mut TcpStream, position: u8, request: u32) -> u32 {
    write_out(client, position, request);
    let reply = loop {
        let word = read_in(client, position);
        if word >> 31 == 1 {
            break word;
        }
    };
    write_out(client, position, 0);
    while read_in(client, position) >> 31 == 1 {}
    reply
}

#[test]
fn the_first_line_for_programs_says_where_it_listens_and_signals_end_it_with_0() {
    let folder = tempfile::tempdir().unwrap();
    for signal in ["-TERM", "-INT"] {
        let sim = Sim::start(folder.path(), &[]);
        let address = sim.listening["modbus"].as_str().unwrap();
        assert!(address.starts_with("127.0.0.1:"), "{address}");
        let first = sim.listening.to_string();
        assert_eq!(first, format!("{{\"event\":\"listening\",\"modbus\":\"{address}\"}}"));
        let last = sim.end(signal);
        assert_eq!(last["event"], "stopped");
        assert_eq!(last["faulty_cycles"], 0);
        assert_eq!(last["segment_faults"], serde_json::json!([0, 0, 0, 0]));
    }
}

#[test]
fn at_its_end_it_tells_what_the_modbus_server_has_seen() {
    let sim = Sim::start(Path::new("."), &[]);
    let mut client = sim.connect("modbus");
    read_in(&mut client, 0);
    assert_eq!(ask(&mut client, &[7]), [0x87, 1], "no function that is served");
    let [served, _] = sim.last_two("-TERM");
    assert_eq!(
        served,
        serde_json::json!({
            "event": "served", "requests": 2, "exceptions": 1,
            "closed": { "bad_frames": 0, "idle": 0, "too_many": 0 }, "accept_errors": 0,
        })
    );
}

#[test]
fn every_encoder_of_the_built_in_ring_moves() {
    let sim = Sim::start(Path::new("."), &["--speed", "100"]);
    let mut client = sim.connect("modbus");
    for position in 0..3 {
        let first = read_in(&mut client, position);
        while read_in(&mut client, position) == first {}
    }
    sim.end("-TERM");
}

#[test]
fn parameters_outlive_the_program_in_its_state_folder() {
    let folder = tempfile::tempdir().unwrap();
    let sim = Sim::start(folder.path(), &["--state", "memories"]);
    let mut client = sim.connect("modbus");
    assert_eq!(service(&mut client, 2, 0xC200_270F), 0xC200_270F);
    let message = refused(folder.path(), &["sim", "--modbus", "off", "--state", "memories"]);
    assert_eq!(message, "error: --state memories: another simulation uses this folder\n");
    sim.end("-TERM");

    let sim = Sim::start(folder.path(), &["--state", "memories"]);
    assert_eq!(service(&mut sim.connect("modbus"), 2, 0x8200_0000), 0x8200_270F);
    assert_eq!(service(&mut sim.connect("modbus"), 1, 0x8200_0000), 0x82FF_FFFF);
    sim.end("-TERM");

    // A folder with one file cut off is left as it is.
    let file = folder.path().join("memories/encoder-2.toml");
    fs::write(&file, &fs::read(&file).unwrap()[..700]).unwrap();
    let before: Vec<_> =
        (0..3).map(|k| fs::read(folder.path().join(format!("memories/encoder-{k}.toml")))).collect();
    let message = refused(folder.path(), &["sim", "--modbus", "off", "--state", "memories"]);
    assert!(
        message.starts_with("error: --state memories/encoder-2.toml: no whole state file: "),
        "{message}"
    );
    let after: Vec<_> =
        (0..3).map(|k| fs::read(folder.path().join(format!("memories/encoder-{k}.toml")))).collect();
    for (before, after) in before.into_iter().zip(after) {
        assert_eq!(before.unwrap(), after.unwrap());
    }
}

#[test]
fn the_same_run_gives_the_same_recording_and_it_replays() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["a.csv", "b.csv"] {
        let arguments = ["sim", "--modbus", "off", "--for", "2", "--speed", "max", "--record", file];
        let output = run(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(!folder.path().join(format!("{file}.partial")).exists());
    }
    let a = fs::read(folder.path().join("a.csv")).unwrap();
    assert!(a == fs::read(folder.path().join("b.csv")).unwrap());
    for position in ["0", "1", "2"] {
        let output = run(folder.path(), &["replay", "--at", position, "a.csv"]);
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "2955 rows, 0 differences\n");
    }
}

/// The last time of a value change dump, whose last line is whole.
fn last_time(text: &str) -> u64 {
    assert!(text.ends_with('\n'));
    text.lines().rfind(|line| line.starts_with('#')).unwrap()[1..].parse().unwrap()
}

#[test]
fn the_ending_of_a_recording_chooses_what_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let record = |file: &str, more: &[&str]| {
        let arguments = ["sim", "--modbus", "off", "--for", "50ms", "--speed", "max", "--record", file];
        let output = run(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(!folder.path().join(format!("{file}.partial")).exists());
        fs::read(folder.path().join(file)).unwrap()
    };
    let bits = String::from_utf8(record("bits.vcd", &["--lines", "--words"])).unwrap();
    assert!(bits.starts_with("$version encoring "), "{}", &bits[..80]);
    assert!(bits.contains("\n$timescale 100 ns $end\n"));
    for signal in ["wire 1 ( segment_0 $end", "wire 1 + segment_3 $end", "wire 32 : in [31:0] $end"] {
        assert!(bits.contains(&format!("$var {signal}\n")), "{signal}");
    }
    // 74 cycles of 677 us, the last of which ends with the telegram that began in it.
    // What is on its way then is drawn behind the devices that delay it.
    let end = last_time(&bits);
    assert!((500_980..=501_200).contains(&end), "{end}");
    assert_eq!(
        bits.as_bytes(),
        record("again.vcd", &["--lines", "--words"]),
        "the same run, the same recording"
    );

    let words = String::from_utf8(record("words.VCD", &["--words"])).unwrap();
    assert!(words.contains(" out_service $end\n") && words.contains(" parameter [15:0] $end\n"));
    assert!(!words.contains("segment_0"));
    assert_eq!(last_time(&words), 500_980);

    let levels = String::from_utf8(record("levels.vcd", &[])).unwrap();
    assert!(levels.contains(" encoder_2_ssi_clock $end\n") && !levels.contains(" parameter"));

    let packed = record("bits.fst", &["--lines"]);
    assert!(packed.len() < bits.len() / 10);
    assert_eq!(packed, record("again.fst", &["--lines"]));
    for other in ["ring.csv", "ring"] {
        assert!(record(other, &[]).starts_with(b"# encoring-trace 1\n"));
    }
    let said = refused(folder.path(), &["sim", "--modbus", "off", "--lines", "--record", "no.csv"]);
    assert_eq!(said, "error: --record no.csv: a trace has no lines; with --lines name a .vcd or .fst\n");
}

#[test]
fn a_signal_leaves_a_whole_waveform() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["ring.vcd", "ring.fst"] {
        let sim = Sim::start(folder.path(), &["--lines", "--words", "--record", file]);
        let partial = folder.path().join(format!("{file}.partial"));
        assert!(partial.exists() && !folder.path().join(file).exists());
        let mut client = sim.connect("modbus");
        assert_eq!(service(&mut client, 2, 0x8200_0000), 0x82FF_FFFF);
        let last = sim.end("-INT");
        assert!(!partial.exists());
        let found = fs::read(folder.path().join(file)).unwrap();
        if file.ends_with("vcd") {
            let text = String::from_utf8(found).unwrap();
            let (end, stopped) = (last_time(&text), last["time_ns"].as_u64().unwrap() / 100);
            assert!((stopped..stopped + 220).contains(&end), "{end}, stopped at {stopped}");
            // The service that came over Modbus.
            assert!(text.contains(&format!("\nb{:032b} L\n", 0x8200_0000_u32)));
        } else {
            // Kind of the first block, its length, no time at the beginning, and the end.
            let number = |at: usize| u64::from_be_bytes(found[at..at + 8].try_into().unwrap());
            assert_eq!((found[0], number(1), number(9)), (0, 329, 0));
            assert!(number(17) >= last["time_ns"].as_u64().unwrap() / 100);
        }
    }
}

#[test]
fn the_example_is_a_scenario() {
    let folder = tempfile::tempdir().unwrap();
    let example = run(folder.path(), &["sim", "--example"]);
    fs::write(folder.path().join("ring.toml"), &example.stdout).unwrap();
    let arguments = ["sim", "ring.toml", "--modbus", "off", "--for", "10ms", "--speed", "max"];
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("3 encoders on a simulated ring, a cycle every 677 us\n"), "{text}");
    assert!(
        text.ends_with("stopped after 10.155 ms on the ring: 15 cycles, 0 faulty, 0 dropped\n"),
        "{text}"
    );
}

#[test]
fn the_control_port_takes_an_encoder_off_the_ring() {
    let sim = Sim::start(Path::new("."), &["--control", "127.0.0.1:0"]);
    let mut control = sim.connect("control");
    let mut answers = BufReader::new(control.try_clone().unwrap());
    let mut say = |line: &str| {
        writeln!(control, "{line}").unwrap();
        let mut answer = String::new();
        answers.read_line(&mut answer).unwrap();
        serde_json::from_str::<serde_json::Value>(&answer).unwrap()
    };
    assert_eq!(say(r#"{"verb":"set","position":1,"set":{"supply_v":5.0}}"#)["ok"], true);
    let view = say(r#"{"verb":"view"}"#);
    assert_eq!(view["view"]["devices"][1]["on"], false);
    assert_eq!(view["view"]["devices"][0]["on"], true);
    assert_eq!(say(r#"{"verb":"set","position":9,"set":{"supply_v":5.0}}"#)["ok"], false);
    let last = sim.end("-TERM");
    assert!(last["faulty_cycles"].as_u64().unwrap() > 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_flood_of_peers_takes_few_threads() {
    let sim = Sim::start(Path::new("."), &["--control", "127.0.0.1:0"]);
    let status = format!("/proc/{}/status", sim.program.id());
    let threads = || -> usize {
        let status = fs::read_to_string(&status).unwrap();
        let threads = status.lines().find_map(|line| line.strip_prefix("Threads:"));
        threads.unwrap().trim().parse().unwrap()
    };
    let before = threads();
    let address = sim.listening["control"].as_str().unwrap();
    let most = std::thread::scope(|scope| {
        let peers: Vec<_> = (0..20)
            .map(|_| {
                scope.spawn(|| {
                    for _ in 0..50 {
                        let mut peer = TcpStream::connect(address).unwrap();
                        // Whoever is one too many may be closed before it has said anything.
                        let _ = peer.write_all("{\"verb\":\"view\"}\n".repeat(3).as_bytes());
                        let _ = peer.read(&mut [0]);
                    }
                })
            })
            .collect();
        let mut most = 0;
        while !peers.iter().all(std::thread::ScopedJoinHandle::is_finished) {
            most = most.max(threads());
        }
        most
    });
    assert!(most > before && most <= before + 4, "{before}, then {most}");
    sim.end("-TERM");
}

/// Reads holding registers.
fn holding(client: &mut TcpStream, first: u16, count: u8) -> Vec<u16> {
    let [high, low] = first.to_be_bytes();
    let answer = ask(client, &[3, high, low, 0, count]);
    assert_eq!(answer[..2], [3, 2 * count], "{answer:02X?}");
    answer[2..].chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
}

#[test]
fn a_fault_of_the_line_is_seen_in_the_diagnostic_registers_and_counted_while_the_ring_runs() {
    let sim = Sim::start(Path::new("."), &["--control", "127.0.0.1:0"]);
    let mut client = sim.connect("modbus");
    let mut control = sim.connect("control");
    assert_eq!(holding(&mut client, 900, 6), [0x00E0, 0, 0, 0, 0, 0]);
    writeln!(control, r#"{{"verb":"line","segment":2,"fault":"silent"}}"#).unwrap();
    // READY, DETECT, BUS and DC_RESULT; the interface of device 2.
    while holding(&mut client, 900, 2) != [0x1094, 0x0280] {}
    let faults = holding(&mut client, 902, 4);
    assert!(faults[2] >= 5 && [faults[0], faults[1], faults[3]] == [0; 3], "{faults:?}");
    writeln!(control, r#"{{"verb":"line","fault":"none"}}"#).unwrap();
    while holding(&mut client, 900, 2) != [0x00E0, 0] {}
    let faults = holding(&mut client, 902, 4);
    let last = sim.end("-TERM");
    assert_eq!(last["segment_faults"], serde_json::json!(faults));
    assert!(last["faulty_cycles"].as_u64().unwrap() > faults[2].into(), "a search is none of data");
}

#[test]
fn in_the_inline_layout_our_own_commands_find_the_ring_as_behind_a_coupler() {
    // A write leaves its backup there.
    let folder = tempfile::tempdir().unwrap();
    let sim = Sim::start(folder.path(), &["--layout", "inline", "--word-order", "low-first"]);
    let mut client = sim.connect("modbus");
    assert_eq!(holding(&mut client, 1400, 4), [3, 0x0233, 0x0233, 0x0233]);
    assert_eq!(ask(&mut client, &[23, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 0]), [0x97, 1]);
    let bus =
        format!("modbus-tcp://{}?layout=inline&order=low-first", sim.listening["modbus"].as_str().unwrap());
    let write =
        ["write", "measuring-length", "9999", "--bus", &bus, "--at", "2", "--model", "ce-65-m", "--yes"];
    let output = run(folder.path(), &[&write[..], &["--format", "json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let read =
        ["read", "measuring-length", "--bus", &bus, "--at", "2", "--model", "ce-65-m", "--format", "json"];
    let output = run(folder.path(), &read);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["parameters"][0]["value"], 9999, "{told}");
    sim.end("-TERM");

    let arguments =
        ["sim", "--layout", "inline", "--modbus", "127.0.0.1:0", "--for", "10ms", "--speed", "max"];
    let told = String::from_utf8(run(folder.path(), &arguments).stdout).unwrap();
    let lines: Vec<&str> = told.lines().skip(1).take(3).collect();
    assert!(
        lines[0].starts_with("position  device  model     OUT holding  IN holding  position now"),
        "{told}"
    );
    assert!(lines[1].starts_with("       0  1.0     la-66     8006, 8007   8000, 8001  "), "{told}");
    assert!(lines[2].starts_with("       1  2.0     ce-100-m  8008, 8009   8002, 8003  "), "{told}");
    assert!(refused(folder.path(), &["sim", "--layout", "flat"]).contains("it must be plain or inline"));
}

#[test]
fn what_cannot_be_done_is_said_in_one_line_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sim = Sim::start(here, &[]);
    let taken = sim.listening["modbus"].as_str().unwrap().to_owned();
    fs::write(
        here.join("twice.toml"),
        "version = 1\n[[device]]\nposition = 0\nmodel = \"la-66\"\nlength = 5\n",
    )
    .unwrap();
    let common = ["--state", "new", "--record", "new.csv"];
    for (arguments, message) in [
        (
            vec!["--modbus", &taken],
            format!("error: --modbus {taken}: the port is in use; choose another, or 0 for any\n"),
        ),
        (
            vec!["--modbus", "nowhere"],
            "error: --modbus nowhere: no address; write HOST:PORT, PORT or off\n".to_owned(),
        ),
        (
            vec!["twice.toml"],
            "error: twice.toml line 5: unknown field `length`, expected one of `position`, `model`, `rod_mm`, \
             `native`, `firmware`, `service_times`, `zero_loss`, `stale_service`, `motion`, `ssi`\n"
                .to_owned(),
        ),
    ] {
        let arguments = [&["sim"][..], &common, &arguments].concat();
        assert_eq!(refused(here, &arguments), message);
        assert!(!here.join("new").exists() && !here.join("new.csv.partial").exists());
    }
    fs::create_dir(here.join("folder")).unwrap();
    for (arguments, message) in [
        (&["--record", "folder"][..], "error: --record folder: not an ordinary file; name a new one\n"),
        (
            &["--record", "none/new.csv"],
            "error: --record none/new.csv: there is no folder none; make it first\n",
        ),
        (
            &["--record", "none/new.vcd"],
            "error: --record none/new.vcd: there is no folder none; make it first\n",
        ),
        (&["--record", "twice.toml", "twice.toml"], "error: twice.toml line 5: unknown field"),
    ] {
        let said = refused(here, &[&["sim", "--modbus", "off", "--state", "new"][..], arguments].concat());
        assert!(said.starts_with(message), "{said}");
        assert!(!here.join("new").exists() && !here.join("folder.partial").exists());
    }
    let example = run(here, &["sim", "--example"]).stdout;
    fs::write(here.join("ring.toml"), &example).unwrap();
    let arguments = ["sim", "ring.toml", "--modbus", "off", "--state", "new", "--record", "ring.toml"];
    assert_eq!(refused(here, &arguments), "error: --record ring.toml: this is the scenario\n");
    assert!(!here.join("new").exists() && fs::read(here.join("ring.toml")).unwrap() == example);
    for wrong in [["--speed", "0"], ["--for", "0"], ["--modbus-connections", "0"]] {
        assert!(refused(here, &[&["sim"][..], &wrong].concat()).starts_with("error: invalid value '"));
    }
    for (web, problem) in [
        ("on", "--web on: no address; write HOST:PORT, PORT or off".to_owned()),
        (taken.as_str(), format!("--web {taken}: the port is in use; choose another, or 0 for any")),
        (
            "0.0.0.0:0",
            "--web: others reach 0.0.0.0, so the page must ask for a token; name its file with --web-token-file FILE, \
             or name 127.0.0.1"
                .to_owned(),
        ),
    ] {
        let said = refused(here, &["sim", "--modbus", "off", "--web", web]);
        assert_eq!(said, format!("error: {problem}\n"));
    }
    sim.end("-TERM");
}

#[test]
fn the_page_is_named_in_the_first_line_and_left_out_where_a_ring_runs_as_fast_as_it_can() {
    let folder = tempfile::tempdir().unwrap();
    let sim = Sim::start(folder.path(), &["--web", "127.0.0.1:0", "--web-host", "Bench.Example"]);
    let own = sim.listening["web"].as_str().unwrap();
    for (host, status) in [(own, "200 OK"), ("bench.example", "200 OK"), ("other.example", "421")] {
        let mut page = sim.connect("web");
        write!(page, "GET /healthz HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        page.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{host}: {answer}");
    }
    sim.end("-TERM");
    let sim = Sim::start(folder.path(), &["--speed", "max"]);
    assert_eq!(sim.listening.get("web"), None);
    sim.end("-TERM");
}

#[test]
fn what_happens_on_the_ring_is_told_while_it_runs() {
    let folder = tempfile::tempdir().unwrap();
    let text = "version = 1\n[[device]]\nposition = 0\nmodel = \"ce-100-m\"\n\
                [[event]]\nat_s = 0.005\nposition = 0\nset = { supply_v = 0 }\n\
                [[event]]\nat_s = 0.006\nposition = 0\nset = { supply_v = 24 }\n\
                [[event]]\nat_s = 0.01\nsegment = 0\nline = \"bad\"\n";
    fs::write(folder.path().join("ring.toml"), text).unwrap();
    let arguments = ["sim", "ring.toml", "--modbus", "off", "--for", "20ms", "--speed", "max"];
    let output = run(folder.path(), &arguments);
    let told = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = told.lines().skip(3).collect();
    assert_eq!(
        lines,
        [
            "5.093 ms: the ring is silent from segment 0 on",
            "6.482 ms: bad check words on segment 0",
            "7.408 ms: the ring is whole again",
            "10.186 ms: bad check words on segment 0",
            "12.501 ms: the bus is stopped, the master looks for the fault",
            "12.964 ms: the master found: telegrams are bad on segment 0, behind the master (parameter 0100)",
            "stopped after 20.372 ms on the ring: 44 cycles, 28 faulty, 0 dropped",
            "faulty cycles on segment 0: 7",
        ]
    );
}

/// The lines of a run of the built-in ring, without its table.
fn told(arguments: &str) -> Vec<String> {
    let common = ["sim", "--modbus", "off", "--speed", "max"];
    let arguments: Vec<&str> = common.into_iter().chain(arguments.split(' ')).collect();
    let output = run(Path::new("."), &arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap().lines().skip(5).map(ToOwned::to_owned).collect()
}

#[test]
fn a_broken_cable_is_searched_and_its_place_told() {
    assert_eq!(
        told("--for 400ms --fault silent:2@100ms+200ms"),
        [
            "100.196 ms: bad check words on segment 2",
            "102.904 ms: the bus is stopped, the master looks for the fault",
            "132.692 ms: the master found: the ring ends behind device 2.0: nobody answers on segment 2 \
             (parameter 0280)",
            "310.743 ms: the ring is whole again",
            "stopped after 400.107 ms on the ring: 591 cycles, 311 faulty, 0 dropped",
            "faulty cycles on segment 2: 1",
        ]
    );
}

#[test]
fn a_search_is_told_to_programs_too() {
    let common = ["sim", "--modbus", "off", "--speed", "max", "--format", "json"];
    let arguments = [&common[..], &["--for", "300ms", "--fault", "jumper:0@50ms"]].concat();
    let output = run(Path::new("."), &arguments);
    let lines: Vec<serde_json::Value> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let began = lines.iter().position(|line| line["event"] == "search_began").unwrap();
    let found = &lines[began + 1];
    assert_eq!((found["event"].as_str(), found["fault"].as_str()), (Some("search_found"), Some("break")));
    assert_eq!((found["segment"].as_u64(), found["parameter_hex"].as_str()), (Some(1), Some("0180")));
    assert_eq!(lines.last().unwrap()["event"], "stopped");
}

#[test]
fn faults_of_devices_end_with_their_time() {
    assert_eq!(
        told("--for 120ms --fault chip:1@10ms+10ms --fault bad:0@90ms+1ms"),
        [
            "10.832 ms: the ring is silent from segment 1 on",
            "13.54 ms: the bus is stopped, the master looks for the fault",
            "42.651 ms: the ring is whole again",
            "90.041 ms: bad check words on segment 0",
            "92.072 ms: the ring is whole again",
            "stopped after 120.506 ms on the ring: 178 cycles, 50 faulty, 0 dropped",
            "faulty cycles on segment 0: 3",
        ]
    );
}

#[test]
fn a_fault_that_cannot_be_is_refused_with_what_is_allowed() {
    for (faults, message) in [
        (&["bad:4"][..], "--fault bad:4: segment 4; the segments are 0 to 3"),
        (&["supply:3"], "--fault supply:3: position 3; the positions are 0 to 2"),
        (
            &["bad:1", "silent:2@1"],
            "--fault silent:2@1: segment 1 is troubled at that time; a ring has one such at a time",
        ),
    ] {
        let faults = faults.iter().flat_map(|fault| ["--fault", fault]);
        let arguments: Vec<&str> = ["sim", "--modbus", "off"].into_iter().chain(faults).collect();
        assert_eq!(refused(Path::new("."), &arguments), format!("error: {message}\n"));
    }
    for level in ["word", "bit"] {
        let said = refused(Path::new("."), &["sim", "--level", level]);
        assert!(said.contains("there is one kind of ring now"), "{said}");
    }
    let said = refused(Path::new("."), &["sim", "--fault", "cut:1"]);
    assert!(
        said.starts_with("error: invalid value 'cut:1' for '--fault <FAULT>': kind \"cut\"; the kinds"),
        "{said}"
    );
}

#[test]
fn counters_are_told_while_it_runs() {
    let sim = Sim::start(Path::new("."), &["--speed", "100", "--counters", "1s"]);
    let mut lines = sim.lines;
    let mut line = String::new();
    lines.read_line(&mut line).unwrap();
    let told: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!((told["event"].as_str(), told["faulty_cycles"].as_u64()), (Some("counters"), Some(0)));
    assert!(told["cycles"].as_u64().unwrap() >= 1_000, "{told}");
    let mut program = sim.program;
    program.kill().unwrap();
    program.wait().unwrap();
}
