//! Encoders replaced over Modbus TCP, process by process as a user does it, and a `restore` that is killed in the middle.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    missing_docs,
    reason = "a test may panic"
)]

mod common;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");

/// A simulated ring with a Modbus server; it ends with the test.
struct Sim {
    program: Child,
    _lines: BufReader<ChildStdout>,
    address: String,
    control: String,
}

impl Sim {
    /// With a referee that is off, on or strict.
    fn start(folder: &Path, model: &str, referee: &str) -> Self {
        let ring = format!(
            "version = 1\n[[device]]\nposition = 0\nmodel = \"{model}\"\nmotion = {{ kind = \"hold\", raw = 5000 }}\n"
        );
        let file = folder.join("ring.toml");
        fs::write(&file, ring).unwrap();
        let mut command = Command::new(PROGRAM);
        command
            .args([
                "sim",
                "--format",
                "json",
                "--web",
                "off",
                "--referee",
                referee,
                "--modbus",
                "0",
                "--control",
                "0",
            ])
            .arg(file);
        let (program, lines, listening) = common::listening(&mut command);
        let [address, control] =
            ["modbus", "control"].map(|name| listening[name].as_str().unwrap().to_owned());
        Self { program, _lines: lines, address, control }
    }

    /// Turns the shaft, or moves the magnet.
    fn stand(&self, raw: u64) {
        self.tell(&format!("{{\"verb\":\"set\",\"position\":0,\"set\":{{\"raw\":{raw}}}}}\n"));
    }

    /// Writes a parameter as a PLC does that runs no data check.
    fn write(&self, service: u32, value: u32) {
        self.tell(&format!(
            "{{\"verb\":\"service\",\"position\":0,\"service\":{service},\"value\":{value}}}\n"
        ));
    }

    fn tell(&self, line: &str) {
        let mut control = TcpStream::connect(&self.control).unwrap();
        control.write_all(line.as_bytes()).unwrap();
        let mut answer = String::new();
        BufReader::new(control).read_line(&mut answer).unwrap();
        assert!(answer.contains("\"ok\":true"), "{answer}");
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// Passes requests on, and counts them down; at 0 it tells, and passes nothing on any more.
struct Counter {
    address: String,
    left: Arc<AtomicI64>,
    reached: Receiver<()>,
}

impl Counter {
    fn before(server: String) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let left = Arc::new(AtomicI64::new(i64::MAX));
        let (tell, reached) = channel();
        let counter = Arc::clone(&left);
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                let (server, left, tell) = (server.clone(), Arc::clone(&counter), tell.clone());
                thread::spawn(move || {
                    let mut server = TcpStream::connect(server).unwrap();
                    pass_on(client, &mut server, |_| match left.fetch_sub(1, Ordering::SeqCst) {
                        1 => {
                            let _ = tell.send(());
                            false
                        }
                        left => left > 0,
                    });
                });
            }
        });
        Self { address, left, reached }
    }
}

/// From when on a PLC writes.
#[derive(Clone, Copy)]
enum Writes {
    Request(u64),
    /// From behind the first request with the service bit that asks for a preset.
    Preset,
    Never,
}

/// A way to a server beside a PLC that writes the OUT word of position 0 before each request from some moment on; with the
/// number of requests so far.
fn beside_a_plc(server: String, from: Writes) -> (String, Arc<AtomicU64>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let count = Arc::new(AtomicU64::new(0));
    let (counter, preset) = (Arc::clone(&count), Arc::new(AtomicBool::new(false)));
    thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let [mut server, mut plc] = [(); 2].map(|()| TcpStream::connect(&server).unwrap());
            let (counter, preset) = (Arc::clone(&counter), Arc::clone(&preset));
            thread::spawn(move || {
                pass_on(client, &mut server, |request| {
                    let number = counter.fetch_add(1, Ordering::SeqCst);
                    let writes = match from {
                        Writes::Request(from) => number >= from,
                        Writes::Preset => preset.load(Ordering::SeqCst),
                        Writes::Never => false,
                    };
                    if writes {
                        // Function 16, registers 0 and 1: 00001234h. With its bytes exchanged no word of ours may be it:
                        // that would be one which the gateway has spoilt.
                        plc.write_all(&[0, 1, 0, 0, 0, 11, 1, 16, 0, 0, 0, 2, 4, 0, 0, 0x12, 0x34]).unwrap();
                        assert_eq!(frame(&mut plc).unwrap()[7], 16);
                    }
                    // Function 16, and the upper byte of its word.
                    if request[7] == 16 && request[13] == 0xC6 {
                        preset.store(true, Ordering::SeqCst);
                    }
                    true
                });
            });
        }
    });
    (address, count)
}

