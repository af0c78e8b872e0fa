//! Errors heavier than any that the check word catches for sure: how often one goes by.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::ident::ENCODER;
use encoring_ring::master::Ended;
use encoring_ring::profile::{BIT_500K, DATA_CR};
use encoring_ring::telegram::Bits;
use encoring_ring::{BitRing, Slave, Sound};
use encoring_words::{InWord, Instant, OutWord};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SLOT_NS: u64 = 677_000;

/// Runs so many spoiled cycles; in how many of them somebody took a word that nobody had sent.
fn taken_wrong(cycles: u32, seed: u64, spoil: impl Fn(&mut Pcg64Mcg, Bits) -> Bits) -> u32 {
    let mut chance = Pcg64Mcg::seed_from_u64(seed);
    let mut sound = BitRing::new([(); 3].map(|()| Slave::new(ENCODER, BIT_500K)), BIT_500K);
    sound.bring_up(&mut Sound, 1_000).unwrap();
    sound.begin_time();
    let (old, new) = ([OutWord(0x1111_1111); 3], [OutWord(0xC200_270F), OutWord(0), OutWord(0xFFFF_FFFF)]);
    let (in_old, in_new) = ([InWord(0x2222_2222); 3], [InWord(1), InWord(0xFFFF_FFFF), InWord(0x00C3_5000)]);
    let mut input = [InWord(0); 3];
    for slot in 1..=2 {
        sound.cycle(Instant(slot * SLOT_NS), &old, &mut input, &in_old.map(Some), &mut Sound);
    }
    (0..cycles)
        .filter(|_| {
            let mut ring = sound.clone();
            let mut input = in_old;
            let hit = chance.random_range(0..=3);
            let mut lines = |segment: usize, _: u64, line: Bits| {
                if segment == hit { spoil(&mut chance, line) } else { line }
            };
            let cycled = ring.cycle(Instant(3 * SLOT_NS), &new, &mut input, &in_new.map(Some), &mut lines);
            let wrong_out = (0..3).any(|k| ring.out_word(k) != old[k] && ring.out_word(k) != new[k]);
            let wrong_in = input != in_old && input != in_new;
            assert!(
                cycled.ended == Ended::Good || input == in_old,
                "the master takes words of good cycles only"
            );
            wrong_out || wrong_in
        })
        .count() as u32
}

// [R6]
#[test]
fn of_data_that_is_noise_one_cycle_in_2_to_the_16_goes_by() {
    // Headers, stop bits, check word and end word stay, so only the check word can notice: 8 of 2^19 are expected.
    let cycles = 1 << 19;
    let wrong = taken_wrong(cycles, 11, |chance, line| match line.count {
        13 if line.bits & u64::from(DATA_CR) == 0 => {
            Bits { bits: line.bits ^ u64::from(chance.random::<u8>()) << 1, count: 13 }
        }
        _ => line,
    });
    assert!((1..=20).contains(&wrong), "{wrong} of {cycles}");
}

#[test]
fn of_a_line_that_is_noise_all_over_nothing_goes_by() {
    let wrong = taken_wrong(1 << 18, 12, |chance, line| match line.count {
        13 => Bits { bits: chance.random::<u64>() >> 51, count: 13 },
        _ => line,
    });
    assert_eq!(wrong, 0);
}
