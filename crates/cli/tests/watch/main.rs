//! `encoring watch` and `encoring log` as their users run them.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    missing_docs,
    reason = "a test may panic"
)]

mod causes;
mod log;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output, Stdio};

use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(PROGRAM).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// What a refused call says; it prints nothing else.
fn refused(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stdout), "", "{arguments:?}");
    text(&output.stderr)
}

/// A program in the background that prints lines.
struct Running {
    program: Child,
    lines: BufReader<ChildStdout>,
}

impl Running {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut program =
            Command::new(PROGRAM).current_dir(folder).args(arguments).stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(program.stdout.take().unwrap());
        Self { program, lines }
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        assert!(self.lines.read_line(&mut line).unwrap() > 0, "it has ended");
        line
    }

    fn json(&mut self) -> Value {
        serde_json::from_str(&self.line()).unwrap()
    }

    /// Reads lines until one is as wanted.
    fn until(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        loop {
            let line = self.json();
            if wanted(&line) {
                return line;
            }
        }
    }

    /// Ends it as `signal` would, and gives what it still prints.
    fn end(mut self, signal: &str) -> String {
        let pid = self.program.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        let mut rest = String::new();
        self.lines.read_to_string(&mut rest).unwrap();
        assert_eq!(self.program.wait().unwrap().code(), Some(0));
        rest
    }
}

/// A simulation behind Modbus, and its bus address.
fn gateway(folder: &Path) -> (Running, String) {
    let mut sim =
        Running::start(folder, &["sim", "--format", "json", "--web", "off", "--modbus", "127.0.0.1:0"]);
    let port = sim.json()["modbus"].as_str().unwrap().to_owned();
    (sim, format!("modbus-tcp://{port}"))
}

fn write_out(address: &str, position: u8, word: u32) {
    let mut client = TcpStream::connect(address.strip_prefix("modbus-tcp://").unwrap()).unwrap();
    let pdu = [&[16, 0, 2 * position, 0, 2, 4][..], &word.to_be_bytes()].concat();
    client.write_all(&[&[0, 1, 0, 0, 0, 11, 1][..], &pdu].concat()).unwrap();
    let mut answer = [0; 12];
    client.read_exact(&mut answer).unwrap();
    assert_eq!(answer[7], 16);
}

/// A ring on which nothing moves.
const STILL: &str = "version = 1\n[[device]]\nposition = 0\nmodel = \"la-66\"\nrod_mm = 500\n\
                     motion = { kind = \"hold\", raw = 125000 }\n";

/// The whole lines of a log behind its head and the columns, without the times. A line that is being written is left
/// out.
fn rows(file: &Path) -> Vec<String> {
    let lines = fs::read_to_string(file).unwrap();
    let whole = lines.rsplit_once('\n').map_or("", |(whole, _)| whole);
    let rows = whole.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|row| row.split_once(',').unwrap().1.to_owned()).collect()
}

#[test]
fn without_a_terminal_there_is_a_line_for_each_encoder_at_first_and_then_for_changes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ring.toml"), STILL).unwrap();
    let output =
        run(folder.path(), &["watch", "--bus", "sim:ring.toml", "--for", "300ms", "--every", "50ms"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let out = text(&output.stdout);
    let lines: Vec<_> = out.lines().collect();
    assert_eq!(lines[0], "sim:ring.toml, a simulation, judged every 10 ms, shown every 50 ms");
    assert!(
        lines[2].ends_with("   0  la-66           12500  valid              00000000  000030D4  normal"),
        "{out}"
    );
    assert!(lines[3].contains(" polls in ") && lines.len() == 4, "{out}");
}

#[test]
fn a_program_gets_a_stream_of_objects() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ring.toml"), STILL).unwrap();
    let arguments = ["watch", "--bus", "sim:ring.toml", "--for", "100ms", "--format", "json"];
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let out = text(&output.stdout);
    let lines: Vec<_> = out.lines().collect();
    insta::assert_snapshot!("json_first", lines[0]);
    // When the first poll is made depends on the machine.
    let (before, rest) = lines[1].split_once("\"time_ns\":").unwrap();
    let rest = rest.split_once(',').unwrap().1;
    insta::assert_snapshot!("json_seen", format!("{before}\"time_ns\":...,{rest}"));
    let last: Value = serde_json::from_str(lines.last().unwrap()).unwrap();
    assert_eq!(last["event"], "ended");
    assert!((1..=11).contains(&last["polls"].as_u64().unwrap()), "{last}");
    assert_eq!(lines.len(), 3, "it stands, so it is told once: {out}");
}

