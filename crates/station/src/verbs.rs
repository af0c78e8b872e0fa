//! What a ring can be told and asked, as an object of JSON: the verbs that every face of it shares.
//!
//! An object is judged as a whole before anything is done. Keys that are unknown or named twice are refused, so a
//! typing error never goes unnoticed.

use encoring_host::{Outcome, Reply, Request};
use encoring_sim::Fault;
use encoring_sim::scenario::Change;
use encoring_words::{Duration, OutWord};
use serde_json::value::RawValue;

use crate::controlled::Controlled;
use crate::polled_view::PolledView;
use crate::view::View;
use object::Envelope;

pub use encoders::Encoders;
pub use refused::Refused;
pub use said::refusals;

mod encoders;
mod object;
mod refused;
mod said;

/// The longest `id` that is echoed, in bytes as it was written.
pub const ID_BYTES_MAX: usize = 64;

/// A line, read.
#[derive(Debug)]
pub struct ReadLine<'a> {
    /// What the answer echoes, as it was written.
    pub id: Option<&'a RawValue>,
    /// What is asked.
    pub command: Result<Command, Refused>,
}

/// What whoever says a verb may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Permission {
    /// Only look.
    Look,
    /// Change something too.
    Change,
}

/// Something that can be done as it stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Changes what surrounds an encoder.
    Set {
        /// Its ring position.
        position: usize,
        /// What changes, in order.
        changes: Vec<Change>,
    },
    /// Writes the OUT word of an encoder, whole.
    Out {
        /// Its ring position.
        position: usize,
        /// The word.
        word: OutWord,
    },
    /// Carries a service out, from the data on OUT to the position again.
    Serve {
        /// The ring position of the encoder.
        position: usize,
        /// What is asked of it.
        request: Request,
    },
    /// Troubles a segment of the ring.
    Line {
        /// 0..=encoders.
        segment: usize,
        /// What it suffers.
        fault: Fault,
        /// For how long.
        lasting: Duration,
    },
    /// Ends every trouble of the line.
    EndLine,
    /// Makes the gateway misbehave.
    Misbehave {
        /// How, as the gateway reads it.
        fault: String,
    },
    /// Ends a fault of the gateway.
    EndGateway {
        /// Which; `None` for every one.
        fault: Option<String>,
    },
    /// Lists the faults of the gateway.
    GatewayFaults,
    /// Takes the next position as it comes: somebody knows why the one before has jumped.
    Acknowledge {
        /// The ring position of the encoder.
        position: usize,
    },
    /// Shows the whole ring.
    View,
    /// Lists the verbs.
    Help,
}

/// What a command gives back.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// It is done.
    Done,
    /// A service is done.
    Reply {
        /// What the encoder replied.
        reply: Reply,
        /// An error was pending before.
        error_before: bool,
    },
    /// The ring at this moment.
    View(Box<View>),
    /// A ring behind a bus, as the last poll saw it.
    PolledView(Box<PolledView>),
    /// What the gateway does wrong.
    GatewayFaults(Vec<String>),
    /// The verbs.
    Help,
}

/// Which rings a verb is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SaidTo {
    /// Every one.
    Any,
    /// One that is simulated in this process.
    Simulated,
    /// One behind a bus.
    Polled,
}

/// A verb as `help` tells it.
pub(crate) struct Verb {
    pub(crate) name: &'static str,
    /// Where there is something that it could change or show.
    pub(crate) said_to: SaidTo,
    read: fn(&str, Encoders<'_>) -> Result<Command, Refused>,
    pub(crate) does: fn() -> String,
    pub(crate) examples: &'static [&'static str],
}

