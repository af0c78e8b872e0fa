//! The line of what is wrong in a TOML text.

use std::fmt;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::line_at;

/// What is wrong with a text, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misfit {
    /// The line, from 1, where one is at fault.
    pub line: Option<usize>,
    /// What is wrong.
    pub problem: String,
}

/// Reads a text into values.
///
/// # Errors
/// [`Misfit`].
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Misfit> {
    toml::from_str(text).map_err(|cause| {
        let line = match cause.span() {
            Some(span) => Some(line_at(text, span.start)),
            None => first_line_with(text, cause.message()),
        };
        Misfit { line, problem: plain(cause.message()) }
    })
}

/// What the parser says, in one line and without its inner types.
fn plain(message: &str) -> String {
    let number = message.strip_prefix("invalid type: integer `").and_then(|rest| rest.split_once("` as "));
    match number {
        Some((number, _)) => {
            format!("{number} is outside {}..{}, the whole numbers of a file", i64::MIN, i64::MAX)
        }
        None => message.replace('\n', "; "),
    }
}

/// Refuses a text that ends right behind a number or a bare word of its last line: if it was cut there, what is left of a
/// number is another number. A value that is closed, or that a space or a comment follows, is whole.
///
/// # Errors
/// [`Misfit`] with the last line.
pub fn ends_whole(text: &str) -> Result<(), Misfit> {
    let last = text.rsplit('\n').next().unwrap_or(text);
    let open = last.ends_with(|sign: char| sign.is_alphanumeric() || "_.+-".contains(sign));
    if !open || last.contains('#') {
        return Ok(());
    }
    Err(Misfit {
        line: Some(line_at(text, text.len())),
        problem: format!(
            "the file ends within its last line, behind {:?}: it may have been cut off there; if it is whole, add a line end",
            last.trim_start()
        ),
    })
}

/// As [`parse`], with hexadecimal numbers of the tables of one name as the text that was typed, so that they keep their base.
///
/// # Errors
/// [`Misfit`].
pub fn parse_as_typed<T: DeserializeOwned>(text: &str, table: &str) -> Result<T, Misfit> {
    let Ok(mut whole) = DeTable::parse(text) else { return parse(text) };
    keep_typed(whole.get_mut(), table, Within::Other);
    T::deserialize(toml::Deserializer::from(whole)).or_else(|_| parse(text))
}

/// Whether a table is in one whose numbers keep their base.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Within {
    Typed,
    Other,
}

fn keep_typed(table: &mut DeTable<'_>, name: &str, within: Within) {
    for (key, value) in table.iter_mut() {
        let within = if key.get_ref() == name { Within::Typed } else { within };
        keep_typed_value(value.get_mut(), name, within);
    }
}

fn keep_typed_value(value: &mut DeValue<'_>, name: &str, within: Within) {
    match value {
        DeValue::Table(table) => keep_typed(table, name, within),
        DeValue::Array(items) => {
            items.iter_mut().for_each(|item| keep_typed_value(item.get_mut(), name, within));
        }
        DeValue::Integer(number) if within == Within::Typed && number.radix() == 16 => {
            *value = DeValue::String(number.to_string().into());
        }
        _ => {}
    }
}

/// The first line that brings an error for which the parser names no place.
fn first_line_with(text: &str, message: &str) -> Option<usize> {
    let brings = |end: usize| {
        let before = text.get(..end).unwrap_or(text);
        DeTable::parse(before).is_err_and(|cause| cause.span().is_none() && cause.message() == message)
    };
    let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).chain([text.len()]).collect();
    let line = ends.partition_point(|end| !brings(*end));
    (line < ends.len()).then_some(line + 1)
}

/// One step on the way to a value.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Index(usize),
}

/// A value that was read and cannot be: what is wrong, and the way to it through the tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// From the value outwards.
    way: Vec<Step>,
    problem: String,
    outside: Option<Box<Outside>>,
}

/// A value outside its limits, as it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outside {
    /// Its key.
    pub key: String,
    /// The value.
    pub value: String,
    /// The lowest one.
    pub low: String,
    /// The highest one.
    pub high: String,
}

impl Wrong {
    /// Of no value in particular.
    #[must_use]
    pub fn new(problem: impl Into<String>) -> Self {
        Self { way: Vec::new(), problem: problem.into(), outside: None }
    }

    /// The value of this key.
    #[must_use]
    pub fn at(key: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::new(problem).inside(key)
    }

    /// The value of this key is none within its limits.
    #[must_use]
    pub fn outside(outside: Outside) -> Self {
        let Outside { key, value, low, high } = &outside;
        let told = Self::at(key, format!("{key} {value}; the limits are {low} and {high}"));
        Self { outside: Some(Box::new(outside)), ..told }
    }

    /// The value and its limits, if that is what is wrong.
    #[must_use]
    pub fn beyond(&self) -> Option<&Outside> {
        self.outside.as_deref()
    }

