//! Numbers that are not written in decimal alone.

use std::fmt;

/// A number of so many digits in hexadecimal; in JSON a string without `h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hex<const DIGITS: usize>(pub u32);

impl<const DIGITS: usize> fmt::Display for Hex<DIGITS> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:0DIGITS$X}", self.0)
    }
}

/// A number with one decimal place or two, not below 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// So many tenths.
    Tenths(u64),
    /// So many hundredths.
    Hundredths(u64),
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Tenths(tenths) => write!(f, "{}.{}", tenths / 10, tenths % 10),
            Self::Hundredths(parts) => write!(f, "{}.{:02}", parts / 100, parts % 100),
        }
    }
}
