//! Decimals of three digits: microseconds of nanoseconds, volts of millivolts.

use std::fmt;

/// A number of thousandths, written as a decimal without trailing zeros.
pub(crate) struct Decimal {
    thousandths: u64,
    /// The least number of decimals.
    least: usize,
}

impl Decimal {
    pub(crate) fn volts(millivolts: u32) -> Self {
        Self { thousandths: millivolts.into(), least: 1 }
    }

    pub(crate) fn microseconds(nanoseconds: u64) -> Self {
        Self { thousandths: nanoseconds, least: 0 }
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mut rest, mut digits) = (self.thousandths % 1000, 3);
        while digits > self.least && rest % 10 == 0 {
            rest /= 10;
            digits -= 1;
        }
        write!(f, "{}", self.thousandths / 1000)?;
        if digits > 0 { write!(f, ".{rest:0digits$}") } else { Ok(()) }
    }
}
