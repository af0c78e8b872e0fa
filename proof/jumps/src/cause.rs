//! The causes, and what each of them leaves in the rows.

use std::fmt;

/// Why a position jumped. The names are those that a diagnosis gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Cause {
    ReplyAsPosition,
    TornWords,
    HalvesExchanged,
    GrayAsBinary,
    BinaryAsGray,
    Wrap,
    Preset,
    Rescaled,
    Direction,
    ZeroLost,
    Aliasing,
    OverSpeed,
    OverAcceleration,
    SingleBit,
    StuckBit,
    Noise,
    Frozen,
    OtherSource,
    Mechanical,
    /// None of these: the axis moved.
    Motion,
}

/// Every cause with its name, motion last.
pub(crate) const CAUSES: [(Cause, &str); 20] = [
    (Cause::ReplyAsPosition, "reply_as_position"),
    (Cause::TornWords, "torn_words"),
    (Cause::HalvesExchanged, "halves_exchanged"),
    (Cause::GrayAsBinary, "gray_as_binary"),
    (Cause::BinaryAsGray, "binary_as_gray"),
    (Cause::Wrap, "wrap"),
    (Cause::Preset, "preset"),
    (Cause::Rescaled, "rescaled"),
    (Cause::Direction, "direction"),
    (Cause::ZeroLost, "zero_lost"),
    (Cause::Aliasing, "aliasing"),
    (Cause::OverSpeed, "over_speed"),
    (Cause::OverAcceleration, "over_acceleration"),
    (Cause::SingleBit, "single_bit"),
    (Cause::StuckBit, "stuck_bit"),
    (Cause::Noise, "noise"),
    (Cause::Frozen, "frozen"),
    (Cause::OtherSource, "other_source"),
    (Cause::Mechanical, "mechanical"),
    (Cause::Motion, "motion"),
];

impl Cause {
    pub(crate) fn name(self) -> &'static str {
        CAUSES.iter().find(|(cause, _)| *cause == self).map_or("", |(_, name)| name)
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A jump, by what it leaves in the rows. Lengths are steps.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Trace {
    /// A reply where a position is expected; `known`: its data are 0 or a value that was given with the recording.
    Reply {
        jump: f64,
        known: bool,
    },
    /// One half of the word before, one of the word after; their high halves differ in so many bits.
    Torn {
        bits: u32,
    },
    /// So many rows with both halves exchanged while the axis moved; `foreign`: bits 31..24 become what no encoder sends.
    Exchanged {
        rows: f64,
        travelled: f64,
        foreign: bool,
    },
    /// So many rows in Gray code that are read as binary, or the reverse.
    OtherCode {
        cause: Cause,
        rows: f64,
        travelled: f64,
    },
    /// From one end of the positions to the other; seen so often in the recording.
    Wrap {
        times: u32,
    },
    /// A preset adjustment; `shown`: its reply stands in the rows; `round`: to 0 or to a value that was given.
    Preset {
        jump: f64,
        shown: bool,
        round: bool,
    },
    /// Another S, N or D: positions and speeds times `ratio`.
    Rescaled {
        jump: f64,
        ratio: f64,
        shown: bool,
    },
    Direction {
        jump: f64,
        shown: bool,
    },
    /// The turns that a shaft made without supply; `known`: the place before and after is known otherwise.
    ZeroLost {
        known: bool,
    },
    /// Rows come faster than the encoder's samples.
    Aliased,
    /// Too fast by so many steps a second, for so many rows.
    OverSpeed {
        excess: f64,
        rows: f64,
    },
    /// The speed changed by so many steps a second, with so many steps a second squared.
    OverAcceleration {
        change: f64,
        acceleration: f64,
    },
    /// A bit is wrong; `carry`: the high half changed from the row before to this one.
    Bit {
        bit: u32,
        carry: bool,
    },
    /// A bit keeps its level while it should have changed so often.
    Stuck {
        bit: u32,
        changes: u32,
    },
    /// Every row is off by up to so many steps.
    Noise {
        steps: f64,
        rows: f64,
    },
    /// The same position for so many rows, and then where the axis has gone meanwhile; `steady`: at the same speed.
    Frozen {
        rows: f64,
        steady: bool,
    },
    /// The position of another encoder: so many steps away, faster or slower by so much; `returns`: it ends.
    Other {
        jump: f64,
        faster: f64,
        stands: bool,
        returns: bool,
    },
    /// A coupling slipped.
    Slip {
        jump: f64,
    },
}

impl Trace {
    pub(crate) const fn cause(&self) -> Cause {
        match self {
            Self::Reply { .. } => Cause::ReplyAsPosition,
            Self::Torn { .. } => Cause::TornWords,
            Self::Exchanged { .. } => Cause::HalvesExchanged,
            Self::OtherCode { cause, .. } => *cause,
            Self::Wrap { .. } => Cause::Wrap,
            Self::Preset { .. } => Cause::Preset,
            Self::Rescaled { .. } => Cause::Rescaled,
            Self::Direction { .. } => Cause::Direction,
            Self::ZeroLost { .. } => Cause::ZeroLost,
            Self::Aliased => Cause::Aliasing,
            Self::OverSpeed { .. } => Cause::OverSpeed,
            Self::OverAcceleration { .. } => Cause::OverAcceleration,
            Self::Bit { .. } => Cause::SingleBit,
            Self::Stuck { .. } => Cause::StuckBit,
            Self::Noise { .. } => Cause::Noise,
            Self::Frozen { .. } => Cause::Frozen,
            Self::Other { .. } => Cause::OtherSource,
            Self::Slip { .. } => Cause::Mechanical,
        }
    }

    /// `true` for what shows only while the axis moves.
    pub(crate) const fn needs_motion(&self) -> bool {
        matches!(self, Self::Torn { .. } | Self::Wrap { .. } | Self::Aliased)
    }
}
