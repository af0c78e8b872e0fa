//! When the shaft and the magnet are looked at.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, MS, US, cases, ce65, ce65_8192, ce100, every_model, la66};
use encoring_words::{Instant, Model};
use proptest::prelude::*;

/// Switches on again at an odd time, and gives that time.
fn switched_on(bench: &mut Bench) -> u64 {
    bench.turn_to(0);
    bench.advance(123_457);
    bench.power_off();
    bench.power_up();
    bench.now
}

/// The IN word so many nanoseconds after `start` with the shaft at `raw`.
fn seen(bench: &mut Bench, start: u64, nanos: u64, raw: i64) -> i64 {
    bench.now = start + nanos;
    bench.turn_to(raw);
    i64::from(bench.exchange_now(0))
}

// [R8]
#[test]
fn the_ce_100_looks_every_millisecond_since_power_up() {
    let mut bench = ce100();
    let start = switched_on(&mut bench);
    for tenth in 0..50 {
        let at = tenth * 100 * US;
        assert_eq!(seen(&mut bench, start, at, tenth as i64), tenth as i64 / 10 * 10);
    }
}

// [R9]
#[test]
fn the_ce_65_looks_every_half_millisecond_since_power_up() {
    for (mut bench, scale) in [(ce65(), 1), (ce65_8192(), 2)] {
        let start = switched_on(&mut bench);
        for tenth in 0..50 {
            let at = tenth * 100 * US;
            assert_eq!(seen(&mut bench, start, at, tenth as i64 * scale), tenth as i64 / 5 * 5);
        }
    }
}

#[test]
fn the_la_66_looks_every_millisecond_too() {
    let mut bench = la66();
    let start = switched_on(&mut bench);
    for tenth in 0..50 {
        let at = tenth * 100 * US;
        assert_eq!(seen(&mut bench, start, at, tenth as i64 * 10), tenth as i64 / 10 * 10);
    }
}

// [R9]
#[test]
fn two_readings_0_3_ms_apart_may_be_the_same() {
    let mut bench = ce65();
    let start = switched_on(&mut bench);
    assert_eq!(seen(&mut bench, start, 100 * US, 7), 0);
    assert_eq!(seen(&mut bench, start, 400 * US, 8), 0, "the same");
    assert_eq!(seen(&mut bench, start, 700 * US, 9), 9, "another");
    assert_eq!(seen(&mut bench, start, 900 * US, 10), 9);
}

#[test]
fn a_refresh_comes_exactly_at_its_multiple_and_a_nanosecond_before_it_not() {
    for (mut bench, refresh) in [(ce100(), MS), (ce65(), 500 * US)] {
        let start = switched_on(&mut bench);
        assert_eq!(seen(&mut bench, start, refresh - 1, 1), 0);
        assert_eq!(seen(&mut bench, start, refresh, 2), 2);
        assert_eq!(seen(&mut bench, start, refresh, 3), 2, "at the same moment there is no second one");
        assert_eq!(seen(&mut bench, start, 2 * refresh - 1, 4), 2);
        assert_eq!(seen(&mut bench, start, 2 * refresh, 5), 5);
    }
}

#[test]
fn after_missed_refreshes_the_grid_stays_that_of_power_up() {
    let mut bench = ce100();
    let start = switched_on(&mut bench);
    assert_eq!(seen(&mut bench, start, 900 * US, 1), 0);
    assert_eq!(seen(&mut bench, start, 7_300 * US, 2), 2, "told now, sampled now");
    assert_eq!(seen(&mut bench, start, 7_999 * US, 3), 2);
    assert_eq!(seen(&mut bench, start, 8_000 * US, 4), 4);
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn a_sample_is_taken_when_a_multiple_lies_between_two_moments(
        moments in prop::collection::vec((prop_oneof![0..3_000_000_u64, Just(500_000), Just(0)], 0..1000_i64), 1..60),
    ) {
        for mut bench in every_model() {
            let refresh = if bench.model() == Model::Ce65M { 500 * US } else { MS };
            let start = switched_on(&mut bench);
            let (mut time, mut sample) = (0, 0);
            for (pause, raw) in &moments {
                let before = time;
                time += pause;
                if time / refresh > before / refresh {
                    sample = *raw;
                }
                let expected = match bench.unit.sensor() {
                    encoring_words::model::Sensor::Linear { .. } => sample / 10,
                    encoring_words::model::Sensor::Rotary { steps_per_turn } => sample / i64::from(steps_per_turn / 4096),
                };
                prop_assert_eq!(seen(&mut bench, start, time, *raw), expected, "{}", bench.model());
            }
        }
    }
}

#[test]
fn an_ssi_edge_is_a_moment_too_and_both_interfaces_share_the_sample() {
    let mut bench = ce65();
    let start = switched_on(&mut bench);
    bench.now = start + 600 * US;
    bench.turn_to(0x1234);
    assert_eq!(bench.ssi_word(24), 0x1234);
    assert_eq!(seen(&mut bench, start, 990 * US, 0x4321), 0x1234, "the bus shows what the SSI edge saw");
    assert_eq!(seen(&mut bench, start, 1_000 * US, 0x4321), 0x4321);
    bench.now = start + 1_100 * US;
    bench.turn_to(0x7777);
    assert_eq!(bench.ssi_word(24), 0x4321, "the SSI sends what the bus saw");
}

#[test]
fn the_position_of_a_sample_follows_the_parameters_at_once() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(4096 * 10);
        bench.exchange(0);
        bench.service(0xC200_0FFF);
        let start = switched_on(&mut bench);
        assert_eq!(seen(&mut bench, start, MS, 4096 * 10), 10);
        // Everything below happens without a new sample.
        bench.turn_to(4096 * 3000);
        for out in [0xC100_0001, 0, 0x8800_0000, 0] {
            bench.advance(US);
            bench.exchange_now(out);
        }
        assert_eq!(bench.exchange_now(0), 0xFFF - 10, "direction");
        bench.exchange_now(0xC600_0FF0);
        assert_eq!(bench.exchange_now(0), 0xFF0, "preset");
    }
}

#[test]
fn time_never_runs_backwards() {
    for mut bench in [ce100(), ce65()] {
        let start = switched_on(&mut bench);
        assert_eq!(seen(&mut bench, start, 5 * MS, 50), 50);
        for earlier in [4 * MS, 2 * MS + 1, 0] {
            assert_eq!(seen(&mut bench, start, earlier, 99), 50, "an earlier time counts as the last one");
        }
        bench.now = 0;
        assert_eq!(bench.exchange_now(0), 50, "before power-up too");
        assert_eq!(seen(&mut bench, start, 5 * MS + 1, 98), 50);
        assert_eq!(seen(&mut bench, start, 6 * MS, 97), 97);
    }
}

#[test]
fn the_encoder_names_the_moment_of_the_last_refresh() {
    for (mut bench, refresh) in [(ce100(), MS), (ce65(), 500 * US), (la66(), MS)] {
        let start = switched_on(&mut bench);
        for nanos in [0, 1, refresh - 1, refresh, refresh + 1, 7 * refresh - 1, 7 * refresh] {
            let refreshed = start + nanos / refresh * refresh;
            assert_eq!(bench.encoder.refreshed_at(Instant(start + nanos)), Instant(refreshed));
        }
    }
}
