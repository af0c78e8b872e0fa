//! `encoring replay`: comparing, printing, recordings, and what is refused.

use super::{Run, encoring, refused};
use encoring_encoder::{ServiceTimes, Unit};
use encoring_sim::replay::play;
use encoring_sim::{Eeprom, Node, Surroundings, device_line};
use encoring_trace::{Row, Writer};
use encoring_words::model::Sensor;
use encoring_words::{Instant, Model, OutWord};
use std::path::PathBuf;
use tempfile::TempDir;

const Q4096: Sensor = Sensor::Rotary { steps_per_turn: 4096 };

/// Every golden trace: its options, its file, its rows.
const GOLDEN: [(&str, &str, u32); 6] = [
    ("--model la-66 --rod-mm 500", "la-66", 4000),
    ("--model ce-100-m", "ce-100-m", 4000),
    ("--model ce-100-m --native 4096", "ce-100-m-travel", 1513),
    ("--model ce-65-m", "ce-65-m", 4000),
    ("--model ce-65-m --native 8192 --service-times zero", "ce-65-m-8192", 4000),
    ("--model ce-65-m", "ce-65-m-travel", 1517),
];

fn vector(name: &str) -> String {
    format!("vectors/{name}.csv")
}

fn replay(arguments: &str, file: &str) -> Run {
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    encoring(&[&["replay"][..], &arguments, &[file]].concat(), b"")
}

/// A file of its own directory, which must live as long as the test.
fn file(name: &str, content: impl AsRef<[u8]>) -> (TempDir, String) {
    let directory = tempfile::tempdir().unwrap();
    let path: PathBuf = directory.path().join(name);
    std::fs::write(&path, content).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (directory, path)
}

#[test]
fn every_golden_trace_replays_without_a_difference() {
    for (options, name, rows) in GOLDEN {
        let Run { code, out, err } = replay(options, &vector(name));
        assert_eq!(out, format!("{rows} rows, 0 differences\n"), "{name}");
        assert_eq!((code, err.as_str()), (Some(0), ""), "{name}");
    }
}

#[test]
fn printing_a_golden_trace_gives_it_back_byte_for_byte() {
    for (options, name, rows) in GOLDEN {
        let trace = std::fs::read_to_string(format!("{}/../../{}", env!("CARGO_MANIFEST_DIR"), vector(name)))
            .unwrap();
        let Run { code, out, err } = replay(&format!("{options} --print"), &vector(name));
        assert!(out == trace, "{name}");
        assert_eq!((code, err), (Some(0), format!("{rows} rows, 0 differences\n")), "{name}");
        // Also without the answers and with the columns the other way round.
        let commands = trace.lines().map(|row| {
            let cells: Vec<&str> = row.split(',').take(7).collect();
            cells.into_iter().rev().collect::<Vec<_>>().join(",") + "\n"
        });
        let commands: String = commands.collect();
        let arguments: Vec<&str> = options.split(' ').chain(["--print", "-"]).collect();
        let Run { code, out, .. } =
            encoring(&[&["replay"], arguments.as_slice()].concat(), commands.as_bytes());
        assert!(out == trace, "{name}");
        assert_eq!(code, Some(0), "{name}");
    }
}

#[test]
fn the_first_ten_differences_are_shown_and_all_are_counted() {
    let Run { code, out, err } = replay("--model ce-65-m", &vector("ce-65-m-8192"));
    assert_eq!((code, err.as_str()), (Some(1), ""));
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines.len(), 11);
    assert_eq!(lines[0], "line 2: out 88000000 expected 00FFF800 got 00FFF000");
    assert_eq!(lines[10], "4000 rows, 2742 differences");

    let Run { code, out, err } = replay("--model ce-65-m --format json", &vector("ce-65-m-8192"));
    assert_eq!((code, err.as_str()), (Some(1), ""));
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&summary["rows"], &summary["differences"]), (&4000.into(), &2742.into()));
    assert_eq!(summary["first"].as_array().unwrap().len(), 10);
    assert_eq!(
        summary["first"][0],
        serde_json::json!({"line": 2, "out": "88000000", "expected": "00FFF800", "got": "00FFF000"})
    );

    let Run { code, out, err } = replay("--model ce-65-m --print", &vector("ce-65-m-8192"));
    assert_eq!(code, Some(1));
    assert_eq!(out.lines().count(), 4001);
    assert_eq!(err.lines().collect::<Vec<_>>(), lines);
}

