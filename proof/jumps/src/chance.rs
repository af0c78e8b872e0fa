//! Chance from a seed.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Draws, the same for the same seed.
pub(crate) struct Chance(Pcg64Mcg);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// From 0 to below 1.
    pub(crate) fn part(&mut self) -> f64 {
        self.0.random::<f64>()
    }

    /// True in so many of a hundred.
    pub(crate) fn percent(&mut self, percent: u32) -> bool {
        self.0.random_range(0..100) < percent
    }

    pub(crate) fn between(&mut self, least: i64, most: i64) -> i64 {
        self.0.random_range(least..=most.max(least))
    }

    pub(crate) fn real(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.part()
    }

    /// Small ones as often as large ones. Both above 0.
    pub(crate) fn scaled(&mut self, least: f64, most: f64) -> f64 {
        // Powers of two and a part between them need no logarithm, which machines round differently.
        let mut doublings = 0;
        while least * f64::from(1_u32 << (doublings + 1).min(31)) <= most && doublings < 30 {
            doublings += 1;
        }
        let power = f64::from(1_u32 << self.between(0, doublings).clamp(0, 31));
        (least * power * (1.0 + self.part())).min(most)
    }

    pub(crate) fn of<T: Copy>(&mut self, all: &[T], otherwise: T) -> T {
        let at = self.between(0, all.len() as i64 - 1);
        all.get(at.unsigned_abs() as usize).copied().unwrap_or(otherwise)
    }
}
