use super::*;
use std::collections::BTreeMap;

const ROW: LogRow = LogRow {
    time_ns: 1_500,
    position: 2,
    out: Some(0xC200_270F),
    input: Some(0x0000_270F),
    verdict: "valid",
    value: Some(9_999),
    status: None,
    parameter: None,
};
const PLAIN: MasterColumns = MasterColumns { status: false, parameter: false };
const ROTATION: Rotation = Rotation { bytes: 1_000_000, time_ns: None, keep: 3 };

fn remarks() -> Vec<String> {
    vec!["started today".to_owned(), "bus a\nb".to_owned()]
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("axis.csv");
    (folder, file)
}

/// Every file of a folder.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let name = |entry: &fs::DirEntry| entry.file_name().into_string().unwrap();
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries.map(|entry| (name(&entry), fs::read_to_string(entry.path()).unwrap())).collect()
}

/// A log with rows of these times.
fn filled(path: &Path, rotation: Rotation, times: impl IntoIterator<Item = u64>) -> Log {
    let mut log = Log::create(path, &[], PLAIN, rotation).unwrap();
    for time_ns in times {
        log.write(&LogRow { time_ns, ..ROW }).unwrap();
    }
    log.flush().unwrap();
    log
}

fn times(file: &str) -> Vec<u64> {
    let rows = file.lines().skip(2).map(|line| line.split(',').next().unwrap());
    rows.map(|time| (time.parse::<f64>().unwrap() * 1_000.0).round() as u64).collect()
}

#[test]
fn a_row_has_what_was_seen_and_nothing_else() {
    let (folder, path) = folder();
    let mut log = Log::create(&path, &remarks(), PLAIN, ROTATION).unwrap();
    log.write(&ROW).unwrap();
    let unseen = LogRow { out: None, input: None, verdict: "no_answer", value: None, ..ROW };
    log.write(&LogRow { time_ns: 2_000, ..unseen }).unwrap();
    log.flush().unwrap();
    assert_eq!(
        files(folder.path())["axis.csv"],
        "# encoring-log 2 started today\n\
         # bus a b\n\
         time_us,position,out,in,verdict,value\n\
         1.5,2,0xC200270F,0x0000270F,valid,9999\n\
         2,2,,,no_answer,\n"
    );
    assert_eq!((log.rows(), log.files()), (2, 1));
}

#[test]
fn the_masters_registers_are_the_last_columns_and_what_happens_stands_between_the_rows() {
    let (folder, path) = folder();
    for (status, parameter, text) in [
        (true, true, ",status,parameter\n1.5,2,0xC200270F,0x0000270F,valid,9999,0x1094,0x0300\n"),
        (true, false, ",status\n1.5,2,0xC200270F,0x0000270F,valid,9999,0x1094\n"),
        (false, true, ",parameter\n1.5,2,0xC200270F,0x0000270F,valid,9999,0x0300\n"),
    ] {
        let mut log = Log::create(&path, &[], MasterColumns { status, parameter }, ROTATION).unwrap();
        log.remark("before\nthe first").unwrap();
        log.write(&LogRow { status: Some(0x1094), parameter: Some(0x0300), ..ROW }).unwrap();
        log.remark("the ring stands still").unwrap();
        log.write(&LogRow { time_ns: 2_000, ..ROW }).unwrap();
        log.flush().unwrap();
        let (header, row) = text.split_once('\n').unwrap();
        let unread = ",".repeat(usize::from(status) + usize::from(parameter));
        assert_eq!(
            files(folder.path())["axis.csv"],
            format!(
                "# encoring-log 2\ntime_us,position,out,in,verdict,value{header}\n# before the first\n{row}# the ring \
                 stands still\n2,2,0xC200270F,0x0000270F,valid,9999{unread}\n"
            )
        );
    }
}

#[test]
fn the_longest_row_fits() {
    let row = LogRow {
        time_ns: u64::MAX,
        position: usize::MAX,
        out: Some(u32::MAX),
        input: Some(u32::MAX),
        verdict: "implausible_acceleration_and_more",
        value: Some(u32::MAX),
        status: Some(u16::MAX),
        parameter: Some(u16::MAX),
    };
    assert!(
        print(&row, MasterColumns { status: true, parameter: true }, &mut [0; ROW_BYTES_MAX]).unwrap()
            < ROW_BYTES_MAX
    );
}