/// Frames of Modbus TCP, as long as `go_on` says so.
fn pass_on(mut client: TcpStream, server: &mut TcpStream, mut go_on: impl FnMut(&[u8]) -> bool) {
    while let Some(request) = frame(&mut client) {
        if !go_on(&request) {
            // Until the client is gone.
            while frame(&mut client).is_some() {}
            return;
        }
        if server.write_all(&request).is_err() {
            return;
        }
        let Some(answer) = frame(server) else { return };
        if client.write_all(&answer).is_err() {
            return;
        }
    }
}

fn frame(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut frame = vec![0; 6];
    stream.read_exact(&mut frame).ok()?;
    let length = usize::from(u16::from_be_bytes([frame[4], frame[5]]));
    frame.resize(6 + length, 0);
    stream.read_exact(&mut frame[6..]).ok()?;
    Some(frame)
}

/// A user with a folder of files and of states.
struct User {
    folder: tempfile::TempDir,
    bus: String,
}

impl User {
    fn command(&self, command: &str) -> Command {
        let mut encoring = Command::new(PROGRAM);
        encoring
            .current_dir(self.folder.path())
            .args(command.split(' '))
            .args(["--bus", &self.bus, "--at", "0"]);
        encoring.env("XDG_STATE_HOME", self.folder.path().join("states"));
        encoring.stdout(Stdio::piped()).stderr(Stdio::piped()).stdin(Stdio::null());
        encoring
    }

    fn run(&self, command: &str, code: i32) -> String {
        let output = self.command(command).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{command}: {text}");
        text
    }
}

