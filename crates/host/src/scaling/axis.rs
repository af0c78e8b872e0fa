//! A linear axis that a shaft moves: how many turns its travel needs, and what more of them cost.

use encoring_words::model::SENSOR_TURNS;
use encoring_words::word::DATA_MAX;

use super::fraction::{Fraction, Turns};
use super::ratio::Ratio;
use super::rotary::{Rotary, rotary};
use super::shaft::Shaft;

/// An axis: how far it travels, and how far a turn of the shaft moves it, in one unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// From one end to the other.
    pub travel: Ratio,
    /// How much further the range reaches at least, so that the end of travel is not where the position wraps.
    pub reserve: Ratio,
    /// In one turn of the shaft.
    pub per_turn: Ratio,
}

/// What turns are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The travel alone: at its end the position is about to wrap.
    Travel,
    /// The fewest whole turns with the reserve.
    Reserve,
    /// The fewest turns with the reserve that keep the zero without supply [C29].
    Safe,
}

/// Turns for an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Proposal {
    /// What they are for.
    pub purpose: Purpose,
    /// What to program.
    pub rotary: Rotary,
    /// How far the axis moves until the position wraps.
    pub range: Ratio,
}

impl Axis {
    /// The axis with the reserve that is usual: a twentieth of the travel.
    #[must_use]
    pub fn new(travel: Ratio, per_turn: Ratio) -> Self {
        Self { travel, reserve: travel.divided_by(Ratio::from(20)), per_turn }
    }

    /// The turns of the travel; `None` if they have too many digits.
    #[must_use]
    pub fn turns(&self) -> Option<Ratio> {
        self.travel.over(self.per_turn)
    }

    /// The turns of travel and reserve together.
    fn needed(&self) -> Option<Ratio> {
        self.travel.plus(self.reserve)?.over(self.per_turn)
    }

    /// The turns for a purpose; `None` if no turns that can be programmed are.
    #[must_use]
    pub fn fraction(&self, purpose: Purpose, shaft: Shaft) -> Option<Fraction> {
        match purpose {
            Purpose::Travel => Fraction::at_least(self.turns()?, shaft),
            Purpose::Reserve => {
                let needed = self.needed()?;
                let whole = needed.numerator().div_ceil(needed.denominator()).max(1);
                Fraction::new(u32::try_from(whole).ok()?, 1, shaft).ok()
            }
            Purpose::Safe => safe_at_least(self.needed()?, shaft),
        }
    }

    /// Turns for a purpose with steps per turn: those asked for, or the most there can be; fewer where the turns do not
    /// leave room for them. `None` if nothing can be programmed for it.
    #[must_use]
    pub fn proposal(
        &self,
        purpose: Purpose,
        steps_per_turn: Option<Ratio>,
        shaft: Shaft,
    ) -> Option<Proposal> {
        let fraction = self.fraction(purpose, shaft)?;
        let room = Ratio::from(DATA_MAX + 1).divided_by(fraction.turns());
        let plate = Ratio::from(shaft.steps_per_turn());
        let steps_per_turn = steps_per_turn.unwrap_or(plate).min(plate).min(room);
        let rotary = rotary(steps_per_turn, Turns::from(fraction), shaft).ok()?;
        Some(Proposal { purpose, rotary, range: self.per_turn.multiplied_by(fraction.turns()) })
    }

    /// What to take: turns that keep the zero, unless only others leave room for the steps per turn asked for.
    #[must_use]
    pub fn advice(&self, steps_per_turn: Option<Ratio>, shaft: Shaft) -> Option<Purpose> {
        let plate = Ratio::from(shaft.steps_per_turn());
        let wanted = steps_per_turn.map(|steps| steps.min(plate));
        let has_room = |fraction: Fraction| {
            wanted.is_none_or(|steps| steps <= Ratio::from(DATA_MAX + 1).divided_by(fraction.turns()))
        };
        match self.fraction(Purpose::Safe, shaft) {
            Some(fraction) if has_room(fraction) => Some(Purpose::Safe),
            _ => self.fraction(Purpose::Reserve, shaft).map(|_| Purpose::Reserve),
        }
    }
}

