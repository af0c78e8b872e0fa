//! The faults of a ring and of an SSI: what each is called, and what it does to the bits of a segment.
//!
//! A kind is known here and nowhere else: a scenario, the control port and the command line read it with [`Fault`]'s
//! text form, `KIND[=VALUE]`. An injector works on what a segment carries and knows no telegram. The same seed and the
//! same bits give the same faults; what happens on one segment does not shift the chance of another.

use std::fmt;
use std::str::FromStr;

use encoring_ring::Ident;
use encoring_ring::Lines;
use encoring_ring::telegram::Bits;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::gaps::Gaps;
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

/// How long a burst is.
const BURST_BITS: u32 = 16;

/// Bits of a gap: a data telegram.
const LOST_BITS: u32 = 13;

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
            Self::Flips(_) => ("flips", "of a million bits N are turned over"),
            Self::Bursts(_) => ("bursts", "of a million bits N begin a burst of 16"),
            Self::Jitter(_) => ("jitter", "of a million bits N are read as the one before"),
            Self::Lost(_) => ("lost", "of a million bits N begin a gap of a telegram"),
            Self::Supply => ("supply", "no supply; afterwards 24 V"),
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

/// How the hits of a fault come.
enum Hits {
    /// None by itself.
    None,
    /// One, all the time.
    Throughout,
    /// Each bit begins one of so many bits with the same chance.
    Random { per_million: u32, bits: u32 },
}

impl Fault {
    const fn hits(self) -> Hits {
        match self {
            Self::Low | Self::High | Self::Silent => Hits::Throughout,
            Self::Flips(per_million) | Self::Jitter(per_million) => Hits::Random { per_million, bits: 1 },
            Self::Bursts(per_million) => Hits::Random { per_million, bits: BURST_BITS },
            Self::Lost(per_million) => Hits::Random { per_million, bits: LOST_BITS },
            // What hits each frame is told from outside, and the rest leaves lines alone.
            Self::Bad | Self::Supply | Self::Chip | Self::Jumper | Self::Ident(_) | Self::Ssi(_) => {
                Hits::None
            }
        }
    }

    /// What becomes of the bits of a line in a hit: `late` are those that came one bit before each, `pattern` is a burst.
    const fn strike(self, line: u64, late: u64, pattern: u64) -> u64 {
        match self {
            Self::Flips(_) => !line,
            Self::Low => 0,
            Self::High | Self::Silent | Self::Lost(_) => u64::MAX,
            Self::Jitter(_) => late,
            Self::Bursts(_) => line ^ pattern,
            Self::Bad | Self::Supply | Self::Chip | Self::Jumper | Self::Ident(_) | Self::Ssi(_) => line,
        }
    }
}

/// A fault for a time. All times are in line bits since the ring was made.
#[derive(Clone, Debug)]
struct Window {
    fault: Fault,
    to: u64,
    /// `None` if one hit lasts throughout.
    random: Option<(Gaps, u32)>,
    hit: Hit,
}

/// The present or next hit.
#[derive(Clone, Copy, Debug)]
struct Hit {
    from: u64,
    to: u64,
    /// Which bits of a burst turn over, the first one on top.
    pattern: u16,
}

impl Window {
    fn new(fault: Fault, from: u64, to: u64, chance: &mut Pcg64Mcg) -> Option<Self> {
        let throughout = Hit { from, to, pattern: 0 };
        match fault.hits() {
            Hits::None | Hits::Random { per_million: 0, .. } => None,
            Hits::Throughout => Some(Self { fault, to, random: None, hit: throughout }),
            Hits::Random { per_million, bits } => {
                let random = Some((Gaps::new(per_million), bits));
                let mut window = Self { fault, to, random, hit: throughout };
                window.find_hit(from, chance);
                Some(window)
            }
        }
    }

    /// The next hit, not before `from`. Which bits came before does not matter to a chance that is the same for each.
    fn find_hit(&mut self, from: u64, chance: &mut Pcg64Mcg) {
        let Some((gaps, bits)) = &self.random else {
            self.hit.from = u64::MAX;
            return;
        };
        let from = from.saturating_add(gaps.draw(chance));
        let pattern = if let Fault::Bursts(_) = self.fault { chance.random::<u16>() | 0x8000 } else { 0 };
        self.hit = Hit { from, to: from.saturating_add(u64::from(*bits)), pattern };
    }

