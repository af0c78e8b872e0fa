//! The reader on an SSI and an identification word, as a scenario file and the control port write them.

use encoring_files::toml_text::Wrong;
use encoring_host::ssi_receiver::TakenAt;
use encoring_ring::Ident;
use encoring_words::parameter::Code;
use encoring_words::{Duration, Model};
use serde::{Deserialize, Deserializer};

use super::limits::within;
use super::{Change, SECONDS_MAX};
use crate::fault::{Fault, SsiTrouble, identification};
use crate::ssi::{SsiCard, SsiSettings};

/// A reader: `{ khz = 500, clocks = 25, every_ms = 10 }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SsiTable {
    khz: f64,
    clocks: u32,
    every_ms: f64,
    #[serde(default)]
    taken_at: TakenAtName,
    bits: Option<u8>,
    code: Option<CodeName>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum CodeName {
    Binary,
    Gray,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TakenAtName {
    Rising,
    #[default]
    Falling,
}

/// What an event does to the reader.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "ssi is \"off\", or a table of khz, clocks, every_ms, taken_at, bits and code")]
pub enum SsiChange {
    /// None hangs there any more.
    Off(Off),
    /// This one does.
    Reader(SsiTable),
}

/// The word `off`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Off {
    /// It.
    Off,
}

/// What an event does to the line of the SSI: a fault in its text form, or `none`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SsiFaultText(Option<SsiTrouble>);

impl<'de> Deserialize<'de> for SsiFaultText {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        let text = String::deserialize(source)?;
        if text == "none" {
            return Ok(Self(None));
        }
        let fault: Fault = text.parse().map_err(serde::de::Error::custom)?;
        let forms = || Fault::forms(|fault| fault.on_ssi().is_some());
        let wrong = || {
            serde::de::Error::custom(format_args!(
                "{fault} is no fault of an SSI; those are {}, none",
                forms()
            ))
        };
        fault.on_ssi().map(|trouble| Self(Some(trouble))).ok_or_else(wrong)
    }
}

/// An identification word, as a number or as text: `"0303"`, `"0x0303"`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "NumberOrText")]
pub struct IdentText(Ident);

#[derive(Deserialize)]
#[serde(untagged, expecting = "an identification word: a number from 0 to 65535, or text as \"0303\"")]
enum NumberOrText {
    Number(u16),
    Text(String),
}

impl TryFrom<NumberOrText> for IdentText {
    type Error = String;

    fn try_from(written: NumberOrText) -> Result<Self, String> {
        match written {
            NumberOrText::Number(number) => Ok(Self(Ident(number))),
            NumberOrText::Text(text) => identification(&text).map(Self),
        }
    }
}

impl From<IdentText> for Ident {
    fn from(IdentText(ident): IdentText) -> Self {
        ident
    }
}

impl SsiTable {
    /// The settings, for an encoder of this model.
    pub(super) fn read(&self, model: Model) -> Result<SsiSettings, Wrong> {
        has_ssi("ssi", model)?;
        let limits = |key, value, high| within(key, value, 0.0, high);
        let hz = (limits("khz", self.khz, 1e6)? * 1e3).round() as u32;
        let every = Duration((limits("every_ms", self.every_ms, SECONDS_MAX * 1e3)? * 1e6).round() as u64);
        let taken_at = match self.taken_at {
            TakenAtName::Rising => TakenAt::Rising,
            TakenAtName::Falling => TakenAt::Falling,
        };
        let code = self.code.map(|code| match code {
            CodeName::Binary => Code::Binary,
            CodeName::Gray => Code::Gray,
        });
        let settings = SsiSettings::new(hz, self.clocks, every, taken_at).map_err(Wrong::new)?;
        settings.reading_as(SsiCard { bits: self.bits, code }).map_err(|problem| Wrong::at("bits", problem))
    }
}

impl SsiChange {
    pub(super) fn read(&self, model: Model) -> Result<Change, Wrong> {
        match self {
            Self::Off(Off::Off) => has_ssi("ssi", model).map(|()| Change::Ssi(None)),
            Self::Reader(table) => Ok(Change::Ssi(Some(table.read(model)?))),
        }
    }
}

impl SsiFaultText {
    pub(super) fn read(self, model: Model) -> Result<Change, Wrong> {
        has_ssi("ssi_fault", model)?;
        Ok(Change::SsiTrouble(self.0))
    }
}

fn has_ssi(key: &str, model: Model) -> Result<(), Wrong> {
    if model.has_ssi_output() { Ok(()) } else { Err(Wrong::at(key, format!("{key}: a {model} has no SSI"))) }
}
