//! One exchange of the device beside the bare scaling formula with its two divisions.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::hint::black_box;

use divan::{Bencher, counter::ItemsCount};
use encoring_encoder::{Encoder, ServiceTimes, Terminals, Unit};
use encoring_sim::Node;
use encoring_words::model::Sensor;
use encoring_words::{Duration, Instant, Model, OutWord};

fn main() {
    divan::main();
}

const CALLS: u64 = 10_000;

/// What the position costs at least: `floor(((E * D + offset) mod (Q * N)) * (S + 1) / (Q * N))`.
#[divan::bench]
fn bare_formula(bencher: Bencher) {
    let (d, offset, phases, values) = black_box((1_i64, 12_345_i64, 40_960_i64, 10_000_u64));
    bencher.counter(ItemsCount::new(CALLS)).bench(|| {
        let mut sum = 0_u64;
        for e in 0..CALLS as i64 {
            let phase = (black_box(e * 37) * d + offset).rem_euclid(phases) as u64;
            sum = sum.wrapping_add(black_box(phase * values / phases as u64));
        }
        sum
    });
}

fn exchanges(bencher: Bencher, model: Model, sensor: Sensor, step: Duration, raw: impl Fn(u64) -> i64) {
    let mut unit = Unit::new(model, sensor).unwrap();
    unit.service_times = ServiceTimes::ZERO;
    let mut memory = Node::new(unit).memory().clone();
    let terminals = Terminals { raw: 5, ..Terminals::default() };
    let mut encoder = Encoder::power_up(&unit, Instant::ZERO, &terminals, &mut memory);
    // The worked example: 10 turns of 1000 steps.
    for word in [0xC200_270F, 0, 0xC300_000A, 0, 0x8800_0000, 0] {
        encoder.exchange(Instant::ZERO, OutWord(word), &terminals, &mut memory);
    }
    let mut now = Instant::ZERO;
    bencher.counter(ItemsCount::new(CALLS)).bench_local(|| {
        let mut sum = 0_u32;
        for call in 0..CALLS {
            now = now + step;
            let terminals = Terminals { raw: black_box(raw(call)), ..Terminals::default() };
            sum ^= encoder.exchange(now, black_box(OutWord(0)), &terminals, &mut memory).0;
        }
        sum
    });
}

const SHAFT: Sensor = Sensor::Rotary { steps_per_turn: 4096 };

#[divan::bench]
fn ce_65_m_new_sample(bencher: Bencher) {
    exchanges(bencher, Model::Ce65M, SHAFT, Duration::from_micros(500), |call| call as i64 * 37);
}

#[divan::bench]
fn ce_65_m_same_sample(bencher: Bencher) {
    exchanges(bencher, Model::Ce65M, SHAFT, Duration::ZERO, |_| 5);
}

#[divan::bench]
fn ce_100_m_new_sample(bencher: Bencher) {
    exchanges(bencher, Model::Ce100M, SHAFT, Duration::from_micros(1_000), |call| call as i64 * 37);
}

#[divan::bench]
fn la_66_new_sample(bencher: Bencher) {
    let rod = Sensor::Linear { rod_um: 500_000 };
    exchanges(bencher, Model::La66, rod, Duration::from_micros(1_000), |call| call as i64 * 37);
}
