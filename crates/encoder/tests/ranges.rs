//! What each parameter takes, at the ends of its range and beside them, and what becomes of the rest.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, CellFault, ce65, ce100, every_model, la66};
use encoring_words::Model;

const DATA_MAX: u32 = 0xFF_FFFF;

/// Writes `data` and expects it to be taken: echo without an error, read back as it is.
fn takes(bench: &mut Bench, number: u32, data: u32) {
    let write = 0xC000_0000 | number << 24 | data;
    assert_eq!(bench.service(write), write, "{}", bench.model());
    assert_eq!(bench.service(0x8000_0000 | number << 24), 0x8000_0000 | number << 24 | data);
}

/// Writes `data` and expects it to be refused: bit 29, status 2^1 (none on the LA-66), the old value.
fn refuses(bench: &mut Bench, number: u32, data: u32) {
    bench.data_check();
    let read = 0x8000_0000 | number << 24;
    let old = bench.service(read) & DATA_MAX;
    let written = bench.memory.written();
    assert_eq!(
        bench.service(0xC000_0000 | number << 24 | data),
        0xE000_0000 | number << 24 | data,
        "{} {data:06X}",
        bench.model()
    );
    assert_eq!(bench.service(read), read | 1 << 29 | old);
    assert_eq!(bench.memory.written(), written, "nothing reaches the memory");
    let latched = if bench.model() == Model::La66 { 0 } else { 2 };
    assert_eq!(bench.data_check() & 0x2F, latched);
    assert_eq!(bench.data_check() & 0x2F, 0, "told once");
}

// [R45, R99]
#[test]
fn the_counting_direction_of_la_66_and_ce_100_is_0_or_1() {
    for mut bench in [la66(), ce100()] {
        for data in [0, 1, 0] {
            takes(&mut bench, 1, data);
        }
        for data in [2, 0xFF, 0x100, 0x101, 0x01_0000, DATA_MAX] {
            refuses(&mut bench, 1, data);
        }
    }
}

// [R47]
#[test]
fn service_01_of_the_ce_65_takes_every_byte_and_returns_0_or_1() {
    let mut bench = ce65();
    let table = [
        (0x00_0000, 0x0000),
        (0x00_0001, 0x0001),
        (0x00_0100, 0x0100),
        (0x00_0101, 0x0101),
        (0x00_FF7F, 0x0101),
        (0xFF_0000, 0x0000),
        (0xFF_80FF, 0x0101),
        (0x00_8000, 0x0100),
        (0x00_0080, 0x0001),
        (0x01_0002, 0x0001),
        (0xFF_FFFF, 0x0101),
    ];
    for (data, kept) in table {
        assert_eq!(bench.service(0xC100_0000 | data), 0xC100_0000 | data, "echoed as sent");
        assert_eq!(bench.service(0x8100_0000), 0x8100_0000 | kept, "{data:06X}");
    }
}

// [R46]
#[test]
fn service_01_of_the_ce_65_means_two_by_two_behaviours() {
    let mut bench = ce65();
    bench.turn_to(0x1233);
    // Falling: -1 - 1233h, of 24 bits FFEDCCh.
    let (rising, falling) = (0x00_1233, 0xFF_EDCC);
    let gray = |value: u32| value ^ value >> 1;
    let table = [
        (0x00_0000, rising),
        (0x00_0001, falling),
        (0x00_0100, gray(rising)),
        (0x00_0101, gray(falling)),
        (0x00_FF7F, gray(falling)),
        (0xFF_0000, rising),
        (0x00_FF80, gray(falling)),
    ];
    for (data, shown) in table {
        bench.program(&[0xC100_0000 | data]);
        assert_eq!(bench.position(), shown, "{data:06X}");
    }
}

// [R54]
#[test]
fn the_measuring_length_of_the_rotary_encoders_begins_at_10h() {
    for mut bench in [ce100(), ce65()] {
        for data in [0x10, 0x11, 0xFF_FFFE, DATA_MAX] {
            takes(&mut bench, 2, data);
        }
        for data in [0, 1, 0x0F] {
            refuses(&mut bench, 2, data);
        }
    }
}

