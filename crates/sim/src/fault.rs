//! The faults of a ring: what each is called, and what it does to the bits of a segment.
//!
//! A kind is known here and nowhere else: a scenario, the control port and the command line read it with [`Fault`]'s
//! text form, `KIND[=VALUE]`. An injector works on what a segment carries and knows no telegram. The same seed and the
//! same bits give the same faults; what happens on one segment does not shift the chance of another.

use std::fmt;
use std::str::FromStr;

use encoring_ring::Ident;
use encoring_ring::bit_level::Lines;
use encoring_ring::telegram::Bits;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// What a ring can suffer, on a segment or at a device. Chances are per million line bits; at word level a cycle is bad
/// with the chance that its bits have together.
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
    /// It shows another identification word. The word level knows none.
    Ident(Ident),
}

/// Every kind, in the order in which the pages list them. The values are to be replaced.
const KINDS: [Fault; 12] = [
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
];

/// From 0 to this is every bit.
pub const PER_MILLION: u32 = 1_000_000;

/// How long a burst is.
const BURST_BITS: u32 = 16;

/// Bits of a gap: a data telegram.
const LOST_BITS: u32 = 13;

/// What stands behind the `=` of a kind.
enum Value<'a> {
    Nothing,
    Chance(&'a mut u32),
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
            Self::Flips(_) => ("flips", "of a million bits N are turned over"),
            Self::Bursts(_) => ("bursts", "of a million bits N begin a burst of 16"),
            Self::Jitter(_) => ("jitter", "of a million bits N are read as the one before"),
            Self::Lost(_) => ("lost", "of a million bits N begin a gap of a telegram"),
            Self::Supply => ("supply", "no supply; afterwards 24 V"),
            Self::Chip => ("chip", "the protocol chip is held in reset"),
            Self::Jumper => ("jumper", "the jumper for the next device is missing"),
            Self::Ident(_) => ("ident", "another identification word"),
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
            Self::Bad | Self::Silent | Self::Low | Self::High | Self::Supply | Self::Chip | Self::Jumper => {
                Value::Nothing
            }
        }
    }

    /// `true` for what a segment suffers; the others are of a device.
    #[must_use]
    pub const fn is_of_line(self) -> bool {
        !matches!(self, Self::Supply | Self::Chip | Self::Jumper | Self::Ident(_))
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
                Value::Chance(_) => "=N",
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

    fn chance(mut self) -> Option<u32> {
        match self.value() {
            Value::Chance(chance) => Some(*chance),
            Value::Nothing | Value::Ident(_) => None,
        }
    }

    /// Whether the word level would not show it as it was asked for.
    #[must_use]
    pub const fn needs_bits(self) -> bool {
        !matches!(self, Self::Bad | Self::Silent | Self::Supply | Self::Chip | Self::Jumper)
    }

    /// A line that does not move carries nothing.
    pub(crate) const fn silences(self) -> bool {
        matches!(self, Self::Silent | Self::Low | Self::High)
    }

    /// Whether it hits a cycle of so many bits, at word level.
    pub(crate) fn spoils(self, bits: u64, draws: &mut impl RngExt) -> bool {
        match self.chance() {
            Some(chance) => draws.random_range(0..u64::from(PER_MILLION)) < bits * u64::from(chance),
            None => self.hits_each_frame(),
        }
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
            Value::Chance(chance) => write!(f, "={chance}"),
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
            (Value::Ident(ident), value) => {
                let word =
                    value.filter(|word| word.len() == 4 && word.bytes().all(|c| c.is_ascii_hexdigit()));
                let word = word.and_then(|word| u16::from_str_radix(word, 16).ok());
                let wrong = || "ident takes an identification word of 4 hex digits, as ident=0303".to_owned();
                ident.0 = word.ok_or_else(wrong)?;
            }
        }
        Ok(fault)
    }
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
                let (name, per_million) = kind.ok_or_else(|| de::Error::invalid_length(0, &self))?;
                let mut fault = Fault::named(&name).map_err(de::Error::custom)?;
                let Value::Chance(chance) = fault.value() else {
                    return Err(de::Error::custom(format_args!("{name} takes no number; write \"{name}\"")));
                };
                *chance = per_million;
                if per_million > PER_MILLION {
                    let limits =
                        format_args!("bits in a million {per_million}; the limits are 0 and {PER_MILLION}");
                    return Err(de::Error::custom(limits));
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

/// A fault and its time, in line bits since the ring was made.
#[derive(Clone, Copy, Debug)]
struct Window {
    fault: Fault,
    from: u64,
    to: u64,
}

/// The injector of one segment.
#[derive(Clone, Debug)]
pub struct Injector {
    window: Option<Window>,
    /// Bits to be turned over once, at this time.
    once: Option<u64>,
    chance: Pcg64Mcg,
    /// Bits that the present burst or gap still has.
    left: u32,
    /// The last bit that came.
    last: bool,
}

impl Injector {
    /// An injector that changes nothing yet.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { window: None, once: None, chance: Pcg64Mcg::seed_from_u64(seed), left: 0, last: true }
    }

    /// A fault from bit `from` on, up to and without bit `to`, in place of any other.
    pub const fn set(&mut self, fault: Fault, from: u64, to: u64) {
        self.window = if fault.hits_each_frame() { None } else { Some(Window { fault, from, to }) };
        self.left = 0;
    }

    /// Ends every fault.
    pub const fn clear(&mut self) {
        self.window = None;
        self.left = 0;
    }

    /// Turns one bit over.
    pub const fn flip(&mut self, at: u64) {
        self.once = Some(at);
    }

    /// What becomes of some bits, the first of them at `at`.
    pub fn pass(&mut self, at: u64, line: Bits) -> Bits {
        let ends = at + u64::from(line.count);
        let mut bits = line.bits;
        if let Some(once) = self.once
            && once < ends
        {
            if once >= at {
                bits ^= 1 << (ends - 1 - once);
            }
            self.once = None;
        }
        match self.window {
            Some(window) if window.from < ends && at < window.to => {
                let mut changed = 0;
                for (k, time) in (0..line.count).rev().zip(at..) {
                    let bit = bits >> k & 1 != 0;
                    let inside = (window.from..window.to).contains(&time);
                    changed =
                        changed << 1 | u64::from(if inside { self.bit(window.fault, bit) } else { bit });
                    self.last = bit;
                }
                Bits { bits: changed, count: line.count }
            }
            _ => {
                self.last = bits & 1 != 0 || line.count == 0 && self.last;
                Bits { bits, count: line.count }
            }
        }
    }

    fn bit(&mut self, fault: Fault, bit: bool) -> bool {
        match fault {
            Fault::Low => false,
            Fault::High | Fault::Silent => true,
            Fault::Flips(per_million) => bit ^ self.happens(per_million),
            Fault::Jitter(per_million) => {
                if self.happens(per_million) {
                    self.last
                } else {
                    bit
                }
            }
            Fault::Bursts(per_million) => {
                if self.left > 0 {
                    self.left -= 1;
                    return bit ^ self.chance.random::<bool>();
                }
                let begins = self.happens(per_million);
                if begins {
                    self.left = BURST_BITS - 1;
                }
                bit ^ begins
            }
            Fault::Lost(per_million) => {
                if self.left == 0 && self.happens(per_million) {
                    self.left = LOST_BITS;
                }
                let is_lost = self.left > 0;
                self.left = self.left.saturating_sub(1);
                bit || is_lost
            }
            // What hits each frame is told from outside, and the rest leaves lines alone.
            Fault::Bad | Fault::Supply | Fault::Chip | Fault::Jumper | Fault::Ident(_) => bit,
        }
    }

    fn happens(&mut self, per_million: u32) -> bool {
        self.chance.random_range(0..PER_MILLION) < per_million
    }
}

/// The segments of a ring, each with its injector.
#[derive(Clone, Debug)]
pub struct Segments(Vec<Injector>);

impl Segments {
    /// Those of a ring with so many devices: one more than these.
    #[must_use]
    pub fn new(devices: usize, seed: u64) -> Self {
        // Each has a stream of its own.
        Self(
            (0..=devices as u64)
                .map(|segment| Injector::new(seed ^ segment.wrapping_mul(0x9E37_79B9_7F4A_7C15)))
                .collect(),
        )
    }

    /// The injector of a segment.
    pub fn get_mut(&mut self, segment: usize) -> Option<&mut Injector> {
        self.0.get_mut(segment)
    }

    /// Ends every fault.
    pub fn clear(&mut self) {
        self.0.iter_mut().for_each(Injector::clear);
    }
}

impl Lines for Segments {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        match self.0.get_mut(segment) {
            Some(injector) if injector.window.is_some() || injector.once.is_some() => injector.pass(at, line),
            _ => line,
        }
    }
}

#[cfg(test)]
mod tests;