#[test]
fn one_changed_word_is_the_one_difference() {
    let (_directory, path) = file("one.csv", "out,in\n00000000,00000000\n82000010,82FFFFFE\n");
    let Run { code, out, .. } = replay("--model ce-65-m", &path);
    assert_eq!(code, Some(1));
    assert_eq!(out, "line 3: out 82000010 expected 82FFFFFE got 82FFFFFF\n2 rows, 1 differences\n");
    let (_directory, path) = file("off.csv", "supply_v,in\n24,off\n10,00000000\n");
    let Run { out, .. } = replay("--model ce-65-m", &path);
    assert_eq!(
        out,
        "line 2: out 00000000 expected off got 00000000\n\
         line 3: out 00000000 expected 00000000 got off\n2 rows, 2 differences\n"
    );
}

#[test]
fn default_service_times_delay_the_replies() {
    let (_directory, path) = file("late.csv", "out,in\n00000000,00000000\nC2000010,00000000\n");
    assert_eq!(replay("--model ce-65-m --service-times default", &path).code, Some(0));
    assert_eq!(replay("--model ce-65-m --service-times zero", &path).code, Some(1));
    assert_eq!(replay("--model ce-65-m", &path).code, Some(1));
}

#[test]
fn a_service_bit_that_stands_at_power_up_counts_only_for_a_unit_that_executes_it() {
    let (_kept, ignored) =
        file("ignored.csv", "out,raw,in\nC6000005,1000,000003E8\n46000005,1000,000003E8\n");
    let (_also, executed) =
        file("executed.csv", "out,raw,in\nC6000005,1000,C6000005\n46000005,1000,00000005\n");
    let says = |option: &str, path: &str| replay(&format!("--model ce-65-m {option}"), path).out;
    for option in ["", "--stale-service ignored"] {
        assert_eq!(says(option, &ignored), "2 rows, 0 differences\n", "{option}");
        assert!(says(option, &executed).ends_with("2 rows, 2 differences\n"), "{option}");
    }
    assert_eq!(says("--stale-service executed", &executed), "2 rows, 0 differences\n");
    assert!(says("--stale-service executed", &ignored).ends_with("2 rows, 2 differences\n"));
}

#[test]
fn a_trace_without_answers_compares_nothing_and_says_so() {
    let (_directory, path) = file("bare.csv", "out\n00000000\n");
    let Run { code, out, err } = replay("--model la-66", &path);
    assert_eq!((code, out.as_str()), (Some(3), "1 rows, 0 differences\n"));
    assert_eq!(err, format!("note: nothing compared: no row of {path} that was played has an IN word\n"));
}