#[test]
fn behind_a_gateway_services_errors_and_the_end_of_the_link_are_seen_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let models = "la-66,ce-100-m,ce-65-m";
    let arguments = [
        "watch",
        "--bus",
        &address,
        "--at",
        "0-2",
        "--model",
        models,
        "--every",
        "20ms",
        "--stale-after",
        "1m",
    ];
    let mut watch = Running::start(folder.path(), &[&arguments[..], &["--format", "json"]].concat());
    let first = watch.until(|line| line["event"] == "seen");
    assert_eq!((&first["verdict"], &first["lamps"]), (&Value::from("unchecked"), &Value::Null));
    assert_eq!(first["cannot_judge"], serde_json::json!(["range", "motion"]));

    write_out(&address, 1, 0xCF00_0000);
    let reply = watch.until(|line| line["position"] == 1 && line["phase"] == "acknowledged");
    assert_eq!((&reply["out"], &reply["in"]), (&Value::from("CF000000"), &Value::from("EF000000")));
    assert_eq!(reply["verdict"], "faulty");
    write_out(&address, 1, 0);
    let pending = watch.until(|line| line["position"] == 1 && line["phase"] == "normal");
    assert_eq!((&pending["verdict"], &pending["value"]), (&Value::from("faulty"), &Value::Null));
    write_out(&address, 1, 0x8800_0000);
    let check = watch.until(|line| line["position"] == 1 && line["in"] == "88000080");
    assert_eq!(
        (&check["verdict"], &check["phase"]),
        (&Value::from("in_service"), &Value::from("acknowledged"))
    );
    write_out(&address, 1, 0);
    watch.until(|line| line["position"] == 1 && line["verdict"] == "unchecked");

    sim.end("-TERM");
    let lost = watch.until(|line| line["position"] == 0 && line["in"].is_null());
    assert!(lost["verdict"].as_str().unwrap().starts_with("no_answer_"), "{lost}");
    assert!(lost["value"].is_null() && !lost["text"].as_array().unwrap().is_empty());
    let last = watch.end("-INT");
    assert!(last.lines().last().unwrap().starts_with(r#"{"event":"ended""#), "{last}");
}

// [R143]
#[test]
fn an_error_that_nobody_asks_about_is_told_by_a_watch_and_stands_in_a_log() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let at = ["--bus", &address, "--at", "1", "--model", "ce-100-m", "--stale-after", "1m"];
    let mut watch = Running::start(folder.path(), &[&["watch", "--format", "json"][..], &at].concat());
    // The encoder has no service 0F.
    write_out(&address, 1, 0xCF00_0000);
    watch.until(|line| line["phase"] == "acknowledged");
    write_out(&address, 1, 0);
    let found = watch.until(|line| line["event"] == "finding");
    let said = found["text"].as_str().unwrap();
    assert!(said.starts_with("error_ignored (error, suspected), OUT 00000000: "), "{found}");
    assert!(said.ends_with(" [R143]") && found["position"] == 1, "{found}");
    watch.end("-INT");

    let mut log = Running::start(folder.path(), &[&["log", "/dev/stdout"][..], &at].concat());
    let line = loop {
        let line = log.line();
        if line.starts_with("# event finding: ") {
            break line;
        }
    };
    assert!(line.contains(" position 1: error_ignored (error, suspected), OUT "), "{line}");
    log.end("-INT");
    sim.end("-TERM");
}

// [R38]
#[test]
fn a_service_bit_that_is_left_standing_is_told_when_a_watch_or_a_log_ends() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    write_out(&address, 1, 0x0200_0000);
    write_out(&address, 1, 0x8200_0000);
    let at = ["--bus", &address, "--at", "1", "--model", "ce-100-m", "--stale-after", "1m", "--for", "3s"];
    let watch: &[&str] = &["watch", "--poll", "100ms", "--format", "json"];
    let log: &[&str] = &["log", "--every", "100ms", "/dev/stdout"];
    for (command, begins) in [(watch, r#"{"event":"finding""#), (log, "# event finding: ")] {
        // Across a pause of a loaded machine nothing is judged.
        let told = (0..20).find_map(|_| {
            let output = run(folder.path(), &[command, &at].concat());
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let lines = text(&output.stdout);
            lines.lines().find(|line| line.starts_with(begins)).map(str::to_owned)
        });
        let told = told.unwrap();
        assert!(told.contains("never_dropped (error, suspected), OUT 82000000"), "{told}");
    }
    sim.end("-TERM");
}

