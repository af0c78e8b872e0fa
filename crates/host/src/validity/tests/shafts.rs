//! Shafts at random: those within their limits are valid whatever the polls, and what is valid can be so.

use encoring_words::gray;
use encoring_words::parameter::Code;
use proptest::collection::vec;
use proptest::prelude::*;

use super::*;

/// A shaft that moves with piecewise constant acceleration, exactly. Turns are counted in 1 / (2 * 10^21).
#[derive(Clone, Copy)]
struct Shaft {
    at_ns: i128,
    turned: i128,
    /// Revolutions per second in 10^-12.
    speed: i128,
}

const TURN: i128 = 2 * 10_i128.pow(21);
/// 6000 rpm.
const FASTEST: i128 = 100 * 10_i128.pow(12);
/// 10^4 rad/s^2 in thousandths of a revolution/s^2, rounded down.
const SUDDENEST: i128 = 1_591_549;

impl Shaft {
    /// Goes on to a time with an acceleration in thousandths of a revolution/s^2, as far as the speed allows.
    fn go_on(&mut self, until_ns: i128, acceleration: i128) {
        let time = until_ns - self.at_ns;
        let to_fastest = (FASTEST - self.speed * acceleration.signum()) / acceleration.abs().max(1);
        let changing = if acceleration == 0 { 0 } else { time.min(to_fastest) };
        self.turned += 2 * self.speed * changing + acceleration * changing * changing;
        self.speed += acceleration * changing;
        self.turned += 2 * self.speed * (time - changing);
        self.at_ns = until_ns;
        assert!(self.speed.abs() <= FASTEST);
    }
}

