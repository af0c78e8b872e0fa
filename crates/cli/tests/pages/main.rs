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

// [R33, R34, R38, R39, R79]
#[test]
fn a_client_that_does_what_the_pages_show_breaks_no_rule_of_the_handshake() {
    for page in ["README.md", "docs/modbus.md"] {
        let (blocks, _) = page::blocks(&std::fs::read_to_string(Path::new(ROOT).join(page)).unwrap());
        let commands =
            blocks.iter().filter(|block| block.mark != Mark::NotRun).flat_map(|block| &block.steps);
        let mut reader = Reader::new();
        for command in commands.map(|step| &step.command) {
            if reader::stays(&command.replace("cargo run --release -- ", "encoring ")) {
                let _ = reader.ends_ring();
                reader.types(&format!("{command} --referee strict --record-bus plc.csv --overwrite"));
            } else if command.starts_with("mbpoll ") {
                reader.types(command);
            }
        }
        assert_eq!(reader.ends_ring(), Some(0), "{page}");
        let (clean, found) = reader.types("encoring referee plc.csv");
        assert!(clean && !found.concat().contains("(error"), "{page}: {found:?}");
        assert!(found[0].ends_with("seen"), "no finding at all: {found:?}");
    }
}

/// The commands in the second column of the table of jobs.
fn jobs(readme: &str) -> Vec<String> {
    let rows = readme.lines().skip_while(|line| *line != "## Which job is yours").skip(1);
    let rows = rows.take_while(|line| !line.starts_with("## ")).filter(|line| line.starts_with("| "));
    let spans =
        rows.filter_map(|row| row.split(" | ").nth(1)).flat_map(|cell| cell.split('`').skip(1).step_by(2));
    spans.filter(|span| span.starts_with("encoring ")).map(str::to_owned).collect()
}

#[test]
fn every_job_of_the_readme_works_in_the_order_of_the_table() {
    let jobs = jobs(&std::fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap());
    let mut reader = Reader::new();
    reader.types("encoring sim");
    for job in &jobs {
        // It asks at a terminal, step by step.
        if job.starts_with("encoring replace --bus") {
            continue;
        }
        // As short as it may be.
        let (_, found) = reader.types(&job.replace("--for 10m", "--for 1s"));
        let wrong =
            found.iter().any(|line| line.starts_with("error: ") || line.contains("command not found"));
        assert!(!wrong, "{job}\n{}", found.join("\n"));
    }
    assert!(jobs.len() >= 25, "{} jobs", jobs.len());
}
