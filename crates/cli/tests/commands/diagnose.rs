//! `encoring diagnose`: its inputs, both outputs, its exit codes, and what is refused.

use super::{Run, encoring, refused};
use serde_json::Value;
use std::path::Path;

/// A log of positions a millisecond apart.
fn log(words: impl IntoIterator<Item = u32>) -> String {
    let rows = (0..).zip(words).map(|(ms, word): (u32, u32)| format!("{ms},{word:08X}\n"));
    "time_ms,in\n".to_owned() + &rows.collect::<String>()
}

/// Even motion, with one row changed.
fn turning(at: u32, change: impl Fn(u32) -> u32) -> String {
    log((0..200).map(|k| if k == at { change(1_000 + 10 * k) } else { 1_000 + 10 * k }))
}

/// The same as a log has it: a decimal value stands last.
fn of_a_log(at: u32) -> String {
    let row = |k: u32| {
        let word = (100_000 + 10 * k) ^ if k == at { 1 << 20 } else { 0 };
        format!("{},0,0x{word:08X},ok,{word}\n", 1_000 * k)
    };
    let rows = (0..200).map(row).collect::<String>();
    format!("# encoring-log 2 started 2026-11-28T03:07:19Z\ntime_us,position,in,verdict,value\n{rows}")
}

fn diagnosed(arguments: &[&str], log: &str) -> (Option<i32>, Value) {
    let all = [&["diagnose", "-", "--format", "json"][..], arguments].concat();
    let Run { code, out, err } = encoring(&all, log.as_bytes());
    let report = serde_json::from_str(&out);
    assert!(report.is_ok(), "{out}{err}");
    (code, report.unwrap())
}

#[test]
fn even_motion_has_no_step_change_and_says_what_was_judged_and_what_could_not_be() {
    let (code, report) = diagnosed(&[], &turning(0, |word| word));
    assert_eq!((code, report["events"].as_array().map(Vec::len)), (Some(0), Some(0)));
    assert!(report["judged"][0].as_str().unwrap().contains("200 rows"), "{report}");
    assert!(report["limits"][0].as_str().unwrap().contains("no jump of up to"), "{report}");
}

#[test]
fn one_wrong_bit_is_a_fault_with_every_key_of_the_document() {
    let (code, report) = diagnosed(&[], &turning(100, |word| word ^ 1 << 20));
    assert_eq!(code, Some(1));
    let event = report["events"][0].as_object().unwrap();
    let keys: Vec<&str> = event.keys().map(String::as_str).collect();
    let mut documented = vec![
        "file",
        "line",
        "to_line",
        "count",
        "time_us",
        "position",
        "cause",
        "certainty",
        "alternatives",
        "apart",
        "evidence",
    ];
    documented.sort_unstable();
    assert_eq!(keys, documented);
    assert_eq!((event["cause"].as_str(), event["line"].as_u64()), (Some("single_bit"), Some(102)));
}

#[test]
fn a_preset_is_no_fault_and_a_jump_of_which_nothing_tells_is_exit_code_3() {
    let preset = log((0..200).map(|k| match k {
        0..100 => 5_000,
        100..110 => 0xC600_03E8,
        _ => 1_000,
    }));
    let (_, report) = diagnosed(&[], &preset);
    let causes: Vec<_> = report["events"].as_array().unwrap().iter().map(|event| &event["cause"]).collect();
    assert!(causes.contains(&&Value::from("preset")), "{report}");
    let slipped = log((0..200).map(|k| if k < 100 { 500_000 + 10 * k } else { 654_321 + 10 * k }));
    let (code, report) = diagnosed(&[], &slipped);
    assert_eq!((code, report["events"][0]["cause"].as_str()), (Some(3), Some("unclear")), "{report}");
}

