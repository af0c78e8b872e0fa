//! What an encoder is from the day it was built.

use core::fmt;
use core::str::FromStr;

use encoring_words::model::{Sensor, SensorError};
use encoring_words::{Access, Duration, Model, Service, Week};

/// How long each kind of service takes from the request to its completion. No manual gives figures; the defaults
/// are this project's choice. 0 makes the reply appear in the exchange of the request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServiceTimes {
    /// Reading a parameter, and every other read but the data check.
    pub read: Duration,
    /// Writing a parameter, and every other write but the preset adjustment.
    pub write: Duration,
    /// Service 08.
    pub data_check: Duration,
    /// Service 06.
    pub preset_adjustment: Duration,
}

impl ServiceTimes {
    /// Every reply in the exchange of its request.
    pub const ZERO: Self = Self {
        read: Duration::ZERO,
        write: Duration::ZERO,
        data_check: Duration::ZERO,
        preset_adjustment: Duration::ZERO,
    };

    /// What a new [`Unit`] has.
    pub const DEFAULT: Self = Self {
        read: Duration::ZERO,
        write: Duration::from_millis(10),
        data_check: Duration::from_millis(20),
        preset_adjustment: Duration::from_millis(10),
    };

    /// The time of one request; `None` stands for a service number that no manual lists.
    #[must_use]
    pub const fn of(&self, service: Option<Service>, access: Access) -> Duration {
        match (service, access) {
            (Some(Service::DataCheck), Access::Read) => self.data_check,
            (Some(Service::PresetAdjustment), Access::Write) => self.preset_adjustment,
            (_, Access::Read) => self.read,
            (_, Access::Write) => self.write,
        }
    }
}

impl Default for ServiceTimes {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Where a shaft is taken to be after it moved without supply [R63].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ZeroLoss {
    /// Right up to 2048 turns, the best that 4096 turns of sensor allow.
    #[default]
    Nearest,
    /// The worst that the manual allows: beyond 512 turns a further 4096 turns off, against the travel.
    WorstAllowed,
}

/// What is made of a service bit that is 1 in the first OUT word after power-up or after a reset of the bus [D1, D43].
/// What a real encoder does is not known, so controller programs should be tested against both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StaleService {
    /// It is no request until a cycle has brought 0.
    #[default]
    Ignored,
    /// The word counts as it is: a preset that still stands is done a second time.
    Executed,
}

impl fmt::Display for StaleService {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ignored => "ignored",
            Self::Executed => "executed",
        })
    }
}

/// A text that names no [`StaleService`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoStaleService;

impl fmt::Display for NoStaleService {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a stale service bit is ignored or executed")
    }
}

impl core::error::Error for NoStaleService {}

impl FromStr for StaleService {
    type Err = NoStaleService;

    fn from_str(text: &str) -> Result<Self, NoStaleService> {
        match text {
            "ignored" => Ok(Self::Ignored),
            "executed" => Ok(Self::Executed),
            _ => Err(NoStaleService),
        }
    }
}

/// One encoder as delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    model: Model,
    sensor: Sensor,
    /// Week of its firmware; what the AK-40 format depends on.
    pub firmware: Week,
    /// Its service times.
    pub service_times: ServiceTimes,
    /// What it makes of a shaft that moved without supply.
    pub zero_loss: ZeroLoss,
    /// What it makes of a service bit that stood while it was off or its bus in reset.
    pub stale_service: StaleService,
}

impl Unit {
    /// An encoder with present-day firmware and default service times.
    ///
    /// # Errors
    /// [`SensorError`] if the model is not built with the sensor.
    pub const fn new(model: Model, sensor: Sensor) -> Result<Self, SensorError> {
        match model.built_with(sensor) {
            Ok(sensor) => Ok(Self {
                model,
                sensor,
                firmware: Week::AK40,
                service_times: ServiceTimes::DEFAULT,
                zero_loss: ZeroLoss::Nearest,
                stale_service: StaleService::Ignored,
            }),
            Err(wrong) => Err(wrong),
        }
    }

    /// Its model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.model
    }

    /// What it measures with.
    #[must_use]
    pub const fn sensor(&self) -> Sensor {
        self.sensor
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn what_becomes_of_a_stale_service_bit_has_two_names() {
        for known in [StaleService::Ignored, StaleService::Executed] {
            assert_eq!(known.to_string().parse(), Ok(known));
        }
        for wrong in ["", "Ignored", "worst", "executed "] {
            assert_eq!(wrong.parse::<StaleService>(), Err(NoStaleService), "{wrong:?}");
        }
    }
}
