//! What is known of an encoder beforehand: its active values, and how fast its shaft or magnet may move.

use core::num::NonZeroU32;

use encoring_words::model::{Sensor, SensorKind};
use encoring_words::parameter::{Code, OutOfRange, Parameter};
use encoring_words::{Duration, ErrorStatus, Model, ParameterSet};

use super::track::{Circle, Space};

/// What the positions of an encoder must be like, from its active set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expectation {
    pub(super) code: Code,
    /// The largest position.
    pub(super) largest: u32,
    /// S.
    pub(super) measuring_length: u32,
    moved: Moved,
}

/// What moves, in the units that [`Space`] explains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moved {
    Shaft { step: i128, native: i128, turn: i128 },
    Magnet { rod_um: i128 },
}

/// Why nothing can be expected of an encoder with these values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoExpectation {
    /// A rod with a shaft's model or a shaft with a rod's, or a sensor without a step.
    #[error("the {model} has no such sensor: {sensor:?}")]
    Sensor {
        /// The model.
        model: Model,
        /// The sensor.
        sensor: Sensor,
    },
    /// No encoder stores this value.
    #[error("{parameter:?}: {refused}")]
    Parameter {
        /// Whose value it is.
        parameter: Parameter,
        /// The value and its range.
        refused: OutOfRange,
    },
    /// No encoder makes this set active: its data check answers with these bits.
    #[error("the data check would refuse the set with status {:04X}h", .0.bits())]
    Set(ErrorStatus),
}

impl Expectation {
    /// For the values that are active now, as the master knows them. The presets do not matter, nor the counting
    /// direction.
    ///
    /// # Errors
    /// [`NoExpectation`] if no encoder can have these values active.
    pub fn new(model: Model, sensor: Sensor, active: &ParameterSet) -> Result<Self, NoExpectation> {
        let check = |parameter: Parameter| {
            let value = active.value(parameter);
            parameter
                .normalise(model, value)
                .map_err(|refused| NoExpectation::Parameter { parameter, refused })
        };
        let measuring_length = check(Parameter::MeasuringLength)?;
        let length = i128::from(measuring_length);
        let may_be_gray = model.position_may_be_gray();
        let code = if may_be_gray { active.counting_direction().code } else { Code::Binary };
        let largest = model.largest_position(measuring_length);
        match (model.sensor_kind(), sensor) {
            (SensorKind::Linear, Sensor::Linear { rod_um }) if rod_um > 0 => Ok(Self {
                code,
                largest,
                measuring_length,
                moved: Moved::Magnet { rod_um: i128::from(rod_um) },
            }),
            (SensorKind::Rotary, Sensor::Rotary { steps_per_turn }) if steps_per_turn > 0 => {
                let numerator = i128::from(check(Parameter::Numerator)?);
                let denominator = i128::from(check(Parameter::Denominator)?);
                let wrong = active.validity(model, sensor)
                    & (ErrorStatus::NUMERATOR_ZERO | ErrorStatus::LENGTH_TOO_LARGE);
                if !wrong.is_empty() {
                    return Err(NoExpectation::Set(wrong));
                }
                let native = denominator * (length + 1);
                let steps_per_turn = i128::from(steps_per_turn);
                Ok(Self {
                    code,
                    largest,
                    measuring_length,
                    moved: Moved::Shaft {
                        step: steps_per_turn * numerator,
                        native,
                        turn: steps_per_turn * native,
                    },
                })
            }
            _ => Err(NoExpectation::Sensor { model, sensor }),
        }
    }

