//! The two 32-bit words of an encoder's process image [R13..R29].
//!
//! [`OutWord`] and [`InWord`] are lossless: any 32 bits are one. What the bits mean is asked with `decode` and
//! becomes an [`Out`] or [`In`]; `From` leads back to the same bits. No word is an error here: whoever receives
//! one judges it.

use crate::service::{Access, Service};

/// A named piece of both words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its highest bit.
    pub high: u8,
    /// Its lowest bit.
    pub low: u8,
    /// The manuals' name.
    pub name: &'static str,
}

impl Field {
    const fn new(high: u8, low: u8, name: &'static str) -> Self {
        Self { high, low, name }
    }

    /// The field's bits in their place.
    #[must_use]
    pub const fn mask(self) -> u32 {
        u32::MAX >> (31 - (self.high - self.low)) << self.low
    }

    /// The field's value in a word, right-aligned.
    #[must_use]
    pub const fn of(self, word: u32) -> u32 {
        (word & self.mask()) >> self.low
    }
}

/// Service bit: 0 normal mode, 1 service mode [R17].
pub const SERVICE_BIT: Field = Field::new(31, 31, "service bit");
/// Read-write bit: 0 read, 1 write [R18].
pub const READ_WRITE_BIT: Field = Field::new(30, 30, "read-write bit");
/// Error bit, meant only from encoder to master [R19, C13].
pub const ERROR_BIT: Field = Field::new(29, 29, "error bit");
/// Reserve, always 0 [R20].
pub const RESERVE_BIT: Field = Field::new(28, 28, "reserve");
/// Service number [R21].
pub const SERVICE: Field = Field::new(27, 24, "service");
/// Position, or the service's data [R22, R23].
pub const DATA: Field = Field::new(23, 0, "data");

/// The layout that both words share, from the most significant bit down [R17..R22].
pub const FIELDS: [Field; 6] = [SERVICE_BIT, READ_WRITE_BIT, ERROR_BIT, RESERVE_BIT, SERVICE, DATA];

/// The largest value of 24 data bits.
pub const DATA_MAX: u32 = DATA.mask();

/// A word from the master to an encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OutWord(pub u32);

/// What is written to an OUT word: all of it, or one of the two 16-bit words that it consists of [R5].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// Bits 31..16.
    High(u16),
    /// Bits 15..0.
    Low(u16),
    /// Both at once.
    Both(OutWord),
}

/// A word from an encoder to the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InWord(pub u32);

/// A service number as it stands in a word: every 4-bit value is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ServiceNumber {
    /// A number that at least one manual lists.
    Known(Service),
    /// One of 0, 7, 0Ah..0Ch, 0Eh and 0Fh.
    Unknown(u8),
}

impl ServiceNumber {
    /// From bits 27..24, of which only the low four are looked at.
    #[must_use]
    pub const fn new(number: u8) -> Self {
        match Service::from_number(number & 0xF) {
            Some(service) => Self::Known(service),
            None => Self::Unknown(number & 0xF),
        }
    }

    /// The number, 0..=0Fh.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Known(service) => service.number(),
            Self::Unknown(number) => number,
        }
    }
}

/// The fields below the service bit, as both a request and a reply carry them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServiceFields {
    /// Bit 30.
    pub access: Access,
    /// Bit 29.
    pub error: bool,
    /// Bit 28.
    pub reserve: bool,
    /// Bits 27..24.
    pub service: ServiceNumber,
    /// Bits 23..0.
    pub data: u32,
}

/// What an OUT word asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Out {
    /// Service bit 0: normal mode; the other 31 bits have no effect [R13].
    Normal(u32),
    /// Service bit 1: a service is requested [R15].
    Request(ServiceFields),
}

/// What an IN word says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum In {
    /// Normal mode: the position, and whether an error is pending [R23, R24].
    Position {
        /// Bits 23..0.
        value: u32,
        /// Bit 29.
        error: bool,
    },
    /// The acknowledgement of a service [R25, R26].
    Reply(ServiceFields),
    /// Service bit 0 but bits set that no encoder sets then [R24]: not from one of these encoders.
    Foreign(u32),
}

impl ServiceFields {
    const fn of(word: u32) -> Self {
        Self {
            access: if READ_WRITE_BIT.of(word) == 1 { Access::Write } else { Access::Read },
            error: ERROR_BIT.of(word) == 1,
            reserve: RESERVE_BIT.of(word) == 1,
            service: ServiceNumber::new(SERVICE.of(word) as u8),
            data: DATA.of(word),
        }
    }

    const fn bits(self) -> u32 {
        SERVICE_BIT.mask()
            | match self.access {
                Access::Read => 0,
                Access::Write => READ_WRITE_BIT.mask(),
            }
            | if self.error { ERROR_BIT.mask() } else { 0 }
            | if self.reserve { RESERVE_BIT.mask() } else { 0 }
            | ((self.service.number() as u32) << SERVICE.low)
            | (self.data & DATA.mask())
    }
}