#[test]
fn a_log_is_compared_and_keeps_the_word_that_it_did_not_see() {
    let log = "# encoring-log 2 started today\n# bus sim\ntime_us,position,out,in,verdict,value\n\
               0,0,0x00000000,0x00000000,valid,0\n0,1,0x00000000,0x00000000,valid,0\n\
               1000,1,0x82000000,0x82FFFFFF,reply,\n2000,1,,,no_answer,\n3000,1,0x82000000,0x82FFFFFF,reply,\n";
    let (_directory, path) = file("log.csv", log);
    let Run { code, out, err } = replay("--model ce-65-m --at 1", &path);
    assert_eq!((code, out.as_str(), err.as_str()), (Some(0), "4 rows, 0 differences\n", ""));
    let Run { out, .. } = replay("--model ce-65-m --at 1 --print", &path);
    assert_eq!(out.lines().nth(3), Some("2000,82000000,0,0.0,0.0,24.0,1,82FFFFFF"));
    let Run { code, out, .. } = replay("--model ce-65-m --at 2", &path);
    assert_eq!((code, out.as_str()), (Some(3), "0 rows, 0 differences\n"));
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let la_66 = vector("la-66");
    let refuses = |options: &str, message: &str| {
        let options: Vec<&str> = options.split_whitespace().collect();
        refused(&[&["replay"][..], &options, &[&la_66]].concat(), b"", message);
    };
    refuses(
        "",
        "error: --model is missing: a trace does not name its encoder; it is la-66, ce-100-m or ce-65-m",
    );
    refuses("--model ce-100-m --native 8192", "error: --native: 8192 steps per turn; a ce-100-m has 4096");
    refuses("--model ce-65-m --rod-mm 500", "error: --rod-mm: a ce-65-m has steps per turn, no rod length");
    refuses("--model la-66 --native 4096", "error: --native: a la-66 has a rod length, no steps per turn");
    refuses(
        "--model la-66 --native 4096 --rod-mm 500",
        "error: --native and --rod-mm: an encoder turns or is a rod, not both",
    );
    refuses(
        "--model la-66 --rod-mm 0",
        "error: invalid value '0' for '--rod-mm <N>': not above 0; allowed is a number like 12 or 0.01, above 0",
    );
    refuses(
        "--model la-66 --rod-mm 500,5",
        "error: invalid value '500,5' for '--rod-mm <N>': write the decimals behind a point: 500.5",
    );
    refuses("--model la-66 --native 1000", "error: invalid value '1000' for '--native <STEPS>'");
    refuses(
        "--model la-66 --at 128",
        "error: invalid value '128' for '--at <POSITION>': 128 is above 127; give 0 to 127",
    );
    refuses(
        "--model la-66 --at 3",
        "error: vectors/la-66.csv line 2: no column position, so nothing is at 3; leave --at out",
    );
}

#[test]
fn bad_traces_are_refused_with_file_line_and_column() {
    let refuses = |content: &[u8], message: &str| {
        refused(&["replay", "--model", "ce-65-m", "-"], content, message);
    };
    refuses(
        b"",
        "error: standard input line 1: no header, the columns are time_us, position, out, raw, preset1_v, preset2_v, supply_v, magnet, in, verdict, value, line, status, parameter",
    );
    refuses(
        b"out\nC2\n",
        "error: standard input line 2, column out: C2: a word has 8 digits; zeros may be lost. Write 000000C2 or 0xC2",
    );
    refuses(b"out,magnet\n00000000,2\n", "error: standard input line 2, column magnet: \"2\" is not 0 or 1");
    refuses(
        b"out,raw\n00000000\n",
        "error: standard input line 2: 1 cell, the header has 2; a remark must begin with #",
    );
    refuses(
        b"time_us\n5\n4\n",
        "error: standard input line 3, column time_us: 4 is before 5, the time of the previous row",
    );
    refuses(
        b"position\n3\n4\n",
        "error: standard input line 3: position 4 after position 3; choose one with --at",
    );
    refuses(b"# encoring-trace 2\nout\n", "error: standard input line 1: version 2, this program reads 1");
    refused(
        &["replay", "--model", "ce-65-m", "no-such-file.csv"],
        b"",
        "error: cannot open no-such-file.csv: No such file or directory",
    );
    assert_eq!(replay("--model ce-65-m", "vectors").code, Some(2));
}