#[test]
fn what_ten_kills_left_is_named_by_the_next_command_and_repaired_by_restore() {
    let folder = tempfile::tempdir().unwrap();
    let sim = Sim::start(folder.path(), "ce-65-m", "on");
    let counter = Counter::before(sim.address.clone());
    let user = User { bus: format!("modbus-tcp://{}?settle_ms=5&timeout_ms=2000", counter.address), folder };
    user.run("backup factory.toml --model ce-65-m", 0);
    user.run("program --model ce-65-m --yes --no-backup rotary --steps-per-turn 1000 --turns 3.5", 0);
    user.run("backup wanted.toml --model ce-65-m", 0);
    user.run("restore factory.toml --yes --no-backup", 0);
    // How many requests a whole restore makes.
    counter.left.store(1_000_000, Ordering::SeqCst);
    user.run("restore wanted.toml --yes --no-backup", 0);
    let whole = 1_000_000 - counter.left.load(Ordering::SeqCst);
    let mut told = Vec::new();
    for kill in 0..10 {
        user.run("restore factory.toml --yes --no-backup", 0);
        // From where nothing was written to where all is read back.
        let at = whole * (3 + kill) / 13;
        counter.left.store(at, Ordering::SeqCst);
        let mut killed = user.command("restore wanted.toml --yes").spawn().unwrap();
        let reached = loop {
            if counter.reached.recv_timeout(Duration::from_millis(2)).is_ok() {
                break true;
            }
            if killed.try_wait().unwrap().is_some() {
                break false;
            }
        };
        if !reached {
            // It polled less often than the one that was counted.
            counter.left.store(i64::MAX, Ordering::SeqCst);
            continue;
        }
        killed.kill().unwrap();
        killed.wait().unwrap();
        counter.left.store(i64::MAX, Ordering::SeqCst);
        // A service bit may stand on OUT; then the next command says how to take it back.
        let first = user.command("read all --model ce-65-m --format json").output().unwrap();
        if first.status.code() != Some(0) {
            let text = String::from_utf8(first.stderr).unwrap();
            assert!(text.contains("encoring release --at 0"), "{text}");
            user.run("release --yes", 0);
        }
        let read = user.run("read all --model ce-65-m --format json", 0);
        let view: serde_json::Value = serde_json::from_str(read.lines().next().unwrap()).unwrap();
        let state = view["journal"]["state"].as_str().unwrap_or("nothing begun").to_owned();
        let value = |at: usize| view["parameters"][at]["value"].as_u64().unwrap();
        let written =
            [(1, 3_499), (2, 35), (3, 10)].iter().filter(|(at, wanted)| value(*at) == *wanted).count();
        let expected: &[&str] = match written {
            0 => &["untouched", "nothing begun"],
            3 => &["all_written"],
            _ => &["part_written"],
        };
        assert!(expected.contains(&state.as_str()), "{at} of {whole}: {state}, {written} written: {view}");
        if written == 3 && kill % 2 == 0 {
            user.run("check --yes --model ce-65-m", 0);
        } else {
            let wanted = user.run("restore wanted.toml --yes --no-backup", 0);
            assert!(wanted.contains("done and verified"), "{wanted}");
        }
        assert!(user.run("read all --model ce-65-m --format json", 0).contains("\"journal\":null"));
        told.push(format!("{at}: {state}"));
    }
    println!("killed at request, of {whole}: {}", told.join(", "));
    assert!(told.iter().any(|told| told.ends_with("part_written")), "{told:?}");
    assert!(told.iter().any(|told| told.ends_with("all_written")), "{told:?}");
}

#[test]
fn a_plc_that_writes_out_beside_replace_is_said_before_and_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let sim = Sim::start(folder.path(), "ce-65-m", "on");
    let of = |address: &str| format!("modbus-tcp://{address}?settle_ms=5&timeout_ms=600");
    let mut user = User { bus: of(&sim.address), folder };
    user.run("backup factory.toml --model ce-65-m --mark here", 0);
    user.run("program --model ce-65-m --yes --no-backup rotary --steps-per-turn 1000 --turns 3.5", 0);
    user.run("backup axis.toml --model ce-65-m --mark here", 0);
    user.run("restore factory.toml --yes --no-backup", 0);
    let replace = "replace --from axis.toml --yes --no-backup --patience 2s --set-at here";
    // How many requests a whole one makes.
    let (address, requests) = beside_a_plc(sim.address.clone(), Writes::Never);
    user.bus = of(&address);
    user.run(replace, 0);
    let whole = requests.load(Ordering::SeqCst);
    // From the first request on, in the middle of the values, and at the zero.
    for (from, when) in [
        (Writes::Request(0), "the first request"),
        (Writes::Request(whole / 2), "half of the requests"),
        (Writes::Preset, "the preset"),
    ] {
        user.bus = of(&sim.address);
        user.run("restore factory.toml --yes --no-backup", 0);
        user.bus = of(&beside_a_plc(sim.address.clone(), from).0);
        let told = user.run(replace, 1);
        assert!(told.contains("the PLC must not write it meanwhile"), "{told}");
        assert!(told.contains("OUT holds 00001234 instead of"), "from {when} on: {told}");
        assert!(told.contains("another master writes it"), "from {when} on: {told}");
        // When the PLC is quiet the same command goes on from there.
        user.bus = of(&sim.address);
        assert!(user.run(replace, 0).contains("position now:"), "from {when} on");
    }
}