#[test]
fn events_have_the_same_numbers_in_text_picture_and_page_over_all_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let [first, second, plot, page] = ["a.csv", "b.csv", "jumps.svg", "jumps.html"].map(file);
    let words = |k: u32| if k == 50 || k == 150 { (1_000 + 10 * k) ^ 1 << 20 } else { 1_000 + 10 * k };
    std::fs::write(&first, log((0..200).map(words))).unwrap();
    std::fs::write(&second, turning(100, |word| word ^ 1 << 20)).unwrap();
    let Run { out, .. } = encoring(&["diagnose", &first, &second, "--plot", &plot, "--report", &page], b"");
    let text = out.split_whitespace().collect::<Vec<_>>().join(" ");
    let (picture, page) = (std::fs::read_to_string(plot).unwrap(), std::fs::read_to_string(page).unwrap());
    for (number, file, line) in [(1, &first, 52), (2, &first, 152), (3, &second, 102)] {
        assert!(text.contains(&format!("{number}. {file} line {line}, ")), "{number}: {out}");
        assert!(picture.contains(&format!(">{number}</text>")), "{number}");
        assert!(page.contains(&format!("<tr><td>{number}<td>line {line}, ")), "{number}");
    }
}

// [R150, R151, R152, R153]
#[test]
fn a_jump_that_may_be_mechanical_or_electrical_has_the_causes_and_remedies_of_the_manual() {
    let Run { out, .. } = encoring(&["diagnose", "-"], turning(100, |word| word ^ 1 << 20).as_bytes());
    let text = out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in ["loose contacts", "shock modules", "twisted pairs", "plastic couplings"] {
        assert!(text.contains(part), "{part}: {out}");
    }
}

#[test]
fn what_an_ssi_receiver_printed_is_read_as_positions() {
    let rows = (0..50).map(|k| {
        let position = if k == 25 { 1 << 18 } else { 100 + k };
        format!("{},25,1,{position},\n", k * 1_000_000)
    });
    let csv = "time_ns,clocks,field,position,fault\n".to_owned() + &rows.collect::<String>();
    let (code, report) = diagnosed(&[], &csv);
    assert_eq!(report["events"][0]["line"].as_u64(), Some(27), "{report}");
    assert_ne!(code, Some(2));
}

#[test]
fn a_transfer_with_a_fault_is_no_position() {
    let rows = |fault: &str| {
        let row = |k: u32| match k {
            25 => format!("25000000,25,1,262144,{fault}\n"),
            _ => format!("{},25,1,{},\n", k * 1_000_000, 100 + k),
        };
        "time_ns,clocks,field,position,fault\n".to_owned() + &(0..50).map(row).collect::<String>()
    };
    for fault in ["parity", "clock_limit", "cut"] {
        let (code, report) = diagnosed(&[], &rows(fault));
        let judged = report["judged"][0].as_str().unwrap();
        assert!(judged.contains("50 rows, 49 of them positions"), "{judged}");
        assert_eq!((code, report["events"].as_array().map(Vec::len)), (Some(0), Some(0)), "{fault}");
    }
    let (code, report) = diagnosed(&[], &rows(""));
    assert_eq!((code, report["events"][0]["line"].as_u64()), (Some(3), Some(27)), "{report}");
}

/// A shaft that turns evenly; from row 50 on the ring stands for some rows, and the words of the master's memory with it.
fn stopped(rows: u32, status: &str, parameter: &str) -> String {
    let stops = 50..50 + rows;
    let row = |k: u32| {
        let stands = stops.contains(&k);
        let word = if stands { 50_490 } else { 50_000 + 10 * k };
        let said = if stands { format!("{status},{parameter}") } else { "00E0h,0".to_owned() };
        format!("{},{word:08X},{said}\n", 10 * k)
    };
    "time_ms,in,status,parameter\n".to_owned() + &(0..200).map(row).collect::<String>()
}

#[test]
fn a_jump_over_rows_in_which_the_master_says_that_the_ring_stood_is_a_gap_and_told_by_the_status() {
    for rows in [2, 5, 40, 100] {
        let (code, report) = diagnosed(&[], &stopped(rows, "00C4h", "0BE1h"));
        let event = &report["events"][0];
        assert_eq!((code, report["events"].as_array().map(Vec::len)), (Some(1), Some(1)), "{report}");
        assert_eq!((event["cause"].as_str(), event["certainty"].as_str()), (Some("frozen"), Some("certain")));
        assert_eq!((&event["line"], &event["to_line"]), (&52.into(), &(52 + rows).into()), "{report}");
        let evidence = event["evidence"].to_string();
        assert!(evidence.contains("00C4h (READY, ACTIVE, BUS) and parameter 0BE1h"), "{evidence}");
        let limits = report["limits"].to_string();
        assert!(limits.contains(&format!("{rows} rows hold no position, the first at line 52")), "{limits}");
    }
}

