//! The check word: x^16+x^12+x^5+1 over the bytes of a segment, highest bit first [A8].

use crate::profile::CRC_PRESET;

const POLYNOMIAL: u16 = 0x1021;

/// The remainder of every byte, so that a byte costs one look-up.
const TABLE: [u16; 256] = {
    let mut table = [0; 256];
    let mut byte = 0_u16;
    while byte < 256 {
        let mut rest = byte << 8;
        let mut bit = 0;
        while bit < 8 {
            rest = if rest & 0x8000 == 0 { rest << 1 } else { rest << 1 ^ POLYNOMIAL };
            bit += 1;
        }
        // The table is filled when the crate is compiled, so nothing can go past its end later.
        #[expect(clippy::indexing_slicing, reason = "in a constant")]
        {
            table[byte as usize] = rest;
        }
        byte += 1;
    }
    table
};

/// A check word in the making.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crc(u16);

impl Crc {
    /// Over nothing yet.
    pub const NEW: Self = Self(CRC_PRESET);

    /// Takes one byte in.
    pub fn push(&mut self, byte: u8) {
        let index = (self.0 >> 8) as u8 ^ byte;
        self.0 = self.0 << 8 ^ TABLE.get(usize::from(index)).copied().unwrap_or_default();
    }

    /// The check word of the bytes so far.
    #[must_use]
    pub const fn word(self) -> u16 {
        self.0
    }
}

impl Default for Crc {
    fn default() -> Self {
        Self::NEW
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn of(bytes: &[u8]) -> u16 {
        let mut crc = Crc::NEW;
        bytes.iter().for_each(|byte| crc.push(*byte));
        crc.word()
    }

    #[test]
    fn the_check_word_of_one_to_nine() {
        assert_eq!(of(b"123456789"), 0x29B1);
        assert_eq!(of(b""), 0xFFFF);
    }

    proptest! {
        #[test]
        fn the_check_word_is_the_one_that_others_compute(bytes: Vec<u8>) {
            let theirs = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740);
            prop_assert_eq!(of(&bytes), theirs.checksum(&bytes));
        }
    }
}
