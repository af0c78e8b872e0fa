//! Plain Gray code, `value xor (value >> 1)` [R120, C10].
//!
//! Over a range whose length is not a power of two the code is not single-step at the wrap [C21]; no offset is
//! added to hide that, because no manual mentions one.

/// The Gray code of a binary value.
#[must_use]
pub const fn encode(value: u32) -> u32 {
    value ^ (value >> 1)
}

/// The binary value of a Gray code.
#[must_use]
pub const fn decode(code: u32) -> u32 {
    let mut value = code;
    value ^= value >> 16;
    value ^= value >> 8;
    value ^= value >> 4;
    value ^= value >> 2;
    value ^= value >> 1;
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worked_values() {
        assert_eq!(encode(0x27_0F), 0x34_88);
        assert_eq!(encode(0x12_34), 0x1B_2E);
        assert_eq!(encode(0xFF_FF_FF), 0x80_00_00);
    }

    #[test]
    fn every_24_bit_value_comes_back_and_neighbours_differ_in_one_bit() {
        for value in 0..=0xFF_FF_FF_u32 {
            assert_eq!(decode(encode(value)), value);
            assert_eq!((encode(value) ^ encode(value + 1)).count_ones(), 1);
        }
    }

    #[test]
    fn the_wrap_of_9999_changes_five_bits_and_the_full_wrap_one() {
        assert_eq!((encode(9999) ^ encode(0)).count_ones(), 5);
        assert_eq!((encode(0xFF_FF_FF) ^ encode(0)).count_ones(), 1);
    }
}
