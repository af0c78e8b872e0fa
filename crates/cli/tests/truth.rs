//! What a command says, and what the encoder then is: one table, seen by a second Modbus client.
//!
//! A simulated ring runs in a process of its own. A client brings it into a condition, the command runs through the
//! same server, and the client looks again.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::unix::ffi::OsStrExt;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");

/// The program; the journal of whoever runs the tests is left alone.
fn program() -> Command {
    let mut command = Command::new(PROGRAM);
    let states = format!("{}/states-{}", env!("CARGO_TARGET_TMPDIR"), std::process::id());
    command.env("XDG_STATE_HOME", states);
    command
}

const NUMERATOR: u32 = 0x8300_0000;
const LENGTH: u32 = 0x8200_0000;
/// The standing encoders, each at the position that it shows with factory values.
const CE_65_M: &str = "model = \"ce-65-m\"\nmotion = { kind = \"hold\", raw = 5000 }\n";
const LA_66: &str = "model = \"la-66\"\nmotion = { kind = \"hold\", raw = 250_000 }\n";
const TURNING: &str = "model = \"ce-65-m\"\nmotion = { kind = \"speed\", rpm = 60.0 }\n";
/// At 0 the encoder has read its records.
const FROM_THE_FIRST_CYCLES_ON: &str = "[[event]]\nat_s = 0.001\nposition = 0\n";

/// How the encoder is before the command.
#[derive(Clone, Copy, Debug)]
enum Before {
    Sound,
    /// Of a service that no encoder has; it is over.
    ErrorPending,
    UnreadableRecord,
    MagnetAway,
    Moving,
    /// The numerator is 5000, and the position is still computed with 4096.
    NotAccepted,
    /// The link goes with the write of the request that begins with this byte.
    LinkLost(u8),
}

/// What the second client sees afterwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum In {
    /// This word.
    Is(u32),
    /// Any position without an error.
    SomePosition,
    /// The reply of the service that was cut off: its service bit is still on OUT.
    Reply(u8),
}

/// One line: the command, its exit code, `done` or `checked` if it printed them, IN, and what service 03 (on an
/// LA-66: 02) reads afterwards.
type Line<'a> = (&'a str, i32, Option<bool>, In, u32);

struct Ring {
    program: Child,
    _lines: BufReader<ChildStdout>,
    address: String,
    _folder: tempfile::TempDir,
}

impl Drop for Ring {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

impl Ring {
    fn start(before: Before) -> Self {
        let (device, event) = match before {
            Before::UnreadableRecord => (CE_65_M, "set = { eeprom = { fault = \"read\" } }\n"),
            Before::MagnetAway => (LA_66, "set = { magnet = false }\n"),
            Before::Moving => (TURNING, ""),
            _ => (CE_65_M, ""),
        };
        let ring = Self::of(device, event);
        let mut client = ring.client();
        match before {
            Before::ErrorPending => drop(client.service(0x8700_0000)),
            Before::NotAccepted => assert_eq!(client.service(0xC300_1388), 0xC300_1388),
            Before::MagnetAway => while client.input() & 1 << 29 == 0 {},
            _ => {}
        }
        ring
    }

    /// One encoder, and what happens to it from the first cycles on.
    fn of(device: &str, event: &str) -> Self {
        let event =
            if event.is_empty() { String::new() } else { format!("{FROM_THE_FIRST_CYCLES_ON}{event}") };
        let folder = tempfile::tempdir().unwrap();
        let scenario = folder.path().join("ring.toml");
        fs::write(&scenario, format!("version = 1\n[[device]]\nposition = 0\n{device}{event}")).unwrap();
        let mut command = program();
        command.args(["sim", "--format", "json", "--web", "off", "--modbus", "127.0.0.1:0"]).arg(&scenario);
        let (program, lines, listening) = common::listening(&mut command);
        let address = listening["modbus"].as_str().unwrap().to_owned();
        Self { program, _lines: lines, address, _folder: folder }
    }

