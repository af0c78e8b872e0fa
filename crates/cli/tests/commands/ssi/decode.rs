//! `encoring ssi decode`.

use std::fs::File;
use std::path::{Path, PathBuf};

use encoring_trace::capture::{CaptureFormat, CaptureWriter};
use serde_json::Value;

use crate::{Run, encoring};

/// Clock and data as somebody else would draw them: from digits, and no shift register.
struct Drawn {
    /// When, and clock in bit 0, data in bit 1.
    changes: Vec<(u64, u8)>,
    end: u64,
}

/// Transfers of these fields, so many clocks each.
fn drawn(fields: &[String], clocks: usize, khz: u64, delay: u64) -> Drawn {
    let half = 500_000 / khz;
    let mut edges = Vec::new();
    let mut at = 50_000;
    for field in fields {
        let bits: Vec<bool> =
            field.chars().chain(std::iter::repeat('0')).take(clocks).map(|bit| bit == '1').collect();
        for (bit, number) in bits.iter().zip(0_u64..) {
            edges.push((at + 2 * half * number, 0, false));
            edges.push((at + 2 * half * number + half, 0, true));
            edges.push((at + 2 * half * number + half + delay, 1, *bit));
        }
        let last = at + 2 * half * (clocks as u64 - 1);
        edges.push((last + 20_001 + delay, 1, true));
        at = last + 60_000;
    }
    edges.sort_by_key(|(time, ..)| *time);
    let mut shown = 3;
    let mut changes = vec![(0, shown)];
    for (time, line, high) in edges {
        shown = if high { shown | 1 << line } else { shown & !(1 << line) };
        changes.push((time, shown));
    }
    Drawn { changes, end: at }
}

fn write(file: &Path, names: [&str; 2], samplerate: Option<u64>, drawn: &Drawn) {
    let format = CaptureFormat::of(file).unwrap();
    let mut writer = CaptureWriter::new(format, File::create(file).unwrap(), &names, 3, samplerate).unwrap();
    drawn.changes.iter().for_each(|(time, shown)| writer.change(*time, *shown).unwrap());
    writer.finish(drawn.end).unwrap();
}

fn fields(bits: usize) -> Vec<String> {
    (0..20_u32).map(|k| format!("{:0bits$b}", 9_999 + 37 * k)).collect()
}

struct Captures(tempfile::TempDir);

impl Captures {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, samplerate: Option<u64>, drawn: &Drawn) -> String {
        let file: PathBuf = self.0.path().join(name);
        write(&file, ["clock", "data"], samplerate, drawn);
        file.to_str().unwrap().to_owned()
    }

    /// A text as a file.
    fn text(&self, name: &str, text: &str) -> String {
        let file = self.0.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_owned()
    }
}

fn decode(file: &str, options: &[&str]) -> Run {
    encoring(&[&["ssi", "decode", file], options].concat(), b"")
}

