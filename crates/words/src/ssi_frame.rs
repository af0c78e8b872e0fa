//! The bits of one SSI transfer, pulse by pulse [R103..R120].
//!
//! The device that shifts them out is `encoder::ssi_output`; here is only which bit belongs to which rising edge.

use crate::Week;
use crate::parameter::{Code, SsiValues};

/// A level on Clock+ or Data+.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// 0 V.
    Low,
    /// +5 V.
    High,
}

impl Level {
    /// High for 1.
    #[must_use]
    pub const fn from_bit(bit: u32) -> Self {
        if bit & 1 == 1 { Self::High } else { Self::Low }
    }

    /// 1 for High.
    #[must_use]
    pub const fn bit(self) -> u32 {
        self as u32
    }
}

/// The mono period: a transfer ends when more than this has passed since the last falling clock edge [R111, C22].
pub const MONO_PERIOD: crate::Duration = crate::Duration::from_micros(20);

/// Clock rate in hertz that is guaranteed, from and to [R104].
pub const CLOCK_HZ: (u32, u32) = (80_000, 1_000_000);

/// Clock rate in hertz that is physically possible, from and to, approximately [R111, R112, C20].
pub const CLOCK_HZ_LIMIT: (u32, u32) = (50_000, 1_100_000);

/// Data bits that make firmware from week 41/1997 send the AK-40 format [R117].
pub const AK40_BITS: u8 = 31;

/// Pulses after which a repeated word begins again: 24 data bits and two Low [R119].
pub const REPETITION_PULSES: u8 = 26;

/// Data bits of a word that is repeated, whatever number was programmed [R119, C19].
const REPETITION_BITS: u8 = 24;

/// The fewest and the most data bits [R105].
pub const DATA_BITS: (u8, u8) = (8, 32);

/// How the bits of a transfer are laid out: the same for the device that sends and for who receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiFormat {
    code: Code,
    bits: u8,
    check: SsiCheck,
}

/// What a transfer holds beside the position, so that a disturbance can be noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SsiCheck {
    /// Nothing.
    None,
    /// AK-40: the last bit makes the number of ones odd [R117].
    OddParity,
    /// The word comes again every [`REPETITION_PULSES`] [R119].
    Repetition,
}

impl SsiFormat {
    /// The format that firmware of a week sends with these values. Numbers that no service stores count as the nearest
    /// that one does.
    #[must_use]
    pub const fn new(values: SsiValues, firmware: Week) -> Self {
        let SsiValues { repetition, code, bits } = values;
        if repetition {
            return Self { code, bits: REPETITION_BITS, check: SsiCheck::Repetition };
        }
        if bits == AK40_BITS && firmware.knows_ak40() {
            return Self { code: Code::Binary, bits: AK40_BITS + 1, check: SsiCheck::OddParity };
        }
        Self::plain(bits, code)
    }

    /// So many bits and nothing beside them, as cards that know no AK-40 and no repetition take them. A number that no
    /// service stores counts as the nearest that one does.
    #[must_use]
    pub const fn plain(bits: u8, code: Code) -> Self {
        let (fewest, most) = DATA_BITS;
        let bits = match bits {
            few if few < fewest => fewest,
            many if many > most => most,
            bits => bits,
        };
        Self { code, bits, check: SsiCheck::None }
    }

    /// The code of the position: always binary in the AK-40 format.
    #[must_use]
    pub const fn code(self) -> Code {
        self.code
    }

    /// Bits of the field, 8..=32: the data bits, and in the AK-40 format their parity.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.bits
    }

    /// What it holds beside the position.
    #[must_use]
    pub const fn check(self) -> SsiCheck {
        self.check
    }

    /// The field that says `position`. Gray of the whole value first, then the cut [C18].
    #[must_use]
    pub const fn field(self, position: u32) -> u32 {
        let field = match self.check {
            SsiCheck::OddParity => position << 1 | (position.count_ones() + 1) & 1,
            SsiCheck::None | SsiCheck::Repetition => self.code.encode(position),
        };
        field & u32::MAX >> (DATA_BITS.1 - self.bits)
    }

    /// The position that a field says. Of a position that needs more bits than there are, the upper ones are missing;
    /// in Gray code no bit of it can be told then [C18].
    #[must_use]
    pub const fn position(self, field: u32) -> u32 {
        match self.check {
            SsiCheck::OddParity => field >> 1,
            SsiCheck::None | SsiCheck::Repetition => self.code.decode(field),
        }
    }

    /// `false` if the format has a parity and the field's is wrong.
    #[must_use]
    pub const fn holds_parity(self, field: u32) -> bool {
        !matches!(self.check, SsiCheck::OddParity) || field.count_ones() % 2 == 1
    }
}

/// A word as latched at the first falling edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiFrame {
    format: SsiFormat,
    /// The bits, the first to be sent highest.
    field: u32,
}

impl SsiFrame {
    /// The frame for a position.
    #[must_use]
    pub const fn new(position: u32, format: SsiFormat) -> Self {
        Self { format, field: format.field(position) }
    }