#[test]
fn a_word_of_no_cycle_is_no_position_and_a_break_behind_the_encoder_takes_none_from_it() {
    let zeros = |said: &str| {
        let row = |k: u32| match k {
            50..60 => format!("{},00000000,{said}\n", 10 * k),
            _ => format!("{},{:08X},00E0h,0\n", 10 * k, 50_000 + 10 * k),
        };
        "time_ms,in,status,parameter\n".to_owned() + &(0..200).map(row).collect::<String>()
    };
    // The ring stands; the last data cycle was faulty.
    for said in ["00C4h,0BE1h", "10E0h,0"] {
        let (code, report) = diagnosed(&[], &zeros(said));
        assert_eq!((code, report["events"].as_array().map(Vec::len)), (Some(0), Some(0)), "{report}");
        let judged = report["judged"][0].as_str().unwrap();
        assert!(judged.contains("200 rows, 190 of them positions"), "{judged}");
    }
    // The ring ends behind device 1, and this one is reached.
    let (_, report) = diagnosed(&[], &zeros("00E4h,0180h"));
    assert!(report["judged"][0].as_str().unwrap().contains("200 of them positions"), "{report}");
}

/// A simulated ring, recorded for a second.
fn recorded(folder: &Path) -> String {
    let file = folder.join("ring.csv").display().to_string();
    let sim = ["sim", "--for", "1s", "--speed", "max", "--modbus", "off", "--web", "off", "--record", &file];
    let Run { code, err, .. } = encoring(&sim, b"");
    assert_eq!(code, Some(0), "{err}");
    file
}

#[test]
fn a_recording_tells_model_and_scaling_of_each_encoder_by_its_memory() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path());
    let Run { code, out, .. } = encoring(&["diagnose", &file, "--format", "json"], b"");
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(code, Some(0), "{out}");
    let judged = report["judged"].to_string();
    for position in 0..3 {
        assert!(judged.contains(&format!("position {position}: 16777216 positions, as given")), "{judged}");
    }
    assert!(!report["limits"].to_string().contains("give --parameters"), "{report}");
}

#[test]
fn parameters_of_several_encoders_are_given_by_position_and_compared_with_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path());
    let kept = folder.path().join("kept.toml").display().to_string();
    let scaling = "[parameters]\nmeasuring_length = 9999\nnumerator = 4096\ndenominator = 1\n";
    std::fs::write(&kept, format!("version = 1\nmodel = \"ce-65-m\"\n\n{scaling}")).unwrap();
    let of = |position: &str| format!("{position}{kept}");
    let Run { out, err, .. } = encoring(&["diagnose", &file, "--parameters", &of("2=")], b"");
    assert!(
        err.contains("the memory in the recording has measuring_length = 16777215, --parameters says 9999"),
        "{err}{out}"
    );
    assert!(out.contains("position 2: 10000 positions, as given"), "{out}");
    for (arguments, said) in [
        (
            vec![of("")],
            "the recording is of a la-66, and --model or --parameters says ce-65-m; of several encoders",
        ),
        (vec![of("7=")], "--parameters 7=FILE: the recording has no position 7"),
        (vec![of("2="), of("2=")], "position 2 has a file already"),
    ] {
        let given = arguments.iter().flat_map(|argument| ["--parameters", argument]);
        let all: Vec<&str> = ["diagnose", &file].into_iter().chain(given).collect();
        let Run { code, err, .. } = encoring(&all, b"");
        assert_eq!((code, err.contains(said)), (Some(2), true), "{err}");
    }
}

