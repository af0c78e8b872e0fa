//! Worked values: what 6000 rpm, 10^4 rad/s^2 and the ends of a rod allow, and what they do not.

use core::num::NonZeroU32;

use super::*;
use crate::validity::Why;

/// The data sheet's speed alone, and samples that are never old.
fn speed_alone(model: Model) -> Limits {
    Limits { acceleration_rad_s2: None, refresh: Duration::ZERO, ..sheet(model) }
}

/// The most steps that are valid after so many microseconds.
fn most(
    model: Model,
    steps_per_turn: u32,
    values: &[(Parameter, u32)],
    limits: Limits,
    after_us: u64,
) -> u32 {
    let sensor = Sensor::Rotary { steps_per_turn };
    let valid = |from: u32, to: u32| {
        let mut bench = Bench::new(model, sensor, values, limits);
        bench.poll(0, from);
        bench.poll(after_us, to).valid().is_some()
    };
    let steps = (0..100_000).take_while(|steps| valid(0, *steps)).count() as u32 - 1;
    assert!(valid(steps, 0) && !valid(steps + 1, 0), "the same downwards");
    steps
}

// [R124]
#[test]
fn at_6000_rpm_204_8_steps_pass_in_half_a_millisecond() {
    // Up to two more, for the step where it begins and the step where it ends.
    let (ce_65, ce_100) = (Model::Ce65M, Model::Ce100M);
    assert_eq!(most(ce_65, 4_096, &[], speed_alone(ce_65), 500), 206);
    assert_eq!(most(ce_100, 4_096, &[], speed_alone(ce_100), 1_000), 411);
    let fine = range(0xFF_FFFF, 2_048, 1);
    assert_eq!(most(ce_65, 8_192, &fine, speed_alone(ce_65), 500), 411);
    // Here a step is 4.096 of the sensor's: 50 steps, one and a quarter more.
    assert_eq!(most(ce_65, 4_096, &range(9_999, 10, 1), speed_alone(ce_65), 500), 51);
}

#[test]
fn the_age_of_a_sample_adds_to_the_time() {
    let mut limits = Limits { refresh: Duration::from_micros(500), ..speed_alone(Model::Ce65M) };
    assert_eq!(most(Model::Ce65M, 4_096, &[], limits, 500), 411);
    limits.cycle = Duration::from_micros(250);
    assert_eq!(most(Model::Ce65M, 4_096, &[], limits, 500), 514);
}

// [R142]
#[test]
fn torn_words_around_00ffff_are_caught() {
    for torn in [0x00_0000, 0x01_FFFF] {
        let mut bench = Bench::ce_65_m(Limits::of(Model::Ce65M, Duration::from_micros(263)));
        assert_eq!(bench.poll(0, 0xFFFF), Position::Valid(0xFFFF));
        assert!(matches!(bench.poll(1_000, torn), Position::Implausible(Why::Speed { .. })), "{torn:06X}");
        assert_eq!(bench.stops.len(), 1);
        assert_eq!(bench.poll(1_000, 0x1_0000), Position::Valid(0x1_0000));
    }
}

#[test]
fn a_torn_word_of_so_few_steps_per_turn_that_it_is_possible_is_not_caught() {
    // A whole turn has 17 steps.
    let mut bench = Bench::new(Model::Ce65M, Q4096, &range(16, 1, 1), sheet(Model::Ce65M));
    bench.poll(0, 0xF);
    assert_eq!(bench.poll(10_000, 0x0), Position::Valid(0));
}

// [R142]
#[test]
fn every_flip_of_a_bit_worth_more_than_the_shaft_can_turn_is_caught() {
    for bit in 9..24 {
        for value in [0x00_0000, 0x12_3456, 0xAB_CDEF, 0xFF_FFFF] {
            let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
            bench.poll(0, value);
            assert_eq!(bench.poll(500, value), Position::Valid(value));
            assert_eq!(bench.poll(500, value ^ 1 << bit).valid(), None, "bit {bit} of {value:06X}");
            assert_eq!(bench.poll(500, value), Position::Valid(value));
        }
    }
}