pub(crate) const VERBS: [Verb; 8] = [
    Verb {
        name: "set",
        said_to: SaidTo::Simulated,
        read: object::set,
        does: || {
            "changes what surrounds the encoder at position: supply_v, eeprom, magnet, raw or motion, preset1_v, \
             preset2_v, chip_held, jumper, ident, ssi, ssi_fault"
                .to_owned()
        },
        examples: &[
            r#"{"verb":"set","position":0,"set":{"supply_v":24.0}}"#,
            r#"{"verb":"set","position":0,"set":{"motion":{"kind":"speed","per_s":1000}}}"#,
            r#"{"verb":"set","position":0,"set":{"eeprom":{"fault":"none"}}}"#,
            r#"{"verb":"set","position":2,"set":{"ssi":{"khz":500,"clocks":25,"every_ms":10}}}"#,
        ],
    },
    Verb {
        name: "out",
        said_to: SaidTo::Any,
        read: object::out,
        does: || "writes the whole OUT word of the encoder at position, in any spelling of a word".to_owned(),
        examples: &[r#"{"verb":"out","position":1,"word":"4200270F"}"#],
    },
    Verb {
        name: "service",
        said_to: SaidTo::Any,
        read: object::service,
        does: || {
            "carries a service out at position, from the data on OUT to the position again, and gives the reply; with \
             value it writes, without it reads"
                .to_owned()
        },
        examples: &[
            r#"{"verb":"service","position":1,"service":2,"value":9999}"#,
            r#"{"verb":"service","position":1,"service":2}"#,
            r#"{"verb":"service","position":1,"service":8}"#,
        ],
    },
    Verb {
        name: "line",
        said_to: SaidTo::Simulated,
        read: object::line,
        does: || {
            let kinds = Fault::forms(Fault::is_of_line);
            format!(
                "troubles a segment of the ring for for_s seconds, or until fault none; segment 0 leads into the first \
                 encoder; the faults are {kinds}, with N of a million bits"
            )
        },
        examples: &[
            r#"{"verb":"line","segment":1,"fault":"silent","for_s":0.1}"#,
            r#"{"verb":"line","segment":0,"fault":"flips=20"}"#,
            r#"{"verb":"line","fault":"none"}"#,
        ],
    },
    Verb {
        name: "gateway",
        said_to: SaidTo::Simulated,
        read: |text, _| object::gateway(text),
        does: || {
            "makes the Modbus server misbehave as gateways do: fault begins a fault, in the form that sim --gateway-fault \
             takes, whose times count from now; end ends one, or all; without either it lists them"
                .to_owned()
        },
        examples: &[
            r#"{"verb":"gateway","fault":"late=2500#17"}"#,
            r#"{"verb":"gateway","fault":"silent@5s+1s"}"#,
            r#"{"verb":"gateway"}"#,
            r#"{"verb":"gateway","end":"late=2500#17"}"#,
            r#"{"verb":"gateway","end":"all"}"#,
        ],
    },
    Verb {
        name: "acknowledge",
        said_to: SaidTo::Polled,
        read: object::acknowledge,
        does: || {
            "takes the next position at position as it comes, once it is known why the one before has jumped"
                .to_owned()
        },
        examples: &[r#"{"verb":"acknowledge","position":1}"#],
    },
    Verb {
        name: "view",
        said_to: SaidTo::Any,
        read: |text, _| object::bare(text, Command::View),
        does: || "shows the whole ring at one moment".to_owned(),
        examples: &[r#"{"verb":"view"}"#],
    },
    Verb {
        name: "help",
        said_to: SaidTo::Any,
        read: |text, _| object::bare(text, Command::Help),
        does: || "lists the verbs; every line may have an id, which its answer has too".to_owned(),
        examples: &[r#"{"verb":"help","id":1}"#],
    },
];

fn names() -> String {
    let everywhere = VERBS.iter().filter(|verb| verb.said_to != SaidTo::Polled);
    everywhere.map(|verb| verb.name).collect::<Vec<_>>().join(", ")
}

/// Reads one line that is said to these encoders. Nothing is done yet.
#[must_use]
pub fn parse<'a, 'e>(text: &'a str, encoders: impl Into<Encoders<'e>>) -> ReadLine<'a> {
    let encoders = encoders.into();
    let refused = |refused| ReadLine { id: None, command: Err(refused) };
    // An array would be read too, key by key; nobody means that.
    if !text.trim_start().starts_with('{') {
        return refused(Refused::NotAnObject);
    }
    let envelope: Envelope<'a> = match object::read(text) {
        Ok(envelope) => envelope,
        Err(malformed) => return refused(malformed),
    };
    if let Some(id) = envelope.id.map(RawValue::get)
        && (id.len() > ID_BYTES_MAX || id.starts_with(['{', '[']))
    {
        return refused(Refused::Id { bytes: id.len() });
    }
    let command = envelope.verb.ok_or(Refused::NoVerb).and_then(|written| {
        let name = serde_json::from_str::<String>(written.get()).ok();
        let verb = VERBS.iter().find(|verb| name.as_deref() == Some(verb.name));
        let verb = verb.ok_or_else(|| Refused::UnknownVerb { verb: shortened(written.get(), 64) })?;
        if !encoders.take(verb) {
            return Err(Refused::NotHere { verb: verb.name, others: encoders.verbs() });
        }
        (verb.read)(text, encoders)
    });
    ReadLine { id: envelope.id, command }
}

impl Command {
    /// `false` for what only looks.
    #[must_use]
    pub const fn changes(&self) -> bool {
        !matches!(self, Self::GatewayFaults | Self::Acknowledge { .. } | Self::View | Self::Help)
    }

    /// Does it. Waits for the ring for up to a cycle.
    ///
    /// # Errors
    /// [`Refused`] if the ring no longer runs, or the gateway does not take it.
    pub fn obey(self, controlled: &Controlled) -> Result<Given, Refused> {
        let Controlled { ring, gateway, .. } = controlled;
        let gateway = gateway.as_deref().ok_or(Refused::NoGateway);
        match self {
            Self::Set { position, changes } => ring.change(position, changes)?,
            Self::Out { position, word } => ring.write_out(position, word)?,
            Self::Serve { position, request } => return served(controlled, position, request),
            Self::Line { segment, fault, lasting } => ring.trouble(segment, Some((fault, lasting)))?,
            Self::EndLine => ring.trouble(0, None)?,
            Self::Misbehave { fault } => gateway?.begin(&fault).map_err(Refused::Gateway)?,
            Self::EndGateway { fault: Some(fault) } => gateway?.end(&fault).map_err(Refused::Gateway)?,
            Self::EndGateway { fault: None } => gateway?.end_all(),
            Self::Acknowledge { .. } => {
                return Err(Refused::NotHere { verb: "acknowledge", others: names() });
            }
            Self::GatewayFaults => return Ok(Given::GatewayFaults(gateway?.faults())),
            Self::View => return Ok(Given::View(Box::new(ring.view()?))),
            Self::Help => return Ok(Given::Help),
        }
        Ok(Given::Done)
    }
}

fn served(controlled: &Controlled, position: usize, request: Request) -> Result<Given, Refused> {
    let served = controlled.ring.serve(position, request)?;
    given(position, served.map_err(|problem| Refused::NotServed { position, problem })?)
}

/// What a service that came to an end gives back.
pub(crate) fn given(position: usize, outcome: Outcome) -> Result<Given, Refused> {
    match outcome {
        Outcome::Done { reply, error_before } => Ok(Given::Reply { reply, error_before }),
        Outcome::TimedOut(timed_out) => Err(Refused::TimedOut { position, timed_out }),
        Outcome::GivenUp(_) => Err(Refused::GivenUp { position }),
    }
}

pub(crate) fn shortened(text: &str, chars_max: usize) -> String {
    match text.char_indices().nth(chars_max) {
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or_default()),
        None => text.to_owned(),
    }
}
