//! What is printed can be typed: the numbers of every output go back into the commands that take them.
//!
//! Tables are found in the outputs by their headers, and a header without rules fails. Numbers outside of tables are
//! found word by word.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use encoring_words::number::{self, Bare};
use serde_json::Value;

use super::workshop::Bench;
use super::{Run, encoring};

/// What every command prints, in the bench's folder and in this order.
const OUTPUTS: &[&str] = &[
    "backup old.toml --at 2 --mark left=0mm",
    "read --at 0",
    "read --at 1",
    "read --at 2",
    "write ssi-values 1011Fh --at 2 --yes",
    "write counting-direction falling --at 2 --yes",
    "write measuring-length DABh --at 1 --yes",
    "write preset-value-1 4000 --at 1 --yes",
    "check --at 1 --yes",
    "preset 18h --at 2 --yes",
    "program rotary --steps-per-turn 1000 --turns 3.5 --at 2 --yes",
    "restore old.toml --at 2 --dry-run",
    "restore old.toml --at 2 --yes",
    "restore old.toml --as ce-100-m --at 1 --dry-run",
    "watch --for 1",
    "replace --from old.toml --at 2 --yes",
    "release --at 2 --yes",
    "calc rotary --steps-per-turn 1000 --turns 3.5",
    "calc rotary --steps-per-turn 1000.5 --turns 3.14159",
    "calc rotary --steps-per-turn 5000 --turns 10",
    "calc linear --length-mm 500 --resolution-mm 0.01",
    "calc explain --length 9999 --numerator 10 --denominator 1 --direction falling",
    "calc explain --length 50000 --model la-66 --rod-mm 500",
    "decode C200270F",
    "decode 8D18011F",
    "decode 88002080 --direction in",
    "decode C1010100",
    "decode 0100270F",
    "decode 2000270F",
    "decode C7000018",
    "scan --bus sim --fault jumper:1",
    "decode --master 00E4 0380",
    concat!("replay --model ce-100-m ", env!("CARGO_MANIFEST_DIR"), "/../../vectors/ce-65-m-8192.csv"),
    concat!("referee ", env!("CARGO_MANIFEST_DIR"), "/../../vectors/ce-65-m-travel.csv"),
    concat!("diagnose ", env!("CARGO_MANIFEST_DIR"), "/../../vectors/ce-65-m-travel.csv"),
    "sheet all",
    "ring cycle-time --encoders 3",
    "ssi encode 9999 --bits 25 --code gray",
    "ssi encode 9999 --bits 31",
    "ssi sweep",
    "ssi capture --out capture.sr",
    "ssi decode capture.sr --bits 24",
    "ssi guess capture.sr",
];

/// What runs without the bench's ring and its memories.
const ALONE: [&str; 9] = ["calc", "decode", "replay", "referee", "diagnose", "sheet", "ring", "ssi", "scan"];

/// What prints no numbers of an encoder or runs until it is ended; `log` writes files, and `probe` has a test of its own.
const ELSEWHERE: [&str; 6] = ["completions", "help", "sim", "log", "probe", "serve"];

