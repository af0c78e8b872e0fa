//! Bit 29, what sets and clears it, and the status that the data check tells.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, CellFault, cases, ce65, ce100, every_model, la66};
use encoring_encoder::Magnet;
use encoring_words::Model;
use proptest::prelude::*;

fn mask(model: Model) -> u32 {
    match model {
        Model::La66 => 0x0020,
        Model::Ce100M => 0x638F,
        Model::Ce65M => 0x608F,
    }
}

// [R27]
#[test]
fn a_good_service_on_a_device_without_errors_leaves_bit_29_at_0() {
    for mut bench in every_model() {
        for out in [0x8100_0000, 0xC100_0001, 0x8200_0000, 0xC200_0FFF, 0xC600_0123, 0x8800_0000] {
            assert_eq!(bench.service(out) & 1 << 29, 0, "{out:08X}");
            assert!(!bench.encoder.error_pending());
        }
        bench.service(0x8700_0000);
        assert!(bench.encoder.error_pending());
    }
}

// [R28, R83]
#[test]
fn a_set_error_bit_is_cleared_by_the_data_check_alone() {
    for mut bench in every_model() {
        assert_eq!(bench.service(0x8700_0000), 0xA700_0000);
        for out in [0x8100_0000, 0xC100_0001, 0x8200_0000, 0xC200_0FFF, 0xC600_0123, 0xC800_0000] {
            assert_eq!(bench.service(out) & 1 << 29, 1 << 29, "every reply carries it: {out:08X}");
            assert_eq!(bench.position() & 1 << 29, 1 << 29);
        }
        bench.advance(3_600_000_000_000);
        assert_eq!(bench.position(), 0x2000_0123, "an hour later too");
        assert_eq!(bench.data_check() >> 24, 0x88);
        assert_eq!(bench.position() >> 24, 0);
        assert_eq!(bench.service(0x8100_0000), 0x8100_0001);
    }
}

