//! How many bits go by between two hits, if each is hit with the same chance.
//!
//! One draw gives the whole gap, in integers, so that every machine has the same. The draw is a likelihood, and the gap
//! the most bits that go by unhit with at least that: a number below q^k, of 2^64, stands for k bits or more. It is
//! built from its highest binary digit down, with the powers q, q^2, q^4 and so on.

use rand::RngExt;

/// From 0 to this is every bit.
pub const PER_MILLION: u32 = 1_000_000;

/// The gaps of one chance.
#[derive(Clone, Debug)]
pub(crate) struct Gaps {
    /// The likelihood, of 2^64, that 2^k bits in a row are not hit, as long as it is more than nothing.
    powers: Vec<u64>,
}

impl Gaps {
    /// Of a million bits so many are hit, at least 1.
    pub(crate) fn new(per_million: u32) -> Self {
        let others = u128::from(PER_MILLION.saturating_sub(per_million.max(1)));
        let first = ((others << 64) / u128::from(PER_MILLION)) as u64;
        let squares = |power: &u64| Some(((u128::from(*power) * u128::from(*power)) >> 64) as u64);
        let powers = std::iter::successors(Some(first), squares).take_while(|power| *power > 0).collect();
        Self { powers }
    }

    /// Bits before the next hit.
    pub(crate) fn draw(&self, chance: &mut impl RngExt) -> u64 {
        self.at(chance.random())
    }

    fn at(&self, draw: u64) -> u64 {
        let mut likelihood = 1_u128 << 64;
        let mut gap = 0;
        for (digit, power) in self.powers.iter().enumerate().rev() {
            let longer = (likelihood * u128::from(*power)) >> 64;
            if longer > u128::from(draw) {
                likelihood = longer;
                gap |= 1 << digit;
            }
        }
        gap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_as_likely_as_so_many_bits_without_a_hit() {
        for per_million in [1, 20, 1_000, 100_000, 500_000, 900_000] {
            let gaps = Gaps::new(per_million);
            let q = 1.0 - f64::from(per_million) / 1e6;
            for bits in [1, 2, 3, 10, 63, 64, 65, 1_000, 123_456] {
                let likelihood = q.powi(bits) * 2.0_f64.powi(64);
                if likelihood < 1e9 {
                    break;
                }
                let (more, less) = ((likelihood * (1.0 - 1e-6)) as u64, (likelihood * (1.0 + 1e-6)) as u64);
                assert!(gaps.at(more) >= bits as u64, "{per_million} {bits}");
                assert!(gaps.at(less) < bits as u64, "{per_million} {bits}");
            }
        }
    }

    #[test]
    fn where_every_bit_is_hit_there_is_no_gap() {
        let gaps = Gaps::new(PER_MILLION);
        assert_eq!([0, 1, u64::MAX].map(|draw| gaps.at(draw)), [0; 3]);
    }

    #[test]
    fn no_gap_is_without_end() {
        assert_eq!(Gaps::new(1).at(u64::MAX), 0);
        let longest = Gaps::new(1).at(0);
        assert!((40_000_000..70_000_000).contains(&longest), "{longest}");
    }
}
