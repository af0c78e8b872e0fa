//! What faults do to the bits of a ring's segments.
//!
//! An injector works on what a segment carries and knows no telegram. The same seed and the same bits give the same
//! faults; what happens on one segment does not shift the chance of another.

use encoring_ring::Lines;
use encoring_ring::telegram::Bits;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::fault::Fault;
use crate::gaps::Gaps;

#[cfg(test)]
mod tests;

/// How long a burst is.
const BURST_BITS: u32 = 16;

/// Bits of a gap: a data telegram.
const LOST_BITS: u32 = 13;

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