#[test]
fn a_power_cycle_clears_bit_29_and_the_latched_status() {
    for mut bench in every_model() {
        bench.service(0x8700_0000);
        assert_eq!(bench.power_cycle(), 0);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

// [R82]
#[test]
fn latched_bits_gather_until_the_data_check_and_are_told_once() {
    for mut bench in [ce100(), ce65()] {
        for out in [0x8700_0000, 0x8600_0000, 0xC800_0000, 0xC900_0000] {
            bench.service(out);
        }
        assert_eq!(bench.data_check(), 0x8800_008E);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

// [R83]
#[test]
fn a_validity_fault_keeps_bit_29_and_the_data_check_says_a8h() {
    for mut bench in [ce100(), ce65()] {
        assert_eq!(bench.service(0xC300_0001), 0xC300_0001, "2^14 is not known before the check");
        assert_eq!(bench.position(), 0);
        for _ in 0..3 {
            assert_eq!(bench.data_check(), 0xA800_4000);
            assert_eq!(bench.position(), 0x2000_0000);
        }
        assert_eq!(bench.service(0xC300_1000), 0xE300_1000);
        assert_eq!(bench.data_check(), 0x8800_0000);
        assert_eq!(bench.position(), 0);
    }
}

#[test]
fn a_check_with_latched_bits_but_valid_parameters_says_88h_and_accepts() {
    for mut bench in [ce100(), ce65()] {
        bench.service(0xC200_0FFF);
        bench.service(0x8700_0000);
        assert_eq!(bench.data_check(), 0x8800_0080);
        assert_eq!(bench.position_at(4096 * 4095), 4095);
    }
}

// [R77, R78]
#[test]
fn the_data_check_tells_the_status_in_the_second_word_and_nothing_above_it() {
    for mut bench in every_model() {
        for out in [0x8700_0000, 0x8600_0000, 0xC800_0000, 0xC3FF_FFFF] {
            bench.service(out);
            for data in [0, 0x12_3456, 0xFF_FFFF] {
                let reply = bench.service(0x8800_0000 | data);
                assert_eq!(reply & 0xDFFF_0000, 0x8800_0000, "bits 23..16 are 0");
                assert_eq!(reply & 0xFFFF & !mask(bench.model()), 0);
            }
        }
    }
}

// [R84]
#[test]
fn error_bit_in_the_first_word_status_in_the_second() {
    let mut bench = ce65();
    let reply = bench.service(0x8700_0000);
    assert_eq!(reply >> 16, 0xA700);
    let reply = bench.data_check();
    assert_eq!((reply >> 16, reply & 0xFFFF), (0x8800, 0x0080));
}

// [R85]
#[test]
fn a_memory_that_cannot_be_read_is_2_to_0() {
    for mut bench in [ce100(), ce65()] {
        bench.position_at(0x12_3456);
        bench.memory.break_all(CellFault::Read);
        for number in [1, 2, 3, 9] {
            assert_eq!(bench.service(0x8000_0000 | number << 24), 0xA000_0000 | number << 24, "data 0");
        }
        assert_eq!(bench.position(), 0x2012_3456, "the working copies are untouched");
        bench.memory.repair();
        assert_eq!(bench.service(0x8200_0000), 0xA2FF_FFFF);
        assert_eq!(bench.data_check(), 0x8800_0001);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

// [R86]
#[test]
fn a_memory_that_cannot_be_written_is_2_to_1_and_the_old_value_stays() {
    for mut bench in [ce100(), ce65()] {
        bench.program(&[0xC200_0FFF]);
        bench.position_at(4096 * 7);
        bench.memory.break_all(CellFault::Write);
        assert_eq!(bench.service(0xC200_1FFF), 0xE200_1FFF);
        assert_eq!(bench.service(0x8200_0000), 0xA200_0FFF);
        assert_eq!(bench.service(0xC600_0100), 0xE600_0100);
        assert_eq!(bench.position(), 0x2000_0007);
        bench.memory.repair();
        assert_eq!(bench.data_check(), 0x8800_0002);
        assert_eq!(bench.position(), 7);
        assert_eq!(bench.power_cycle(), 7);
        assert_eq!(bench.service(0x8200_0000), 0x8200_0FFF);
    }
}

// [R86]
#[test]
fn a_value_that_does_not_read_back_is_2_to_1_and_the_old_one_stays_in_use() {
    for stuck in [0x00, 0x5A, 0xFF] {
        for mut bench in [ce100(), ce65()] {
            bench.program(&[0xC200_0FFF]);
            bench.position_at(4096 * 7);
            bench.memory.break_all(CellFault::Stuck(stuck));
            assert_eq!(bench.service(0xC200_1FFF), 0xE200_1FFF);
            assert_eq!(bench.service(0xC600_0100), 0xE600_0100);
            assert_eq!(bench.position(), 0x2000_0007);
            assert_eq!(bench.service(0x8200_0000), 0xA200_0000, "nor can the old one be read");
            assert_eq!(bench.data_check() & 0xFFFF, 0x0003);
            assert_eq!(bench.position() & 0xFF_FFFF, 7);
        }
    }
}

#[test]
fn a_check_that_cannot_store_the_accepted_set_tells_2_to_1_at_once_and_accepts_nothing() {
    for mut bench in [ce100(), ce65()] {
        bench.position_at(4096 * 2048);
        bench.service(0xC200_0FFF);
        bench.service(0x8700_0000);
        bench.memory.break_all(CellFault::Write);
        assert_eq!(bench.data_check(), 0xA800_0082);
        assert_eq!(bench.position(), 0x2080_0000, "the old scaling");
        assert_eq!(bench.data_check(), 0xA800_0002, "again because it failed again");
        bench.memory.repair();
        assert_eq!(bench.data_check(), 0x8800_0000, "not told a second time");
        assert_eq!(bench.position(), 2048);
    }
}

// [R82, R87, R88, R92]
#[test]
fn the_bits_of_the_table_one_by_one() {
    let told = |mut bench: Bench, outs: &[u32]| {
        for out in outs {
            bench.service(*out);
        }
        bench.data_check() & 0xFFFF
    };
    for new in [ce100, ce65] {
        assert_eq!(told(new(), &[0xC800_0000]), 1 << 2);
        assert_eq!(told(new(), &[0x8600_0000]), 1 << 3);
        assert_eq!(told(new(), &[0x8000_0000]), 1 << 7);
        assert_eq!(told(new(), &[0xC300_0000]), 1 << 13);
        assert_eq!(told(new(), &[0xC300_0FFF]), 1 << 14);
        assert_eq!(told(new(), &[0xC300_0000, 0xC900_0063]), 1 << 13, "2^13 hides 2^14");
    }
    assert_eq!(told(ce100(), &[0xC400_0011, 0xC200_0010]), 1 << 8);
    assert_eq!(told(ce100(), &[0xC500_0011, 0xC200_0010]), 1 << 9);
    assert_eq!(told(ce100(), &[0xC400_0011, 0xC500_0011, 0xC200_0010, 0xC300_0000]), 0x2300);
}

// [R91]
#[test]
fn bits_8_and_9_do_not_exist_on_the_ce_65() {
    let mut bench = ce65();
    for out in [0xC400_FFFF, 0xC500_FFFF] {
        assert_eq!(bench.service(out), out | 1 << 29);
    }
    bench.service(0xC200_0010);
    assert_eq!(bench.data_check(), 0x8800_0080);
}

// [R95]
#[test]
fn the_la_66_leaves_no_status_bit_but_2_to_5() {
    let mut bench = la66();
    let faults = [0x8700_0000, 0x8600_0000, 0xC800_0000, 0xC200_0000, 0xC100_0002, 0x8300_0000, 0xC900_0000];
    for out in faults {
        assert_eq!(bench.service(out), out | 1 << 29);
        assert_eq!(bench.position(), 1 << 29, "an error without a name");
        assert_eq!(bench.data_check(), 0x8800_0000);
        assert_eq!(bench.position(), 0);
    }
    for fault in [CellFault::Read, CellFault::Write, CellFault::Stuck(0x5A)] {
        bench.memory.break_all(fault);
        bench.service(0x8100_0000);
        bench.service(0xC200_1234);
        bench.service(0xC600_1234);
        assert_eq!(bench.data_check(), 0x8800_0000, "{fault:?}");
        bench.memory.repair();
    }
    bench.terminals.magnet = Magnet::Missing;
    bench.service(0x8700_0000);
    assert_eq!(bench.data_check(), 0xA800_0020);
}

proptest! {
    #![proptest_config(cases(60))]

    // [R94]
    #[test]
    fn no_status_ever_leaves_the_mask_of_its_model(
        outs in prop::collection::vec(any::<u32>(), 1..40),
        cell in 0_usize..512,
        stuck in any::<u8>(),
    ) {
        for mut bench in every_model() {
            bench.memory.break_cell(cell, CellFault::Stuck(stuck));
            for out in &outs {
                bench.service(out | 1 << 31);
                let status = bench.data_check();
                prop_assert_eq!(status & 0xDFFF_0000, 0x8800_0000);
                prop_assert_eq!(status & 0xFFFF & !mask(bench.model()), 0);
            }
        }
    }
}

// [R142]
#[test]
fn speed_and_acceleration_beyond_every_limit_set_no_error() {
    for mut bench in [ce100(), ce65()] {
        for raw in [0, 1 << 40, -(1 << 40), 7, 1 << 23, 0] {
            assert_eq!(bench.position_at(raw) & 0xFF00_0000, 0);
        }
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

// [R24]
#[test]
fn in_normal_mode_the_upper_byte_is_00h_and_with_an_error_20h_until_the_data_check() {
    for bench in every_model() {
        // Unknown, refused, and a read of what is only written.
        for fault in [0x8700_0000, 0xC200_0000, 0x8600_0000] {
            let mut bench = bench.clone();
            let upper = |bench: &mut Bench| {
                let words = [0, 0x7FFF_FFFF, 0x2000_0000, 0x0800_0000, 0x4600_1234];
                words.map(|out| bench.exchange(out) >> 24)
            };
            assert_eq!(upper(&mut bench), [0x00; 5], "{}", bench.model());
            bench.service(fault);
            assert_eq!(upper(&mut bench), [0x20; 5], "{} after {fault:08X}", bench.model());
            bench.service(0x8200_0000);
            assert_eq!(upper(&mut bench), [0x20; 5], "a good service clears nothing");
            bench.data_check();
            assert_eq!(upper(&mut bench), [0x00; 5], "{} after the data check", bench.model());
        }
    }
}

#[test]
fn the_latched_status_is_what_the_next_data_check_tells() {
    for (mut bench, told) in every_model().into_iter().zip([0x0000, 0x008E, 0x008E, 0x008E]) {
        for out in [0x8700_0000, 0x8600_0000, 0xC800_0000, 0xC200_0000] {
            bench.service(out);
        }
        assert_eq!(bench.encoder.latched_status().bits(), told, "{}", bench.model());
        assert_eq!(bench.data_check(), 0x8800_0000 | u32::from(told));
        assert!(bench.encoder.latched_status().is_empty());
    }
}
