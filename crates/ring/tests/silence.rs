//! What a chip does when its line is silent, and when its master only keeps it awake.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::ident::ENCODER;
use encoring_ring::profile::BIT_500K;
use encoring_ring::telegram::{Bits, statuses};
use encoring_ring::{BitRing, Slave, Sound};
use encoring_words::{InWord, Instant, OutWord};

/// Line bits of 2 us in a millisecond.
const MS: u32 = 500;

/// The chip in the middle of a ring of three that has just taken a word.
fn chip() -> Slave {
    let mut ring = BitRing::new([(); 3].map(|()| Slave::new(ENCODER, BIT_500K)), BIT_500K);
    ring.bring_up(&mut Sound, 1_000).unwrap();
    ring.begin_time();
    let out = [OutWord(0x8300_0000); 3];
    ring.cycle(Instant(677_000), &out, &mut [InWord(0); 3], &[Some(InWord(0)); 3], &mut Sound);
    ring.slaves()[1].clone()
}

fn held(chip: &Slave) -> u32 {
    chip.taken().shown().0
}

fn silence(chip: &mut Slave, bits: u32) {
    for _ in 0..bits {
        chip.regenerate(Bits::idle(1));
    }
}

#[test]
fn a_silent_line_leaves_the_word_for_25_ms_and_no_longer() {
    for already in [0, 1, 7, 20 * MS] {
        let mut chip = chip();
        assert_eq!(held(&chip), 0x8300_0000);
        silence(&mut chip, already);
        let left = 25 * MS - chip.ages().0 as u32;
        silence(&mut chip, left);
        assert_eq!(held(&chip), 0x8300_0000, "25 ms are not too long");
        assert!(chip.lamps().rc && chip.position().is_some());
        silence(&mut chip, 1);
        assert_eq!(held(&chip), 0);
        assert!(!chip.lamps().rc && chip.position().is_none());
        assert!(chip.taken().word.is_none());
    }
}

#[test]
fn a_silence_that_ends_in_time_counts_for_nothing() {
    let mut chip = chip();
    for _ in 0..10 {
        silence(&mut chip, 24 * MS);
        chip.regenerate(statuses(2));
        assert_eq!(held(&chip), 0x8300_0000);
    }
}

#[test]
fn status_telegrams_alone_keep_the_word_and_ba_goes_off_after_640_ms() {
    let mut chip = chip();
    let begun = chip.ages().1.unwrap();
    while chip.ages().1.unwrap() + 60 <= 640 * u64::from(MS) {
        chip.regenerate(statuses(12));
    }
    assert!(chip.ages().1.unwrap() > begun);
    assert!(chip.lamps().ba && chip.lamps().rc);
    assert_eq!(held(&chip), 0x8300_0000);
    chip.regenerate(statuses(12));
    assert!(!chip.lamps().ba && chip.lamps().rc);
    assert_eq!(held(&chip), 0x8300_0000);
}
