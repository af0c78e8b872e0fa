//! What each word is called, when the user is told to stop, and what makes a position valid again.

use core::num::NonZeroU32;
use std::format;
use std::string::ToString;

use encoring_words::parameter::OutOfRange;
use encoring_words::{ErrorStatus, gray};
use proptest::prelude::*;

use super::*;
use crate::validity::{NoExpectation, Why};

fn stale(last: Option<u32>, ms: u64) -> Position {
    Position::Stale { last, age: Duration::from_millis(ms) }
}

// [R143]
#[test]
fn an_error_bit_takes_the_position_away_in_the_very_poll_and_the_stop_is_called_once() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    assert_eq!(bench.poll(1_000, 0x0000_1000), Position::Valid(0x1000));
    assert_eq!(bench.stops, []);
    assert_eq!(bench.poll(1_000, 0x2000_1000), Position::Faulty(None));
    assert_eq!(bench.stops, [Stop::Error(None)]);
    for _ in 0..500 {
        assert_eq!(bench.poll(1_000, 0x2000_1000).valid(), None);
    }
    assert_eq!(bench.poll(1_000, 0x0000_1000), Position::Valid(0x1000));
    assert_eq!(bench.stops.len(), 1);
    bench.poll(1_000, 0x2000_1000);
    assert_eq!(bench.stops.len(), 2);
}

// [R143]
#[test]
fn the_stop_is_called_for_an_error_in_the_first_poll_of_all_and_in_a_reply() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    assert_eq!(bench.poll(0, 0x2000_0000), Position::Faulty(None));
    assert_eq!(bench.stops, [Stop::Error(None)]);
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    bench.poll(0, 0);
    assert_eq!(bench.poll(1_000, 0xA700_0000), Position::Faulty(None));
    assert_eq!(bench.stops, [Stop::Error(None)]);
}

// [R141]
#[test]
fn a_fault_carries_the_status_that_a_data_check_told_of_it_until_it_is_gone() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    let numerator_zero = Position::Faulty(Some(ErrorStatus::NUMERATOR_ZERO));
    for (word, position) in [
        (0xE300_0000, Position::Faulty(None)),
        (0x2000_0000, Position::Faulty(None)),
        (0xA800_2000, numerator_zero),
        (0x2000_0000, numerator_zero),
        (0xE300_000A, numerator_zero),
        (0x8800_0000, Position::InService),
        (0x0000_0000, Position::Valid(0)),
        (0x2000_0000, Position::Faulty(None)),
        // An error that is over shows once as status alone.
        (0x8800_0080, Position::InService),
        (0x0000_0000, Position::Valid(0)),
    ] {
        assert_eq!(bench.poll(1_000, word), position, "{word:08X}");
    }
}

#[test]
fn a_reply_is_never_a_position() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    assert_eq!(bench.poll(0, 0x0000_1234), Position::Valid(0x1234));
    for reply in [0xC200_270F, 0x8200_270F, 0x8800_0000, 0xC600_0000] {
        assert_eq!(bench.poll(1_000, reply), Position::InService, "{reply:08X}");
    }
    assert_eq!(bench.poll(1_000, 0x0000_1234), Position::Valid(0x1234));
    // The same data without the service bit would have been a jump.
    assert_eq!(bench.poll(1_000, 0x0000_270F).valid(), None);
    assert_eq!(bench.stops.len(), 1);
}

#[test]
fn bits_that_no_encoder_sets_are_foreign() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    bench.poll(0, 0x0000_1234);
    for word in [0x0100_1234, 0x0800_1234, 0x1000_1234, 0x4000_1234, 0x6000_1234, 0x9200_270F, 0xFFFF_FFFF] {
        let why = Why::Foreign(InWord(word));
        assert_eq!(bench.poll(1_000, word), Position::Implausible(why), "{word:08X}");
        assert_eq!(why.to_string(), format!("IN {word:08X} has bits that no encoder sets"));
    }
    assert_eq!(bench.stops, [Stop::Implausible(Why::Foreign(InWord(0x0100_1234)))]);
    assert_eq!(bench.poll(1_000, 0x0000_1234), Position::Valid(0x1234));
}

