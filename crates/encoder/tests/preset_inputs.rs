//! The preset inputs: a second above 11 V, in normal mode.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, CellFault, MS, SECOND, ce65, ce100, la66};
use encoring_encoder::ServiceTimes;
use encoring_encoder::records::{Record, write_count};

const FIRST: u32 = 0x1111;
const SECOND_VALUE: u32 = 0x2222;

/// A CE-100-M with preset values 1111h and 2222h, its shaft at 5000h.
fn bench() -> Bench {
    let mut bench = ce100();
    bench.program(&[0xC400_0000 | FIRST, 0xC500_0000 | SECOND_VALUE]);
    assert_eq!(bench.position_at(0x5000), 0x5000);
    bench
}

/// One exchange so many nanoseconds after `start`, with the inputs at these millivolts.
fn seen(bench: &mut Bench, start: u64, nanos: u64, inputs: [u32; 2], out: u32) -> u32 {
    bench.now = start + nanos;
    bench.terminals.preset_mv = inputs;
    bench.exchange_now(out)
}

const OFF: [u32; 2] = [0, 0];
const ONE: [u32; 2] = [24_000, 0];
const TWO: [u32; 2] = [0, 24_000];
const BOTH: [u32; 2] = [24_000, 24_000];

// [R68, R69]
#[test]
fn the_input_must_be_energised_for_exactly_a_second() {
    for (inputs, value) in [(ONE, FIRST), (TWO, SECOND_VALUE)] {
        let mut bench = bench();
        let start = bench.now + MS;
        assert_eq!(seen(&mut bench, start, 0, inputs, 0), 0x5000);
        assert_eq!(seen(&mut bench, start, 999 * MS, inputs, 0), 0x5000);
        assert_eq!(seen(&mut bench, start, SECOND - 1, inputs, 0), 0x5000);
        assert_eq!(seen(&mut bench, start, SECOND, inputs, 0), value);
        assert_eq!(bench.power_cycle(), value, "and it is kept");
    }
}

#[test]
fn the_second_counts_from_the_first_exchange_that_sees_it() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, OFF, 0);
    // Energised right after that exchange, seen 40 ms later.
    assert_eq!(seen(&mut bench, start, 40 * MS, ONE, 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 1_039 * MS, ONE, 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 1_041 * MS, ONE, 0), FIRST);
}

#[test]
fn a_second_with_a_gap_is_none() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    seen(&mut bench, start, 500 * MS, OFF, 0);
    seen(&mut bench, start, 501 * MS, ONE, 0);
    assert_eq!(seen(&mut bench, start, 1_500 * MS, ONE, 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 1_501 * MS, ONE, 0), FIRST);
}

// [R69]
#[test]
fn one_activation_adjusts_once() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    assert_eq!(seen(&mut bench, start, SECOND, ONE, 0), FIRST);
    bench.turn_to(0x5001);
    for second in 2..10 {
        assert_eq!(seen(&mut bench, start, second * SECOND, ONE, 0), FIRST + 1);
    }
    seen(&mut bench, start, 10 * SECOND, OFF, 0);
    seen(&mut bench, start, 10 * SECOND + MS, ONE, 0);
    assert_eq!(seen(&mut bench, start, 11 * SECOND + MS, ONE, 0), FIRST);
}

/// The level that an input takes at `millivolts` after it was at `before`.
fn is_1_at(before: u32, millivolts: u32) -> bool {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, OFF, 0);
    seen(&mut bench, start, MS, [before, 0], 0);
    seen(&mut bench, start, 2 * MS, [millivolts, 0], 0);
    seen(&mut bench, start, 3 * SECOND, [millivolts, 0], 0) == FIRST
}

// [R71]
#[test]
fn below_8_v_is_0_above_11_v_is_1_and_between_nothing_changes() {
    let table = [
        (0, false, false),
        (7_990, false, false),
        (7_999, false, false),
        (8_000, false, true),
        (9_500, false, true),
        (11_000, false, true),
        (11_001, true, true),
        (11_010, true, true),
        (24_000, true, true),
        (30_000, true, true),
        (30_100, true, true),
    ];
    for (millivolts, from_0, from_1) in table {
        assert_eq!(is_1_at(0, millivolts), from_0, "{millivolts} mV after 0 V");
        assert_eq!(is_1_at(24_000, millivolts), from_1, "{millivolts} mV after 24 V");
    }
}

