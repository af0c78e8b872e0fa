//! How a reader on an SSI reads, and how that is written.

use std::fmt;
use std::str::FromStr;

use encoring_host::ssi_receiver::TakenAt;
use encoring_words::Duration;
use encoring_words::parameter::Code;
use encoring_words::ssi_frame::{DATA_BITS, MONO_PERIOD, SsiFormat};

use crate::span;

/// The clock rate of a reader in hertz, from and to. The encoder guarantees less of it.
pub const READER_HZ: (u32, u32) = (1_000, 10_000_000);

/// The most clocks of a transfer.
pub const READER_CLOCKS_MAX: u32 = 1_000;

/// How a reader reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiSettings {
    hz: u32,
    clocks: u32,
    every: Duration,
    taken_at: TakenAt,
    card: SsiCard,
}

impl SsiSettings {
    /// A reader with this clock rate, so many clocks a transfer, and a transfer every so often.
    ///
    /// # Errors
    /// What is out of its limits, and these.
    pub fn new(hz: u32, clocks: u32, every: Duration, taken_at: TakenAt) -> Result<Self, String> {
        let (low, high) = READER_HZ;
        if !(low..=high).contains(&hz) {
            let limits = format!("{} to {}", Khz(low), Khz(high));
            return Err(format!("a clock of {} kHz; a reader has {limits} kHz", Khz(hz)));
        }
        if !(1..=READER_CLOCKS_MAX).contains(&clocks) {
            return Err(format!("{clocks} clocks; a transfer has 1 to {READER_CLOCKS_MAX}"));
        }
        let settings = Self { hz, clocks, every, taken_at, card: SsiCard::default() };
        let least = Duration(settings.period() * u64::from(clocks)) + MONO_PERIOD;
        if every < least {
            let told = format!("{clocks} clocks at {} kHz and the pause of 20 us take {least}", Khz(hz));
            return Err(format!("a transfer every {every}; {told}"));
        }
        Ok(settings)
    }

    /// Nanoseconds of a clock period, so that the clock is never faster than told.
    pub(super) fn period(self) -> u64 {
        1_000_000_000_u64.div_ceil(u64::from(self.hz.max(1)))
    }

    /// Clock rate in hertz.
    #[must_use]
    pub const fn hz(self) -> u32 {
        self.hz
    }

    /// Clocks of a transfer.
    #[must_use]
    pub const fn clocks(self) -> u32 {
        self.clocks
    }

    /// From the beginning of a transfer to that of the next.
    #[must_use]
    pub const fn every(self) -> Duration {
        self.every
    }

    /// At which edge it takes the data.
    #[must_use]
    pub const fn taken_at(self) -> TakenAt {
        self.taken_at
    }

    /// What it takes for the encoder's format.
    #[must_use]
    pub const fn card(self) -> SsiCard {
        self.card
    }

    /// The same reader that takes this for the encoder's format.
    ///
    /// # Errors
    /// A number of bits that no encoder sends, and its limits.
    pub fn reading_as(self, card: SsiCard) -> Result<Self, String> {
        let (fewest, most) = DATA_BITS;
        match card.bits {
            Some(bits) if !(fewest..=most).contains(&bits) => {
                Err(format!("{bits} bits; a reader takes {fewest} to {most}"))
            }
            _ => Ok(Self { card, ..self }),
        }
    }
}

/// What a reader is set to, where that is not what the encoder sends: it then takes plain words, without parity and
/// repetition. What is not set is as the encoder has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SsiCard {
    /// Bits of the field.
    pub bits: Option<u8>,
    /// Code of the position.
    pub code: Option<Code>,
}

impl SsiCard {
    /// What it takes for the format of an encoder that sends `sent`.
    #[must_use]
    pub fn reads(self, sent: SsiFormat) -> SsiFormat {
        match self {
            Self { bits: None, code: None } => sent,
            Self { bits, code } => SsiFormat::plain(bits.unwrap_or(sent.bits()), code.unwrap_or(sent.code())),
        }
    }
}

/// Hertz as kilohertz, without trailing zeros.
struct Khz(u32);

impl fmt::Display for Khz {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, rest) = (self.0 / 1_000, self.0 % 1_000);
        let decimals = format!("{rest:03}");
        match decimals.trim_end_matches('0') {
            "" => write!(f, "{whole}"),
            decimals => write!(f, "{whole}.{decimals}"),
        }
    }
}

/// A reader with its place, `POSITION=KHZ,CLOCKS,EVERY` as `2=500,25,10ms`; what it takes for the encoder's format may
/// follow, as `,bits=24,code=gray`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlacedReader {
    /// The ring position of its encoder.
    pub position: usize,
    /// How it reads.
    pub settings: SsiSettings,
}

impl fmt::Display for PlacedReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { position, settings: SsiSettings { hz, clocks, every, card, .. } } = self;
        write!(f, "{position}={},{clocks},{}", Khz(*hz), span::written(*every))?;
        if let Some(bits) = card.bits {
            write!(f, ",bits={bits}")?;
        }
        card.code.map_or(Ok(()), |code| write!(f, ",code={}", code.name()))
    }
}

impl FromStr for PlacedReader {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || "write POSITION=KHZ,CLOCKS,EVERY, as 2=500,25,10ms".to_owned();
        let (position, rest) = text.split_once('=').ok_or_else(form)?;
        let mut parts = rest.split(',').map(str::trim);
        let (Some(khz), Some(clocks), Some(every)) = (parts.next(), parts.next(), parts.next()) else {
            return Err(form());
        };
        let whole = |what: &str, text: &str| format!("{what} \"{text}\"; a whole number; {}", form());
        let position = position.trim();
        let position = crate::fault::digits(position).ok_or_else(|| whole("position", position))?;
        let clocks = crate::fault::digits(clocks).ok_or_else(|| whole("clocks", clocks))?;
        let hz = hertz(khz).ok_or_else(|| format!("clock \"{khz}\"; kHz as 500 or 62.5; {}", form()))?;
        let every = span::read(every).map_err(|problem| format!("every \"{every}\": {problem}"))?;
        let settings = SsiSettings::new(hz, clocks, every, TakenAt::default())?.reading_as(card(parts)?)?;
        Ok(Self { position, settings })
    }
}

/// What stands behind the period: `bits=24`, `code=gray`.
fn card<'a>(mut parts: impl Iterator<Item = &'a str>) -> Result<SsiCard, String> {
    parts.try_fold(SsiCard::default(), |card, part| {
        let unknown =
            || format!("\"{part}\"; behind the period may stand bits=24 and code=binary or code=gray");
        match part.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
            Some(("bits", value)) if card.bits.is_none() => {
                Ok(SsiCard { bits: Some(crate::fault::digits(value).ok_or_else(unknown)?), ..card })
            }
            Some(("code", value)) if card.code.is_none() => {
                Ok(SsiCard { code: Some(Code::named(value).ok_or_else(unknown)?), ..card })
            }
            _ => Err(unknown()),
        }
    })
}

/// Kilohertz with up to three decimals.
fn hertz(khz: &str) -> Option<u32> {
    let (whole, decimals) = khz.split_once('.').unwrap_or((khz, "0"));
    if decimals.len() > 3 {
        return None;
    }
    let whole: u32 = crate::fault::digits(whole)?;
    let decimals: u32 = crate::fault::digits(&format!("{decimals:0<3}"))?;
    whole.checked_mul(1_000)?.checked_add(decimals)
}
