//! What was acknowledged or recorded is kept, whatever ends a simulation.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::{PROGRAM, Sim, read_in, refused, run, service};

#[test]
fn output_that_nobody_reads_holds_up_nothing() {
    let (reader, mut filler) = std::io::pipe().unwrap();
    let mut program = Command::new(PROGRAM)
        .args([
            "sim",
            "--format",
            "json",
            "--web",
            "off",
            "--modbus",
            "127.0.0.1:0",
            "--control",
            "127.0.0.1:0",
        ])
        .stdout(filler.try_clone().unwrap())
        .spawn()
        .unwrap();
    let mut lines = BufReader::with_capacity(1, reader);
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    let listening: serde_json::Value = serde_json::from_str(&first).unwrap();
    let connect = |name: &str| TcpStream::connect(listening[name].as_str().unwrap()).unwrap();
    // From here on the pipe is full, and more waits behind it.
    std::thread::spawn(move || filler.write_all(&[b'\n'; 1 << 20]));
    let (mut client, mut control) = (connect("modbus"), connect("control"));
    let mut answers = BufReader::new(control.try_clone().unwrap());
    for k in 0..40 {
        let volts = if k % 2 == 0 { 0 } else { 24 };
        writeln!(control, r#"{{"verb":"set","position":1,"set":{{"supply_v":{volts}}}}}"#).unwrap();
        let mut answer = String::new();
        answers.read_line(&mut answer).unwrap();
        assert!(answer.contains("\"ok\":true"), "{answer}");
        if volts > 0 {
            // Two cycles and more, until the ring is whole and the shaft moves.
            let place = read_in(&mut client, 0);
            while read_in(&mut client, 0) == place {}
        }
    }
    let pid = program.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    assert_eq!(program.wait().unwrap().code(), Some(0));
    drop(lines);
}

#[test]
fn a_reader_that_leaves_ends_the_simulation_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--state", "memories", "--record", "ring.csv", "--counters", "0.1"];
    let sim = Sim::start(folder.path(), &arguments);
    assert_eq!(service(&mut sim.connect("modbus"), 2, 0xC200_270F), 0xC200_270F);
    let mut program = sim.program;
    drop(sim.lines);
    assert_eq!(program.wait().unwrap().code(), Some(0));
    assert!(!folder.path().join("ring.csv.partial").exists());
    let replayed = run(folder.path(), &["replay", "--at", "2", "ring.csv"]);
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    let sim = Sim::start(folder.path(), &["--state", "memories"]);
    assert_eq!(service(&mut sim.connect("modbus"), 2, 0x8200_0000), 0x8200_270F);
    sim.end("-TERM");
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_ends_the_simulation_in_order_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let arguments = ["sim", "--modbus", "off", "--web", "off", "--state", "memories", "--record", "ring.csv"];
    let output =
        Command::new(PROGRAM).current_dir(folder.path()).args(arguments).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.starts_with("error: cannot write the output: "), "{said}");
    assert!(
        folder.path().join("ring.csv").exists() && folder.path().join("memories/encoder-2.toml").exists()
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_state_folder_that_cannot_be_written_can_be_read_and_is_refused_to_whatever_changes_an_encoder() {
    let read = run(Path::new("."), &["read", "--bus", "sim", "--at", "0", "--state", "/sys"]);
    assert_eq!(read.status.code(), Some(0), "{read:?}");
    let said = String::from_utf8(read.stderr).unwrap();
    assert!(said.starts_with("note: --state /sys cannot be written: it is read without a lock"), "{said}");
    for changing in [
        &["write", "measuring-length", "9999", "--bus", "sim", "--at", "2", "--yes"][..],
        &["sim", "--modbus", "off", "--for", "1ms"],
    ] {
        let said = refused(Path::new("."), &[changing, &["--state", "/sys"]].concat());
        let refusal = "error: --state /sys: what changes cannot be kept there; nothing was done\n";
        assert!(said.ends_with(refusal), "{said}");
    }
}

/// A short recording, and what it says; the exit code is the first.
fn record(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let common = ["sim", "--modbus", "off", "--for", "20ms", "--speed", "max"];
    let output = run(folder, &[&common, arguments].concat());
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_recording_never_costs_a_file_that_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("a.csv"), "precious").unwrap();
    let (code, said) = record(here, &["--record", "a.csv", "--state", "memories"]);
    let refusal = "error: --record a.csv: it is there already; name a new one, or give --overwrite\n";
    assert_eq!((code, said.as_str()), (Some(2), refusal));
    assert!(!here.join("memories").exists() && fs::read(here.join("a.csv")).unwrap() == b"precious");

    // Only when the new one is whole.
    let sim = Sim::start(here, &["--record", "a.csv", "--overwrite"]);
    assert!(fs::read(here.join("a.csv")).unwrap() == b"precious" && here.join("a.csv.partial").exists());
    let (code, said) = record(here, &["--record", "a.csv", "--overwrite"]);
    assert_eq!((code, said.as_str()), (Some(2), "error: --record a.csv: another program writes it\n"));
    sim.end("-TERM");
    assert!(fs::read(here.join("a.csv")).unwrap().starts_with(b"# encoring-trace 1\n"));
    assert!(!here.join("a.csv.partial").exists());

    let (code, said) = record(here, &["--state", "memories"]);
    assert_eq!((code, said.as_str()), (Some(0), ""));
    let before = fs::read(here.join("memories/encoder-0.toml")).unwrap();
    for file in ["memories/encoder-0.toml", "memories/new.csv"] {
        let (code, said) = record(here, &["--record", file, "--overwrite", "--state", "memories"]);
        let refusal = format!("error: --record {file}: this folder holds the memories; name another one\n");
        assert_eq!((code, said), (Some(2), refusal));
    }
    assert_eq!(fs::read(here.join("memories/encoder-0.toml")).unwrap(), before);
}

