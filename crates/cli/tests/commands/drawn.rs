//! `encoring diagnose --plot` and `--report`.

use super::{Run, encoring_in};

/// A slow movement with one wrong bit in the middle.
fn log() -> String {
    let word = |k: u32| if k == 200 { (5_000 + 3 * k) ^ 1 << 19 } else { 5_000 + 3 * k };
    let rows = (0..400).map(|k| format!("{},{:08X}\n", k * 1_000, word(k)));
    format!("time_us,in\n{}", rows.collect::<String>())
}

#[test]
fn a_picture_and_a_page_show_the_jump_and_are_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    std::fs::write(folder.path().join("axis.csv"), log()).unwrap();
    let both = ["diagnose", "axis.csv", "--plot", "axis.svg", "--report", "axis.html"];
    let Run { code, err, .. } = encoring_in(folder.path(), &both, b"");
    assert_eq!((code, err.as_str()), (Some(1), ""));
    let (picture, page) = (at("axis.svg"), at("axis.html"));
    assert!(picture.contains(">line 202, ") && picture.contains("one wrong bit"), "{picture}");
    assert!(page.contains("<svg ") && page.contains("<td>line 202, ") && !page.contains("<script"), "{page}");

    // Before the recording is read: one that is not there is not missed.
    let missing = ["diagnose", "none.csv", "--plot", "axis.svg"];
    let Run { code, out, err } = encoring_in(folder.path(), &missing, b"");
    assert_eq!((code, out.as_str()), (Some(2), ""));
    assert!(
        err.contains("--plot axis.svg: it is there already; name a new one, or give --overwrite"),
        "{err}"
    );
    std::fs::write(folder.path().join("axis.svg"), "old").unwrap();
    let again = [&both[..], &["--overwrite"]].concat();
    assert_eq!(encoring_in(folder.path(), &again, b"").code, Some(1));
    assert_eq!((at("axis.svg"), at("axis.html")), (picture, page));
}

#[test]
fn a_pipe_is_drawn_as_a_file_is_and_several_files_are_one_picture_with_their_own_numbers() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("first.csv"), log()).unwrap();
    std::fs::write(folder.path().join("second.csv"), log()).unwrap();
    let run = |arguments: &[&str]| {
        let all = [&["diagnose"][..], arguments, &["--plot", "out.svg", "--overwrite"]].concat();
        assert_eq!(encoring_in(folder.path(), &all, log().as_bytes()).code, Some(1));
        std::fs::read_to_string(folder.path().join("out.svg")).unwrap()
    };
    let (piped, file) = (run(&["-"]), run(&["first.csv"]));
    assert_eq!(piped, file.replace("first.csv", "standard input"));
    let both = run(&["first.csv", "second.csv"]);
    assert_eq!(both.matches(">2</text>").count(), 3, "{both}");
}
