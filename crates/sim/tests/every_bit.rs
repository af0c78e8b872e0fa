//! Worlds twice: once with sound slots taken as a whole, once with every bit run. After every slot nothing differs: not
//! the chips and the master in all that they hold, no word, time, lamp, register, place or exchange.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Ring, device, scenario, set};
use encoring_ring::Verdict;
use encoring_sim::{Fault, Occurrence, Scenario};
use encoring_words::{Duration, Instant};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const MS: u64 = 1_000_000;

/// A ring with everything that can happen to it within so many milliseconds.
fn any_scenario(chance: &mut Pcg64Mcg, lasting_ms: u64) -> Scenario {
    // Evenly on a logarithm.
    let octave = 1_usize << chance.random_range(0..6_u32);
    let encoders = chance.random_range(octave..2 * octave);
    let mut text = String::from("version = 1\n[ring]\n");
    text += ["kbit_s = 500\n", "kbit_s = 2000\nsoftware_us = 0\n"][chance.random_range(0..2_usize)];
    text += ["", "", "faulty_per_million = 3000\n"][chance.random_range(0..3_usize)];
    for position in 0..encoders {
        let model = ["la-66", "ce-100-m", "ce-65-m"][chance.random_range(0..3_usize)];
        let per_s = chance.random_range(-100_000..100_000_i64);
        let motion = format!("motion = {{ kind = \"speed\", start = 1000, per_s = {per_s} }}");
        text += &device(position, model, &motion);
    }
    for _ in 0..chance.random_range(0..4) {
        let what = ["preset1_v = 24.0", "raw = 77", "supply_v = 28.5", "supply_v = 24.0"];
        let position = chance.random_range(0..encoders);
        if !text.contains("ce-65-m") {
            let at = chance.random_range(0..lasting_ms) as f64;
            text += &set(at, position, what[chance.random_range(0..4_usize)]);
        }
    }
    let mut scenario = scenario(&text);
    scenario.seed = chance.random();
    let kinds: Vec<Fault> = Fault::kinds().map(|(fault, ..)| fault).collect();
    for _ in 0..chance.random_range(0..6) {
        let fault = match kinds[chance.random_range(0..kinds.len())] {
            Fault::Ident(_) => "ident=0303".parse().unwrap(),
            fault => {
                let rate = [1, 30, 1_000, 50_000][chance.random_range(0..4_usize)];
                let name = fault.to_string();
                let name = name.split('=').next().unwrap();
                format!("{name}={rate}").parse().unwrap_or(fault)
            }
        };
        let places = if fault.is_of_line() { encoders + 1 } else { encoders };
        let occurrence = Occurrence {
            fault,
            place: chance.random_range(0..places),
            at: Instant(chance.random_range(0..lasting_ms * MS)),
            lasting: Duration(chance.random_range(1..40 * MS)),
        };
        // Two of one line at a time are refused.
        let _ = scenario.add(&occurrence);
    }
    scenario
}

#[derive(Debug, Default)]
struct Seen {
    good: u32,
    others: u32,
    searches: u64,
}

fn compare(seed: u64, seen: &mut Seen) {
    let mut chance = Pcg64Mcg::seed_from_u64(seed);
    let scenario = any_scenario(&mut chance, 150);
    let mut whole = Ring::of(&scenario);
    let mut bits = Ring::of(&scenario);
    bits.world.run_every_bit();
    while whole.world.now() < Instant(200 * MS) {
        for out in &mut whole.out {
            if chance.random_range(0..4) == 0 {
                *out = chance.random();
            }
        }
        bits.out.clone_from(&whole.out);
        let told = || format!("seed {seed} at {} ns", whole.world.now().as_nanos());
        let told = told();
        let cycled = whole.cycle();
        assert_eq!(cycled, bits.cycle(), "{told}");
        assert_eq!(whole.input, bits.input, "{told}");
        assert!(whole.world.ring() == bits.world.ring(), "{told}");
        for position in 0..whole.out.len() {
            assert_eq!(whole.world.lamps(position), bits.world.lamps(position), "{told}");
        }
        match cycled.verdict {
            Verdict::Good => seen.good += 1,
            _ => seen.others += 1,
        }
    }
    assert!(whole.rows == bits.rows, "seed {seed}");
    seen.searches += whole.world.ring().master().counts().searches - 1;
}

#[test]
fn a_world_is_the_same_whether_its_bits_are_run_or_not() {
    let mut seen = Seen::default();
    for seed in 0..60 {
        compare(seed, &mut seen);
    }
    assert!(seen.good > 10_000 && seen.others > 2_000 && seen.searches > 20, "{seen:?}");
}
