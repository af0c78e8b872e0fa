//! A service as a manual lists it: what may be done with it, and what its data may be.

use super::Sensor;
use crate::ErrorStatus;
use crate::data::{CountingDirection, OutOfRange, SsiValues, within};
use crate::service::Service;
use crate::word::DATA_MAX;

/// A service as the manual of a model lists it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Which.
    pub service: Service,
    /// What may be done with it.
    pub allowed: Allowed,
    /// What its data may be in a write.
    pub takes: Takes,
    /// What a new encoder holds.
    pub(super) factory: Factory,
}

impl Listed {
    /// 08 is read only [R78].
    pub(super) const DATA_CHECK: Self = Self {
        service: Service::DataCheck,
        allowed: Allowed::Reading,
        takes: Takes::Nothing,
        factory: Factory::Value(0),
    };

    pub(super) const fn value(service: Service, takes: Takes, factory: u32) -> Self {
        Self { service, allowed: Allowed::Both, takes, factory: Factory::Value(factory) }
    }

    /// 06 is write only [R76].
    pub(super) const fn preset_adjustment(takes: Takes) -> Self {
        Self {
            service: Service::PresetAdjustment,
            allowed: Allowed::Writing,
            takes,
            factory: Factory::Value(0),
        }
    }

    /// The value that a new encoder with this sensor holds. No manual says; it is this project's choice.
    #[must_use]
    pub const fn factory(&self, sensor: Sensor) -> u32 {
        match (self.factory, sensor) {
            (Factory::Value(value), _) => value,
            (Factory::HundredthsOfAMillimetre, Sensor::Rotary { .. }) => DATA_MAX,
            (Factory::HundredthsOfAMillimetre, Sensor::Linear { rod_um }) => match rod_um / 10 {
                0 => 1,
                steps if steps > DATA_MAX => DATA_MAX,
                steps => steps,
            },
        }
    }
}

/// What may be done with a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// Reading and writing.
    Both,
    /// Reading alone.
    Reading,
    /// Writing alone.
    Writing,
}

/// What the data of a write may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// There is no write.
    Nothing,
    /// One number of 24 bits.
    Number {
        /// The smallest that is not refused.
        low: u32,
        /// The largest that is not refused.
        high: u32,
        /// What else is asked of it.
        demand: Demand,
    },
    /// One number of 24 bits, refused above the active measuring length [R75, C30].
    UpToMeasuringLength,
    /// Counting direction and code of the position, a byte each [R46].
    DirectionAndCode,
    /// Repetition, code and number of data bits of the SSI, a byte each [R113].
    SsiValues {
        /// The fewest data bits [R115].
        fewest_bits: u8,
        /// The most data bits [R115].
        most_bits: u8,
    },
}

/// What is asked of a number beside its range: it is stored all the same, and an error as long as it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// Nothing.
    None,
    /// Other than 0, judged at once; this status otherwise.
    NotZero(ErrorStatus),
    /// At most the measuring length, judged by the data check; this status otherwise.
    UpToMeasuringLength(ErrorStatus),
}

impl Takes {
    pub(super) const fn number(low: u32, high: u32) -> Self {
        Self::Number { low, high, demand: Demand::None }
    }

    /// The data as the encoder stores and returns them [R47, R114, R119, C11, C19]. Whether the measuring length
    /// allows them is not looked at.
    ///
    /// # Errors
    /// [`OutOfRange`] if they are refused; the old value then stays.
    pub const fn normalise(self, data: u32) -> Result<u32, OutOfRange> {
        match self {
            Self::Nothing | Self::UpToMeasuringLength => within(data, 0, DATA_MAX),
            Self::Number { low, high, .. } => within(data, low, high),
            Self::DirectionAndCode => Ok(CountingDirection::from_data(data).data()),
            Self::SsiValues { fewest_bits, most_bits } => {
                SsiValues::normalise(data, fewest_bits as u32, most_bits as u32)
            }
        }
    }

    /// The largest number that is taken while `length` is the active measuring length.
    #[must_use]
    pub const fn largest(self, length: u32) -> u32 {
        match self {
            Self::Number { high, .. } => high,
            Self::UpToMeasuringLength => length,
            Self::Nothing | Self::DirectionAndCode | Self::SsiValues { .. } => DATA_MAX,
        }
    }

    /// The status bits that a number sets at once, although it is stored; most set none.
    #[must_use]
    pub const fn invalid(self, value: u32) -> ErrorStatus {
        match self {
            Self::Number { demand: Demand::NotZero(status), .. } if value == 0 => status,
            _ => ErrorStatus::empty(),
        }
    }

    /// The same at the data check, with the measuring length beside it.
    #[must_use]
    pub const fn invalid_beside(self, value: u32, length: u32) -> ErrorStatus {
        match self {
            Self::Number { demand: Demand::UpToMeasuringLength(status), .. } if value > length => status,
            _ => self.invalid(value),
        }
    }
}

/// What a new encoder holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Factory {
    Value(u32),
    /// So many steps as the rod has hundredths of a millimetre.
    HundredthsOfAMillimetre,
}
