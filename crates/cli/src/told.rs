//! What the master's side found out, in words and as JSON: values, error status, failures.

use std::fmt;

use encoring_bus::master::MasterError;
use encoring_bus::watch::{Poll, Watch};
use encoring_bus::{Behind, Bus, RingNews};
use encoring_host::preset::position;
use encoring_host::request::Request;
use encoring_host::service::{Check, Failure as ServiceFailure, Refusal};
use encoring_host::session::{Fate, TimedOut, WaitedFor};
use encoring_words::explain::Meaning;
use encoring_words::model::MODELS;
use encoring_words::parameter::Code;
use encoring_words::status::StatusBit;
use encoring_words::word::In;
use encoring_words::{Access, ErrorStatus, InWord, Model, Parameter};
use encoring_workshop::MachineMark;
use serde::Serialize;

use crate::arguments::bus::{Source, Target};

use crate::output::time::seconds;
use crate::output::{Answer, Failure};

/// What a service of a bus can fail with.
pub(crate) type Failed = ServiceFailure<MasterError>;

/// Which encoder a report is about.
#[derive(Serialize)]
pub(crate) struct TargetView {
    pub(crate) position: usize,
    pub(crate) device_number: String,
    pub(crate) model: &'static str,
}

impl TargetView {
    pub(crate) fn new(target: Target) -> Self {
        Self { position: target.position, device_number: target.device(), model: target.model.name() }
    }
}

impl fmt::Display for TargetView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "position {} (device {}), {}", self.position, self.device_number, self.model)
    }
}

/// The first fault that was seen, for whoever ends with it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FaultSeen {
    time_ns: u64,
    position: usize,
    verdict: &'static str,
}

impl fmt::Display for FaultSeen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "position {} is {} at {} s", self.position, self.verdict, seconds(self.time_ns))
    }
}

/// What polls told of faults.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    first: Option<FaultSeen>,
    /// Of an encoder, or of whether its ring runs, nothing was known at some time.
    unknown: bool,
}

impl Faults {
    pub(crate) fn take(&mut self, poll: &Poll) {
        // Whether the ring runs was to be looked at.
        self.unknown |= matches!(poll.ring, Some(RingNews::Unread(_)));
        for sight in &poll.sights {
            match sight.verdict.is_fault() {
                Some(true) if self.first.is_none() => {
                    let (time_ns, verdict) = (sight.at.as_nanos(), sight.verdict.word());
                    self.first = Some(FaultSeen { time_ns, position: sight.position, verdict });
                }
                Some(_) => {}
                None => self.unknown = true,
            }
        }
    }

    pub(crate) const fn first(&self) -> Option<&FaultSeen> {
        self.first.as_ref()
    }
}

/// How a command ends that has only looked; `faults` are those that it was to look for.
pub(crate) fn looked<B: Bus + ?Sized>(watch: &Watch<'_, B>, faults: Option<&Faults>) -> Answer {
    match faults {
        Some(Faults { first: Some(_), .. }) => Answer::No,
        Some(Faults { unknown: true, .. }) => Answer::Unknown,
        _ if watch.is_unanswered() => Answer::Unknown,
        _ => Answer::Yes,
    }
}

/// What IN showed.
#[derive(Serialize)]
pub(crate) struct Shown {
    pub(crate) word: String,
    /// In steps; `None` for anything but a position.
    pub(crate) position: Option<u32>,
    pub(crate) error_bit: bool,
}

impl Shown {
    /// `code` is `None` if it is not known whether the encoder shows Gray code.
    pub(crate) fn new(word: InWord, code: Option<Code>) -> Self {
        let error_bit = matches!(word.decode(), In::Position { error: true, .. });
        Self { word: word.to_string(), position: code.and_then(|code| position(word, code)), error_bit }
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.position {
            Some(position) => write!(f, "{position}")?,
            None => f.write_str("not known")?,
        }
        write!(f, " ({})", self.word)?;
        if self.error_bit { f.write_str(", an error is pending") } else { Ok(()) }
    }
}

/// The value of a parameter.
#[derive(Serialize)]
pub(crate) struct ParameterView {
    pub(crate) service: String,
    pub(crate) name: &'static str,
    /// `None` if it could not be told from the 0 of a record that cannot be read.
    pub(crate) value: Option<u32>,
    pub(crate) value_hex: Option<String>,
    pub(crate) meaning: Option<String>,
}

