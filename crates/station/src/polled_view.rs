//! What polls have shown of a ring, as plain data.

use std::fmt;

use encoring_bus::misread::Misread;
use encoring_bus::watch::{HandshakePhase, Sight, Subject, TOLD_BY_POLLS, Watch};
use encoring_bus::{Blind, Bus, BusError, Cause, Judgement, Link};
use encoring_diagnosis::{FoundView, SaidOfEvent};
use encoring_host::referee::{Finding, HandshakeRule, RULES, Vantage};
use encoring_host::validity::Why;
use encoring_ring::diagnostics::Diagnosis;
use encoring_words::{Duration, ErrorStatus, InWord, Model, OutWord};
use serde::Serialize;

use crate::causes::Causes;
use crate::finding::FindingView;
use crate::json;
use crate::known::{KnownEncoder, KnownParameter};
use crate::refereeing::RefereeView;
use crate::view::LampsView;

/// A ring behind a bus, as the last poll saw it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PolledView {
    /// Time on the bus in nanoseconds.
    pub time_ns: u64,
    /// From one poll to the next in nanoseconds.
    pub poll_ns: u64,
    /// Polls made.
    pub polls: u64,
    /// `good`, `silent` where the master says that the ring stands still, or `untold` where nobody tells.
    pub line: &'static str,
    /// The segment at fault, if the master has found one.
    pub segment: Option<usize>,
    /// How the connection is.
    pub link: LinkView,
    /// What the ring's master says, as far as the bus shows it.
    pub diagnosis: MasterSays,
    /// The encoders, in the order of their positions.
    pub devices: Vec<PolledDevice>,
    /// Which rules of the handshake were broken, as far as polls can judge that.
    pub referee: Option<RefereeView>,
}

/// How a connection is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LinkView {
    /// Whether there is one; `None`: nobody has tried yet.
    pub up: Option<bool>,
    /// Why there is none, as a code.
    pub cause: Option<&'static str>,
    /// And in words.
    pub text: Option<String>,
}

/// The master's diagnostic registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MasterSays {
    /// The status register.
    #[serde(serialize_with = "json::maybe_hex")]
    pub status: Option<u16>,
    /// The parameter register.
    #[serde(serialize_with = "json::maybe_hex")]
    pub parameter: Option<u16>,
}

/// One encoder as the last poll saw it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PolledDevice {
    /// Ring position from 0.
    pub position: usize,
    /// The vendor's number of the device, like `3.0`.
    pub device_number: String,
    /// Its model.
    #[serde(serialize_with = "json::text")]
    pub model: Model,
    /// The OUT word that stands on the bus, whoever wrote it; `None` where it cannot be read.
    #[serde(serialize_with = "json::maybe_text")]
    pub out: Option<OutWord>,
    /// The IN word; `None` if none came.
    #[serde(rename = "in", serialize_with = "json::maybe_text")]
    pub input: Option<InWord>,
    /// How old it may be.
    pub age_ns: Option<u64>,
    /// The position in steps, in binary code, if there is one.
    pub value: Option<u32>,
    /// What the IN word is worth: one of [`Judgement::WORDS`], or `unseen` before the first poll.
    pub verdict: &'static str,
    /// Why no word came, in words.
    pub text: Option<String>,
    /// What could not be judged.
    pub blind: Vec<&'static str>,
    /// Bit 29.
    pub error: bool,
    /// Where a service stands: `normal`, `busy`, `acknowledged`, `ending`, or `unknown`.
    pub handshake: &'static str,
    /// What is impossible of an implausible position.
    pub why: Option<WhyView>,
    /// How its words are turned round on their way, as one shows that no encoder sends: `halves`, `bytes` or
    /// `halves_and_bytes`.
    pub misread: Option<&'static str>,
    /// What was found of the jump that makes it implausible.
    pub likely: Option<LikelyView>,
    /// The error status, if a data check has told it since the error bit is set.
    #[serde(serialize_with = "json::status_if_on")]
    pub status: Option<ErrorStatus>,
    /// The largest position, as far as the judge knows it.
    pub measuring_length: Option<u32>,
    /// What is known of its parameters.
    pub parameters: Vec<KnownParameter>,
    /// What a data check would find in the programmed values, if enough of them is known.
    #[serde(serialize_with = "json::status_if_on")]
    pub data_check: Option<ErrorStatus>,
    /// Its lamps, of a simulated one.
    pub lamps: Option<LampsView>,
}