impl OutWord {
    /// `true` if bit 31 is set.
    #[must_use]
    pub const fn service_bit(self) -> bool {
        SERVICE_BIT.of(self.0) == 1
    }

    /// What the word asks for.
    #[must_use]
    pub const fn decode(self) -> Out {
        if self.service_bit() { Out::Request(ServiceFields::of(self.0)) } else { Out::Normal(self.0) }
    }

    /// The word after a write; a half that is not written stays.
    #[must_use]
    pub const fn after(self, written: Written) -> Self {
        match written {
            Written::High(high) => Self::from_halves(high, self.low()),
            Written::Low(low) => Self::from_halves(self.high(), low),
            Written::Both(word) => word,
        }
    }
}

impl InWord {
    /// Normal mode with this position; only its low 24 bits are taken.
    #[must_use]
    pub const fn position(value: u32, error: bool) -> Self {
        Self(DATA.of(value) | if error { ERROR_BIT.mask() } else { 0 })
    }

    /// `true` if bit 31 is set.
    #[must_use]
    pub const fn service_bit(self) -> bool {
        SERVICE_BIT.of(self.0) == 1
    }

    /// `true` if bit 29 is set.
    #[must_use]
    pub const fn error_bit(self) -> bool {
        ERROR_BIT.of(self.0) == 1
    }

    /// What the word says.
    #[must_use]
    pub const fn decode(self) -> In {
        if self.service_bit() {
            In::Reply(ServiceFields::of(self.0))
        } else if self.0 & !(DATA.mask() | ERROR_BIT.mask()) == 0 {
            In::Position { value: DATA.of(self.0), error: self.error_bit() }
        } else {
            In::Foreign(self.0)
        }
    }
}

impl From<Out> for OutWord {
    fn from(out: Out) -> Self {
        match out {
            Out::Normal(bits) => Self(bits & !SERVICE_BIT.mask()),
            Out::Request(fields) => Self(fields.bits()),
        }
    }
}

impl From<In> for InWord {
    fn from(input: In) -> Self {
        match input {
            In::Position { value, error } => Self::position(value, error),
            In::Reply(fields) => Self(fields.bits()),
            In::Foreign(bits) => Self(bits & !SERVICE_BIT.mask()),
        }
    }
}

macro_rules! halves {
    ($word:ty) => {
        impl $word {
            /// From relative word addresses "1" (high) and "2" (low) [R5].
            #[must_use]
            pub const fn from_halves(high: u16, low: u16) -> Self {
                Self((high as u32) << 16 | low as u32)
            }

            /// Relative word address "1": bits 31..16 [R5].
            #[must_use]
            pub const fn high(self) -> u16 {
                (self.0 >> 16) as u16
            }

            /// Relative word address "2": bits 15..0 [R5].
            #[must_use]
            pub const fn low(self) -> u16 {
                self.0 as u16
            }
        }

        impl core::fmt::Display for $word {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(f, "{:08X}", self.0)
            }
        }
    };
}
halves!(OutWord);
halves!(InWord);

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_fields_cover_the_word_once() {
        let mut covered = 0_u32;
        for field in FIELDS {
            assert_eq!(covered & field.mask(), 0, "{} overlaps", field.name);
            covered |= field.mask();
        }
        assert_eq!(covered, u32::MAX);
    }

    // [R5]
    #[test]
    fn the_worked_example_stands_in_two_words() {
        let out = OutWord(0xC200_270F);
        assert_eq!((out.high(), out.low()), (0xC200, 0x270F));
        assert_eq!(OutWord::from_halves(0xC200, 0x270F), out);
        let Out::Request(request) = out.decode() else { panic!("a request") };
        assert_eq!(request.access, Access::Write);
        assert_eq!(request.service, ServiceNumber::Known(Service::MeasuringLength));
        assert_eq!(request.data, 9999);
    }

    #[test]
    fn the_error_bit_is_bit_29() {
        assert!(InWord(0x2000_0000).error_bit() && InWord(0xA700_0000).error_bit());
        assert!(!InWord(0xDFFF_FFFF).error_bit());
    }

    #[test]
    fn a_position_with_other_upper_bits_is_foreign() {
        assert_eq!(InWord(0x2000_0001).decode(), In::Position { value: 1, error: true });
        for bit in [24, 25, 26, 27, 28, 30] {
            assert!(matches!(InWord(1 << bit).decode(), In::Foreign(_)));
        }
    }

    proptest! {
        #[test]
        fn every_word_comes_back_from_its_meaning(word: u32) {
            prop_assert_eq!(OutWord::from(OutWord(word).decode()), OutWord(word));
            prop_assert_eq!(InWord::from(InWord(word).decode()), InWord(word));
            prop_assert_eq!(OutWord::from_halves(OutWord(word).high(), OutWord(word).low()), OutWord(word));
        }
    }
}
