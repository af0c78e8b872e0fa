//! Instructions of a thousand exchanges under valgrind: a guard against silent slow-downs.
//!
//! The limits are what was counted on x86-64 with Rust 1.95, and a fifth more for other compilers. Whoever exceeds one
//! finds out why, and raises it with the reason in the commit, or not at all.
#![allow(missing_docs, unused_qualifications, clippy::unwrap_used, reason = "a benchmark, and its macros")]

use std::hint::black_box;

use encoring_encoder::{Encoder, ServiceTimes, Terminals, Unit};
use encoring_host::referee::{LineSeen, Observed, Referee, Vantage};
use encoring_sim::{Eeprom, Node};
use encoring_words::model::Sensor;
use encoring_words::{Duration, InWord, Instant, Model, OutWord};
use gungraun::prelude::*;
use gungraun::{Callgrind, EventKind};

const CALLS: u64 = 1_000;

fn device() -> (Encoder, Eeprom) {
    let mut unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }).unwrap();
    unit.service_times = ServiceTimes::ZERO;
    let mut memory = Node::new(unit).memory().clone();
    let encoder = Encoder::power_up(&unit, Instant::ZERO, &Terminals::default(), &mut memory);
    (encoder, memory)
}

/// `step` apart, the shaft turning by 37 steps each.
fn exchanges((mut encoder, mut memory): (Encoder, Eeprom), step: Duration, out: fn(u64) -> u32) -> u32 {
    let (mut now, mut sum) = (Instant::ZERO, 0);
    for call in 0..CALLS {
        now = now + step;
        let terminals = Terminals { raw: black_box(call as i64 * 37), ..Terminals::default() };
        sum ^= encoder.exchange(now, black_box(OutWord(out(call))), &terminals, &mut memory).0;
    }
    black_box(sum)
}

fn limit(instructions: u64) -> LibraryBenchmarkConfig {
    LibraryBenchmarkConfig::default()
        .tool(Callgrind::default().hard_limits([(EventKind::Ir, instructions * 6 / 5)]))
        .clone()
}

#[library_benchmark(config = limit(140_148))]
#[bench::ce_65_m(setup = device)]
fn new_sample(device: (Encoder, Eeprom)) -> u32 {
    exchanges(device, Duration::from_micros(500), |_| 0)
}

#[library_benchmark(config = limit(81_190))]
#[bench::ce_65_m(setup = device)]
fn same_sample(device: (Encoder, Eeprom)) -> u32 {
    exchanges(device, Duration::ZERO, |_| 0)
}

#[library_benchmark(config = limit(331_146))]
#[bench::ce_65_m(setup = device)]
fn read_services(device: (Encoder, Eeprom)) -> u32 {
    exchanges(device, Duration::from_micros(500), |call| if call % 2 == 0 { 0 } else { 0x8200_0000 })
}

/// Cycles that the referee of an encoder sees, 500 us apart, the shaft turning.
fn refereed(mut referee: Referee, words: fn(u64) -> (u32, u32)) -> u64 {
    for cycle in 0..CALLS {
        let (out, input) = words(cycle);
        referee.observe(black_box(Observed::Cycle {
            at: Instant(cycle * 500_000),
            out: OutWord(out),
            input: Some(InWord(input)),
            line: LineSeen::Good,
        }));
    }
    black_box(referee.services())
}

fn referee() -> Referee {
    Referee::new(Vantage::Writes, Some(Model::Ce65M))
}

// Beside `new_sample`, whose exchange it looks at.
#[library_benchmark(config = limit(165_977))]
#[bench::ce_65_m(setup = referee)]
fn referee_idle(referee: Referee) -> u64 {
    refereed(referee, |cycle| (0, (cycle as u32 * 37) & 0xFF_FFFF))
}

// 125 reads of eight cycles each: number first, the bit, the reply, the fall and the end.
#[library_benchmark(config = limit(181_869))]
#[bench::ce_65_m(setup = referee)]
fn referee_services(referee: Referee) -> u64 {
    refereed(referee, |cycle| match cycle % 8 {
        0 => (0, 100),
        1 | 2 => (0x0200_0000, 100),
        3 => (0x8200_0000, 100),
        4 | 5 => (0x8200_0000, 0x8200_270F),
        6 => (0x0200_0000, 0x8200_270F),
        _ => (0x0200_0000, 100),
    })
}

library_benchmark_group!(
    name = exchange,
    benchmarks = [new_sample, same_sample, read_services, referee_idle, referee_services]
);

main!(library_benchmark_groups = exchange);
