//! The master's commands on simulated rings. Through a gateway they are run by `.ci/foreign/master_through_bridge.py`.

use super::{Run, encoring, refused};
use std::fs;
use std::path::Path;

fn run(arguments: &str) -> Run {
    encoring(&arguments.split(' ').collect::<Vec<_>>(), b"")
}

fn json(arguments: &str, code: i32) -> serde_json::Value {
    let Run { code: ended, out, err } = run(&format!("{arguments} --format json"));
    assert_eq!(ended, Some(code), "{arguments}: {out}{err}");
    serde_json::from_str(&out).unwrap()
}

/// A standing CE-65-M and what happens to it.
fn ring(folder: &Path, more: &str) -> String {
    let file = folder.join("ring.toml");
    let device = "[[device]]\nposition = 0\nmodel = \"ce-65-m\"\nmotion = { kind = \"hold\", raw = 5000 }\n";
    fs::write(&file, format!("version = 1\n{device}{more}")).unwrap();
    format!("--bus sim:{} --at 0", file.display())
}

#[test]
fn what_is_programmed_is_read_by_name_and_by_number() {
    let text = run("read all --bus sim --at 0");
    insta::assert_snapshot!(text.out);
    let by_name = json("read measuring-length --bus sim --at 0", 0);
    assert_eq!(by_name["parameters"][0]["value"], 50_000);
    assert_eq!(json("read 02 --bus sim --at 0", 0), by_name);
}

#[test]
fn a_range_is_programmed_and_stays_in_the_encoders_memory() {
    let folder = tempfile::tempdir().unwrap();
    let bus = format!("{} --state {}", ring(folder.path(), ""), folder.path().join("memories").display());
    let done = run(&format!("program {bus} --yes rotary --steps-per-turn 1000 --turns 3.5"));
    assert_eq!(done.code, Some(0), "{}", done.err);
    insta::assert_snapshot!(done.out);
    let read = json(&format!("read all {bus}"), 0);
    let values: Vec<_> = read["parameters"].as_array().unwrap().iter().map(|row| &row["value"]).collect();
    assert_eq!(values, [0, 3_499, 35, 10, 24]);
    // 5000 steps of 4096 a turn.
    assert_eq!(read["shown"]["position"], 1_220);

    let preset = json(&format!("preset 100 {bus} --yes"), 0);
    assert_eq!((preset["before"].as_u64(), preset["after"].as_u64()), (Some(1_220), Some(100)));
    assert_eq!(json(&format!("read 02 {bus}"), 0)["shown"]["position"], 100);
}

#[test]
fn the_old_values_are_a_file_that_brings_them_back() {
    let folder = tempfile::tempdir().unwrap();
    let bus = format!("{} --state {}", ring(folder.path(), ""), folder.path().join("memories").display());
    let before = json(&format!("read all {bus}"), 0);
    let backup = folder.path().join("backup.toml");
    let done = json(&format!("write numerator 5000 {bus} --yes --backup {}", backup.display()), 0);
    assert_eq!(done["backup"], backup.display().to_string());
    let again = run(&format!("write numerator 4999 {bus} --yes --backup {}", backup.display()));
    assert_eq!(again.code, Some(2));
    assert!(
        again.err.contains("so nothing was written") && again.err.contains("it is there already"),
        "{}",
        again.err
    );
    assert_eq!(json(&format!("read 03 {bus}"), 0)["parameters"][0]["value"], 5_000);
    let back = json(&format!("program {bus} --yes --file {}", backup.display()), 0);
    assert_eq!(back["result"], "verified");
    assert_eq!(json(&format!("read all {bus}"), 0)["parameters"], before["parameters"]);
}

