//! A cause with what speaks for it and what else it may be.

use crate::cause::{JumpCause, Likelihood};
use crate::episode::ALTERNATIVES_MAX;
use crate::services::Services;

/// What rows are judged to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Judged {
    pub(crate) cause: JumpCause,
    pub(crate) certainty: Likelihood,
    pub(crate) alternatives: Vec<JumpCause>,
    pub(crate) evidence: Vec<String>,
}

impl Judged {
    pub(crate) fn new(cause: JumpCause, certainty: Likelihood, evidence: impl Into<String>) -> Self {
        Self { cause, certainty, alternatives: Vec::new(), evidence: vec![evidence.into()] }
    }

    pub(crate) fn certain(cause: JumpCause, evidence: impl Into<String>) -> Self {
        Self::new(cause, Likelihood::Certain, evidence)
    }

    pub(crate) fn likely(cause: JumpCause, evidence: impl Into<String>) -> Self {
        Self::new(cause, Likelihood::Likely, evidence)
    }

    pub(crate) fn possible(cause: JumpCause, evidence: impl Into<String>) -> Self {
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
    pub(crate) fn since(mut self, evidence: impl Into<String>) -> Self {
        self.evidence.push(evidence.into());
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

    /// What would tell the cause from the others, beside what was seen of services; empty if there are none.
    pub(crate) fn apart(&self, services: &Services) -> String {
        let mut told: Vec<&str> = Vec::new();
        for cause in [self.cause].into_iter().chain(self.alternatives.iter().copied()) {
            let what = telling(cause, services);
            if !self.alternatives.is_empty() && !what.is_empty() && !told.contains(&what) {
                told.push(what);
            }
        }
        told.join("; ")
    }
}

/// What shows whether it is this cause or another.
const fn telling(cause: JumpCause, services: &Services) -> &'static str {
    match cause {
        JumpCause::ReplyAsPosition => "log the whole word: bit 31 tells a reply",
        JumpCause::TornWords => {
            "log faster, both halves in one access: a torn word stands where the high half changes"
        }
        JumpCause::SingleBit => {
            "log faster: a wrong bit comes anywhere, not only where the high half changes"
        }
        JumpCause::HalvesExchanged => "log the whole word",
        JumpCause::GrayAsBinary | JumpCause::BinaryAsGray => "read service 01: its byte 1 is the code",
        JumpCause::Wrap => "give S with --parameters",
        JumpCause::Preset if services.shows_out() => "an input that made a preset shows at its pin",
        JumpCause::Rescaled | JumpCause::Direction if services.shows_out() => "let the axis go on evenly",
        JumpCause::Frozen if services.shows_out() => "log the master's status too",
        JumpCause::Preset => "log OUT too: service 06 shows there; an input shows at its pin",
        JumpCause::Rescaled | JumpCause::Direction => {
            "log OUT too: services 01, 02, 03, 09 show there; or let the axis go on evenly"
        }
        JumpCause::ZeroLost => "look at the mark, and give what it shows with --known",
        JumpCause::Aliasing => "log once a refresh time, or slower than 4 of them",
        JumpCause::OverSpeed | JumpCause::OverAcceleration => {
            "log faster, and give what the axis does at most with --max-rpm"
        }
        JumpCause::StuckBit => "let the axis pass the bit three times",
        JumpCause::Noise => "let the axis stand still",
        JumpCause::Frozen => "log OUT and the master's status too",
        JumpCause::OtherSource => "log the encoder beside it too",
        JumpCause::Mechanical => "look at the mark on shaft and coupling",
        JumpCause::Unclear => "",
    }
}
