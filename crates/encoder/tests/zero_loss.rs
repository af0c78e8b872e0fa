//! Where the shaft is found after it moved without supply.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, CellFault, MS, cases, ce65, ce65_8192, ce100};
use encoring_encoder::records::{Record, write_count};
use encoring_encoder::{Encoder, ZeroLoss};
use encoring_words::Instant;
use proptest::prelude::*;

/// 10 turns of 1000 steps: 4096 turns too many or too few are seen.
const TEN_TURNS: [u32; 3] = [0xC200_270F, 0xC300_000A, 0xC900_0001];

fn ten_turns(mut bench: Bench) -> Bench {
    bench.program(&TEN_TURNS);
    bench
}

/// The position of `steps` (of 4096 a turn) over ten turns.
fn right(steps: i64) -> u32 {
    u32::try_from(steps.rem_euclid(40_960) * 10_000 / 40_960).unwrap()
}

proptest! {
    #![proptest_config(cases(200))]

    // [R63]
    #[test]
    fn up_to_2048_turns_while_off_the_position_is_right(
        from in -(1_i64 << 60)..1_i64 << 60,
        travels in prop::collection::vec(prop_oneof![
            -8_388_607..=8_388_607_i64,
            Just(8_388_607),
            Just(-8_388_607),
        ], 1..6),
    ) {
        for bench in [ce100(), ce65()] {
            let mut bench = ten_turns(bench);
            let mut raw = from;
            prop_assert_eq!(bench.position_at(raw), right(raw));
            for travel in &travels {
                raw += travel;
                prop_assert_eq!(bench.power_cycle_moved_to(raw), right(raw));
            }
        }
    }

    #[test]
    fn beyond_2048_turns_it_comes_up_a_whole_round_of_4096_turns_off(
        from in -(1_i64 << 60)..1_i64 << 60,
        travel in 8_388_609..16_777_216_i64,
        backwards in any::<bool>(),
    ) {
        let mut bench = ten_turns(ce100());
        bench.position_at(from);
        let (raw, found) = if backwards {
            (from - travel, from - travel + 4096 * 4096)
        } else {
            (from + travel, from + travel - 4096 * 4096)
        };
        prop_assert_eq!(bench.power_cycle_moved_to(raw), right(found));
    }

    // [R63]
    #[test]
    fn the_worst_allowed_is_right_up_to_512_turns_and_one_round_against_the_travel_beyond(
        from in -(1_i64 << 60)..1_i64 << 60,
        travel in prop_oneof![-8_388_607..=8_388_607_i64, Just(2_097_152), Just(2_097_153), Just(-2_097_152), Just(-2_097_153)],
    ) {
        let mut bench = ten_turns(ce65()).rebuilt(|unit| unit.zero_loss = ZeroLoss::WorstAllowed);
        bench.position_at(from);
        let raw = from + travel;
        let lost = if travel.abs() <= 512 * 4096 { 0 } else { travel.signum() * 4096 * 4096 };
        prop_assert_eq!(bench.power_cycle_moved_to(raw), right(raw - lost));
    }

    #[test]
    fn with_8192_steps_a_turn_the_limits_are_turns_too(
        travel in prop_oneof![-16_777_215..=16_777_215_i64, Just(4_194_304), Just(4_194_305), Just(-4_194_304), Just(-4_194_305)],
    ) {
        let mut bench = ten_turns(ce65_8192());
        bench.position_at(12_345);
        prop_assert_eq!(bench.power_cycle_moved_to(12_345 + travel), right((12_345 + travel).div_euclid(2)));
        let mut bench = bench.rebuilt(|unit| unit.zero_loss = ZeroLoss::WorstAllowed);
        bench.position_at(12_345);
        let lost = if travel.abs() <= 512 * 8192 { 0 } else { travel.signum() * 4096 * 8192 };
        prop_assert_eq!(
            bench.power_cycle_moved_to(12_345 + travel),
            right((12_345 + travel - lost).div_euclid(2))
        );
    }
}

#[test]
fn the_reference_is_the_last_sample_and_not_the_shaft_at_power_off() {
    let mut bench = ten_turns(ce100());
    bench.position_at(0);
    // 1500 turns while on but unseen, and 1000 while off: 2500 since the last sample.
    bench.turn_to(4096 * 1500);
    assert_eq!(bench.power_cycle_moved_to(4096 * 2500), right(4096 * (2500 - 4096)));
}

