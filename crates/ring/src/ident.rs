//! The identification word that a device shows in an ID cycle: what it is, how long it is, what it reports.

use crate::profile::{MESSAGE_CRC, MESSAGE_MODULE, MESSAGE_RECONFIGURE};

/// 16 bits: ident code in bits 7..0, length code in 12..8, messages in 15..13. Any 16 bits are one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ident(pub u16);

/// What an encoder of any model shows: ident code 33h and two words [R2, R3].
pub const ENCODER: Ident = Ident::new(0x33, 0x02);

/// The bits of a word that are messages.
pub const MESSAGES: u16 = MESSAGE_RECONFIGURE | MESSAGE_CRC | MESSAGE_MODULE;

/// Which directions a device has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataDirection {
    /// It takes data.
    Out,
    /// It gives data.
    In,
    /// Both.
    Both,
}

/// What the ident code of a device says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Digital inputs or outputs, remote bus: 01h, 02h, 03h.
    Digital(DataDirection),
    /// Analogue inputs or outputs, remote bus: 31h, 32h, 33h, the encoders among them [R2].
    Analogue(DataDirection),
    /// A code that is not known here.
    Other(u8),
}

/// How long a device's register is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Whole bytes, up to 64.
    Bytes(u8),
    /// Less than a byte: 2 or 4 bits.
    Bits(u8),
}

/// The length codes, each with its bits; those that are missing are reserved.
pub const LENGTHS: [(u8, u16); 21] = [
    (0x00, 0),
    (0x01, 16),
    (0x02, 32),
    (0x03, 48),
    (0x04, 64),
    (0x05, 80),
    (0x06, 128),
    (0x07, 144),
    (0x08, 4),
    (0x09, 8),
    (0x0B, 24),
    (0x0D, 2),
    (0x0E, 96),
    (0x0F, 112),
    (0x11, 416),
    (0x12, 256),
    (0x13, 384),
    (0x14, 512),
    (0x15, 160),
    (0x16, 192),
    (0x17, 224),
];

/// What [`LENGTHS`] says of every code, so that a length costs one look-up.
const BY_CODE: [Option<Length>; 32] = {
    let mut by_code = [None; 32];
    let mut row = 0;
    while row < LENGTHS.len() {
        // The table is filled when the crate is compiled, so nothing can go past its end later.
        #[expect(clippy::indexing_slicing, reason = "in a constant")]
        {
            let (code, bits) = LENGTHS[row];
            let length =
                if bits % 8 == 0 { Length::Bytes((bits / 8) as u8) } else { Length::Bits(bits as u8) };
            by_code[code as usize] = Some(length);
        }
        row += 1;
    }
    by_code
};

impl Ident {
    /// A word without messages; of the length code the low five bits.
    #[must_use]
    pub const fn new(code: u8, length_code: u8) -> Self {
        Self((length_code as u16 & 0x1F) << 8 | code as u16)
    }

    /// The ident code.
    #[must_use]
    pub const fn code(self) -> u8 {
        self.0 as u8
    }

    /// The length code.
    #[must_use]
    pub const fn length_code(self) -> u8 {
        (self.0 >> 8) as u8 & 0x1F
    }

    /// The messages alone.
    #[must_use]
    pub const fn messages(self) -> u16 {
        self.0 & MESSAGES
    }

    /// The word without its messages: what a configuration is compared by.
    #[must_use]
    pub const fn identity(self) -> Self {
        Self(self.0 & !MESSAGES)
    }

    /// What the ident code says.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self.code() {
            0x01 => Kind::Digital(DataDirection::Out),
            0x02 => Kind::Digital(DataDirection::In),
            0x03 => Kind::Digital(DataDirection::Both),
            0x31 => Kind::Analogue(DataDirection::Out),
            0x32 => Kind::Analogue(DataDirection::In),
            0x33 => Kind::Analogue(DataDirection::Both),
            other => Kind::Other(other),
        }
    }

    /// How long the register is; `None` for a reserved code.
    #[must_use]
    pub fn length(self) -> Option<Length> {
        *BY_CODE.get(usize::from(self.length_code()))?
    }

    /// The whole bytes of the register; `None` for a reserved code and for registers of less than a byte, which this
    /// ring does not carry.
    #[must_use]
    pub fn bytes(self) -> Option<usize> {
        match self.length()? {
            Length::Bytes(bytes) => Some(usize::from(bytes)),
            Length::Bits(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::DEVICE_BYTES_MAX;

    // [R2, R3]
    #[test]
    fn an_encoder_is_33h_with_two_words() {
        assert_eq!(ENCODER, Ident(0x0233));
        assert_eq!(ENCODER.code(), 51);
        assert_eq!(ENCODER.kind(), Kind::Analogue(DataDirection::Both));
        assert_eq!(ENCODER.bytes(), Some(4));
    }

    #[test]
    fn every_length_code_has_its_words_or_is_reserved() {
        let words = |code| match Ident::new(0, code).length() {
            Some(Length::Bytes(bytes)) if bytes % 2 == 0 => Some(bytes / 2),
            _ => None,
        };
        let expected = [
            (0x00, 0),
            (0x01, 1),
            (0x02, 2),
            (0x03, 3),
            (0x04, 4),
            (0x05, 5),
            (0x06, 8),
            (0x07, 9),
            (0x0E, 6),
            (0x0F, 7),
            (0x15, 10),
            (0x16, 12),
            (0x17, 14),
            (0x12, 16),
            (0x13, 24),
            (0x11, 26),
            (0x14, 32),
        ];
        for (code, length) in expected {
            assert_eq!(words(code), Some(length), "{code:02X}h");
        }
        assert_eq!(Ident::new(0, 0x08).length(), Some(Length::Bits(4)));
        assert_eq!(Ident::new(0, 0x09).length(), Some(Length::Bytes(1)));
        assert_eq!(Ident::new(0, 0x0B).length(), Some(Length::Bytes(3)));
        assert_eq!(Ident::new(0, 0x0D).length(), Some(Length::Bits(2)));
        for reserved in [0x0A, 0x0C, 0x10, 0x18, 0x19, 0x1A, 0x1B, 0x1C, 0x1D, 0x1E, 0x1F] {
            assert_eq!(Ident::new(0, reserved).length(), None, "{reserved:02X}h");
        }
        let longest = (0..32).filter_map(|code| Ident::new(0, code).bytes()).max();
        assert_eq!(longest, Some(DEVICE_BYTES_MAX));
    }

    #[test]
    fn messages_do_not_change_what_a_device_is() {
        let troubled = Ident(ENCODER.0 | MESSAGES);
        assert_ne!(troubled, ENCODER);
        assert_eq!(troubled.identity(), ENCODER);
        assert_eq!(troubled.messages(), 0xE000);
        assert_eq!(troubled.bytes(), Some(4));
    }
}
