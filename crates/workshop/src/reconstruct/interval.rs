//! Exact numbers between two bounds, and the simplest of them.

/// A fraction of whole numbers above 0. As a bound it may be (1, 0), which nothing reaches, so it is no
/// `host::scaling::Ratio`: that is a number that people type, with a denominator and at most 24 digits.
pub type ExactNumber = (u128, u128);

/// The numbers between two bounds, neither of them included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    pub(super) low: ExactNumber,
    pub(super) high: ExactNumber,
}

/// `a < b`, exact as long as both products stay below 2^128.
pub(super) const fn less(a: ExactNumber, b: ExactNumber) -> bool {
    a.0.saturating_mul(b.1) < b.0.saturating_mul(a.1)
}

const fn gcd(a: u128, b: u128) -> u128 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// In lowest terms.
pub(super) const fn reduced((numerator, denominator): ExactNumber) -> ExactNumber {
    match gcd(numerator, denominator) {
        0 => (numerator, denominator),
        common => (numerator / common, denominator / common),
    }
}

impl Interval {
    /// Everything above 0.
    pub(super) const ALL: Self = Self { low: (0, 1), high: (1, 0) };

    /// Everything above 0 up to a bound.
    pub(super) const fn up_to(high: ExactNumber) -> Self {
        Self { low: (0, 1), high }
    }

    /// What is in both.
    pub(super) const fn and(self, other: Self) -> Self {
        let low = if less(self.low, other.low) { other.low } else { self.low };
        let high = if less(other.high, self.high) { other.high } else { self.high };
        Self { low, high }
    }

    /// Whether nothing is in it.
    pub(super) const fn is_empty(self) -> bool {
        !less(self.low, self.high)
    }

    /// Whether a number is in it.
    pub(super) const fn contains(self, number: ExactNumber) -> bool {
        less(self.low, number) && less(number, self.high)
    }

    /// Every number of it multiplied by a fraction.
    pub(super) const fn times(self, factor: ExactNumber) -> Self {
        Self { low: product(self.low, factor), high: product(self.high, factor) }
    }

    /// The whole numbers in it: the first, and how many there are.
    pub(super) const fn whole(self) -> (u128, u128) {
        let first = self.low.0 / self.low.1 + 1;
        if self.high.1 == 0 {
            return (first, u128::MAX - first);
        }
        // The largest below the upper bound.
        let last = self.high.0.div_ceil(self.high.1).saturating_sub(1);
        (first, (last + 1).saturating_sub(first))
    }

    /// 1000 divided by each number; `None` if one of the bounds has no reciprocal.
    pub(super) const fn thousandth_upside_down(self) -> Option<Self> {
        if self.low.0 == 0 || self.high.1 == 0 {
            return None;
        }
        Some(Self {
            low: product((1_000, 1), (self.high.1, self.high.0)),
            high: product((1_000, 1), (self.low.1, self.low.0)),
        })
    }

    /// The roundest number in it, as people choose resolutions: a multiple of the largest of 1, 2 and 5 times a power of
    /// ten, down to thousandths; of several multiples the middle one. With it how round it is, in thousandths.
    pub(super) fn roundest(self) -> Option<(ExactNumber, u128)> {
        let thousandths = self.times((1_000, 1));
        let powers = (0..=12).rev().map(|power| 10_u128.pow(power));
        powers.flat_map(|power| [5 * power, 2 * power, power]).find_map(|unit| {
            let (first, count) = thousandths.times((1, unit)).whole();
            let factor = (count > 0).then(|| first + (count - 1) / 2)?;
            Some((reduced((factor * unit, 1_000)), unit))
        })
    }

    /// The number in it with the smallest denominator.
    pub(super) fn simplest(self) -> ExactNumber {
        let (mut low, mut high) = (self.low, self.high);
        // The whole parts of a continued fraction that both bounds have in common.
        let mut parts = Vec::new();
        loop {
            let whole = low.0 / low.1;
            if less((whole + 1, 1), high) {
                return assembled(&parts, (whole + 1, 1));
            }
            parts.push(whole);
            let (rest_low, rest_high) = (low.0 - whole * low.1, high.0 - whole * high.1);
            // Upside down the bounds change places; a lower bound that is whole has no upper one then.
            (low, high) = ((high.1, rest_high), if rest_low == 0 { (1, 0) } else { (low.1, rest_low) });
        }
    }
}

/// `x` behind the whole parts of a continued fraction.
fn assembled(parts: &[u128], x: ExactNumber) -> ExactNumber {
    parts.iter().rev().fold(x, |(numerator, denominator), part| (part * numerator + denominator, numerator))
}

/// A product in lowest terms.
pub(super) const fn product(a: ExactNumber, b: ExactNumber) -> ExactNumber {
    let (a, b) = (reduced((a.0, b.1)), reduced((b.0, a.1)));
    (a.0.saturating_mul(b.0), a.1.saturating_mul(b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_simplest_and_the_roundest_number_lie_within() {
        let simplest = |low, high| Interval { low, high }.simplest();
        assert_eq!(simplest((3, 1), (7, 2)), (10, 3));
        assert_eq!(simplest((3, 1), (4, 1)), (7, 2));
        assert_eq!(simplest((31_414, 10_000), (31_416, 10_000)), (311, 99));
        assert_eq!(simplest((0, 1), (1, 1_000)), (1, 1_001));
        for denominator in 1..60_u128 {
            for numerator in 1..200 {
                let exact = (numerator * 1_000, denominator * 1_000);
                let bounds = Interval { low: (exact.0 - 1, exact.1), high: (exact.0 + 1, exact.1) };
                let found = bounds.simplest();
                assert!(
                    bounds.contains(found) && found.1 <= denominator,
                    "{numerator}/{denominator}: {found:?}"
                );
            }
        }
        let roundest = |low, high| Interval { low, high }.roundest();
        assert_eq!(roundest((978, 1), (1_023, 1)), Some(((1_000, 1), 1_000_000)));
        assert_eq!(roundest((195, 1), (204, 1)), Some(((200, 1), 200_000)));
        assert_eq!(roundest((1_247, 1_000), (1_252, 1_000)), Some(((5, 4), 50)));
        assert_eq!(roundest((12_345, 10_000_000), (12_346, 10_000_000)), None);
    }
}
