//! Ctrl-C, pressed again, ends every command whatever the gateway does.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a test may panic"
)]

mod common;

use std::fs;
use std::io::{self, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");

/// Longer than any command may take after the second Ctrl-C, also on a machine that is busy.
const PRESSED_MAX: u32 = 50;
const BETWEEN: Duration = Duration::from_millis(200);

/// A simulated ring behind a gateway with a fault; it ends with the test.
struct Gateway {
    program: Child,
    /// Nobody reads on, but a pipe that is closed would end it.
    _lines: BufReader<ChildStdout>,
    address: String,
}

impl Gateway {
    fn start(fault: &str) -> Self {
        let options = ["sim", "--web", "off", "--modbus", "0", "--format", "json", "--gateway-fault", fault];
        let (program, lines, listening) = common::listening(Command::new(PROGRAM).args(options));
        Self { program, _lines: lines, address: listening["modbus"].as_str().unwrap().to_owned() }
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// What passes between a command and its gateway.
#[derive(Debug, PartialEq, Eq)]
enum Passed {
    Connection,
    Request,
}

/// Passes everything on, and tells of it.
fn between(gateway: String) -> (String, Receiver<Passed>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (tell, told) = channel();
    thread::spawn(move || {
        for client in listener.incoming() {
            let (Ok(client), Ok(server)) = (client, TcpStream::connect(&gateway)) else { return };
            let _ = tell.send(Passed::Connection);
            let back = (server.try_clone().unwrap(), client.try_clone().unwrap());
            let tell = tell.clone();
            thread::spawn(move || pass(client, server, Some(&tell)));
            thread::spawn(move || pass(back.0, back.1, None));
        }
    });
    (address, told)
}

/// A gateway that closes every connection at once.
const HANGS_UP: &str = "hangs up";

fn hangs_up() -> (String, Receiver<Passed>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (tell, told) = channel();
    thread::spawn(move || listener.incoming().flatten().all(|_| tell.send(Passed::Connection).is_ok()));
    (address, told)
}

fn pass(mut from: TcpStream, mut to: TcpStream, tell: Option<&Sender<Passed>>) {
    let mut bytes = [0; 1024];
    while let Ok(count @ 1..) = from.read(&mut bytes) {
        let whole: io::Result<()> = bytes.get(..count).map_or(Ok(()), |bytes| to.write_all(bytes));
        if whole.is_err() {
            break;
        }
        let _ = tell.map(|tell| tell.send(Passed::Request));
    }
    let _ = to.shutdown(Shutdown::Both);
}

/// Presses Ctrl-C until the command has ended: the system makes one of two that come too close together.
fn pressed_until_it_ends(mut command: Child) -> Option<ExitStatus> {
    let id = command.id().to_string();
    let (tell, told) = channel();
    thread::spawn(move || tell.send(command.wait().unwrap()));
    for _ in 0..PRESSED_MAX {
        // Where it fails the command has just ended.
        let pressed = Command::new("kill").args(["-INT", &id]).stderr(Stdio::null()).status().unwrap();
        if !pressed.success() {
            return told.recv().ok();
        }
        if let Ok(status) = told.recv_timeout(BETWEEN) {
            return Some(status);
        }
    }
    let _ = Command::new("kill").args(["-KILL", &id]).status();
    None
}

/// Begins a command, waits until it is in the midst of the fault, and ends it.
fn interrupt(fault: &str, command: &str, folder: &Path) {
    let gateway = (fault != HANGS_UP).then(|| Gateway::start(fault));
    let (address, passed) = match &gateway {
        Some(gateway) => between(gateway.address.clone()),
        None => hangs_up(),
    };
    // Without Ctrl-C it would wait for minutes.
    let bus = format!("modbus-tcp://{address}?timeout_ms=60000");
    let mut program = Command::new(PROGRAM);
    program.env("XDG_STATE_HOME", folder).current_dir(folder).args(command.split(' '));
    match command {
        "probe" => program.arg(&bus),
        "scan" => program.args(["--bus", &format!("{bus}&layout=inline")]),
        _ => program.args(["--bus", &bus, "--at", "0"]),
    };
    let serves = command.contains("--patience");
    if !["probe", "scan", "release", "restore", "replace"].iter().any(|other| command.starts_with(other)) {
        program.args(["--model", "ce-65-m"]);
    }
    let child = program.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    // A gateway that dies does so with the first service; then the command connects again.
    let awaited = match fault {
        HANGS_UP => [Passed::Connection].as_slice(),
        "dead" if serves => &[Passed::Connection, Passed::Connection],
        _ => &[Passed::Connection, Passed::Request],
    };
    for awaited in awaited {
        assert!(passed.iter().any(|passed| passed == *awaited), "{command} on {fault}: no {awaited:?}");
    }
    let ended = pressed_until_it_ends(child);
    let ended = ended.unwrap_or_else(|| panic!("{command} on {fault} does not end"));
    assert!(ended.code().is_some(), "{command} on {fault}: killed by a signal instead of ended: {ended}");
    if serves {
        assert_eq!(ended.code(), Some(3), "{command} on {fault}");
    }
}

const COMMANDS: [&str; 13] = [
    "check --yes --patience 600s",
    "program --yes --no-backup --file axis.toml --patience 600s",
    "restore axis.toml --yes --no-backup --patience 600s",
    "replace --from axis.toml --yes --no-backup --patience 600s",
    "backup kept.toml --patience 600s",
    "scan",
    "preset 7 --yes --patience 600s",
    "write measuring-length 9999 --yes --no-backup --patience 600s",
    "read 02 --patience 600s",
    "watch",
    "log log.csv",
    "probe",
    "release --yes",
];

fn every_command(fault: &str) {
    let folder = tempfile::tempdir().unwrap();
    let kept = "version = 1\nmodel = \"ce-65-m\"\n[parameters]\nmeasuring_length = 9999\n";
    fs::write(folder.path().join("axis.toml"), kept).unwrap();
    thread::scope(|scope| {
        for command in COMMANDS {
            let folder = folder.path();
            scope.spawn(move || interrupt(fault, command, folder));
        }
    });
}

#[test]
fn ctrl_c_twice_ends_every_command_on_a_gateway_that_does_not_answer() {
    every_command("silent");
}

#[test]
fn ctrl_c_twice_ends_every_command_on_a_gateway_that_answers_after_a_minute() {
    every_command("late=60000");
}

#[test]
fn ctrl_c_twice_ends_every_command_on_a_gateway_that_carries_out_and_says_nothing() {
    every_command("drop");
}

#[test]
fn ctrl_c_twice_ends_every_command_on_a_gateway_that_has_died() {
    every_command("dead");
}

#[test]
fn ctrl_c_twice_ends_every_command_on_a_gateway_that_closes_every_connection() {
    every_command(HANGS_UP);
}

/// A log of a service that no model has, or of one that all have, and then so many rows without one that only a command that
/// has judged the service can have taken them from a pipe.
fn long_log(service: u32) -> String {
    let rest = service & 0x7FFF_FFFF;
    let words = [(0, 100), (rest, 100), (service, 100), (service, service), (rest, service), (rest, 100)];
    let rows = words.into_iter().chain(std::iter::repeat_n((rest, 100), 100_000));
    let rows = (0..).zip(rows).map(|(row, (out, input))| format!("{},{out:08X},{input:08X}\n", row * 10));
    format!("time_ms,out,in\n{}", rows.collect::<String>())
}

#[test]
fn ctrl_c_ends_the_referee_of_a_pipe_that_gives_nothing_more_with_what_is_known() {
    for (service, file, code, said) in [
        (0x8700_0000, "-", 1, "unknown_service"),
        (0x8700_0000, "/dev/stdin", 1, "unknown_service"),
        (0x8200_0000, "-", 3, "1 service was seen"),
    ] {
        let mut program = Command::new(PROGRAM);
        program.args(["referee", file, "--model", "ce-65-m"]).stdin(Stdio::piped());
        let mut child = program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut pipe = child.stdin.take().unwrap();
        pipe.write_all(long_log(service).as_bytes()).unwrap();
        // In the midst of a row.
        pipe.write_all(b"99999").unwrap();
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        drop(pipe);
        let [out, told] = [&ended.stdout, &ended.stderr].map(|text| String::from_utf8_lossy(text));
        assert_eq!(ended.status.code(), Some(code), "{file}: {out}{told}");
        assert!(out.contains(said), "{out}");
        assert!(told.contains(": interrupted, judged up to line "), "{told}");
    }
}