    /// The table that was looked at so far is the value of this key.
    #[must_use]
    pub fn inside(mut self, key: impl Into<String>) -> Self {
        self.way.push(Step::Key(key.into()));
        self
    }

    /// The value that was looked at so far is this one of an array, from 0.
    #[must_use]
    pub fn inside_item(mut self, index: usize) -> Self {
        self.way.push(Step::Index(index));
        self
    }

    /// What is wrong, in other words.
    #[must_use]
    pub fn told(mut self, tell: impl FnOnce(String) -> String) -> Self {
        self.problem = tell(self.problem);
        self
    }

    /// With the line of the value, or of the innermost table on the way that is in the text.
    #[must_use]
    pub fn in_text(self, text: &str) -> Misfit {
        Misfit { line: line_of(text, &self.way), problem: self.problem }
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.problem)
    }
}

impl From<Wrong> for String {
    fn from(wrong: Wrong) -> Self {
        wrong.problem
    }
}

fn line_of(text: &str, way: &[Step]) -> Option<usize> {
    let table = DeTable::parse(text).ok()?.into_inner();
    let table = DeValue::Table(table);
    let (mut value, mut found) = (&table, None);
    for step in way.iter().rev() {
        let Some((next, start)) = go(value, step) else { break };
        (value, found) = (next, Some(start));
    }
    found.map(|start| line_at(text, start))
}

/// The value one step further, and where it begins: with its key, if it has one.
fn go<'v, 'i>(value: &'v DeValue<'i>, step: &Step) -> Option<(&'v DeValue<'i>, usize)> {
    match (value, step) {
        (DeValue::Table(table), Step::Key(key)) => {
            let (key, value) = table.get_key_value(key.as_str())?;
            Some((value.get_ref(), key.span().start))
        }
        (DeValue::Array(items), Step::Index(index)) => {
            let item = items.get(*index)?;
            Some((item.get_ref(), item.span().start))
        }
        _ => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    const TEXT: &str = "\
version = 1
[[event]]
at_s = 1
set.preset1_v = 24.0
set.preset2_v = 99.0
[[event]]
at_s = 2
set = { motion = { kind = \"moves\", moves = [
    { to = 1 },
    { to = 2, in_s = 3 },
] } }
[event.more]
at_s = 4
";

    fn line(wrong: Wrong) -> Option<usize> {
        wrong.in_text(TEXT).line
    }

    #[test]
    fn a_number_that_is_too_large_is_told_with_its_line_and_the_limits() {
        for number in ["99999999999999999999", "-99999999999999999999"] {
            let misfit = parse::<toml::Table>(&format!("a = 1\nb = {number}\n")).unwrap_err();
            let told = format!(
                "{number} is outside -9223372036854775808..9223372036854775807, the whole numbers of a file"
            );
            assert_eq!(misfit, Misfit { line: Some(2), problem: told });
        }
    }

    #[test]
    fn the_line_is_that_of_the_value_at_the_end_of_the_way() {
        let event = |wrong: Wrong, index| line(wrong.inside_item(index).inside("event"));
        assert_eq!(line(Wrong::at("version", "")), Some(1));
        assert_eq!(event(Wrong::at("at_s", ""), 0), Some(3));
        assert_eq!(event(Wrong::at("preset1_v", "").inside("set"), 0), Some(4));
        assert_eq!(event(Wrong::at("preset2_v", "").inside("set"), 0), Some(5));
        assert_eq!(event(Wrong::at("at_s", ""), 1), Some(7));
        let to =
            |index| Wrong::at("to", "").inside_item(index).inside("moves").inside("motion").inside("set");
        assert_eq!((event(to(0), 1), event(to(1), 1)), (Some(9), Some(10)));
        assert_eq!(event(Wrong::at("at_s", "").inside("more"), 1), Some(13));
    }

    #[test]
    fn a_way_that_leads_nowhere_ends_at_the_last_table_that_is_there() {
        assert_eq!(line(Wrong::at("missing", "").inside_item(1).inside("event")), Some(6));
        assert_eq!(line(Wrong::at("missing", "")), None);
        assert_eq!(line(Wrong::new("")), None);
        assert_eq!(Wrong::at("version", "").in_text("version = ").line, None);
    }

    #[test]
    fn what_is_no_toml_is_told_with_its_line() {
        let misfit = parse::<toml::Table>("a = 1\nb = [\n").unwrap_err();
        assert!(misfit.line.is_some_and(|line| line >= 2), "{misfit:?}");
        for deep in [
            format!("x = {}{}", "[".repeat(200), "]".repeat(200)),
            format!("x{} = 1", ".x".repeat(200)),
            format!("[x{}]\ny = 1", ".x".repeat(200)),
            format!("x = {}{}", "{ x = ".repeat(200), "}".repeat(200)),
        ] {
            let misfit = parse::<toml::Table>(&format!("a = 1\nb = 2\n{deep}\nc = 4\n")).unwrap_err();
            assert_eq!(misfit.line, Some(3), "{misfit:?}");
        }
    }
}
