//! Programmed, accepted, active: when a written value begins to count.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, ce65, ce65_8192, ce100, every_model, la66};
use encoring_words::Model;

/// Makes a new device.
type New = fn() -> Bench;

/// Reads every parameter of the model: number and value.
fn values(bench: &mut Bench) -> Vec<(u32, u32)> {
    let numbers: &[u32] = match bench.model() {
        Model::La66 => &[1, 2, 4],
        Model::Ce100M => &[1, 2, 3, 4, 5, 9],
        Model::Ce65M => &[1, 2, 3, 9, 0xD],
    };
    numbers.iter().map(|n| (*n, bench.service(0x8000_0000 | n << 24) & 0xFF_FFFF)).collect()
}

#[test]
fn factory_values() {
    assert_eq!(values(&mut la66()), [(1, 0), (2, 0xC350), (4, 0)]);
    assert_eq!(values(&mut ce100()), [(1, 0), (2, 0xFF_FFFF), (3, 4096), (4, 0), (5, 0), (9, 1)]);
    for mut bench in [ce65(), ce65_8192()] {
        assert_eq!(values(&mut bench), [(1, 0), (2, 0xFF_FFFF), (3, 4096), (9, 1), (0xD, 0x18)]);
    }
}

#[test]
fn the_factory_position_is_the_raw_one() {
    for mut bench in [ce100(), ce65()] {
        for raw in [0, 1, 4096, 0xAB_CDEF, 0xFF_FFFF] {
            assert_eq!(i64::from(bench.position_at(raw)), raw);
        }
    }
    // 8192 steps and 4096 turns are 25 bits; the position has 24.
    let mut bench = ce65_8192();
    assert_eq!(bench.position_at(0x1FF_FFFF), 0xFF_FFFF);
    assert_eq!(bench.position_at(3), 1);
}

// [R79]
#[test]
fn the_old_parameters_work_until_the_data_check() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(0x12_3456);
        for out in [0xC200_0FFF, 0xC300_0800, 0xC100_0001, 0xC900_0002] {
            bench.service(out);
            assert_eq!(bench.position(), 0x12_3456);
        }
        assert_eq!(bench.service(0x8200_0000), 0x8200_0FFF, "read back is what was programmed");
        assert_eq!(bench.data_check(), 0x8800_0000);
        // Falling: -1 - 123456h, twice over 2048 turns, 4096 steps.
        let phase = (-1 - 0x12_3456_i64) * 2;
        assert_eq!(i64::from(bench.position()), phase.rem_euclid(4096 * 2048) * 4096 / (4096 * 2048));
    }
}

// [R80]
#[test]
fn without_a_data_check_the_new_parameters_work_from_the_next_power_up_on() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(4096 * 100);
        bench.service(0xC200_0FFF);
        assert_eq!(bench.position(), 4096 * 100);
        assert_eq!(bench.power_cycle(), 100);
        assert_eq!(bench.data_check(), 0x8800_0000);
        assert_eq!(bench.position(), 100);
    }
}

// [R81]
#[test]
fn several_parameters_switch_together_in_any_order() {
    let writes = [0xC200_37FF, 0xC300_0023, 0xC900_000A];
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for mut bench in [ce100(), ce65()] {
            bench.turn_to(14_336 * 7 + 4096);
            for k in order {
                assert_eq!(bench.service(writes[k]), writes[k], "no 2^14 in between");
                assert_eq!(bench.position(), 14_336 * 7 + 4096);
            }
            assert_eq!(bench.data_check(), 0x8800_0000);
            assert_eq!(bench.position(), 4096);
        }
    }
}

#[test]
fn a_data_check_that_finds_a_fault_accepts_nothing_at_all() {
    for mut bench in [ce100(), ce65()] {
        bench.program(&[0xC200_0FFF]);
        bench.turn_to(4096 * 100);
        bench.service(0xC200_1FFF);
        bench.service(0xC100_0001);
        bench.service(0xC300_0000);
        assert_eq!(bench.data_check(), 0xA800_2000);
        assert_eq!(bench.position(), 0x2000_0000 | 100, "old length, old direction, old numerator");
        assert_eq!(bench.service(0x8200_0000), 0xA200_1FFF, "what was programmed stays programmed");
        assert_eq!(bench.service(0x8100_0000), 0xA100_0001);
        assert_eq!(bench.service(0x8300_0000), 0xA300_0000);
        bench.service(0xC300_1000);
        assert_eq!(bench.data_check(), 0x8800_0000);
        assert_eq!(bench.position(), 0x1FFF - 200);
    }
}

