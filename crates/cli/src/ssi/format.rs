//! The options that say how an encoder sends its position.

use std::fmt;

use clap::{Args, ValueEnum};
use encoring_words::Week;
use encoring_words::parameter::{Code, SsiValues};
use encoring_words::ssi_frame::{SsiCheck, SsiFormat};

use crate::arguments::whole;

/// Data bits of a new encoder.
const BITS_DEFAULT: u8 = 24;

/// How the position is sent: what service 0D programs, and the firmware.
#[derive(Args, Debug, Clone, Copy)]
pub(crate) struct FormatArguments {
    /// Number of data bits, 8 to 32; 31 is AK-40 from firmware 41/1997 on [default: 24]
    #[arg(long, value_name = "N", value_parser = whole::<u8>(8..=32))]
    bits: Option<u8>,
    /// Code of the position on the SSI
    #[arg(long, default_value = "binary")]
    code: CodeName,
    /// Repeat the 24 data bits every 26 clocks
    #[arg(long)]
    repetition: bool,
    /// Week and year of the firmware on the type label; before 41/1997 there is no AK-40 [default: 41/1997]
    #[arg(long, value_name = "WW/YYYY")]
    firmware: Option<Week>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CodeName {
    Binary,
    Gray,
}

impl FormatArguments {
    /// What service 0D programs.
    pub(crate) fn values(&self) -> SsiValues {
        let code = match self.code {
            CodeName::Binary => Code::Binary,
            CodeName::Gray => Code::Gray,
        };
        SsiValues { repetition: self.repetition, code, bits: self.bits.unwrap_or(BITS_DEFAULT) }
    }

    /// What the encoder sends.
    pub(crate) fn format(&self) -> SsiFormat {
        SsiFormat::new(self.values(), self.firmware.unwrap_or(Week::AK40))
    }

    /// The firmware, if it was told.
    pub(crate) const fn firmware(&self) -> Option<Week> {
        self.firmware
    }

    /// Bits, code or repetition were told.
    pub(crate) fn is_given(&self) -> bool {
        self.bits.is_some() || self.repetition || self.code != CodeName::Binary
    }

    /// What was asked for and has no effect [R117, R119].
    pub(crate) fn without_effect(&self) -> Option<String> {
        let format = self.format();
        match (format.check(), self.bits) {
            (SsiCheck::Repetition, Some(bits)) if bits != format.bits() => {
                Some(format!("--bits {bits}: with repetition the encoder makes it {}", format.bits()))
            }
            (SsiCheck::OddParity, _) if self.code == CodeName::Gray => {
                Some("--code gray: AK-40 is always binary".to_owned())
            }
            _ => None,
        }
    }
}

/// Hertz, as `1MHz`, `500 kHz` or `24000000`.
pub(crate) fn rate(text: &str) -> Result<u64, String> {
    encoring_trace::capture::hertz(text)
        .ok_or_else(|| format!("{text:?} is no rate; it is like 1MHz, 500kHz or 24000000"))
}

/// A format as people call it.
pub(crate) struct FormatText(pub(crate) SsiFormat);

impl fmt::Display for FormatText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(format) = self;
        let code = match format.code() {
            Code::Binary => "binary",
            Code::Gray => "Gray",
        };
        match format.check() {
            SsiCheck::OddParity => f.write_str("AK-40: 31 bits binary and odd parity"),
            SsiCheck::Repetition => write!(f, "{} bits {code}, repeated every 26 clocks", format.bits()),
            SsiCheck::None => write!(f, "{} bits {code}", format.bits()),
        }
    }
}