#[test]
fn a_backup_that_is_asked_for_is_written_whether_anything_differs_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let bus = format!("{} --state {}", ring(folder.path(), ""), folder.path().join("memories").display());
    let [same, dry, kept] =
        ["same.toml", "dry.toml", "kept.toml"].map(|name| folder.path().join(name).display().to_string());
    let done = json(&format!("write numerator 4096 {bus} --yes --backup {same}"), 0);
    assert_eq!(
        (done["result"].as_str(), done["backup"].as_str()),
        (Some("already_programmed"), Some(&*same))
    );
    let planned = json(&format!("write numerator 5000 {bus} --dry-run --backup {dry}"), 0);
    assert_eq!((planned["result"].as_str(), planned["backup"].as_str()), (Some("planned"), Some(&*dry)));
    let values = |file: &str| {
        let text = fs::read_to_string(file).unwrap();
        // But for the time at which it was taken.
        let of_both = |line: &&str| !line.starts_with('#') && !line.starts_with("at = ");
        text.lines().filter(of_both).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(values(&same), values(&dry));
    assert!(values(&same).iter().any(|line| line.starts_with("numerator = 4096")));
    // The same values once more are no reason to stop; the file is left as it is.
    let before = fs::read_to_string(&dry).unwrap();
    let done = json(&format!("write numerator 5000 {bus} --yes --backup {dry}"), 0);
    assert_eq!((done["result"].as_str(), fs::read_to_string(&dry).unwrap()), (Some("verified"), before));
    fs::write(&kept, "mine").unwrap();
    for more in ["--yes", "--dry-run"] {
        let refused = run(&format!("write numerator 4096 {bus} {more} --backup {kept}"));
        assert_eq!(refused.code, Some(2), "{}", refused.err);
        assert!(refused.err.contains("it is there already"), "{}", refused.err);
    }
    assert_eq!(fs::read_to_string(&kept).unwrap(), "mine");
    assert_eq!(json(&format!("read 03 {bus}"), 0)["parameters"][0]["value"], 5_000);
}

#[test]
fn what_calc_warns_of_is_in_the_question_and_in_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let bus = ring(folder.path(), "");
    let range = "rotary --steps-per-turn 1000 --turns 3.435353553";
    let asked = run(&format!("program {bus} {range}"));
    assert_eq!(asked.code, Some(2));
    let warnings = json(&format!("program {bus} --yes {range}"), 0)["warnings"].clone();
    let warnings: Vec<&str> =
        warnings.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
    for (topic, words) in [
        ("turns: ", "turns cannot be programmed"),
        ("rounded: ", "is the nearest whole number"),
        ("zero: ", "can be lost"),
        ("gray: ", "bits change at once"),
    ] {
        let warning = warnings.iter().find(|warning| warning.starts_with(topic) && warning.contains(words));
        let warning = warning.unwrap_or_else(|| panic!("{topic}{words}: {warnings:?}"));
        assert!(asked.err.contains(warning), "{warning}\n{}", asked.err);
    }
    for told in ["Then a data check follows", "the position may jump"] {
        assert!(asked.err.contains(told), "{}", asked.err);
    }
}

#[test]
fn a_ring_that_forgets_says_so_when_something_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    let state = format!(" --state {}", folder.path().display());
    let notes = |command: &str| {
        let err = run(&format!("{command} --bus sim --at 1")).err;
        let note = |line: &&str| {
            line.starts_with("note: ")
                && line.contains("--state DIR")
                && line.contains("--bus modbus-tcp://127.0.0.1:5020")
        };
        err.lines().filter(note).count()
    };
    for command in
        ["preset 5 --yes", "check --yes", "write numerator 5000 --yes", "write numerator 4096 --yes"]
    {
        assert_eq!(notes(command), 1, "{command}");
        assert_eq!(notes(&format!("{command}{state}")), 0, "{command}");
    }
    for command in
        ["read all", "write numerator 5000 --dry-run", "write numerator 5000 --dry-run --read-only"]
    {
        assert_eq!(notes(command), 0, "{command}");
    }
}

#[test]
fn an_error_that_was_pending_is_one_although_its_status_says_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let memories = folder.path().join("memories");
    let bus = format!("--bus sim --at 0 --state {}", memories.display());
    json(&format!("check {bus} --yes"), 0);
    // A memory that is gone: the LA-66 has no status bit for it.
    let file = memories.join("encoder-0.toml");
    let text = fs::read_to_string(&file).unwrap();
    let (head, rest) = text.split_once("memory = \"").unwrap();
    let (_, tail) = rest.split_once('"').unwrap();
    fs::write(&file, format!("{head}memory = \"{}\"{tail}", "FF".repeat(512))).unwrap();
    let lost = run(&format!("check {bus} --yes"));
    assert_eq!(lost.code, Some(1), "{}{}", lost.out, lost.err);
    let told = "error status 0000\nan error was pending and is over; the status does not tell which\n";
    assert!(lost.out.contains(told), "{}", lost.out);
}

