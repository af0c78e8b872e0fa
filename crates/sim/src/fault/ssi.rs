//! The faults of the line between an encoder's SSI and its reader.

/// What an SSI can suffer. Chances are per million clock pulses, times in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SsiTrouble {
    /// Clock pulses do not reach the encoder.
    Lost(u32),
    /// The encoder sees a further pulse behind one.
    Added(u32),
    /// The data of a pulse are turned over.
    Flips(u32),
    /// The data come so much later than the clock says.
    Skew(u32),
    /// The cable delays so much each way, so the data come twice as late.
    Delay(u32),
    /// Data+ stands at Low.
    Low,
    /// Data+ stands at High.
    High,
}

impl SsiTrouble {
    /// What it is called, and what it is.
    pub(super) const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Lost(_) => ("ssi_lost", "N of a million SSI clock pulses do not reach the encoder"),
            Self::Added(_) => ("ssi_added", "N of a million SSI clock pulses are doubled"),
            Self::Flips(_) => ("ssi_flips", "N of a million SSI bits are inverted"),
            Self::Skew(_) => ("ssi_skew", "the SSI data come N ns later than the clock"),
            Self::Delay(_) => ("ssi_delay", "the SSI cable delays by N ns each way"),
            Self::Low => ("ssi_low", "the SSI data stay Low"),
            Self::High => ("ssi_high", "the SSI data stay High"),
        }
    }

    /// How late the data reach the reader.
    pub(crate) const fn data_delay_ns(self) -> u64 {
        match self {
            Self::Skew(ns) => ns as u64,
            Self::Delay(ns) => 2 * ns as u64,
            Self::Lost(_) | Self::Added(_) | Self::Flips(_) | Self::Low | Self::High => 0,
        }
    }
}