    /// Data+ from the `pulse`-th rising edge on, counted from 1. Low after the last bit [R110].
    #[must_use]
    pub const fn level(&self, pulse: u32) -> Level {
        let Some(index) = pulse.checked_sub(1) else { return Level::High };
        let index = match self.format.check {
            SsiCheck::Repetition => index % REPETITION_PULSES as u32,
            SsiCheck::None | SsiCheck::OddParity => index,
        };
        let bits = self.format.bits as u32;
        if index < bits { Level::from_bit(self.field >> (bits - 1 - index)) } else { Level::Low }
    }

    /// The pulse that follows `pulse`, counted so that a clock that never stops cannot overflow: repetition begins
    /// again at 1, and after the last bit nothing changes any more.
    #[must_use]
    pub const fn after(&self, pulse: u32) -> u32 {
        match self.format.check {
            SsiCheck::Repetition => pulse % REPETITION_PULSES as u32 + 1,
            SsiCheck::None | SsiCheck::OddParity if pulse > self.format.bits as u32 => pulse,
            SsiCheck::None | SsiCheck::OddParity => pulse + 1,
        }
    }

    /// What a receiver collects with so many clocks, at most 64, the first bit received highest.
    #[must_use]
    pub fn collect(&self, clocks: u32) -> u64 {
        (1..=clocks).fold(0, |bits, pulse| bits << 1 | u64::from(self.level(pulse).bit()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(position: u32, repetition: bool, code: Code, bits: u8) -> SsiFrame {
        SsiFrame::new(position, SsiFormat::new(SsiValues { repetition, code, bits }, Week::AK40))
    }

    #[test]
    fn the_ak_40_words() {
        let words = [
            (0, 0x0000_0001),
            (1, 0x0000_0002),
            (2, 0x0000_0004),
            (3, 0x0000_0007),
            (0x27_0F, 0x0000_4E1F),
            (0x12_3456, 0x0024_68AC),
            (0xFF_FFFF, 0x01FF_FFFF),
        ];
        for (position, word) in words {
            for code in [Code::Binary, Code::Gray] {
                assert_eq!(frame(position, false, code, 31).collect(32), word);
                assert_eq!(frame(position, false, code, 31).collect(33), word << 1);
            }
            assert_eq!(word.count_ones() % 2, 1);
        }
        // A line stuck at either level has even parity, so it is noticed.
        assert_eq!(0_u32.count_ones() % 2, 0);
        assert_eq!(u32::MAX.count_ones() % 2, 0);
    }

    #[test]
    fn older_firmware_sends_31_plain_bits_in_the_programmed_code() {
        let values = SsiValues { repetition: false, code: Code::Gray, bits: 31 };
        let frame = SsiFrame::new(0x27_0F, SsiFormat::new(values, Week::new(40, 1997).unwrap()));
        assert_eq!(frame.collect(31), 0x34_88);
        assert_eq!(frame.collect(32), 0x34_88 << 1);
    }

    #[test]
    fn the_number_of_data_bits_places_the_position_in_the_pulses() {
        let plain = |bits, clocks| frame(0x27_0F, false, Code::Binary, bits).collect(clocks);
        assert_eq!(plain(24, 24), 0x00_27_0F);
        assert_eq!(plain(25, 25), 0x00_27_0F);
        assert_eq!(plain(14, 14), 0b10_0111_0000_1111);
        assert_eq!(plain(32, 32), 0x00_00_27_0F);
        assert_eq!(plain(14, 24), 0b10_0111_0000_1111 << 10);
        assert_eq!(frame(0x180, false, Code::Gray, 8).collect(8), 0x40);
    }

    #[test]
    fn more_data_bits_than_any_service_stores_are_32() {
        for code in [Code::Binary, Code::Gray] {
            assert_eq!(frame(0x27_0F, false, code, 33), frame(0x27_0F, false, code, 32));
            assert_eq!(frame(0x27_0F, false, code, u8::MAX), frame(0x27_0F, false, code, 32));
        }
    }

    #[test]
    fn counted_pulses_put_out_the_same_bits_however_long_the_clock_runs() {
        for (frame, pulses) in
            [(frame(0xAB_CDEF, true, Code::Gray, 24), 300), (frame(0xFF_FFFF, false, Code::Binary, 24), 300)]
        {
            let mut pulse = 0;
            for counted in 1..=pulses {
                pulse = frame.after(pulse);
                assert_eq!(frame.level(pulse), frame.level(counted), "pulse {counted}");
                assert!(pulse <= 26);
            }
        }
    }

    #[test]
    fn repetition_sends_the_same_24_bits_every_26_pulses() {
        let frame = frame(0xAB_CDEF, true, Code::Binary, 24);
        let once = 0xAB_CDEF_u64 << 2;
        assert_eq!(frame.collect(26), once);
        assert_eq!(frame.collect(52), once << 26 | once);
    }
}
