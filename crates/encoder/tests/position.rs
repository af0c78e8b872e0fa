//! From raw steps to positions, with presets, for any legal parameters.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::formula::{Rotary, rod_steps};
use common::{Bench, cases, ce65, ce65_8192, ce100, la66};
use encoring_encoder::position::{Offset, Scale};
use encoring_encoder::{ServiceTimes, Unit};
use encoring_words::model::Sensor;
use encoring_words::{Model, ParameterSet};
use proptest::prelude::*;

/// Legal values of a rotary encoder: S from 10h to as many steps as the rating plate allows.
fn legal() -> impl Strategy<Value = Rotary> {
    let ratio = prop_oneof![(1..=0xFFFF_i128, 1..=99_i128), (1..=20_i128, 1..=20_i128)];
    (prop_oneof![Just(4096_i128), Just(8192)], ratio, any::<bool>()).prop_flat_map(|(q, (n, d), falling)| {
        let largest = (q * n / d - 1).min(0xFF_FFFF);
        prop_oneof![Just(largest), Just(0x10), 0x10..=largest].prop_map(move |s| Rotary {
            q,
            s,
            n,
            d,
            falling,
        })
    })
}

fn raws() -> impl Strategy<Value = i64> {
    let far = 1_i64 << 62;
    prop_oneof![-far..far, -100_000_000..100_000_000_i64, -5000..5000_i64]
}

/// A CE-65-M that works with these values, and no preset yet.
fn bench(rotary: &Rotary) -> Bench {
    let mut bench = if rotary.q == 8192 { ce65_8192() } else { ce65() };
    bench.program(&rotary.writes());
    bench
}

/// A value between 0 and S.
fn share(rotary: &Rotary, share: u32) -> u32 {
    u32::try_from((i128::from(share) * (rotary.s + 1)) >> 32).unwrap()
}