    fn client(&self) -> Client {
        Client(TcpStream::connect(&self.address).unwrap())
    }
}

/// The second client.
struct Client(TcpStream);

impl Client {
    fn ask(&mut self, pdu: &[u8]) -> Vec<u8> {
        let length = u16::try_from(pdu.len() + 1).unwrap().to_be_bytes();
        self.0.write_all(&[&[0, 1, 0, 0][..], &length, &[1], pdu].concat()).unwrap();
        frame(&mut self.0).unwrap().split_off(7)
    }

    fn input(&mut self) -> u32 {
        let answer = self.ask(&[4, 0, 0, 0, 2]);
        u32::from_be_bytes(answer[2..6].try_into().unwrap())
    }

    fn out_word(&mut self) -> u32 {
        let answer = self.ask(&[3, 0, 0, 0, 2]);
        u32::from_be_bytes(answer[2..6].try_into().unwrap())
    }

    fn out(&mut self, word: u32) {
        self.ask(&[&[16, 0, 0, 0, 2, 4][..], &word.to_be_bytes()].concat());
    }

    /// A whole service: its reply.
    fn service(&mut self, request: u32) -> u32 {
        // Whatever was left there ends first.
        self.out(0);
        while self.input() >> 31 == 1 {}
        self.out(request);
        let reply = loop {
            let word = self.input();
            if word >> 31 == 1 {
                break word;
            }
        };
        self.out(0);
        while self.input() >> 31 == 1 {}
        reply
    }
}

/// A Modbus frame, header and all.
fn frame(stream: &mut TcpStream) -> std::io::Result<Vec<u8>> {
    let mut header = [0; 7];
    stream.read_exact(&mut header)?;
    let mut pdu = vec![0; usize::from(u16::from_be_bytes([header[4], header[5]])) - 1];
    stream.read_exact(&mut pdu)?;
    Ok([&header[..], &pdu].concat())
}

/// A gateway that is gone once a request with this upper byte has reached the ring; its address.
fn gone_after(code: u8, ring: &Ring) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let server = ring.address.clone();
    thread::spawn(move || {
        while let Ok((mut client, _)) = listener.accept() {
            let mut server = TcpStream::connect(&server).unwrap();
            while let Ok(asked) = frame(&mut client) {
                server.write_all(&asked).unwrap();
                let answer = frame(&mut server).unwrap();
                if asked[7] == 16 && asked[13] == code {
                    let _ = client.shutdown(Shutdown::Both);
                    return;
                }
                if client.write_all(&answer).is_err() {
                    break;
                }
            }
        }
    });
    address
}