/// The fewest turns from `needed` on that keep the zero: the sensor's turns divided by a whole number, which is as large
/// as it can be [C29].
fn safe_at_least(needed: Ratio, shaft: Shaft) -> Option<Fraction> {
    let turns = u128::from(SENSOR_TURNS);
    let most = turns * u128::from(shaft.largest_parts().1);
    let divisor = Ratio::from(SENSOR_TURNS).divided_by(needed).floor().min(most);
    (1..=divisor).rev().find_map(|divisor| {
        let kept = Ratio::of(turns, divisor);
        let part = |part: u128| u32::try_from(part).ok();
        Fraction::new(part(kept.numerator())?, part(kept.denominator())?, shaft).ok()
    })
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scaling::ZeroRisk;
    use encoring_words::Model;
    use proptest::prelude::*;
    use proptest::test_runner::Config;
    use std::string::ToString;
    use std::vec::Vec;

    fn shaft(steps_per_turn: u32) -> Shaft {
        Shaft::new(Model::Ce65M, steps_per_turn).unwrap()
    }

    fn ratio(text: &str) -> Ratio {
        text.parse().unwrap()
    }

    #[test]
    fn fifty_metres_on_a_drum_get_turns_with_a_reserve_that_keep_the_zero() {
        let axis = Axis::new(ratio("50000"), ratio("3330"));
        let fraction = |purpose| axis.fraction(purpose, shaft(4096)).unwrap().to_string();
        assert_eq!(axis.turns(), Some(Ratio::of(5_000, 333)));
        // 1006/67 is nearer, but shorter than the travel.
        assert_eq!(fraction(Purpose::Travel), "991/66");
        assert_eq!(fraction(Purpose::Reserve), "16/1");
        assert_eq!(fraction(Purpose::Safe), "16/1");
        assert_eq!(axis.advice(None, shaft(4096)), Some(Purpose::Safe));
        let proposal = axis.proposal(Purpose::Safe, None, shaft(4096)).unwrap();
        assert_eq!((proposal.range, proposal.rotary.scaling.measuring_length()), (ratio("53280"), 65_535));
    }

    #[test]
    fn turns_that_keep_the_zero_are_left_where_the_steps_asked_for_have_no_room() {
        let axis = Axis::new(ratio("3000"), ratio("1"));
        assert_eq!(axis.fraction(Purpose::Safe, shaft(8192)).unwrap().to_string(), "4096/1");
        assert_eq!(axis.advice(Some(ratio("4096")), shaft(8192)), Some(Purpose::Safe));
        assert_eq!(axis.advice(Some(ratio("4097")), shaft(8192)), Some(Purpose::Reserve));
        assert_eq!(axis.advice(None, shaft(8192)), Some(Purpose::Safe));
        // Without a wish the steps are as many as fit.
        let steps =
            |purpose| axis.proposal(purpose, None, shaft(8192)).unwrap().rotary.scaling.steps_per_turn();
        assert_eq!(steps(Purpose::Safe), Ratio::from(4_096));
        assert!(steps(Purpose::Reserve) > Ratio::from(5_326));
        // Above 4096 turns none is safe, above 65535 there is none.
        let long =
            |travel: &str, purpose| Axis::new(ratio(travel), ratio("1")).fraction(purpose, shaft(4096));
        assert_eq!((long("4000", Purpose::Safe), long("70000", Purpose::Reserve)), (None, None));
        assert_eq!(long("4000", Purpose::Reserve).unwrap().to_string(), "4200/1");
    }

    /// Every number of turns that can be programmed and keeps the zero, by the definition; rising.
    fn all_safe() -> Vec<Ratio> {
        let mut safe = Vec::new();
        for denominator in 1..=99_u128 {
            safe.extend(
                (1..=65_535_u128)
                    .filter(|numerator| (4096 * denominator).is_multiple_of(*numerator))
                    .map(|numerator| Ratio::of(numerator, denominator)),
            );
        }
        safe.sort_unstable();
        safe
    }

    #[test]
    fn the_advice_is_that_of_a_search_through_all_turns_on_a_thousand_axes() {
        let safe = all_safe();
        let mut runner = proptest::test_runner::TestRunner::new(Config::with_cases(1_000));
        let axes =
            (1..100_000_000_u64, 0..10_000_000_u64, 1..10_000_000_u64, prop_oneof![Just(4096), Just(8192)]);
        let checked = runner.run(&axes, |(travel, reserve, per_turn, native)| {
            let hundredths = |number| Ratio::new(number, 100).unwrap();
            let axis = Axis {
                travel: hundredths(travel),
                reserve: hundredths(reserve),
                per_turn: hundredths(per_turn),
            };
            let needed = Ratio::new(travel + reserve, per_turn).unwrap();
            let shaft = shaft(native);
            let best = safe.iter().find(|turns| **turns >= needed).copied();
            prop_assert_eq!(axis.fraction(Purpose::Safe, shaft).map(Fraction::turns), best);
            let whole = (1..=65_535_u32).map(Ratio::from).find(|turns| *turns >= needed);
            prop_assert_eq!(axis.fraction(Purpose::Reserve, shaft).map(Fraction::turns), whole);
            for purpose in [Purpose::Travel, Purpose::Reserve, Purpose::Safe] {
                let Some(proposal) = axis.proposal(purpose, None, shaft) else { continue };
                prop_assert!(proposal.range >= axis.travel);
                prop_assert_eq!(proposal.rotary.scaling.too_large(shaft), None);
                let kept = proposal.rotary.scaling.zero_risk() == ZeroRisk::Safe;
                prop_assert!(kept || purpose != Purpose::Safe);
            }
            Ok(())
        });
        checked.unwrap();
    }
}
