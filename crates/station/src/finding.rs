//! What referees found, for people and for programs.

use std::fmt;

use encoring_host::referee::rule::{Severity, Vantage};
use encoring_host::referee::{Finding, Ruling, WRITES_ASSUMED};
use encoring_words::{Duration, InWord, OutWord};
use serde::Serialize;

use crate::json;

/// A rule that a program broke, and how.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FindingView {
    /// Its name.
    pub rule: &'static str,
    /// `broken`, `suspected` or `note`.
    pub verdict: &'static str,
    /// `error`, `warning` or `note`.
    pub severity: &'static str,
    /// The ring position.
    pub position: u8,
    /// When it was broken first.
    pub first_us: u64,
    /// And last.
    pub last_us: u64,
    /// How often.
    pub count: u32,
    /// OUT at the first break.
    #[serde(serialize_with = "json::text")]
    pub out: OutWord,
    /// IN then, if it was known.
    #[serde(rename = "in", serialize_with = "json::maybe_text")]
    pub input: Option<InWord>,
    /// What it rests on.
    pub statement: &'static str,
    /// What a program should do instead.
    pub advice: String,
    /// From where it was seen.
    pub seen_from: &'static str,
}

impl FindingView {
    /// That of a finding at a position.
    #[must_use]
    pub fn new(position: u8, finding: &Finding, vantage: Vantage) -> Self {
        let rule = finding.rule;
        let mut advice = rule.advice().to_owned();
        if let Some(days) = finding.days_to_wear() {
            advice += &format!(
                "; at this rate {WRITES_ASSUMED} writes, which a cell is assumed to stand, are made in "
            );
            advice += &match days {
                0 => "less than a day".to_owned(),
                1 => "a day".to_owned(),
                days => format!("{days} days"),
            };
        }
        Self {
            rule: rule.name(),
            verdict: finding.verdict.name(),
            severity: rule.severity().name(),
            position,
            first_us: finding.first.as_nanos() / 1_000,
            last_us: finding.last.as_nanos() / 1_000,
            count: finding.count,
            out: finding.out,
            input: finding.input,
            statement: rule.statement(),
            advice,
            seen_from: vantage.letter(),
        }
    }
}

impl FindingView {
    /// `true` if a rule of severity error was certainly broken.
    #[must_use]
    pub fn is_error(&self) -> bool {
        (self.severity, self.verdict) == (Severity::Error.name(), Ruling::Broken.name())
    }

    /// Rule, how sure and how bad it is, and what to do, in one line.
    #[must_use]
    pub fn told(&self) -> String {
        let Self { out, advice, statement, .. } = self;
        format!("{}, OUT {out}: {advice} [{statement}]", self.named())
    }

    /// Rule, and how sure and how bad it is.
    fn named(&self) -> String {
        let Self { rule, verdict, severity, .. } = self;
        let how =
            if *severity == *verdict { (*severity).to_owned() } else { format!("{severity}, {verdict}") };
        format!("{rule} ({how})")
    }
}

impl fmt::Display for FindingView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { out, statement, .. } = self;
        write!(f, "position {}: {} ", self.position, self.named())?;
        let first = Duration::from_micros(self.first_us);
        match self.count {
            1 => write!(f, "at {first}")?,
            count => write!(f, "{count} times from {first} to {}", Duration::from_micros(self.last_us))?,
        }
        write!(f, ": OUT {out}")?;
        if let Some(input) = &self.input {
            write!(f, ", IN {input}")?;
        }
        writeln!(f, " [{statement}]\n  {}", self.advice)
    }
}