#[test]
fn with_a_ratio_that_divides_4096_turns_a_wrong_count_is_not_seen() {
    for (s, n, d) in [(0xFF_FFFF, 4096, 1), (0x7F_FFFF, 2048, 1), (2047, 5, 10), (0xFFF, 4096, 3)] {
        let mut bench = ce100();
        bench.program(&[0xC200_0000 | s, 0xC300_0000 | n, 0xC900_0000 | d]);
        bench.position_at(0);
        let raw = 3000 * 4096 + 1234;
        let right = {
            let mut on = bench.clone();
            on.position_at(raw)
        };
        assert_eq!(bench.power_cycle_moved_to(raw), right, "{n}/{d}");
    }
}

#[test]
fn a_wrong_count_remains_and_shows_after_a_change_of_the_numerator() {
    let mut bench = ce100();
    let raw = 3000 * 4096;
    bench.position_at(0);
    assert_eq!(bench.power_cycle_moved_to(raw), 3000 * 4096, "not seen with 4096 turns");
    assert_eq!(bench.power_cycle(), 3000 * 4096);
    bench.program(&TEN_TURNS);
    assert_eq!(bench.position(), right(raw - 4096 * 4096), "but it is there");
    assert_eq!(bench.power_cycle(), right(raw - 4096 * 4096));
}

#[test]
fn a_new_device_is_found_nearest_to_0() {
    for (raw, found) in [(0, 0), (2047 * 4096, 2047 * 4096), (3000 * 4096, -1096 * 4096), (1 << 40, 0)] {
        let bench = ce100();
        let mut bench = Bench::with_memory(&bench.unit, bench.memory);
        bench.turn_to(raw);
        // It was never switched off regularly, so there is no last sample.
        bench.power_up();
        bench.exchange_now(0);
        let mut bench = ten_turns(bench);
        assert_eq!(bench.position(), right(found), "{raw}");
    }
}

#[test]
fn a_lost_count_is_2_to_0_and_nearest_to_0() {
    for zero_loss in [ZeroLoss::Nearest, ZeroLoss::WorstAllowed] {
        let mut bench = ten_turns(ce65()).rebuilt(|unit| unit.zero_loss = zero_loss);
        bench.position_at(4096 * 10_000);
        bench.power_off();
        // Only the record of the turn count is lost: its cells are those that change at power-off.
        let before = bench.memory.clone();
        let mut other = bench.clone();
        other.position_at(-77_777_777);
        other.power_off();
        other.position_at(123_456_789);
        other.power_off();
        for cell in 0..512 {
            if other.memory.image()[cell] != before.image()[cell] {
                bench.memory.break_cell(cell, CellFault::Stuck(0xFF));
            }
        }
        assert_eq!(write_count(&mut bench.memory, Record::TurnCount), 0, "lost");
        bench.power_up();
        // 10000 turns are 1808 more than two rounds.
        assert_eq!(bench.exchange_now(0), 0x2000_0000 | right(4096 * 1808));
        assert_eq!(bench.data_check(), 0x8800_0001);
        assert_eq!(bench.position(), right(4096 * 1808));
    }
}

#[test]
fn the_count_is_written_at_power_off_and_only_if_the_shaft_has_moved() {
    let mut bench = ce100();
    bench.power_cycle();
    let count = write_count(&mut bench.memory, Record::TurnCount);
    for raw in 0..50 {
        bench.position_at(raw);
    }
    assert_eq!(write_count(&mut bench.memory, Record::TurnCount), count, "not while on");
    bench.power_cycle();
    assert_eq!(write_count(&mut bench.memory, Record::TurnCount), count + 1);
    for _ in 0..5 {
        bench.power_cycle();
    }
    assert_eq!(write_count(&mut bench.memory, Record::TurnCount), count + 1, "equal values do not wear");
}

#[test]
fn a_supply_that_fails_without_the_reserve_leaves_the_older_count() {
    let mut bench = ten_turns(ce100());
    bench.position_at(4096 * 100);
    bench.power_cycle();
    bench.position_at(4096 * 3000);
    // No power-off: the memory never learnt of the 2900 turns.
    bench.advance(10 * MS);
    bench.encoder = Encoder::power_up(&bench.unit, Instant(bench.now), &bench.terminals, &mut bench.memory);
    assert_eq!(bench.exchange_now(0), right(4096 * (3000 - 4096)));
}

#[test]
fn exactly_2048_turns_while_off_count_as_clockwise_whichever_way_they_were() {
    for travel in [8_388_608, -8_388_608] {
        let mut bench = ten_turns(ce100());
        assert_eq!(bench.position_at(0), right(0));
        assert_eq!(bench.power_cycle_moved_to(travel), right(8_388_608));
    }
}
