//! The bit level beside the word level: any ring, any data, any faults. The word level is told how each slot of the bit
//! level went, and nothing else; then both must have moved the same words and light the same lamps.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::ident::ENCODER;
use encoring_ring::profile::{BIT_2M, BIT_500K, RESET_AFTER};
use encoring_ring::slave::Condition;
use encoring_ring::{BitRing, CycleTime, Slave, Sound, Verdict, WordRing};
use encoring_sim::Fault;
use encoring_sim::fault::Segments;
use encoring_words::{InWord, Instant, OutWord};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// How often each kind of slot was seen, so that the test cannot pass by never getting into trouble.
#[derive(Debug, Default)]
struct Seen {
    good: u32,
    bad: u32,
    silent: u32,
    /// Comparisons left out after noise on a dead line.
    astray: u32,
    searches: u64,
}

fn any_fault(chance: &mut Pcg64Mcg) -> Fault {
    let per_million = [20, 200, 2_000, 50_000][chance.random_range(0..4_usize)];
    match chance.random_range(0..7) {
        0 => Fault::Flips(per_million),
        1 => Fault::Bursts(per_million),
        2 => Fault::Jitter(per_million),
        3 => Fault::Lost(per_million),
        4 => Fault::Low,
        5 => Fault::High,
        _ => Fault::Silent,
    }
}

fn compare(seed: u64, seen: &mut Seen) {
    let mut chance = Pcg64Mcg::seed_from_u64(seed);
    let encoders = [1, 2, 3, 5, 16][chance.random_range(0..5_usize)];
    let bit = if chance.random() { BIT_500K } else { BIT_2M };
    let cycle = CycleTime { bit, ..CycleTime::default() }.of_encoders(encoders as u32).as_nanos();
    let mut bits = BitRing::new((0..encoders).map(|_| Slave::new(ENCODER, bit)).collect::<Vec<_>>(), bit);
    bits.bring_up(&mut Sound, 10_000).unwrap();
    bits.begin_time();
    let mut words = WordRing::default();
    let mut segments = Segments::new(encoders, seed);
    let mut seen_bits = vec![InWord(0); encoders];
    let mut seen_words = seen_bits.clone();
    let mut quiet_until = 0;
    let mut off_until = vec![0_u64; encoders];
    // Two things the verdict of a slot cannot tell. A line that dies in the middle of a slot is silent a little earlier
    // than the word level thinks, so a reset may come some slots earlier. And noise on a dead line can look like status
    // telegrams: then the devices behind it are not reset, and keep what they took until they take something again.
    let mut differs_since = vec![None; encoders];
    let mut noise_until = 0;
    let mut astray = vec![false; encoders];
    for slot in 1..=400_u64 {
        let now = Instant(slot * cycle);
        if slot >= quiet_until {
            segments.clear();
            if chance.random_range(0..3) == 0 {
                let segment = chance.random_range(0..=encoders);
                let fault = any_fault(&mut chance);
                segments.get_mut(segment).unwrap().set(fault, 0, u64::MAX);
                let stands = [Fault::Low, Fault::High, Fault::Silent];
                if !stands.contains(&fault) {
                    noise_until = u64::MAX;
                }
            } else if noise_until == u64::MAX {
                noise_until = slot;
            }
            quiet_until = slot + chance.random_range(1..60);
        }
        let position = chance.random_range(0..encoders);
        if chance.random_range(0..100) == 0 {
            off_until[position] = slot + chance.random_range(1..40);
        }
        for (position, until) in off_until.iter().enumerate() {
            let condition = if slot < *until { Condition::Off } else { Condition::Running };
            if bits.slaves()[position].condition() != condition {
                bits.slaves_mut()[position].set_condition(condition);
                words.power_off(position);
            }
        }
        let out: Vec<OutWord> = (0..encoders).map(|_| OutWord(chance.random())).collect();
        let answers: Vec<_> = (0..encoders)
            .map(|_| (chance.random_range(0..20) > 0).then(|| InWord(chance.random())))
            .collect();
        let cycled = bits.cycle(now, &out, &mut seen_bits, &answers, &mut segments);
        words.cycle(now, &out, &mut seen_words, &answers, cycled.verdict);
        for (position, until) in off_until.iter().enumerate() {
            if slot < *until {
                // Without supply nothing is taken, whatever the line says.
                words.power_off(position);
            }
        }
        match cycled.verdict {
            Verdict::Good => seen.good += 1,
            Verdict::Bad { .. } => seen.bad += 1,
            Verdict::Silent { .. } => seen.silent += 1,
        }
        let told = format!("seed {seed} slot {slot} {cycled:?}");
        assert_eq!(seen_bits, seen_words, "{told}");
        let few_slots = RESET_AFTER.as_nanos() / cycle + 6;
        for position in 0..encoders {
            let lamps = bits.lamps(position).unwrap();
            let is_noisy = slot < noise_until.saturating_add(few_slots);
            if lamps.rc != words.incoming_connected(position, now) {
                let since = *differs_since[position].get_or_insert(slot);
                assert!(is_noisy || slot - since <= 6, "{told} position {position}");
                astray[position] = true;
                continue;
            }
            differs_since[position] = None;
            let (held, expected) = (bits.out_word(position), words.out_word(position, now));
            astray[position] &= held != expected;
            if !astray[position] {
                assert_eq!(held, expected, "{told} position {position}");
                let [bit, word] = [bits.taken(position), words.taken(position, now)].map(|taken| taken.word);
                assert_eq!(bit, word, "{told} position {position}");
            } else {
                assert!(is_noisy, "{told} position {position}");
                seen.astray += 1;
            }
            assert_eq!(lamps.ba, words.bus_active(position, now), "{told} position {position}");
        }
    }
    seen.searches += bits.master().counts().searches - 1;
}

#[test]
fn both_levels_move_the_same_words_through_any_ring_with_any_faults() {
    let mut seen = Seen::default();
    for seed in 0..60 {
        compare(seed, &mut seen);
    }
    assert!(seen.astray < 2_000, "{seen:?}");
    assert!(seen.good > 5_000 && seen.bad > 500 && seen.silent > 500 && seen.searches > 20, "{seen:?}");
}
