//! What `encoring log` writes, and how it ends.

use super::*;

#[test]
fn a_log_has_a_row_for_each_encoder_and_poll() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["log", "a.csv", "--bus", "sim", "--for", "10", "--speed", "max"];
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), "300 rows of 1000 polls in 9.999 s, 1 file: valid 3000\n");
    let file = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let head: Vec<_> = file.lines().take(8).collect();
    assert!(head[0].starts_with("# encoring-log 2 started 2"), "{}", head[0]);
    insta::assert_snapshot!("log", head[1..].join("\n"));
    assert_eq!(rows(&folder.path().join("a.csv")).len(), 300);
    // A second log keeps the first.
    let json = run(folder.path(), &[&arguments[..], &["--at", "2", "--format", "json"]].concat());
    let summary: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((&summary["rows"], &summary["polls"]), (&Value::from(100), &Value::from(1_000)));
    assert_eq!(summary["verdicts"], serde_json::json!([{ "verdict": "valid", "polls": 1_000 }]));
    assert_eq!(fs::read_to_string(folder.path().join("a.1.csv")).unwrap(), file);
}

#[test]
fn with_changes_only_what_differs_is_logged() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ring.toml"), STILL).unwrap();
    let arguments = ["log", "a.csv", "--bus", "sim:ring.toml", "--for", "10m", "--speed", "max", "--changes"];
    let output = run(folder.path(), &[&arguments[..], &["--every", "1s"]].concat());
    let summary = text(&output.stdout);
    assert!(
        summary.starts_with("1 rows of 60000 polls in ") && summary.ends_with(": valid 60000\n"),
        "{summary}"
    );
    assert_eq!(rows(&folder.path().join("a.csv")), ["0,0x00000000,0x000030D4,valid,12500"]);
}

#[test]
fn full_files_take_turns_and_the_oldest_goes() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["log", "a.csv", "--bus", "sim", "--for", "30", "--speed", "max", "--every", "0"];
    let output = run(folder.path(), &[&arguments[..], &["--rotate-mb", "1", "--keep", "2"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["a.1.csv", "a.2.csv", "a.csv"]);
    for name in ["a.1.csv", "a.2.csv"] {
        let length = fs::metadata(folder.path().join(name)).unwrap().len();
        assert!((999_900..=1_000_000).contains(&length), "{name} has {length}");
        assert!(
            fs::read_to_string(folder.path().join(name)).unwrap().starts_with("# encoring-log 2 started ")
        );
    }
    let last = text(&output.stdout);
    assert!(last.contains(" rows of 4431") && last.contains(" files: valid "), "{last}");
}

#[test]
fn what_is_no_log_is_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.csv"), "my figures\n").unwrap();
    let said = refused(folder.path(), 2, &["log", "a.csv", "--bus", "sim", "--for", "1", "--speed", "max"]);
    assert!(said.ends_with("a.csv: it is there and holds no log, so it was left as it is\n"), "{said}");
    assert_eq!(fs::read_to_string(folder.path().join("a.csv")).unwrap(), "my figures\n");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_full_disk_and_a_missing_folder_end_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let common = ["--bus", "sim", "--for", "1", "--speed", "max"];
    let said = refused(folder.path(), 3, &[&["log", "none/a.csv"][..], &common].concat());
    let why = "error: none/a.csv: cannot make the file: there is no folder none; make it first";
    assert!(said.starts_with(why), "{said}");
    if Path::new("/dev/full").exists() {
        let said = refused(folder.path(), 3, &[&["log", "/dev/full"][..], &common].concat());
        assert!(said.starts_with("error: /dev/full: cannot write: "), "{said}");
    }
}

#[test]
fn signals_end_a_log_with_everything_in_it() {
    let folder = tempfile::tempdir().unwrap();
    for signal in ["-INT", "-TERM"] {
        let log = Running::start(folder.path(), &["log", "a.csv", "--bus", "sim", "--every", "10ms"]);
        let file = folder.path().join("a.csv");
        // Rows come with the first flush.
        while !file.exists() || rows(&file).is_empty() {
            std::thread::yield_now();
        }
        let summary = log.end(signal);
        let counted = rows(&file).len();
        assert!(summary.starts_with(&format!("{counted} rows of ")), "{summary}, {counted} in the file");
        fs::remove_file(file).unwrap();
    }
}