#[test]
fn the_wrap_is_no_jump_in_either_direction() {
    for (s, n, d) in [(9_999, 10, 1), (0xFF_FFFF, 4_096, 1), (9_999, 35, 10)] {
        let mut bench = Bench::new(Model::Ce65M, Q4096, &range(s, n, d), sheet(Model::Ce65M));
        for value in [s - 1, s, 0, 1, 0, s, s - 1] {
            assert_eq!(bench.poll(500, value), Position::Valid(value));
        }
    }
}

#[test]
fn when_half_of_the_range_can_be_travelled_between_two_polls_everything_is_possible() {
    // Ten turns: half of them take 50 ms.
    for (after_ms, valid) in [(40, false), (49, false), (50, true), (1_000, true)] {
        let mut bench = Bench::new(Model::Ce65M, Q4096, &range(9_999, 10, 1), sheet(Model::Ce65M));
        bench.poll(0, 0);
        assert_eq!(bench.poll(after_ms * 1_000, 5_000).valid().is_some(), valid, "{after_ms} ms");
    }
}

#[test]
fn after_a_service_a_fault_or_silence_speed_is_judged_over_the_whole_gap() {
    for word in [None, Some(0x8200_270F), Some(0x2000_0000)] {
        for (steps, valid) in [(4_096 * 10, true), (4_096 * 11, false)] {
            let mut bench = Bench::ce_65_m(Limits { acceleration_rad_s2: None, ..sheet(Model::Ce65M) });
            bench.poll(0, 0);
            for _ in 0..99 {
                bench.judge(1_000, word.map(|word| Seen { input: InWord(word), age: Duration::ZERO }));
            }
            assert_eq!(bench.poll(1_000, steps).valid().is_some(), valid, "{word:?} {steps}");
        }
    }
}

/// How long a shaft that turns at constant speed stays valid, polled every 250 us.
fn valid_polls(steps_per_s: u64) -> usize {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    (0..100_000_u64)
        .take_while(|k| bench.poll(250, (k * 250 * steps_per_s / 1_000_000) as u32).valid().is_some())
        .count()
}

#[test]
fn a_speed_that_is_only_a_little_too_high_is_found_when_it_has_made_up_for_the_refresh() {
    assert_eq!(valid_polls(409_600), 100_000);
    // 1 % too fast: 0.5 ms and two steps are gained in 51 ms.
    let polls = valid_polls(413_696);
    assert!((200..=210).contains(&polls), "{polls}");
    assert!(valid_polls(409_600 * 2) <= 5);
}

#[test]
fn steps_as_large_as_turns_are_judged_over_many_polls() {
    // 17 steps in 17 turns; a step takes 10 ms, and each poll sees one more.
    let mut bench = Bench::new(Model::Ce65M, Q4096, &range(16, 17, 1), sheet(Model::Ce65M));
    assert_eq!(bench.poll(0, 0), Position::Valid(0));
    assert_eq!(bench.poll(5_000, 1), Position::Valid(1));
    assert_eq!(bench.poll(5_000, 2), Position::Valid(2));
    assert_eq!(bench.poll(5_000, 3).valid(), None);
}

/// What becomes of a shaft that stands for 50 ms, then gains so many revolutions per second each second up to 6000 rpm,
/// polled every 500 us.
fn started(rev_s2: u64) -> Option<Why> {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    let full_us = 100 * 1_000_000 / rev_s2;
    for poll in 0..600_u64 {
        let us = (poll * 500).saturating_sub(50_000);
        let (rising, steady) = (us.min(full_us), us.saturating_sub(full_us));
        // Revolutions in 2 * 10^-12.
        let turned = rev_s2 * rising * rising + 2 * rev_s2 * full_us * steady;
        match bench.poll(500, (turned * 1_024 / 500_000_000_000) as u32) {
            Position::Valid(_) => {}
            Position::Implausible(why) => return Some(why),
            other => panic!("{other:?}"),
        }
    }
    None
}

// [R142]
#[test]
fn from_0_to_6000_rpm_takes_at_least_62_8_ms() {
    // 10^4 rad/s^2 are 1591.5 revolutions per second each second: 62.8 ms.
    assert_eq!(started(1_591), None);
    assert_eq!(started(1_000), None);
    for faster in [2_000, 2_500, 10_000, 1_000_000] {
        assert!(matches!(started(faster), Some(Why::Acceleration { .. } | Why::Speed { .. })), "{faster}");
    }
    assert!(matches!(started(2_500), Some(Why::Acceleration { .. })));
}

