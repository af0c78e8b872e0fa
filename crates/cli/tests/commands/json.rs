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
        // One object, or one a line.
        let documented = serde_json::Deserializer::from_str(&block).into_iter::<serde_json::Value>();
        let documented: Vec<_> = documented.map(Result::unwrap).collect();
        let arguments: Vec<&str> = command.split(' ').collect();
        // A file that a command writes is not to stay.
        let folder = tempfile::tempdir().unwrap();
        let run = match arguments[0] {
            "backup" | "replace" => encoring_in(folder.path(), &arguments, b""),
            _ => encoring(&arguments, b""),
        };
        let lines: Vec<&str> = run.out.lines().collect();
        let last = &lines[lines.len().saturating_sub(documented.len())..];
        let printed: Vec<serde_json::Value> =
            last.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(documented, printed, "{command}");
        examples += 1;
    }
    assert!(examples >= 3, "{examples} examples");
}