impl ParameterView {
    pub(crate) fn new(parameter: Parameter, model: Model, value: Option<u32>) -> Self {
        Self {
            service: format!("{:02X}", parameter.service().number()),
            name: parameter.key(),
            value,
            value_hex: value.map(|value| format!("{value:06X}")),
            meaning: value
                .and_then(|value| Meaning::of(parameter, model, value))
                .map(|meaning| meaning.to_string()),
        }
    }
}

impl fmt::Display for ParameterView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.value.map_or_else(|| "?".to_owned(), |value| value.to_string());
        let hex = self.value_hex.as_ref().map(|hex| format!("{hex}h")).unwrap_or_default();
        let meaning = self.meaning.as_deref().unwrap_or("");
        let line = format!("{:<7}  {:<18}  {value:>8}  {hex:>7}  {meaning}", self.service, self.name);
        f.write_str(line.trim_end())
    }
}

/// A mark on the machine.
#[derive(Serialize)]
pub(crate) struct MarkView {
    name: String,
    shown: u32,
    reference: Option<String>,
}

impl MarkView {
    pub(crate) fn new(mark: &MachineMark) -> Self {
        let reference = mark.reference.map(|reference| reference.to_string());
        Self { name: mark.name.clone(), shown: mark.shown, reference }
    }
}

impl fmt::Display for MarkView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, shown, reference } = self;
        let reference = reference.as_ref().map(|reference| format!(" ({reference})"));
        write!(f, "mark {name:?}{}: {shown}", reference.unwrap_or_default())
    }
}

/// An error status with everything that the manuals say of it.
#[derive(Serialize)]
pub(crate) struct StatusView {
    pub(crate) status_hex: String,
    /// The error bit of the data check's reply.
    pub(crate) remains: bool,
    pub(crate) bits: Vec<BitView>,
    /// Why it may be the status of another model.
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<String>,
    #[serde(skip)]
    model: Model,
}

#[derive(Serialize)]
pub(crate) struct BitView {
    pub(crate) bit: u8,
    pub(crate) meaning: &'static str,
    pub(crate) remedy: &'static str,
}

impl BitView {
    /// The bits that are set.
    pub(crate) fn of(status: ErrorStatus) -> Vec<Self> {
        let row = |row: &StatusBit| Self { bit: row.bit, meaning: row.meaning, remedy: row.remedy };
        status.explain().map(row).collect()
    }
}

impl StatusView {
    pub(crate) fn of(check: Check, model: Model) -> Self {
        let Check { status, remains } = check;
        let foreign = status.difference(model.status_mask());
        let doubt = (!foreign.is_empty())
            .then(|| format!("a {model} never shows the bits {:04X}: is --model right?", foreign.bits()));
        Self {
            status_hex: format!("{:04X}", status.bits()),
            remains,
            bits: BitView::of(status),
            doubt,
            model,
        }
    }

    /// The status of a data check before which IN showed this.
    pub(crate) fn after(before: InWord, check: Check, model: Model) -> Self {
        let mut view = Self::of(check, model);
        if before.error_bit() && check.is_good() && model.tells_refusals() {
            let doubt = format!("a {model} tells which error was pending: is --model right?");
            view.doubt.get_or_insert(doubt);
        }
        view
    }
}

impl fmt::Display for StatusView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error status {}", self.status_hex)?;
        for BitView { bit, meaning, remedy } in &self.bits {
            write!(f, "\n  2^{bit:<2}  {meaning}\n        remedy: {remedy}")?;
        }
        if self.bits.is_empty() && self.remains && !self.model.tells_refusals() {
            write!(f, "\n  a {} does not tell which error it was: a refusal has no status bit", self.model)?;
        }
        self.doubt.as_ref().map_or(Ok(()), |doubt| write!(f, "\n  {doubt}"))
    }
}

