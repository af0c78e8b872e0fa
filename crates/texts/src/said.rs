//! A sentence, and what is known of it beforehand.

use std::fmt;

use encoring_words::Duration;
use serde::ser::{Serialize, SerializeMap, SerializeStruct, Serializer};

use crate::number::{Decimal, Hex};

/// A sentence: in English for people, and as its code with named values for whoever says it in another language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    origin: Origin,
    text: String,
    values: Vec<(&'static str, SaidValue)>,
}

/// Where its English text comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// From the template of this code.
    Template(&'static str),
    /// From a library that knows no codes; this is the code of what it says.
    Retold(&'static str),
    /// The text is its own code.
    Itself,
}

/// A sentence without its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SaidTemplate {
    /// Its code.
    pub code: &'static str,
    /// The English sentence, with the names of its values in braces; empty where another library has it.
    pub english: &'static str,
    /// The names of its values.
    pub values: &'static [&'static str],
}

impl Said {
    /// A sentence with these values. The macro [`crate::texts`] calls this.
    #[must_use]
    pub const fn new(code: &'static str, text: String, values: Vec<(&'static str, SaidValue)>) -> Self {
        Self { origin: Origin::Template(code), text, values }
    }

    /// What another library says, in its words, as the code of it. The macro [`crate::retold`] calls this.
    #[must_use]
    pub const fn retold(code: &'static str, text: String, values: Vec<(&'static str, SaidValue)>) -> Self {
        Self { origin: Origin::Retold(code), text, values }
    }

    /// A statement without values, which is its own code: what a manual says of one thing and nothing else.
    #[must_use]
    pub const fn stated(text: String) -> Self {
        Self { origin: Origin::Itself, text, values: Vec::new() }
    }

    /// Its code.
    #[must_use]
    pub fn code(&self) -> &str {
        match self.origin {
            Origin::Template(code) | Origin::Retold(code) => code,
            Origin::Itself => &self.text,
        }
    }

    /// Its values, by their names.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, &SaidValue)> {
        self.values.iter().map(|(name, value)| (*name, value))
    }

    /// The English sentence.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for Said {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

struct Values<'a>(&'a [(&'static str, SaidValue)]);

impl Serialize for Values<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.end()
    }
}

/// Its code and values; the English sentence is beside them only where another library has it.
impl Serialize for Said {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let is_retold = matches!(self.origin, Origin::Retold(_));
        let mut said = serializer.serialize_struct("Said", if is_retold { 3 } else { 2 })?;
        said.serialize_field("code", self.code())?;
        said.serialize_field("values", &Values(&self.values))?;
        if is_retold {
            said.serialize_field("text", &self.text)?;
        }
        said.end()
    }
}

/// A value of a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SaidValue {
    /// A whole number; a time in nanoseconds, if its name ends in `_ns`.
    Number(i64),
    /// A number with decimal places.
    Decimal(Decimal),
    /// What is written the same in every language: names, words in hex, what somebody typed.
    Text(String),
    /// A part that has a code of its own.
    Said(Said),
}

impl Serialize for SaidValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => serializer.serialize_i64(*number),
            Self::Decimal(Decimal::Tenths(tenths)) => serializer.serialize_f64(*tenths as f64 / 10.0),
            Self::Decimal(Decimal::Hundredths(parts)) => serializer.serialize_f64(*parts as f64 / 100.0),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Said(said) => said.serialize(serializer),
        }
    }
}

macro_rules! numbers {
    ($($type:ty),+) => {
        $(impl From<$type> for SaidValue {
            fn from(number: $type) -> Self {
                Self::Number(number.into())
            }
        })+
    };
}

numbers!(u8, u16, u32, i32, i64);

/// Counts and times are far below the limit.
impl From<u64> for SaidValue {
    fn from(number: u64) -> Self {
        Self::Number(i64::try_from(number).unwrap_or(i64::MAX))
    }
}

impl From<usize> for SaidValue {
    fn from(number: usize) -> Self {
        Self::from(number as u64)
    }
}

impl From<Duration> for SaidValue {
    fn from(time: Duration) -> Self {
        Self::from(time.as_nanos())
    }
}

impl From<Decimal> for SaidValue {
    fn from(number: Decimal) -> Self {
        Self::Decimal(number)
    }
}

impl<const DIGITS: usize> From<Hex<DIGITS>> for SaidValue {
    fn from(number: Hex<DIGITS>) -> Self {
        Self::Text(number.to_string())
    }
}

impl From<&str> for SaidValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for SaidValue {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<Said> for SaidValue {
    fn from(said: Said) -> Self {
        Self::Said(said)
    }
}
