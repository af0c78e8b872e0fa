//! What the verbs take, as it is written.

use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

use encoring_host::Request;
use encoring_sim::Fault;
use encoring_sim::scenario::{MotionFiles, MotionTable, Occurrence, SECONDS_MAX, SetTable};
use encoring_words::number::{Bare, word};
use encoring_words::parameter::Parameter;
use encoring_words::word::DATA_MAX;
use encoring_words::{Duration, OutWord, Service};
use serde::de::value::MapAccessDeserializer;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use super::{Command, Encoders, Refused, shortened};

/// What is quoted of a text that somebody wrote.
const WRITTEN_CHARS_MAX: usize = 40;

/// What every line has. The rest is read once the verb is known.
#[derive(Deserialize)]
pub(super) struct Envelope<'a> {
    #[serde(borrow, default, deserialize_with = "written")]
    pub(super) id: Option<&'a RawValue>,
    #[serde(borrow, default, deserialize_with = "written")]
    pub(super) verb: Option<&'a RawValue>,
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
struct PositionLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
    position: i64,
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
struct OutLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
    position: i64,
    word: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ServiceLine {
    #[serde(rename = "verb")]
    _verb: IgnoredAny,
    #[serde(rename = "id", default)]
    _id: IgnoredAny,
    position: i64,
    service: i64,
    value: Option<i64>,
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

pub(super) fn read<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T, Refused> {
    serde_json::from_str(text).map_err(|cause| {
        let (line, column) = (cause.line(), cause.column());
        let told = cause.to_string();
        let problem = told.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&told);
        Refused::Json { column, problem: problem.to_owned() }
    })
}

pub(super) fn bare(text: &str, command: Command) -> Result<Command, Refused> {
    read::<BareLine>(text).map(|_| command)
}

pub(super) fn acknowledge(text: &str, encoders: Encoders<'_>) -> Result<Command, Refused> {
    let PositionLine { position, .. } = read(text)?;
    encoders.placed(position).map(|(position, _)| Command::Acknowledge { position })
}

pub(super) fn out(text: &str, encoders: Encoders<'_>) -> Result<Command, Refused> {
    let OutLine { position, word: written, .. } = read(text)?;
    let (position, _) = encoders.placed(position)?;
    let reading = word([written.as_str()], Bare::Hexadecimal).map_err(|problem| Refused::Word {
        written: shortened(&written, WRITTEN_CHARS_MAX),
        problem: problem.to_string(),
    })?;
    Ok(Command::Out { position, word: OutWord(reading.bits) })
}

pub(super) fn service(text: &str, encoders: Encoders<'_>) -> Result<Command, Refused> {
    let ServiceLine { position, service: number, value, .. } = read(text)?;
    let (position, model) = encoders.placed(position)?;
    let service = u8::try_from(number).ok().and_then(Service::from_number);
    let service = service.ok_or(Refused::Service { service: number })?;
    let value = value.map(|value| {
        let written = u32::try_from(value).ok().filter(|value| *value <= DATA_MAX);
        written.ok_or(Refused::Value { value })
    });
    let request = match (Parameter::from_service(service), value.transpose()?) {
        (Some(parameter), Some(value)) => Request::write(model, parameter, value),
        (Some(parameter), None) => Request::read(model, parameter),
        (None, None) if service == Service::DataCheck => Ok(Request::data_check()),
        (None, Some(_)) if service == Service::DataCheck => return Err(Refused::ValueOfCheck),
        // Whether the measuring length allows the value the encoder says.
        (None, Some(value)) => Request::preset(model, value, DATA_MAX),
        (None, None) => return Err(Refused::ReadOfPreset),
    };
    let request = request.map_err(|problem| Refused::Request { position, problem })?;
    Ok(Command::Serve { position, request })
}

pub(super) fn set(text: &str, encoders: Encoders<'_>) -> Result<Command, Refused> {
    let SetLine { position: asked, set: Object(table), .. } = read(text)?;
    let (position, unit) = encoders.simulated(asked)?;
    if let Some(MotionTable::Csv { .. }) = table.motion {
        return Err(Refused::File { position });
    }
    let changes = table
        .read(unit, &mut MotionFiles::beside(Path::new("")))
        .map_err(|problem| Refused::Set { position, model: unit.model(), problem })?;
    Ok(Command::Set { position, changes })
}

pub(super) fn line(text: &str, encoders: Encoders<'_>) -> Result<Command, Refused> {
    let LineLine { segment, fault, for_s, .. } = read(text)?;
    let fault = match (fault, segment, for_s) {
        (Asked::None, None, None) => return Ok(Command::EndLine),
        (Asked::None, Some(_), _) => return Err(Refused::NoneWith { key: "segment" }),
        (Asked::None, None, Some(_)) => return Err(Refused::NoneWith { key: "for_s" }),
        (Asked::Fault(fault), ..) => fault,
    };
    let last = encoders.count();
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

pub(super) fn gateway(text: &str) -> Result<Command, Refused> {
    let GatewayLine { fault, end, .. } = read(text)?;
    match (fault, end) {
        (Some(_), Some(_)) => Err(Refused::FaultAndEnd),
        (Some(fault), None) => Ok(Command::Misbehave { fault }),
        (None, Some(end)) => Ok(Command::EndGateway { fault: Some(end).filter(|end| end != "all") }),
        (None, None) => Ok(Command::GatewayFaults),
    }
}
