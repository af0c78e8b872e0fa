//! A shaft, as that of the CE-100-M and the CE-65-M: services 02, 03 and 09.

use encoring_words::model::SENSOR_TURNS;
use encoring_words::parameter::{OutOfRange, within};
use encoring_words::{Access, Service, gray};

use super::fraction::{Chosen, Fraction, Turns, TurnsOutside};
use super::ratio::{Deviation, Ratio};
use super::sequence::{HandshakeWord, data_check, handshake};
use super::shaft::Shaft;

/// S, N and D, each within its range. Whether the encoder takes them together is another question:
/// [`RotaryScaling::too_large`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RotaryScaling {
    measuring_length: u32,
    /// N and D.
    pub fraction: Fraction,
}

/// Why the data check refuses a scaling with status 2^14, and what it would take instead [R93, R158, C31].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// With the same measuring length: the smallest legal N/D, if there is one.
    pub smallest_fraction: Option<Fraction>,
    /// With the same N/D: the largest legal measuring length, if there is one.
    pub largest_measuring_length: Option<u32>,
}

/// What becomes of the zero if the shaft moves more than 512 turns without supply [R63, C29].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroRisk {
    /// It cannot be lost.
    Safe,
    /// It can be: the position is then off by this much.
    Shift {
        /// In turns.
        turns: Ratio,
        /// In steps.
        steps: Ratio,
    },
}

impl RotaryScaling {
    /// From the data of services 02, 03 and 09.
    ///
    /// # Errors
    /// [`OutOfRange`] for a measuring length that the encoder refuses [R54].
    pub const fn new(measuring_length: u32, fraction: Fraction, shaft: Shaft) -> Result<Self, OutOfRange> {
        match within(measuring_length, shaft.length.0, shaft.length.1) {
            Ok(measuring_length) => Ok(Self { measuring_length, fraction }),
            Err(refused) => Err(refused),
        }
    }

    /// S, the data of service 02: the largest position [C4].
    #[must_use]
    pub const fn measuring_length(self) -> u32 {
        self.measuring_length
    }

    const fn positions(self) -> u128 {
        self.measuring_length as u128 + 1
    }

    /// The steps per turn that it gives.
    #[must_use]
    pub const fn steps_per_turn(self) -> Ratio {
        Ratio::whole(self.positions()).divided_by(self.fraction.turns())
    }

    /// `None` if the steps per turn are at most those of the rating plate, which the encoder takes; equality is legal
    /// [C31].
    #[must_use]
    pub fn too_large(self, shaft: Shaft) -> Option<TooLarge> {
        let (n, d) = (u128::from(self.fraction.numerator()), u128::from(self.fraction.denominator()));
        let native = u128::from(shaft.steps_per_turn());
        if self.positions() * d <= native * n {
            return None;
        }
        Some(TooLarge {
            smallest_fraction: Fraction::at_least(Ratio::of(self.positions(), native), shaft),
            // Below the refused one.
            largest_measuring_length: (native * n / d)
                .checked_sub(1)
                .map(|length| length as u32)
                .filter(|length| *length >= shaft.length.0),
        })
    }

    /// The verdict on the zero. Exactly when 4096 * D is a multiple of N does a turn count that is wrong by 4096 turns
    /// make no difference.
    #[must_use]
    pub const fn zero_risk(self) -> ZeroRisk {
        let (n, d) = (self.fraction.numerator() as u128, self.fraction.denominator() as u128);
        match SENSOR_TURNS as u128 * d % n {
            0 => ZeroRisk::Safe,
            rest => {
                ZeroRisk::Shift { turns: Ratio::of(rest, d), steps: Ratio::of(rest * self.positions(), n) }
            }
        }
    }

    /// How many bits change at once in Gray code where the position goes from S to 0. One would be single-step, and is
    /// so only if S + 1 is a power of two [C21].
    #[must_use]
    pub const fn gray_wrap_bits(self) -> u32 {
        (gray::encode(self.measuring_length) ^ gray::encode(0)).count_ones()
    }

    /// The words that program it: services 02, 03, 09, and the data check that makes all three active at once
    /// [R79, R81].
    pub fn sequence(self) -> impl Iterator<Item = HandshakeWord> + Clone {
        let write = |service, data| handshake(service, Access::Write, data);
        write(Service::MeasuringLength, self.measuring_length)
            .into_iter()
            .chain(write(Service::Numerator, self.fraction.numerator()))
            .chain(write(Service::Denominator, self.fraction.denominator()))
            .chain(data_check())
    }
}

