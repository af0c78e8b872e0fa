//! A virtual second of rings of 1, 10 and 128 encoders, and a cycle as a station runs it, with the process image
//! locked. Neither allocates: divan prints a column for allocations only where there are some.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::path::Path;

use divan::{AllocProfiler, Bencher};
use encoring_benches::scenario;
use encoring_bus::SharedImage;
use encoring_ring::ProcessImage;
use encoring_sim::{Scenario, World};
use encoring_words::{InWord, OutWord};

#[global_allocator]
static ALLOCATIONS: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

fn ring(encoders: usize) -> World {
    World::new(&Scenario::parse("bench", &scenario(encoders), Path::new("")).unwrap()).unwrap()
}

#[divan::bench(args = [1, 10, 128], sample_count = 20)]
fn virtual_second(bencher: Bencher, encoders: usize) {
    let mut world = ring(encoders);
    let out = vec![OutWord(0); encoders];
    let mut input = vec![InWord(0); encoders];
    let cycles = 1_000_000_000 / world.cycle_time().as_nanos();
    bencher.bench_local(|| {
        for _ in 0..cycles {
            world.cycle(&out, &mut input);
        }
    });
}

#[divan::bench(args = [1, 10, 50, 128], sample_size = 100)]
fn station_cycle(bencher: Bencher, encoders: usize) {
    let mut world = ring(encoders);
    let image = SharedImage::new(ProcessImage::new(encoders).unwrap());
    bencher.bench_local(|| {
        image.with(|image| {
            let (out, input) = image.both();
            world.cycle(out, input)
        })
    });
}