#[cfg(unix)]
#[test]
fn what_a_killed_run_recorded_is_kept_and_links_and_pipes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sim = Sim::start(here, &["--record", "a.csv", "--speed", "max"]);
    let mut program = sim.program;
    while fs::metadata(here.join("a.csv.partial")).unwrap().len() < 200_000 {
        std::thread::yield_now();
    }
    program.kill().unwrap();
    program.wait().unwrap();
    let (code, said) = record(here, &["--record", "a.csv"]);
    let note = "note: --record a.csv: what a run that was killed had recorded is kept as a.csv.1.partial\n";
    assert_eq!((code, said.as_str()), (Some(0), note));
    let remains = fs::read_to_string(here.join("a.csv.1.partial")).unwrap();
    let whole = &remains[..=remains.rfind('\n').unwrap()];
    let replayed = run(here, &["replay", "--at", "0", "a.csv.1.partial"]);
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    let played = String::from_utf8(replayed.stdout).unwrap();
    assert!(played.ends_with(" rows, 0 differences\n"), "{played}");
    // Wherever the last row is cut off, also where it still reads as a row.
    let last = whole[..whole.len() - 1].rfind('\n').unwrap() + 1;
    let line = whole.lines().count();
    let position = whole[last..].split(',').nth(1).unwrap();
    for end in last + 1..whole.len() {
        fs::write(here.join("cut.csv"), &whole[..end]).unwrap();
        let replayed = run(here, &["replay", "--at", position, "cut.csv"]);
        assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
        let note = format!(
            "note: cut.csv line {line} has no line end: the recording was cut off there, and this row is left out\n"
        );
        assert_eq!(String::from_utf8(replayed.stderr).unwrap(), note);
    }

    fs::write(here.join("precious"), "precious").unwrap();
    std::os::unix::fs::symlink("precious", here.join("b.csv.partial")).unwrap();
    assert!(Command::new("mkfifo").arg(here.join("c.csv")).status().unwrap().success());
    for file in ["b.csv", "c.csv"] {
        let (code, said) = record(here, &["--record", file, "--overwrite"]);
        let refusal = format!("error: --record {file}: not an ordinary file; name a new one\n");
        assert_eq!((code, said), (Some(2), refusal));
    }
    assert_eq!(fs::read(here.join("precious")).unwrap(), b"precious");
}

#[cfg(unix)]
#[test]
fn a_recording_that_no_longer_fits_ends_in_whole_rows_and_nothing_else_does() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // A limit on the length of a file, in place of a full disk: 100 blocks of 512 bytes.
    let script = format!(
        "ulimit -f 100; exec {PROGRAM} sim --modbus off --for 2 --speed max --state memories --record a.csv"
    );
    let output = Command::new("sh").current_dir(here).args(["-c", &script]).output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    let [at_once, at_the_end] = said.lines().collect::<Vec<_>>()[..] else { panic!("{said}") };
    assert!(at_once.starts_with("note: ") && at_once.contains(": the recording broke off: "), "{said}");
    assert!(at_the_end.starts_with("error: --record a.csv: "), "{said}");
    assert!(at_the_end.ends_with("; what was written is in a.csv.partial"), "{said}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("\nstopped after 2.000535 s on the ring: 2955 cycles, 0 faulty"), "{told}");
    assert!(!here.join("a.csv").exists() && here.join("memories/encoder-2.toml").exists());
    let replayed = run(here, &["replay", "--at", "1", "a.csv.partial"]);
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    assert_ne!(replayed.stdout, b"0 rows, 0 differences\n");
}