/// What a cell is, and so which command takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    /// Words for people. Numbers in them are looked at as those outside of tables.
    Text,
    /// Times, counters, ages, registers, quantities of data sheets.
    Apart,
    /// `read CELL`.
    Parameter,
    /// `write SERVICE CELL`.
    Of,
    /// `read --at CELL`.
    Place,
    /// `sheet CELL`.
    Model,
    /// `preset CELL`.
    Position,
    /// `decode CELL`: a word, whole or in two halves.
    Word,
    /// `decode CELL`: the word of the column with this name.
    SameWord(&'static str),
    /// `decode --decimal CELL`, alone or with the cell behind it: that word too.
    Decimal(&'static str),
    /// The second half of one.
    Second,
}

use Cell::{Apart, Decimal, Model, Of, Parameter, Place, Position, SameWord, Second, Text, Word};

/// Every header that is printed, with what its cells are.
const TABLES: &[(&str, &[Cell])] = &[
    ("service|parameter|decimal|hex", &[Parameter, Parameter, Of, Of]),
    ("service|parameter|before|wanted|now", &[Parameter, Parameter, Of, Of, Of]),
    ("service|value|decimal|hex", &[Parameter, Text, Of, Of]),
    (
        "service|OUT|high low|wait for IN|high low",
        &[Parameter, Word, SameWord("OUT"), Word, SameWord("wait for IN")],
    ),
    (
        "write|word|high low|signed|unsigned|high|low",
        &[Parameter, Word, SameWord("word"), SameWord("word"), Decimal("word"), Decimal("word"), Second],
    ),
    (
        "time|at|model|position|verdict|OUT|IN|handshake",
        &[Apart, Place, Model, Position, Text, Word, Word, Text],
    ),
    (
        "position|device|ident|meaning|length|words|OUT|IN|U|BA|RC|RD",
        &[Place, Text, Text, Text, Text, Apart, Apart, Apart, Text, Text, Text, Text],
    ),
    ("kHz|right|wrong|faulty", &[Apart; 4]),
    ("service|name|read|write|values", &[Parameter, Text, Word, Text, Text]),
    ("bit|meaning|remedy", &[Text; 3]),
    ("chapter|about|rule", &[Text; 3]),
    ("connector|pin|signal", &[Text; 3]),
    ("quantity|is|least|most|unit|remark", &[Apart; 6]),
    ("signal|low_below_v|high_above_v|most_v|ohms|most_ma|remark", &[Apart; 7]),
    ("time|clocks|field|position", &[Apart, Apart, Text, Position]),
];

/// A table of an output.
#[derive(Debug)]
struct Table<'a> {
    columns: Vec<&'a str>,
    rows: Vec<Vec<&'a str>>,
}

/// The cells of a line with their places, in characters: two spaces stand between cells.
fn cells(line: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut at = 0;
    for piece in line.split("  ") {
        let cell = piece.trim();
        if !cell.is_empty() {
            found.push((at + (piece.chars().count() - piece.trim_start().chars().count()), cell));
        }
        at += piece.chars().count() + 2;
    }
    found
}

impl<'a> Table<'a> {
    /// The tables of a text: a header of three words or more without a digit, and the lines below it.
    fn all(text: &'a str) -> Vec<Self> {
        let lines: Vec<&str> = text.lines().collect();
        let is_header = |line: &str| {
            let cells = cells(line);
            cells.len() >= 3 && !line.contains(|sign: char| sign.is_ascii_digit() || "-‾:,".contains(sign))
        };
        let mut tables = Vec::new();
        for (at, header) in lines.iter().enumerate().filter(|(_, line)| is_header(line)) {
            let below: Vec<&str> =
                lines[at + 1..].iter().copied().take_while(|line| cells(line).len() > 1).collect();
            if below.first().is_some_and(|line| line.contains(|sign: char| sign.is_ascii_digit())) {
                tables.push(Self::of(&cells(header), &below));
            }
        }
        tables
    }

    /// A cell belongs to the column whose header stands above it, or else to the last one that begins before it.
    fn of(header: &[(usize, &'a str)], below: &[&'a str]) -> Self {
        let columns = header.iter().map(|(_, name)| *name).collect();
        let rows = below.iter().map(|line| {
            let mut row = vec![""; header.len()];
            for (at, cell) in cells(line) {
                let end = at + cell.chars().count();
                let above =
                    |(place, name): &&(usize, &str)| *place < end && place + name.chars().count() > at;
                let column = header
                    .iter()
                    .find(above)
                    .or_else(|| header.iter().rfind(|(place, _)| *place <= at))
                    .and_then(|found| header.iter().position(|other| other == found));
                if let Some(place) = column.and_then(|column| row.get_mut(column))
                    && place.is_empty()
                {
                    *place = cell;
                }
            }
            row
        });
        Self { columns, rows: rows.collect() }
    }

    fn header(&self) -> String {
        self.columns.join("|")
    }

    fn rules(&self) -> &'static [Cell] {
        let header = self.header();
        TABLES.iter().find(|(name, _)| *name == header).unwrap().1
    }
}

/// Types a cell back; the second time the same is typed nothing is done.
struct Typist {
    bench: Bench,
    done: BTreeSet<String>,
}

impl Typist {
    fn new() -> Self {
        Self { bench: Bench::new(), done: BTreeSet::new() }
    }