/// One poll, and how the shaft was driven before it.
#[derive(Clone, Copy, Debug)]
struct Poll {
    after_ns: i128,
    acceleration: i128,
    /// Of the ring's cycle and of the bus's age, in thousandths.
    ring: i128,
    /// Of the refresh time, in thousandths; from 1000 on, the encoder's own pace.
    refresh: i128,
    age_ns: i128,
    brings: Brings,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Brings {
    Position,
    Reply,
    Nothing,
}

fn polls() -> impl Strategy<Value = Vec<Poll>> {
    let after = prop_oneof![1..3_000_000_i128, 100_000..600_000_i128, Just(500_000), 1..200_000_000_i128];
    let acceleration = prop_oneof![
        3 => Just(SUDDENEST),
        3 => Just(-SUDDENEST),
        2 => Just(0),
        2 => -SUDDENEST..=SUDDENEST,
    ];
    let brings =
        prop_oneof![20 => Just(Brings::Position), 1 => Just(Brings::Reply), 1 => Just(Brings::Nothing)];
    let age = prop_oneof![Just(0), 0..2_000_000_i128];
    // Runs of equal acceleration, so that full speed is reached.
    let run = (acceleration, vec((after, 0..=1_000_i128, 0..2_000_i128, age, brings), 1..40));
    vec(run, 1..8).prop_map(|runs| {
        let poll = |acceleration, (after_ns, ring, refresh, age_ns, brings)| Poll {
            after_ns,
            acceleration,
            ring,
            refresh,
            age_ns,
            brings,
        };
        let of_run = |(acceleration, polls): (i128, Vec<_>)| {
            polls.into_iter().map(move |times| poll(acceleration, times))
        };
        runs.into_iter().flat_map(of_run).collect()
    })
}

/// Sensor, S, N, D.
fn scalings() -> impl Strategy<Value = (u32, u32, u32, u32)> {
    let numerator = prop_oneof![1..=0xFFFF_u32, 1..=100_u32, Just(4_096)];
    (prop_oneof![Just(4_096_u32), Just(8_192)], numerator, prop_oneof![1..=99_u32, Just(1)], any::<u32>())
        .prop_filter_map("too few positions", |(native, n, d, any)| {
            let most = (native * n / d).min(0x100_0000);
            (most >= 17).then(|| (native, if any % 3 == 0 { most } else { 17 + any % (most - 16) } - 1, n, d))
        })
}

/// The manuals' formula once more.
fn shown(raw: i128, (native, s, n, d): (u32, u32, u32, u32), falling: bool, offset: i128) -> u32 {
    let phases = i128::from(native) * i128::from(n);
    let raw = if falling { -1 - raw } else { raw };
    let phase = (raw * i128::from(d) + offset).rem_euclid(phases);
    (phase * (i128::from(s) + 1) / phases) as u32
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    // [R124, R142]
    #[test]
    fn a_shaft_within_its_limits_is_valid_whenever_it_is_looked_at(
        polls in polls(),
        scaling in scalings(),
        (falling, code, offset) in (any::<bool>(), prop_oneof![Just(Code::Binary), Just(Code::Gray)], 0..1_i128 << 29),
        cycle_ns in prop_oneof![Just(0), 0..2_000_000_i128],
        begin in (-100_i128..100, -100_i128..=100),
    ) {
        let (native, s, n, d) = scaling;
        let sensor = Sensor::Rotary { steps_per_turn: native };
        let mut values = range(s, n, d).to_vec();
        values.push((Parameter::CountingDirection, (code as u32) << 8 | u32::from(falling)));
        let limits = Limits::of(Model::Ce65M, Duration(cycle_ns as u64));
        let mut bench = Bench::new(Model::Ce65M, sensor, &values, limits);
        let refresh_ns = i128::from(Model::Ce65M.refresh().as_nanos());
        let mut shaft = Shaft { at_ns: 0, turned: begin.0 * TURN, speed: begin.1 * FASTEST / 100 };
        let (mut now, mut given, mut sampled) = (5_000_000_i128, 0_i128, 0_i128);
        for poll in polls {
            now += poll.after_ns;
            // The word was given before now, the sample taken before that; neither is older than the last.
            given = given.max(now - (cycle_ns + poll.age_ns) * poll.ring / 1_000);
            let pace = match poll.refresh {
                0..1_000 => refresh_ns * poll.refresh / 1_000,
                _ => (given - offset).rem_euclid(refresh_ns),
            };
            sampled = sampled.max(given - pace);
            shaft.go_on(sampled, poll.acceleration);
            let raw = (shaft.turned * i128::from(native)).div_euclid(TURN);
            let value = shown(raw, scaling, falling, offset);
            let input = match poll.brings {
                Brings::Reply => InWord(0xC200_0000 | s),
                _ if code == Code::Gray => InWord(gray::encode(value)),
                _ => InWord(value),
            };
            let seen = Seen { input, age: Duration(poll.age_ns as u64) };
            let brought = (poll.brings != Brings::Nothing).then_some(seen);
            let position = bench.validity.judge(Instant(now as u64), brought, &mut |stop| bench.stops.push(stop));
            match poll.brings {
                Brings::Position => prop_assert_eq!(position, Position::Valid(value)),
                Brings::Reply => prop_assert_eq!(position, Position::InService),
                Brings::Nothing => prop_assert!(!matches!(position, Position::Implausible(_))),
            }
        }
        let only_stale = bench.stops.iter().all(|stop| matches!(stop, Stop::Stale { .. }));
        prop_assert!(only_stale);
    }

    #[test]
    fn a_magnet_within_its_speed_and_its_rod_is_valid_whenever_it_is_looked_at(
        polls in vec((1..5_000_000_i128, -1_000_000_i128..=1_000_000, 0..1_000_i128, any::<u8>()), 1..200),
        (rod_um, s) in (10..2_000_000_u32, prop_oneof![1..=0xFF_FFFF_u32, 1..50_000_u32]),
        (offset, speed_mm_s, begin) in (any::<u32>(), 1..20_000_u32, 0..2_000_000_i128),
    ) {
        let sensor = Sensor::Linear { rod_um };
        let limits = Limits { speed_mm_s: core::num::NonZeroU32::new(speed_mm_s), ..sheet(Model::La66) };
        let mut bench = Bench::new(Model::La66, sensor, &[(Parameter::MeasuringLength, s)], limits);
        // In 10^-12 m, so that a speed in mm/s is a whole number of them each nanosecond.
        let end = i128::from(rod_um) * 1_000_000;
        let (mut x, mut now, mut sampled) = ((begin * 1_000_000).min(end), 5_000_000_i128, 0_i128);
        for (after, way, refresh, word) in polls {
            now += after;
            let last = sampled;
            sampled = last.max(now - refresh * 1_000);
            x = (x + (sampled - last) * i128::from(speed_mm_s) * way / 1_000_000).clamp(0, end);
            let steps = x / 1_000_000 * i128::from(s) / i128::from(rod_um);
            let value = (steps as u32).wrapping_add(offset) & 0xFF_FFFF;
            let input = InWord(if word == 0 { 0x2000_0000 } else { value });
            let seen = Seen { input, age: Duration::ZERO };
            let position = bench.validity.judge(Instant(now as u64), Some(seen), &mut |_| {});
            let expected = if word == 0 { Position::Faulty(None) } else { Position::Valid(value) };
            prop_assert_eq!(position, expected);
        }
    }

    // [R142]
    #[test]
    fn between_any_two_valid_positions_there_was_time_for_the_way(
        moves in vec((1..2_000_u64, -600_i64..=600), 1..300),
    ) {
        let limits = Limits { acceleration_rad_s2: None, ..sheet(Model::Ce65M) };
        let mut bench = Bench::ce_65_m(limits);
        let (mut place, mut valid) = (8_000_000_i64, Vec::new());
        for (after_us, steps) in moves {
            let next = place + steps;
            if bench.poll(after_us, next as u32).valid().is_some() {
                place = next;
                valid.push((bench.now_ns, place));
            }
        }
        for (k, (later, to)) in valid.iter().enumerate() {
            for (earlier, from) in valid.iter().take(k) {
                // 409600 steps a second, in the time and half a millisecond; a nanosecond lost in each poll.
                let longest = later - earlier + 500_000 + 2 * k as u64;
                let steps = to.abs_diff(*from).saturating_sub(2);
                prop_assert!(steps * 1_000_000_000 <= longest * 409_600, "{from} {to} in {longest} ns");
            }
        }
    }
}
