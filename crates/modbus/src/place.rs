//! Where registers are and how two of them make a word: what the server and the client both stand on.

use std::fmt::{self, Display};
use std::str::FromStr;

use encoring_ring::image::Half;

/// The registers of one encoder: the halves of a 32-bit word.
pub const REGISTERS_PER_ENCODER: usize = 2;

/// The first of the diagnostic registers: status, parameter, and one for each segment.
pub const DIAGNOSIS: u16 = 900;

/// The register that says how many modules there are. Those after it describe them.
pub const MODULES: u16 = 1400;
/// Where the process data begin, unless an address says otherwise.
pub const DATA: RegisterPlace = RegisterPlace { table: Table::Holding, first: 8000 };

/// The two register tables of Modbus that are served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Holding registers: functions 3, 6, 16 and 23.
    Holding,
    /// Input registers: function 4.
    Input,
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Holding => "holding",
            Self::Input => "input",
        })
    }
}

/// Registers of one table, from an address on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegisterPlace {
    /// Which table.
    pub table: Table,
    /// The first register.
    pub first: u16,
}

impl Display for RegisterPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.table, self.first)
    }
}

/// Which half of a 32-bit word stands in the register with the lower address. Modbus does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WordOrder {
    /// Bits 31..16 first, as the encoders' own word addresses "1" and "2" [R5].
    #[default]
    HighFirst,
    /// Bits 15..0 first.
    LowFirst,
}

/// A word order was to be something else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("word order {given:?}; it must be high-first or low-first")]
pub struct UnknownWordOrder {
    /// What was given.
    pub given: String,
}

impl FromStr for WordOrder {
    type Err = UnknownWordOrder;

    fn from_str(given: &str) -> Result<Self, Self::Err> {
        match given {
            "high-first" => Ok(Self::HighFirst),
            "low-first" => Ok(Self::LowFirst),
            _ => Err(UnknownWordOrder { given: given.to_owned() }),
        }
    }
}

impl Display for WordOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::HighFirst => "high-first",
            Self::LowFirst => "low-first",
        })
    }
}

impl WordOrder {
    /// The word that two registers hold.
    #[must_use]
    pub fn word(self, registers: [u16; REGISTERS_PER_ENCODER]) -> u32 {
        let [first, second] = registers.map(u32::from);
        match self {
            Self::HighFirst => first << 16 | second,
            Self::LowFirst => second << 16 | first,
        }
    }

    /// The registers that hold a word.
    #[must_use]
    pub const fn registers(self, word: u32) -> [u16; REGISTERS_PER_ENCODER] {
        let (high, low) = ((word >> 16) as u16, word as u16);
        match self {
            Self::HighFirst => [high, low],
            Self::LowFirst => [low, high],
        }
    }

    /// Which half the register at an offset holds, counted from the first of the words.
    pub(crate) const fn half(self, register: usize) -> Half {
        match (self, register.is_multiple_of(REGISTERS_PER_ENCODER)) {
            (Self::HighFirst, true) | (Self::LowFirst, false) => Half::High,
            (Self::HighFirst, false) | (Self::LowFirst, true) => Half::Low,
        }
    }
}
