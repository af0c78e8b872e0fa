//! The table of allowed edges in ARCHITECTURE.md is the truth about what may depend on what.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

const PREFIX: &str = "encoring-";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The names in backticks of a table cell.
fn names(cell: &str) -> BTreeSet<String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn allowed() -> BTreeMap<String, BTreeSet<String>> {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, section) = page.split_once("## Allowed edges").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split('|').collect();
        let [of, may_use] = cells[..] else { panic!("two cells in {row}") };
        (names(of).into_iter().next().unwrap(), names(may_use))
    })
    .collect()
}

/// Every file of Rust below a folder, as text.
fn sources(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let text = |path: PathBuf| match path.extension() {
        _ if path.is_dir() => sources(&path),
        Some(ending) if ending == "rs" => std::fs::read_to_string(path).unwrap(),
        _ => String::new(),
    };
    entries.map(text).collect()
}

#[test]
fn crates_depend_on_each_other_as_the_architecture_says_and_need_every_permission_that_it_gives() {
    let allowed = allowed();
    let metadata = MetadataCommand::new().manifest_path(root().join("Cargo.toml")).no_deps().exec().unwrap();
    let mut seen = BTreeSet::new();
    for package in &metadata.packages {
        let Some(name) = package.name.strip_prefix(PREFIX) else {
            panic!("package {} is not named {PREFIX}FOLDER", package.name)
        };
        let folder = package.manifest_path.parent().unwrap().file_name().unwrap();
        assert_eq!(folder, name, "a package has the name of its folder");
        let may_use = allowed.get(name).unwrap_or_else(|| panic!("{name} has no row in ARCHITECTURE.md"));
        let edges = package.dependencies.iter().filter(|edge| edge.kind != DependencyKind::Build);
        let edges: BTreeSet<&str> = edges.filter_map(|edge| edge.name.strip_prefix(PREFIX)).collect();
        for edge in &edges {
            assert!(may_use.contains(*edge), "{name} -> {edge} is not in the table of ARCHITECTURE.md");
        }
        let text = sources(package.manifest_path.parent().unwrap().as_std_path());
        for permission in may_use {
            assert!(
                edges.contains(permission.as_str()),
                "{name} has no use for {permission}, which it may use"
            );
            let path = format!("encoring_{}", permission.replace('-', "_"));
            assert!(text.contains(&path), "no file of {name} names {path}");
        }
        seen.insert(name.to_owned());
    }
    let rows: BTreeSet<String> = allowed.into_keys().collect();
    assert_eq!(rows, seen, "the table has a row for every crate and no other");
}

/// All of ours that a package needs for its library or program, directly or not.
fn needed(of: &str) -> BTreeSet<String> {
    let metadata = MetadataCommand::new().manifest_path(root().join("Cargo.toml")).no_deps().exec().unwrap();
    let mut needed = BTreeSet::new();
    let mut open = vec![of.to_owned()];
    while let Some(name) = open.pop() {
        let package = metadata.packages.iter().find(|package| *package.name == format!("{PREFIX}{name}"));
        let edges = package.unwrap().dependencies.iter().filter(|edge| edge.kind == DependencyKind::Normal);
        for edge in edges.filter_map(|edge| edge.name.strip_prefix(PREFIX)) {
            if needed.insert(edge.to_owned()) {
                open.push(edge.to_owned());
            }
        }
    }
    needed
}

#[test]
fn whoever_uses_a_bus_or_modbus_does_not_build_the_simulator() {
    for user in ["bus", "modbus"] {
        let needed = needed(user);
        for simulates in ["encoder", "device", "sim", "station", "trace"] {
            assert!(!needed.contains(simulates), "{user} needs {simulates}");
        }
    }
    assert!(needed("modbus").contains("bus"), "what is needed was looked for");
    assert!(needed("control").contains("ring"), "also through others");
}

#[test]
fn the_core_builds_without_the_standard_library() {
    for core in ["words", "encoder", "ring", "host", "device"] {
        let lib = std::fs::read_to_string(root().join(format!("crates/{core}/src/lib.rs"))).unwrap();
        assert!(lib.lines().any(|line| line == "#![no_std]"), "{core}");
        assert!(!lib.contains("extern crate alloc"), "{core}");
    }
}