#[test]
fn full_files_take_turns_and_only_so_many_are_kept() {
    let (folder, path) = folder();
    // Each row has 27 to 30 bytes behind a head of 55.
    let log = filled(&path, Rotation { bytes: 140, ..ROTATION }, 0..20);
    assert_eq!((log.rows(), log.files()), (20, 10));
    let files = files(folder.path());
    let kept: Vec<_> = files.iter().map(|(name, file)| (name.as_str(), times(file))).collect();
    assert_eq!(
        kept,
        [
            ("axis.1.csv", vec![16, 17]),
            ("axis.2.csv", vec![14, 15]),
            ("axis.3.csv", vec![12, 13]),
            ("axis.csv", vec![18, 19]),
        ]
    );
    assert!(files.values().all(|file| file.starts_with("# encoring-log 2\n") && file.len() <= 140));
}

#[test]
fn a_file_has_a_row_however_small_it_must_be() {
    let (folder, path) = folder();
    filled(&path, Rotation { bytes: 0, keep: 1, ..ROTATION }, [1, 2, 3]);
    let files = files(folder.path());
    assert_eq!(times(&files["axis.csv"]), [3]);
    assert_eq!(times(&files["axis.1.csv"]), [2]);
}

#[test]
fn a_later_log_of_the_same_name_keeps_the_earlier_one() {
    let (folder, path) = folder();
    filled(&path, ROTATION, [1]);
    filled(&path, ROTATION, [2]);
    // Nothing is deleted as long as there is a gap.
    fs::rename(folder.path().join("axis.1.csv"), folder.path().join("axis.3.csv")).unwrap();
    filled(&path, ROTATION, [3]);
    filled(&path, ROTATION, [4]);
    let kept: Vec<_> = files(folder.path()).values().flat_map(|file| times(file)).collect();
    assert_eq!(kept, [3, 2, 1, 4]);
}

#[test]
fn what_is_no_log_is_left_as_it_is() {
    let (folder, path) = folder();
    let finished = folder.path().join("axis.2.csv");
    for foreign in ["time_us,out\n", "# encoring-trace 1\n", "#", "# encoring-lo"] {
        fs::write(&path, foreign).unwrap();
        let error = Log::create(&path, &[], PLAIN, ROTATION).unwrap_err();
        assert!(matches!(error.problem, LogProblem::Foreign), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), foreign);
    }
    fs::remove_file(&path).unwrap();
    filled(&path, ROTATION, [1]);
    filled(&path, ROTATION, [2]);
    fs::write(&finished, "a letter").unwrap();
    let before = files(folder.path());
    let error = Log::create(&path, &[], PLAIN, ROTATION).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "{}: it is there and holds no log, so it was left as it is",
            finished.canonicalize().unwrap().display()
        )
    );
    assert_eq!(files(folder.path()), before);
}

#[test]
fn a_foreign_file_that_turns_up_later_is_left_too_and_the_log_stays() {
    let (folder, path) = folder();
    let mut log = filled(&path, Rotation { bytes: 0, keep: 2, ..ROTATION }, [1, 2]);
    fs::write(folder.path().join("axis.1.csv"), "a letter").unwrap();
    let before = files(folder.path());
    let error = log.write(&ROW).unwrap_err();
    assert!(matches!(error.problem, LogProblem::Foreign), "{error}");
    assert_eq!(files(folder.path()), before);
}

#[test]
fn an_empty_file_is_used_and_a_folder_is_not() {
    let (folder, path) = folder();
    fs::write(&path, "").unwrap();
    filled(&path, ROTATION, [1]);
    assert_eq!(times(&files(folder.path())["axis.csv"]), [1]);
    let error = Log::create(folder.path(), &[], PLAIN, ROTATION).unwrap_err();
    assert!(matches!(error.problem, LogProblem::System { .. }), "{error}");
    let nowhere = folder.path().join("none/axis.csv");
    assert!(matches!(
        Log::create(&nowhere, &[], PLAIN, ROTATION).unwrap_err().problem,
        LogProblem::System { .. }
    ));
}

#[test]
fn two_cannot_write_the_same_log() {
    let (folder, path) = folder();
    let log = filled(&path, ROTATION, [1]);
    let error = Log::create(&path, &[], PLAIN, ROTATION).unwrap_err();
    assert!(matches!(error.problem, LogProblem::InUse), "{error}");
    assert_eq!(files(folder.path()).len(), 1);
    drop(log);
    filled(&path, ROTATION, [2]);
    assert_eq!(files(folder.path()).len(), 2);
}

