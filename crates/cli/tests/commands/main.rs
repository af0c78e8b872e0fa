//! The program, run as a user runs it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, reason = "a test may panic")]

mod cells;
mod decode;
mod diagnose;
mod drawn;
mod json;
mod master;
mod program;
mod referee;
mod referee_figures;
mod replay;
mod ring;
mod ssi;
mod workshop;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// The user's folder for states.
fn states() -> String {
    format!("{}/states-{}", env!("CARGO_TARGET_TMPDIR"), std::process::id())
}

/// What a run left behind.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

/// Runs `encoring` at the root of the workspace, with these arguments and this standard input.
fn encoring<S: AsRef<std::ffi::OsStr>>(arguments: &[S], input: &[u8]) -> Run {
    encoring_in(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")), arguments, input)
}

/// The same in another folder.
fn encoring_in<S: AsRef<std::ffi::OsStr>>(folder: &Path, arguments: &[S], input: &[u8]) -> Run {
    let mut child = Command::new(env!("CARGO_BIN_EXE_encoring"))
        .args(arguments)
        .current_dir(folder)
        // The journal of whoever runs the tests is left alone.
        .env("XDG_STATE_HOME", states())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stdin = child.stdin.take().expect("piped");
    let input = input.to_vec();
    // Beside the reading, so that neither waits for the other; a program that ends early reads no more.
    let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = child.wait_with_output().expect("the program ends");
    writer.join().expect("written");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

/// Asserts that the arguments are refused: exit code 2, nothing on standard output, and this first line.
fn refused(arguments: &[&str], input: &[u8], message: &str) {
    let Run { code, out, err } = encoring(arguments, input);
    assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments:?}: {err}");
    assert_eq!(err.lines().next(), Some(message), "{arguments:?}");
}
