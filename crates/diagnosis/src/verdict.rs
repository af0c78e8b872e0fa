//! A cause with what speaks for it and what else it may be.

use encoring_texts::Said;

use crate::apart::telling;
use crate::cause::{JumpCause, Likelihood};
use crate::episode::ALTERNATIVES_MAX;
use crate::services::Services;

/// What rows are judged to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Judged {
    pub(crate) cause: JumpCause,
    pub(crate) certainty: Likelihood,
    pub(crate) alternatives: Vec<JumpCause>,
    pub(crate) evidence: Vec<Said>,
}

impl Judged {
    pub(crate) fn new(cause: JumpCause, certainty: Likelihood, evidence: Said) -> Self {
        Self { cause, certainty, alternatives: Vec::new(), evidence: vec![evidence] }
    }

    pub(crate) fn certain(cause: JumpCause, evidence: Said) -> Self {
        Self::new(cause, Likelihood::Certain, evidence)
    }

    pub(crate) fn likely(cause: JumpCause, evidence: Said) -> Self {
        Self::new(cause, Likelihood::Likely, evidence)
    }

    pub(crate) fn possible(cause: JumpCause, evidence: Said) -> Self {
        Self::new(cause, Likelihood::Possible, evidence)
    }

    /// With what else it may be.
    pub(crate) fn or(mut self, others: &[JumpCause]) -> Self {
        for other in others {
            if *other != self.cause
                && !self.alternatives.contains(other)
                && self.alternatives.len() < ALTERNATIVES_MAX
            {
                self.alternatives.push(*other);
            }
        }
        self
    }

    /// With what else it may be before all others, where the cause cannot be told.
    pub(crate) fn or_first(mut self, other: JumpCause) -> Self {
        if self.cause == JumpCause::Unclear && self.alternatives.first() != Some(&other) {
            self.alternatives.retain(|known| *known != other);
            self.alternatives.insert(0, other);
            self.alternatives.truncate(ALTERNATIVES_MAX);
        }
        self
    }

    /// With more that speaks for it.
    pub(crate) fn since(mut self, evidence: Said) -> Self {
        self.evidence.push(evidence);
        self
    }

    /// Where motion explains everything: what is only likely is no more than one of several.
    pub(crate) fn doubted(self) -> Self {
        if self.certainty == Likelihood::Certain || self.cause == JumpCause::Unclear {
            return self;
        }
        let Self { cause, alternatives, evidence, .. } = self;
        let doubted = Self {
            cause: JumpCause::Unclear,
            certainty: Likelihood::Possible,
            alternatives: vec![cause],
            evidence,
        };
        doubted.or(&alternatives)
    }

    /// What would tell the cause from the others, beside what was seen of services; none if there are none.
    pub(crate) fn apart(&self, services: &Services) -> Vec<Said> {
        let mut told: Vec<Said> = Vec::new();
        if self.alternatives.is_empty() {
            return told;
        }
        for cause in [self.cause].into_iter().chain(self.alternatives.iter().copied()) {
            told.extend(telling(cause, services).filter(|what| !told.contains(what)));
        }
        told
    }
}
