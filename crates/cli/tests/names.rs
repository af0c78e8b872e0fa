//! One name, one thing: no two libraries give the same name to two public types.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Names that several libraries have, each for the same thing in its own field.
const EVERYWHERE: [(&str, &str); 2] = [
    ("Error", "what a library's reader of files refuses with"),
    ("Options", "how whatever a library runs shall run"),
];

/// The command line is no library: nobody names its types from outside.
const NO_LIBRARY: &str = "cli";

fn crates() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file of Rust below a folder, tests apart.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_test = |path: &Path| matches!(path.file_stem(), Some(stem) if stem == "tests");
    let found = entries.filter(|path| !is_test(path)).flat_map(|path| match path.extension() {
        _ if path.is_dir() => files(&path),
        Some(ending) if ending == "rs" => vec![path],
        _ => Vec::new(),
    });
    found.collect()
}

/// The name of the type that a line of a file makes public, if it makes one.
fn public_type(line: &str) -> Option<&str> {
    let kinds = ["pub struct ", "pub enum ", "pub trait ", "pub type "];
    let rest = kinds.into_iter().find_map(|kind| line.strip_prefix(kind))?;
    rest.split(|sign: char| !sign.is_alphanumeric() && sign != '_').next()
}

/// Every public type of the libraries, with the files that define one of this name.
fn public_types() -> BTreeMap<String, BTreeSet<PathBuf>> {
    let mut types: BTreeMap<String, BTreeSet<PathBuf>> = BTreeMap::new();
    for library in std::fs::read_dir(crates()).unwrap().map(|entry| entry.unwrap().path()) {
        if library.file_name().unwrap() == NO_LIBRARY {
            continue;
        }
        for file in files(&library.join("src")) {
            let text = std::fs::read_to_string(&file).unwrap();
            for name in text.lines().filter_map(public_type) {
                types.entry(name.to_owned()).or_default().insert(file.clone());
            }
        }
    }
    types
}

#[test]
fn no_public_type_has_the_name_of_another() {
    let types = public_types();
    assert!(types.len() > 150, "only {} public types were found", types.len());
    let everywhere = EVERYWHERE.map(|(name, _)| name);
    let twice: Vec<_> = types
        .iter()
        .filter(|(name, places)| places.len() > 1 && !everywhere.contains(&name.as_str()))
        .collect();
    assert!(twice.is_empty(), "{twice:#?}");
}

#[test]
fn a_name_may_stand_twice_only_where_it_does() {
    let types = public_types();
    for (name, reason) in EVERYWHERE {
        let places = types.get(name).map_or(0, BTreeSet::len);
        assert!(places > 1, "{name} ({reason}) stands {places} times: take it off the list");
    }
}
