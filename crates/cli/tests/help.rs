//! The examples of every `--help` work as they are printed.
//!
//! 192.168.1.10 is played by a simulated ring. What asks is answered by `--yes`, and what runs until Ctrl-C ends by itself.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::expect_used,
    reason = "a test"
)]
#![allow(
    clippy::disallowed_methods,
    reason = "a test plays a person: it types, waits and reads what was printed"
)]

#[path = "pages/clients.rs"]
mod clients;
#[path = "pages/reader.rs"]
mod reader;

use std::sync::Mutex;

use reader::Reader;

/// Encoders that stand still, so that marks can be noted and positions compared.
const STANDING: &str = r#"printf '%s\n' 'version = 1' 'seed = 1' \
    '[[device]]' 'position = 0' 'model = "la-66"' 'rod_mm = 500' \
    '[[device]]' 'position = 1' 'model = "ce-100-m"' \
    '[[device]]' 'position = 2' 'model = "ce-65-m"' > standing.toml"#;

/// The ring at 192.168.1.10, where the encoders stand still if nothing else is asked for.
const RINGS: [(&str, &str); 2] =
    [("encoring probe", "encoring sim"), ("encoring scan", "encoring sim --layout inline")];

/// What stands in the folder before the examples of a command are typed.
const BEFORE: [(&str, &[&str]); 12] = [
    ("encoring decode", &["echo C200270F > words.txt"]),
    (
        "encoring replay",
        &["cp vectors/ce-65-m-8192.csv trace.csv", "cp vectors/la-66.csv commands.csv", RECORDING, TABLE],
    ),
    ("encoring program", &[BACKUP_1]),
    ("encoring restore", &[BACKUP_2, BACKUP_RING]),
    ("encoring replace", &[BACKUP_2]),
    ("encoring watch", &[BACKUP_2, "cp axis-3.toml axis-2.toml", SCENARIO]),
    ("encoring log", &[BACKUP_2, "cp axis-3.toml axis-2.toml"]),
    ("encoring diagnose", &["encoring log axis.csv --bus sim --for 1s", TABLE]),
    ("encoring referee", &[RECORDING, TABLE, BUS]),
    ("encoring ssi decode", &[CAPTURE, LOGIC, "encoring ssi capture --out capture.vcd --bits 31"]),
    ("encoring ssi guess", &[CAPTURE, LOGIC]),
    ("encoring ssi capture", &[SCENARIO]),
];

const RECORDING: &str = "encoring sim --for 1s --speed max --record recording.csv --modbus off";
const TABLE: &str = "printf '%s\\n' 'Zeit;QD 256;ID 256' '0;00000000;00000000' '5;42000000;00000000' '10;C2000000;00000000' > plc.csv";
const BUS: &str =
    "printf '%s\\n' '# encoring-bus 1' 'time_us,position,event,out,in,line,client,half,value' > bus.csv";
const BACKUP_1: &str = "encoring backup axis-3.toml --bus modbus-tcp://192.168.1.10 --at 1 --model ce-100-m";
const BACKUP_2: &str = "encoring backup axis-3.toml --bus modbus-tcp://192.168.1.10 --at 2 --model ce-65-m";
const BACKUP_RING: &str =
    "encoring backup ring.toml --bus modbus-tcp://192.168.1.10 --at 0-2 --model la-66,ce-100-m,ce-65-m";
const SCENARIO: &str = "encoring sim --example > ring.toml";
const CAPTURE: &str = "encoring ssi capture --out capture.sr --bits 25 --code gray";
const LOGIC: &str =
    "encoring ssi capture --out logic.csv && sed -i '1s/clock,data/Channel 0,Channel 1/' logic.csv";

/// What needs more than this machine has, or somebody who answers.
const NOT_RUN: [&str; 4] =
    ["/dev/tty", "fpath", "mbpoll ", "encoring replace --bus modbus-tcp://192.168.1.10 --at 2"];

/// A command that is in `--help`, and its examples.
struct Helped {
    path: String,
    help: String,
}