// [R49]
#[test]
fn the_measuring_length_of_the_la_66_is_arbitrary_but_not_0() {
    let mut bench = la66();
    for data in [1, 2, 0x0F, 0x10, 0xC350, 0xFF_FFFE, DATA_MAX] {
        takes(&mut bench, 2, data);
    }
    refuses(&mut bench, 2, 0);
}

// [R57]
#[test]
fn the_numerator_ends_at_ffffh() {
    for mut bench in [ce100(), ce65()] {
        for data in [1, 2, 0xFFFE, 0xFFFF] {
            takes(&mut bench, 3, data);
        }
        for data in [0x1_0000, 0x1_0001, DATA_MAX] {
            refuses(&mut bench, 3, data);
        }
    }
}

// [R57, R92]
#[test]
fn a_numerator_of_0_is_stored_and_flagged_at_once() {
    for mut bench in [ce100(), ce65()] {
        assert_eq!(bench.service(0xC300_0000), 0xE300_0000);
        assert_eq!(bench.service(0x8300_0000), 0xA300_0000);
        assert_eq!(bench.position(), 0x2000_0000);
        assert_eq!(bench.data_check(), 0xA800_2000);
    }
}

#[test]
fn a_numerator_of_0_that_is_corrected_before_the_data_check_is_named_by_it_once() {
    // "Determine the error exactly" [R82]: bit 29 was in the reply, so the check tells which it was.
    for mut bench in [ce100(), ce65()] {
        assert_eq!(bench.service(0xC300_0000), 0xE300_0000);
        assert_eq!(bench.service(0xC300_1000), 0xE300_1000);
        assert_eq!(bench.data_check(), 0x8800_2000);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

#[test]
fn a_numerator_of_0_that_the_memory_does_not_take_is_2_to_1_and_not_2_to_13() {
    for mut bench in [ce100(), ce65()] {
        bench.memory.break_all(CellFault::Write);
        assert_eq!(bench.service(0xC300_0000), 0xE300_0000);
        bench.memory.repair();
        assert_eq!(bench.service(0x8300_0000), 0xA300_1000, "the old one stays");
        assert_eq!(bench.data_check(), 0x8800_0002);
    }
}

// [R58]
#[test]
fn the_denominator_is_1_to_63h() {
    for mut bench in [ce100(), ce65()] {
        for data in [1, 2, 0x62, 0x63] {
            takes(&mut bench, 9, data);
        }
        for data in [0, 0x64, 0x65, 0x100, 0x101, DATA_MAX] {
            refuses(&mut bench, 9, data);
        }
    }
}

// [R66]
#[test]
fn preset_value_1_of_the_la_66_does_not_depend_on_the_measuring_length() {
    let mut bench = la66();
    bench.service(0xC200_0001);
    for data in [0, 1, 2, 0xC350, 0xFF_FFFE, DATA_MAX] {
        takes(&mut bench, 4, data);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

// [R67, R70, R90]
#[test]
fn preset_values_of_the_ce_100_are_judged_by_the_data_check() {
    for (number, bit) in [(4, 0x100), (5, 0x200)] {
        let mut bench = ce100();
        bench.program(&[0xC200_270F]);
        for data in [0, 1, 0x270E, 0x270F] {
            takes(&mut bench, number, data);
            assert_eq!(bench.data_check(), 0x8800_0000);
        }
        for data in [0x2710, 0x2711, DATA_MAX] {
            takes(&mut bench, number, data);
            assert_eq!(bench.data_check(), 0xA800_0000 | bit, "{data:06X}");
            assert_eq!(bench.data_check(), 0xA800_0000 | bit, "until corrected");
            assert_eq!(bench.service(0xC000_0000 | number << 24), 0xE000_0000 | number << 24);
            assert_eq!(bench.data_check(), 0x8800_0000);
        }
    }
}

// [R90]
#[test]
fn a_length_shrunk_below_the_preset_values_is_their_fault() {
    let mut bench = ce100();
    bench.program(&[0xC400_270F, 0xC500_2710]);
    assert_eq!(bench.service(0xC200_270F), 0xC200_270F);
    assert_eq!(bench.data_check(), 0xA800_0200);
    assert_eq!(bench.service(0xC200_270E), 0xE200_270E);
    assert_eq!(bench.data_check(), 0xA800_0300);
    assert_eq!(bench.service(0xC200_2710), 0xE200_2710);
    assert_eq!(bench.data_check(), 0x8800_0000);
}

// [R75]
#[test]
fn service_06_of_the_rotary_encoders_ends_at_the_active_length() {
    for mut bench in [ce100(), ce65()] {
        bench.program(&[0xC200_270F]);
        for value in [0, 1, 0x270E, 0x270F] {
            assert_eq!(bench.service(0xC600_0000 | value), 0xC600_0000 | value);
            assert_eq!(bench.position(), value);
        }
        for value in [0x2710, 0x2711, DATA_MAX] {
            assert_eq!(bench.service(0xC600_0000 | value), 0xE600_0000 | value);
            assert_eq!(bench.position(), 0x2000_270F, "nothing moved");
            assert_eq!(bench.data_check(), 0x8800_0002);
        }
        // A longer length that is only programmed does not count, a shorter one neither.
        bench.service(0xC200_FFFF);
        assert_eq!(bench.service(0xC600_2710), 0xE600_2710);
        bench.data_check();
        assert_eq!(bench.service(0xC600_2710), 0xC600_2710);
        bench.service(0xC200_0010);
        assert_eq!(bench.service(0xC600_FFFF), 0xC600_FFFF);
        assert_eq!(bench.position(), 0xFFFF);
    }
}

// [R74]
#[test]
fn service_06_of_the_la_66_takes_24_bits() {
    let mut bench = la66();
    for value in [0, 1, 0xC350, 0xC351, 0xFF_FFFE, DATA_MAX] {
        assert_eq!(bench.service(0xC600_0000 | value), 0xC600_0000 | value);
        assert_eq!(bench.position(), value);
    }
}

// [R105, R115]
#[test]
fn the_number_of_ssi_bits_is_8_to_20h() {
    let mut bench = ce65();
    for data in [0x08, 0x09, 0x18, 0x1F, 0x20, 0x0108, 0x01_0018] {
        takes(&mut bench, 0xD, data);
    }
    for data in [0, 0x07, 0x21, 0xFF, 0x0107, 0x01_0007, 0x01_0021, 0xFF_FF00, DATA_MAX] {
        refuses(&mut bench, 0xD, data);
    }
}

// [R114]
#[test]
fn service_0d_returns_0_or_1_and_24_bits_with_repetition() {
    let mut bench = ce65();
    let table = [
        (0x00_FF18, 0x00_0118),
        (0x00_801F, 0x00_011F),
        (0xFF_FF20, 0x01_0118),
        (0x80_0008, 0x01_0018),
        (0x01_001F, 0x01_0018),
        (0x00_0020, 0x00_0020),
    ];
    for (data, kept) in table {
        assert_eq!(bench.service(0xCD00_0000 | data), 0xCD00_0000 | data, "echoed as sent");
        assert_eq!(bench.service(0x8D00_0000), 0x8D00_0000 | kept, "{data:06X}");
    }
}

// [R56, R64]
#[test]
fn parameters_are_read_and_written_on_every_model_that_has_them() {
    for mut bench in every_model() {
        let (numbers, rotary): (&[u32], bool) = match bench.model() {
            Model::La66 => (&[1, 2, 4], false),
            Model::Ce100M => (&[1, 2, 3, 4, 5, 9], true),
            Model::Ce65M => (&[1, 2, 3, 9], true),
        };
        for &number in numbers {
            takes(&mut bench, number, if number == 2 && rotary { 0x10 } else { 1 });
        }
    }
}