/// A service that failed.
#[derive(Serialize)]
pub(crate) struct FailureView {
    /// `not_sent`, `refused`, `timed_out`, `given_up`, `another_master`, `no_bus`, `misread`, `not_prepared`, `error_pending` or `unreadable`.
    pub(crate) kind: &'static str,
    /// The request's OUT word.
    pub(crate) out: Option<String>,
    /// What was waited for in vain: `normal`, `acknowledgement` or `end`.
    pub(crate) waited_for: Option<&'static str>,
    /// Whether the encoder has carried the request out: `yes`, `no` or `unknown`.
    pub(crate) carried_out: Option<&'static str>,
    pub(crate) status: Option<StatusView>,
    /// The same in sentences.
    pub(crate) text: Vec<String>,
    /// Which of them tells of the bus.
    #[serde(skip)]
    of_bus: Option<usize>,
    #[serde(skip)]
    ends: Ends,
}

#[derive(Clone, Copy)]
enum Ends {
    BadInput,
    Refused,
    NoAnswer,
}

/// `service 02 (write measuring length in steps = 9999)`
fn named(request: Request) -> String {
    format!("service {:02X} ({})", request.service().number(), request.deed())
}

/// Whether a refused service tells that `--model` is wrong: only services that the model has are sent.
fn other_model(request: Request, check: Option<Check>, target: Target) -> Option<String> {
    let unknown = check.map_or(request.access() == Access::Read, |check| {
        check.status.contains(ErrorStatus::UNKNOWN_COMMAND)
    });
    let service = request.service();
    let without: Vec<_> = MODELS.into_iter().filter(|model| !service.known_to(*model)).collect();
    let lack = match without.as_slice() {
        _ if !unknown || target.source == Source::Ring => return None,
        [] => return None,
        [only] => format!("only a {only} has no service {:02X}", service.number()),
        several => {
            let names: Vec<_> = several.iter().map(|model| format!("a {model}")).collect();
            format!("{} have no service {:02X}", names.join(" and "), service.number())
        }
    };
    Some(format!("{lack}: is --model {} right? look at the type label", target.model))
}

const fn fate(fate: Fate) -> (&'static str, &'static str) {
    match fate {
        Fate::NotSent => ("no", "this request was not sent"),
        Fate::Unknown => ("unknown", "whether the encoder has carried it out is not known"),
        Fate::CarriedOut(_) => ("yes", "the encoder has carried it out: its reply was seen"),
    }
}

impl FailureView {
    pub(crate) fn new(failed: &Failed, target: Target, behind: Option<&Behind>) -> Self {
        match *failed {
            ServiceFailure::Request(error) => Self::told("not_sent", Ends::BadInput, vec![error.to_string()]),
            ServiceFailure::Refused(refusal) => Self::refused(refusal, target),
            ServiceFailure::TimedOut { request, timed_out } => Self::timed_out(request, timed_out, behind),
            ServiceFailure::GivenUp { request, given_up } => {
                let (carried_out, known) = fate(given_up.fate);
                let text = vec![format!("interrupted in {}", named(request)), known.to_owned()];
                Self {
                    out: Some(request.word().to_string()),
                    carried_out: Some(carried_out),
                    ..Self::told("given_up", Ends::NoAnswer, text)
                }
            }
            ServiceFailure::ErrorPending { shown } => {
                let text = vec![
                    format!("IN shows {shown}: an error is pending, so no preset adjustment was sent"),
                    "`encoring check` comes first: it tells which error it is, and ends it if it is over; the position \
                     may jump"
                        .to_owned(),
                ];
                Self::told("error_pending", Ends::Refused, text)
            }
            ServiceFailure::NotActive { position, largest } => {
                let text = vec![
                    format!(
                        "the position is {position}, above the measuring length {largest}: it is not computed with the \
                         programmed values yet, so no preset adjustment was sent: its zero would be lost"
                    ),
                    "`encoring check` comes first: it makes the values count; the position jumps".to_owned(),
                ];
                Self::told("not_active", Ends::Refused, text)
            }
            ServiceFailure::Unreadable { parameter } => {
                let text = format!(
                    "{} reads as 0 while an error is pending, and so does a record that cannot be read; run \
                     `encoring check`",
                    parameter.key()
                );
                Self::told("unreadable", Ends::NoAnswer, vec![text])
            }
            ServiceFailure::Bus(ref error) => Self::of_bus(error, target),
        }
    }

