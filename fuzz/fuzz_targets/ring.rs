//! Any line into a protocol chip, and any line home to a master.
#![no_main]

use arbitrary::Arbitrary;
use encoring_ring::ident::ENCODER;
use encoring_ring::master::Ended;
use encoring_ring::profile::{BIT_500K, DEVICE_DELAY_BITS};
use encoring_ring::telegram::Bits;
use encoring_ring::{BitRing, Ident, Slave, Sound};
use encoring_words::{InWord, Instant, OutWord};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    ident: u16,
    load: [u8; 64],
    pieces: Vec<(u64, u8)>,
    /// What each piece of a segment is replaced by: segment, bits to turn over.
    flips: Vec<(u8, u64)>,
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
}

/// A ring whose segments do anything: the master takes words of good cycles only, and afterwards it finds back.
fn ring(input: &Input) {
    let mut ring = BitRing::new([(); 2].map(|()| Slave::new(ENCODER, BIT_500K)), BIT_500K);
    ring.bring_up(&mut Sound, 1_000).expect("two encoders fit");
    ring.begin_time();
    let mut flips = input.flips.iter();
    let mut lines = |segment: usize, _: u64, line: Bits| match flips.next() {
        Some((hit, bits)) if usize::from(hit % 4) == segment => {
            Bits { bits: line.bits ^ (bits & (u64::MAX >> (64 - line.count))), count: line.count }
        }
        _ => line,
    };
    let mut words = [InWord(0); 2];
    let mut slot = 0;
    for _ in 0..10 {
        slot += 1;
        let before = words;
        let answers = [Some(InWord(slot)), Some(InWord(!slot))];
        let out = [OutWord(slot); 2];
        let cycled = ring.cycle(Instant(u64::from(slot) * 570_000), &out, &mut words, &answers, &mut lines);
        assert!(cycled.ended == Ended::Good || words == before);
    }
    let good = (0..500).any(|_| {
        slot += 1;
        let at = Instant(u64::from(slot) * 570_000);
        ring.cycle(at, &[OutWord(7); 2], &mut words, &[Some(InWord(8)); 2], &mut Sound).ended == Ended::Good
    });
    assert!(good, "it does not come back");
}

fuzz_target!(|input: Input| {
    chip(&input);
    ring(&input);
});