    /// What becomes of a piece of the line, the first of its bits at `at` and `late` one bit before each.
    fn pass(&mut self, at: u64, line: Bits, late: u64, chance: &mut Pcg64Mcg) -> u64 {
        let ends = at + u64::from(line.count);
        let mut bits = line.bits;
        if self.hit.to <= at && at < self.to {
            self.find_hit(at, chance);
        }
        while self.hit.from < ends.min(self.to) {
            let Hit { from, to, pattern } = self.hit;
            let hit = span(from.max(at), to.min(self.to), ends);
            let first = from.saturating_add(u64::from(u16::BITS));
            let pattern = u64::from(pattern);
            let pattern = if first <= ends {
                pattern.checked_shl((ends - first) as u32).unwrap_or_default()
            } else {
                pattern.checked_shr((first - ends) as u32).unwrap_or_default()
            };
            bits = bits & !hit | self.fault.strike(line.bits, late, pattern) & hit;
            if to > ends {
                break;
            }
            self.find_hit(to, chance);
        }
        bits
    }

    /// Whether no hit touches bit `from` and those after it, up to and without bit `to`. One that it has still to catch
    /// up with is a hit.
    const fn is_quiet(&self, from: u64, to: u64) -> bool {
        self.to <= from || self.hit.from >= to || self.hit.from >= self.to
    }
}

/// The lowest bits, so many of them.
const fn below(bits: u64) -> u64 {
    if bits < 64 { (1 << bits) - 1 } else { u64::MAX }
}

/// The bits from `from` up to and without `to` of a piece of at most 64 that ends with bit `ends - 1`.
const fn span(from: u64, to: u64, ends: u64) -> u64 {
    let low = ends.saturating_sub(to);
    let high = ends.saturating_sub(from);
    below(high) & !below(low)
}

/// The injector of one segment.
#[derive(Clone, Debug)]
pub struct Injector {
    window: Option<Box<Window>>,
    /// A bit to be turned over once.
    once: Option<u64>,
    chance: Pcg64Mcg,
    /// The last bit that came, if it was a 0, as the time of the one after it. Between two slots a line is at 1.
    low: Option<u64>,
}

impl Injector {
    /// An injector that changes nothing yet.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { window: None, once: None, chance: Pcg64Mcg::seed_from_u64(seed), low: None }
    }

    /// A fault from bit `from` on, up to and without bit `to`, in place of any other.
    pub fn set(&mut self, fault: Fault, from: u64, to: u64) {
        self.window = Window::new(fault, from, to, &mut self.chance).map(Box::new);
    }

    /// Ends every fault.
    pub fn clear(&mut self) {
        self.window = None;
    }

    /// Turns one bit over.
    pub const fn flip(&mut self, at: u64) {
        self.once = Some(at);
    }

    /// What becomes of some bits, the first of them at `at`.
    pub fn pass(&mut self, at: u64, mut line: Bits) -> Bits {
        let ends = at + u64::from(line.count);
        if let Some(once) = self.once
            && once < ends
        {
            line.bits ^= span(once.max(at), once + 1, ends);
            self.once = None;
        }
        let mut bits = line.bits;
        if let Some(window) = &mut self.window {
            let before = self.low != Some(at);
            let late = line.bits >> 1 | u64::from(before) << line.count.saturating_sub(1);
            bits = window.pass(at, line, late, &mut self.chance);
        }
        self.low = (line.bits & 1 == 0).then_some(ends);
        Bits { bits, count: line.count }
    }

    /// Whether it changes nothing from bit `from` on, up to and without bit `to`.
    #[must_use]
    pub fn is_quiet(&self, from: u64, to: u64) -> bool {
        self.once.is_none_or(|once| once >= to)
            && self.window.as_ref().is_none_or(|window| window.is_quiet(from, to))
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

    fn quiet(&self, from: u64, to: u64) -> bool {
        self.0.iter().all(|injector| injector.is_quiet(from, to))
    }
}

#[cfg(test)]
mod tests;
