//! What is refused in the whole workspace is refused in crates with a `clippy.toml` of their own too.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Where words and values come in: no second reader of them stands there.
const READERS: [&str; 3] = ["cli", "trace", "workshop"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn table(file: &Path) -> toml::Table {
    toml::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

/// The entries of a list, each as text.
fn entries(table: &toml::Table, list: &str) -> BTreeSet<String> {
    table.get(list).and_then(toml::Value::as_array).unwrap().iter().map(toml::Value::to_string).collect()
}

#[test]
fn a_crate_with_lints_of_its_own_has_those_of_the_workspace() {
    let whole = table(&root().join("clippy.toml"));
    let crates = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let own: Vec<PathBuf> =
        crates.map(|path| path.join("clippy.toml")).filter(|file| file.exists()).collect();
    assert!(own.len() >= READERS.len());
    for file in own {
        let lints = table(&file);
        for (key, value) in &whole {
            match value.as_array() {
                Some(_) => assert!(
                    entries(&lints, key).is_superset(&entries(&whole, key)),
                    "{}: {key} lacks an entry of the workspace",
                    file.display()
                ),
                None => assert_eq!(lints.get(key), Some(value), "{}: {key}", file.display()),
            }
        }
    }
}

#[test]
fn words_and_values_have_one_reader_where_they_come_in() {
    let whole = entries(&table(&root().join("clippy.toml")), "disallowed-methods");
    let integers = "u8 u16 u32 u64 u128 usize i8 i16 i32 i64 i128 isize".split(' ');
    let refused: BTreeSet<String> = integers
        .map(|integer| format!("{integer}::from_str_radix"))
        .chain(["str::parse".to_owned()])
        .collect();
    for name in READERS {
        let own =
            entries(&table(&root().join("crates").join(name).join("clippy.toml")), "disallowed-methods");
        let more: Vec<String> = own.difference(&whole).cloned().collect();
        assert_eq!(more.len(), refused.len(), "{name}");
        for method in &refused {
            assert!(
                more.iter().any(|entry| entry.contains(&format!("path = \"{method}\""))),
                "{name}: {method}"
            );
        }
    }
}
