//! Where the process data of an encoder are on an Inline bus coupler, which shows what it found on its ring:
//!
//! | Registers | Hold |
//! |---|---|
//! | 1400 | how many modules there are |
//! | 1401.. | one for each module: length code in the high byte, ident code in the low byte |
//! | 8000.. | the IN data of all modules, then the OUT data of all modules, in the order of the ring |
//!
//! Every module begins at a register of its own: data that are shorter than a word take a whole one, 3 bytes take
//! two. A coupler that packs them closer has to be addressed as plain registers. No real coupler was tried.
//!
//! The server's [`Layout::Inline`](crate::registers::Layout) shows a ring in the same way.

use encoring_bus::BusError;
use encoring_ring::ident::LENGTHS;

use crate::error::{Garbled, ModbusError};
use crate::place::{MODULES, REGISTERS_PER_ENCODER};

/// The most devices on a ring.
pub const MODULES_MAX: u16 = 512;

/// What every one of these encoders shows: analogue, in both directions [R2].
const ENCODER_IDENT: u8 = 51;

/// One module as the coupler describes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Module {
    ident: u8,
    words: u16,
}

/// The modules of a ring, from the first to the last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directory {
    modules: Vec<Module>,
}

/// Which registers an encoder has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offsets {
    /// The first of its IN data, counted from the first of all process data.
    pub input: usize,
    /// The first of its OUT data.
    pub out: usize,
}

/// How many registers the data of a module with this length code take; `None` if the code is reserved.
#[must_use]
pub fn words(length_code: u8) -> Option<u16> {
    // What is less than a word takes a whole register.
    LENGTHS.iter().find(|(code, _)| *code == length_code).map(|(_, bits)| bits.div_ceil(16))
}

impl Module {
    /// Output only: digital or analogue.
    const fn has_input(self) -> bool {
        !matches!(self.ident, 0x01 | 0x31)
    }

    /// Input only: digital or analogue.
    const fn has_output(self) -> bool {
        !matches!(self.ident, 0x02 | 0x32)
    }

    fn is_encoder(self) -> bool {
        self.ident == ENCODER_IDENT && usize::from(self.words) == REGISTERS_PER_ENCODER
    }

    fn input(self) -> usize {
        if self.has_input() { usize::from(self.words) } else { 0 }
    }

    fn output(self) -> usize {
        if self.has_output() { usize::from(self.words) } else { 0 }
    }
}

impl Directory {
    /// Reads the registers from [`MODULES`] + 1 on, as many as there are modules; `function` is the one that they
    /// were read with.
    ///
    /// # Errors
    /// [`Garbled::LengthCode`] if one has a reserved length: nothing behind it could be found.
    pub fn parse(registers: &[u16], function: u8) -> Result<Self, ModbusError> {
        let module = |(register, described): (u16, &u16)| {
            let [code, ident] = described.to_be_bytes();
            let garbled = ModbusError::Garbled { function, register, got: Garbled::LengthCode { code } };
            words(code).map(|words| Module { ident, words }).ok_or(garbled)
        };
        let modules = (MODULES + 1..).zip(registers).map(module).collect::<Result<_, ModbusError>>()?;
        Ok(Self { modules })
    }

    /// How many modules there are.
    #[must_use]
    pub fn modules(&self) -> usize {
        self.modules.len()
    }

    /// The ring positions of the encoders.
    pub fn encoders(&self) -> impl Iterator<Item = usize> {
        self.modules.iter().enumerate().filter(|(_, module)| module.is_encoder()).map(|(k, _)| k)
    }

    /// The registers of the encoder at a ring position.
    ///
    /// # Errors
    /// [`BusError::NoEncoder`] behind the last module, [`BusError::NotAnEncoder`] if another module is there.
    pub fn offsets(&self, position: usize) -> Result<Offsets, BusError> {
        let Some(module) = self.modules.get(position) else {
            return Err(BusError::NoEncoder { position, encoders: self.modules.len() });
        };
        if !module.is_encoder() {
            // The longest length is 32 words.
            let words = u8::try_from(module.words).unwrap_or(u8::MAX);
            return Err(BusError::NotAnEncoder { position, ident: module.ident, words });
        }
        let before = self.modules.iter().take(position);
        let input: usize = before.clone().map(|module| module.input()).sum();
        let all_input: usize = self.modules.iter().map(|module| module.input()).sum();
        let out: usize = before.map(|module| module.output()).sum();
        Ok(Offsets { input, out: all_input + out })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directory(modules: &[u16]) -> Directory {
        Directory::parse(modules, 3).unwrap()
    }

    #[test]
    fn in_data_of_all_modules_come_before_out_data() {
        let ring = directory(&[0x0233, 0x0233, 0x0233]);
        assert_eq!(ring.offsets(0), Ok(Offsets { input: 0, out: 6 }));
        assert_eq!(ring.offsets(2), Ok(Offsets { input: 4, out: 10 }));
        assert_eq!(ring.encoders().collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn modules_of_one_direction_take_no_room_in_the_other() {
        // Digital out 1 word, encoder, digital in 2 bits, analogue in 4 words, analogue out 2 words, encoder.
        let ring = directory(&[0x0101, 0x0233, 0x0D02, 0x0432, 0x0231, 0x0233]);
        assert_eq!(ring.offsets(1), Ok(Offsets { input: 0, out: 9 + 1 }));
        assert_eq!(ring.offsets(5), Ok(Offsets { input: 2 + 1 + 4, out: 9 + 1 + 2 + 2 }));
        assert_eq!(ring.encoders().collect::<Vec<_>>(), [1, 5]);
    }

    #[test]
    fn what_is_no_encoder_is_told() {
        let ring = directory(&[0x0133, 0x0203]);
        assert_eq!(ring.offsets(0), Err(BusError::NotAnEncoder { position: 0, ident: 51, words: 1 }));
        assert_eq!(ring.offsets(1), Err(BusError::NotAnEncoder { position: 1, ident: 3, words: 2 }));
        assert_eq!(ring.offsets(2), Err(BusError::NoEncoder { position: 2, encoders: 2 }));
        assert_eq!(
            ring.offsets(0).unwrap_err().to_string(),
            "the module at position 0 has ident code 51 and 1 words, an encoder has 51 and 2"
        );
    }

    #[test]
    fn every_length_code_has_its_words_or_is_refused() {
        let lengths: Vec<_> = (0..=u8::MAX).filter_map(|code| Some((code, words(code)?))).collect();
        assert_eq!(
            lengths,
            [
                (0x00, 0),
                (0x01, 1),
                (0x02, 2),
                (0x03, 3),
                (0x04, 4),
                (0x05, 5),
                (0x06, 8),
                (0x07, 9),
                (0x08, 1),
                (0x09, 1),
                (0x0B, 2),
                (0x0D, 1),
                (0x0E, 6),
                (0x0F, 7),
                (0x11, 26),
                (0x12, 16),
                (0x13, 24),
                (0x14, 32),
                (0x15, 10),
                (0x16, 12),
                (0x17, 14),
            ]
        );
        let error = Directory::parse(&[0x0233, 0x2A01], 3).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the answer to function 3 at register 1402 is no answer: length code 2Ah is not defined"
        );
    }
}