impl Helped {
    fn examples(&self) -> Vec<String> {
        let text = self.help.replace("\\\n", " ");
        let lines = text.lines().skip_while(|line| *line != "Examples:").skip(1);
        let lines = lines.take_while(|line| line.starts_with("  "));
        lines.map(|line| line.split("  #").next().unwrap_or_default().trim().to_owned()).collect()
    }

    /// What is typed for an example.
    fn typed(&self, example: &str) -> String {
        let example = example.split(" | jq").next().unwrap_or_default();
        let mut typed = played(&example.replace("--for 1d", "--for 10s"));
        // Whoever else runs may hold the default port of the page.
        if example.starts_with("encoring serve ") {
            typed.push_str(" --web 0");
        }
        let goes_on = ["encoring watch ", "encoring log ", "encoring serve "]
            .iter()
            .any(|name| example.starts_with(name));
        if goes_on && !typed.contains("--for") {
            typed.push_str(" --for 300ms");
        }
        if self.help.contains("--yes") && !typed.contains("--yes") {
            typed.push_str(" --yes");
        }
        typed
    }
}

/// An address of the simulated ring in place of 192.168.1.10, with the patience of a loaded machine.
fn played(command: &str) -> String {
    const RING: &str = "127.0.0.1:5020?timeout_ms=5000";
    command.replace("192.168.1.10?", &format!("{RING}&")).replace("192.168.1.10", RING)
}

/// Every command and what its `--help` prints.
fn helped() -> Vec<Helped> {
    fn walk(reader: &mut Reader, path: &str, all: &mut Vec<Helped>) {
        let (ok, lines) = reader.types(&format!("{path} --help"));
        assert!(ok, "{path}");
        let list = lines.iter().skip_while(|line| *line != "Commands:").skip(1);
        let list = list.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
        let names: Vec<&str> = list.filter_map(|line| line.split_whitespace().next()).collect();
        for name in names.into_iter().filter(|name| *name != "help") {
            walk(reader, &format!("{path} {name}"), all);
        }
        all.push(Helped { path: path.to_owned(), help: lines.join("\n") });
    }
    let mut all = Vec::new();
    walk(&mut Reader::new(), "encoring", &mut all);
    all
}

fn entry<T: Copy>(table: &[(&str, T)], path: &str) -> Option<T> {
    table.iter().find(|(name, _)| *name == path).map(|(_, entry)| *entry)
}

/// The examples that were typed, and what did not work.
fn tried(helped: &Helped) -> (usize, Vec<String>) {
    let mut reader = Reader::new();
    let mut must = |command: &str| {
        let (ok, found) = reader.types(&played(command));
        assert!(ok, "{}: {command}\n{}", helped.path, found.join("\n"));
    };
    if helped.help.contains("192.168.1.10") {
        must(STANDING);
        must(entry(&RINGS, &helped.path).unwrap_or("encoring sim standing.toml"));
    }
    entry(&BEFORE, &helped.path).unwrap_or_default().iter().for_each(|command| must(command));
    let (mut run, mut wrong) = (0, Vec::new());
    for example in helped.examples() {
        if NOT_RUN.iter().any(|part| example.contains(part)) {
            continue;
        }
        let typed = helped.typed(&example);
        let (ok, found) = reader.types(&typed);
        run += 1;
        // A fault that is found, or a value that nobody knows, is an answer.
        let is_refused = |line: &String| line.starts_with("error: ") || line.starts_with("bash: ");
        if !ok && found.iter().any(is_refused) {
            wrong.push(format!("{}: {typed}\n{}", helped.path, found.join("\n")));
        }
    }
    (run, wrong)
}

/// Rings that run at one time; more of them would keep each other waiting.
const THREADS: usize = 3;

#[test]
fn every_example_of_every_help_works() {
    let (queue, results) = (Mutex::new(helped()), Mutex::new((0, Vec::new())));
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                while let Some(helped) = { queue.lock().unwrap().pop() } {
                    let (run, wrong) = tried(&helped);
                    let mut results = results.lock().unwrap();
                    results.0 += run;
                    results.1.extend(wrong);
                }
            });
        }
    });
    let (run, wrong) = results.into_inner().unwrap();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n\n"));
    assert!(run >= 80, "only {run} examples were run");
}
