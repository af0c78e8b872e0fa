//! docs/conformance.md has a row for every statement of the manuals, and names only tests that exist.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The statements are numbered R1..R161.
const STATEMENTS: usize = 161;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn tests_below(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            tests_below(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let mut is_test = false;
            for line in text.lines().map(str::trim) {
                if line.starts_with("#[test]") {
                    is_test = true;
                } else if let Some(rest) = line.strip_prefix("fn ") {
                    if is_test {
                        found.insert(rest.split(['(', '<']).next().unwrap().to_owned());
                    }
                    is_test = false;
                }
            }
        }
    }
}

#[test]
fn every_statement_has_a_row_and_every_named_test_exists() {
    let mut tests = BTreeSet::new();
    tests_below(&root().join("crates"), &mut tests);
    let page = fs::read_to_string(root().join("docs/conformance.md")).unwrap();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| R")).collect();
    assert_eq!(rows.len(), STATEMENTS);
    for (number, row) in (1..).zip(rows) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, _, state] = cells[..] else { panic!("four cells in {row}") };
        assert_eq!(name, format!("R{number}"));
        match state {
            "open" | "data sheet only" => {}
            _ => {
                let named = state.strip_prefix("done: ").unwrap_or_else(|| panic!("{name}: state {state}"));
                for test in named.split(", ") {
                    let test = test.trim_matches('`');
                    assert!(tests.contains(test), "{name}: there is no test {test}");
                }
            }
        }
    }
}
