//! Both languages have every text that the page uses, and no other.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use encoring_bus::Judgement;
use encoring_diagnosis::CAUSES;
use encoring_host::referee::RULES;
use encoring_sheet::{Sheet, SheetCell, SheetSection};
use encoring_texts::{Said, SaidTemplate, SaidValue};
use encoring_words::model::MODELS;
use encoring_words::sheet::SECTIONS;

type Texts = BTreeMap<String, String>;

fn assets() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets")
}

fn texts(language: &str) -> Texts {
    let text = fs::read_to_string(assets().join(format!("texts/{language}.json"))).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn scripts() -> String {
    let files = fs::read_dir(assets().join("js")).unwrap();
    files.map(|file| fs::read_to_string(file.unwrap().path()).unwrap()).collect()
}

/// The first argument of each call of `t`.
fn asked(script: &str) -> Vec<&str> {
    let word =
        |before: &str| before.ends_with(|last: char| last.is_alphanumeric() || last == '_' || last == '.');
    let calls = script.match_indices("t(").filter(|(at, _)| !word(&script[..*at]));
    let argument = |at: usize| {
        let mut depth = 0;
        let rest = &script[at..];
        let end = rest.find(|next| {
            depth += match next {
                '(' | '{' | '[' => 1,
                ')' | '}' | ']' => -1,
                _ => 0,
            };
            depth < 0 || depth == 0 && next == ','
        });
        &rest[..end.unwrap()]
    };
    calls.map(|(at, call)| argument(at + call.len())).collect()
}

/// The keys that a script asks for, and the beginnings of those that it makes of codes.
fn used(script: &str) -> (BTreeSet<String>, BTreeSet<String>) {
    let (mut whole, mut made) = (BTreeSet::new(), BTreeSet::new());
    for argument in asked(script) {
        whole.extend(argument.split('"').skip(1).step_by(2).map(str::to_owned));
        let templates = argument.split('`').skip(1).step_by(2);
        made.extend(templates.map(|text| text.split("${").next().unwrap().to_owned()));
    }
    (whole, made)
}

fn places(text: &str) -> BTreeSet<&str> {
    text.split('{').skip(1).map(|rest| rest.split('}').next().unwrap()).collect()
}

#[test]
fn both_languages_have_the_same_texts_with_the_same_values() {
    let (english, german) = (texts("en"), texts("de"));
    assert_eq!(english.keys().collect::<Vec<_>>(), german.keys().collect::<Vec<_>>());
    for (key, text) in &english {
        let german = &german[key];
        assert!(!text.trim().is_empty() && !german.trim().is_empty(), "{key}");
        assert_eq!(places(text), places(german), "{key}");
    }
    let differ = english.iter().filter(|(key, text)| german[*key] != **text).count();
    assert!(differ * 10 > english.len() * 8, "{differ} of {} are translated", english.len());
}

/// A sentence with the sentences that stand in it.
fn all_of(said: &Said, found: &mut BTreeSet<String>) {
    found.insert(said.code().to_owned());
    for (_, value) in said.values() {
        if let SaidValue::Said(part) = value {
            all_of(part, found);
        }
    }
}

/// The codes of everything that the data sheets say, of pins of the connectors, and of the manual's remedies.
fn of_sheets() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for model in MODELS {
        for section in Sheet::new(model, &SECTIONS).sections {
            section.notes.iter().for_each(|note| all_of(note, &mut found));
            for cell in section.rows.rows.into_iter().flatten() {
                if let SheetCell::Said(said) = cell {
                    all_of(&said, &mut found);
                }
            }
        }
    }
    found
}

