//! The rules of CONTRIBUTING for help texts, held against every command.

use clap::{Command, CommandFactory};

/// The columns of a terminal for which help is written; clap breaks longer lines.
const COLUMNS: usize = 100;
/// The most words of a sentence.
const WORDS: usize = 25;

/// Turns that no help text has, and what to write.
const TURNS: [(&str, &str); 17] = [
    ("shall", "say what it is or does"),
    ("may be repeated", "repeatable"),
    ("if nothing is said", "[default: ...]"),
    ("says nothing", "[default: ...]"),
    ("hangs", "is connected to"),
    ("so many", "name the number"),
    ("so much", "name the quantity"),
    ("so often", "name the time"),
    ("for good", "to the end"),
    ("meanwhile", "while ..."),
    ("somebody", "the user"),
    ("nobody", "no ..."),
    ("tells", "shows, prints, names"),
    ("is told", "is shown, is printed"),
    ("here and now", "leave it out"),
    ("are one", "are the same"),
    ("the other way round", "it undoes ..."),
];

/// Every command with the words to type for it.
fn commands() -> Vec<(String, Command)> {
    fn walk(path: &str, command: Command, all: &mut Vec<(String, Command)>) {
        for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
            walk(&format!("{path} {}", inner.get_name()), inner.clone(), all);
        }
        all.push((path.to_owned(), command));
    }
    let mut all = Vec::new();
    let mut root = crate::Arguments::command();
    root.build();
    walk("encoring", root, &mut all);
    assert!(all.len() > 30, "{} commands", all.len());
    all
}

fn after(command: &Command) -> String {
    command.get_after_help().map(ToString::to_string).unwrap_or_default()
}

/// The examples of a command, each in one line.
fn examples(command: &Command) -> Vec<String> {
    let text = after(command).replace("\\\n", " ");
    let lines = text.lines().skip_while(|line| *line != "Examples:").skip(1);
    lines.take_while(|line| line.starts_with("  ")).map(|line| line.trim().to_owned()).collect()
}

/// Every text of a command that somebody wrote, with what it is of.
fn texts(command: &Command) -> Vec<(String, String)> {
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string);
    let of_arguments = command.get_arguments().filter(|argument| !argument.is_hide_set()).map(|argument| {
        let help = argument.get_long_help().or(argument.get_help());
        (argument.to_string(), help.map(ToString::to_string).unwrap_or_default())
    });
    let mut texts: Vec<_> = of_arguments.collect();
    texts.push(("what it is".to_owned(), about.unwrap_or_default()));
    texts
}

/// Whether a text begins as a sentence of somebody else: "Prints the ...", where "Print the ..." is asked for.
fn is_third_person(text: &str) -> bool {
    let mut words = text.split_whitespace();
    let articles = ["a", "an", "the", "every", "each", "this", "these"];
    words.next().is_some_and(|first| first.ends_with('s') && !first.ends_with("ss"))
        && words.next().is_some_and(|second| articles.contains(&second))
}

/// The sentences of the paragraphs of a text, each up to its colon: a list follows there. What is indented is a list or an
/// example.
fn sentences(text: &str) -> impl Iterator<Item = String> {
    let paragraphs = text.split("\n\n").map(|paragraph| {
        paragraph.lines().filter(|line| !line.starts_with(' ')).collect::<Vec<_>>().join(" ")
    });
    let sentences = |text: String| -> Vec<String> { text.split(". ").map(str::to_owned).collect() };
    let until_list = |text: String| text.split_once(": ").map_or(text.clone(), |(until, _)| until.to_owned());
    paragraphs.flat_map(sentences).map(until_list)
}

#[test]
fn every_command_and_every_option_has_a_text() {
    for (path, command) in commands() {
        for (of, text) in texts(&command) {
            assert!(!text.trim().is_empty(), "{path}: {of} has no text");
            assert!(text.starts_with(char::is_uppercase), "{path}: {of} begins with a capital: {text}");
            assert!(!is_third_person(&text), "{path}: {of}: say what to do, as `Print the ...`: {text}");
        }
    }
}

#[test]
fn every_command_has_an_example_of_itself() {
    for (path, command) in commands() {
        let examples = examples(&command);
        let (first, inner) = path.rsplit_once(' ').unwrap_or((&path, ""));
        // Options of a command stand before its subcommand, too.
        let shows = |example: &&String| example.contains(first) && example.contains(inner);
        assert!(examples.iter().any(|example| shows(&example)), "{path} has no example: {examples:?}");
    }
}

#[test]
fn every_command_names_its_exit_codes() {
    for (path, command) in commands() {
        let names = after(&command).contains("Exit codes:");
        assert!(names || command.has_subcommands(), "{path}");
    }
}

/// What is wrong with the English of a text.
fn faults(text: &str) -> Vec<String> {
    let turns = TURNS.iter().filter(|(turn, _)| text.contains(turn));
    let turns = turns.map(|(turn, instead)| format!("{turn:?}; write: {instead}\n  {text}"));
    let long = sentences(text).map(|sentence| (sentence.split_whitespace().count(), sentence));
    let long = long.filter(|(words, _)| *words > WORDS);
    turns.chain(long.map(|(words, sentence)| format!("{words} words in a sentence: {sentence}"))).collect()
}

#[test]
fn every_help_text_is_in_plain_english() {
    let mut wrong = Vec::new();
    for (path, command) in commands() {
        let mut texts = texts(&command);
        texts.push(("what stands below".to_owned(), after(&command)));
        for (of, text) in texts {
            wrong.extend(faults(&text).into_iter().map(|fault| format!("{path}: {of}: {fault}")));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn a_banned_turn_and_a_long_sentence_are_found() {
    assert_eq!(faults("What one step shall be").len(), 1);
    assert_eq!(faults(&["word"; WORDS + 1].join(" ")).len(), 1);
    assert_eq!(faults(&["word"; WORDS].join(" ")).len(), 0);
    assert!(is_third_person("Prints the scenario") && !is_third_person("Steps per turn"));
}

#[test]
fn no_line_below_the_options_is_wider_than_a_terminal() {
    for (path, command) in commands() {
        for line in after(&command).lines() {
            assert!(line.chars().count() <= COLUMNS, "{path}: {line}");
        }
    }
}