#[test]
fn bad_parameters_are_not_taken_over_at_power_up() {
    for (bad, status) in [(0xC300_0000, 0x2000), (0xC300_0001, 0x4000)] {
        for mut bench in [ce100(), ce65()] {
            bench.program(&[0xC200_0FFF]);
            bench.turn_to(4096 * 100);
            bench.service(bad);
            bench.service(0xC200_1FFF);
            for _ in 0..2 {
                assert_eq!(bench.power_cycle(), 0x2000_0000 | 100, "the last accepted set");
            }
            let data = bad & 0xFF_FFFF;
            assert_eq!(bench.service(0x8300_0000), 0xA300_0000 | data);
            assert_eq!(bench.data_check(), 0xA800_0000 | status);
            bench.service(0xC300_1000);
            assert_eq!(bench.data_check(), 0x8800_0000);
            assert_eq!(bench.position(), 200);
        }
    }
}

#[test]
fn faults_found_at_power_up_are_not_latched() {
    for mut bench in [ce100(), ce65()] {
        bench.service(0xC300_0000);
        assert_eq!(bench.power_cycle(), 0x2000_0000);
        assert_eq!(bench.service(0xC300_1000), 0xE300_1000);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

#[test]
fn a_corrected_set_is_taken_over_at_power_up_without_a_check() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(4096 * 100);
        bench.service(0xC300_0000);
        assert_eq!(bench.data_check(), 0xA800_2000);
        bench.service(0xC300_0800);
        bench.service(0xC200_0FFF);
        assert_eq!(bench.power_cycle(), 200);
    }
}

#[test]
fn presets_above_the_length_keep_the_old_set_at_power_up() {
    let mut bench = ce100();
    bench.turn_to(4096 * 100);
    bench.service(0xC500_1000);
    bench.service(0xC200_0FFF);
    assert_eq!(bench.power_cycle(), 0x2000_0000 | (4096 * 100));
    assert_eq!(bench.data_check(), 0xA800_0200);
}

#[test]
fn on_the_la_66_a_write_counts_with_its_acknowledgement() {
    let mut bench = la66();
    bench.turn_to(250_000);
    assert_eq!(bench.position(), 25_000);
    assert_eq!(bench.service(0xC200_0064), 0xC200_0064);
    assert_eq!(bench.position(), 50);
    bench.turn_to(100_000);
    assert_eq!(bench.position(), 20);
    assert_eq!(bench.service(0xC100_0001), 0xC100_0001);
    assert_eq!(bench.position(), 80);
    assert_eq!(bench.data_check(), 0x8800_0000);
    assert_eq!(bench.position(), 80, "the check changes nothing");
    assert_eq!(bench.power_cycle(), 80);
}

#[test]
fn the_data_check_of_the_la_66_writes_nothing() {
    let mut bench = la66();
    bench.service(0xC200_0064);
    bench.service(0xC400_0123);
    let written = bench.memory.written();
    assert_eq!(bench.data_check(), 0x8800_0000);
    assert_eq!(bench.memory.written(), written);
}

// [R97]
#[test]
fn a_power_cycle_keeps_every_parameter() {
    let kept: [(New, &[u32]); 3] = [
        (la66, &[0xC100_0001, 0xC200_1234, 0xC4FE_DCBA]),
        (ce100, &[0xC100_0001, 0xC200_2710, 0xC300_0100, 0xC400_0007, 0xC500_2710, 0xC900_0063]),
        (ce65, &[0xC100_0101, 0xC200_2710, 0xC300_0100, 0xC900_0063, 0xCD00_0119]),
    ];
    for (new, writes) in kept {
        let mut bench = new();
        bench.program(writes);
        for _ in 0..3 {
            bench.power_cycle();
            for write in writes {
                assert_eq!(bench.service(write & 0xBF00_0000), write & 0xBFFF_FFFF);
            }
            assert_eq!(bench.data_check(), 0x8800_0000);
        }
    }
}

#[test]
fn a_refused_write_leaves_programmed_and_active_as_they_were() {
    for mut bench in every_model() {
        bench.turn_to(100_000);
        let position = bench.position();
        let before = values(&mut bench);
        let refused = if bench.model() == Model::La66 { 0xC200_0000 } else { 0xC200_000F };
        assert_eq!(bench.service(refused), refused | 1 << 29);
        assert_eq!(values(&mut bench), before);
        bench.data_check();
        assert_eq!(bench.position(), position);
        assert_eq!(bench.power_cycle(), position);
    }
}

// [R99]
#[test]
fn a_ratio_of_more_than_4096_turns_wraps_only_after_all_of_them() {
    let mut bench = ce100();
    bench.program(&[0xC200_FFFE, 0xC300_FFFF]);
    for turn in [0, 1, 4095, 4096, 65_533, 65_534] {
        assert_eq!(i64::from(bench.position_at(turn * 4096)), turn);
        assert_eq!(i64::from(bench.position_at(turn * 4096 + 4095)), turn);
    }
    assert_eq!(bench.position_at(65_535 * 4096), 0);
}