/// A shaft's scaling as calculated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rotary {
    /// What to program.
    pub scaling: RotaryScaling,
    /// How N/D was found.
    pub chosen: Chosen,
    /// Steps per turn times N/D, before it was made a whole number.
    pub positions: Ratio,
    /// How far the steps per turn lie off those asked for.
    pub off: Deviation,
}

impl Rotary {
    /// How many steps the range is longer or shorter than the turns that were asked for. Where a machine runs on in one
    /// direction this adds up with each pass of the range.
    #[must_use]
    pub const fn steps_off(self) -> Deviation {
        self.chosen.off.times(self.scaling.steps_per_turn())
    }
}

/// A number of positions that cannot be programmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the measuring length would lie outside {low:X}h..{high:X}h ({low}..{high})")]
pub struct LengthOutside {
    /// The smallest measuring length.
    pub low: u32,
    /// The largest measuring length.
    pub high: u32,
    /// Steps per turn times N/D, which is S + 1.
    pub positions: Ratio,
    /// The steps per turn nearest to those asked for that work with these turns.
    pub nearest: Ratio,
    /// The whole number of turns nearest to those asked for that works with these steps per turn, if there is one.
    pub nearest_turns: Option<Fraction>,
}

/// Why there is nothing to program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RotaryError {
    /// The number of turns.
    #[error(transparent)]
    Turns(#[from] TurnsOutside),
    /// The number of positions.
    #[error(transparent)]
    Length(#[from] LengthOutside),
}

/// The scaling that counts `steps_per_turn` over `turns`: S = steps per turn * N/D - 1 with the fraction that is
/// programmed [R53]. If that is no whole number, S is the nearest one with which steps per turn that the rating plate
/// allows do not become too many.
///
/// # Errors
/// [`RotaryError`] if the turns or the measuring length lie outside what can be programmed. Too many steps per turn
/// are no error here: [`RotaryScaling::too_large`] tells them.
pub fn rotary(steps_per_turn: Ratio, turns: Turns, shaft: Shaft) -> Result<Rotary, RotaryError> {
    let chosen = turns.choose(shaft)?;
    let programmed = chosen.fraction.turns();
    let positions = steps_per_turn.multiplied_by(programmed);
    let plate = Ratio::from(shaft.steps_per_turn());
    let limit = if steps_per_turn > plate { u128::MAX } else { plate.multiplied_by(programmed).floor() };
    let whole = u32::try_from(positions.nearest().min(limit)).unwrap_or(u32::MAX);
    match RotaryScaling::new(whole.saturating_sub(1), chosen.fraction, shaft) {
        Ok(scaling) => {
            let off = scaling.steps_per_turn().deviation_from(steps_per_turn);
            Ok(Rotary { scaling, chosen, positions, off })
        }
        Err(refused) => Err(length_outside(refused, steps_per_turn, positions, programmed, shaft).into()),
    }
}

fn length_outside(
    refused: OutOfRange,
    steps_per_turn: Ratio,
    positions: Ratio,
    turns: Ratio,
    shaft: Shaft,
) -> LengthOutside {
    let plate = Ratio::from(shaft.steps_per_turn());
    let few = refused.value < refused.low;
    let end = Ratio::from(if few { refused.low } else { refused.high } + 1);
    let nearest_turns = || {
        if steps_per_turn.is_zero() || steps_per_turn > plate {
            return None;
        }
        let turns = end.divided_by(steps_per_turn);
        let whole = if few { turns.numerator().div_ceil(turns.denominator()) } else { turns.floor() };
        Fraction::new(u32::try_from(whole).ok()?, 1, shaft).ok()
    };
    let OutOfRange { low, high, .. } = refused;
    LengthOutside {
        low,
        high,
        positions,
        nearest: end.divided_by(turns).min(plate),
        nearest_turns: nearest_turns(),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scaling::{Choice, Expected, HandshakeStep};
    use encoring_words::model::Sensor;
    use encoring_words::word::{In, Out, ServiceNumber};
    use encoring_words::{ErrorStatus, Model, OutWord, ParameterSet};
    use proptest::prelude::*;
    use std::string::ToString;
    use std::vec::Vec;

    fn ce(steps_per_turn: u32) -> Shaft {
        Shaft::new(Model::Ce65M, steps_per_turn).unwrap()
    }

    fn calculated(steps_per_turn: &str, turns: &str) -> Rotary {
        rotary(steps_per_turn.parse().unwrap(), turns.parse().unwrap(), ce(4096)).unwrap()
    }

    fn scaling(s: u32, n: u32, d: u32) -> RotaryScaling {
        RotaryScaling::new(s, Fraction::new(n, d, ce(4096)).unwrap(), ce(4096)).unwrap()
    }

    // [R55]
    #[test]
    fn the_worked_example_of_both_manuals() {
        let found = calculated("1000", "10");
        assert_eq!(found.scaling, scaling(0x270F, 0xA, 1));
        assert_eq!((found.off, found.chosen.off), (Deviation::None, Deviation::None));
        let words: Vec<u32> = found.scaling.sequence().map(|step| step.out.0).collect();
        assert_eq!(
            words,
            [
                0x4200_270F,
                0xC200_270F,
                0x4200_270F,
                0x4300_000A,
                0xC300_000A,
                0x4300_000A,
                0x4900_0001,
                0xC900_0001,
                0x4900_0001,
                0x0800_0000,
                0x8800_0000,
                0x0800_0000
            ]
        );
    }

    // [R62]
    #[test]
    fn three_and_a_half_turns_are_35_tenths() {
        assert_eq!(calculated("4096", "3.5").scaling, scaling(0x37FF, 35, 10));
        assert_eq!(calculated("1000", "3.5").scaling, scaling(0xDAB, 35, 10));
        assert_eq!(calculated("1000", "7/2").scaling, scaling(0xDAB, 7, 2));
    }

    // [R53]
    #[test]
    fn the_measuring_length_is_steps_per_turn_times_turns_less_one() {
        for (steps, turns, s) in
            [("4096", "1", 0xFFF), ("4096", "4096", 0xFF_FFFF), ("17", "1", 0x10), ("0.5", "65535", 32_767)]
        {
            let found = calculated(steps, turns);
            assert_eq!(found.scaling.measuring_length(), s, "{steps} x {turns}");
        }
        let nearest = calculated("1000", "3.1416");
        assert_eq!(nearest.scaling, scaling(3140, 311, 99));
        // 184/990000 turns of 3141 * 99/311 steps.
        assert_eq!(nearest.steps_off(), Deviation::Below(Ratio::of(184 * 3141 * 99, 990_000 * 311)));
    }

    #[test]
    fn a_measuring_length_that_is_not_whole_is_rounded_and_the_real_steps_are_told() {
        let found = calculated("1000", "10/3");
        assert_eq!(found.positions, Ratio::of(10_000, 3));
        assert_eq!(found.scaling, scaling(3332, 10, 3));
        assert_eq!(found.scaling.steps_per_turn(), Ratio::of(9_999, 10));
        assert_eq!(found.off, Deviation::Below(Ratio::of(1, 10)));
        // 4096 * 8/3 = 10922.67: rounded up it would be more than the rating plate allows.
        let found = calculated("4096", "8/3");
        assert_eq!(found.scaling, scaling(10_921, 8, 3));
        assert_eq!(found.scaling.too_large(ce(4096)), None);
    }

    // [R158]
    #[test]
    fn more_steps_than_the_rating_plate_are_told_with_the_smallest_legal_fraction() {
        for legal in [(0xFFF, 1, 1), (0x37FF, 35, 10), (0xFF_FFFF, 0x1000, 1)] {
            assert_eq!(scaling(legal.0, legal.1, legal.2).too_large(ce(4096)), None, "{legal:?}");
        }
        for (illegal, fraction, length) in [
            ((0x1000, 1, 1), "100/99", 0xFFF),
            ((0x3800, 35, 10), "347/99", 0x37FF),
            ((0xFF_FFFF, 0xFFF, 1), "4096/1", 0xFF_EFFF),
        ] {
            let too_large = scaling(illegal.0, illegal.1, illegal.2).too_large(ce(4096)).unwrap();
            assert_eq!(too_large.smallest_fraction.unwrap().to_string(), fraction, "{illegal:?}");
            assert_eq!(too_large.largest_measuring_length, Some(length), "{illegal:?}");
        }
        assert_eq!(scaling(0xFF_FFFF, 0x800, 1).too_large(ce(8192)), None);
        let too_large = scaling(0xFF_FFFF, 0x7FF, 1).too_large(ce(8192)).unwrap();
        assert_eq!(too_large.smallest_fraction.unwrap().to_string(), "2048/1");
        let asked = rotary("4097".parse().unwrap(), "1".parse().unwrap(), ce(4096)).unwrap();
        assert_eq!(asked.scaling.measuring_length(), 0x1000);
        assert!(asked.scaling.too_large(ce(4096)).is_some());
    }

    // [R63]
    #[test]
    fn the_zero_is_safe_exactly_when_a_lost_epoch_cannot_be_seen() {
        for (n, d) in [(4096, 1), (2048, 1), (1, 1), (5, 10), (1, 99), (24, 3), (4096, 3)] {
            assert_eq!(scaling(9999, n, d).zero_risk(), ZeroRisk::Safe, "{n}/{d}");
        }
        for (n, d) in [(10, 1), (3, 1), (35, 10), (8192, 1), (65535, 1)] {
            assert_ne!(scaling(9999, n, d).zero_risk(), ZeroRisk::Safe, "{n}/{d}");
        }
        let shift = |turns, steps| ZeroRisk::Shift { turns: Ratio::from(turns), steps: Ratio::from(steps) };
        assert_eq!(scaling(9999, 10, 1).zero_risk(), shift(6, 6000));
        assert_eq!(scaling(14335, 35, 10).zero_risk(), shift(1, 4096));
    }

    #[test]
    fn gray_is_single_step_at_the_wrap_only_over_a_power_of_two() {
        assert_eq!(scaling(9999, 10, 1).gray_wrap_bits(), 5);
        assert_eq!(scaling(0xFF_FFFF, 4096, 1).gray_wrap_bits(), 1);
        for s in 0x10..0x1_0000_u32 {
            let single = scaling(s, 1, 1).gray_wrap_bits() == 1;
            assert_eq!(single, (s + 1).is_power_of_two(), "{s}");
        }
    }

    #[test]
    fn lengths_beyond_both_ends_are_refused_with_the_nearest_that_works() {
        let refused =
            |steps: &str, turns: &str| match rotary(steps.parse().unwrap(), turns.parse().unwrap(), ce(8192))
            {
                Err(RotaryError::Length(refused)) => {
                    let turns = refused.nearest_turns.map(|turns| turns.to_string()).unwrap_or_default();
                    (refused.nearest, turns)
                }
                other => panic!("{other:?}"),
            };
        assert_eq!(refused("8192", "4096"), (Ratio::from(4096), "2048/1".to_string()));
        assert_eq!(refused("100000", "4096"), (Ratio::from(4096), "".to_string()));
        assert_eq!(refused("100000000", "1"), (Ratio::from(8192), "".to_string()));
        assert_eq!(refused("1", "16"), (Ratio::of(17, 16), "17/1".to_string()));
        assert_eq!(refused("0.0001", "16"), (Ratio::of(17, 16), "".to_string()));
    }

    fn any_ratio() -> impl Strategy<Value = Ratio> {
        (1..=u64::MAX, 0..64_u32, 1..=u64::MAX, 0..64_u32)
            .prop_filter_map("too many digits", |(a, i, b, j)| Ratio::new((a >> i).max(1), (b >> j).max(1)))
    }

    fn any_turns() -> impl Strategy<Value = Turns> {
        prop_oneof![
            (1..100_000_u32, 1..200_u32).prop_map(|(n, d)| std::format!("{n}/{d}").parse().unwrap()),
            (0..70_000_u32, 1..1_000_000_000_u32).prop_map(|(whole, decimals)| std::format!(
                "{whole}.{decimals:09}"
            )
            .parse()
            .unwrap()),
        ]
    }

    fn any_native() -> impl Strategy<Value = Shaft> {
        prop_oneof![Just(ce(4096)), Just(ce(8192))]
    }

    fn any_scaling() -> impl Strategy<Value = RotaryScaling> {
        (0x10..=0xFF_FFFF_u32, 0..24_u32, 1..=65535_u32, 1..=99_u32)
            .prop_map(|(s, shift, n, d)| scaling((s >> shift).max(0x10), n, d))
    }

    /// What the encoder's data check says of a scaling.
    fn status(scaling: RotaryScaling, native: Shaft) -> ErrorStatus {
        use encoring_words::Parameter as P;
        let sensor = Sensor::Rotary { steps_per_turn: native.steps_per_turn() };
        let mut set = ParameterSet::factory(Model::Ce65M, sensor);
        for (parameter, value) in [
            (P::MeasuringLength, scaling.measuring_length()),
            (P::Numerator, scaling.fraction.numerator()),
            (P::Denominator, scaling.fraction.denominator()),
        ] {
            set.set(parameter, parameter.normalise(Model::Ce65M, value).unwrap());
        }
        set.validity(Model::Ce65M, sensor)
    }

    proptest! {
        #[test]
        fn any_request_is_answered_with_legal_values_or_the_nearest_that_work(
            steps in any_ratio(), turns in any_turns(), native in any_native(),
        ) {
            match rotary(steps, turns, native) {
                Ok(found) => {
                    let s = found.scaling.measuring_length();
                    prop_assert!((0x10..=0xFF_FFFF).contains(&s));
                    if steps <= Ratio::from(native.steps_per_turn()) {
                        prop_assert_eq!(found.scaling.too_large(native), None);
                    }
                    let exact = steps.multiplied_by(found.chosen.fraction.turns());
                    prop_assert_eq!(found.positions, exact);
                    let whole = u128::from(s) + 1;
                    prop_assert!(exact.floor() == whole || exact.nearest() == whole);
                    prop_assert_eq!(found.off == Deviation::None, exact == Ratio::whole(whole));
                }
                Err(RotaryError::Length(refused)) => {
                    let works = rotary(refused.nearest, turns, native).map(|found| found.scaling.too_large(native));
                    prop_assert_eq!(works, Ok(None));
                    if let Some(turns) = refused.nearest_turns {
                        let works = rotary(steps, turns.into(), native).map(|found| found.scaling.too_large(native));
                        prop_assert_eq!(works, Ok(None));
                    }
                }
                Err(RotaryError::Turns(refused)) => {
                    let chosen = Turns::from(refused.nearest).choose(native).unwrap();
                    prop_assert_eq!((chosen.fraction, chosen.choice), (refused.nearest, Choice::AsGiven));
                }
            }
        }

        #[test]
        fn the_verdict_on_2_to_14_is_the_encoders(scaling in any_scaling(), native in any_native()) {
            let too_large = scaling.too_large(native);
            let says = status(scaling, native);
            prop_assert_eq!(too_large.is_some(), says == ErrorStatus::LENGTH_TOO_LARGE);
            prop_assert_eq!(too_large.is_none(), says.is_empty());
            if let Some(instead) = too_large {
                let s = scaling.measuring_length();
                let raised = RotaryScaling::new(s, instead.smallest_fraction.unwrap(), native).unwrap();
                prop_assert!(status(raised, native).is_empty());
                let largest = instead.largest_measuring_length.unwrap();
                let shortened = RotaryScaling::new(largest, scaling.fraction, native).unwrap();
                prop_assert!(status(shortened, native).is_empty());
                let longer = RotaryScaling::new(largest + 1, scaling.fraction, native).unwrap();
                prop_assert!(!status(longer, native).is_empty());
            }
        }

        #[test]
        fn the_shift_is_what_4096_turns_too_many_change(scaling in any_scaling(), turns in 0..1_000_u64) {
            // Positions of a shaft, times N, before and after the count jumps.
            let (n, d) = (u128::from(scaling.fraction.numerator()), u128::from(scaling.fraction.denominator()));
            let place = |turns: u64| u128::from(turns) * d % n;
            let jumped = (place(turns + 4096) + n - place(turns)) % n;
            match scaling.zero_risk() {
                ZeroRisk::Safe => prop_assert_eq!(jumped, 0),
                ZeroRisk::Shift { turns, steps } => {
                    prop_assert_eq!(turns, Ratio::of(jumped, d));
                    prop_assert_eq!(steps, Ratio::of(jumped * scaling.positions(), n));
                }
            }
        }

        #[test]
        fn the_words_decode_to_what_they_say(scaling in any_scaling()) {
            let steps: Vec<_> = scaling.sequence().collect();
            let services = [
                (Service::MeasuringLength, Access::Write, scaling.measuring_length()),
                (Service::Numerator, Access::Write, scaling.fraction.numerator()),
                (Service::Denominator, Access::Write, scaling.fraction.denominator()),
                (Service::DataCheck, Access::Read, 0),
            ];
            prop_assert_eq!(steps.len(), 3 * services.len());
            for (three, (service, access, data)) in steps.chunks(3).zip(services) {
                let [prepare, request, end] = three else { panic!("three") };
                prop_assert_eq!((prepare.phase, request.phase, end.phase), (HandshakeStep::Prepare, HandshakeStep::Request, HandshakeStep::End));
                let Out::Request(fields) = request.out.decode() else { panic!("a request") };
                prop_assert_eq!(fields.service, ServiceNumber::Known(service));
                prop_assert_eq!((fields.access, fields.data, fields.error, fields.reserve), (access, data, false, false));
                let Expected::Reply(reply) = request.expected else { panic!("a reply") };
                prop_assert_eq!(reply.decode(), In::Reply(fields));
                for rest in [prepare, end] {
                    prop_assert_eq!(rest.out, OutWord(request.out.0 & 0x7FFF_FFFF));
                    prop_assert_eq!(rest.expected, Expected::Position);
                }
            }
        }
    }
}
