//! What README and `docs/` print is what the commands say: every `console` block is typed, in order, and compared.
//!
//! A command without output below it must only succeed. A line `...` stands for any lines. `sim` without `--for` runs
//! on until the end of the page, or until the next one. [`page::Mark`] has what a comment before a block may say. The
//! blocks of `docs/json.md` are objects; `commands/json.rs` compares them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test"
)]
#![allow(
    clippy::disallowed_methods,
    reason = "a test plays a person: it types, waits and reads what was printed"
)]

mod clients;
mod page;
mod reader;

use std::path::{Path, PathBuf};

use page::{Block, Mark};
use reader::Reader;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// README, `docs/` and the page of the traces.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(ROOT);
    let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let is_page = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "md");
    let docs = docs.filter(is_page).filter(|path| !path.ends_with("json.md"));
    docs.chain([root.join("README.md"), root.join("vectors/README.md")]).collect()
}

/// The commands that were run, and what differed.
fn typed(page: &Path) -> (usize, Vec<String>) {
    let (blocks, unmarked) = page::blocks(&std::fs::read_to_string(page).unwrap());
    let name = page.strip_prefix(ROOT).unwrap_or(page).display().to_string();
    let mut wrong: Vec<String> = unmarked
        .iter()
        .map(|line| format!("{name}:{line}: a block with commands begins with ```console\n"))
        .collect();
    let (mut reader, mut run) = (Reader::new(), 0);
    for Block { mark, steps } in blocks.iter().filter(|block| block.mark != Mark::NotRun) {
        for step in steps {
            let (ok, found) = reader.types(&step.command);
            run += 1;
            let differs = !step.printed.is_empty() && !mark.agrees(&step.printed, &found);
            if differs || (step.printed.is_empty() && !ok) {
                let (printed, found) = (step.printed.join("\n"), found.join("\n"));
                let at = format!("{name}:{}", step.line);
                wrong.push(format!("{at}: {}\n-- printed\n{printed}\n-- found\n{found}\n", step.command));
            }
        }
    }
    (run, wrong)
}

#[test]
fn every_printed_output_is_what_the_command_says() {
    let pages = pages();
    let results: Vec<(usize, Vec<String>)> = std::thread::scope(|scope| {
        let running: Vec<_> = pages.iter().map(|page| scope.spawn(|| typed(page))).collect();
        running.into_iter().map(|page| page.join().unwrap()).collect()
    });
    let run: usize = results.iter().map(|(run, _)| run).sum();
    let wrong: Vec<String> = results.into_iter().flat_map(|(_, wrong)| wrong).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    assert!(run >= 60, "only {run} commands were run");
}
