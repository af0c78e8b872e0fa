//! What all commands share: help, version, completions, bad usage.

use super::{Run, encoring};
use std::process::{Command, Stdio};

#[test]
fn it_knows_its_version() {
    let Run { code, out, .. } = encoring(&["-V"], b"");
    assert_eq!((code, out), (Some(0), format!("encoring {}\n", env!("CARGO_PKG_VERSION"))));
    let Run { code, out, .. } = encoring(&["--version"], b"");
    let lines: Vec<_> = out.lines().collect();
    assert_eq!((code, lines[0]), (Some(0), &*format!("encoring {}", env!("CARGO_PKG_VERSION"))));
    assert!(lines[1].starts_with("commit ") && lines[2].starts_with("built for "), "{out}");
    assert!(lines[3].starts_with("features: ") && lines.len() == 4, "{out}");
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let Run { code, out, .. } = encoring(&["man", folder.path().to_str().unwrap()], b"");
    assert_eq!((code, &*out), (Some(0), ""));
    for page in ["encoring.1", "encoring-sim.1", "encoring-ssi-decode.1"] {
        let page = std::fs::read_to_string(folder.path().join(page)).unwrap();
        assert!(page.contains(".SH SYNOPSIS"), "{page}");
    }
    let none = folder.path().join("none");
    let Run { code, err, .. } = encoring(&["man", none.to_str().unwrap()], b"");
    assert!(code == Some(2) && err.contains("not a folder; make it first"), "{err}");
}

#[test]
fn bad_usage_is_exit_code_2() {
    for arguments in [&[][..], &["fly"], &["replay"], &["decode", "--fly"], &["completions", "cmd"]] {
        let Run { code, out, err } = encoring(arguments, b"");
        assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(!err.is_empty(), "{arguments:?}");
    }
}

#[test]
fn every_shell_gets_a_script_that_knows_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let Run { code, out, err } = encoring(&["completions", shell], b"");
        assert_eq!((code, err.as_str()), (Some(0), ""), "{shell}");
        for word in ["decode", "replay", "service-times", "ce-100-m"] {
            assert!(out.contains(word) || shell != "bash", "{shell}: {word}");
        }
        assert!(out.contains("replay"), "{shell}");
    }
}

#[test]
fn a_pipe_that_closes_early_ends_every_command_quietly() {
    for arguments in [
        "decode",
        "decode --format json",
        "replay --model ce-65-m --print -",
        "replay --model ce-65-m -",
        "completions bash",
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_encoring"))
            .args(arguments.split(' '))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut stdin = child.stdin.take().unwrap();
        let input = if arguments.starts_with("decode") { "C200270F\n" } else { "in\n00000001\n" };
        let writer = std::thread::spawn(move || {
            use std::io::Write;
            // A program that has ended reads no more.
            let _ = stdin.write_all(input.as_bytes());
        });
        let output = child.wait_with_output().unwrap();
        writer.join().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {err}");
        assert!(!err.contains("error"), "{arguments}: {err}");
    }
}

#[test]
fn what_cannot_be_is_refused_before_a_connection_is_tried() {
    // Nobody answers there, and nobody is asked.
    let bus = ["--bus", "modbus-tcp://192.0.2.1", "--model", "ce-65-m", "--at"];
    for (command, at) in [("read", "99999"), ("read", "128"), ("watch", "0,128")] {
        let number = at.trim_start_matches("0,");
        let advice = if command == "watch" { "; write 2 or 0,2 or 0-2" } else { "" };
        let option = if command == "watch" { "<POSITIONS>" } else { "<POSITION>" };
        let message = format!(
            "error: invalid value '{at}' for '--at {option}': \"{number}\" is no position; a ring has 0 to 127{advice}"
        );
        super::refused(&[&[command][..], &bus, &[at]].concat(), b"", &message);
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("empty.toml");
    std::fs::write(&file, "version = 1\nmodel = \"ce-65-m\"\n").unwrap();
    let file = file.to_str().unwrap();
    let message = format!("error: {file}: no value in [parameters], so nothing to program");
    super::refused(&[&["program"][..], &bus, &["0", "--file", file]].concat(), b"", &message);
}