fn transfers(run: &Run) -> Vec<Value> {
    run.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

// [R106..R112, R116] The same words from every format of a file.
#[test]
fn a_capture_is_decoded_alike_from_every_kind_of_file() {
    let captures = Captures::new();
    let drawn = drawn(&fields(25), 26, 500, 0);
    for (name, samplerate) in [
        ("a.vcd", None),
        ("a.csv", None),
        ("a.sr", Some(20_000_000)),
        ("b.csv", Some(20_000_000)),
        ("c.sr", Some(7_000_000)),
    ] {
        let run = decode(&captures.file(name, samplerate, &drawn), &["--bits", "25", "--format", "json"]);
        assert_eq!(run.code, Some(0), "{name}: {}", run.err);
        let found = transfers(&run);
        assert_eq!(found.len(), 20, "{name}");
        for (transfer, k) in found.iter().zip(0..) {
            let field = format!("{:025b}", 9_999 + 37 * k);
            assert_eq!((&transfer["field"], &transfer["clocks"]), (&field.into(), &26.into()), "{name}");
            assert_eq!(
                (&transfer["position"], &transfer["fault"]),
                (&(9_999 + 37 * k).into(), &Value::Null),
                "{name}"
            );
        }
        assert!(run.err.starts_with("note: clock is "), "{}", run.err);
    }
}

#[test]
fn the_text_has_words_positions_and_timing() {
    let captures = Captures::new();
    let mut all = fields(14);
    all[7] = "1".repeat(14) + "1";
    let file = captures.file("a.vcd", None, &drawn(&all, 15, 400, 30));
    let run = decode(&file, &["--bits", "14"]);
    assert_eq!(run.code, Some(1));
    insta::assert_snapshot!(run.out);
    let csv = decode(&file, &["--bits", "14", "--format", "csv"]);
    let lines: Vec<&str> = csv.out.lines().collect();
    assert_eq!(lines.len(), 21);
    assert_eq!(lines[..2], ["time_ns,clocks,field,position,fault", "50000,15,10011100001111,9999,"]);
    assert!(lines[8].ends_with(",15,11111111111111,,stuck_high"), "{}", lines[8]);
}

// [R117]
#[test]
fn every_single_flip_in_an_ak_40_word_is_noticed() {
    let captures = Captures::new();
    let digits = format!("{:031b}", 0x12_3456);
    let parity = if digits.matches('1').count() % 2 == 0 { "1" } else { "0" };
    let whole = digits + parity;
    let flipped = (0..32).map(|place| {
        let turned = if &whole[place..=place] == "1" { "0" } else { "1" };
        format!("{}{turned}{}", &whole[..place], &whole[place + 1..])
    });
    let all: Vec<String> = std::iter::once(whole.clone()).chain(flipped).collect();
    let run = decode(
        &captures.file("a.vcd", None, &drawn(&all, 33, 1_000, 0)),
        &["--bits", "31", "--format", "json"],
    );
    let found = transfers(&run);
    assert_eq!((&found[0]["position"], &found[0]["fault"]), (&0x12_3456.into(), &Value::Null));
    assert!(found[1..].iter().all(|transfer| transfer["fault"] == "parity"), "{}", run.out);
    assert_eq!((found.len(), run.code), (33, Some(1)));
}

// [R109] With a long cable the falling edge brings the bit before.
#[test]
fn with_a_long_cable_the_rising_edge_reads_what_the_falling_one_does_not() {
    let captures = Captures::new();
    let file = captures.file("a.vcd", None, &drawn(&fields(24), 25, 1_000, 650));
    let rising = decode(&file, &["--edge", "rising", "--format", "json"]);
    assert_eq!(rising.code, Some(0), "{}", rising.out);
    assert_eq!(transfers(&rising)[3]["position"], 9_999 + 3 * 37);
    let falling = decode(&file, &["--format", "json"]);
    assert_ne!(transfers(&falling)[3]["position"], 9_999 + 3 * 37);
}

#[test]
fn bad_captures_are_refused_with_the_place() {
    let captures = Captures::new();
    let good = captures.file("a.vcd", None, &drawn(&fields(24), 25, 500, 0));
    let text = std::fs::read_to_string(&good).unwrap();
    let refused = |file: &str, options: &[&str], message: &str| {
        let run = decode(file, options);
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{}", run.err);
        assert!(run.err.contains(message), "{}", run.err);
    };
    let scale = captures.text("scale.vcd", &text.replace("1 ns", "3 ns"));
    refused(
        &scale,
        &[],
        "scale.vcd line 1: timescale \"3 ns\": it is 1, 10 or 100 and s, ms, us, ns, ps or fs",
    );
    // A thousand times too slow: no transfer is whole, and no clock found.
    let slow = captures.text("slow.vcd", &text.replace("1 ns", "1 us"));
    refused(&slow, &[], "no line is clocked as an SSI");
    refused(
        &slow,
        &[],
        "Correct the time scale or the sample rate if it is wrong; name them with --clock NAME",
    );
    let still = captures.text("still.csv", "Time [s],a,b\n0,1,1\n1,1,1\n");
    refused(&still, &[], "no line is clocked as an SSI");
    refused(&still, &["--clock", "x", "--data", "b"], "--clock \"x\": ");
    refused(&captures.text("no.csv", "a,b\n1,1\n"), &[], "no.csv line 1: neither a column of times");
    refused(&captures.text("e.vcd", ""), &[], "e.vcd: the file is empty");
    refused("/nowhere/a.vcd", &[], "/nowhere/a.vcd: ");
    refused("crates", &[], "crates: a folder, no file");
    // Inverted, as the other wire of each pair shows it.
    let inverted: Vec<(u64, u8)> =
        drawn(&fields(24), 25, 500, 0).changes.iter().map(|(at, shown)| (*at, shown ^ 3)).collect();
    let other = captures.file("other.csv", None, &Drawn { changes: inverted, end: 2_000_000 });
    refused(&other, &[], "rests Low: Clock- was captured, or the lines are inverted");
}

#[test]
fn a_capture_that_breaks_off_is_decoded_up_to_there_and_its_last_transfer_is_cut() {
    let captures = Captures::new();
    let good = captures.file("a.vcd", None, &drawn(&fields(24), 25, 500, 0));
    let text = std::fs::read_to_string(&good).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let cut = captures.text("cut.vcd", &(lines[..lines.len() - 20].join("\n") + "\n#17"));
    let run = decode(&cut, &["--format", "json"]);
    let found = transfers(&run);
    assert_eq!((found.len(), run.code), (20, Some(0)), "{}", run.err);
    assert_eq!((&found[19]["fault"], &found[19]["position"]), (&"cut".into(), &Value::Null));
    assert!(
        run.err.contains(&format!("note: the file breaks off in line {}", lines.len() - 19)),
        "{}",
        run.err
    );
    let first = captures.text("first.vcd", &lines[..30].join("\n"));
    let run = decode(&first, &["--clock", "clock", "--data", "data"]);
    assert_eq!(run.code, Some(3), "{}", run.out);
}

#[test]
fn a_rate_beside_that_of_the_file_is_told_and_not_used() {
    let captures = Captures::new();
    let file = captures.file("a.csv", None, &drawn(&fields(24), 25, 500, 0));
    let plain = decode(&file, &["--format", "json"]);
    let run = decode(&file, &["--format", "json", "--samplerate", "1MHz"]);
    assert_eq!((run.code, &run.out), (plain.code, &plain.out));
    assert!(run.err.contains("a.csv has a time for each change; --samplerate is not used"), "{}", run.err);
    let session = captures.file("a.sr", Some(10_000_000), &drawn(&fields(24), 25, 500, 0));
    let run = decode(&session, &["--samplerate", "1MHz"]);
    assert!(
        run.err.contains("was sampled at 10000000 Hz; --samplerate with 1000000 Hz is not used"),
        "{}",
        run.err
    );
    assert!(!decode(&session, &["--samplerate", "10MHz"]).err.contains("--samplerate"));
}

#[test]
fn clock_and_data_are_found_whatever_they_are_called_and_asked_for_where_more_fit() {
    let captures = Captures::new();
    let drawn = drawn(&fields(24), 25, 500, 0);
    let swapped: Vec<(u64, u8)> =
        drawn.changes.iter().map(|(at, shown)| (*at, shown >> 1 | shown << 1 & 2)).collect();
    let file = captures.file("a.csv", None, &Drawn { changes: swapped, end: drawn.end });
    let run = decode(&file, &["--format", "json"]);
    assert_eq!(
        (run.err.as_str(), run.code),
        ("note: clock is \"data\", data is \"clock\": found by what they do\n", Some(0))
    );
    assert_eq!(transfers(&run)[0]["position"], 9_999);
    // The same data on a third line.
    let text = std::fs::read_to_string(captures.file("b.csv", None, &drawn)).unwrap();
    let thrice: String =
        text.lines().map(|line| format!("{line},{}\n", line.rsplit(',').next().unwrap())).collect();
    let run = decode(&captures.text("c.csv", &thrice.replacen("data,data", "data,more", 1)), &[]);
    assert_eq!(run.code, Some(2));
    assert!(
        run.err.contains("several lines may be clock and data; name them with --clock NAME --data NAME"),
        "{}",
        run.err
    );
}

#[test]
fn the_format_of_a_capture_is_guessed_and_what_cannot_be_told_is_listed() {
    let captures = Captures::new();
    let guess = |file: &str| {
        let run = encoring(&["ssi", "guess", file, "--format", "json"], b"");
        (run.code, serde_json::from_str::<Value>(&run.out).unwrap())
    };
    // A shaft at 7.3 steps a transfer, in Gray.
    let moving: Vec<String> =
        (0..120_u32).map(|k| 9_999 + k * 73 / 10).map(|at| format!("{:014b}", at ^ at >> 1)).collect();
    let (code, view) = guess(&captures.file("gray.sr", Some(10_000_000), &drawn(&moving, 16, 500, 0)));
    assert_eq!(code, Some(0), "{view}");
    let fit = serde_json::json!({
        "bits": 14, "code": "gray", "parity": null, "repetition": false, "leading_zeros": 0, "clocks_behind": 2
    });
    assert_eq!(view["fits"], serde_json::json!([fit]));
    assert_eq!((&view["edge"], &view["clocks"], &view["words"]), (&"either".into(), &16.into(), &120.into()));
    // The same with as many clocks as bits: there may be more bits.
    let (code, view) = guess(&captures.file("short.csv", None, &drawn(&moving, 14, 500, 0)));
    assert_eq!((code, &view["may_be_longer"]), (Some(3), &true.into()));
    // Late data, and AK-40.
    let ak40: Vec<String> = (0..120_u32)
        .map(|k| format!("{:031b}", 9_999 + k * 73 / 10))
        .map(|digits| if digits.matches('1').count() % 2 == 0 { digits + "1" } else { digits + "0" })
        .collect();
    let (code, view) = guess(&captures.file("late.vcd", None, &drawn(&ak40, 33, 1_000, 650)));
    assert_eq!(
        (code, &view["edge"], &view["fits"][0]["parity"]),
        (Some(0), &"rising".into(), &"odd".into()),
        "{view}"
    );
    // A shaft at rest.
    let still = vec![moving[0].clone(); 40];
    let (code, view) = guess(&captures.file("still.vcd", None, &drawn(&still, 16, 500, 0)));
    assert_eq!((code, &view["moved"]), (Some(3), &false.into()));
    let fits = view["fits"].as_array().unwrap();
    assert!(
        fits.iter().any(|fit| fit["code"] == "gray") && fits.iter().any(|fit| fit["code"] == "binary"),
        "{view}"
    );
}
