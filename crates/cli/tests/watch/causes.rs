//! Jumps that no machine makes, and the causes that are told of them.

use super::*;

#[test]
fn what_a_machine_does_at_most_is_refused_where_nothing_can_be_judged_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let rod = "version = 1\nmodel = \"la-66\"\n[parameters]\nmeasuring_length = 50000\n";
    fs::write(folder.path().join("rod.toml"), rod).unwrap();
    let common = ["watch", "--bus", &address, "--for", "50ms"];
    let of_rod = ["--at", "0", "--parameters", "rod.toml", "--max-mm-s"];
    for (arguments, message) in [
        (
            &["--at", "0", "--model", "la-66", "--max-rpm", "100"][..],
            "--max-rpm: none of these encoders is a shaft",
        ),
        (
            &["--at", "1", "--model", "ce-100-m", "--max-mm-s", "100"],
            "--max-mm-s: none of these encoders is a rod",
        ),
        (
            &["--at", "1", "--model", "ce-100-m", "--rod-mm", "100"],
            "--rod-mm: none of these encoders is a rod",
        ),
        (
            &["--at", "1", "--model", "ce-100-m", "--max-rpm", "100"],
            "--max-rpm: the scaling of no shaft here is known, so no movement can be judged; give its parameters",
        ),
        (
            &["--at", "0", "--model", "la-66", "--max-mm-s", "100", "--rod-mm", "500"],
            "--max-mm-s: the scaling of no rod here is known",
        ),
        (
            &[&of_rod[..], &["100"]].concat(),
            "--max-mm-s: the length of the rod at position 0 is not known; give it with",
        ),
        (&[&of_rod[..], &["100", "--rod-mm", "500,500"]].concat(), "--rod-mm: 2 values for 1 encoders"),
    ] {
        let said = refused(folder.path(), 2, &[&common[..], arguments].concat());
        assert!(said.starts_with(&format!("error: {message}")), "{said}");
    }
    let good = run(folder.path(), &[&common[..], &of_rod, &["100", "--rod-mm", "500"]].concat());
    assert_eq!(good.status.code(), Some(0), "{}", text(&good.stderr));
    let said = refused(folder.path(), 2, &["watch", "--bus", "sim", "--rod-mm", "500"]);
    assert_eq!(said, "error: --rod-mm: a simulated ring knows its rods; leave the option out\n");
    sim.end("-TERM");
}

/// A rod whose magnet is put elsewhere.
const JUMP: &str = "version = 1\n[[device]]\nposition = 0\nmodel = \"la-66\"\nmotion = { kind = \"hold\", raw = 125_000 }\n\
                    [[event]]\nat_s = 1.0\nposition = 0\nset = { raw = 250_000 }\n";

#[test]
fn a_rod_jumps_only_for_whoever_says_how_fast_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("jump.toml"), JUMP).unwrap();
    let log = |file: &str, more: &[&str]| {
        let arguments = ["log", file, "--bus", "sim:jump.toml", "--for", "2s", "--speed", "max"];
        text(&run(folder.path(), &[&arguments[..], more].concat()).stdout)
    };
    assert!(log("a.csv", &[]).ends_with(": valid 200\n"));
    let jumped = log("b.csv", &["--max-mm-s", "1000"]);
    assert!(jumped.ends_with(", implausible_speed 100\n"), "{jumped}");
    let file = fs::read_to_string(folder.path().join("b.csv")).unwrap();
    assert!(file.contains("position 0: nothing permissible moves from 12500 to 25000 within "), "{file}");
    assert!(!file.contains("kill"), "{file}");
    assert!(file.contains("# event cause: "), "{file}");
}

#[cfg(unix)]
#[test]
fn the_cause_of_a_jump_stands_in_lines_for_people_and_programs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("jump.toml"), JUMP).unwrap();
    // Until it is told, however slowly the polls come.
    let told = |format: &str, part: &str| {
        let arguments = ["watch", "--bus", "sim:jump.toml", "--max-mm-s", "1000", "--format", format];
        let mut watch = Running::start(folder.path(), &arguments);
        let mut line = watch.line();
        while !line.contains(part) {
            line = watch.line();
        }
        watch.end("-INT");
        line
    };
    let line = told("text", "position 0: cause of the jump: cannot be told, possible: ");
    assert!(line.contains("; or mechanical, preset, other_source; to tell: "), "{line}");
    let line = told("json", r#""event":"cause""#);
    let event: Value = serde_json::from_str(&line).unwrap();
    assert_eq!(event["cause"], "unclear");
    assert_eq!(event["certainty"], "possible");
    assert_eq!(event["alternatives"], serde_json::json!(["mechanical", "preset", "other_source"]));
}

#[cfg(unix)]
#[test]
fn a_signal_acknowledges_a_jump() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("jump.toml"), JUMP).unwrap();
    let arguments = ["--bus", "sim:jump.toml", "--max-mm-s", "1000"];
    let mut watch = Running::start(folder.path(), &[&["watch"][..], &arguments].concat());
    let pid = watch.program.id().to_string();
    let mut told = String::new();
    while !told.contains("; `kill -USR1 ") {
        told = watch.line();
    }
    assert!(told.contains(&format!("`kill -USR1 {pid}` acknowledges it")), "{told}");
    assert!(Command::new("kill").args(["-USR1", &pid]).status().unwrap().success());
    while !told.contains("position 0: the jump was acknowledged") {
        told = watch.line();
    }
    while !told.contains("25000  valid") {
        told = watch.line();
    }
    watch.end("-INT");
}
