//! What a running station allocates for a cycle, all of its threads together: nothing.
//!
//! A station that runs ten times as long as another, with a client that reads its image, allocates as often as the
//! other, for its start and its end. Exits with 1 if a cycle allocates at full speed, where none is dropped: in real
//! time a busy machine may add the event that tells of dropped cycles.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::alloc::System;
use std::path::Path;
use std::process::ExitCode;
use std::thread;

use encoring_sim::{Scenario, World};
use encoring_station::{Options, Speed, Station};
use encoring_words::Duration;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATIONS: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const SHORT: Duration = Duration::from_millis(300);
const LONG: Duration = Duration::from_millis(3_000);

/// Cycles and allocations of a station from before its start until after its end.
fn run(scenario: &Scenario, speed: Speed, lasting: Duration) -> (u64, usize) {
    let region = Region::new(ALLOCATIONS);
    let world = World::new(scenario).unwrap();
    let station =
        Station::start(world, Options { speed, until: Some(lasting), ..Options::default() }).unwrap();
    let image = station.handle().image();
    let mut sum = 0;
    while !station.is_finished() {
        sum ^= image.with(|image| image.input().iter().fold(0, |sum, word| sum ^ word.0));
        thread::yield_now();
    }
    std::hint::black_box(sum);
    let outcome = station.stop().unwrap();
    let counters = outcome.view.counters;
    drop(outcome);
    let change = region.change();
    (counters.cycles, change.allocations + change.reallocations)
}

fn main() -> ExitCode {
    let mut clean = true;
    println!("| encoders | speed | cycles | allocations | cycles | allocations | a cycle |");
    println!("|--:|---|--:|--:|--:|--:|--:|");
    for encoders in [1, 50, 128] {
        let scenario =
            Scenario::parse("bench", &encoring_benches::scenario(encoders), Path::new("")).unwrap();
        for (name, speed) in [("real", Speed::REAL), ("max", Speed::Max)] {
            let (short_cycles, short) = run(&scenario, speed, SHORT);
            let (long_cycles, long) = run(&scenario, speed, LONG);
            let each = (long as f64 - short as f64) / (long_cycles - short_cycles) as f64;
            clean &= speed == Speed::REAL || each <= 0.0;
            println!(
                "| {encoders} | {name} | {short_cycles} | {short} | {long_cycles} | {long} | {each:.4} |"
            );
        }
    }
    if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
