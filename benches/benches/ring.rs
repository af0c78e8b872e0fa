//! A virtual second of the ring, beside the second that the wire takes: sound slots as a whole, the same with every bit
//! of them run, and a world whose encoders move; faults are compiled in, none is set.
//!
//! Not a benchmark of divan: what counts is the ratio to the wire.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::path::Path;

use encoring_benches::scenario;
use encoring_ring::ident::ENCODER;
use encoring_ring::profile::BIT_500K;
use encoring_ring::{BitRing, CycleTime, EveryBit, Slave, Sound};
use encoring_sim::injector::Segments;
use encoring_sim::{Scenario, World};
use encoring_words::{InWord, Instant, OutWord};

const ROUNDS: usize = 7;

/// About so many devices are cycled in a round.
const DEVICE_CYCLES: [u64; 2] = [30_000_000, 400_000];

fn main() {
    println!("times real time, best of {ROUNDS} rounds");
    println!("encoders   cycles/s on the wire   sound slots   every bit   world");
    for encoders in [1, 3, 16, 128] {
        let cycle = CycleTime::default().of_encoders(encoders as u32).as_nanos();
        let mut best = [0.0_f64; 3];
        for _ in 0..ROUNDS {
            let ratios = [whole(encoders, cycle), every_bit(encoders, cycle), world(encoders)];
            for (best, ratio) in best.iter_mut().zip(ratios) {
                *best = best.max(ratio);
            }
        }
        let [whole, bits, world] = best;
        let wire = 1_000_000_000 / cycle;
        println!("{encoders:>8} {wire:>22} {whole:>13.0} {bits:>11.0} {world:>7.0}");
    }
}

fn world(encoders: usize) -> f64 {
    let text = scenario(encoders);
    let mut world = World::new(&Scenario::parse("bench", &text, Path::new("")).unwrap()).unwrap();
    let mut words = Words::of(encoders);
    let cycles = DEVICE_CYCLES[1] / encoders as u64;
    let cycle = world.cycle_time().as_nanos();
    ratio(cycles, cycle, |_| {
        world.cycle(&words.out, &mut words.input);
    })
}

/// How many times faster than the wire.
fn ratio(cycles: u64, cycle: u64, mut run: impl FnMut(Instant)) -> f64 {
    #[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
    let started = std::time::Instant::now();
    for slot in 1..=cycles {
        run(Instant(slot * cycle));
    }
    (cycles * cycle) as f64 / 1e9 / started.elapsed().as_secs_f64()
}

struct Words {
    out: Vec<OutWord>,
    answers: Vec<Option<InWord>>,
    input: Vec<InWord>,
}

impl Words {
    fn of(encoders: usize) -> Self {
        Self {
            out: vec![OutWord(0x8200_0000); encoders],
            answers: vec![Some(InWord(0x1234)); encoders],
            input: vec![InWord(0); encoders],
        }
    }

    /// What changes from cycle to cycle.
    fn turn(&mut self, now: Instant) {
        let word = now.0 as u32;
        self.out.fill(OutWord(word));
        self.answers.fill(Some(InWord(word)));
    }
}

fn ring(encoders: usize) -> BitRing<Vec<Slave>> {
    let slaves: Vec<Slave> = (0..encoders).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
    let mut ring = BitRing::new(slaves, BIT_500K);
    ring.bring_up(&mut Sound, 10_000).unwrap();
    ring.begin_time();
    ring
}

fn whole(encoders: usize, cycle: u64) -> f64 {
    let (mut ring, mut words) = (ring(encoders), Words::of(encoders));
    let mut segments = Segments::new(encoders, 1);
    let cycles = DEVICE_CYCLES[0] / encoders as u64;
    let ratio = ratio(cycles, cycle, |now| {
        words.turn(now);
        ring.cycle(now, &words.out, &mut words.input, &words.answers, &mut segments);
    });
    assert_eq!((ring.master().counts().cycles, ring.master().counts().faulty), (cycles, 0));
    ratio
}

fn every_bit(encoders: usize, cycle: u64) -> f64 {
    let (mut ring, mut words) = (ring(encoders), Words::of(encoders));
    let mut segments = Segments::new(encoders, 1);
    let cycles = DEVICE_CYCLES[1] / encoders as u64;
    let ratio = ratio(cycles, cycle, |now| {
        words.turn(now);
        ring.cycle(now, &words.out, &mut words.input, &words.answers, &mut EveryBit(&mut segments));
    });
    assert_eq!((ring.master().counts().cycles, ring.master().counts().faulty), (cycles, 0));
    ratio
}
