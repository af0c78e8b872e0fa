//! What can happen to the bits of a segment: an injector for each, with chance from a seed.
//!
//! An injector works on what a segment carries and knows no telegram. The same seed and the same bits give the same
//! faults; what happens on one segment does not shift the chance of another.

use encoring_ring::bit_level::Lines;
use encoring_ring::telegram::Bits;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What a segment suffers. Chances are per million bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentFault {
    /// Single bits turn over.
    Flips {
        /// Bits of a million.
        per_million: u32,
    },
    /// Some bits in a row, each of which turns over or not; the first one does.
    Bursts {
        /// Bits of a million at which one begins.
        per_million: u32,
        /// How long each is.
        bits: u8,
    },
    /// The line stands at 0.
    StuckLow,
    /// The line stands at 1.
    StuckHigh,
    /// The cable is broken: a receiver without a line reads idle.
    Break,
    /// The edges come too early or too late for the receiver, so that it reads the bit before once more.
    Jitter {
        /// Bits of a million that are read wrong.
        per_million: u32,
    },
    /// 13 bits in a row are missing: the line is idle instead.
    Lost {
        /// Bits of a million at which such a gap begins.
        per_million: u32,
    },
}

/// From 0 to this is every bit.
pub const PER_MILLION: u32 = 1_000_000;

/// Bits of a gap: a data telegram.
const LOST_BITS: u32 = 13;