#[test]
fn what_the_data_check_would_refuse_is_not_begun_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    let refused = run(&format!("write numerator 10 {} --yes", ring(folder.path(), "")));
    assert_eq!(refused.code, Some(1), "{}", refused.err);
    insta::assert_snapshot!(refused.out);
}

#[test]
fn a_memory_that_cannot_be_written_is_told_with_both_reasons_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let broken = "[[event]]\nat_s = 0.0\nposition = 0\nset = { eeprom = { fault = \"write\" } }\n";
    let refused = run(&format!("write numerator 5000 {} --yes", ring(folder.path(), broken)));
    assert_eq!(refused.code, Some(1), "{}", refused.err);
    assert!(refused.out.contains("it was repeated and refused again"), "{}", refused.out);
    assert!(refused.out.contains("defective memory area in the EEPROM, or a value outside its range"));
    assert!(refused.out.contains("error status 0002"), "{}", refused.out);
}

#[test]
fn an_encoder_without_supply_gives_no_answer() {
    let folder = tempfile::tempdir().unwrap();
    let off = "[[event]]\nat_s = 0.0\nposition = 0\nset = { supply_v = 0.0 }\n";
    let bus = ring(folder.path(), off);
    for command in ["read all", "check --yes", "preset 5 --yes", "write numerator 5000 --yes"] {
        let Run { code, out, err } = run(&format!("{command} {bus}"));
        assert_eq!(code, Some(3), "{command}: {out}{err}");
        let told = format!("{out}{err}");
        assert!(
            told.contains("this request was not sent") || told.contains("old: the ring has stopped"),
            "{command}: {told}"
        );
    }
}

#[test]
fn a_read_that_fails_is_told_from_a_zero() {
    let folder = tempfile::tempdir().unwrap();
    // After power-up, which would find it too.
    let broken = "[[event]]\nat_s = 0.001\nposition = 0\nset = { eeprom = { fault = \"read\" } }\n";
    let refused = run(&format!("read numerator {}", ring(folder.path(), broken)));
    assert_eq!(refused.code, Some(3), "{}", refused.err);
    assert!(refused.out.contains("03       numerator                  ?\n"), "{}", refused.out);
    let told = "it was repeated and refused again\nan error is pending now: `encoring check` tells which\n";
    assert!(refused.out.contains(told), "{}", refused.out);
}

#[test]
fn the_data_check_explains_what_was_pending_and_is_over() {
    let folder = tempfile::tempdir().unwrap();
    let memories = folder.path().join("memories");
    let bus = format!("{} --state {}", ring(folder.path(), ""), memories.display());
    let good = json(&format!("check {bus} --yes"), 0);
    assert_eq!((good["status_hex"].as_str(), good["remains"].as_bool()), (Some("0000"), Some(false)));
    // A memory that is gone is an error from the start.
    let file = memories.join("encoder-0.toml");
    let text = fs::read_to_string(&file).unwrap();
    let (head, _) = text.split_once("memory = \"").unwrap();
    fs::write(&file, format!("{head}memory = \"{}\"\n", "FF".repeat(512))).unwrap();
    let lost = run(&format!("check {bus} --yes"));
    assert_eq!(lost.code, Some(1));
    assert!(
        lost.out.contains("error status 0001") && lost.out.contains("was pending and is over"),
        "{}",
        lost.out
    );
}

