//! The examples of `docs/json.md` are what the program prints.

use super::{encoring, encoring_in};

#[test]
fn every_example_of_the_document_is_what_the_program_prints() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/json.md");
    let document = std::fs::read_to_string(path).unwrap();
    let mut examples = 0;
    let mut lines = document.lines();
    while let Some(line) = lines.next() {
        let Some(command) = line.strip_prefix("$ encoring ") else { continue };
        let block: String = lines.by_ref().take_while(|line| *line != "```").collect();
        let documented: serde_json::Value = serde_json::from_str(&block).unwrap();
        let arguments: Vec<&str> = command.split(' ').collect();
        // A file that a command writes is not to stay.
        let folder = tempfile::tempdir().unwrap();
        let run = match arguments[0] {
            "backup" | "replace" => encoring_in(folder.path(), &arguments, b""),
            _ => encoring(&arguments, b""),
        };
        let printed: serde_json::Value = serde_json::from_str(run.out.lines().last().unwrap()).unwrap();
        assert_eq!(documented, printed, "{command}");
        examples += 1;
    }
    assert!(examples >= 3, "{examples} examples");
}