/// A fault and its time, in line bits since the ring was made.
#[derive(Clone, Copy, Debug)]
struct Window {
    fault: SegmentFault,
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
    pub const fn set(&mut self, fault: SegmentFault, from: u64, to: u64) {
        self.window = Some(Window { fault, from, to });
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

    fn bit(&mut self, fault: SegmentFault, bit: bool) -> bool {
        match fault {
            SegmentFault::Flips { per_million } => bit ^ self.happens(per_million),
            SegmentFault::StuckLow => false,
            SegmentFault::StuckHigh | SegmentFault::Break => true,
            SegmentFault::Jitter { per_million } => {
                if self.happens(per_million) {
                    self.last
                } else {
                    bit
                }
            }
            SegmentFault::Bursts { per_million, bits } => {
                if self.left > 0 {
                    self.left -= 1;
                    return bit ^ self.chance.random::<bool>();
                }
                let begins = self.happens(per_million);
                if begins {
                    self.left = u32::from(bits).saturating_sub(1);
                }
                bit ^ begins
            }
            SegmentFault::Lost { per_million } => {
                if self.left == 0 && self.happens(per_million) {
                    self.left = LOST_BITS;
                }
                let is_lost = self.left > 0;
                self.left = self.left.saturating_sub(1);
                bit || is_lost
            }
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
mod tests {
    use super::*;

    /// 4000 bits of a line, in pieces of every length.
    fn pieces() -> Vec<(u64, Bits)> {
        let mut chance = Pcg64Mcg::seed_from_u64(7);
        let mut at = 1_000;
        let mut pieces = Vec::new();
        while at < 5_000 {
            let count = chance.random_range(1..=64_u32);
            pieces.push((at, Bits { bits: chance.random::<u64>() >> (64 - count), count }));
            at += u64::from(count);
        }
        pieces
    }

    fn bits(pieces: &[(u64, Bits)]) -> Vec<bool> {
        pieces
            .iter()
            .flat_map(|(_, piece)| (0..piece.count).rev().map(|k| piece.bits >> k & 1 != 0))
            .collect()
    }

    fn through(fault: SegmentFault, from: u64, to: u64, seed: u64, segment: usize) -> (Vec<bool>, Vec<bool>) {
        let mut segments = Segments::new(3, seed);
        segments.get_mut(segment).unwrap().set(fault, from, to);
        let before = pieces();
        let after: Vec<(u64, Bits)> =
            before.iter().map(|(at, piece)| (*at, segments.pass(segment, *at, *piece))).collect();
        (bits(&before), bits(&after))
    }

    fn with(per_million: u32) -> [SegmentFault; 4] {
        [
            SegmentFault::Flips { per_million },
            SegmentFault::Bursts { per_million, bits: 1 },
            SegmentFault::Jitter { per_million },
            SegmentFault::Lost { per_million },
        ]
    }

    #[test]
    fn a_chance_of_0_changes_nothing_on_any_segment() {
        for segment in 0..4 {
            for fault in with(0) {
                let (before, after) = through(fault, 0, u64::MAX, 1, segment);
                assert_eq!(before, after, "{fault:?}");
            }
        }
    }

    #[test]
    fn a_chance_of_1_changes_every_bit_on_every_segment() {
        for segment in 0..4 {
            let [flips, bursts, jitter, lost] =
                with(PER_MILLION).map(|fault| through(fault, 0, u64::MAX, 1, segment));
            for (before, after) in [flips, bursts] {
                assert!(before.iter().zip(&after).all(|(before, after)| before != after));
            }
            let (before, after) = jitter;
            assert_eq!(after[1..], before[..before.len() - 1], "every bit is the one before");
            assert!(lost.1.iter().all(|bit| *bit));
        }
    }

    #[test]
    fn a_line_that_stands_does_not_move() {
        for segment in 0..4 {
            let stands = |fault, level| {
                let (before, after) = through(fault, 0, u64::MAX, 1, segment);
                assert!(after.iter().all(|bit| *bit == level));
                assert_eq!(after.len(), before.len());
            };
            stands(SegmentFault::StuckLow, false);
            stands(SegmentFault::StuckHigh, true);
            stands(SegmentFault::Break, true);
        }
    }

    #[test]
    fn a_fault_keeps_to_its_time_to_the_bit_and_to_its_segment() {
        let (before, after) = through(SegmentFault::Flips { per_million: PER_MILLION }, 1_500, 1_777, 1, 2);
        let changed: Vec<u64> = (1_000..)
            .zip(before.iter().zip(&after))
            .filter_map(|(at, (before, after))| (before != after).then_some(at))
            .collect();
        assert_eq!(changed, (1_500..1_777).collect::<Vec<u64>>());
        let mut segments = Segments::new(3, 1);
        segments.get_mut(2).unwrap().set(SegmentFault::StuckLow, 0, u64::MAX);
        for segment in [0, 1, 3] {
            assert_eq!(segments.pass(segment, 1_600, Bits::idle(64)), Bits::idle(64));
        }
    }

    #[test]
    fn a_single_flip_hits_its_bit_and_no_other() {
        let before = pieces();
        for at in [1_000, 1_001, 1_063, 3_210, 4_999] {
            let mut injector = Injector::new(0);
            injector.flip(at);
            let after: Vec<_> =
                before.iter().map(|(begins, piece)| (*begins, injector.pass(*begins, *piece))).collect();
            let changed: Vec<usize> =
                (0..bits(&before).len()).filter(|k| bits(&before)[*k] != bits(&after)[*k]).collect();
            assert_eq!(changed, [(at - 1_000) as usize]);
        }
    }

    #[test]
    fn a_chance_between_hits_about_as_often_as_it_says_and_the_same_seed_the_same_bits() {
        for fault in with(100_000) {
            let (before, after) = through(fault, 0, u64::MAX, 5, 1);
            let changed = before.iter().zip(&after).filter(|(before, after)| before != after).count();
            // Of some 4000 bits; half of the bits that jitter repeats or a gap covers were the same anyway.
            let expected = match fault {
                SegmentFault::Lost { .. } => 800..1_700,
                SegmentFault::Jitter { .. } => 130..280,
                _ => 320..490,
            };
            assert!(expected.contains(&changed), "{fault:?}: {changed}");
            assert_eq!(through(fault, 0, u64::MAX, 5, 1).1, after);
            assert_ne!(through(fault, 0, u64::MAX, 6, 1).1, after, "another seed");
            assert_ne!(through(fault, 0, u64::MAX, 5, 2).1, after, "another segment");
        }
    }

    #[test]
    fn a_burst_is_as_long_as_it_says() {
        let fault = SegmentFault::Bursts { per_million: 2_000, bits: 16 };
        let (before, after) = through(fault, 0, u64::MAX, 3, 0);
        let hits: Vec<usize> = (0..before.len()).filter(|k| before[*k] != after[*k]).collect();
        assert!(!hits.is_empty());
        let mut begins = hits[0];
        let mut bursts = 1;
        for hit in hits {
            if hit - begins >= 16 {
                begins = hit;
                bursts += 1;
            }
        }
        assert!((3..20).contains(&bursts), "{bursts} in 4000 bits");
    }
}