#[test]
fn a_bus_stuck_at_1_has_no_position_and_one_stuck_at_0_is_found_when_the_shaft_was_elsewhere() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    assert_eq!(bench.poll(0, u32::MAX).valid(), None);
    assert_eq!(bench.poll(1_000, 0x0012_3456), Position::Valid(0x12_3456));
    for _ in 0..1_000 {
        assert_eq!(bench.poll(1_000, 0).valid(), None);
    }
}

#[test]
fn a_position_above_the_measuring_length_is_out_of_range() {
    let mut bench = Bench::new(Model::Ce100M, Q4096, &range(9_999, 10, 1), sheet(Model::Ce100M));
    assert_eq!(bench.poll(0, 9_999), Position::Valid(9_999));
    let range = Why::Range { value: 10_000, measuring_length: 9_999 };
    assert_eq!(bench.poll(1_000, 10_000), Position::Implausible(range));
    assert_eq!(bench.poll(1_000, 0), Position::Valid(0));
}

#[test]
fn gray_code_is_undone_before_anything_is_judged() {
    let mut values = range(9_999, 10, 1).to_vec();
    values.push((Parameter::CountingDirection, 0x100));
    let mut bench = Bench::new(Model::Ce65M, Q4096, &values, sheet(Model::Ce65M));
    assert_eq!(bench.poll(0, gray::encode(9_999)), Position::Valid(9_999));
    assert_eq!(bench.poll(1_000, gray::encode(0)), Position::Valid(0));
    assert_eq!(bench.poll(1_000, gray::encode(9_999)), Position::Valid(9_999));
    // Read between two of the five bits that change there: 3488h, 0000h.
    assert_eq!(gray::encode(9_999), 0x3488);
    for torn in [0x2488, 0x3088, 0x1488, 0x3400] {
        assert_eq!(bench.poll(1_000, torn).valid(), None, "{torn:04X} is {}", gray::decode(torn));
        assert_eq!(bench.poll(1_000, gray::encode(0)), Position::Valid(0));
    }
    // Replies are never in Gray code, and no other model has one.
    assert_eq!(bench.poll(1_000, 0x8200_270F), Position::InService);
    let mut bench = Bench::new(Model::Ce100M, Q4096, &values, sheet(Model::Ce100M));
    assert_eq!(bench.poll(0, 9_999), Position::Valid(9_999));
}

#[test]
fn a_position_is_stale_when_its_word_is_too_old_and_the_stop_is_called_once() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    assert_eq!(bench.nothing(0), stale(None, 0));
    assert_eq!(bench.stops, []);
    assert_eq!(bench.poll(1_000, 0x1000), Position::Valid(0x1000));
    assert_eq!(bench.nothing(100_000), Position::Valid(0x1000));
    assert_eq!(bench.nothing(1_000), stale(Some(0x1000), 101));
    assert_eq!(bench.stops, [Stop::Stale { age: Duration::from_millis(101) }]);
    assert_eq!(bench.nothing(1_000), stale(Some(0x1000), 102));
    assert_eq!(bench.stops.len(), 1);
    assert_eq!(bench.poll(1_000, 0x1000), Position::Valid(0x1000));
    // A word that was old when it came.
    let old = |ms| Some(Seen { input: InWord(0x1000), age: Duration::from_millis(ms) });
    assert_eq!(bench.judge(200_000, old(100)), Position::Valid(0x1000));
    assert_eq!(bench.nothing(1_000), stale(Some(0x1000), 101));
    assert_eq!(bench.judge(100_000, old(150)), stale(Some(0x1000), 150));
    // It cannot be older than what was seen before.
    assert_eq!(bench.judge(1_000, old(1_000)), stale(Some(0x1000), 151));
    assert_eq!(bench.stops.len(), 2);
}

