//! The ring at bit level: it opens, moves words, and follows what happens to its segments and devices.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::ident::ENCODER;
use encoring_ring::master::Ended;
use encoring_ring::profile::BIT_500K;
use encoring_ring::{BitRing, CycleTime, Slave, Sound, Verdict};
use encoring_words::{InWord, Instant, OutWord};

fn encoders(count: usize) -> BitRing<Vec<Slave>> {
    let slaves = (0..count).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
    let mut ring = BitRing::new(slaves, BIT_500K);
    ring.bring_up(&mut Sound, 100_000).unwrap();
    ring.begin_time();
    ring
}

#[test]
fn words_move_both_ways_through_every_length_of_ring() {
    for count in [1, 2, 3, 16, 128] {
        let mut ring = encoders(count);
        let cycle = CycleTime::default().of_encoders(count as u32).as_nanos();
        for k in 1..4_u32 {
            let out: Vec<OutWord> = (0..count as u32).map(|p| OutWord(0xC200_0000 ^ k << 16 ^ p)).collect();
            let answers: Vec<_> =
                (0..count as u32).map(|p| Some(InWord(0xE3A5_E3A5_u32.rotate_left(k) ^ p))).collect();
            let mut input = vec![InWord(0); count];
            let cycled = ring.cycle(Instant(u64::from(k) * cycle), &out, &mut input, &answers, &mut Sound);
            assert_eq!((cycled.ended, cycled.verdict), (Ended::Good, Verdict::Good), "{count}");
            for p in 0..count {
                assert_eq!(ring.out_word(p), out[p]);
                assert_eq!(Some(input[p]), answers[p]);
            }
        }
        assert_eq!(ring.master().status(), 0x00E0);
        assert_eq!(ring.master().parameter(), 0);
    }
}
