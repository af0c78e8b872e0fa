//! The cause of a jump, as it is printed.

use std::fmt;

use encoring_diagnosis::{Episode, JumpCause};
use serde::Serialize;

/// What was found of a jump.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FoundView {
    pub(crate) cause: &'static str,
    pub(crate) certainty: &'static str,
    pub(crate) alternatives: Vec<&'static str>,
    pub(crate) apart: String,
    pub(crate) evidence: Vec<String>,
    /// The cause for people.
    #[serde(skip)]
    pub(crate) title: &'static str,
}

impl FoundView {
    pub(crate) fn new(episode: &Episode) -> Self {
        Self {
            cause: episode.cause.name(),
            certainty: episode.certainty.name(),
            alternatives: episode.alternatives.iter().copied().map(JumpCause::name).collect(),
            apart: episode.apart.clone(),
            evidence: episode.evidence.clone(),
            title: episode.cause.title(),
        }
    }
}

/// In one line.
impl fmt::Display for FoundView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { title, certainty, evidence, alternatives, apart, .. } = self;
        write!(f, "cause of the jump: {title}, {certainty}: {}", evidence.join(", "))?;
        if !alternatives.is_empty() {
            write!(f, "; or {}", alternatives.join(", "))?;
        }
        if !apart.is_empty() {
            write!(f, "; to tell: {apart}")?;
        }
        Ok(())
    }
}