#[cfg(unix)]
#[test]
fn memories_that_do_not_fit_are_told_at_once_and_each_is_tried() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // No file at all may hold a byte, in place of a full disk; the lock has none.
    let script =
        format!("ulimit -f 0; exec {PROGRAM} sim --modbus 127.0.0.1:0 --format json --state memories");
    let mut program = Command::new("sh")
        .current_dir(here)
        .args(["-c", &script])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(program.stdout.take().unwrap());
    let mut positions = Vec::new();
    while positions.len() < 3 {
        let mut line = String::new();
        assert!(lines.read_line(&mut line).unwrap() > 0, "{positions:?}");
        let told: serde_json::Value = serde_json::from_str(&line).unwrap();
        if told["event"] == "memory_not_saved" {
            positions.push(told["position"].as_u64().unwrap());
        }
    }
    assert_eq!(positions, [0, 1, 2]);
    let pid = program.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    let mut said = String::new();
    program.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(program.wait().unwrap().code(), Some(3), "{said}");
    let last = said.lines().last().unwrap();
    for position in 0..3 {
        let file = format!("memories/encoder-{position}.toml: ");
        assert!(last.starts_with("error: --state ") && last.contains(&file), "{said}");
        assert_eq!(said.lines().filter(|line| line.starts_with("note: ") && line.contains(&file)).count(), 1);
    }
    assert_eq!(fs::read_dir(here.join("memories")).unwrap().count(), 1, "only the lock is left");
}

/// Kills a simulation at so many moments: what was acknowledged more than a second before is in its file, every state
/// file is whole, and what was recorded replays up to its last whole row.
fn killed(times: u32) {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let arguments = ["--state", "memories", "--record", "a.csv", "--control", "127.0.0.1:0"];
    let mut chance = 0x9E37_79B9_u32;
    // The value that may have been lost, and the one that must be there otherwise.
    let (mut new, mut old) = (None, 0xFF_FFFF);
    for kill in 0..times {
        // A file that is cut off would be refused here.
        let sim = Sim::start(here, &arguments);
        let mut client = sim.connect("modbus");
        let found = service(&mut client, 2, 0x8200_0000) & 0xFF_FFFF;
        assert!(found == old || Some(found) == new, "kill {kill}: {found}, not {old} or {new:?}");
        let value = 10_000 + kill;
        assert_eq!(service(&mut client, 2, 0xC200_0000 | value), 0xC200_0000 | value);
        let mut control = sim.connect("control");
        let mut answers = BufReader::new(control.try_clone().unwrap());
        let mut ring_ns = || {
            writeln!(control, r#"{{"verb":"view"}}"#).unwrap();
            let mut answer = String::new();
            answers.read_line(&mut answer).unwrap();
            let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
            answer["view"]["time_ns"].as_u64().unwrap()
        };
        chance = chance.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let acknowledged = ring_ns();
        let until = acknowledged + u64::from(chance >> 8) * 90;
        let mut now = acknowledged;
        while now < until {
            now = ring_ns();
        }
        let mut program = sim.program;
        program.kill().unwrap();
        program.wait().unwrap();
        (new, old) = if now - acknowledged > 1_000_000_000 { (None, value) } else { (Some(value), found) };

        let recorded = fs::read_to_string(here.join("a.csv.partial")).unwrap();
        let whole = &recorded[..recorded.rfind('\n').map_or(0, |end| end + 1)];
        if whole.contains("\ntime_us,") {
            let replayed = run(here, &["replay", "--at", "2", "a.csv.partial"]);
            assert_eq!(replayed.status.code(), Some(0), "kill {kill}: {replayed:?}");
            let told = String::from_utf8(replayed.stderr).unwrap();
            assert_eq!(
                told.contains(" has no line end"),
                whole.len() < recorded.len(),
                "kill {kill}: {told}"
            );
        }
    }
}

#[test]
fn a_kill_at_any_moment_loses_nothing_that_was_acknowledged_a_second_before() {
    killed(20);
}

#[test]
#[ignore = "some three minutes; .ci/long runs it"]
fn two_hundred_kills_lose_nothing() {
    killed(200);
}