    /// Runs a command on a fresh ring, and looks for a line in which these words follow each other.
    fn typed(&mut self, command: &str, expected: &str) {
        if self.done.insert(format!("{command} {expected}")) {
            let Run { out, err, .. } = self.bench.run(command);
            let told = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ").contains(expected);
            assert!((out.clone() + &err).lines().any(told), "{command}: no {expected:?} in\n{out}{err}");
        }
    }

    fn word(&mut self, options: &[&str], cell: &str, word: &str) {
        if self.done.insert(format!("decode {options:?} {cell} {word}")) {
            let Run { out, err, .. } =
                encoring(&[&["decode", "--format", "json"], options, &[cell]].concat(), b"");
            let view: Value = serde_json::from_str(&out).unwrap_or_default();
            assert_eq!(view["word"], word, "{cell}: {err}");
        }
    }

    /// A value of a parameter, at the encoder that has it: what it is to become is this.
    fn value(&mut self, service: &str, cell: &str, decimal: &str) {
        let place = if matches!(service, "04" | "05") { 1 } else { 2 };
        let command = format!("write {service} {cell} --at {place} --dry-run");
        if self.done.insert(format!("{command} {decimal}")) {
            let Run { out, err, .. } = self.bench.run(&command);
            let tables = Table::all(&out);
            let rows = tables.iter().flat_map(|table| &table.rows);
            let wanted = rows.filter(|row| row[0] == service).map(|row| row[3]).next();
            assert_eq!(wanted, Some(decimal), "{command}: {out}{err}");
        }
    }

    fn row(&mut self, table: &Table<'_>, row: &[&str]) {
        let of = |name: &str| row[table.columns.iter().position(|column| *column == name).unwrap()];
        for (column, (rule, cell)) in table.rules().iter().zip(row).enumerate() {
            // Nothing is there, or it says so.
            if matches!(*cell, "" | "-" | "position") {
                continue;
            }
            let service = cells(row[0]).first().map_or("", |(_, cell)| cell.split(' ').next().unwrap_or(""));
            match rule {
                Text | Apart | Second => {}
                Parameter => self.parameter(cell),
                Of => self.value(
                    service,
                    cell,
                    if table.columns.contains(&"decimal") { of("decimal") } else { cell },
                ),
                Place => self.typed(&format!("read 02 --at {cell}"), &format!("position {cell} (device")),
                Model => assert_eq!(encoring(&["sheet", cell], b"").code, Some(0), "{cell}"),
                Position => {
                    self.typed(&format!("preset {cell} --at 2 --yes"), &format!("position now: {cell}"));
                }
                Word => self.word(&[], cell, cell),
                SameWord(word) => self.word(&[], cell, of(word)),
                Decimal(word) => {
                    let low = (table.rules().get(column + 1) == Some(&Second)).then(|| row[column + 1]);
                    let cell = low.map_or_else(|| (*cell).to_owned(), |low| format!("{cell} {low}"));
                    self.word(&["--decimal"], &cell, of(word));
                }
            }
        }
    }

    /// Its number is in front of its name, if both stand in one cell.
    fn parameter(&mut self, cell: &str) {
        let (name, place) = match cell.split(' ').next().unwrap_or_default() {
            "08" | "06" => return,
            name @ ("04" | "05" | "preset_value_1" | "preset_value_2") => (name, 1),
            name => (name, 2),
        };
        self.typed(&format!("read {name} --at {place}"), name);
    }
}

/// Asserts that a number in a text is read as what it is, if it is one.
fn read_back(number: &str, line: &str) {
    let digits = number.strip_suffix('h').unwrap_or(number);
    let hexadecimal =
        !digits.is_empty() && digits.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F'));
    if !hexadecimal || !digits.contains(|digit: char| digit.is_ascii_digit()) && number == digits {
        return;
    }
    // Digit by digit, as the reader that is tested shall not say what is right.
    let digit =
        |sum: u64, digit: char| sum.saturating_mul(16).saturating_add(u64::from(digit.to_digit(16).unwrap()));
    let bits = digits.chars().fold(0, digit);
    let decimal = digits.bytes().all(|digit| digit.is_ascii_digit());
    let read = match (digits.len(), number == digits) {
        (8, _) => number::word([number], Bare::Hexadecimal).map(|read| read.bits),
        (_, false) => number::value(number).map(|read| read.number),
        // Numbers of services, which the commands take.
        (2, true) => return,
        // The bits of a line.
        (9.., true) if digits.bytes().all(|bit| matches!(bit, b'0' | b'1')) => return,
        (4, true) if !decimal || digits.starts_with('0') => {
            number::half(number, Bare::Hexadecimal).map(|read| read.bits)
        }
        (_, true) if decimal && (!digits.starts_with('0') || digits.len() == 1) => return,
        (_, true) => number::value(number).map(|read| read.number),
    };
    assert_eq!(read.map(u64::from), Ok(bits), "{line}");
}

