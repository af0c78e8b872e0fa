//! The cause of a jump, for people in one line and for programs.

use std::fmt;

use serde::Serialize;

use crate::cause::JumpCause;
use crate::episode::Episode;
use crate::said::{SaidOfEvent, printed};

/// What was found of a jump.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FoundView {
    /// Its name for programs.
    pub cause: &'static str,
    /// How sure it is.
    pub certainty: &'static str,
    /// What else it may be, the likeliest first.
    pub alternatives: Vec<&'static str>,
    /// What would tell them apart; empty if nothing else is possible.
    pub apart: String,
    /// What speaks for it.
    pub evidence: Vec<String>,
    /// The sentences as codes and values.
    #[serde(skip)]
    pub said: SaidOfEvent,
    /// The cause for people.
    #[serde(skip)]
    pub title: &'static str,
}

impl FoundView {
    /// That of an episode.
    #[must_use]
    pub fn new(episode: &Episode) -> Self {
        Self {
            cause: episode.cause.name(),
            certainty: episode.certainty.name(),
            alternatives: episode.alternatives.iter().copied().map(JumpCause::name).collect(),
            apart: printed(&episode.apart).join("; "),
            evidence: printed(&episode.evidence),
            said: episode.into(),
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
