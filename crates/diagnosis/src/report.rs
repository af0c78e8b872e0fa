//! What was found, for people and for programs.

use std::fmt;

use encoring_texts::Said;
use encoring_words::Duration;
use encoring_words::sheet::StepChange;
use serde::Serialize;

use crate::episode::Episode;
use crate::found::FoundView;
use crate::manual::{is_of_the_manual, step_changes};
use crate::recorded::Diagnosed;

/// An episode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReportedEvent {
    file: String,
    line: u64,
    to_line: u64,
    count: u64,
    time_us: u64,
    position: u8,
    #[serde(flatten)]
    found: FoundView,
    /// The manual's table of causes and remedies is about it [R150..R153].
    #[serde(skip)]
    is_of_the_manual: bool,
}

/// What was found in some recordings: as it is printed, or with the keys of `docs/json.md`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct DiagnosisReport {
    events: Vec<ReportedEvent>,
    judged: Vec<String>,
    limits: Vec<String>,
    /// Any jump could be judged.
    #[serde(skip)]
    is_judged: bool,
}

impl ReportedEvent {
    fn new(file: &str, episode: &Episode) -> Self {
        Self {
            file: file.to_owned(),
            line: episode.line,
            to_line: episode.to_line,
            count: episode.count,
            time_us: episode.time_ns / 1_000,
            position: episode.position,
            found: FoundView::new(episode),
            is_of_the_manual: is_of_the_manual(episode),
        }
    }
}

impl DiagnosisReport {
    /// That of these recordings, in their order.
    #[must_use]
    pub fn new(diagnosed: &[Diagnosed]) -> Self {
        let events = |file: &Diagnosed| {
            let name = file.name.clone();
            file.conclusion
                .episodes
                .iter()
                .map(|episode| ReportedEvent::new(&name, episode))
                .collect::<Vec<_>>()
        };
        let sentences = |of: fn(&Diagnosed) -> &[Said]| {
            let several = diagnosed.len() > 1;
            let named = |file: &Diagnosed, sentence: &Said| match several {
                true => format!("{}: {sentence}", file.name),
                false => sentence.to_string(),
            };
            diagnosed
                .iter()
                .flat_map(|file| of(file).iter().map(move |sentence| named(file, sentence)))
                .collect()
        };
        Self {
            events: diagnosed.iter().flat_map(events).collect(),
            judged: sentences(|file| &file.conclusion.judged),
            limits: sentences(|file| &file.conclusion.limits),
            is_judged: diagnosed.iter().any(Diagnosed::is_judged),
        }
    }
}

impl fmt::Display for ReportedEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} line {}", self.file, self.line)?;
        if self.to_line != self.line {
            write!(f, " to {}", self.to_line)?;
        }
        let at = Duration::from_micros(self.time_us);
        let FoundView { title, certainty, evidence, alternatives, apart, .. } = &self.found;
        writeln!(f, ", {at}, position {}: {title}, {certainty}", self.position)?;
        for evidence in evidence {
            writeln!(f, "  {evidence}")?;
        }
        if !alternatives.is_empty() {
            writeln!(f, "  or {}", alternatives.join(", "))?;
        }
        if !apart.is_empty() {
            writeln!(f, "  to tell them apart: {apart}")?;
        }
        Ok(())
    }
}

impl fmt::Display for DiagnosisReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        for limit in &self.limits {
            text += &format!("{limit}\n");
        }
        if self.judged.is_empty() {
            text += "nothing could be judged: no row holds a position\n";
        } else if self.events.is_empty() && self.is_judged {
            text += "no step change\n";
        }
        // As the picture and the page number them.
        for (number, event) in (1..).zip(&self.events) {
            text += &format!("{number}. {event}");
        }
        if self.events.iter().any(|event| event.is_of_the_manual) {
            text += "what may be mechanical or electrical has these causes and remedies in the manual:\n";
            for StepChange { cause, remedy } in step_changes() {
                text += &format!("  {cause}: {remedy}\n");
            }
        }
        for judged in &self.judged {
            text += &format!("judged: {judged}\n");
        }
        f.write_str(&text)
    }
}
