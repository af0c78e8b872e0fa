//! What a ring can be told and asked, as an object of JSON: the verbs that every face of it shares.
//!
//! An object is judged as a whole before anything is done. Keys that are unknown or named twice are refused, so a
//! typing error never goes unnoticed.

use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

use encoring_encoder::Unit;
use encoring_sim::Fault;
use encoring_sim::scenario::{Change, MotionFiles, MotionTable, Occurrence, SECONDS_MAX, SetTable};
use encoring_words::{Duration, Model};
use serde::de::value::MapAccessDeserializer;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use crate::controlled::Controlled;
use crate::station::RingStopped;
use crate::view::View;

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
    /// The ring at this moment.
    View(Box<View>),
    /// What the gateway does wrong.
    GatewayFaults(Vec<String>),
    /// The verbs.
    Help,
}

/// Why a line was refused. Nothing was done then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// No JSON object.
    #[error("not a JSON object; a line looks like {{\"verb\":\"help\"}}")]
    NotAnObject,
    /// Malformed JSON, or a key or type that does not belong there.
    #[error("column {column}: {problem}")]
    Json {
        /// Where in the line it was noticed, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// Nothing is asked.
    #[error("verb is missing; the verbs are {}", names())]
    NoVerb,
    /// No such verb.
    #[error("verb {verb}; the verbs are {}", names())]
    UnknownVerb {
        /// As it was written.
        verb: String,
    },
    /// Too long to be echoed, or no scalar.
    #[error(
        "id of {bytes} bytes; an id is a string, a number, true, false or null of at most {ID_BYTES_MAX}"
    )]
    Id {
        /// Its length as it was written.
        bytes: usize,
    },
    /// No such encoder.
    #[error("position {position}; the encoders are at 0 to {last}")]
    Position {
        /// As asked.
        position: i64,
        /// The highest.
        last: usize,
    },
    /// A value that this encoder cannot be given.
    #[error("position {position}, a {model}: {problem}")]
    Set {
        /// Its position.
        position: usize,
        /// Its model.
        model: Model,
        /// Key, value and limit.
        problem: String,
    },
    /// A motion from a file.
    #[error("position {position}: motion kind \"csv\" opens a file, which a peer cannot ask for; use moves")]
    File {
        /// Of which encoder.
        position: usize,
    },
    /// A fault without its place.
    #[error("segment is missing; the segments are 0 to {last}")]
    NoSegment {
        /// The one that leads back to the master.
        last: usize,
    },
    /// No such segment.
    #[error("segment {segment}; the segments are 0 to {last}")]
    Segment {
        /// As asked.
        segment: i64,
        /// The one that leads back to the master.
        last: usize,
    },
    /// No span of time.
    #[error("for_s {for_s}; the limits are 0 and {SECONDS_MAX}")]
    ForS {
        /// As asked.
        for_s: f64,
    },
    /// A place or time with the end of all faults.
    #[error("{key} with fault \"none\", which ends every fault of the line and takes no other key")]
    NoneWith {
        /// Which.
        key: &'static str,
    },
    /// Two things of the gateway at once.
    #[error("fault and end in one line; fault begins one, end ends one")]
    FaultAndEnd,
    /// There is no gateway.
    #[error("there is no Modbus server whose answers could be spoilt")]
    NoGateway,
    /// The gateway does not take it.
    #[error("{0}")]
    Gateway(String),
    /// There is nothing left to change or look at.
    #[error(transparent)]
    Stopped(#[from] RingStopped),
}

/// A verb as `help` tells it.
pub(crate) struct Verb {
    pub(crate) name: &'static str,
    read: fn(&str, &[Unit]) -> Result<Command, Refused>,
    pub(crate) does: fn() -> String,
    pub(crate) examples: &'static [&'static str],
}

pub(crate) const VERBS: [Verb; 5] = [
    Verb {
        name: "set",
        read: set,
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
        name: "line",
        read: line,
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
        read: |text, _| gateway(text),
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
        name: "view",
        read: |text, _| bare(text, Command::View),
        does: || "shows the whole ring at one moment".to_owned(),
        examples: &[r#"{"verb":"view"}"#],
    },
    Verb {
        name: "help",
        read: |text, _| bare(text, Command::Help),
        does: || "lists the verbs; every line may have an id, which its answer has too".to_owned(),
        examples: &[r#"{"verb":"help","id":1}"#],
    },
];

fn names() -> String {
    VERBS.map(|verb| verb.name).join(", ")
}

/// Reads one line. Nothing is done yet.
#[must_use]
pub fn parse<'a>(text: &'a str, units: &[Unit]) -> ReadLine<'a> {
    let refused = |refused| ReadLine { id: None, command: Err(refused) };
    // An array would be read too, key by key; nobody means that.
    if !text.trim_start().starts_with('{') {
        return refused(Refused::NotAnObject);
    }
    let envelope: Envelope<'a> = match read(text) {
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
        (verb.read)(text, units)
    });
    ReadLine { id: envelope.id, command }
}