#[test]
fn the_head_of_a_log_tells_the_model_and_the_end_of_the_range() {
    let head = "# encoring-log 2 started 2026-11-28T01:22:00Z\n# encoder 2 ce-65-m measuring_length=9999\n";
    let rows = (0..200).map(|k| format!("{},2,,0x{:08X},valid,\n", k * 1_000, (9_500 + 10 * k) % 10_000));
    let log = head.to_owned() + "time_us,position,out,in,verdict,value\n" + &rows.collect::<String>();
    let (code, report) = diagnosed(&[], &log);
    assert_eq!((code, report["events"][0]["certainty"].as_str()), (Some(0), Some("certain")), "{report}");
    assert!(report["judged"].to_string().contains("10000 positions, as given"), "{report}");
    let Run { code, err, .. } = encoring(&["diagnose", "-", "--model", "la-66"], log.as_bytes());
    assert_eq!((code, err.contains("the recording is of a ce-65-m")), (Some(2), true), "{err}");
}

#[test]
fn a_known_place_that_no_row_is_near_is_told_and_no_time_of_the_day_is_refused() {
    let (_, report) = diagnosed(&["--known", "90s = 1000"], &turning(0, |word| word));
    let limits = report["limits"].to_string();
    assert!(
        limits.contains("the known place 1000 at 90 s was not compared: no row is near that time"),
        "{limits}"
    );
    for (known, said) in [
        ("12:61 = 3", "12:61: 61 is above 59"),
        ("12:00:00.1234567890 = 3", "1234567890 has more digits than nanoseconds, 9"),
    ] {
        let Run { code, err, .. } = encoring(&["diagnose", "-", "--known", known], b"");
        assert_eq!((code, err.contains(said)), (Some(2), true), "{err}");
    }
}

#[test]
fn a_jump_is_told_with_what_the_other_encoders_did() {
    let rows = (0..200).flat_map(|k| {
        let word = |position: u32| if (position, k) == (1, 100) { 1_000 ^ 1 << 20 } else { 1_000 + 10 * k };
        [0, 1].map(|position| format!("{},{position},{:08X}\n", k * 10, word(position)))
    });
    let (_, report) = diagnosed(&[], &("time_ms,position,in\n".to_owned() + &rows.collect::<String>()));
    let evidence = report["events"][0]["evidence"].to_string();
    assert!(evidence.contains("no other encoder of the recording has an event at that time"), "{report}");
}

/// Two encoders of one axis, which turns and stands; their positions behind a pause of two seconds, and whether the second has one.
fn of_one_axis(moved: u32, behind: [u32; 2], has_pause: bool) -> Vec<(u64, Value)> {
    let row = |k: u32| {
        let before = 10 * k.min(moved);
        let is_paused = (200..400).contains(&k);
        let words = match k {
            0..400 => [20_000 + before, 50_000 + before],
            _ => behind,
        };
        let one = |position: u32, word: u32| format!("{},{position},{word:08X}\n", 10 * k);
        let first = if is_paused { String::new() } else { one(3, words[0]) };
        let second = if is_paused && has_pause { String::new() } else { one(5, words[1]) };
        first + &second
    };
    let rows = (0..600).map(row).collect::<String>();
    let (_, report) = diagnosed(&[], &("time_ms,position,in\n".to_owned() + &rows));
    let events = report["events"].as_array().unwrap().clone();
    let lost = events.into_iter().filter(|event| event["cause"] == "zero_lost");
    lost.map(|event| (event["position"].as_u64().unwrap(), event)).collect()
}

#[test]
fn a_zero_that_was_lost_shows_by_the_offset_to_an_encoder_that_moved_together_with_it() {
    // The axis stood: one is where it was, the other is not.
    let lost = of_one_axis(150, [21_500 + 3 * 4_096, 51_500], true);
    assert_eq!((lost.len(), lost[0].0), (1, 3), "{lost:?}");
    let event = &lost[0].1;
    assert_eq!((&event["certainty"], &event["line"]), (&"likely".into(), &402.into()), "{event}");
    let evidence = event["evidence"].to_string();
    assert!(evidence.contains("the offset to position 5 differs by 12288 steps"), "{evidence}");
    let lost = of_one_axis(150, [21_500, 51_500 - 4_096], true);
    assert_eq!((lost.len(), lost[0].0), (1, 5), "{lost:?}");
    // One had no pause, and may have moved meanwhile.
    let lost = of_one_axis(150, [21_500 + 4_096, 51_500], false);
    assert_eq!((lost.len(), lost[0].0), (1, 3), "{lost:?}");
}

