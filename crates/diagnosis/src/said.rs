//! The sentences of a diagnosis as codes and values, beside the English ones.

use encoring_texts::{Said, SaidTemplate};
use serde::Serialize;

use crate::episode::{Conclusion, Episode};
use crate::{apart, evidence, statements};

/// Every sentence that a diagnosis can say.
pub fn sentences() -> impl Iterator<Item = &'static SaidTemplate> {
    evidence::TEXTS.iter().chain(statements::TEXTS).chain(apart::TEXTS)
}

/// What is said of an episode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct SaidOfEvent {
    evidence: Vec<Said>,
    apart: Vec<Said>,
}

/// The sentences of a report as codes and values, in its order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SaidReport {
    events: Vec<SaidOfEvent>,
    judged: Vec<Said>,
    limits: Vec<Said>,
}

impl SaidReport {
    /// That of a recording.
    #[must_use]
    pub fn new(conclusion: &Conclusion) -> Self {
        let of = |episode: &Episode| SaidOfEvent {
            evidence: episode.evidence.clone(),
            apart: episode.apart.clone(),
        };
        Self {
            events: conclusion.episodes.iter().map(of).collect(),
            judged: conclusion.judged.clone(),
            limits: conclusion.limits.clone(),
        }
    }
}

/// Sentences as they are printed.
pub(crate) fn printed(said: &[Said]) -> Vec<String> {
    said.iter().map(Said::to_string).collect()
}
