//! Positions as places of a shaft or a magnet, and back.

use super::linear::LinearScaling;
use super::ratio::Ratio;
use super::rotary::RotaryScaling;

impl RotaryScaling {
    /// How many turns lie between position 0 and a position, counted up.
    #[must_use]
    pub const fn turns_at(self, position: u32) -> Ratio {
        Ratio::of(position as u128, 1).divided_by(self.steps_per_turn())
    }

    /// The position nearest to a place so many turns from position 0; `None` beyond the last position.
    #[must_use]
    pub fn position_at(self, turns: Ratio) -> Option<u32> {
        nearest(turns.multiplied_by(self.steps_per_turn()), self.measuring_length())
    }
}

impl LinearScaling {
    /// What a step is on a rod of this length, in the unit of the length.
    #[must_use]
    pub const fn resolution(self, length: Ratio) -> Ratio {
        length.divided_by(Ratio::of(self.measuring_length() as u128, 1))
    }

    /// The position nearest to a place of a rod, in the unit of its length; `None` beyond the end of the rod.
    #[must_use]
    pub fn position_at(self, place: Ratio, length: Ratio) -> Option<u32> {
        nearest(place.divided_by(self.resolution(length)), self.measuring_length())
    }
}

fn nearest(position: Ratio, last: u32) -> Option<u32> {
    u32::try_from(position.nearest()).ok().filter(|position| *position <= last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scaling::{Fraction, Shaft, Turns, rotary};
    use encoring_words::Model;
    use proptest::prelude::*;

    fn shaft() -> Shaft {
        Shaft::new(Model::Ce65M, 4096).unwrap()
    }

    #[test]
    fn a_position_is_a_place_and_the_place_the_position() {
        let found = rotary("1000".parse().unwrap(), "3.5".parse().unwrap(), shaft()).unwrap().scaling;
        assert_eq!(found.turns_at(250), Ratio::of(1, 4));
        assert_eq!(found.position_at(Ratio::of(1, 4)), Some(250));
        assert_eq!(found.position_at("3.499".parse().unwrap()), Some(3499));
        assert_eq!(found.position_at("3.5".parse().unwrap()), None, "0 again");
        let rod = LinearScaling::new(50_000, Model::La66).unwrap();
        let length: Ratio = "500".parse().unwrap();
        assert_eq!(rod.resolution(length), Ratio::of(1, 100));
        assert_eq!(rod.position_at(length, length), Some(50_000));
        assert_eq!(rod.position_at("500.01".parse().unwrap(), length), None);
    }

    proptest! {
        #[test]
        fn every_position_comes_back_from_its_place(
            s in 0x10..=0xFF_FFFF_u32, n in 1..=65_535_u32, d in 1..=99_u32, position: u32,
        ) {
            let scaling = RotaryScaling::new(s, Fraction::new(n, d, shaft()).unwrap(), shaft()).unwrap();
            let position = position % (s + 1);
            prop_assert_eq!(scaling.position_at(scaling.turns_at(position)), Some(position));
        }

        #[test]
        fn what_is_calculated_is_explained_back(s in 0x10..=0xFF_FFFF_u32, n in 1..=65_535_u32, d in 1..=99_u32) {
            let scaling = RotaryScaling::new(s, Fraction::new(n, d, shaft()).unwrap(), shaft()).unwrap();
            prop_assume!(scaling.too_large(shaft()).is_none());
            let again = rotary(scaling.steps_per_turn(), Turns::from(scaling.fraction), shaft()).unwrap();
            prop_assert_eq!(again.scaling, scaling);
        }
    }
}