#[test]
fn no_zero_was_lost_where_the_offset_is_the_same_or_both_or_none_may_have_moved() {
    for (moved, behind) in [
        (150, [21_500, 51_500]),
        (150, [25_500, 55_500]),
        // Both are elsewhere: nothing tells which of them is wrong.
        (150, [25_500, 60_000]),
        // They were never seen to move together.
        (0, [20_000 + 4_096, 50_000]),
    ] {
        assert_eq!(of_one_axis(moved, behind, true), [], "{moved} {behind:?}");
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_line_and_column() {
    let begins =
        "error: standard input line 3, column time_us: 1000 is before 2000, the time of the previous row";
    refused(&["diagnose", "-"], b"time_us,in\n2000,00000064\n1000,00000065\n", begins);
    let Run { code, out, .. } = encoring(&["diagnose", "-"], b"time_us,in\n");
    assert_eq!((code, out.starts_with("nothing could be judged")), (Some(3), true), "{out}");
    let Run { code, out, .. } = encoring(&["diagnose", "-"], b"time_us,in\n0,00000064\n");
    assert_eq!(code, Some(3), "{out}");
    assert!(out.contains("nothing can be judged") && !out.contains("no step change"), "{out}");
    let rows = b"time_us,in\n0,00000064\n".as_slice();
    for speed in ["--max-rpm", "--max-mm-s"] {
        let Run { code, err, .. } = encoring(&["diagnose", "-", speed, "0"], rows);
        assert_eq!((code, err.contains("0 is below 1; give 1 to 16777215")), (Some(2), true), "{err}");
    }
    for file in ["--report", "--plot"] {
        let Run { code, err, .. } = encoring(&["diagnose", "-", file, "no/such/folder/x"], rows);
        assert_eq!((code, err.contains("there is no folder no/such/folder")), (Some(2), true), "{err}");
    }
}

#[test]
fn a_half_line_at_the_end_is_named_and_the_whole_lines_are_judged() {
    for whole in [turning(50, |word| word ^ 1 << 20), of_a_log(50)] {
        let (last, _) = whole.trim_end().rsplit_once('\n').unwrap();
        let number = last.lines().count() + 1;
        let cells = last.lines().last().unwrap().split(',').count();
        for (half, wrong) in [
            ("101", format!("line {number}: 1 cell, the header has {cells}; the file ends within this line")),
            ("10x", format!("line {number}: 1 cell, the header has {cells}; the file ends within this line")),
        ] {
            let (code, report) = diagnosed(&[], &format!("{last}\n{half}"));
            assert_eq!((code, report["events"].as_array().unwrap().len()), (Some(1), 1), "{report}");
            assert_eq!(report["events"][0]["cause"], "single_bit", "{report}");
            let limit = report["limits"][0].as_str().unwrap();
            assert!(
                limit.starts_with("a half line at the end is left out: ") && limit.contains(&wrong),
                "{limit}"
            );
        }
        // Nothing shows whether a line that has all its cells is whole: a row more, and never a jump.
        let whole = whole.trim_end();
        for cut in 1..6 {
            let (code, report) = diagnosed(&[], &whole[..whole.len() - cut]);
            assert_eq!((code, report["events"].as_array().unwrap().len()), (Some(1), 1), "{report}");
        }
    }
}

#[test]
fn a_half_line_that_is_not_the_last_is_refused() {
    let begins = "error: standard input line 3: 1 cell, the header has 2; a remark must begin with #";
    refused(&["diagnose", "-"], b"time_us,in\n2000,00000064\n3000\n4000,00000065\n", begins);
}

#[test]
fn what_is_wrong_in_a_half_line_is_named_with_its_column() {
    let rows = (0..40).map(|k| format!("{};{:08X}\n", k * 10, 1_000 + k * 30)).collect::<String>();
    let (code, report) = diagnosed(&[], &format!("t [ms];in\n{rows}400;0000"));
    let limit = report["limits"][0].as_str().unwrap();
    assert_eq!(code, Some(0), "{report}");
    assert!(limit.contains("line 42, column \"in\": 0000"), "{limit}");
}