    /// Only words.
    const fn told(kind: &'static str, ends: Ends, text: Vec<String>) -> Self {
        Self { kind, out: None, waited_for: None, carried_out: None, status: None, text, of_bus: None, ends }
    }

    fn refused(refusal: Refusal, target: Target) -> Self {
        let Refusal { request, check, repeated } = refusal;
        let mut text = vec![format!("the encoder refused {}", named(request))];
        if repeated {
            text.push("it was repeated and refused again".to_owned());
        }
        text.extend(other_model(request, check, target));
        if check.is_none() {
            text.push("an error is pending now: `encoring check` tells which".to_owned());
        }
        Self {
            out: Some(request.word().to_string()),
            status: check.map(|check| StatusView::of(check, target.model)),
            ..Self::told("refused", Ends::Refused, text)
        }
    }

    fn timed_out(request: Request, timed_out: TimedOut, behind: Option<&Behind>) -> Self {
        let TimedOut { waited_for, fate: known, .. } = timed_out;
        let (carried_out, known) = fate(known);
        let mut text = vec![format!("no answer to {}: {timed_out}", named(request)), known.to_owned()];
        if waited_for == WaitedFor::Normal && timed_out.last.is_some_and(InWord::service_bit) {
            text.push(
                "IN shows what could be a reply, and was not asked for here: another master is at work, or the halves \
                 of the words are exchanged; `encoring probe` tells, while the shaft turns"
                    .to_owned(),
            );
        }
        let of_bus = behind.map(|_| text.len());
        text.extend(behind.map(Behind::to_string));
        let ends = match behind {
            Some(Behind::OtherMaster { .. }) => Ends::Refused,
            _ => Ends::NoAnswer,
        };
        Self {
            of_bus,
            out: Some(request.word().to_string()),
            waited_for: Some(match waited_for {
                WaitedFor::Normal => "normal",
                WaitedFor::Acknowledgement => "acknowledgement",
                WaitedFor::End => "end",
            }),
            carried_out: Some(carried_out),
            ..Self::told("timed_out", ends, text)
        }
    }

    fn of_bus(error: &MasterError, target: Target) -> Self {
        let (kind, ends) = match error {
            MasterError::OtherMaster { .. } | MasterError::Overwritten { .. } => {
                ("another_master", Ends::Refused)
            }
            MasterError::Bus(error) if error.is_no_encoder() => ("no_bus", Ends::BadInput),
            MasterError::Misread { .. } => ("misread", Ends::NoAnswer),
            MasterError::NotPrepared { .. } => ("not_prepared", Ends::NoAnswer),
            MasterError::Interrupted => ("given_up", Ends::NoAnswer),
            _ => ("no_bus", Ends::NoAnswer),
        };
        let mut text = vec![error.to_string()];
        if let MasterError::OtherMaster { .. } = error {
            text.push(format!(
                "if no PLC works with this encoder, a command was ended before it could take the bit back: \
                 `encoring release --at {}` shows it and clears it",
                target.position
            ));
        }
        let of_bus = (!matches!(error, MasterError::Interrupted)).then_some(0);
        let carried_out = matches!(error, MasterError::NotPrepared { .. }).then_some(fate(Fate::NotSent).0);
        Self { of_bus, carried_out, ..Self::told(kind, ends, text) }
    }

    /// The same with where the bus is, where it is about the bus.
    pub(crate) fn at(mut self, place: &str) -> Self {
        if let Some(line) = self.of_bus.take().and_then(|line| self.text.get_mut(line)) {
            *line = format!("{place}: {line}");
        }
        self
    }

    /// How the command ends that met it and has not printed it.
    pub(crate) fn into_failure(self) -> Failure {
        let message = self.to_string();
        match self.ends {
            Ends::BadInput => Failure::BadInput(message),
            Ends::NoAnswer => Failure::NoAnswer(message),
            Ends::Refused => Failure::Refused(message),
        }
    }

    /// The same for a command that has printed it.
    pub(crate) fn answer(&self) -> Answer {
        match self.ends {
            Ends::BadInput | Ends::Refused => Answer::No,
            Ends::NoAnswer => Answer::Unknown,
        }
    }
}

impl fmt::Display for FailureView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text.join("\n"))?;
        match &self.status {
            Some(status) => write!(f, "\n{status}"),
            None => Ok(()),
        }
    }
}
