//! What an encoder is from the day it was built.

use core::fmt;
use core::str::FromStr;

use encoring_words::model::{Sensor, SensorError};
use encoring_words::{Access, Duration, Model, Service};

/// A calendar week, as firmware is dated [R117].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Week {
    year: u16,
    week: u8,
}

/// A text that is no week of the form `41/1997`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAWeek;

impl fmt::Display for NotAWeek {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a firmware week is written WW/YYYY, from 1/1990 to 53/2099, like 41/1997")
    }
}

impl core::error::Error for NotAWeek {}

impl Week {
    /// The first firmware with the AK-40 format [R117, R118].
    pub const AK40: Self = Self { year: 1997, week: 41 };

    /// A week of a year.
    ///
    /// # Errors
    /// [`NotAWeek`] outside weeks 1..=53 and years 1990..=2099.
    pub const fn new(week: u8, year: u16) -> Result<Self, NotAWeek> {
        if week == 0 || week > 53 || year < 1990 || year > 2099 {
            Err(NotAWeek)
        } else {
            Ok(Self { year, week })
        }
    }
}

impl fmt::Display for Week {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.week, self.year)
    }
}

impl FromStr for Week {
    type Err = NotAWeek;

    fn from_str(text: &str) -> Result<Self, NotAWeek> {
        let (week, year) = text.split_once('/').ok_or(NotAWeek)?;
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if !digits(week) || !digits(year) {
            return Err(NotAWeek);
        }
        Self::new(week.parse().map_err(|_| NotAWeek)?, year.parse().map_err(|_| NotAWeek)?)
    }
}

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

    /// `true` if 31 data bits mean the AK-40 format [R117].
    #[must_use]
    pub fn knows_ak40(&self) -> bool {
        self.firmware >= Week::AK40
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

    #[test]
    fn firmware_weeks_have_an_order() {
        assert_eq!("41/1997".parse(), Ok(Week::AK40));
        assert_eq!(Week::AK40.to_string(), "41/1997");
        assert_eq!(
            NotAWeek.to_string(),
            "a firmware week is written WW/YYYY, from 1/1990 to 53/2099, like 41/1997"
        );
        assert!("40/1997".parse::<Week>().unwrap() < Week::AK40);
        assert!("1/1998".parse::<Week>().unwrap() > Week::AK40);
        for wrong in ["", "41", "41/97", "0/1997", "54/1997", "41/2100", "+1/1997", "41/1997/1"] {
            assert_eq!(wrong.parse::<Week>(), Err(NotAWeek), "{wrong}");
        }
    }

    #[test]
    fn the_first_and_the_last_firmware_week_are_those_of_the_message() {
        for (week, year) in [(1, 1990), (53, 1990), (1, 2099), (53, 2099)] {
            assert_eq!(Week::new(week, year), Ok(Week { year, week }));
        }
        for (week, year) in [(0, 1990), (54, 1990), (53, 1989), (0, 2099), (54, 2099), (1, 2100)] {
            assert_eq!(Week::new(week, year), Err(NotAWeek), "{week}/{year}");
        }
    }
}