#[test]
fn a_shaft_at_rest_jumps_by_few_steps_at_most_in_the_next_poll() {
    let mut bench = Bench::ce_65_m(sheet(Model::Ce65M));
    for _ in 0..200 {
        bench.poll(500, 1_000);
    }
    let valid = |steps: u32| {
        bench
            .validity
            .clone()
            .judge(
                Instant(bench.now_ns + 500_000),
                Some(Seen { input: InWord(1_000 + steps), age: Duration::ZERO }),
                &mut |_| {},
            )
            .valid()
            .is_some()
    };
    // Half of 1591.5 revolutions/s^2 in 1 ms are 3.3 steps; the speed alone would allow 411.
    assert!(valid(5) && !valid(30));
}

fn rod(speed_mm_s: Option<u32>) -> Bench {
    let limits = Limits { speed_mm_s: speed_mm_s.and_then(NonZeroU32::new), ..sheet(Model::La66) };
    let mut bench = Bench::new(Model::La66, Sensor::Linear { rod_um: 500_000 }, &[], limits);
    // Whatever is held of a magnet that was gone is over after a refresh.
    for _ in 0..3 {
        bench.poll(1_000, 0xFF_FF00);
    }
    bench
}

#[test]
fn the_positions_of_a_rod_wrap_at_24_bits_and_span_its_measuring_length() {
    let mut bench = rod(None);
    // 50000 steps on the rod: 256 to where the positions begin again, and on.
    assert_eq!(bench.poll(1_000, 40_000), Position::Valid(40_000));
    let off = Why::OffTheRod { from: 40_000, to: 49_745, measuring_length: 50_000 };
    assert_eq!(bench.poll(1_000, 49_745), Position::Implausible(off));
    assert_eq!(bench.poll(1_000, 40_000), Position::Valid(40_000));
    assert_eq!(bench.poll(1_000, 49_744), Position::Valid(49_744));
    assert_eq!(bench.poll(1_000, 0xFF_FF00), Position::Valid(0xFF_FF00));
    assert_eq!(bench.poll(1_000, 0xFF_FEFF).valid(), None);
    assert_eq!(bench.poll(1_000, 0x7F_0000).valid(), None);
}

#[test]
fn a_magnet_has_the_speed_that_the_user_gives_it() {
    // 1 m/s is 100 steps of 0.01 mm in 1 ms; the sample may be 1 ms old.
    for (steps, valid) in [(150, true), (201, true), (202, false), (1_000, false)] {
        let mut bench = rod(Some(1_000));
        assert_eq!(bench.poll(1_000, 0xFF_FF00 - steps).valid().is_some(), valid, "{steps}");
    }
}

#[test]
fn steps_finer_than_a_micrometre_come_a_micrometre_at_a_time() {
    // 20 steps a micrometre. 1 mm/s is 40 steps in 2 ms, and 21 more for the places in one micrometre and one step.
    for (steps, valid) in [(61, true), (62, false)] {
        let limits = Limits { speed_mm_s: NonZeroU32::new(1), ..sheet(Model::La66) };
        let length = [(Parameter::MeasuringLength, 10_000_000)];
        let mut bench = Bench::new(Model::La66, Sensor::Linear { rod_um: 500_000 }, &length, limits);
        for _ in 0..4 {
            bench.poll(1_000, 1_000_000);
        }
        assert_eq!(bench.poll(1_000, 1_000_000 + steps).valid().is_some(), valid, "{steps}");
    }
}

#[test]
fn a_magnet_that_was_gone_is_held_until_the_next_sample_and_may_then_be_elsewhere() {
    let mut bench = rod(Some(1_000));
    for _ in 0..1_000 {
        assert_eq!(bench.poll(1_000, 0x20FF_FF00), Position::Faulty(None));
    }
    assert_eq!(bench.poll(1_000, 0x8800_0020), Position::InService);
    // Still the old sample, but the magnet has been on its way for a second.
    assert_eq!(bench.poll(100, 0xFF_FF00), Position::Valid(0xFF_FF00));
    assert_eq!(bench.poll(900, 40_000), Position::Valid(40_000));
    bench.poll(1_000, 40_000);
    bench.poll(1_000, 40_000);
    assert_eq!(bench.poll(1_000, 0xFF_FF00).valid(), None);
}