#[test]
fn without_any_word_it_is_stale_and_the_stop_is_called_when_the_limit_has_passed() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    assert_eq!(bench.nothing(5_000), stale(None, 0));
    assert_eq!(bench.nothing(100_000), stale(None, 100));
    assert_eq!(bench.stops, []);
    assert_eq!(bench.nothing(1_000), stale(None, 101));
    assert_eq!(bench.stops.len(), 1);
}

#[test]
fn a_fault_and_an_implausible_word_stay_while_nothing_comes_and_a_service_grows_stale() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    bench.poll(0, 0x2000_0000);
    assert_eq!(bench.nothing(500_000), Position::Faulty(None));
    bench.poll(0, 0x4000_0000);
    assert_eq!(bench.nothing(500_000), Position::Implausible(Why::Foreign(InWord(0x4000_0000))));
    bench.poll(0, 0xC200_270F);
    assert_eq!(bench.nothing(1_000), Position::InService);
    assert_eq!(bench.nothing(500_000), stale(None, 501));
}

// [R143]
#[test]
fn the_stop_is_called_for_each_of_the_three_reasons_once() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    bench.poll(0, 0);
    for _ in 0..3 {
        bench.poll(1_000, 0x2000_0000);
        bench.poll(1_000, 0x4000_0000);
        bench.poll(1_000, 0x8200_0000);
        bench.nothing(500_000);
    }
    let foreign = Stop::Implausible(Why::Foreign(InWord(0x4000_0000)));
    let old = Stop::Stale { age: Duration::from_millis(500) };
    assert_eq!(bench.stops, [Stop::Error(None), foreign, old]);
}

/// The zero of 10 turns of 1000 steps is lost by 6 turns [C29].
fn with_a_lost_zero() -> Bench {
    let mut bench = Bench::new(Model::Ce65M, Q4096, &range(9_999, 10, 1), sheet(Model::Ce65M));
    assert_eq!(bench.poll(0, 1_234), Position::Valid(1_234));
    bench.nothing(10_000);
    bench
}

// [R142]
#[test]
fn a_zero_that_was_lost_by_6_turns_is_caught_and_does_not_heal_with_time() {
    let mut bench = with_a_lost_zero();
    let within = Duration::from_micros(11_500);
    let speed = Why::Speed { from: 1_234, to: 7_234, within };
    assert_eq!(bench.poll(1_000, 7_234), Position::Implausible(speed));
    assert_eq!(speed.to_string(), "nothing permissible moves from 1234 to 7234 within 11.5 ms");
    assert_eq!(bench.stops, [Stop::Implausible(speed)]);
    // After 60 ms a shaft could have got there.
    for _ in 0..1_000 {
        assert_eq!(bench.poll(1_000, 7_234), Position::Implausible(speed));
    }
    bench.validity.rebase();
    assert_eq!(bench.nothing(1_000), stale(None, 1));
    assert_eq!(bench.poll(1_000, 7_235), Position::Valid(7_235));
    assert_eq!(bench.stops.len(), 1);
}

/// A shaft that turns a turn of 4096 steps in 100 ms, whose word is stuck elsewhere from 1 s to `until_ms`.
fn with_a_stuck_word(stuck: u32, until_ms: u32) -> (Bench, u32) {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    let place = |ms: u32| 0x10_0000 + ms * 4_096 / 100;
    for ms in (0..1_000).step_by(10) {
        assert_eq!(bench.poll(10_000, place(ms)), Position::Valid(place(ms)));
    }
    for _ in (1_000..until_ms).step_by(10) {
        assert_eq!(bench.poll(10_000, stuck).valid(), None);
    }
    (bench, place(until_ms))
}