/// The numbers of a text: what stands between spaces and signs that no number has.
fn numbers(line: &str) -> impl Iterator<Item = &str> {
    let apart = |sign: char| !(sign.is_ascii_alphanumeric() || "#.-+/=%^_".contains(sign));
    line.split(apart).flat_map(|piece| piece.split("..")).map(|piece| piece.trim_matches('.'))
}

fn outputs() -> Vec<String> {
    let bench = Bench::new();
    let run = |command: &&str| {
        let Run { code, out, err } = match command.split(' ').next() {
            Some(name) if ALONE.contains(&name) => bench.alone(command),
            _ => bench.run(command),
        };
        assert!(matches!(code, Some(0 | 1)), "{command}\n{out}{err}");
        out + &err
    };
    OUTPUTS.iter().map(run).collect()
}

#[test]
fn every_cell_of_every_table_is_typed_back_and_is_the_same() {
    let outputs = outputs();
    let tables: Vec<Table<'_>> = outputs.iter().flat_map(|output| Table::all(output)).collect();
    let printed: BTreeSet<String> = tables.iter().map(Table::header).collect();
    let ruled: BTreeSet<String> = TABLES.iter().map(|(header, _)| (*header).to_owned()).collect();
    assert_eq!(printed, ruled, "what is printed, and what there are rules for");
    let mut typist = Typist::new();
    for table in &tables {
        table.rows.iter().for_each(|row| typist.row(table, row));
    }
}

#[test]
fn no_number_in_any_output_is_refused_or_read_as_another() {
    for output in &outputs() {
        // A drawing of lines and bits is none.
        for line in output.lines().filter(|line| !line.contains(['‾', '"'])) {
            numbers(line).for_each(|number| read_back(number, line));
        }
    }
}

#[test]
fn what_probe_prints_is_read_as_what_it_is() {
    let mut sim = Command::new(env!("CARGO_BIN_EXE_encoring"))
        .args(["sim", "--format", "json", "--web", "off", "--modbus", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(sim.stdout.take().unwrap());
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    let listening: Value = serde_json::from_str(&first).unwrap();
    let gateway = format!("modbus-tcp://{}", listening["modbus"].as_str().unwrap());
    let probed = encoring(&["probe", &gateway], b"");
    let addresses: Vec<&str> = probed.out.split('\'').filter(|text| text.starts_with("modbus-tcp")).collect();
    let read = |address: &&str| {
        encoring(&["read", "02", "--bus", address, "--at", "2", "--model", "ce-65-m"], b"").code
    };
    let codes: Vec<Option<i32>> = addresses.iter().map(read).collect();
    sim.kill().unwrap();
    sim.wait().unwrap();
    assert!(!codes.is_empty() && codes.iter().all(|code| *code == Some(0)), "{}", probed.out);
    for line in probed.out.lines() {
        numbers(line).for_each(|number| read_back(number, line));
    }
}

#[test]
fn every_command_is_among_the_outputs() {
    let commands = |path: &[&str]| -> Vec<String> {
        let Run { out, .. } = encoring(&[path, &["--help"]].concat(), b"");
        let list = out.lines().skip_while(|line| *line != "Commands:").skip(1);
        let names = list.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("   "));
        names.filter_map(|line| line.split_whitespace().next().map(str::to_owned)).collect()
    };
    let looked_at = |name: &str| {
        let begins = |command: &str| command == name || command.starts_with(&format!("{name} "));
        ELSEWHERE.contains(&name) || OUTPUTS.iter().any(|command| begins(command))
    };
    for name in commands(&[]) {
        assert!(looked_at(&name), "{name}");
        if ["calc", "ssi", "ring"].contains(&name.as_str()) {
            for inner in commands(&[&name]).iter().filter(|inner| *inner != "help") {
                assert!(looked_at(&format!("{name} {inner}")), "{name} {inner}");
            }
        }
    }
}