#[test]
fn only_level_0_arms_an_input_again_and_9_5_v_is_none() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    assert_eq!(seen(&mut bench, start, SECOND, ONE, 0), FIRST);
    bench.turn_to(0x6000);
    for (second, millivolts) in [(2, 9_500), (3, 24_000), (4, 8_000), (5, 11_001), (7, 24_000)] {
        assert_ne!(seen(&mut bench, start, second * SECOND, [millivolts, 0], 0), FIRST);
    }
    seen(&mut bench, start, 8 * SECOND, [7_999, 0], 0);
    seen(&mut bench, start, 9 * SECOND, [11_001, 0], 0);
    assert_eq!(seen(&mut bench, start, 10 * SECOND, [8_000, 0], 0), FIRST);
}

#[test]
fn an_input_that_is_1_at_power_up_waits_for_a_0() {
    let mut bench = bench();
    bench.terminals.preset_mv = ONE;
    assert_eq!(bench.power_cycle(), 0x5000);
    let start = bench.now;
    for second in 1..5 {
        assert_eq!(seen(&mut bench, start, second * SECOND, ONE, 0), 0x5000);
    }
    assert_eq!(seen(&mut bench, start, 5 * SECOND, [9_500, 0], 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 7 * SECOND, ONE, 0), 0x5000, "9.5 V was no 0");
    seen(&mut bench, start, 8 * SECOND, OFF, 0);
    seen(&mut bench, start, 9 * SECOND, ONE, 0);
    assert_eq!(seen(&mut bench, start, 10 * SECOND, ONE, 0), FIRST);
}

#[test]
fn between_the_levels_at_power_up_counts_as_0() {
    let mut bench = bench();
    bench.terminals.preset_mv = [9_500, 0];
    bench.power_cycle();
    let start = bench.now;
    assert_eq!(seen(&mut bench, start, 5 * SECOND, [9_500, 0], 0), 0x5000);
    seen(&mut bench, start, 6 * SECOND, ONE, 0);
    assert_eq!(seen(&mut bench, start, 7 * SECOND, ONE, 0), FIRST);
}

#[test]
fn the_value_of_the_accepted_set_counts_and_not_the_programmed_one() {
    let mut bench = bench();
    bench.service(0xC400_3333);
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    assert_eq!(seen(&mut bench, start, SECOND, ONE, 0), FIRST);
    assert_eq!(bench.data_check(), 0x8800_0000);
    let start = bench.now + MS;
    seen(&mut bench, start, 0, OFF, 0);
    seen(&mut bench, start, MS, ONE, 0);
    assert_eq!(seen(&mut bench, start, 2 * SECOND, ONE, 0), 0x3333);
}

// [R68]
#[test]
fn a_service_within_the_second_starts_it_anew() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    seen(&mut bench, start, 400 * MS, ONE, 0x8100_0000);
    assert_eq!(seen(&mut bench, start, 1_500 * MS, ONE, 0x8100_0000), 0x8100_0000);
    // The first normal-mode exchange after it.
    assert_eq!(seen(&mut bench, start, 1_600 * MS, ONE, 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 2_599 * MS, ONE, 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 2_600 * MS, ONE, 0), FIRST);
}

#[test]
fn busy_and_withdrawn_time_is_service_mode() {
    let mut bench = bench().rebuilt(|unit| unit.service_times = ServiceTimes::default());
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    // Requested before the second is over, withdrawn at once, completed 20 ms later.
    assert_eq!(seen(&mut bench, start, 990 * MS, ONE, 0x8800_0000), 0x5000);
    assert_eq!(seen(&mut bench, start, 1_000 * MS, ONE, 0), 0x5000, "busy");
    assert_eq!(seen(&mut bench, start, 1_010 * MS, ONE, 0), 0x8800_0000, "the reply");
    assert_eq!(seen(&mut bench, start, 1_011 * MS, ONE, 0), 0x5000, "the second begins here");
    assert_eq!(seen(&mut bench, start, 2_010 * MS, ONE, 0), 0x5000);
    assert_eq!(seen(&mut bench, start, 2_011 * MS, ONE, 0), FIRST);
}

#[test]
fn service_mode_does_not_arm_a_spent_input_but_a_0_during_it_does() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    assert_eq!(seen(&mut bench, start, SECOND, ONE, 0), FIRST);
    bench.turn_to(0x6000);
    seen(&mut bench, start, 2 * SECOND, ONE, 0x8100_0000);
    seen(&mut bench, start, 3 * SECOND, ONE, 0);
    assert_eq!(seen(&mut bench, start, 5 * SECOND, ONE, 0), FIRST + 0x1000);
    seen(&mut bench, start, 6 * SECOND, OFF, 0x8100_0000);
    seen(&mut bench, start, 7 * SECOND, ONE, 0x8100_0000);
    seen(&mut bench, start, 8 * SECOND, ONE, 0);
    assert_eq!(seen(&mut bench, start, 9 * SECOND, ONE, 0), FIRST);
}

