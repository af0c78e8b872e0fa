//! `encoring ssi capture` and `ssi sweep`: the simulated encoder.

use std::fs;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::{encoring, refused};

fn lines(out: &str) -> Vec<Value> {
    out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

// [R104..R112, R116, R117, R119] Every kind of file, and every kind of format, through the simulated encoder.
#[test]
fn what_is_captured_is_decoded_again() {
    let folder = tempfile::tempdir().unwrap();
    let formats: [&[&str]; 6] = [
        &["--bits", "24"],
        &["--bits", "25", "--code", "gray"],
        &["--bits", "14"],
        &["--bits", "31"],
        &["--bits", "31", "--firmware", "40/1997", "--code", "gray"],
        &["--repetition"],
    ];
    for (format, number) in formats.iter().zip(0..) {
        for (ending, more) in
            [("vcd", &[][..]), ("csv", &["--jitter", "30"]), ("sr", &["--samplerate", "10MHz"])]
        {
            let file = folder.path().join(format!("{number}.{ending}"));
            let file = file.to_str().unwrap();
            let arguments = ["ssi", "capture", "--out", file, "--for", "30ms"];
            let run = encoring(&[&arguments, *format, more].concat(), b"");
            assert_eq!(run.code, Some(0), "{format:?} {ending}: {}", run.err);
            let run = encoring(&[&["ssi", "decode", file, "--format", "json"], *format].concat(), b"");
            let found = lines(&run.out);
            assert!(
                (29..=31).contains(&found.len()) && run.code == Some(0),
                "{format:?} {ending}: {}",
                run.out
            );
            // The shaft moves upwards from 0; the same places, whatever the file.
            let positions: Vec<u64> = found.iter().map(|line| line["position"].as_u64().unwrap()).collect();
            assert!(positions.is_sorted() && positions[0] < positions[20], "{positions:?}");
        }
    }
}

#[test]
fn what_troubles_the_line_is_in_the_capture() {
    let folder = tempfile::tempdir().unwrap();
    let captured = |name: &str, options: &[&str], read: &[&str]| {
        let file = folder.path().join(name);
        let file = file.to_str().unwrap();
        let run = encoring(&[&["ssi", "capture", "--out", file, "--for", "50ms"], options].concat(), b"");
        assert_eq!(run.code, Some(0), "{}", run.err);
        let run = encoring(&[&["ssi", "decode", file, "--format", "json"], read].concat(), b"");
        (run.code, lines(&run.out))
    };
    let faults = |found: &[Value], fault: &str| found.iter().filter(|line| line["fault"] == fault).count();
    let (code, found) = captured("short.csv", &["--clocks", "20"], &[]);
    assert_eq!((code, faults(&found, "clocks")), (Some(1), found.len()));
    let (code, found) =
        captured("late.vcd", &["--ssi", "2=1000,25,1ms", "--skew", "650"], &["--edge", "rising"]);
    assert_eq!((code, faults(&found, "cut")), (Some(0), 0));
    let (code, found) =
        captured("stuck.csv", &["--fault", "ssi_low:2@10ms"], &["--clock", "clock", "--data", "data"]);
    assert!(code == Some(1) && faults(&found, "stuck_low") > 30, "{found:?}");
    let (code, found) =
        captured("flips.csv", &["--bits", "31", "--fault", "ssi_flips=20000:2"], &["--bits", "31"]);
    assert!(code == Some(1) && faults(&found, "parity") > 5, "{found:?}");
    let (code, _) = captured(
        "noise.csv",
        &["--noise", "20000"],
        &["--clocks", "25", "--clock", "clock", "--data", "data"],
    );
    assert_eq!(code, Some(1), "spikes are pulses too many or flips");
}

#[test]
fn a_capture_is_not_made_over_another_file_and_needs_an_encoder_with_an_ssi() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.sr");
    let file = file.to_str().unwrap();
    assert_eq!(encoring(&["ssi", "capture", "--out", file, "--for", "2ms"], b"").code, Some(0));
    let before = fs::read(file).unwrap();
    let again = encoring(&["ssi", "capture", "--out", file], b"");
    assert_eq!(again.code, Some(2));
    assert!(
        again.err.ends_with("it is there already; name a new one, or give --overwrite\n"),
        "{}",
        again.err
    );
    assert_eq!(fs::read(file).unwrap(), before);
    assert_eq!(encoring(&["ssi", "capture", "--out", file, "--overwrite"], b"").code, Some(0));
    let ending = "error: --out a.txt: the name of a capture ends in .vcd, .sr or .csv";
    refused(&["ssi", "capture", "--out", "a.txt"], b"", ending);
    let run = encoring(&["ssi", "capture", "--out", "b.sr", "--ssi", "0=500,25,1ms"], b"");
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("position 0 is a la-66, which has no SSI"), "{}", run.err);
    assert!(!std::path::Path::new("b.sr").exists());
}

// [R104, R111, R112, C20]
#[test]
fn a_sweep_tells_what_each_clock_rate_brings() {
    let swept = |options: &[&str]| {
        let run = encoring(&[&["ssi", "sweep", "--format", "json"], options].concat(), b"");
        (run.code, lines(&run.out).remove(0)["rates"].as_array().unwrap().clone())
    };
    for options in [&[][..], &["--bits", "31"], &["--bits", "14", "--code", "gray", "--edge", "rising"]] {
        let (code, rates) = swept(options);
        assert_eq!((code, rates.len()), (Some(0), 16), "{options:?}");
        for rate in &rates {
            let khz = rate["khz"].as_u64().unwrap();
            let meaning = match khz {
                ..50 => "the word breaks at t_M",
                50..80 => "works, not guaranteed",
                80..=1_000 => "guaranteed, works",
                _ => "outside the guarantee, works here",
            };
            assert_eq!(rate["meaning"], meaning, "{options:?} {rate}");
            assert_eq!(rate["wrong"], 0, "without a delay nothing is wrong: {rate}");
        }
    }
    // Late by more than half a period of 1 MHz, and of nothing slower than 900 kHz.
    let rates = ["--khz", "800", "--khz", "1000"];
    let (code, found) = swept(&[&["--delay", "550"][..], &rates].concat());
    assert_eq!((code, &found[0]["right"], &found[1]["right"]), (Some(1), &10.into(), &0.into()));
    let (code, found) = swept(&[&["--delay", "550", "--edge", "rising"][..], &rates].concat());
    assert_eq!((code, &found[1]["right"]), (Some(0), &10.into()));
    assert_eq!(swept(&["--khz", "60"]).0, Some(3), "nothing of what is guaranteed was tried");
}

#[test]
fn a_capture_that_is_interrupted_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("long.csv");
    let mut capture = Command::new(env!("CARGO_BIN_EXE_encoring"))
        .args(["ssi", "capture", "--for", "9000000s", "--out"])
        .arg(&file)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let files = || fs::read_dir(folder.path()).unwrap().count();
    while files() == 0 && capture.try_wait().unwrap().is_none() {}
    assert!(Command::new("kill").args(["-INT", &capture.id().to_string()]).status().unwrap().success());
    let output = capture.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(files(), 0, "{:?}", String::from_utf8(output.stderr));
}
