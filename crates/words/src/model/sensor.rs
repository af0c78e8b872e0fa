//! What an encoder measures with.

use core::fmt;

use super::{Model, Series};

/// What a model measures with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorKind {
    /// A shaft.
    Rotary,
    /// A rod with a magnet.
    Linear,
}

/// What measures: the part of an encoder that differs from one delivery to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// A shaft, with its steps per turn.
    Rotary {
        /// One of [`Model::steps_per_turn`].
        steps_per_turn: u32,
    },
    /// A rod, with the measuring length of its type label.
    Linear {
        /// In micrometres.
        rod_um: u32,
    },
}

/// Turns that a shaft's sensor tells apart without counting [R99, R100].
pub const SENSOR_TURNS: u32 = 4096;

/// The longest rod whose factory resolution of 0.01 mm still fits 24 bits, in micrometres.
pub const ROD_UM_MAX: u32 = 167_772_150;

/// The shortest rod with at least one step, in micrometres.
pub const ROD_UM_MIN: u32 = 10;

/// A sensor that a model is not built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorError {
    /// The model is not built with so many steps per turn.
    StepsPerTurn {
        /// The model.
        model: Model,
        /// What was asked for.
        steps_per_turn: u32,
    },
    /// A rod was asked to turn or a shaft to have a length.
    OtherKind {
        /// The model.
        model: Model,
    },
    /// The rod is too short or too long.
    RodLength {
        /// What was asked for, in micrometres.
        rod_um: u32,
    },
}

impl fmt::Display for SensorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StepsPerTurn { model, steps_per_turn } => {
                let options = Series(model.steps_per_turn(), "or");
                write!(f, "{steps_per_turn} steps per turn; a {model} has {options}")
            }
            Self::OtherKind { model } => match model.sensor_kind() {
                SensorKind::Linear => write!(f, "a {model} has a rod length, no steps per turn"),
                SensorKind::Rotary => write!(f, "a {model} has steps per turn, no rod length"),
            },
            Self::RodLength { rod_um } => {
                write!(f, "a rod of {rod_um} um; the limits are {ROD_UM_MIN} um and {ROD_UM_MAX} um")
            }
        }
    }
}

impl core::error::Error for SensorError {}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_sensor_must_belong_to_its_model() {
        let rotary = |steps_per_turn| Sensor::Rotary { steps_per_turn };
        let rod = |rod_um| Sensor::Linear { rod_um };
        assert!(Model::Ce65M.built_with(rotary(8192)).is_ok());
        assert!(Model::Ce100M.built_with(rotary(4096)).is_ok());
        assert!(Model::La66.built_with(rod(500_000)).is_ok());
        let text = |model: Model, sensor| model.built_with(sensor).unwrap_err().to_string();
        assert_eq!(text(Model::Ce100M, rotary(8192)), "8192 steps per turn; a ce-100-m has 4096");
        assert_eq!(text(Model::Ce65M, rotary(4097)), "4097 steps per turn; a ce-65-m has 4096 or 8192");
        assert_eq!(text(Model::La66, rotary(4096)), "a la-66 has a rod length, no steps per turn");
        assert_eq!(text(Model::Ce65M, rod(10)), "a ce-65-m has steps per turn, no rod length");
        assert_eq!(text(Model::La66, rod(9)), "a rod of 9 um; the limits are 10 um and 167772150 um");
    }

    #[test]
    fn rods_are_as_long_as_the_message_says() {
        let rod = |rod_um| Model::La66.built_with(Sensor::Linear { rod_um });
        assert!(rod(10).is_ok() && rod(167_772_150).is_ok());
        for rod_um in [0, 9, 167_772_151, u32::MAX] {
            assert_eq!(rod(rod_um), Err(SensorError::RodLength { rod_um }));
        }
    }

    #[test]
    fn a_sensor_is_what_was_said_of_it_or_the_usual_one() {
        assert_eq!(Model::Ce65M.sensor(None, None), Ok(Sensor::Rotary { steps_per_turn: 4096 }));
        assert_eq!(Model::Ce65M.sensor(Some(8192), None), Ok(Sensor::Rotary { steps_per_turn: 8192 }));
        assert_eq!(Model::La66.sensor(None, None), Ok(Sensor::Linear { rod_um: 500_000 }));
        assert_eq!(Model::La66.sensor(None, Some(20)), Ok(Sensor::Linear { rod_um: 20 }));
        for (model, steps_per_turn, rod_um) in [
            (Model::La66, Some(4096), None),
            (Model::Ce65M, None, Some(20)),
            (Model::Ce65M, Some(4096), Some(20)),
        ] {
            assert_eq!(model.sensor(steps_per_turn, rod_um), Err(SensorError::OtherKind { model }));
        }
    }
}
