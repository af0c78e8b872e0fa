//! Findings for people and for programs.

use std::fmt;

use encoring_host::referee::rule::{Severity, Vantage};
use encoring_host::referee::{Finding, HandshakeRule, WRITES_ASSUMED};
use encoring_words::Duration;
use serde::Serialize;

/// A finding.
#[derive(Serialize)]
pub(super) struct FindingView {
    rule: &'static str,
    verdict: &'static str,
    severity: &'static str,
    position: u8,
    first_us: u64,
    last_us: u64,
    count: u32,
    out: String,
    #[serde(rename = "in")]
    input: Option<String>,
    statement: &'static str,
    advice: String,
    seen_from: &'static str,
}

impl FindingView {
    pub(super) fn new(position: u8, finding: &Finding, vantage: Vantage) -> Self {
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
            out: finding.out.to_string(),
            input: finding.input.map(|input| input.to_string()),
            statement: rule.statement(),
            advice,
            seen_from: vantage.letter(),
        }
    }
}

impl fmt::Display for FindingView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rule, verdict, severity, position, out, statement, .. } = self;
        let note = Severity::Note.name();
        let head = if *severity == note { note.to_owned() } else { format!("{severity}, {verdict}") };
        write!(f, "position {position}: {rule} ({head}) ")?;
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

/// What stands below the findings.
#[derive(Serialize)]
pub(super) struct EndView {
    not_judged: Vec<&'static str>,
    seen_from: &'static str,
    #[serde(skip)]
    services: u64,
}

impl EndView {
    pub(super) fn new(not_judged: &[HandshakeRule], vantage: Vantage, services: u64) -> Self {
        let not_judged = not_judged.iter().map(|rule| rule.name()).collect();
        Self { not_judged, seen_from: vantage.letter(), services }
    }
}

impl fmt::Display for EndView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { not_judged, seen_from, services } = self;
        match services {
            0 => writeln!(f, "no service was seen")?,
            1 => writeln!(f, "1 service was seen")?,
            services => writeln!(f, "{services} services were seen")?,
        }
        let names = if not_judged.is_empty() { "none".to_owned() } else { not_judged.join(", ") };
        writeln!(f, "not judged from here ({seen_from}): {names}")
    }
}