#[test]
fn a_word_that_was_stuck_elsewhere_is_over_when_the_position_is_where_the_shaft_can_have_turned_to() {
    // For 9 s a shaft cannot have travelled half of the 4096 turns.
    for until_ms in [1_010, 1_500, 10_000] {
        let (mut bench, place) = with_a_stuck_word(0x80_0000, until_ms);
        assert_eq!(bench.poll(10_000, place), Position::Valid(place), "{until_ms}");
        assert!(!bench.validity.has_jumped());
        assert_eq!(bench.poll(10_000, place + 410), Position::Valid(place + 410));
    }
}

#[test]
fn a_word_that_was_stuck_is_not_over_where_the_shaft_cannot_be_or_could_be_anywhere() {
    // 100 turns a second are the limit.
    let (mut bench, place) = with_a_stuck_word(0x80_0000, 1_500);
    assert_eq!(bench.poll(10_000, place + 70 * 4_096).valid(), None);
    assert!(bench.validity.has_jumped());
    // After 21 s whatever came would be possible.
    let (mut bench, place) = with_a_stuck_word(0x80_0000, 22_000);
    assert_eq!(bench.poll(10_000, place).valid(), None);
}

#[test]
fn a_shaft_at_rest_that_shows_one_wrong_place_after_the_other_stays_implausible() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    for _ in 0..100 {
        assert_eq!(bench.poll(10_000, 0x10_0000), Position::Valid(0x10_0000));
    }
    for wrong in [1_000, 4, 8].map(|turns| 0x10_0000 + turns * 4_096) {
        for _ in 0..100 {
            assert_eq!(bench.poll(10_000, wrong).valid(), None);
        }
    }
    assert_eq!(bench.poll(10_000, 0x10_0000), Position::Valid(0x10_0000));
}

#[test]
fn a_single_wrong_word_is_over_with_the_next_right_one() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    for (word, valid) in [
        (0x10_0000, true),
        (0x10_0000, true),
        (0x20_0000, false),
        (0x10_0000, true),
        (0x00_0000, false),
        (0x80_0000, false),
        (0x10_0001, true),
    ] {
        assert_eq!(bench.poll(1_000, word).valid().is_some(), valid, "{word:06X}");
    }
    // So little that only its suddenness gives it away.
    for _ in 0..100 {
        bench.poll(500, 0x10_0001);
    }
    let sudden = Why::Acceleration { from: 0x10_0001, to: 0x10_0101 };
    assert_eq!(bench.poll(500, 0x10_0101), Position::Implausible(sudden));
    assert_eq!(bench.poll(500, 0x10_0001), Position::Valid(0x10_0001));
}

#[test]
fn a_preset_adjustment_is_a_jump_for_a_good_reason() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    bench.poll(0, 0x12_3456);
    assert_eq!(bench.poll(10_000, 0xC600_0000), Position::InService);
    bench.validity.rebase();
    assert_eq!(bench.nothing(500), Position::InService);
    assert_eq!(bench.poll(500, 3), Position::Valid(3));
    assert_eq!(bench.stops, []);
}

#[test]
fn other_active_values_are_another_expectation() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    bench.poll(0, 0x12_3456);
    let active = set(Q4096, &range(9_999, 10, 1));
    bench.validity.expect(Expectation::new(Model::Ce65M, Q4096, &active).unwrap());
    assert_eq!(bench.poll(1_000, 0x12_3456).valid(), None);
    assert_eq!(bench.poll(1_000, 42), Position::Valid(42));
}

