//! The names of columns: ours, those of others, and those that look like ours.

use super::time::Unit;
use crate::columns::Column;

/// What a column of a table is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// One of our columns.
    Own(Column),
    /// A time in a unit.
    Time(Unit),
    /// A time whose unit stands in its name, or a date.
    TimeAsNamed,
    /// One half of a word.
    Half(Word, Half),
}

/// One of the two words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Out,
    In,
}

/// One of the two halves of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    High,
    Low,
}

/// Names beside those of [`Column`].
const FURTHER: [(&str, Meaning); 8] = [
    ("time", Meaning::TimeAsNamed),
    ("time_s", Meaning::Time(Unit::S)),
    ("time_ms", Meaning::Time(Unit::Ms)),
    ("time_ns", Meaning::Time(Unit::Ns)),
    ("in_high", Meaning::Half(Word::In, Half::High)),
    ("in_low", Meaning::Half(Word::In, Half::Low)),
    ("out_high", Meaning::Half(Word::Out, Half::High)),
    ("out_low", Meaning::Half(Word::Out, Half::Low)),
];

/// What others call a time.
const TIMES: [&str; 5] = ["time", "timestamp", "zeit", "zeitstempel", "t"];

/// Those of them that mean a time whatever stands in brackets behind them.
const LONG_TIMES: [&str; 4] = ["time", "timestamp", "zeit", "zeitstempel"];

impl Meaning {
    /// Every name with what it means.
    pub(super) fn all() -> impl Iterator<Item = (&'static str, Self)> {
        let own = Column::ALL.into_iter().map(|column| (column.name(), Self::Own(column).plain()));
        FURTHER.into_iter().chain(own)
    }

    /// The meaning of one of our names, case aside.
    pub(super) fn named(name: &str) -> Option<Self> {
        Self::all().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, meaning)| meaning)
    }

    /// A name of ours for it.
    pub(super) fn name(self) -> &'static str {
        Self::all().find(|(_, meaning)| *meaning == self).map_or("time", |(name, _)| name)
    }

    /// The time in microseconds is one of the times.
    fn plain(self) -> Self {
        if self == Self::Own(Column::Time) { Self::Time(Unit::Us) } else { self }
    }

    pub(super) fn is_time(self) -> bool {
        matches!(self, Self::Time(_) | Self::TimeAsNamed)
    }

    /// Whether a table without it could still be of use.
    pub(super) fn is_content(self) -> bool {
        !self.is_time() && !matches!(self, Self::Own(Column::Position | Column::Verdict))
    }
}

/// What a name in a header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recognised {
    As(Meaning),
    /// It may be meant for this one of our names.
    Close(&'static str),
    Other,
}

pub(super) fn recognise(name: &str) -> Recognised {
    let lower = name.trim().to_lowercase();
    let (stem, unit) = unit_apart(&lower);
    match unit {
        // T [°C] is no time.
        None if TIMES.contains(&stem) || LONG_TIMES.contains(&before_brackets(stem)) => {
            return Recognised::As(Meaning::TimeAsNamed);
        }
        Some(unit) if TIMES.contains(&stem) => return Recognised::As(Meaning::Time(unit)),
        _ => {}
    }
    match Meaning::named(&lower) {
        Some(meaning) => Recognised::As(meaning),
        None => close(&lower).map_or(Recognised::Other, Recognised::Close),
    }
}

/// A name without its unit, and the unit: `Time [ms]`, `t (s)`, `t/ms`, `Time in s`.
pub(super) fn unit_apart(name: &str) -> (&str, Option<Unit>) {
    let name = name.trim();
    let apart = [("[", "]"), ("(", ")"), ("/", ""), (" in ", "")].into_iter().find_map(|(open, close)| {
        let (stem, rest) = name.rsplit_once(open)?;
        let unit = Unit::named(rest.strip_suffix(close)?.trim())?;
        Some((stem.trim_end(), unit))
    });
    apart.map_or((name, None), |(stem, unit)| (stem, Some(unit)))
}

/// A name without what stands in brackets behind it.
fn before_brackets(name: &str) -> &str {
    let behind = name.ends_with([']', ')']).then(|| name.find(['[', '('])).flatten();
    name.get(..behind.unwrap_or(name.len())).unwrap_or(name).trim_end()
}

/// One of our names that this one could be meant for: the same letters otherwise written, one letter too many, too few
/// or exchanged, or a word of it that is IN or OUT.
fn close(lower: &str) -> Option<&'static str> {
    let letters = |name: &str| name.chars().filter(|letter| letter.is_alphanumeric()).collect::<String>();
    let written = letters(lower);
    let alike = |ours: &str| {
        let ours = letters(ours);
        let one_off = written.len().abs_diff(ours.len()) < 2 && strsim::osa_distance(&written, &ours) == 1;
        one_off && ours.len() > 3 || one_off && written.len() != ours.len() && written.starts_with(&ours)
    };
    let names = || Meaning::all().map(|(name, _)| name);
    let known = names().find(|name| written == letters(name)).or_else(|| names().find(|name| alike(name)));
    let mut pieces = lower.split(|letter: char| !letter.is_alphanumeric());
    known.or_else(|| {
        pieces.find_map(|piece| match piece {
            "in" | "input" => Some("in"),
            "out" | "output" => Some("out"),
            _ => None,
        })
    })
}
