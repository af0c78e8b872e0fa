//! The faults of a ring and of an SSI: what each is called. What they do to the bits of a segment is in
//! [`crate::injector`].
//!
//! A kind is known here and nowhere else: a scenario, the control port and the command line read it with [`Fault`]'s
//! text form, `KIND[=VALUE]`.

use std::fmt;
use std::str::FromStr;

use encoring_ring::Ident;
use encoring_words::number::{self, Bare};
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

pub use crate::gaps::PER_MILLION;
pub use ssi::SsiTrouble;

mod ssi;

/// The longest time that the data of an SSI can be late by, in nanoseconds.
pub const LATE_NS_MAX: u32 = 1_000_000;

/// What a ring can suffer, on a segment or at a device. Chances are per million line bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Every cycle fails its check on the segment: one bit of its frame turns over.
    Bad,
    /// The cable is broken: nothing passes, and a receiver without a line reads idle.
    Silent,
    /// The line stands at 0.
    Low,
    /// The line stands at 1.
    High,
    /// Single bits turn over.
    Flips(u32),
    /// Bursts of 16 bits begin, each bit of which turns over or not; the first one does.
    Bursts(u32),
    /// The edges come too early or too late for the receiver, so that it reads the bit before once more.
    Jitter(u32),
    /// 13 bits in a row are missing: the line is idle instead.
    Lost(u32),
    /// The device has no supply; afterwards it has 24 V.
    Supply,
    /// Its protocol chip is held in reset.
    Chip,
    /// The jumper for the next device is missing [R137].
    Jumper,
    /// It shows another identification word.
    Ident(Ident),
    /// Something happens between its SSI and the reader.
    Ssi(SsiTrouble),
}

/// Every kind, in the order in which the pages list them. The values are to be replaced.
const KINDS: [Fault; 19] = [
    Fault::Bad,
    Fault::Silent,
    Fault::Low,
    Fault::High,
    Fault::Flips(0),
    Fault::Bursts(0),
    Fault::Jitter(0),
    Fault::Lost(0),
    Fault::Supply,
    Fault::Chip,
    Fault::Jumper,
    Fault::Ident(Ident(0)),
    Fault::Ssi(SsiTrouble::Lost(0)),
    Fault::Ssi(SsiTrouble::Added(0)),
    Fault::Ssi(SsiTrouble::Flips(0)),
    Fault::Ssi(SsiTrouble::Skew(0)),
    Fault::Ssi(SsiTrouble::Delay(0)),
    Fault::Ssi(SsiTrouble::Low),
    Fault::Ssi(SsiTrouble::High),
];

/// What stands behind the `=` of a kind.
enum Value<'a> {
    Nothing,
    Chance(&'a mut u32),
    /// In nanoseconds.
    Late(&'a mut u32),
    Ident(&'a mut Ident),
}

impl Fault {
    /// What it is called, and what it is.
    const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Bad => ("bad", "every cycle fails its check there"),
            Self::Silent => ("silent", "nothing passes: a broken cable"),
            Self::Low => ("low", "the line stands at 0"),
            Self::High => ("high", "the line stands at 1"),
            Self::Flips(_) => ("flips", "N of a million bits are inverted"),
            Self::Bursts(_) => ("bursts", "N of a million bits start a burst of 16 bits"),
            Self::Jitter(_) => ("jitter", "N of a million bits are read as the bit before"),
            Self::Lost(_) => ("lost", "N of a million bits start a gap of one telegram"),
            Self::Supply => ("supply", "no supply; 24 V when the fault ends"),
            Self::Chip => ("chip", "the protocol chip is held in reset"),
            Self::Jumper => ("jumper", "the jumper for the next device is missing"),
            Self::Ident(_) => ("ident", "another identification word"),
            Self::Ssi(trouble) => trouble.words(),
        }
    }

    const fn name(self) -> &'static str {
        self.words().0
    }

    const fn value(&mut self) -> Value<'_> {
        match self {
            Self::Flips(chance) | Self::Bursts(chance) | Self::Jitter(chance) | Self::Lost(chance) => {
                Value::Chance(chance)
            }
            Self::Ident(ident) => Value::Ident(ident),
            Self::Ssi(SsiTrouble::Lost(chance) | SsiTrouble::Added(chance) | SsiTrouble::Flips(chance)) => {
                Value::Chance(chance)
            }
            Self::Ssi(SsiTrouble::Skew(ns) | SsiTrouble::Delay(ns)) => Value::Late(ns),
            Self::Ssi(SsiTrouble::Low | SsiTrouble::High) => Value::Nothing,
            Self::Bad | Self::Silent | Self::Low | Self::High | Self::Supply | Self::Chip | Self::Jumper => {
                Value::Nothing
            }
        }
    }

    /// `true` for what a segment suffers; the others are of a device.
    #[must_use]
    pub const fn is_of_line(self) -> bool {
        !matches!(self, Self::Supply | Self::Chip | Self::Jumper | Self::Ident(_) | Self::Ssi(_))
    }

    /// What an SSI suffers; `None` if it is one of the ring.
    #[must_use]
    pub const fn on_ssi(self) -> Option<SsiTrouble> {
        match self {
            Self::Ssi(trouble) => Some(trouble),
            _ => None,
        }
    }

    /// The same, if a segment can suffer it.
    ///
    /// # Errors
    /// A fault of a device, with what is allowed.
    pub fn on_line(self) -> Result<Self, String> {
        let wrong = || format!("{self} is no fault of a line; those are {}", Self::forms(Self::is_of_line));
        if self.is_of_line() { Ok(self) } else { Err(wrong()) }
    }

    /// Every kind with its form, `flips=N`, and what it is.
    pub fn kinds() -> impl Iterator<Item = (Self, String, &'static str)> {
        KINDS.into_iter().map(|mut fault| {
            let value = match fault.value() {
                Value::Nothing => "",
                Value::Chance(_) | Value::Late(_) => "=N",
                Value::Ident(_) => "=HHHH",
            };
            let (name, meaning) = fault.words();
            (fault, format!("{name}{value}"), meaning)
        })
    }

    /// The forms of the kinds that are so, for a sentence.
    #[must_use]
    pub fn forms(are: fn(Self) -> bool) -> String {
        let forms: Vec<String> =
            Self::kinds().filter(|(fault, ..)| are(*fault)).map(|(_, form, _)| form).collect();
        forms.join(", ")
    }

    fn named(name: &str) -> Result<Self, String> {
        let unknown = || format!("kind \"{name}\"; the kinds are {}", Self::forms(|_| true));
        KINDS.into_iter().find(|fault| fault.name() == name).ok_or_else(unknown)
    }

    /// Whether one bit of each frame turns over, and none by itself.
    pub(crate) const fn hits_each_frame(self) -> bool {
        matches!(self, Self::Bad)
    }
}

