//! What a preset adjustment can restore of a zero.
//!
//! The offset of the old unit cannot be read [R76]. A preset makes the position right at one place; it picks the smallest
//! phase of the value, so the old offset's fraction of a step is lost.

use encoring_words::model::SensorKind;
use encoring_words::parameter::ParameterSet;
use encoring_words::{Model, Parameter};

/// How the positions compare with those of the old unit once a preset was made at a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroRestored {
    /// A step of the position is a step of the sensor: equal everywhere.
    Everywhere,
    /// Equal at the mark; elsewhere equal or one step lower.
    AtTheMark {
        /// (S + 1) * D.
        positions: u64,
        /// Steps per turn times N.
        native: u64,
    },
    /// Equal at the mark; elsewhere equal, or one step off if steps per turn of the rating plate are not known.
    AtLeastAtTheMark,
    /// A rod: equal everywhere if it sits where the old one sat, else within a step.
    OfARod,
}

impl ZeroRestored {
    /// For these values. `steps_per_turn` are those of the rating plate, if they are known.
    #[must_use]
    pub fn of(model: Model, set: &ParameterSet, steps_per_turn: Option<u32>) -> Self {
        if model.sensor_kind() == SensorKind::Linear {
            return Self::OfARod;
        }
        let known = match model.steps_per_turn() {
            [only] => Some(*only),
            _ => steps_per_turn,
        };
        let Some(steps) = known else { return Self::AtLeastAtTheMark };
        let positions = (u64::from(set.measuring_length()) + 1).saturating_mul(u64::from(set.denominator()));
        let native = u64::from(steps) * u64::from(set.numerator());
        if positions == native { Self::Everywhere } else { Self::AtTheMark { positions, native } }
    }

    /// In sentences.
    #[must_use]
    pub fn told(self) -> Vec<String> {
        let edge = || {
            "As long as an old unit works this can be kept small: note the mark where the position has just become this \
             value while the shaft turns slowly upwards (the edge of the step), and make the preset at that place."
                .to_owned()
        };
        match self {
            Self::Everywhere => vec![
                "After the preset the position is equal everywhere: one step is one step of the sensor, (S+1)*D = Q*N."
                    .to_owned(),
            ],
            Self::AtTheMark { positions, native } => vec![
                format!(
                    "After the preset the position is equal at the mark; at other places it is equal or one step lower: \
                     which part of a step the old zero had cannot be read ((S+1)*D = {positions}, Q*N = {native})."
                ),
                edge(),
            ],
            Self::AtLeastAtTheMark => vec![
                "After the preset the position is equal at the mark; at other places it is equal or one step lower: which \
                 part of a step the old zero had cannot be read. With --native it could be told whether that matters here."
                    .to_owned(),
                edge(),
            ],
            Self::OfARod => vec![
                "After the preset the position is equal everywhere if the rod sits where the old one sat; else it is equal \
                 at the mark and at other places within one step."
                    .to_owned(),
            ],
        }
    }
}

/// A set of these values; what is not among them is as the factory leaves it.
#[must_use]
pub fn set_of(model: Model, values: &[(Parameter, u32)]) -> ParameterSet {
    let mut set = ParameterSet::factory(model, model.finest_sensor());
    for (parameter, value) in values {
        set.set(*parameter, *value);
    }
    set
}