#[test]
fn both_due_in_one_exchange_act_one_after_the_other() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, BOTH, 0);
    let written = write_count(&mut bench.memory, Record::Offset);
    assert_eq!(seen(&mut bench, start, SECOND, BOTH, 0), SECOND_VALUE, "preset 2 acts last");
    assert_eq!(write_count(&mut bench.memory, Record::Offset), written + 2, "preset 1 acted too");
}

#[test]
fn the_inputs_do_not_affect_one_another() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    seen(&mut bench, start, 600 * MS, BOTH, 0);
    assert_eq!(seen(&mut bench, start, 1_000 * MS, BOTH, 0), FIRST);
    assert_eq!(seen(&mut bench, start, 1_599 * MS, BOTH, 0), FIRST);
    assert_eq!(seen(&mut bench, start, 1_600 * MS, BOTH, 0), SECOND_VALUE);
}

#[test]
fn service_06_only_interrupts_the_second_as_any_service_does() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    seen(&mut bench, start, 100 * MS, ONE, 0xC600_7777);
    assert_eq!(seen(&mut bench, start, 101 * MS, ONE, 0), 0x7777);
    assert_eq!(seen(&mut bench, start, 1_100 * MS, ONE, 0), 0x7777);
    assert_eq!(seen(&mut bench, start, 1_101 * MS, ONE, 0), FIRST);
}

#[test]
fn a_stale_service_bit_at_power_up_does_not_hold_the_inputs_up() {
    let mut bench = bench();
    bench.power_off();
    bench.power_up();
    let start = bench.now;
    seen(&mut bench, start, 0, OFF, 0x8100_0000);
    seen(&mut bench, start, MS, ONE, 0x8100_0000);
    assert_eq!(seen(&mut bench, start, SECOND + MS, ONE, 0x8100_0000), FIRST);
}

#[test]
fn the_position_adjusted_is_that_of_the_sample_in_the_exchange() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    bench.turn_to(0x9000);
    assert_eq!(seen(&mut bench, start, SECOND, ONE, 0), FIRST);
    bench.turn_to(0x9002);
    assert_eq!(seen(&mut bench, start, SECOND + MS, ONE, 0), FIRST + 2);
}

#[test]
fn an_offset_that_cannot_be_stored_moves_nothing_and_is_2_to_1() {
    let mut bench = bench();
    let start = bench.now + MS;
    seen(&mut bench, start, 0, ONE, 0);
    bench.memory.break_all(CellFault::Write);
    assert_eq!(seen(&mut bench, start, SECOND, ONE, 0), 0x2000_5000);
    bench.memory.repair();
    assert_eq!(seen(&mut bench, start, 3 * SECOND, ONE, 0), 0x2000_5000, "one try an activation");
    seen(&mut bench, start, 4 * SECOND, OFF, 0);
    assert_eq!(bench.data_check(), 0x8800_0002);
    assert_eq!(bench.power_cycle(), 0x5000);
    seen(&mut bench, start, 5 * SECOND, ONE, 0);
    assert_eq!(seen(&mut bench, start, 6 * SECOND, ONE, 0), FIRST);
}

// [R66]
#[test]
fn the_la_66_has_one_input_and_takes_any_24_bit_value() {
    let mut bench = la66();
    bench.service(0xC4FE_DCBA);
    bench.turn_to(250_000);
    let start = bench.now + MS;
    seen(&mut bench, start, 0, TWO, 0);
    assert_eq!(seen(&mut bench, start, 2 * SECOND, TWO, 0), 25_000, "there is no second input");
    seen(&mut bench, start, 3 * SECOND, [11_001, 0], 0);
    assert_eq!(seen(&mut bench, start, 4 * SECOND - 1, ONE, 0), 25_000);
    assert_eq!(seen(&mut bench, start, 4 * SECOND, ONE, 0), 0xFE_DCBA);
    assert_eq!(bench.power_cycle(), 0xFE_DCBA);
}

// [R72]
#[test]
fn the_ce_65_has_none() {
    let mut bench = ce65();
    bench.turn_to(0x5000);
    let start = bench.now + MS;
    for second in 0..5 {
        assert_eq!(seen(&mut bench, start, second * SECOND, BOTH, 0), 0x5000);
    }
}
