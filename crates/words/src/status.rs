//! The error status that service 08 returns [R85..R95].

use bitflags::bitflags;

bitflags! {
    /// The 16 bits of the error status. Bits without a name are always 0 [R94].
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub struct ErrorStatus: u16 {
        /// 2^0: a record of the EEPROM could not be read [R85].
        const READING_DATA = 1 << 0;
        /// 2^1: a record of the EEPROM could not be written, or a value was refused [R86, C6, C25].
        const WRITING_DATA = 1 << 1;
        /// 2^2: only reading is allowed [R87].
        const ONLY_READING = 1 << 2;
        /// 2^3: only writing is allowed [R88].
        const ONLY_WRITING = 1 << 3;
        /// 2^5: LA-66, the magnet is outside the valid measuring range [R95].
        const OUTSIDE_RANGE = 1 << 5;
        /// 2^7: unknown command [R89].
        const UNKNOWN_COMMAND = 1 << 7;
        /// 2^8: CE-100, preset 1 lies outside the valid measuring range [R90].
        const PRESET_1_RANGE = 1 << 8;
        /// 2^9: CE-100, preset 2 lies outside the valid measuring range [R90].
        const PRESET_2_RANGE = 1 << 9;
        /// 2^13: the revolutions numerator is 0 [R92].
        const NUMERATOR_ZERO = 1 << 13;
        /// 2^14: more steps per revolution than the rating plate gives [R93, C31].
        const LENGTH_TOO_LARGE = 1 << 14;
    }
}

impl ErrorStatus {
    /// The bits that hold as long as a programmed value is wrong, and are not latched [C23].
    pub const VALIDITY: Self = Self::PRESET_1_RANGE
        .union(Self::PRESET_2_RANGE)
        .union(Self::NUMERATOR_ZERO)
        .union(Self::LENGTH_TOO_LARGE);
}

/// One status bit with what it means and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusBit {
    /// Its place, 0..=15.
    pub bit: u8,
    /// What the manuals say it means.
    pub meaning: &'static str,
    /// The remedy of the disturbances table [CE-65 4.1], completed where the table leaves a cause out.
    pub remedy: &'static str,
}

/// Every status bit that any of the encoders can set, from 2^0 up.
pub const STATUS_BITS: [StatusBit; 10] = [
    StatusBit {
        bit: 0,
        meaning: "error reading data: defective memory area in the EEPROM",
        remedy: "repeat the service; if the error comes again, replace the encoder",
    },
    StatusBit {
        bit: 1,
        meaning: "error writing data: defective memory area in the EEPROM, or a value outside its range",
        remedy: "check the value against its range first; if a legal value is refused again, replace the encoder",
    },
    StatusBit {
        bit: 2,
        meaning: "only reading allowed: a write was tried",
        remedy: "set bit 2^30 (read-write bit) to 0",
    },
    StatusBit {
        bit: 3,
        meaning: "only writing allowed: a read was tried",
        remedy: "set bit 2^30 (read-write bit) to 1",
    },
    StatusBit {
        bit: 5,
        meaning: "sensor outside the valid measuring range (magnet)",
        remedy: "bring the magnet back over the rod, then run the data check",
    },
    StatusBit {
        bit: 7,
        meaning: "unknown command: wrong service number",
        remedy: "check the service number and correct it",
    },
    StatusBit {
        bit: 8,
        meaning: "preset 1 outside the valid measuring range",
        remedy: "program preset 1 (service 04) to 0..measuring length, or raise the measuring length",
    },
    StatusBit {
        bit: 9,
        meaning: "preset 2 outside the valid measuring range",
        remedy: "program preset 2 (service 05) to 0..measuring length, or raise the measuring length",
    },
    StatusBit {
        bit: 13,
        meaning: "revolutions numerator = 0",
        remedy: "program the numerator (service 03) to 1..FFFFh",
    },
    StatusBit {
        bit: 14,
        meaning: "measuring length in steps too large: more steps per revolution than on the rating plate",
        remedy: "raise numerator/denominator (services 03, 09) or lower the measuring length (service 02)",
    },
];

impl ErrorStatus {
    /// The bits that are set, each with its meaning and remedy.
    pub fn explain(self) -> impl Iterator<Item = &'static StatusBit> {
        STATUS_BITS.iter().filter(move |entry| self.bits() >> entry.bit & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // [R155, R156, R157]
    #[test]
    fn the_remedies_say_what_the_table_of_disturbances_says() {
        for (bits, said) in [
            (ErrorStatus::ONLY_READING, "set bit 2^30 (read-write bit) to 0"),
            (ErrorStatus::ONLY_WRITING, "set bit 2^30 (read-write bit) to 1"),
            (ErrorStatus::UNKNOWN_COMMAND, "check the service number"),
            (ErrorStatus::NUMERATOR_ZERO, "1..FFFFh"),
            (ErrorStatus::LENGTH_TOO_LARGE, "raise numerator/denominator"),
            (ErrorStatus::READING_DATA, "if the error comes again, replace the encoder"),
        ] {
            let mut rows = bits.explain();
            let row = rows.next().unwrap();
            assert!(row.remedy.contains(said), "{row:?}");
            assert_eq!(rows.next(), None);
        }
    }

    #[test]
    fn every_named_bit_has_its_row_and_every_row_a_name() {
        let rows = STATUS_BITS.iter().fold(0_u16, |bits, row| bits | 1 << row.bit);
        assert_eq!(rows, ErrorStatus::all().bits());
        assert_eq!(ErrorStatus::all().explain().count(), STATUS_BITS.len());
    }
}