#[test]
fn parameters_come_from_files_behind_a_gateway() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let file = "version = 1\nmodel = \"ce-65-m\"\nnative = 4096\n[parameters]\ncounting_direction = 0\n\
                measuring_length = 16777215\nnumerator = 4096\ndenominator = 1\n";
    fs::write(folder.path().join("axis.toml"), file).unwrap();
    let common =
        ["watch", "--bus", &address, "--for", "100ms", "--format", "json", "--stale-after", "1m", "--at"];
    let found = |arguments: &[&str]| {
        let output = run(folder.path(), &[&common[..], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let lines = text(&output.stdout);
        let seen = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        let seen: Vec<_> = seen.filter(|line| line["event"] == "seen").collect();
        (seen[0]["model"].clone(), seen.last().unwrap()["verdict"].clone())
    };
    assert_eq!(found(&["2", "--parameters", "axis.toml"]), ("ce-65-m".into(), "valid".into()));
    let two = ["1-2", "--model", "ce-100-m,ce-65-m", "--parameters", "2=axis.toml"];
    assert_eq!(found(&two), ("ce-100-m".into(), "valid".into()));

    for (arguments, message) in [
        (
            &["1-2", "--parameters", "axis.toml"][..],
            "--parameters axis.toml: 1 files for 2 encoders; give one",
        ),
        (&["2", "--parameters", "3=axis.toml"], "--parameters 3=axis.toml: position 3 is not in --at"),
        (&["2", "--parameters", "none.toml"], "none.toml: "),
        (
            &["2", "--model", "ce-100-m", "--parameters", "axis.toml"],
            "axis.toml: the file is not for the ce-100-m",
        ),
        (&["2"], "--model MODEL is missing"),
        (&["0-2", "--model", "la-66,la-66"], "--model: 2 values for 3 encoders"),
        (
            &["1", "--model", "ce-100-m", "--native", "8192"],
            "--native: 8192 steps per turn; a ce-100-m has 4096",
        ),
    ] {
        let said = refused(folder.path(), 2, &[&common[..], arguments].concat());
        assert!(said.starts_with(&format!("error: {message}")), "{said}");
    }
    let said = refused(folder.path(), 2, &["watch", "--bus", &address, "--model", "la-66"]);
    assert!(said.starts_with("error: --at POSITIONS is missing"), "{said}");
    let said = refused(folder.path(), 2, &["watch", "--bus", "sim", "--parameters", "axis.toml"]);
    assert!(said.starts_with("error: --parameters: a simulated ring knows the parameters"), "{said}");
    let said = refused(folder.path(), 2, &["watch", "--bus", "sim", "--at", "3"]);
    assert!(said.starts_with("error: --at 3: no encoder at position 3"), "{said}");
    let arguments = ["log", "a.csv", "--bus", &address, "--at", "0", "--model", "la-66", "--speed", "2"];
    assert!(
        refused(folder.path(), 2, &arguments).starts_with("error: --speed works on a simulated ring only")
    );
    assert!(!folder.path().join("a.csv").exists());
    sim.end("-TERM");
}

#[test]
fn a_gateway_that_never_answers_ends_with_3() {
    let folder = tempfile::tempdir().unwrap();
    // Nothing listens at the near end of a connection, and nobody else can take its port.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let held = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    let address = format!("modbus-tcp://{}", held.local_addr().unwrap());
    let common = ["--bus", &address, "--at", "0", "--model", "la-66", "--for", "50ms"];
    let watch = run(folder.path(), &[&["watch"][..], &common].concat());
    assert_eq!(watch.status.code(), Some(3));
    assert!(text(&watch.stdout).contains("no_answer_no_connection"), "{}", text(&watch.stdout));
    let log = run(folder.path(), &[&["log", "a.csv"][..], &common].concat());
    assert_eq!(log.status.code(), Some(3));
    assert!(rows(&folder.path().join("a.csv")).contains(&"0,,,no_answer_no_connection,".to_owned()));
    // Begun again and again it costs nothing that is there.
    let before = fs::read(folder.path().join("a.csv")).unwrap();
    for _ in 0..3 {
        let log = run(folder.path(), &[&["log", "a.csv", "--keep", "1"][..], &common].concat());
        assert_eq!(log.status.code(), Some(3));
        let told = text(&log.stderr);
        assert!(told.contains("a.csv holds now is deleted when the next file takes its turn"), "{told}");
    }
    assert_eq!(fs::read(folder.path().join("a.csv")).unwrap(), before);
    assert!(!folder.path().join("a.1.csv").exists());
    fs::write(folder.path().join("a.1.csv"), "# encoring-log 1\n").unwrap();
    let log = run(folder.path(), &[&["log", "a.csv", "--keep", "1"][..], &common].concat());
    let told = text(&log.stderr);
    assert!(
        told.starts_with("note: --keep 1: ") && told.contains("a.1.csv holds now is deleted when"),
        "{told}"
    );
}

/// Asks the control port for something.
fn control(address: &str, verb: &str) {
    let mut client = TcpStream::connect(address).unwrap();
    client.write_all(format!("{verb}\n").as_bytes()).unwrap();
    let mut answer = String::new();
    BufReader::new(client).read_line(&mut answer).unwrap();
    assert!(answer.contains("\"ok\":true"), "{answer}");
}

#[test]
fn a_stopped_ring_is_seen_over_modbus_with_device_and_segment_and_a_log_holds_its_history() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["sim", "--format", "json", "--web", "off", "--modbus", "127.0.0.1:0", "--control", "127.0.0.1:0"];
    let mut sim = Running::start(folder.path(), &arguments);
    let listening = sim.json();
    let port = listening["modbus"].as_str().unwrap().to_owned();
    let door = listening["control"].as_str().unwrap().to_owned();
    let address = format!("modbus-tcp://{port}?status=holding:900&parameter=holding:901");
    let at = ["--bus", &address, "--at", "0-2", "--model", "la-66,ce-100-m,ce-65-m", "--stale-after", "1m"];
    let mut watch = Running::start(folder.path(), &[&["watch", "--format", "json"][..], &at].concat());
    let log = Running::start(folder.path(), &[&["log", "a.csv"][..], &at].concat());
    watch.until(|line| line["event"] == "seen" && line["verdict"] == "unchecked");

    control(&door, r#"{"verb":"line","segment":1,"fault":"silent"}"#);
    let found = watch.until(|line| line["diagnosis"]["segment"] == 1);
    assert_eq!(found["diagnosis"]["device_number"], "1.0", "{found}");
    assert!(found["text"].as_str().unwrap().starts_with("the ring stands still: "), "{found}");
    assert!(found["date"].as_str().unwrap().ends_with('Z'), "{found}");
    let stopped = watch.until(|line| line["position"] == 2 && line["verdict"] == "ring_stopped");
    assert!(stopped["value"].is_null(), "{stopped}");

    control(&door, r#"{"verb":"line","fault":"none"}"#);
    watch.until(|line| line["event"] == "ring_runs");
    watch.until(|line| line["position"] == 2 && line["verdict"] == "unchecked");
    watch.end("-INT");
    log.end("-INT");
    let file = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(file.contains("\ntime_us,position,out,in,verdict,value,status,parameter\n"), "{file}");
    assert!(file.contains("# event ring_stopped: ") && file.contains("# event ring_runs: "), "{file}");
    let rows = rows(&folder.path().join("a.csv"));
    assert!(rows.iter().any(|row| row.contains(",ring_stopped,,0x1094,0x0180")), "{file}");

    let fault = ["--exit-on-fault", "--for", "1m"];
    control(&door, r#"{"verb":"line","segment":1,"fault":"silent"}"#);
    let output = run(folder.path(), &[&["watch"][..], &at, &fault].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("\nended by a fault: position 0 is ring_stopped at "));
    let output = run(folder.path(), &[&["log", "b.csv"][..], &at, &fault].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    sim.end("-TERM");
    let output = run(folder.path(), &[&["watch"][..], &at, &["--exit-on-fault", "--for", "100ms"]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stdout));
}

#[test]
fn a_signal_ends_a_watch_whose_output_nobody_reads() {
    let (reader, mut filler) = std::io::pipe().unwrap();
    let mut program = Command::new(PROGRAM)
        .args(["watch", "--bus", "sim", "--every", "10ms", "--format", "json"])
        .stdout(filler.try_clone().unwrap())
        .spawn()
        .unwrap();
    let mut lines = BufReader::with_capacity(1, reader);
    lines.read_line(&mut String::new()).unwrap();
    let (half, is_half) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        for chunk in 0.. {
            // From here on it takes less time than a signal.
            if filler.write_all(&[b'\n'; 4096]).is_err() || chunk == 7 && half.send(()).is_err() {
                break;
            }
        }
    });
    is_half.recv().unwrap();
    let pid = program.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    assert_eq!(program.wait().unwrap().code(), Some(0));
    drop(lines);
}

#[test]
fn of_a_gateway_that_does_not_tell_whether_the_ring_runs_it_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let untold = |text: &str| text.matches("this gateway does not tell whether the ring runs").count();
    let at = ["--bus", &address, "--at", "0-1", "--model", "la-66,ce-100-m", "--for", "300ms"];
    for format in ["text", "json"] {
        let watch = run(folder.path(), &[&["watch", "--format", format][..], &at].concat());
        assert_eq!(untold(&text(&watch.stdout)), 1, "{}", text(&watch.stdout));
    }
    let log = run(folder.path(), &[&["log", "a.csv"][..], &at].concat());
    assert_eq!(untold(&text(&log.stderr)), 1, "{}", text(&log.stderr));
    assert_eq!(untold(&fs::read_to_string(folder.path().join("a.csv")).unwrap()), 1);
    sim.end("-TERM");
}

#[test]
fn a_diagnosis_that_the_gateway_refuses_is_told_once_and_is_no_fault_of_an_encoder() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let address = format!("{address}?status=holding:5000");
    let at = ["--bus", &address, "--at", "0", "--model", "la-66", "--for", "500ms", "--exit-on-fault"];
    let output =
        run(folder.path(), &[&["watch", "--format", "json", "--stale-after", "1m"][..], &at].concat());
    assert_eq!(output.status.code(), Some(3), "whether the ring ran is not known");
    let lines: Vec<Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |event: &str| lines.iter().filter(|line| line["event"] == event).collect::<Vec<_>>();
    let unread = of("diagnosis_unread");
    assert_eq!(unread.len(), 1, "{lines:#?}");
    assert!(unread[0]["position"].is_null(), "{}", unread[0]);
    let said = unread[0]["text"].as_str().unwrap();
    assert!(said.starts_with("what the ring's master says was not read: "), "{said}");
    assert!(of("seen").iter().all(|seen| seen["verdict"] == "unchecked"), "{lines:#?}");
    assert!(of("seen")[0]["cannot_judge"].as_array().unwrap().contains(&Value::from("ring")));
    assert!(lines.last().unwrap()["fault"].is_null());
    sim.end("-TERM");
}