/// The tables of the trace crate, where every spelling is read.
fn table(name: &str) -> String {
    format!("{}/../trace/tests/tables/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn replay_table(options: &[&str], name: &str) -> Run {
    encoring(&[&["replay", "--model", "ce-65-m"], options, &[&table(name)]].concat(), b"")
}

#[test]
fn tables_of_other_programs_are_compared_and_what_was_assumed_is_told() {
    let columns = ["--columns", "time_ms=Zeitstempel,out=QD 256,in=ID 256"];
    let Run { code, out, err } = replay_table(&columns, "plc.csv");
    assert_eq!((code, out.as_str()), (Some(0), "7 rows, 0 differences\n"));
    let assumed =
        "`;` separates the cells; time in ms from \"Zeitstempel\"; out from \"QD 256\"; in from \"ID 256\"";
    assert_eq!(err, format!("note: {}: {assumed}\n", table("plc.csv")));
    let Run { out, .. } = replay_table(&[&columns[..], &["--format", "json"]].concat(), "plc.csv");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["assumed"], assumed);
    for (options, name) in [
        (&["--period", "1ms"][..], "no-time.csv"),
        (&["--decimal"], "signed.csv"),
        (&["--columns", "time_s=1,out=2,in=3"], "no-header.csv"),
        (&[], "utf-16.txt"),
    ] {
        let Run { code, out, err } = replay_table(options, name);
        assert_eq!((code, out.as_str()), (Some(0), "7 rows, 0 differences\n"), "{name}: {err}");
        let printed = replay_table(&[options, &["--print"]].concat(), name).out;
        assert_eq!(printed, replay_table(&["--print"], "base.csv").out, "{name}");
    }
}

#[test]
fn words_that_could_be_decimal_are_told() {
    let Run { err, .. } = encoring(&["replay", "--model", "ce-65-m", "-"], b"out,in\n00000000,16777215\n");
    assert_eq!(
        err,
        "note: no word of standard input has a letter, and all were read as hexadecimal; if they are decimal, give \
         --decimal\n"
    );
    let decimal = ["replay", "--model", "ce-65-m", "--decimal", "-"];
    let Run { out, err, .. } = encoring(&decimal, b"out,in\n0,16777215\n");
    assert!(out.starts_with("line 2: out 00000000 expected 00FFFFFF got "), "{out}");
    assert!(!err.contains("--decimal"), "{err}");
}

#[test]
fn columns_are_said_in_the_way_that_the_help_shows() {
    for (columns, why) in [
        (
            "in",
            "\"in\" has no = and no column behind it; a name that holds a comma stands in quotes, as 'in=\"Enc, IN\"'",
        ),
        ("inn=1", "\"inn\" is no column; they are time, "),
        ("in=1,IN=2", "IN is said twice"),
        ("time_s=1,time_ms=2", "time_ms is said twice"),
        ("in=\"1", "a double quote is not closed"),
        ("in= ", "in= has no name of a column behind it"),
    ] {
        let Run { code, err, .. } = replay_table(&["--columns", columns], "base.csv");
        assert_eq!(code, Some(2));
        assert!(
            err.starts_with(&format!("error: invalid value '{columns}' for '--columns <COLUMNS>': {why}")),
            "{err}"
        );
    }
}

#[test]
fn rows_before_a_bad_one_are_shown() {
    let content = b"in\n00000001\nX\n";
    let Run { code, out, err } = encoring(&["replay", "--model", "ce-65-m", "-"], content);
    assert_eq!(code, Some(2));
    assert_eq!(out, "line 2: out 00000000 expected 00000001 got 00000000\n");
    assert!(err.starts_with("error: standard input line 3, column in: X: not a word"), "{err}");
    let Run { code, out, .. } = encoring(&["replay", "--model", "ce-65-m", "--print", "-"], content);
    assert_eq!((code, out.lines().count()), (Some(2), 2));
}

