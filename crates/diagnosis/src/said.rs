//! The sentences of a diagnosis as codes and values, beside the English ones.

use encoring_texts::{Said, SaidTemplate};
use encoring_words::sheet::StepChange;
use serde::Serialize;

use crate::episode::{Conclusion, Episode};
use crate::manual::{is_of_the_manual, step_changes};
use crate::{apart, evidence, labels, statements, unread};

/// Every sentence that a diagnosis can say.
pub fn sentences() -> impl Iterator<Item = &'static SaidTemplate> {
    evidence::TEXTS.iter().chain(statements::TEXTS).chain(apart::TEXTS).chain(labels::TEXTS)
}

/// What is said of an episode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SaidOfEvent {
    /// What speaks for its cause.
    pub evidence: Vec<Said>,
    /// What would tell it from others.
    pub apart: Vec<Said>,
}

impl From<&Episode> for SaidOfEvent {
    fn from(episode: &Episode) -> Self {
        Self { evidence: episode.evidence.clone(), apart: episode.apart.clone() }
    }
}

/// The sentences of a report as codes and values, in its order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SaidReport {
    events: Vec<SaidOfEvent>,
    judged: Vec<Said>,
    limits: Vec<Said>,
    /// What the manual says of step changes, if one may be mechanical or electrical [R150..R153].
    remedies: Vec<Remedy>,
}

/// Every sentence that says why a recording cannot be read.
pub fn unreadable_sentences() -> impl Iterator<Item = &'static SaidTemplate> {
    unread::TEXTS.iter().chain(unread::RETOLD)
}

/// A cause of step changes with what helps.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct Remedy {
    cause: Said,
    remedy: Said,
}

impl From<&StepChange> for Remedy {
    fn from(stated: &StepChange) -> Self {
        let [cause, remedy] = [stated.cause, stated.remedy].map(|text| Said::stated(text.to_owned()));
        Self { cause, remedy }
    }
}

impl SaidReport {
    /// That of a recording.
    #[must_use]
    pub fn new(conclusion: &Conclusion) -> Self {
        Self {
            events: conclusion.episodes.iter().map(SaidOfEvent::from).collect(),
            judged: conclusion.judged.clone(),
            limits: conclusion.limits.clone(),
            remedies: if conclusion.episodes.iter().any(is_of_the_manual) {
                step_changes().iter().map(Remedy::from).collect()
            } else {
                Vec::new()
            },
        }
    }
}

/// Sentences as they are printed.
pub(crate) fn printed(said: &[Said]) -> Vec<String> {
    said.iter().map(Said::to_string).collect()
}
