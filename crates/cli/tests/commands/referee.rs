//! `encoring referee`: every kind of input, both outputs, and what is refused.

use super::{Run, encoring, refused};
use encoring_host::referee::RULES;
use serde_json::Value;

/// A log of a write of 9999 to the measuring length. Between its rows lie 10 ms.
fn log(rows: &[(&str, &str)]) -> String {
    let mut log = "time_ms,out,in\n".to_owned();
    for (k, (out, input)) in rows.iter().enumerate() {
        log += &format!("{},{out},{input}\n", k * 10);
    }
    log
}

const RIGHT: [(&str, &str); 6] = [
    ("00000000", "00000064"),
    ("0200270F", "00000064"),
    ("8200270F", "00000064"),
    ("8200270F", "8200270F"),
    ("0200270F", "8200270F"),
    ("0200270F", "00000064"),
];

fn judged(arguments: &[&str], trace: &str) -> (Option<i32>, Vec<Value>) {
    let all = [&["referee", "-", "--format", "json"][..], arguments].concat();
    let Run { code, out, .. } = encoring(&all, trace.as_bytes());
    (code, out.lines().map(|line| serde_json::from_str(line).unwrap()).collect())
}

#[test]
fn a_right_log_has_no_finding_and_says_what_was_not_judged() {
    let (code, lines) = judged(&["--model", "ce-65-m"], &log(&RIGHT));
    assert_eq!((code, lines.len()), (Some(0), 1), "{lines:?}");
    assert_eq!(
        lines[0],
        serde_json::json!({"not_judged": ["torn_words", "next_before_end", "stale_service_bit"], "seen_from": "p"})
    );
}

#[test]
fn a_finding_has_every_key_of_the_document() {
    let mut rows = RIGHT;
    rows[1].0 = "00000000";
    let (code, lines) = judged(&["--model", "ce-65-m"], &log(&rows));
    // A log sees it only as suspected.
    assert_eq!(code, Some(0));
    assert_eq!(
        lines[0],
        serde_json::json!({
            "rule": "data_with_service_bit", "verdict": "suspected", "severity": "error", "position": 0,
            "first_us": 20_000, "last_us": 20_000, "count": 1, "out": "8200270F", "in": "8200270F",
            "statement": "R33", "seen_from": "p",
            "advice": "put out number and data with service bit 0, and raise the bit one PLC cycle later",
        })
    );
}

#[test]
fn a_request_may_be_given_up_after_the_time_that_is_given() {
    let rows = [
        ("00000000", "00000064"),
        ("0200270F", "00000064"),
        ("8200270F", "00000064"),
        ("8200270F", "00000064"),
        ("8200270F", "00000064"),
        ("0200270F", "00000064"),
        ("0200270F", "00000064"),
    ];
    for (after, code, rule) in [
        ("1s", 1, "dropped_before_acknowledgement"),
        ("40ms", 1, "dropped_before_acknowledgement"),
        ("30ms", 0, "withdrawn"),
    ] {
        let arguments = ["--model", "ce-65-m", "--seen-from", "c", "--withdrawn-after", after];
        let (found, lines) = judged(&arguments, &log(&rows));
        assert_eq!((found, lines[0]["rule"].as_str()), (Some(code), Some(rule)), "{after}: {lines:?}");
    }
}

#[test]
fn a_certain_error_is_exit_code_1_and_no_service_is_3() {
    let mut rows = RIGHT;
    for row in &mut rows[1..] {
        row.0 = if row.0.starts_with('8') { "87000000" } else { "07000000" };
        row.1 = if row.1.starts_with('8') { "A7000000" } else { "00000064" };
    }
    let (code, lines) = judged(&[], &log(&rows));
    assert_eq!(
        (code, &lines[0]["rule"], &lines[0]["verdict"]),
        (Some(1), &"unknown_service".into(), &"broken".into())
    );
    let (code, lines) = judged(&[], &log(&RIGHT[..2]));
    assert_eq!((code, lines.len()), (Some(3), 1));
}

/// What a ring sees of a word that is written in halves, the one with the service bit first.
const TORN: &str = "\
# encoring-bus 1
time_us,position,event,out,in,line,client,half,value
1000,2,cycle,00000000,00000064,good,,,
1100,2,write,,,,4,high,C600
2000,2,cycle,C6000000,00000064,good,,,
2100,2,write,,,,4,low,0005
3000,2,cycle,C6000005,C6000000,good,,,
4000,2,write,,,,4,both,46000005
5000,2,cycle,46000005,00000000,good,,,
";

#[test]
fn single_writes_show_a_torn_word_and_cycles_alone_do_not() {
    let (code, lines) = judged(&["--model", "ce-65-m"], TORN);
    assert_eq!((code, lines.len()), (Some(1), 2), "{lines:?}");
    assert_eq!((&lines[0]["rule"], &lines[0]["position"]), (&"torn_words".into(), &2.into()));
    assert_eq!(lines[1], serde_json::json!({"not_judged": [], "seen_from": "w"}));
    let cycles: String =
        TORN.lines().filter(|line| !line.contains("write")).map(|line| format!("{line}\n")).collect();
    let (_, lines) = judged(&["--model", "ce-65-m"], &cycles);
    assert!(lines.iter().all(|line| line["rule"] != "torn_words"), "{lines:?}");
    assert_eq!(lines.last().unwrap(), &serde_json::json!({"not_judged": ["torn_words"], "seen_from": "c"}));
}

