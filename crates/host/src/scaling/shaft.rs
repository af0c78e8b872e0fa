//! What a shaft's encoder can be programmed to.

use encoring_words::explain::Legal;
use encoring_words::model::{Sensor, SensorError};
use encoring_words::{Model, Service};

/// An encoder with a shaft, as far as its scaling depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shaft {
    steps_per_turn: u32,
    pub(super) length: (u32, u32),
    pub(super) numerator: (u32, u32),
    pub(super) denominator: (u32, u32),
}

impl Shaft {
    /// Of a model with these steps per turn of the sensor, as on the rating plate [R99, R100].
    ///
    /// # Errors
    /// [`SensorError`] if the model is not built with them.
    pub const fn new(model: Model, steps_per_turn: u32) -> Result<Self, SensorError> {
        if let Err(wrong) = model.built_with(Sensor::Rotary { steps_per_turn }) {
            return Err(wrong);
        }
        Ok(Self {
            steps_per_turn,
            length: legal(Service::MeasuringLength, model),
            numerator: legal(Service::Numerator, model),
            denominator: legal(Service::Denominator, model),
        })
    }

    /// The steps per turn of the sensor.
    #[must_use]
    pub const fn steps_per_turn(self) -> u32 {
        self.steps_per_turn
    }

    /// The largest numerator, and the largest denominator.
    #[must_use]
    pub const fn largest_parts(self) -> (u32, u32) {
        (self.numerator.1, self.denominator.1)
    }
}

/// The smallest and the largest legal value of a service; 1 alone where the model lacks it.
const fn legal(service: Service, model: Model) -> (u32, u32) {
    match Legal::of(service, model) {
        Some(Legal::Whole { low, high }) => (low, high),
        _ => (1, 1),
    }
}