// The referee would end the simulation at the first rule of severity error that our own master broke.
#[test]
fn an_encoder_of_each_model_is_replaced_over_modbus() {
    for (model, range, raws) in [
        ("la-66", "linear --length-mm 500 --resolution-mm 0.1", [5_000, 100_000, 250_000, 499_000]),
        ("ce-100-m", "rotary --steps-per-turn 1000 --turns 3.5", [5_000, 7_777, 9_001, 12_345]),
        ("ce-65-m", "rotary --steps-per-turn 4096 --turns 16", [5_000, 7_777, 9_001, 12_345]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let old = Sim::start(folder.path(), model, "strict");
        let bus = |sim: &Sim| format!("modbus-tcp://{}?settle_ms=5&timeout_ms=2000", sim.address);
        let mut user = User { bus: bus(&old), folder };
        user.run(&format!("program --model {model} --yes --no-backup {range}"), 0);
        user.run(&format!("preset 1234 --model {model} --yes"), 0);
        user.run(&format!("backup axis.toml --model {model} --mark at0"), 0);
        for (k, raw) in raws.iter().enumerate().skip(1) {
            old.stand(*raw);
            user.run(&format!("backup axis.toml --update --mark at{k}"), 0);
        }
        let new = Sim::start(user.folder.path(), model, "strict");
        user.bus = bus(&new);
        new.stand(raws[2]);
        let done = user.run("replace --from axis.toml --yes --no-backup --set-at at2", 0);
        assert!(done.contains("its model was not seen, look at its type label"), "{done}");
        for (k, raw) in raws.iter().enumerate() {
            new.stand(*raw);
            let compared =
                user.run(&format!("replace --from axis.toml --yes --no-backup --compare-at at{k}"), 0);
            let equal = compared.contains("equal: the old unit showed the same here");
            // Only where a step is not one of the sensor may it be one lower.
            assert!(
                equal || model == "ce-100-m" && compared.contains("-1 against the old unit"),
                "{compared}"
            );
        }
    }
}

/// An encoder that holds what the file `axis.toml` does and has not checked it: 5000 is no position from 0 to 999.
fn not_checked() -> (Sim, User) {
    let folder = tempfile::tempdir().unwrap();
    let sim = Sim::start(folder.path(), "ce-65-m", "off");
    let file = "version = 1\nmodel = \"ce-65-m\"\n[[mark]]\nname = \"A\"\nshown = 100\n[parameters]\n\
                measuring_length = 999\nnumerator = 10\ndenominator = 1\n";
    fs::write(folder.path().join("axis.toml"), file).unwrap();
    sim.write(0x02, 999);
    sim.write(0x03, 10);
    let user = User { bus: format!("modbus-tcp://{}?settle_ms=5&timeout_ms=2000", sim.address), folder };
    (sim, user)
}

// [R79, R80]
#[test]
fn a_zero_is_made_only_on_values_that_count() {
    let (sim, user) = not_checked();
    let refused = user.run("preset 100 --model ce-65-m --yes", 1);
    assert!(refused.contains("the position is 5000, above the measuring length 999"), "{refused}");
    let replaced = user.run("replace --from axis.toml --yes --no-backup --set-at A", 0);
    assert!(
        replaced.contains("done and verified: checked, read back; nothing had to be written"),
        "{replaced}"
    );
    assert!(replaced.contains("position now:    100"), "{replaced}");
    // The next data check leaves the zero where it is.
    let checked = user.run("check --model ce-65-m --yes", 0);
    assert!(checked.contains("position now:    100"), "{checked}");
    drop(sim);
}

#[test]
fn no_mark_is_noted_where_the_position_shows_that_the_values_do_not_count() {
    let (_sim, user) = not_checked();
    let refused = user.run("backup b.toml --model ce-65-m --mark A", 1);
    assert!(refused.contains("the position 5000 is above the measuring length 999"), "{refused}");
    assert!(!user.folder.path().join("b.toml").exists());
    user.run("check --model ce-65-m --yes", 0);
    user.run("backup b.toml --model ce-65-m --mark A", 0);
}