#[test]
fn nothing_is_expected_of_what_no_encoder_takes() {
    let refused =
        |model, sensor, values: &[_]| Expectation::new(model, sensor, &set(sensor, values)).unwrap_err();
    let rod = Sensor::Linear { rod_um: 500_000 };
    for (model, sensor) in
        [(Model::La66, Q4096), (Model::Ce65M, rod), (Model::La66, Sensor::Linear { rod_um: 0 })]
    {
        assert_eq!(refused(model, sensor, &[]), NoExpectation::Sensor { model, sensor });
    }
    let parameter = |parameter, value, low, high| NoExpectation::Parameter {
        parameter,
        refused: OutOfRange { value, low, high },
    };
    let length = parameter(Parameter::MeasuringLength, 15, 16, 0xFF_FFFF);
    assert_eq!(refused(Model::Ce65M, Q4096, &range(15, 10, 1)), length);
    assert_eq!(length.to_string(), "MeasuringLength: Fh is outside 10h..FFFFFFh");
    let denominator = parameter(Parameter::Denominator, 0, 1, 99);
    assert_eq!(refused(Model::Ce65M, Q4096, &range(99, 10, 0)), denominator);
    let zero = NoExpectation::Set(ErrorStatus::NUMERATOR_ZERO);
    assert_eq!(refused(Model::Ce65M, Q4096, &range(99, 0, 1)), zero);
    let large = NoExpectation::Set(ErrorStatus::LENGTH_TOO_LARGE);
    assert_eq!(refused(Model::Ce65M, Q4096, &range(4_096, 1, 1)), large);
    assert_eq!(large.to_string(), "the data check would refuse the set with status 4000h");
    assert!(Expectation::new(Model::Ce65M, Q4096, &set(Q4096, &range(4_095, 1, 1))).is_ok());
}

proptest! {
    // [R141]
    #[test]
    fn no_word_but_a_position_without_error_in_its_range_is_ever_valid(
        words in proptest::collection::vec((0..5_000_u64, any::<u32>(), 0..12_u32), 1..200),
        largest in 0x10..=0xFF_FFFF_u32,
    ) {
        let mut bench = Bench::new(Model::Ce65M, Q4096, &range(largest, 4_096, 1), sheet(Model::Ce65M));
        for (after_us, word, zeros) in words {
            let word = word & u32::MAX >> zeros;
            match bench.poll(after_us, word) {
                Position::Valid(value) => {
                    prop_assert_eq!(value, word);
                    prop_assert!(value <= largest);
                }
                Position::InService => prop_assert_eq!(word >> 29 & 5, 4),
                Position::Faulty(_) => prop_assert_eq!(word >> 29 & 1, 1),
                Position::Implausible(_) => {}
                Position::Stale { .. } => prop_assert!(false, "a word came"),
            }
        }
    }

    #[test]
    fn no_time_age_or_limit_is_too_large(
        polls in proptest::collection::vec((any::<u64>(), any::<u32>(), any::<u64>(), any::<bool>()), 1..50),
        (speed, acceleration, refresh, cycle) in (any::<u32>(), any::<u32>(), any::<u64>(), any::<u64>()),
        (steps_per_turn, n, d) in (1..=u32::MAX, 1..=0xFFFF_u32, 1..=99_u32),
    ) {
        let limits = Limits {
            speed_rpm: NonZeroU32::new(speed),
            acceleration_rad_s2: NonZeroU32::new(acceleration),
            speed_mm_s: NonZeroU32::new(speed),
            acceleration_mm_s2: NonZeroU32::new(acceleration),
            refresh: Duration(refresh),
            cycle: Duration(cycle),
            ..sheet(Model::Ce65M)
        };
        let shaft = Sensor::Rotary { steps_per_turn };
        let rod = Sensor::Linear { rod_um: steps_per_turn };
        for (model, sensor) in [(Model::Ce65M, shaft), (Model::La66, rod)] {
            let Ok(expectation) = Expectation::new(model, sensor, &set(sensor, &range(0xFF_FFFF, n, d))) else { continue };
            let mut validity = Validity::new(expectation, limits);
            for (now, word, age, came) in &polls {
                let seen = Seen { input: InWord(*word & 0xFF_FFFF), age: Duration(*age) };
                validity.judge(Instant(*now), came.then_some(seen), &mut |_| {});
            }
        }
    }
}