#[test]
fn everything_that_a_data_sheet_says_has_a_german_text_and_every_column_and_section_a_heading() {
    let german = texts("de/sheet");
    let said = of_sheets();
    let templates: Vec<&str> = encoring_sheet::sentences().map(|said| said.code).collect();
    let missing: Vec<_> = said.iter().filter(|code| !german.contains_key(*code)).collect();
    assert_eq!(missing, Vec::<&String>::new(), "these have no German text");
    let unsaid: Vec<_> =
        german.keys().filter(|code| !said.contains(*code) && !templates.contains(&code.as_str())).collect();
    assert_eq!(unsaid, Vec::<&String>::new(), "nobody says these");
    for SaidTemplate { code, english, values } in encoring_sheet::sentences() {
        let values: BTreeSet<&str> = values.iter().copied().collect();
        assert_eq!(places(english), values, "{code}");
        assert_eq!(places(&german[*code]), values, "{code}");
    }
    for (code, text) in german.iter().filter(|(code, _)| !templates.contains(&code.as_str())) {
        assert_eq!((places(code), places(text)), (BTreeSet::new(), BTreeSet::new()), "{code}");
        assert!(!text.trim().is_empty(), "{code}");
    }
    let english = texts("en");
    for model in MODELS {
        for SheetSection { section, rows, .. } in Sheet::new(model, &SECTIONS).sections {
            assert!(english.contains_key(&format!("section.{}", section.name())), "{}", section.name());
            for column in rows.columns {
                assert!(english.contains_key(&format!("sheet.column.{column}")), "{column}");
            }
        }
    }
}

/// Compares the sentences of one kind with their German texts; the English ones are the server's own.
fn said_in_german(name: &str, sentences: impl Iterator<Item = &'static SaidTemplate>) {
    let german = texts(&format!("de/{name}"));
    let mut said = BTreeSet::new();
    for SaidTemplate { code, english, values } in sentences {
        let values: BTreeSet<&str> = values.iter().copied().collect();
        let german = german.get(*code).unwrap_or_else(|| panic!("no German text for {code}"));
        // What another library says in its own words may say less here, but nothing that is not sent.
        if english.is_empty() {
            assert!(named(german).is_subset(&values), "{code}: {german}");
        } else {
            assert_eq!(named(english), values, "{code}");
            assert_eq!(named(german), values, "{code}");
        }
        assert!(!german.trim().is_empty() && said.insert(*code), "{code} is empty or stands twice");
    }
    assert!(said.len() > 40, "{} of {name} were found", said.len());
    let unsaid: Vec<_> = german.keys().filter(|code| !said.contains(code.as_str())).collect();
    assert_eq!(unsaid, Vec::<&String>::new(), "nobody says these");
}

/// The names in braces; what stands in other braces is an example in JSON.
fn named(text: &str) -> BTreeSet<&str> {
    let is_name = |name: &&str| {
        name.chars().all(|sign| sign.is_ascii_lowercase() || sign.is_ascii_digit() || sign == '_')
    };
    places(text).into_iter().filter(is_name).filter(|name| !name.is_empty()).collect()
}

#[test]
fn every_sentence_of_the_server_has_a_text_in_both_languages_with_its_values() {
    said_in_german("diagnosis", encoring_diagnosis::sentences());
    said_in_german("refusals", encoring_dashboard::refusals());
}

#[test]
fn every_text_that_a_script_asks_for_is_there_and_every_text_is_asked_for() {
    let (english, script) = (texts("en"), scripts());
    let (whole, made) = used(&script);
    assert!(whole.len() > 80 && made.len() > 10, "{} and {} were found", whole.len(), made.len());
    for key in &whole {
        assert!(english.contains_key(key), "no text {key}");
    }
    for beginning in &made {
        assert!(english.keys().any(|key| key.starts_with(beginning.as_str())), "no text {beginning}...");
    }
    // An event's key is put together before it is asked for.
    let event = |key: &str| key.starts_with("event.") && script.contains("`event.search_found.${");
    for key in english.keys() {
        let asked = whole.contains(key) || made.iter().any(|made| !made.is_empty() && key.starts_with(made));
        assert!(asked || event(key), "nobody asks for {key}");
    }
}

#[test]
fn every_service_status_register_bit_verdict_and_rule_has_its_text() {
    let english = texts("en");
    for service in 0..16 {
        assert!(english.contains_key(&format!("service.{service}")));
        assert!(english.contains_key(&format!("status.{service}")));
    }
    for rule in RULES {
        for kind in ["broken", "advice"] {
            assert!(english.contains_key(&format!("{kind}.{}", rule.name())), "{kind} {}", rule.name());
        }
    }
    for cause in CAUSES {
        assert!(english.contains_key(&format!("cause.{}", cause.name())), "{}", cause.name());
    }
    for verdict in Judgement::WORDS {
        assert!(english.contains_key(&format!("worth.{verdict}")), "{verdict}");
    }
    for (_, name) in encoring_ring::diagnostics::STATUS_BITS {
        assert!(english.contains_key(&format!("register.{name}")), "{name}");
    }
}