#[test]
fn words_that_a_gateway_turns_round_are_told_once_with_what_cures_it() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["sim", "--format", "json", "--web", "off", "--modbus", "127.0.0.1:0", "--gateway-fault", "swapped"];
    fs::write(folder.path().join("ring.toml"), STILL).unwrap();
    let mut sim = Running::start(folder.path(), &[&arguments[..], &["ring.toml"]].concat());
    let address = format!("modbus-tcp://{}", sim.json()["modbus"].as_str().unwrap());
    let at = ["--bus", &address, "--at", "0", "--model", "la-66", "--for", "300ms"];
    let watch = run(folder.path(), &[&["watch", "--format", "json"][..], &at].concat());
    let lines = text(&watch.stdout);
    let told: Vec<_> = lines.lines().filter(|line| line.contains(r#""event":"misread""#)).collect();
    assert_eq!(told.len(), 1, "{lines}");
    assert!(
        told[0].contains("its halves exchanged") && told[0].contains("order=low-first in the address"),
        "{}",
        told[0]
    );
    let log = run(folder.path(), &[&["log", "a.csv"][..], &at].concat());
    let file = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert_eq!(file.matches("# event misread: ").count(), 1, "{file}");
    assert!(text(&log.stderr).contains("`encoring probe`"), "{}", text(&log.stderr));
    sim.end("-TERM");
}
