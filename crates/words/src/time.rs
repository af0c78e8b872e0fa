//! Points and spans of time in whole nanoseconds.
//!
//! An SSI half period is 455 ns and a cycle at 2 Mbit/s 265.75 us, so nothing coarser would be exact. Arithmetic
//! saturates: a peer that names a far future cannot make a machine overflow.

use core::fmt;
use core::ops::Add;

/// A point in time, in nanoseconds since an origin that whoever tells the time has chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instant(pub u64);

/// A span of time in nanoseconds, up to 584 years.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Duration(pub u64);

impl Instant {
    /// The origin.
    pub const ZERO: Self = Self(0);

    /// Nanoseconds since the origin.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// The span since `earlier`; zero if that lies in the future.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }
}

impl Duration {
    /// No time at all.
    pub const ZERO: Self = Self(0);

    /// A span of whole nanoseconds.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// A span of whole microseconds.
    #[must_use]
    pub const fn from_micros(micros: u64) -> Self {
        Self(micros.saturating_mul(1_000))
    }

    /// A span of whole milliseconds.
    #[must_use]
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis.saturating_mul(1_000_000))
    }

    /// A span of whole seconds.
    #[must_use]
    pub const fn from_secs(secs: u64) -> Self {
        Self(secs.saturating_mul(1_000_000_000))
    }

    /// The span in nanoseconds.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }
}

impl Add<Duration> for Instant {
    type Output = Self;

    fn add(self, span: Duration) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl Add for Duration {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ns = self.0;
        let (unit, name) = match ns {
            n if n >= 1_000_000_000 => (1_000_000_000, "s"),
            n if n >= 1_000_000 => (1_000_000, "ms"),
            n if n >= 1_000 => (1_000, "us"),
            _ => return write!(f, "{ns} ns"),
        };
        let (whole, mut rest) = (ns / unit, ns % unit);
        if rest == 0 {
            return write!(f, "{whole} {name}");
        }
        let mut digits = match unit {
            1_000_000_000 => 9,
            1_000_000 => 6,
            _ => 3,
        };
        while rest % 10 == 0 {
            rest /= 10;
            digits -= 1;
        }
        write!(f, "{whole}.{rest:0digits$} {name}")
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_span_is_written_in_its_largest_unit_without_trailing_zeros() {
        assert_eq!(Duration::from_nanos(455).to_string(), "455 ns");
        assert_eq!(Duration::from_nanos(265_750).to_string(), "265.75 us");
        assert_eq!(Duration::from_micros(14_052).to_string(), "14.052 ms");
        assert_eq!(Duration::from_millis(20).to_string(), "20 ms");
        assert_eq!(Duration::from_millis(1_500).to_string(), "1.5 s");
    }

    #[test]
    fn far_futures_saturate_instead_of_overflowing() {
        assert_eq!(Instant(u64::MAX) + Duration::from_secs(1), Instant(u64::MAX));
        assert_eq!(Instant(1).since(Instant(2)), Duration::ZERO);
        assert_eq!(Duration::from_secs(u64::MAX), Duration(u64::MAX));
        assert_eq!(Duration(u64::MAX) + Duration(1), Duration(u64::MAX));
    }

    #[test]
    fn points_and_spans_add_up() {
        assert_eq!(Duration::from_micros(2) + Duration::from_nanos(3), Duration(2_003));
        assert_eq!((Instant(5) + Duration(2)).as_nanos(), 7);
        assert_eq!(Instant(7).since(Instant(5)).as_nanos(), 2);
    }
}
