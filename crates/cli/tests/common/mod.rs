//! What several tests of the program begin with.

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Stdio};

/// Starts a program that runs on; with it the reader of what it prints, and its first line: where it listens.
pub(crate) fn listening(command: &mut Command) -> (Child, BufReader<ChildStdout>, serde_json::Value) {
    let mut program = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(program.stdout.take().unwrap());
    let mut first = String::new();
    lines.read_line(&mut first).unwrap();
    (program, lines, serde_json::from_str(&first).unwrap())
}