/// A rod that was programmed in an earlier life at position 0, and a CE-65-M with 8192 steps at 3.
fn recording() -> Vec<u8> {
    let mut rod = Unit::new(Model::La66, Sensor::Linear { rod_um: 300_000 }).unwrap();
    rod.service_times = ServiceTimes::ZERO;
    let mut programmed = Node::new(rod);
    for (at, out) in [0, 0xC200_1000].into_iter().enumerate() {
        programmed.step(Instant(at as u64), OutWord(out), &Surroundings::default());
    }
    let memory: Eeprom = programmed.memory_at_power_off();
    let shaft = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }).unwrap();
    let new = Node::new(shaft).memory().clone();

    let devices = [device_line::to_device(0, &rod, &memory), device_line::to_device(3, &shaft, &new)];
    let mut nodes = [(0, Node::with_memory(rod, memory)), (3, Node::with_memory(shaft, new))];
    let mut writer = Writer::recording(Vec::new(), &devices).unwrap();
    for cycle in 0..50_u32 {
        for (position, node) in &mut nodes {
            let out = if cycle % 30 < 20 { 0 } else { 0x8200_0000 };
            let mut row = Row {
                position: Some(*position),
                time_ns: u64::from(cycle) * 500_000,
                out: Some(out),
                raw: i64::from(cycle) * 1000,
                ..Row::default()
            };
            row.input = play(node, &row);
            writer.write(&row).unwrap();
        }
    }
    writer.into_inner()
}

#[test]
fn every_encoder_of_a_recording_replays_from_its_memory() {
    let (_directory, path) = file("two.csv", recording());
    for options in ["--at 0", "--at 3", "--at 0 --model la-66 --rod-mm 300", "--at 3 --native 8192"] {
        let Run { code, out, err } = replay(options, &path);
        assert_eq!(
            (code, out.as_str(), err.as_str()),
            (Some(0), "50 rows, 0 differences\n", ""),
            "{options}"
        );
    }
    let printed = replay("--at 0 --print", &path).out;
    let (_directory, printed) = file("one.csv", printed);
    assert_eq!(replay("--at 0", &printed).out, "50 rows, 0 differences\n");
}

#[test]
fn a_recording_says_which_encoders_it_has_and_what_contradicts_them() {
    let (_directory, path) = file("two.csv", recording());
    let refuses = |options: &[&str], message: &str| {
        refused(&[&["replay", path.as_str()][..], options].concat(), b"", message);
    };
    refuses(&[], &format!("error: {path} is a recording: choose an encoder with --at; positions: 0, 3"));
    refuses(&["--at", "1"], &format!("error: --at 1: {path} has no encoder there; positions: 0, 3"));
    for (at, option, value) in [
        ("0", "--model", "ce-65-m"),
        ("0", "--rod-mm", "500"),
        ("0", "--native", "4096"),
        ("0", "--service-times", "default"),
    ] {
        refuses(
            &["--at", at, option, value],
            &format!(
                "error: {option} contradicts the recording: it holds a la-66 with a rod of 300.000 mm and service \
                 times of 0 ns, 0 ns, 0 ns and 0 ns; leave the option out"
            ),
        );
    }
    refuses(
        &["--at", "0", "--stale-service", "executed"],
        "error: --stale-service contradicts the recording: it holds a la-66 with a rod of 300.000 mm and service \
         times of 0 ns, 0 ns, 0 ns and 0 ns, and a stale service bit is ignored; leave the option out",
    );
    let content = b"# encoring-trace 1\n# device 0 ce-65-m memory=00\nposition\n0\n";
    refused(
        &["replay", "--at", "0", "-"],
        content,
        "error: standard input line 2: device 0: the memory image has 1 bytes, an encoder has 512",
    );
    let unit = Unit::new(Model::Ce65M, Q4096).unwrap();
    let line =
        device_line::to_device(0, &unit, &Eeprom::blank()).to_string().replace("native=4096", "native=x");
    refused(
        &["replay", "--at", "0", "-"],
        format!("# encoring-trace 1\n{line}\nposition\n0\n").as_bytes(),
        "error: standard input line 2: device 0: setting native: \"x\" is not a whole number below 4294967296",
    );
}

#[test]
fn bytes_of_no_trace_never_break_it() {
    let good = std::fs::read(format!("{}/../../vectors/la-66.csv", env!("CARGO_MANIFEST_DIR"))).unwrap();
    for cut in [1, 10, 60, 70, 80, 85, 90] {
        let mut bad = good[..200].to_vec();
        bad[cut] = 0xFF;
        let code = encoring(&["replay", "--model", "la-66", "-"], &bad).code;
        assert_eq!(code, Some(2), "byte {cut}");
    }
}
