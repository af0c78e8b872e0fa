//! Any line into a protocol chip, and any line home to a master.
#![no_main]

use arbitrary::Arbitrary;
use encoring_ring::ident::ENCODER;
use encoring_ring::master::Ended;
use encoring_ring::profile::{BIT_500K, DEVICE_DELAY_BITS};
use encoring_ring::slave::{Condition, Jumper};
use encoring_ring::telegram::Bits;
use encoring_ring::{BitRing, EveryBit, Ident, Lines, Slave, Sound};
use encoring_words::{InWord, Instant, OutWord};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    ident: u16,
    load: [u8; 64],
    pieces: Vec<(u64, u8)>,
    /// Segment and time since the one before, bits to turn over.
    flips: Vec<(u8, u64)>,
    /// What is done to a chip before each slot.
    changes: Vec<u8>,
}

/// Bits through one chip: in pieces and one by one it is the same chip.
fn chip(input: &Input) {
    let mut at_once = Slave::new(Ident(input.ident), BIT_500K);
    at_once.load(&input.load);
    let mut clocked = at_once.clone();
    let (mut sent, mut bits) = (Vec::new(), Vec::new());
    for (word, count) in &input.pieces {
        let count = u32::from(count % 64) + 1;
        let piece = Bits { bits: word >> (64 - count), count };
        let tx = at_once.regenerate(piece);
        assert_eq!(tx.count, count);
        sent.extend((0..count).rev().map(|k| tx.bits >> k & 1 != 0));
        bits.extend((0..count).rev().map(|k| clocked.clock(piece.bits >> k & 1 != 0).0));
    }
    let delay = DEVICE_DELAY_BITS as usize;
    assert_eq!(
        bits.get(delay..).unwrap_or_default(),
        sent.get(..sent.len().saturating_sub(delay)).unwrap_or_default()
    );
    assert_eq!(at_once.latched(), clocked.latched());
    assert_eq!(at_once.identification(), clocked.identification());
    assert_eq!(at_once.ages(), clocked.ages());
    for bits in 0..100 {
        assert_eq!(at_once.taken_before(bits), clocked.taken_before(bits));
    }
}

/// Segments that turn bits over, each hit at its time.
#[derive(Clone, Default)]
struct Hits(Vec<(usize, u64, u64)>);

impl Hits {
    fn of(input: &Input) -> Self {
        let mut at = 0;
        let hits = input.flips.iter().map(|(hit, bits)| {
            at += u64::from(hit / 4) * 5;
            (usize::from(hit % 4), at, *bits)
        });
        Self(hits.collect())
    }

    /// The bits that are turned over on a segment from a time on.
    fn on(&self, segment: usize, at: u64) -> u64 {
        let shifted = |(_, from, bits): &(usize, u64, u64)| match from.checked_sub(at) {
            Some(later) => bits.checked_shr(later as u32).filter(|_| later < 64).unwrap_or_default(),
            None => bits.checked_shl((at - from) as u32).filter(|_| at - from < 64).unwrap_or_default(),
        };
        self.0.iter().filter(|hit| hit.0 == segment).fold(0, |all, hit| all ^ shifted(hit))
    }
}

impl Lines for Hits {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        let hit = self.on(segment, at).checked_shr(64 - line.count).unwrap_or_default();
        Bits { bits: line.bits ^ hit, count: line.count }
    }

    fn quiet(&self, from: u64, to: u64) -> bool {
        self.0.iter().all(|(_, at, _)| at + 64 <= from || to <= *at)
    }
}

/// What somebody does to a chip before a slot, and takes back after it.
fn change(ring: &mut BitRing<[Slave; 2]>, what: u8) {
    let Some(slave) = ring.slaves_mut().get_mut(usize::from(what & 1)) else { return };
    match what >> 1 {
        0 => slave.set_condition(Condition::Off),
        1 => slave.set_condition(Condition::Held),
        2 => slave.set_jumper(Jumper::Open),
        3..36 => slave.set_ident(Ident(u16::from(what >> 1) << 8)),
        _ => {}
    }
}

fn take_back(ring: &mut BitRing<[Slave; 2]>) {
    for slave in ring.slaves_mut() {
        if slave.condition() != Condition::Running {
            slave.set_condition(Condition::Running);
        }
        slave.set_jumper(Jumper::Closed);
        slave.set_ident(ENCODER);
    }
}

/// A ring whose segments do anything, with sound slots as a whole and with every bit run: it is the same ring. The
/// master takes words of good cycles only, and afterwards it finds back.
fn ring(input: &Input) {
    let mut ring = BitRing::new([(); 2].map(|()| Slave::new(ENCODER, BIT_500K)), BIT_500K);
    ring.bring_up(&mut Sound, 1_000).expect("two encoders fit");
    ring.begin_time();
    let mut bits = ring.clone();
    let (mut lines, mut same_lines) = (Hits::of(input), Hits::of(input));
    let mut words = [InWord(0); 2];
    let mut slot = 0;
    let mut run = |what: Option<u8>, lines: &mut Hits, same_lines: &mut Hits| {
        slot += 1;
        let before = words;
        let answers = [Some(InWord(slot)), (slot % 3 > 0).then_some(InWord(!slot))];
        let out = [OutWord(slot); 2];
        for ring in [&mut ring, &mut bits] {
            take_back(ring);
            if let Some(what) = what {
                change(ring, what);
            }
        }
        let at = Instant(u64::from(slot) * 570_000);
        let cycled = ring.cycle(at, &out, &mut words, &answers, lines);
        let mut same_words = before;
        let same = bits.cycle(at, &out, &mut same_words, &answers, &mut EveryBit(same_lines));
        assert_eq!((cycled, words), (same, same_words));
        assert!(ring == bits, "slot {slot}: {ring:?}\n{bits:?}");
        assert!(cycled.ended == Ended::Good || words == before);
        cycled.ended
    };
    for k in 0..12 {
        run(input.changes.get(k).copied(), &mut lines, &mut same_lines);
    }
    let good = (0..500).any(|_| run(None, &mut Hits::default(), &mut Hits::default()) == Ended::Good);
    assert!(good, "it does not come back");
}

fuzz_target!(|input: Input| {
    chip(&input);
    ring(&input);
});
