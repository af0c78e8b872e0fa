//! What can be behind a step change, and how sure that is.

use std::fmt;

use encoring_texts::SaidValue;

/// Why positions step although the axis does not, or only seem to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum JumpCause {
    /// A reply to a service was taken for a position [R25].
    ReplyAsPosition,
    /// One half of the word is from another cycle than the other [R5].
    TornWords,
    /// The high and the low half stand in each other's place [R5].
    HalvesExchanged,
    /// The position is in Gray code and was read as binary [R46, R120].
    GrayAsBinary,
    /// The position is binary and was read as Gray code.
    BinaryAsGray,
    /// The position went on at the other end of its range.
    Wrap,
    /// A preset adjustment, by service 06 or by an input [R68, R73].
    Preset,
    /// Another measuring length, numerator or denominator became active [R79].
    Rescaled,
    /// The counting direction was changed [R42].
    Direction,
    /// The encoder came up with another number of turns [R63].
    ZeroLost,
    /// The log and the encoder's refresh beat: a value twice, then a step of two.
    Aliasing,
    /// The shaft turned faster than is permissible [R124].
    OverSpeed,
    /// The speed changed faster than is permissible [R124].
    OverAcceleration,
    /// One bit of the word was wrong.
    SingleBit,
    /// One bit of the word does not change any more.
    StuckBit,
    /// The positions scatter [R152].
    Noise,
    /// The same word came again and again while the axis moved.
    Frozen,
    /// The words are those of another encoder.
    OtherSource,
    /// Coupling, shaft or scale slipped [R150..R153].
    Mechanical,
    /// Nothing in the recording tells.
    Unclear,
}

/// Every cause, in the order of `docs/diagnosis.md`.
pub const CAUSES: [JumpCause; 20] = [
    JumpCause::ReplyAsPosition,
    JumpCause::TornWords,
    JumpCause::HalvesExchanged,
    JumpCause::GrayAsBinary,
    JumpCause::BinaryAsGray,
    JumpCause::Wrap,
    JumpCause::Preset,
    JumpCause::Rescaled,
    JumpCause::Direction,
    JumpCause::ZeroLost,
    JumpCause::Aliasing,
    JumpCause::OverSpeed,
    JumpCause::OverAcceleration,
    JumpCause::SingleBit,
    JumpCause::StuckBit,
    JumpCause::Noise,
    JumpCause::Frozen,
    JumpCause::OtherSource,
    JumpCause::Mechanical,
    JumpCause::Unclear,
];

impl JumpCause {
    /// Its name for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ReplyAsPosition => "reply_as_position",
            Self::TornWords => "torn_words",
            Self::HalvesExchanged => "halves_exchanged",
            Self::GrayAsBinary => "gray_as_binary",
            Self::BinaryAsGray => "binary_as_gray",
            Self::Wrap => "wrap",
            Self::Preset => "preset",
            Self::Rescaled => "rescaled",
            Self::Direction => "direction",
            Self::ZeroLost => "zero_lost",
            Self::Aliasing => "aliasing",
            Self::OverSpeed => "over_speed",
            Self::OverAcceleration => "over_acceleration",
            Self::SingleBit => "single_bit",
            Self::StuckBit => "stuck_bit",
            Self::Noise => "noise",
            Self::Frozen => "frozen",
            Self::OtherSource => "other_source",
            Self::Mechanical => "mechanical",
            Self::Unclear => "unclear",
        }
    }

    /// What it is, for people.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::ReplyAsPosition => "a reply to a service taken for a position",
            Self::TornWords => "halves of two words put together",
            Self::HalvesExchanged => "high and low half exchanged",
            Self::GrayAsBinary => "Gray code read as binary",
            Self::BinaryAsGray => "binary read as Gray code",
            Self::Wrap => "the end of the range",
            Self::Preset => "a preset adjustment",
            Self::Rescaled => "another scaling",
            Self::Direction => "the other counting direction",
            Self::ZeroLost => "the zero was lost",
            Self::Aliasing => "the log and the refresh beat",
            Self::OverSpeed => "faster than is permissible",
            Self::OverAcceleration => "a change of speed that is not permissible",
            Self::SingleBit => "one wrong bit",
            Self::StuckBit => "a bit that no longer changes",
            Self::Noise => "positions that scatter",
            Self::Frozen => "the same word again and again while the axis moved",
            Self::OtherSource => "positions of another encoder",
            Self::Mechanical => "a slip of coupling, shaft or scale",
            Self::Unclear => "cannot be told",
        }
    }

    /// Whether something is wrong. The others happen to sound encoders: their range ends, or somebody programs them.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        !matches!(
            self,
            Self::Wrap | Self::Preset | Self::Rescaled | Self::Direction | Self::Aliasing | Self::Unclear
        )
    }

    /// Whether it is one that an encoder makes while others go on, so that what these did tells something.
    #[must_use]
    pub const fn is_jump(self) -> bool {
        !matches!(self, Self::Wrap | Self::Aliasing | Self::Rescaled | Self::Direction)
    }

    /// Whether it holds for a stretch of rows, which makes one episode.
    #[must_use]
    pub const fn lasts(self) -> bool {
        matches!(
            self,
            Self::HalvesExchanged
                | Self::GrayAsBinary
                | Self::BinaryAsGray
                | Self::Aliasing
                | Self::OverSpeed
                | Self::StuckBit
                | Self::Noise
                | Self::Frozen
                | Self::OtherSource
        )
    }

    /// Whether the manual's table of step changes is about it [R150..R153].
    #[must_use]
    pub const fn is_of_the_manual(self) -> bool {
        matches!(self, Self::SingleBit | Self::StuckBit | Self::Noise | Self::Mechanical)
    }
}

impl fmt::Display for JumpCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.title())
    }
}

/// How sure a cause is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Likelihood {
    /// Other causes explain it as well.
    Possible,
    /// Others would need a coincidence.
    Likely,
    /// The recording itself says so, or nothing else makes these words.
    Certain,
}

impl Likelihood {
    /// Its name for programs and people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Possible => "possible",
            Self::Likely => "likely",
            Self::Certain => "certain",
        }
    }
}

impl fmt::Display for Likelihood {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// By their names, for which every language has words.
impl From<JumpCause> for SaidValue {
    fn from(cause: JumpCause) -> Self {
        cause.name().into()
    }
}

impl From<Likelihood> for SaidValue {
    fn from(certainty: Likelihood) -> Self {
        certainty.name().into()
    }
}
