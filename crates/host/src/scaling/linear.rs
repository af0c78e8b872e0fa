//! A rod, as the LA-66's: service 02 alone.

use encoring_words::parameter::{OutOfRange, Parameter};
use encoring_words::word::DATA_MAX;
use encoring_words::{Access, Model, Service};

use super::ratio::Ratio;
use super::sequence::{HandshakeWord, data_check, handshake};

/// A measuring length within the range of a rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinearScaling {
    measuring_length: u32,
}

impl LinearScaling {
    /// From the data of service 02.
    ///
    /// # Errors
    /// [`OutOfRange`] for a measuring length that the model refuses.
    pub const fn new(measuring_length: u32, model: Model) -> Result<Self, OutOfRange> {
        match Parameter::MeasuringLength.normalise(model, measuring_length) {
            Ok(measuring_length) => Ok(Self { measuring_length }),
            Err(refused) => Err(refused),
        }
    }

    /// S, the data of service 02: the position at the end of the rod [C4].
    #[must_use]
    pub const fn measuring_length(self) -> u32 {
        self.measuring_length
    }

    /// The words that program it, service 08 at the end.
    pub fn sequence(self) -> impl Iterator<Item = HandshakeWord> + Clone {
        let write = handshake(Service::MeasuringLength, Access::Write, self.measuring_length);
        write.into_iter().chain(data_check())
    }
}

/// A rod's scaling as calculated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linear {
    /// What to program.
    pub scaling: LinearScaling,
    /// Length divided by resolution, before it was made a whole number.
    pub steps: Ratio,
    /// What a step really is, in the unit of the length.
    pub resolution: Ratio,
}

/// A resolution with which the rod would have too few or too many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the rod would have fewer than {low} or more than {high:X}h ({high}) steps")]
pub struct ResolutionOutside {
    /// The fewest steps.
    pub low: u32,
    /// The most steps.
    pub high: u32,
    /// Length divided by resolution.
    pub steps: Ratio,
    /// The resolution nearest to the one asked for that works.
    pub nearest: Ratio,
}

/// The measuring length of a rod: length / resolution, both in the same unit [R49].
///
/// # Errors
/// [`ResolutionOutside`] if the model refuses that, or the resolution or the length is 0.
pub fn linear(length: Ratio, resolution: Ratio, model: Model) -> Result<Linear, ResolutionOutside> {
    let (low, high) = Parameter::MeasuringLength.range(model).unwrap_or((1, DATA_MAX));
    let outside = |steps, nearest| ResolutionOutside { low, high, steps, nearest };
    let finest = length.divided_by(Ratio::from(high));
    if length.is_zero() || resolution.is_zero() {
        return Err(outside(Ratio::from(0), finest));
    }
    let steps = length.divided_by(resolution);
    let whole = u32::try_from(steps.nearest()).unwrap_or(u32::MAX);
    match LinearScaling::new(whole, model) {
        Ok(scaling) => {
            let real = length.divided_by(Ratio::from(whole));
            Ok(Linear { scaling, steps, resolution: real })
        }
        Err(refused) if refused.value < low => Err(outside(steps, length.divided_by(Ratio::from(low)))),
        Err(_) => Err(outside(steps, finest)),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use encoring_words::OutWord;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn ratio(text: &str) -> Ratio {
        text.parse().unwrap()
    }

    fn length(mm: &str, resolution: &str) -> u32 {
        linear(ratio(mm), ratio(resolution), Model::La66).unwrap().scaling.measuring_length()
    }

    #[test]
    fn a_rod_of_500_mm_has_c350h_steps_of_a_hundredth_and_no_one_is_taken_off() {
        assert_eq!(length("500", "0.01"), 0xC350);
    }

    #[test]
    fn a_rod_of_500_mm_has_1388h_steps_of_a_tenth_and_not_1288h() {
        assert_eq!(length("500", "0.1"), 0x1388);
        assert_ne!(length("500", "0.1"), 0x1288);
    }

    #[test]
    fn any_length_can_be_programmed_and_a_rest_is_told() {
        assert_eq!(length("0.01", "0.01"), 1);
        assert_eq!(length("167772.15", "0.01"), 0xFF_FFFF);
        let found = linear(ratio("500"), ratio("0.03"), Model::La66).unwrap();
        assert_eq!((found.scaling.measuring_length(), found.steps.is_whole()), (16_667, false));
        assert_eq!(found.resolution, Ratio::of(500, 16_667));
    }

    #[test]
    fn too_few_and_too_many_steps_are_refused_with_the_nearest_resolution() {
        let too_coarse = linear(ratio("500"), ratio("1001"), Model::La66).unwrap_err();
        assert_eq!(too_coarse.nearest, ratio("500"));
        let too_fine = linear(ratio("16777216"), ratio("1"), Model::La66).unwrap_err();
        assert_eq!(too_fine.nearest, Ratio::of(16_777_216, 16_777_215));
        for refused in [too_coarse, too_fine] {
            let rod = if refused == too_coarse { ratio("500") } else { ratio("16777216") };
            assert!(linear(rod, refused.nearest, Model::La66).is_ok());
        }
        assert!(linear(Ratio::from(0), ratio("1"), Model::La66).is_err());
        assert!(linear(ratio("1"), Ratio::from(0), Model::La66).is_err());
    }

    #[test]
    fn a_rod_is_programmed_with_one_write_and_a_data_check() {
        let words: Vec<OutWord> =
            LinearScaling::new(0xC350, Model::La66).unwrap().sequence().map(|step| step.out).collect();
        let expected = [0x4200_C350, 0xC200_C350, 0x4200_C350, 0x0800_0000, 0x8800_0000, 0x0800_0000];
        assert_eq!(words, expected.map(OutWord));
    }

    proptest! {
        #[test]
        fn any_rod_and_resolution_gives_a_legal_length_or_the_nearest_that_works(
            a in 1..=u64::MAX, b in 1..=u64::MAX, c in 1..=u64::MAX, d in 1..=u64::MAX,
        ) {
            let (Some(rod), Some(resolution)) = (Ratio::new(a, b), Ratio::new(c, d)) else { return Ok(()) };
            match linear(rod, resolution, Model::La66) {
                Ok(found) => {
                    let steps = u128::from(found.scaling.measuring_length());
                    prop_assert!((1..=0xFF_FFFF).contains(&steps));
                    prop_assert!(found.steps.nearest() == steps);
                }
                Err(refused) => prop_assert!(linear(rod, refused.nearest, Model::La66).is_ok()),
            }
        }
    }
}
