//! What differs between the models is looked up in `words::model`: no other product code names one.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};

use encoring_words::model::MODELS;

/// The table.
const TABLE: &str = "words/src/model.rs";

fn crates() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// The product files: those below a crate's `src` that no test module consists of.
fn product_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy();
        if name == "tests" {
            continue;
        }
        if path.is_dir() {
            product_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The lines of a file that are product code: neither comments nor what stands under `#[cfg(test)]`. As rustfmt writes
/// it, that ends with a `;` or a `}` indented no deeper.
fn product_lines(text: &str) -> Vec<(usize, &str)> {
    let mut kept = Vec::new();
    let mut lines = (1..).zip(text.lines());
    while let Some((number, line)) = lines.next() {
        let bare = line.trim_start();
        if bare == "#[cfg(test)]" {
            let indent = line.strip_suffix(bare).unwrap();
            let ends = |line: &str| {
                let here = line.strip_prefix(indent).unwrap_or("");
                here == "}" || here.ends_with(';') && !here.starts_with(' ')
            };
            lines.by_ref().find(|(_, line)| ends(line));
        } else if !bare.starts_with("//") {
            kept.push((number, line));
        }
    }
    kept
}

fn names_a_model(line: &str) -> bool {
    MODELS.iter().any(|model| line.contains(&format!("{model:?}")))
}

#[test]
fn no_product_code_outside_the_table_names_a_model() {
    let crates = crates();
    let mut files = Vec::new();
    for entry in fs::read_dir(&crates).unwrap() {
        product_files(&entry.unwrap().path().join("src"), &mut files);
    }
    assert!(files.contains(&crates.join(TABLE)), "the table has moved");
    let mut naming = Vec::new();
    for file in files.iter().filter(|file| **file != crates.join(TABLE)) {
        let text = fs::read_to_string(file).unwrap();
        for (number, line) in product_lines(&text).into_iter().filter(|(_, line)| names_a_model(line)) {
            naming.push(format!(
                "{}:{number}: {}",
                file.strip_prefix(&crates).unwrap().display(),
                line.trim()
            ));
        }
    }
    assert_eq!(naming, Vec::<String>::new(), "ask for a property of {TABLE} instead");
}

#[test]
fn in_the_table_one_match_finds_the_entry_of_a_model() {
    let text = fs::read_to_string(crates().join(TABLE)).unwrap();
    let arms =
        product_lines(&text).into_iter().filter(|(_, line)| names_a_model(line) && line.contains("=>"));
    let arms: Vec<_> = arms.map(|(number, _)| number).collect();
    assert_eq!(arms.len(), MODELS.len(), "one arm for each model: {arms:?}");
}

#[test]
fn a_test_module_and_a_comment_are_no_product_code() {
    let text = "\
use a;
/// La66
fn product() {}

#[cfg(test)]
mod tests {
    fn test() { Model::La66; }
}

#[cfg(test)]
mod elsewhere;

impl A {
    #[cfg(test)]
    fn helper() {
        Model::La66;
    }

    fn last() {}
}
";
    let lines: Vec<_> =
        product_lines(text).into_iter().map(|(_, line)| line).filter(|line| !line.is_empty()).collect();
    assert_eq!(lines, ["use a;", "fn product() {}", "impl A {", "    fn last() {}", "}"]);
}