proptest! {
    #![proptest_config(cases(300))]

    // [R23]
    #[test]
    fn any_raw_place_gives_the_value_of_the_formula(
        rotary in legal(),
        places in prop::collection::vec(raws(), 1..10),
    ) {
        let mut bench = bench(&rotary);
        for raw in places {
            let value = bench.position_at(raw);
            prop_assert_eq!(value, rotary.value(raw, 0));
            prop_assert!(i128::from(value) <= rotary.s);
        }
    }

    #[test]
    fn neighbouring_places_give_the_same_value_or_its_neighbour(rotary in legal(), start in raws()) {
        let mut bench = bench(&rotary);
        let modulo = u32::try_from(rotary.s + 1).unwrap();
        let mut last = bench.position_at(start);
        for raw in start + 1..start + 20 {
            let value = bench.position_at(raw);
            let (low, high) = if rotary.falling { (value, last) } else { (last, value) };
            let step = (high + modulo - low) % modulo;
            prop_assert!(step <= 1, "{} to {} at {}", last, value, raw);
            last = value;
        }
    }

    // [R59]
    #[test]
    fn the_range_ends_after_exactly_n_turns_and_d_rounds(rotary in legal(), raw in raws()) {
        let mut bench = bench(&rotary);
        let value = bench.position_at(raw);
        // N turns are D whole rounds, whatever the ratio.
        let turns = i64::try_from(rotary.range()).unwrap();
        prop_assert_eq!(bench.position_at(raw + turns), value);
        if rotary.n % rotary.d == 0 {
            let round = turns / i64::try_from(rotary.d).unwrap();
            prop_assert_eq!(bench.position_at(raw - round), value);
        }
    }

    // [R73]
    #[test]
    fn a_preset_lands_exactly_and_stays(
        rotary in legal(),
        raw in raws(),
        other in raws(),
        part in any::<u32>(),
    ) {
        let mut bench = bench(&rotary);
        let value = share(&rotary, part);
        bench.turn_to(raw);
        prop_assert_eq!(bench.service(0xC600_0000 | value), 0xC600_0000 | value);
        prop_assert_eq!(bench.position(), value);
        prop_assert_eq!(bench.data_check(), 0x8800_0000);
        prop_assert_eq!(bench.position(), value, "a data check neither undoes nor repeats it");
        prop_assert_eq!(bench.power_cycle(), value);
        let offset = rotary.preset(raw, value);
        prop_assert_eq!(bench.position_at(other), rotary.value(other, offset));
        let moved = i64::from(rotary.value(other, offset)) - i64::from(rotary.value(other, 0));
        let shift = bench.encoder.preset_shift();
        let beside = (moved - shift).rem_euclid(i64::try_from(rotary.s).unwrap() + 1);
        prop_assert!(beside <= 1, "moved by {}, told {}", moved, shift);
    }

    #[test]
    fn the_ends_of_the_range_can_be_preset_too(rotary in legal(), raw in raws()) {
        let mut bench = bench(&rotary);
        for value in [0, u32::try_from(rotary.s).unwrap()] {
            bench.turn_to(raw);
            bench.service(0xC600_0000 | value);
            prop_assert_eq!(bench.position(), value);
            // The smallest phase: one step back is the value before.
            let offset = rotary.preset(raw, value);
            for place in [raw - 1, raw, raw + 1] {
                prop_assert_eq!(bench.position_at(place), rotary.value(place, offset));
            }
        }
    }

    #[test]
    fn under_another_scaling_the_kept_offset_is_converted_from_the_preset_and_never_from_a_conversion(
        first in legal(),
        others in prop::collection::vec(legal(), 1..5),
        raw in raws(),
        place in raws(),
        part in any::<u32>(),
    ) {
        let mut bench = bench(&first);
        bench.turn_to(raw);
        let value = share(&first, part);
        bench.service(0xC600_0000 | value);
        let num = first.preset(raw, value);
        for (k, mut other) in others.into_iter().enumerate() {
            // The sensor stays; what is legal with 8192 steps a turn may not be with 4096.
            other.q = first.q;
            other.s = other.s.min(other.range() / other.d - 1);
            bench.program(&other.writes());
            if k % 2 == 1 {
                bench.power_cycle();
            }
            prop_assert_eq!(bench.position_at(place), other.value(place, num * other.d / first.d));
        }
        bench.program(&first.writes());
        prop_assert_eq!(bench.position_at(raw), value);
    }

    // [R49]
    #[test]
    fn a_rod_gives_the_value_of_the_formula_and_presets_land_modulo_2_to_24(
        rod_um in prop_oneof![10..=167_772_150_u32, 10..=1000_u32],
        s in prop_oneof![1..=0xFF_FFFF_u32, 1..=100_u32],
        decreasing in any::<bool>(),
        (first, second) in (any::<u32>(), any::<u32>()),
        value in 0..=0xFF_FFFF_u32,
    ) {
        let mut unit = Unit::new(Model::La66, Sensor::Linear { rod_um }).unwrap();
        unit.service_times = ServiceTimes::ZERO;
        let mut bench = Bench::new(unit);
        let rod = i64::from(rod_um);
        let place = |part: u32| (i64::from(part) * (rod + 1)) >> 32;
        let steps = |raw| rod_steps(raw, rod, s.into(), decreasing);
        bench.program(&[0xC100_0000 | u32::from(decreasing), 0xC200_0000 | s]);
        for raw in [0, 1, place(first), place(second), rod] {
            prop_assert_eq!(i64::from(bench.position_at(raw)), steps(raw));
        }
        bench.turn_to(place(first));
        prop_assert_eq!(bench.service(0xC600_0000 | value), 0xC600_0000 | value);
        prop_assert_eq!(bench.position(), value);
        prop_assert_eq!(bench.power_cycle(), value);
        let expected = (i64::from(value) + steps(place(second)) - steps(place(first))).rem_euclid(1 << 24);
        prop_assert_eq!(i64::from(bench.position_at(place(second))), expected);
        let shift = bench.encoder.preset_shift();
        prop_assert_eq!((steps(place(second)) + shift).rem_euclid(1 << 24), expected);
        prop_assert!(shift.abs() <= 1 << 23, "{}", shift);
    }
}

/// Every place of N turns: each of the S + 1 values comes, in order, D times round.
// [R59]
#[test]
fn no_value_is_skipped_and_none_is_out_of_order_over_whole_ranges() {
    for (s, n, d) in [
        (0x10, 1, 1),
        (4095, 1, 1),
        (4094, 1, 1),
        (0x10, 1, 99),
        (40, 1, 99),
        (8191, 2, 1),
        (1364, 1, 3),
        (5460, 4, 3),
        (999, 3, 5),
        (2456, 3, 5),
    ] {
        for falling in [false, true] {
            let rotary = Rotary { q: 4096, s, n, d, falling };
            let mut bench = bench(&rotary);
            let mut steps = 0_i128;
            let mut last = i128::from(bench.position_at(0));
            for raw in 1..=4096 * i64::try_from(n).unwrap() {
                let value = i128::from(bench.position_at(raw));
                if value != last {
                    let next = if falling { last + s } else { last + 1 } % (s + 1);
                    assert_eq!(value, next, "{rotary:?} at {raw}");
                    steps += 1;
                }
                last = value;
            }
            assert_eq!(steps, (s + 1) * d, "{rotary:?}");
        }
    }
}