#[test]
fn of_a_table_without_out_nothing_is_judged() {
    let (code, lines) = judged(&[], "time_ms,in\n0,00000064\n10,C200270F\n20,00000064\n");
    assert_eq!((code, lines.len()), (Some(3), 1), "{lines:?}");
    let names: std::collections::BTreeSet<_> = RULES.iter().map(|rule| rule.name()).collect();
    assert_eq!(lines[0]["not_judged"].as_array().unwrap().len(), names.len());
}

#[test]
fn a_table_with_a_column_line_is_seen_from_the_cycles() {
    let mut table = "time_ms,out,in,line\n".to_owned();
    for (k, (out, input)) in RIGHT.iter().enumerate() {
        table += &format!("{},{out},{input},good\n", k * 10);
    }
    let (code, lines) = judged(&[], &table);
    assert_eq!((code, &lines[0]["seen_from"]), (Some(0), &"c".into()));
    let (_, lines) = judged(&["--seen-from", "c"], &log(&RIGHT));
    assert_eq!(
        lines[0],
        serde_json::json!({"not_judged": ["torn_words", "stale_service_bit"], "seen_from": "c"})
    );
}

#[test]
fn a_recording_of_the_simulator_is_seen_from_the_exchanges() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ring.csv").to_str().unwrap().to_owned();
    let arguments = ["sim", "--for", "50ms", "--speed", "max", "--modbus", "off", "--record", &file];
    assert_eq!(encoring(&arguments, b"").code, Some(0));
    let Run { code, out, .. } = encoring(&["referee", &file], b"");
    assert_eq!(code, Some(3));
    assert_eq!(
        out,
        "no service was seen\nnot judged from here (x): torn_words, next_before_end, stale_service_bit\n"
    );
}

#[test]
fn what_cannot_be_judged_at_all_is_refused_with_its_place() {
    let bad = TORN.replace("2000,2,cycle", "2000,2,bicycle");
    refused(
        &["referee", "-"],
        bad.as_bytes(),
        "error: standard input line 5, column event: \"bicycle\" is not cycle or write",
    );
    refused(
        &["referee", "-", "--seen-from", "c"],
        TORN.as_bytes(),
        "error: standard input says itself what its columns are and where it was taken; leave --columns, --decimal, \
         --period and --seen-from out",
    );
    let backwards = TORN.replace("5000,2", "500,2");
    refused(
        &["referee", "-"],
        backwards.as_bytes(),
        "error: standard input line 9, column time_us: 500 is before 4000, the time of the previous row",
    );
}

#[test]
fn half_a_word_is_told_and_never_judged() {
    // A value without its half, a half without its value, and a cycle without its word: none of them is a zero.
    for (row, half, message) in [
        (
            "2100,2,write,,,,4,low,0005",
            "2100,2,write,,,,4,,0005",
            "error: standard input line 6, column value: \"0005\" is not 4 hex digits of the half that the row names, or 8 of both",
        ),
        (
            "2100,2,write,,,,4,low,0005",
            "2100,2,write,,,,4,low,",
            "error: standard input line 6, column value: \"\" is not 4 hex digits of the half that the row names, or 8 of both",
        ),
        (
            "2000,2,cycle,C6000000,",
            "2000,2,cycle,,",
            "error: standard input line 5, column out: \"\" is not a word: each cycle says what stood on OUT",
        ),
    ] {
        assert!(TORN.contains(row));
        refused(&["referee", "-"], TORN.replace(row, half).as_bytes(), message);
    }
    // The other half stood there before the file begins.
    let trace = TORN.replace("1000,2,cycle,00000000,00000064,good,,,\n", "");
    let Run { code, out, err } = encoring(&["referee", "-", "--model", "ce-65-m"], trace.as_bytes());
    assert_eq!((code, out.lines().count()), (Some(3), 2), "{out}");
    assert!(err.contains("position 2: 1 writes of half a word whose other half is not known"), "{err}");
    let table = "time_ms,out_high,out_low,in\n0,0000,0000,00000064\n10,8200,,00000064\n";
    let Run { code, err, .. } = encoring(&["referee", "-"], table.as_bytes());
    let told = "line 3, column \"out_high\": one half of a word is there and the other is not";
    assert!(code == Some(2) && err.contains(told), "{err}");
}

#[test]
fn a_table_that_runs_backwards_is_refused_and_across_a_pause_nothing_is_judged() {
    let mut rows = log(&RIGHT);
    rows += "5,0200270F,00000064\n";
    let Run { code, err, .. } = encoring(&["referee", "-"], rows.as_bytes());
    assert_eq!(code, Some(2));
    assert!(err.contains("line 8") && err.contains("before"), "{err}");
    // The bit rises, and an hour later it is down: what was between nobody saw.
    let mut rows = log(&vec![RIGHT[1]; 20]);
    rows += "200,8200270F,00000064\n3600000,0200270F,00000064\n3600010,0200270F,00000064\n";
    let Run { code, out, err } = encoring(&["referee", "-", "--model", "ce-65-m"], rows.as_bytes());
    assert_eq!((code, out.lines().count()), (Some(0), 2), "{out}");
    assert!(
        err.contains("position 0: 1 pauses far longer than usual: across them nothing is judged"),
        "{err}"
    );
}