/// `KIND[=VALUE]`, as it is read.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        match { *self }.value() {
            Value::Nothing => Ok(()),
            Value::Chance(number) | Value::Late(number) => write!(f, "={number}"),
            Value::Ident(ident) => write!(f, "={:04X}", ident.0),
        }
    }
}

/// `KIND[=VALUE]`. A chance is at least 1: whoever writes a fault on one line wants one.
impl FromStr for Fault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = match text.split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (text, None),
        };
        let mut fault = Self::named(name)?;
        match (fault.value(), value) {
            (Value::Nothing, None) => {}
            (Value::Nothing, Some(value)) => {
                return Err(format!("value \"{value}\" for {name}, which takes none"));
            }
            (Value::Chance(chance), value) => {
                let given = value.map_or_else(|| "no value".to_owned(), |value| format!("value \"{value}\""));
                *chance = value.and_then(digits).filter(|chance| (1..=PER_MILLION).contains(chance)).ok_or_else(
                    || format!("{given} for {name}; write {name}=N with N from 1 to {PER_MILLION}, bits of a million"),
                )?;
            }
            (Value::Late(ns), value) => {
                let wrong = || {
                    format!("{name} takes a time: write {name}=N with N from 1 to {LATE_NS_MAX} nanoseconds")
                };
                *ns = value.and_then(digits).filter(|ns| (1..=LATE_NS_MAX).contains(ns)).ok_or_else(wrong)?;
            }
            (Value::Ident(ident), value) => {
                let value = value
                    .ok_or("ident takes an identification word of 16 bits, as ident=0303 or ident=0x0303")?;
                *ident = identification(value)?;
            }
        }
        Ok(fault)
    }
}

/// An identification word as people write the half of a word.
pub(crate) fn identification(text: &str) -> Result<Ident, String> {
    let read = number::half(text, Bare::Hexadecimal).map_err(|refused| format!("ident: {refused}"))?;
    Ok(Ident(read.bits as u16))
}

/// A whole number of nothing but digits.
pub(crate) fn digits<N: FromStr>(text: &str) -> Option<N> {
    let all = !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
    if all { text.parse().ok() } else { None }
}

/// In a table: `"silent"`, `"flips=20"` or `{ flips = 20 }`.
impl<'de> Deserialize<'de> for Fault {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Written;

        impl<'de> Visitor<'de> for Written {
            type Value = Fault;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a kind of fault, as \"silent\" or { flips = 20 }")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Fault, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fault, A::Error> {
                let kind: Option<(String, u32)> = map.next_entry()?;
                let (name, number) = kind.ok_or_else(|| de::Error::invalid_length(0, &self))?;
                let mut fault = Fault::named(&name).map_err(de::Error::custom)?;
                let (place, what, limit) = match fault.value() {
                    Value::Chance(chance) => (chance, "bits in a million", PER_MILLION),
                    Value::Late(ns) => (ns, "nanoseconds", LATE_NS_MAX),
                    Value::Nothing | Value::Ident(_) => {
                        let told = format_args!("{name} takes no number; write \"{name}\"");
                        return Err(de::Error::custom(told));
                    }
                };
                *place = number;
                if number > limit {
                    return Err(de::Error::custom(format_args!(
                        "{what} {number}; the limits are 0 and {limit}"
                    )));
                }
                match map.next_key::<String>()? {
                    None => Ok(fault),
                    Some(second) => {
                        Err(de::Error::custom(format_args!("{second} beside {name}; a line has one fault")))
                    }
                }
            }
        }

        source.deserialize_any(Written)
    }
}

#[cfg(test)]
mod tests;