impl Command {
    /// Does it. Waits for the ring for up to a cycle.
    ///
    /// # Errors
    /// [`Refused`] if the ring no longer runs, or the gateway does not take it.
    pub fn obey(self, controlled: &Controlled) -> Result<Given, Refused> {
        let Controlled { ring, gateway, .. } = controlled;
        let gateway = gateway.as_deref().ok_or(Refused::NoGateway);
        match self {
            Self::Set { position, changes } => ring.change(position, changes)?,
            Self::Line { segment, fault, lasting } => ring.trouble(segment, Some((fault, lasting)))?,
            Self::EndLine => ring.trouble(0, None)?,
            Self::Misbehave { fault } => gateway?.begin(&fault).map_err(Refused::Gateway)?,
            Self::EndGateway { fault: Some(fault) } => gateway?.end(&fault).map_err(Refused::Gateway)?,
            Self::EndGateway { fault: None } => gateway?.end_all(),
            Self::GatewayFaults => return Ok(Given::GatewayFaults(gateway?.faults())),
            Self::View => return Ok(Given::View(Box::new(ring.view()?))),
            Self::Help => return Ok(Given::Help),
        }
        Ok(Given::Done)
    }
}

pub(crate) fn shortened(text: &str, chars_max: usize) -> String {
    match text.char_indices().nth(chars_max) {
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or_default()),
        None => text.to_owned(),
    }
}

/// What every line has. The rest is read once the verb is known.
#[derive(Deserialize)]
struct Envelope<'a> {
    #[serde(borrow, default, deserialize_with = "written")]
    id: Option<&'a RawValue>,
    #[serde(borrow, default, deserialize_with = "written")]
    verb: Option<&'a RawValue>,
}

/// A value as it was written, `null` too.
fn written<'de, D: Deserializer<'de>>(source: D) -> Result<Option<&'de RawValue>, D::Error> {
    <&RawValue>::deserialize(source).map(Some)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BareLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
    position: i64,
    set: Object<SetTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LineLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
    segment: Option<i64>,
    fault: Asked,
    for_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GatewayLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
    fault: Option<String>,
    end: Option<String>,
}

/// What the line is to suffer: a fault in its text form, or `none`.
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "String")]
enum Asked {
    Fault(Fault),
    None,
}

impl TryFrom<String> for Asked {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        if text == "none" {
            return Ok(Self::None);
        }
        text.parse::<Fault>().and_then(Fault::on_line).map(Self::Fault)
    }
}

/// A table that is written as an object and not as an array of its values.
struct Object<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct OfObject<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for OfObject<T> {
            type Value = Object<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Object<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Object)
            }
        }

        source.deserialize_map(OfObject(PhantomData))
    }
}

fn read<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T, Refused> {
    serde_json::from_str(text).map_err(|cause| {
        let (line, column) = (cause.line(), cause.column());
        let told = cause.to_string();
        let problem = told.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&told);
        Refused::Json { column, problem: problem.to_owned() }
    })
}

fn bare(text: &str, command: Command) -> Result<Command, Refused> {
    read::<BareLine>(text).map(|_| command)
}

fn set(text: &str, units: &[Unit]) -> Result<Command, Refused> {
    let SetLine { position: asked, set: Object(table), .. } = read(text)?;
    let unknown = || Refused::Position { position: asked, last: units.len().saturating_sub(1) };
    let position = usize::try_from(asked).map_err(|_| unknown())?;
    let unit = units.get(position).ok_or_else(unknown)?;
    if let Some(MotionTable::Csv { .. }) = table.motion {
        return Err(Refused::File { position });
    }
    let changes = table
        .read(unit, &mut MotionFiles::beside(Path::new("")))
        .map_err(|wrong| Refused::Set { position, model: unit.model(), problem: wrong.to_string() })?;
    Ok(Command::Set { position, changes })
}

fn line(text: &str, units: &[Unit]) -> Result<Command, Refused> {
    let LineLine { segment, fault, for_s, .. } = read(text)?;
    let fault = match (fault, segment, for_s) {
        (Asked::None, None, None) => return Ok(Command::EndLine),
        (Asked::None, Some(_), _) => return Err(Refused::NoneWith { key: "segment" }),
        (Asked::None, None, Some(_)) => return Err(Refused::NoneWith { key: "for_s" }),
        (Asked::Fault(fault), ..) => fault,
    };
    let last = units.len();
    let asked = segment.ok_or(Refused::NoSegment { last })?;
    let segment = usize::try_from(asked).ok().filter(|segment| *segment <= last);
    let segment = segment.ok_or(Refused::Segment { segment: asked, last })?;
    let lasting = match for_s {
        None => Occurrence::FOR_GOOD,
        Some(for_s) if (0.0..=SECONDS_MAX).contains(&for_s) => Duration((for_s * 1e9).round() as u64),
        Some(for_s) => return Err(Refused::ForS { for_s }),
    };
    Ok(Command::Line { segment, fault, lasting })
}

fn gateway(text: &str) -> Result<Command, Refused> {
    let GatewayLine { fault, end, .. } = read(text)?;
    match (fault, end) {
        (Some(_), Some(_)) => Err(Refused::FaultAndEnd),
        (Some(fault), None) => Ok(Command::Misbehave { fault }),
        (None, Some(end)) => Ok(Command::EndGateway { fault: Some(end).filter(|end| end != "all") }),
        (None, None) => Ok(Command::GatewayFaults),
    }
}