    /// The same with the limits of a movement.
    pub(super) fn space(&self, limits: &Limits) -> Space {
        let of = |limit: Option<NonZeroU32>| limit.map(|limit| i128::from(limit.get()));
        let circle = self.circle();
        match self.moved {
            Moved::Shaft { step, native, turn } => Space {
                circle,
                step,
                blur: step + native,
                speed: of(limits.speed_rpm).map(|rpm| ceil(rpm * turn, 60)),
                // 1/(2 pi) is a little less than 16551/103993, so that no shaft within its limit lies above.
                acceleration: of(limits.acceleration_rad_s2).map(|a| ceil(a * turn * 16_551, 103_993)),
                reach: None,
            },
            Moved::Magnet { rod_um } => {
                let micrometre = i128::from(self.measuring_length);
                let of_mm = |limit| of(limit).map(|mm| mm * 1_000 * micrometre);
                Space {
                    circle,
                    step: rod_um,
                    blur: rod_um + micrometre,
                    speed: of_mm(limits.speed_mm_s),
                    acceleration: of_mm(limits.acceleration_mm_s2),
                    reach: Some(i64::from(self.measuring_length)),
                }
            }
        }
    }

    /// The positions that there are.
    #[must_use]
    pub const fn circle(&self) -> Circle {
        Circle { positions: self.largest as i64 + 1 }
    }

    /// The code of the positions on the bus.
    #[must_use]
    pub const fn code(&self) -> Code {
        self.code
    }

    /// The largest speed and acceleration, in steps.
    #[must_use]
    pub fn swiftest(&self, limits: &Limits) -> Swiftest {
        let space = self.space(limits);
        let steps = |units: Option<i128>| {
            let units = units.filter(|_| space.step > 0)?;
            Some(i64::try_from(ceil(units, space.step)).unwrap_or(i64::MAX))
        };
        Swiftest { steps_per_s: steps(space.speed), steps_per_s2: steps(space.acceleration) }
    }

    /// `true` for a rod, whose encoder holds the last place of a magnet that is gone.
    pub(super) const fn holds(&self) -> bool {
        matches!(self.moved, Moved::Magnet { .. })
    }
}

/// The largest speed and acceleration of what is measured, in steps of the position; `None` without a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Swiftest {
    /// Steps a second.
    pub steps_per_s: Option<i64>,
    /// Steps a second squared.
    pub steps_per_s2: Option<i64>,
}

/// Rounded up; both above 0.
const fn ceil(dividend: i128, divisor: i128) -> i128 {
    dividend / divisor + (dividend % divisor != 0) as i128
}

/// How fast the shaft or the magnet may move, and how old a position may be. `None`: without limit. What does not concern the encoder's sensor is not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Speed of a shaft in revolutions per minute.
    pub speed_rpm: Option<NonZeroU32>,
    /// Angular acceleration of a shaft in rad/s^2.
    pub acceleration_rad_s2: Option<NonZeroU32>,
    /// Speed of a magnet in mm/s.
    pub speed_mm_s: Option<NonZeroU32>,
    /// Acceleration of a magnet in mm/s^2.
    pub acceleration_mm_s2: Option<NonZeroU32>,
    /// How old a sample may be when the encoder gives its IN word [R8, R9].
    pub refresh: Duration,
    /// How long the IN word may then stay on the ring before the bus counts its age: the longest data cycle.
    pub cycle: Duration,
    /// A position is stale when the word that brought it may be older than this.
    pub stale_after: Duration,
}

impl Limits {
    /// The limits of a model's data sheet, on a ring whose data cycle takes at most `cycle`; stale after 100 ms.
    ///
    /// 6000 rpm and 10^4 rad/s^2 [R124] for the CE-65-M, and by assumption for the CE-100-M. The LA-66's manual gives
    /// no limit. 100 ms are this project's choice.
    #[must_use]
    pub const fn of(model: Model, cycle: Duration) -> Self {
        let (speed_rpm, acceleration_rad_s2) = match model.mechanics() {
            Some(mechanics) => {
                (NonZeroU32::new(mechanics.speed_rpm), NonZeroU32::new(mechanics.acceleration_rad_s2))
            }
            None => (None, None),
        };
        Self {
            speed_rpm,
            acceleration_rad_s2,
            speed_mm_s: None,
            acceleration_mm_s2: None,
            refresh: model.refresh(),
            cycle,
            stale_after: Duration::from_millis(100),
        }
    }
}
