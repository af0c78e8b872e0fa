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
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Written};
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

/// A cycle that the referee of an encoder sees, 500 us after the one before.
fn cycle(number: u64, out: u32, input: u32) -> Observed {
    Observed::Cycle {
        at: Instant(number * 500_000),
        out: OutWord(out),
        input: Some(InWord(input)),
        line: LineSeen::Good,
    }
}

fn refereed(mut referee: Referee, input: fn(u64) -> u32) -> Referee {
    for call in 0..CALLS {
        referee.observe(black_box(cycle(call, 0, input(call))));
    }
    black_box(referee)
}

fn referee() -> Referee {
    Referee::new(Vantage::Writes, Some(Model::Ce65M))
}

// Beside `new_sample`, whose exchange it looks at.
#[library_benchmark(config = limit(113_727))]
#[bench::ce_65_m(setup = referee)]
fn referee_idle(referee: Referee) -> Referee {
    refereed(referee, |call| (call as u32 * 37) & 0xFF_FFFF)
}

// The shaft stands still.
#[library_benchmark(config = limit(79_764))]
#[bench::ce_65_m(setup = referee)]
fn referee_still(referee: Referee) -> Referee {
    refereed(referee, |_| 100)
}

/// What a whole service is: three writes and eight cycles.
fn service(first: u64) -> [Observed; 11] {
    let (rest, request, reply) = (0x0200_0000, 0x8200_0000, 0x8200_270F);
    let write = |number: u64, word| Observed::Write {
        at: Instant(number * 500_000),
        client: 1,
        written: Written::Both(OutWord(word)),
    };
    [
        write(first, rest),
        cycle(first + 1, rest, 100),
        cycle(first + 2, rest, 100),
        write(first + 2, request),
        cycle(first + 3, request, 100),
        cycle(first + 4, request, reply),
        cycle(first + 5, request, reply),
        write(first + 5, rest),
        cycle(first + 6, rest, reply),
        cycle(first + 7, rest, 100),
        cycle(first + 8, rest, 100),
    ]
}

// A thousand whole services.
#[library_benchmark(config = limit(1_732_860))]
#[bench::ce_65_m(setup = referee)]
fn referee_services(mut referee: Referee) -> Referee {
    for call in 0..CALLS {
        for seen in service(call * 8) {
            referee.observe(black_box(seen));
        }
    }
    black_box(referee)
}

library_benchmark_group!(
    name = exchange,
    benchmarks = [new_sample, same_sample, read_services, referee_idle, referee_still, referee_services]
);

main!(library_benchmark_groups = exchange);
