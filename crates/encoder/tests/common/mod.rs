//! What the tests of the encoder share: a memory that fails on demand, a bench with one device on it, the formulas.
#![allow(
    dead_code,
    unreachable_pub,
    unused_imports,
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "tests; no file uses all of it"
)]

pub mod bench;
pub mod formula;
pub mod memory;
pub mod ssi;

pub use bench::{Bench, MS, SECOND, US, ce65, ce65_8192, ce100, every_model, la66};
pub use memory::{CellFault, Hiccup, Memory};

use proptest::test_runner::{Config, RngSeed};

/// So many cases, always the same ones unless `PROPTEST_RNG_SEED` asks for others. A failure prints its input.
pub fn cases(cases: u32) -> Config {
    let given = Config::default();
    let rng_seed = match given.rng_seed {
        RngSeed::Random => RngSeed::Fixed(51),
        fixed @ RngSeed::Fixed(_) => fixed,
    };
    Config { cases, rng_seed, failure_persistence: None, ..given }
}