/// The cause of a jump as far as it can be told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LikelyView {
    /// Its name.
    pub cause: &'static str,
    /// How sure it is.
    pub certainty: &'static str,
    /// What else it may be, the likeliest first.
    pub alternatives: Vec<&'static str>,
    /// What speaks for it, and what would tell it from others, as codes and values.
    #[serde(flatten)]
    pub said: SaidOfEvent,
}

impl From<&FoundView> for LikelyView {
    fn from(found: &FoundView) -> Self {
        let FoundView { cause, certainty, alternatives, said, .. } = found.clone();
        Self { cause, certainty, alternatives, said }
    }
}

/// What is impossible of a position, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WhyView {
    /// The last plausible position.
    pub from: Option<u32>,
    /// The one that is not.
    pub to: Option<u32>,
    /// The most time that there was for the way.
    pub within_ns: Option<u64>,
    /// The largest position that there is.
    pub measuring_length: Option<u32>,
}

/// What is known beside the words of an encoder.
pub(crate) struct Beside<'a> {
    pub(crate) known: &'a [KnownEncoder],
    pub(crate) causes: &'a Causes,
    pub(crate) lamps: &'a dyn Fn(usize) -> Option<LampsView>,
}

const fn turned(way: Misread) -> &'static str {
    match way {
        Misread::Halves => "halves",
        Misread::Bytes => "bytes",
        Misread::HalvesAndBytes => "halves_and_bytes",
    }
}

impl WhyView {
    fn of(why: &Why) -> Self {
        match *why {
            Why::Foreign(_) => Self::default(),
            Why::Range { value, measuring_length } => {
                Self { to: Some(value), measuring_length: Some(measuring_length), ..Self::default() }
            }
            Why::OffTheRod { from, to, measuring_length } => Self {
                from: Some(from),
                to: Some(to),
                measuring_length: Some(measuring_length),
                ..Self::default()
            },
            Why::Speed { from, to, within } => {
                Self { from: Some(from), to: Some(to), within_ns: Some(within.as_nanos()), ..Self::default() }
            }
            Why::Acceleration { from, to } => Self { from: Some(from), to: Some(to), ..Self::default() },
        }
    }
}

impl fmt::Display for MasterSays {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Diagnosis { status: self.status, parameter: self.parameter }.fmt(f)
    }
}

/// What a master says, for programs.
pub(crate) const fn says(diagnosis: Diagnosis) -> MasterSays {
    MasterSays { status: diagnosis.status, parameter: diagnosis.parameter }
}

/// A finding of somebody who sees polls.
pub(crate) fn finding(position: u8, finding: &Finding) -> FindingView {
    FindingView::new(position, finding, Vantage::Log)
}

impl LinkView {
    pub(crate) fn of(what: &Link) -> Self {
        match what {
            Link::Up { .. } => Self { up: Some(true), cause: None, text: None },
            Link::Down { cause, .. } => Self::down(cause.clone()),
            Link::Failed { cause, .. } => Self::down(BusError::NoConnection(Cause::System(*cause))),
        }
    }

    fn down(cause: BusError) -> Self {
        let text = Some(cause.to_string());
        Self { up: Some(false), cause: Some(Judgement::NoAnswer(cause).word()), text }
    }
}