#[test]
fn a_full_disk_is_told() {
    let full = Path::new("/dev/full");
    if !full.exists() {
        return;
    }
    let error = Log::create(full, &[], PLAIN, ROTATION).unwrap_err();
    assert!(error.to_string().starts_with("/dev/full: cannot write: "), "{error}");
}

#[test]
fn a_log_that_sees_nothing_costs_no_older_one_and_leaves_no_file() {
    let (folder, path) = folder();
    let unseen = LogRow { out: None, input: None, verdict: "no_answer", value: None, ..ROW };
    let blind = || {
        let mut log = Log::create(&path, &[], PLAIN, ROTATION).unwrap();
        for _ in 0..10 {
            log.write(&unseen).unwrap();
            log.flush().unwrap();
        }
        assert_eq!((log.rows(), log.files()), (0, 0));
    };
    drop(Log::create(&path, &[], PLAIN, ROTATION).unwrap());
    assert!(files(folder.path()).is_empty());
    filled(&path, ROTATION, [1]);
    let before = files(folder.path());
    for _ in 0..11 {
        blind();
    }
    assert_eq!(files(folder.path()), before);
    // The first word brings the rows before it along.
    let mut log = Log::create(&path, &[], PLAIN, ROTATION).unwrap();
    log.write(&LogRow { time_ns: 5_000, ..unseen }).unwrap();
    log.write(&LogRow { time_ns: 6_000, ..ROW }).unwrap();
    log.flush().unwrap();
    assert_eq!((times(&files(folder.path())["axis.csv"]), log.rows()), (vec![5_000, 6_000], 2));
    assert_eq!(files(folder.path())["axis.1.csv"], before["axis.csv"]);
}

#[test]
fn rows_without_a_word_are_logged_all_the_same_if_they_go_on() {
    let (folder, path) = folder();
    filled(&path, ROTATION, [1]);
    let mut log = Log::create(&path, &[], PLAIN, ROTATION).unwrap();
    for time_ns in 0..10_000 {
        log.write(&LogRow { time_ns, input: None, ..ROW }).unwrap();
    }
    log.flush().unwrap();
    assert_eq!((times(&files(folder.path())["axis.csv"]).len(), log.rows()), (10_000, 10_000));
}

#[test]
fn files_take_turns_after_a_time_too() {
    let (folder, path) = folder();
    let rotation = Rotation { time_ns: Some(1_000), ..ROTATION };
    filled(&path, rotation, [0, 500, 999, 1_000, 1_999, 5_000]);
    let kept: Vec<_> = files(folder.path()).values().map(|file| times(file)).collect();
    assert_eq!(kept, [vec![1_000, 1_999], vec![0, 500, 999], vec![5_000]]);
}

#[test]
fn what_is_deleted_next_is_known_from_the_start() {
    let (folder, path) = folder();
    let doomed = |rotation| Log::create(&path, &[], PLAIN, rotation).unwrap().doomed();
    let named = |name| Some(folder.path().canonicalize().unwrap().join(name));
    filled(&path, ROTATION, [1]);
    filled(&path, ROTATION, [2]);
    assert_eq!(doomed(ROTATION), None);
    assert_eq!(doomed(Rotation { keep: 1, ..ROTATION }), named("axis.1.csv"));
    filled(&path, ROTATION, [3]);
    assert_eq!(doomed(ROTATION), named("axis.2.csv"), "it is the third once the new log has a row");
    filled(&path, ROTATION, [4]);
    assert_eq!(doomed(ROTATION), named("axis.3.csv"));
}

#[test]
fn an_only_log_that_is_kept_is_known_to_be_deleted_next() {
    let (folder, path) = folder();
    let rotation = Rotation { keep: 1, ..ROTATION };
    assert_eq!(Log::create(&path, &[], PLAIN, rotation).unwrap().doomed(), None);
    filled(&path, rotation, [1]);
    let own = folder.path().canonicalize().unwrap().join("axis.csv");
    assert_eq!(Log::create(&path, &[], PLAIN, rotation).unwrap().doomed(), Some(own));
}

#[test]
#[cfg(unix)]
fn a_link_is_followed() {
    let (folder, path) = folder();
    let link = folder.path().join("link.csv");
    filled(&path, ROTATION, [1]);
    std::os::unix::fs::symlink(&path, &link).unwrap();
    filled(&link, ROTATION, [2]);
    let files = files(folder.path());
    assert_eq!(files.keys().collect::<Vec<_>>(), ["axis.1.csv", "axis.csv", "link.csv"]);
    assert_eq!(files["link.csv"], files["axis.csv"]);
}
