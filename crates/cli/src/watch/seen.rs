//! What is shown of an encoder: the same for the screen, for lines and for programs.

use std::fmt;

use encoring_bus::watch::{HandshakePhase, Sight};
use encoring_bus::{Blind, Judge, Judgement};
use encoring_host::service::Check;
use encoring_station::view::LampsView;
use encoring_words::word::{In, ServiceNumber};
use encoring_words::{Access, Duration, InWord, Model};
use serde::Serialize;

use crate::output::time::span;
use crate::told::StatusView;

/// An encoder at one poll.
#[derive(Serialize)]
pub(crate) struct Seen {
    pub(crate) event: &'static str,
    pub(crate) time_ns: u64,
    pub(crate) position: usize,
    pub(crate) device_number: String,
    pub(crate) model: &'static str,
    pub(crate) verdict: &'static str,
    pub(crate) value: Option<u32>,
    pub(crate) measuring_length: Option<u32>,
    pub(crate) out: Option<String>,
    #[serde(rename = "in")]
    pub(crate) input: Option<String>,
    pub(crate) phase: Option<&'static str>,
    pub(crate) age_ns: Option<u64>,
    pub(crate) lamps: Option<LampsView>,
    pub(crate) cannot_judge: Vec<&'static str>,
    pub(crate) status: Option<StatusView>,
    /// The verdict in sentences; empty if all is well.
    pub(crate) text: Vec<String>,
    /// Of a step of the position that is none of the shaft.
    pub(crate) causes: Vec<CauseView>,
    #[serde(skip)]
    pub(crate) sight: Sight,
    #[serde(skip)]
    pub(crate) blind: Vec<Blind>,
}

impl Seen {
    /// `lamps` are those of a simulated encoder.
    pub(crate) fn new(sight: &Sight, judge: &Judge, lamps: Option<LampsView>) -> Self {
        let status = match sight.verdict {
            Judgement::Faulty(Some(status)) => {
                Some(StatusView::of(Check { status, remains: true }, judge.model()))
            }
            _ => None,
        };
        Self {
            event: "seen",
            time_ns: sight.at.as_nanos(),
            position: sight.position,
            device_number: format!("{}.0", sight.position + 1),
            model: judge.model().name(),
            verdict: sight.verdict.word(),
            value: sight.verdict.value(),
            measuring_length: judge.measuring_length(),
            out: sight.out.map(|word| word.to_string()),
            input: sight.input.map(|word| word.to_string()),
            phase: sight.phase().map(HandshakePhase::name),
            age_ns: sight.age.map(Duration::as_nanos),
            lamps,
            cannot_judge: judge.blind().iter().map(|blind| blind.name()).collect(),
            text: text(sight, status.as_ref()),
            status,
            causes: CauseView::of(&sight.verdict, judge.model()),
            sight: sight.clone(),
            blind: judge.blind().to_vec(),
        }
    }

    /// What has to be told again when it changes.
    pub(crate) fn key(&self) -> (&'static str, Option<u32>, &Option<String>, &Option<String>) {
        (self.verdict, self.value, &self.out, &self.input)
    }
}

/// A cause of step changes, with what helps.
#[derive(Serialize)]
pub(crate) struct CauseView {
    cause: &'static str,
    remedy: &'static str,
}

impl CauseView {
    /// Those of the manual, if the verdict is a step.
    fn of(verdict: &Judgement, model: Model) -> Vec<Self> {
        let steps = match verdict {
            Judgement::Implausible(why) if why.is_step() => model.step_changes(),
            _ => &[],
        };
        steps.iter().map(|step| Self { cause: step.cause, remedy: step.remedy }).collect()
    }
}

impl fmt::Display for CauseView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cause: {}; remedy: {}", self.cause, self.remedy)
    }
}

fn text(sight: &Sight, status: Option<&StatusView>) -> Vec<String> {
    match &sight.verdict {
        Judgement::Valid(_) | Judgement::Unchecked(_) => Vec::new(),
        Judgement::Stale { age } => {
            vec![format!(
                "the word may be {} old: the ring stands still, or the gateway answers late",
                span(*age)
            )]
        }
        Judgement::RingStopped(diagnosis) => vec![diagnosis.to_string()],
        Judgement::Faulty(_) => {
            let mut text = vec!["an error is pending: make the machine safe first".to_owned()];
            match status {
                Some(status) => text.extend(status.to_string().lines().map(|line| line.trim().to_owned())),
                None => text
                    .push("its status is not known until a data check tells it: `encoring check`".to_owned()),
            }
            text
        }
        Judgement::InService => vec![reply(sight.input.unwrap_or_default())],
        Judgement::Implausible(why) => vec![why.to_string()],
        Judgement::NoAnswer(error) => vec![error.to_string()],
    }
}

fn reply(input: InWord) -> String {
    let In::Reply(reply) = input.decode() else { return String::new() };
    let deed = match reply.access {
        Access::Read => "read",
        Access::Write => "write",
    };
    let service = match reply.service {
        ServiceNumber::Known(service) => format!("service {:02X} ({})", service.number(), service.name()),
        other => format!("service {:02X}, which no encoder has", other.number()),
    };
    format!("a reply and no position: {deed} {service}, data {}", reply.data)
}