#[test]
fn a_log_can_go_into_a_pipe_that_closes_early() {
    if !Path::new("/dev/stdout").exists() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["log", "/dev/stdout", "--bus", "sim", "--speed", "max", "--for"];
    let output = run(folder.path(), &[&arguments[..], &["1s"]].concat());
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!((output.status.code(), out.lines().count()), (Some(0), 36), "{out}");
    assert!(err.starts_with("30 rows of 100 polls"), "{err}");
    let mut log = Running::start(folder.path(), &[&arguments[..], &["1h"]].concat());
    log.line();
    drop(log.lines);
    assert_eq!(log.program.wait().unwrap().code(), Some(0));
}

#[test]
fn failed_polls_are_rows_without_words() {
    let folder = tempfile::tempdir().unwrap();
    let (sim, address) = gateway(folder.path());
    let at = ["--at", "0,2", "--model", "la-66,ce-65-m", "--every", "10ms", "--stale-after", "1m"];
    let log = Running::start(folder.path(), &[&["log", "a.csv", "--bus", &address][..], &at].concat());
    let file = folder.path().join("a.csv");
    let wait = |wanted: &str| {
        while !file.exists() || !rows(&file).iter().any(|row| row.contains(wanted)) {
            std::thread::yield_now();
        }
    };
    wait("2,0x00000000,");
    sim.end("-TERM");
    wait("0,,,no_answer_");
    let summary = log.end("-TERM");
    assert!(summary.contains("unchecked ") && summary.contains("no_answer_no_connection "), "{summary}");
    let head = fs::read_to_string(&file).unwrap();
    assert!(head.contains("# encoder 2 ce-65-m cannot_judge=code+range+motion\n"), "{head}");
}

/// Whether a program has begun to take the signal that `kill` sends first, number 15.
#[cfg(target_os = "linux")]
#[expect(clippy::disallowed_methods, reason = "the system's own file has a number in hex and nothing else")]
fn takes_signals(program: &Child) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(caught.trim(), 16).unwrap() & 1 << 14 != 0
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_log_into_a_pipe_that_nobody_reads() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reader, filler) = std::io::pipe().unwrap();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe")).status().unwrap().success());
    // The one is read for as much as it can hold, and then no more; the other is never opened for reading.
    for file in ["/dev/stdout", "pipe"] {
        let mut program = Command::new(PROGRAM)
            .current_dir(folder.path())
            .args(["log", file, "--bus", "sim", "--every", "0", "--speed", "max"])
            .stdout(filler.try_clone().unwrap())
            .spawn()
            .unwrap();
        while !takes_signals(&program) {
            assert_eq!(program.try_wait().unwrap(), None, "it has ended");
            std::thread::yield_now();
        }
        if file == "/dev/stdout" {
            reader.read_exact(&mut [0; 65_536]).unwrap();
        }
        let pid = program.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
        assert_eq!(program.wait().unwrap().code(), Some(0));
    }
    drop(reader);
}

#[cfg(unix)]
#[test]
fn a_log_that_no_longer_fits_ends_with_3_in_whole_rows() {
    let folder = tempfile::tempdir().unwrap();
    // A limit on the length of a file, in place of a full disk: 100 blocks of 512 bytes.
    let script = format!("ulimit -f 100; exec {PROGRAM} log a.csv --bus sim --every 0 --for 1h --speed max");
    let output = Command::new("sh").current_dir(folder.path()).args(["-c", &script]).output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.starts_with("error: ") && said.contains("a.csv: cannot write: "), "{said}");
    let log = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(log.ends_with('\n') && log.len() <= 51_200, "{}", log.len());
    let rows = rows(&folder.path().join("a.csv"));
    assert!(rows.len() > 100 && rows.iter().all(|row| row.split(',').count() == 5), "{:?}", rows.last());
}