// [R44]
#[test]
fn clockwise_rises_with_0_and_falls_with_1() {
    for mut bench in [ce100(), ce65()] {
        assert_eq!(
            [bench.position_at(10), bench.position_at(11), bench.position_at(-1)],
            [10, 11, 0xFF_FFFF]
        );
        bench.program(&[0xC100_0001]);
        assert_eq!(
            [bench.position_at(10), bench.position_at(11), bench.position_at(-1)],
            [0xFF_FFF5, 0xFF_FFF4, 0]
        );
    }
}

// [R42]
#[test]
fn towards_the_rods_end_increases_with_0_and_decreases_with_1() {
    let mut bench = la66();
    assert_eq!([bench.position_at(0), bench.position_at(20), bench.position_at(500_000)], [0, 2, 50_000]);
    bench.service(0xC100_0001);
    assert_eq!(
        [bench.position_at(0), bench.position_at(20), bench.position_at(500_000)],
        [50_000, 49_998, 0]
    );
}

// [R53]
#[test]
fn ten_turns_wrap_after_exactly_ten_turns() {
    for mut bench in [ce100(), ce65()] {
        bench.program(&[0xC200_270F, 0xC300_000A]);
        for turn in 0..30 {
            assert_eq!(i64::from(bench.position_at(turn * 4096)), turn % 10 * 1000);
            assert_eq!(i64::from(bench.position_at(turn * 4096 + 4095)), turn % 10 * 1000 + 999);
        }
    }
}

// [R62]
#[test]
fn three_and_a_half_turns_are_35_over_10() {
    let mut bench = ce65();
    bench.program(&[0xC200_37FF, 0xC300_0023, 0xC900_000A]);
    for raw in [0, 1, 14_335, 14_336, 14_337, 28_671, 28_672, -1] {
        assert_eq!(i64::from(bench.position_at(raw)), raw.rem_euclid(14_336));
    }
}

#[test]
fn an_integer_ratio_may_be_written_with_any_denominator() {
    let positions = |n: u32, d: u32| -> Vec<u32> {
        let mut bench = ce65();
        bench.program(&[0xC200_270F, 0xC300_0000 | n, 0xC900_0000 | d]);
        (-50..50).map(|k| bench.position_at(k * 777)).collect()
    };
    assert_eq!(positions(10, 1), positions(100, 10));
    assert_eq!(positions(10, 1), positions(990, 99));
}

// [R100]
#[test]
fn the_position_never_has_more_than_24_bits() {
    let mut bench = ce65_8192();
    bench.program(&[0xC300_0800]);
    assert_eq!(bench.position_at(8192 * 2048 - 1), 0xFF_FFFF, "13 bits a turn over 2048 turns");
    assert_eq!(bench.position_at(8192 * 2048), 0);
    assert_eq!(bench.position_at(8191), 8191);
}

#[test]
fn a_preset_acts_before_the_acknowledgement_and_needs_no_data_check() {
    for mut bench in [ce100(), ce65()] {
        bench.program(&[0xC200_270F]);
        bench.turn_to(4_000_000);
        assert_eq!(bench.exchange(0xC600_04D2), 0xC600_04D2);
        assert_eq!(bench.encoder.position(), 1234);
        assert_eq!(bench.exchange_now(0x4600_04D2), 1234);
        assert_eq!(bench.power_cycle(), 1234);
        assert_eq!(bench.data_check(), 0x8800_0000);
        assert_eq!(bench.position(), 1234);
    }
}

#[test]
fn a_change_of_direction_keeps_the_offset() {
    let mut bench = ce65();
    bench.turn_to(1000);
    bench.service(0xC600_0005);
    bench.program(&[0xC100_0001]);
    // Falling: -1 - 1000, and the offset 5 - 1000.
    assert_eq!(i64::from(bench.position()), (-1 - 1000 + 5 - 1000_i64).rem_euclid(1 << 24));
    bench.program(&[0xC100_0000]);
    assert_eq!(bench.position(), 5);
}

#[test]
fn a_rod_position_above_its_length_wraps_at_24_bits() {
    let mut bench = la66();
    bench.service(0xC6FF_FFFF);
    assert_eq!(bench.position(), 0xFF_FFFF);
    assert_eq!(bench.position_at(10), 0);
    assert_eq!(bench.position_at(500_000), 0xC34F);
    bench.turn_to(0);
    bench.service(0xC6C0_0000);
    bench.service(0xC200_0064);
    assert_eq!(bench.position(), 0xC0_0000, "the offset is in steps and stays");
    assert_eq!(bench.position_at(500_000), 0xC0_0064);
}

#[test]
fn an_offset_that_no_memory_gives_is_taken_as_it_is() {
    let sensor = Sensor::Rotary { steps_per_turn: 4096 };
    let active = ParameterSet::factory(Model::Ce65M, sensor);
    for denominator in [0, 1] {
        assert_eq!(Scale::new(sensor, &active, Offset { num: 100, denominator }).position(7), 107);
    }
}
