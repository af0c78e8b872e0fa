//! docs/conformance.md has a row for every statement of the manuals, and names only tests that exist and cite the row.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The statements are numbered R1..R161.
const STATEMENTS: usize = 161;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every test below a folder: its name, and its text with the comment above it.
fn tests_below(folder: &Path, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            tests_below(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.extend(tests_in(&fs::read_to_string(&path).unwrap()));
        }
    }
}

fn tests_in(text: &str) -> Vec<(String, String)> {
    let lines: Vec<&str> = text.lines().collect();
    let is_comment = |line: &&&str| line.trim_start().starts_with("//");
    let mut tests = Vec::new();
    for (at, _) in lines.iter().enumerate().filter(|(_, line)| line.trim() == "#[test]") {
        let (before, from) = lines.split_at(at);
        let above = before.iter().rev().take_while(is_comment);
        let head = from.iter().find(|line| line.trim_start().starts_with("fn ")).unwrap();
        let ends = head.replace(head.trim_start(), "}");
        let body = from.iter().take_while(|line| **line != ends);
        let name = head.trim_start().trim_start_matches("fn ").split(['(', '<']).next().unwrap();
        tests.push((name.to_owned(), above.chain(body).copied().collect::<Vec<_>>().join("\n")));
    }
    tests
}

/// Whether a text cites a statement, as in `[R79, C23]`.
fn cites(text: &str, statement: &str) -> bool {
    let brackets = text.split('[').skip(1).filter_map(|rest| rest.split_once(']'));
    brackets.flat_map(|(inside, _)| inside.split(',')).any(|cited| cited.trim() == statement)
}

#[test]
fn every_statement_has_a_row_and_every_named_test_exists_and_cites_it() {
    let mut tests = BTreeMap::new();
    tests_below(&root().join("crates"), &mut tests);
    let page = fs::read_to_string(root().join("docs/conformance.md")).unwrap();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| R")).collect();
    assert_eq!(rows.len(), STATEMENTS);
    for (number, row) in (1..).zip(rows) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, _, state] = cells[..] else { panic!("four cells in {row}") };
        assert_eq!(name, format!("R{number}"));
        match state.split_once(": ") {
            None => assert!(["open", "data sheet only"].contains(&state), "{name}: state {state}"),
            Some((kind, named)) => {
                assert_eq!(kind, "done", "{name}: state {state}");
                for test in named.split(", ") {
                    let test = test.trim_matches('`');
                    let text = tests.get(test).unwrap_or_else(|| panic!("{name}: there is no test {test}"));
                    assert!(cites(text, name), "{name}: {test} does not cite it as [{name}]");
                }
            }
        }
    }
}

#[test]
fn a_citation_is_looked_for_in_the_test_and_above_it_and_nowhere_else() {
    let text = "// [R1]\n#[test]\nfn first() {\n    // [R2, C3]\n}\n\n// [R4]\nfn helper() {}\n\n#[test]\nfn second() {\n}\n";
    let tests: BTreeMap<String, String> = tests_in(text).into_iter().collect();
    let cited = |test: &str| ["R1", "R2", "R3", "R4", "C3"].map(|statement| cites(&tests[test], statement));
    assert_eq!(cited("first"), [true, true, false, false, true]);
    assert_eq!(cited("second"), [false; 5]);
}