impl PolledView {
    /// Before the first poll.
    pub(crate) fn unseen(placed: &[(usize, Model)], every: Duration) -> Self {
        Self {
            time_ns: 0,
            poll_ns: every.as_nanos(),
            polls: 0,
            line: "untold",
            segment: None,
            link: LinkView::default(),
            diagnosis: MasterSays::default(),
            devices: placed.iter().map(|(position, model)| PolledDevice::unseen(*position, *model)).collect(),
            referee: None,
        }
    }

    /// After a poll.
    pub(crate) fn of<B: Bus + ?Sized>(
        watch: &Watch<'_, B>,
        link: LinkView,
        every: Duration,
        beside: &Beside<'_>,
    ) -> Self {
        let poll = watch.last();
        let line = match poll.diagnosis.reaches(0) {
            Some(true) => "good",
            Some(false) => "silent",
            None => "untold",
        };
        let seen = poll.sights.iter().zip(watch.subjects()).zip(beside.known);
        let devices = seen.map(|((sight, subject), known)| PolledDevice {
            misread: watch.misread(sight.position).map(turned),
            likely: beside.causes.of(sight.position).map(LikelyView::from),
            parameters: known.parameters(),
            data_check: known.data_check(),
            lamps: (beside.lamps)(sight.position),
            ..PolledDevice::of(sight, subject)
        });
        // Those that polls can judge.
        let findings = watch.referees().findings().filter(|(_, found)| TOLD_BY_POLLS.contains(&found.rule));
        let not_judged = RULES.into_iter().filter(|rule| !TOLD_BY_POLLS.contains(rule));
        let referee = RefereeView {
            services: watch.referees().services(),
            findings: findings.map(|(position, found)| finding(position, found)).collect(),
            not_judged: not_judged.map(HandshakeRule::name).collect(),
            seen_from: Vantage::Log.letter(),
        };
        Self {
            time_ns: poll.at.as_nanos(),
            poll_ns: every.as_nanos(),
            polls: poll.number + 1,
            line,
            segment: poll.diagnosis.segment(),
            link,
            diagnosis: says(poll.diagnosis),
            devices: devices.collect(),
            referee: Some(referee),
        }
    }
}

impl PolledDevice {
    fn unseen(position: usize, model: Model) -> Self {
        Self {
            position,
            device_number: format!("{}.0", position + 1),
            model,
            out: None,
            input: None,
            age_ns: None,
            value: None,
            verdict: "unseen",
            text: None,
            blind: Vec::new(),
            error: false,
            handshake: "unknown",
            why: None,
            misread: None,
            likely: None,
            status: None,
            measuring_length: None,
            parameters: Vec::new(),
            data_check: None,
            lamps: None,
        }
    }

    fn of(sight: &Sight, subject: &Subject) -> Self {
        let judge = &subject.judge;
        let (text, why, status) = match &sight.verdict {
            Judgement::NoAnswer(error) => (Some(error.to_string()), None, None),
            Judgement::Implausible(why) => (None, Some(WhyView::of(why)), None),
            Judgement::Faulty(status) => (None, None, *status),
            _ => (None, None, None),
        };
        Self {
            out: sight.out,
            input: sight.input,
            age_ns: sight.age.map(Duration::as_nanos),
            value: sight.verdict.value(),
            verdict: sight.verdict.word(),
            text,
            blind: judge.blind().iter().copied().map(Blind::name).collect(),
            error: sight.input.is_some_and(|input| !input.service_bit() && input.error_bit()),
            handshake: match sight.phase() {
                None => "unknown",
                Some(HandshakePhase::Normal) => "normal",
                Some(HandshakePhase::Requested) => "busy",
                Some(HandshakePhase::Acknowledged) => "acknowledged",
                Some(HandshakePhase::Ending) => "ending",
            },
            why,
            status,
            measuring_length: judge.measuring_length(),
            ..Self::unseen(sight.position, judge.model())
        }
    }
}