/// Runs a command in a condition, and tells how it differs from what is expected.
fn differs(before: Before, (command, code, done, input, value): Line<'_>) -> Option<String> {
    let ring = Ring::start(before);
    let (model, parameter) = match before {
        Before::MagnetAway => ("la-66", LENGTH),
        _ => ("ce-65-m", NUMERATOR),
    };
    let address = match before {
        Before::LinkLost(code) => gone_after(code, &ring),
        _ => ring.address.clone(),
    };
    let bus = format!("modbus-tcp://{address}?timeout_ms=200");
    let output = program()
        .args(command.split(' '))
        .args(["--bus", &bus, "--at", "0", "--model", model, "--format", "json"])
        // Else the old values are kept in the folder of the test.
        .args(command.starts_with("write").then_some("--no-backup"))
        .args(["--patience", "800ms"])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let mut client = ring.client();
    let shown = client.input();
    let seen = match input {
        In::SomePosition if shown >> 29 == 0 => In::SomePosition,
        In::Reply(_) if shown >> 31 == 1 => In::Reply((shown >> 24) as u8),
        _ => In::Is(shown),
    };
    let reads = client.service(parameter) & 0xFF_FFFF;
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let told = report["done"].as_bool().or(report["checked"].as_bool());
    let found = (output.status.code().unwrap(), told, seen, reads);
    (found != (code, done, input, value)).then(|| {
        format!(
            "{before:?}, {command}: {found:X?}\n{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        )
    })
}

const READ: &str = "read all";
const CHECK: &str = "check --yes";
const PRESET: &str = "preset 100 --yes";
const PROGRAM_IT: &str = "write numerator 5000 --yes";

#[test]
fn every_command_tells_the_truth_in_every_condition() {
    use Before as B;
    use In::{Is, Reply, SomePosition};
    // 5000 steps are 1388h; over 5000 turns instead of 4096 they are the 4096th position.
    let (as_before, programmed, pending) = (Is(0x1388), Is(0x1000), Is(0x2000_1388));
    let rod = Is(0x2000_61A8);
    let table: &[(Before, &[Line<'_>])] = &[
        (
            B::Sound,
            &[
                (READ, 0, None, as_before, 4096),
                (CHECK, 0, None, as_before, 4096),
                (PRESET, 0, Some(true), Is(100), 4096),
                (PROGRAM_IT, 0, Some(true), programmed, 5000),
                // Nothing to write.
                ("write numerator 4096 --yes", 0, Some(false), as_before, 4096),
                ("write numerator 4096 --check --yes", 0, Some(true), as_before, 4096),
                ("write numerator 5000 --dry-run", 0, Some(false), as_before, 4096),
                // Without consent, and without anybody to ask.
                ("write numerator 5000", 2, None, as_before, 4096),
                ("preset 100", 2, None, as_before, 4096),
                ("check", 2, None, as_before, 4096),
            ],
        ),
        (
            B::ErrorPending,
            &[
                (READ, 3, None, pending, 4096),
                (CHECK, 1, None, as_before, 4096),
                (PRESET, 1, Some(false), pending, 4096),
                (PROGRAM_IT, 0, Some(true), programmed, 5000),
                ("write numerator 4096 --yes", 1, Some(false), pending, 4096),
                ("write numerator 5000 --dry-run", 3, Some(false), pending, 4096),
                ("write numerator 5000", 2, None, pending, 4096),
            ],
        ),
        (
            B::UnreadableRecord,
            &[
                (READ, 3, None, pending, 0),
                (CHECK, 1, None, pending, 0),
                (PRESET, 1, Some(false), pending, 0),
                (PROGRAM_IT, 1, Some(false), pending, 0),
                ("write numerator 5000 --dry-run", 1, Some(false), pending, 0),
            ],
        ),
        (
            B::MagnetAway,
            &[
                (READ, 3, None, rod, 50_000),
                (CHECK, 1, None, rod, 50_000),
                (PRESET, 1, Some(false), rod, 50_000),
                ("write measuring-length 5000 --yes", 1, Some(true), Is(0x2000_09C4), 5000),
            ],
        ),
        (
            B::Moving,
            &[
                (READ, 0, None, SomePosition, 4096),
                (CHECK, 0, None, SomePosition, 4096),
                (PRESET, 0, Some(true), SomePosition, 4096),
                (PROGRAM_IT, 0, Some(true), SomePosition, 5000),
            ],
        ),
        (
            B::NotAccepted,
            &[
                (READ, 0, None, as_before, 5000),
                (CHECK, 0, None, programmed, 5000),
                (PRESET, 0, Some(true), Is(100), 5000),
                (PROGRAM_IT, 0, Some(false), as_before, 5000),
                ("write numerator 5000 --check --yes", 0, Some(true), programmed, 5000),
                ("write numerator 5000 --check", 2, None, as_before, 5000),
                ("write numerator 4096 --dry-run", 0, Some(false), as_before, 5000),
            ],
        ),
        (B::LinkLost(0x82), &[(READ, 3, None, Reply(0x82), 4096)]),
        (B::LinkLost(0x88), &[(CHECK, 3, None, Reply(0x88), 4096)]),
        (B::LinkLost(0xC6), &[(PRESET, 3, Some(false), Reply(0xC6), 4096)]),
        (B::LinkLost(0xC3), &[(PROGRAM_IT, 3, Some(false), Reply(0xC3), 5000)]),
    ];
    let lines: Vec<(Before, Line<'_>)> =
        table.iter().flat_map(|(before, lines)| lines.iter().map(|line| (*before, *line))).collect();
    // Each waits for the time on its ring most of all.
    let found: Vec<String> = thread::scope(|scope| {
        let share = lines.len().div_ceil(4);
        let running: Vec<_> = lines
            .chunks(share)
            .map(|part| {
                scope.spawn(|| part.iter().filter_map(|(b, line)| differs(*b, *line)).collect::<Vec<_>>())
            })
            .collect();
        running.into_iter().flat_map(|part| part.join().unwrap()).collect()
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// What somebody at a terminal does when a question stands.
#[derive(Clone, Copy, Debug)]
enum Does {
    Yes,
    No,
    /// Ctrl-C.
    Interrupts,
}

/// A question: words that it holds, what IN shows while it stands, and what is done.
type Question<'a> = (&'a [&'a str], In, Does);

/// A terminal: its master, and its other side for a command.
fn terminal() -> (File, File) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap();
    let other = File::options().read(true).write(true).open(OsStr::from_bytes(name.as_bytes())).unwrap();
    (master.into(), other)
}

/// What a command says up to its next question, or to its end.
fn said(from: &mut impl Read) -> String {
    let (mut text, mut byte) = (Vec::new(), [0]);
    while !text.ends_with(b"[y/N] ") && from.read(&mut byte).unwrap() == 1 {
        text.extend(byte);
    }
    String::from_utf8(text).unwrap()
}

/// Somebody at a terminal runs a command and does what `questions` say; the last value is what IN shows at the end.
fn converses(before: Before, command: &str, questions: &[Question<'_>], code: i32, end: In) {
    let ring = Ring::start(before);
    let mut client = ring.client();
    let mut shown = || match client.input() {
        word if word >> 29 == 0 && matches!(before, Before::Moving) => In::SomePosition,
        word => In::Is(word),
    };
    let model = if matches!(before, Before::MagnetAway) { "la-66" } else { "ce-65-m" };
    let bus = format!("modbus-tcp://{}", ring.address);
    let (mut master, other) = terminal();
    let mut running = program()
        .args(command.split(' '))
        .args(["--bus", &bus, "--at", "0", "--model", model])
        .stdin(other)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut from = running.stderr.take().unwrap();
    for (words, standing, does) in questions {
        let question = said(&mut from);
        let unbroken = question.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in *words {
            assert!(unbroken.contains(word), "{before:?}, {command}: {word} is missing in\n{question}");
        }
        assert!(question.ends_with("[y/N] "), "{before:?}, {command}: no question, but\n{question}");
        assert_eq!(shown(), *standing, "{before:?}, {command}, while this stands:\n{question}");
        match does {
            Does::Yes => master.write_all(b"y\n").unwrap(),
            Does::No => master.write_all(b"n\n").unwrap(),
            Does::Interrupts => {
                let id = running.id().to_string();
                assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
            }
        }
    }
    let rest = said(&mut from);
    assert!(!rest.contains("[y/N]"), "{before:?}, {command}: one question more:\n{rest}");
    let ended = running.wait().unwrap().code();
    assert_eq!((ended, shown()), (Some(code), end), "{before:?}, {command}\n{rest}");
}

#[test]
fn a_question_names_what_is_done_and_nothing_is_done_while_it_stands() {
    use Before as B;
    use Does::{Interrupts, No, Yes};
    use In::{Is, SomePosition};
    let (as_before, programmed, pending) = (Is(0x1388), Is(0x1000), Is(0x2000_1388));
    let jump: &[&str] = &["the data check", "the position may jump"];
    let first: &[&str] = &["the data check", "the position may jump", "It comes first"];
    let zero: &[&str] = &["the position is 5000 now and shall be 100", "The old zero cannot be read back"];
    let values: &[&str] =
        &["numerator 4096 -> 5000", "the data check", "the position may jump", "has another position"];
    let check = "write numerator 5000 --check";
    let write = "write numerator 5000 --no-backup";
    for does in [No, Interrupts] {
        let code = if matches!(does, No) { 1 } else { 3 };
        converses(B::Sound, "check", &[(jump, as_before, does)], code, as_before);
        converses(B::Sound, "preset 100", &[(zero, as_before, does)], code, as_before);
        converses(B::Sound, write, &[(values, as_before, does)], code, as_before);
        converses(B::NotAccepted, check, &[(jump, as_before, does)], code, as_before);
        converses(B::ErrorPending, "preset 100", &[(first, pending, does)], code, pending);
        let second = [(first, pending, Yes), (zero, as_before, does)];
        converses(B::ErrorPending, "preset 100", &second, code, as_before);
        let second = [(first, pending, Yes), (values, as_before, does)];
        converses(B::ErrorPending, write, &second, code, as_before);
    }
    converses(B::Sound, "preset 100", &[(zero, as_before, Yes)], 0, Is(100));
    converses(B::NotAccepted, check, &[(jump, as_before, Yes)], 0, programmed);
    converses(B::NotAccepted, "write numerator 5000", &[], 0, as_before);
    let both = [(first, pending, Yes), (zero, as_before, Yes)];
    converses(B::ErrorPending, "preset 100", &both, 0, Is(100));
    let both = [(first, pending, Yes), (values, as_before, Yes)];
    converses(B::ErrorPending, write, &both, 0, programmed);
    let rod = Is(0x2000_61A8);
    converses(B::MagnetAway, "preset 100", &[(first, rod, Yes)], 1, rod);
    let moving: &[&str] = &["Stop the axis: the shaft or magnet moves, by some "];
    converses(B::Moving, "preset 100", &[(moving, SomePosition, No)], 1, SomePosition);
}

#[test]
fn a_check_with_nothing_to_write_says_no_more_than_it_did() {
    let ring = Ring::start(Before::NotAccepted);
    let bus = format!("modbus-tcp://{}", ring.address);
    let command = ["write", "numerator", "5000", "--check", "--yes"];
    let output =
        program().args(command).args(["--bus", &bus, "--at", "0", "--model", "ce-65-m"]).output().unwrap();
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("checked, read back; nothing had to be written"), "{told}");
    assert_eq!(ring.client().input(), 0x1000);
}

#[test]
fn a_wrong_model_is_told_as_that_where_the_words_show_it() {
    let ring = Ring::start(Before::Sound);
    let bus = format!("modbus-tcp://{}", ring.address);
    let read = |parameter: &str, model: &str| {
        let arguments = ["read", parameter, "--bus", &bus, "--at", "0", "--model", model];
        let output = program().args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(3));
        String::from_utf8(output.stdout).unwrap()
    };
    let told = read("04", "ce-100-m");
    let line = "only a ce-65-m has no service 04: is --model ce-100-m right? look at the type label\n";
    assert!(told.contains(line), "{told}");
    // The next read finds the error of the one before pending, and cannot tell.
    ring.client().service(0x8800_0000);
    assert!(read("05", "ce-100-m").contains("a la-66 and a ce-65-m have no service 05"));
    // An LA-66 has one status bit; this encoder shows another.
    let check = ["check", "--yes", "--bus", &bus, "--at", "0", "--model", "la-66"];
    let output = program().args(check).output().unwrap();
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("a la-66 never shows the bits 0080: is --model right?"), "{told}");
    let note = "note: the OUT word of position 0 is needed for this: the PLC must not write it meanwhile\n";
    assert!(String::from_utf8(output.stderr).unwrap().starts_with(note));
}

#[test]
fn interrupted_after_the_first_write_nobody_says_that_nothing_was_sent() {
    let times =
        "service_times = { read_ms = 0, write_ms = 400, data_check_ms = 20, preset_adjustment_ms = 10 }\n";
    let ring = Ring::of(&format!("{CE_65_M}{times}"), "");
    let bus = format!("modbus-tcp://{}", ring.address);
    let command = ["program", "--bus", &bus, "--at", "0", "--model", "ce-65-m", "--yes", "--no-backup"];
    let program = program()
        .args(command)
        .args(["rotary", "--steps-per-turn", "1000", "--turns", "3.5"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut client = ring.client();
    // The second value is on its way, so the first is in the encoder.
    while client.out_word() >> 24 != 0x43 {}
    assert!(Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap().success());
    let output = program.wait_with_output().unwrap();
    let told = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("the old values were written back, checked and read back"), "{told}");
    assert!(!told.contains("nothing was sent") && !told.contains("is as it was"), "{told}");
    assert_eq!((client.service(LENGTH) & 0xFF_FFFF, client.input()), (0xFF_FFFF, 0x1388));
}
