//! What bits 23..0 of a service hold.

/// A value was refused because it lies outside its range [C6].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{value:X}h is outside {low:X}h..{high:X}h")]
pub struct OutOfRange {
    /// The value that decided: the whole data, for service 0D the number of data bits.
    pub value: u32,
    /// The smallest legal value.
    pub low: u32,
    /// The largest legal value.
    pub high: u32,
}

/// Refuses a value outside `low..=high`.
///
/// # Errors
/// [`OutOfRange`] with the three numbers.
pub const fn within(value: u32, low: u32, high: u32) -> Result<u32, OutOfRange> {
    if value < low || value > high { Err(OutOfRange { value, low, high }) } else { Ok(value) }
}

/// Whether the position rises or falls when the shaft turns clockwise or the magnet moves to the rod's end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// Rising clockwise, looking at the shaft; increasing towards the end of the rod [R42, R44].
    #[default]
    Rising,
    /// The other way round.
    Falling,
}

/// How a position is written into bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Code {
    /// Plain binary.
    #[default]
    Binary,
    /// Gray, see [`crate::gray`].
    Gray,
}

impl Code {
    /// Byte value 0 is binary, every other Gray [R46, R113].
    #[must_use]
    pub const fn from_byte(byte: u8) -> Self {
        if byte == 0 { Self::Binary } else { Self::Gray }
    }

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Binary => "binary",
            Self::Gray => "gray",
        }
    }

    /// The code of a name, upper or lower case.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Binary, Self::Gray].into_iter().find(|code| code.name().eq_ignore_ascii_case(name))
    }

    /// `value` in this code.
    #[must_use]
    pub const fn encode(self, value: u32) -> u32 {
        match self {
            Self::Binary => value,
            Self::Gray => crate::gray::encode(value),
        }
    }

    /// The value that `bits` stand for in this code.
    #[must_use]
    pub const fn decode(self, bits: u32) -> u32 {
        match self {
            Self::Binary => bits,
            Self::Gray => crate::gray::decode(bits),
        }
    }
}

/// The meaning of service 01's data [R46]. Where only 0 and 1 exist the code is binary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CountingDirection {
    /// Byte 0: 0 rising, otherwise falling.
    pub direction: Direction,
    /// Byte 1: the code of the position on the bus.
    pub code: Code,
}

impl CountingDirection {
    /// From bits 23..0; byte 2 has no meaning.
    #[must_use]
    pub const fn from_data(data: u32) -> Self {
        Self {
            direction: if data & 0xFF == 0 { Direction::Rising } else { Direction::Falling },
            code: Code::from_byte((data >> 8) as u8),
        }
    }

    /// Bits 23..0, each byte 0 or 1 [C11].
    #[must_use]
    pub const fn data(self) -> u32 {
        (self.code as u32) << 8 | self.direction as u32
    }
}

/// The meaning of service 0D's data [R113].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiValues {
    /// Byte 2: the data bits come again every 26 pulses [R119].
    pub repetition: bool,
    /// Byte 1: the code of the position on the SSI, independent of the bus.
    pub code: Code,
    /// Byte 0: number of data bits, 8..=32.
    pub bits: u8,
}

impl SsiValues {
    /// From bits 23..0, without judging the number.
    #[must_use]
    pub const fn from_data(data: u32) -> Self {
        Self {
            repetition: data >> 16 & 0xFF != 0,
            code: Code::from_byte((data >> 8) as u8),
            bits: data as u8,
        }
    }

    /// Bits 23..0, bytes 2 and 1 each 0 or 1.
    #[must_use]
    pub const fn data(self) -> u32 {
        (self.repetition as u32) << 16 | (self.code as u32) << 8 | self.bits as u32
    }

    /// The number is judged first, also with repetition; repetition then makes it 24 [R119, C19].
    pub(crate) const fn normalise(data: u32, fewest: u32, most: u32) -> Result<u32, OutOfRange> {
        let mut values = Self::from_data(data);
        if let Err(refused) = within(values.bits as u32, fewest, most) {
            return Err(refused);
        }
        if values.repetition {
            values.bits = 24;
        }
        Ok(values.data())
    }
}
