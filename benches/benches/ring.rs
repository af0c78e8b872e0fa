//! A virtual second of the ring at bit level, with faults compiled in, beside the second that the wire takes.
//!
//! Not a benchmark of divan: what counts is the ratio to the wire.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use encoring_ring::ident::ENCODER;
use encoring_ring::profile::BIT_500K;
use encoring_ring::{BitRing, CycleTime, Slave, Sound};
use encoring_sim::fault::Segments;
use encoring_words::{InWord, Instant, OutWord};

const VIRTUAL_SECONDS: u64 = 5;
const ROUNDS: usize = 7;

fn main() {
    println!("encoders   cycles/s on the wire   times real time (best of {ROUNDS} rounds)");
    for encoders in [1, 3, 16, 128] {
        let best = (0..ROUNDS).map(|_| ratio(encoders)).fold(0.0, f64::max);
        let cycle = CycleTime::default().of_encoders(encoders as u32);
        println!("{encoders:>8} {:>22} {best:>17.0}", 1_000_000_000 / cycle.as_nanos());
    }
}

/// How many times faster than the wire. The best of some rounds is the one that was disturbed least.
fn ratio(encoders: usize) -> f64 {
    let slaves: Vec<Slave> = (0..encoders).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
    let mut ring = BitRing::new(slaves, BIT_500K);
    ring.bring_up(&mut Sound, 10_000).unwrap();
    ring.begin_time();
    let mut segments = Segments::new(encoders, 1);
    let cycle = CycleTime::default().of_encoders(encoders as u32).as_nanos();
    let (out, answers) = (vec![OutWord(0x8200_0000); encoders], vec![Some(InWord(0x1234)); encoders]);
    let mut input = vec![InWord(0); encoders];
    let seconds = if encoders == 128 { 1 } else { VIRTUAL_SECONDS };
    let cycles = seconds * 1_000_000_000 / cycle;
    #[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
    let started = std::time::Instant::now();
    for slot in 1..=cycles {
        ring.cycle(Instant(slot * cycle), &out, &mut input, &answers, &mut segments);
    }
    let took = started.elapsed().as_secs_f64();
    assert_eq!(ring.master().counts().faulty, 0);
    assert_eq!(ring.master().counts().cycles, cycles);
    seconds as f64 / took
}