#[test]
fn nothing_is_changed_without_a_question_or_against_read_only() {
    for command in ["write numerator 5000", "preset 5", "check"] {
        let asked = run(&format!("{command} --bus sim --at 1"));
        assert_eq!((asked.code, asked.out.as_str()), (Some(2), ""), "{command}");
        assert!(asked.err.contains("standard input is no terminal; pass --yes"), "{}", asked.err);
        let name = command.split(' ').next().unwrap();
        let message =
            format!("error: {name} changes the encoder, and --read-only refuses that; leave --read-only out");
        let arguments = format!("{command} --bus sim --at 1 --yes --read-only");
        refused(&arguments.split(' ').collect::<Vec<_>>(), b"", &message);
    }
    let message = "error: program changes the encoder, and --read-only refuses that; leave --read-only out";
    let arguments = "program --bus sim --at 1 --read-only --yes rotary --steps-per-turn 10 --turns 3";
    refused(&arguments.split(' ').collect::<Vec<_>>(), b"", message);
    assert_eq!(json("write numerator 5000 --bus sim --at 1 --dry-run", 0)["result"], "planned");
}

#[test]
fn bad_usage_names_the_value_and_what_is_allowed() {
    for (arguments, message) in [
        (
            "read all --at 1",
            "error: --bus ADDRESS is missing; --bus sim is the built-in ring, the others are in --help",
        ),
        ("read all --bus sim", "error: --at POSITION is missing; positions count from 0"),
        (
            "read all --bus sim --at 3",
            "error: --at 3: no encoder at position 3: the ring has 3, counted from 0",
        ),
        (
            "read all --bus sim --at 1 --model la-66",
            "error: --model la-66: the encoder at position 1 is a ce-100-m",
        ),
        (
            "read all --bus modbus-tcp://127.0.0.1:1 --at 1",
            "error: --model MODEL is missing: no word of an encoder shows its model, so read it from the type label",
        ),
        (
            "read all --bus modbus-tcp://127.0.0.1:1 --at 1 --state x",
            "error: --state is for simulated rings; a real encoder keeps its own memory",
        ),
        ("read preset-value-1 --bus sim --at 2", "error: a ce-65-m has no service 04 (preset value 1)"),
        ("write numerator 0 --bus sim --at 2 --yes", "error: revolutions numerator: 0 is outside 1..65535"),
        (
            "preset 50001 --bus sim --at 9 --yes",
            "error: --at 9: no encoder at position 9: the ring has 3, counted from 0",
        ),
        (
            "program --bus sim --at 1 --yes",
            "error: nothing to program is given: add --file FILE.toml, rotary ..., or linear ...",
        ),
        (
            "program --bus sim --at 0 --yes linear --length-mm 500 --resolution-mm 0.0000001",
            "error: 500 mm in steps of 0.0000001 mm are 5000000000 steps; allowed are 1..16777215 (FFFFFFh); nearest that works: --resolution-mm 0.000029803",
        ),
        (
            "program --bus sim --at 1 --yes linear --length-mm 500 --resolution-mm 0.1",
            "error: linear: a ce-100-m is a shaft, no rod; its range is `rotary`",
        ),
        (
            "program --bus sim --at 0 --yes rotary --steps-per-turn 1000 --turns 3",
            "error: rotary: a la-66 is a rod, no shaft; its range is `linear`",
        ),
        (
            "read 06 --bus sim --at 1",
            "error: invalid value '06' for '[PARAMETER|all]': service 06 is write only, and no parameter: use `encoring preset VALUE`",
        ),
        (
            "write 06 5 --bus sim --at 1",
            "error: invalid value '06' for '<PARAMETER>': service 06 is write only, and no parameter: use `encoring preset VALUE`",
        ),
        (
            "program --bus sim --at 1 --yes --file nowhere.toml",
            "error: nowhere.toml: No such file or directory",
        ),
    ] {
        refused(&arguments.split(' ').collect::<Vec<_>>(), b"", message);
    }
}

#[test]
fn a_gateway_that_is_not_there_is_no_answer() {
    let unused = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    for command in ["read all", "check --yes", "write numerator 5 --yes", "preset 1 --yes"] {
        let Run { code, out, err } =
            run(&format!("{command} --bus modbus-tcp://{unused} --at 0 --model ce-100-m"));
        assert_eq!((code, out.as_str()), (Some(3), ""), "{err}");
        assert!(err.contains("no connection: connection refused"), "{err}");
    }
    let probe = run(&format!("probe modbus-tcp://{unused}"));
    assert_eq!((probe.code, probe.out.as_str()), (Some(3), ""), "{}", probe.err);
}
