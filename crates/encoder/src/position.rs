//! From a raw sample to the position that the bus and the SSI show, in whole numbers.
//!
//! Rotary: `E' = E`, falling `-1 - E`; `phase = (E' * D + offset) mod (Q * N)`; `value = floor(phase * (S + 1) / (Q * N))`.
//! Linear: `x' = x`, decreasing `L - x`; `value = (floor(x' * S / L) + offset) mod 2^24`.

use core::num::NonZeroU64;
use encoring_words::ParameterSet;

use encoring_words::model::{SENSOR_TURNS, Sensor};
use encoring_words::parameter::Direction;
use encoring_words::word::DATA_MAX;

use crate::unit::ZeroLoss;

/// Where a preset has put the zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offset {
    /// Rotary: phases, 0..Q*N at the preset. Linear: steps, mod 2^24.
    pub num: u32,
    /// Rotary: the denominator that was active at the preset, never 0. Linear: 1.
    pub denominator: u8,
}

impl Offset {
    /// No preset yet.
    pub const NONE: Self = Self { num: 0, denominator: 1 };

    /// The offset under another denominator, always from the kept pair.
    const fn under(self, denominator: u64) -> u64 {
        let kept = self.denominator as u64;
        if kept == denominator || kept == 0 { self.num as u64 } else { self.num as u64 * denominator / kept }
    }
}

/// The active parameters and the offset, ready to turn samples into positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// A shaft.
    Rotary {
        /// Counting direction.
        direction: Direction,
        /// S + 1, the number of positions.
        values: NonZeroU64,
        /// Q * N, the phases of one range.
        phases: NonZeroU64,
        /// D.
        denominator: u64,
        /// Added to the phase.
        offset: u64,
    },
    /// A rod.
    Linear {
        /// Counting direction.
        direction: Direction,
        /// S.
        length: u64,
        /// L in micrometres.
        rod_um: NonZeroU64,
        /// Added to the position.
        offset: u64,
    },
}

impl Scale {
    /// The scale of a parameter set that is valid for `sensor`.
    #[must_use]
    pub fn new(sensor: Sensor, active: &ParameterSet, offset: Offset) -> Self {
        let direction = active.counting_direction().direction;
        match sensor {
            Sensor::Rotary { steps_per_turn } => {
                let denominator = u64::from(active.denominator());
                Self::Rotary {
                    direction,
                    values: NonZeroU64::MIN.saturating_add(u64::from(active.measuring_length())),
                    phases: at_least_1(u64::from(steps_per_turn) * u64::from(active.numerator())),
                    denominator,
                    offset: offset.under(denominator),
                }
            }
            Sensor::Linear { rod_um } => Self::Linear {
                direction,
                length: u64::from(active.measuring_length()),
                rod_um: at_least_1(u64::from(rod_um)),
                offset: u64::from(offset.num),
            },
        }
    }

    /// The position of a sample, 0..=S for a shaft, 24 bits for a rod. A rod's sample lies on the rod.
    #[must_use]
    pub fn position(&self, sample: i64) -> u32 {
        match *self {
            Self::Rotary { values, phases, offset, .. } => {
                let phase = (self.turned(sample) + offset) % phases;
                (phase * values.get() / phases) as u32
            }
            Self::Linear { offset, .. } => ((self.turned(sample) + offset) & u64::from(DATA_MAX)) as u32,
        }
    }

    /// How far the preset has moved the positions, in steps: of a shaft around the range, 0..=S, rounded down; of a rod to
    /// either side.
    #[must_use]
    pub const fn preset_shift(&self) -> i64 {
        match *self {
            Self::Rotary { values, phases, offset, .. } => {
                (offset % phases.get() * values.get() / phases.get()) as i64
            }
            Self::Linear { offset, .. } => {
                let range = DATA_MAX as i64 + 1;
                let shift = offset as i64 % range;
                if shift > range / 2 { shift - range } else { shift }
            }
        }
    }

    /// The offset that makes `sample` show `value`: for a shaft the one with the smallest phase whose value it is.
    #[must_use]
    pub fn preset(&self, sample: i64, value: u32) -> Offset {
        let value = u64::from(value);
        match *self {
            Self::Rotary { values, phases, denominator, .. } => {
                // The smallest phase of the value: rounded up.
                let wanted = (value * phases.get() + (values.get() - 1)) / values;
                let num = (wanted % phases + phases.get() - self.turned(sample) % phases) % phases;
                Offset { num: num as u32, denominator: denominator as u8 }
            }
            Self::Linear { .. } => {
                let num = value.wrapping_sub(self.turned(sample)) & u64::from(DATA_MAX);
                Offset { num: num as u32, denominator: 1 }
            }
        }
    }

    /// The sample in the counting direction: phases for a shaft (congruent to `E' * D`), steps for a rod.
    fn turned(&self, sample: i64) -> u64 {
        match *self {
            Self::Rotary { direction, phases, denominator, .. } => {
                let steps = match direction {
                    Direction::Rising => sample,
                    Direction::Falling => -1 - sample,
                };
                // Reduced first, so that no shaft position overflows: below 2^29 * 99.
                let rest = steps.unsigned_abs() % phases;
                let reduced = if steps < 0 && rest != 0 { phases.get() - rest } else { rest };
                reduced * denominator
            }
            Self::Linear { direction, length, rod_um, .. } => {
                let x = (sample.max(0) as u64).min(rod_um.get());
                let from_start = match direction {
                    Direction::Rising => x,
                    Direction::Falling => rod_um.get() - x,
                };
                from_start * length / rod_um
            }
        }
    }
}

/// A divisor; no valid parameter set makes one that is 0.
const fn at_least_1(value: u64) -> NonZeroU64 {
    match NonZeroU64::new(value) {
        Some(value) => value,
        None => NonZeroU64::MIN,
    }
}

/// Where the shaft is taken to be at power-up: the place congruent to `raw` modulo 4096 turns that is nearest to the
/// last sample before power-off, or to 0 if there is none [R63, C29].
#[must_use]
pub fn found_at_power_up(raw: i64, last: Option<i64>, steps_per_turn: u32, zero_loss: ZeroLoss) -> i64 {
    let turn = i64::from(steps_per_turn.max(1));
    let span = turn * i64::from(SENSOR_TURNS);
    let from = last.unwrap_or(0);
    let mut travel = raw.wrapping_sub(from).rem_euclid(span);
    if travel > span / 2 {
        travel -= span;
    }
    let nearest = from.wrapping_add(travel);
    match zero_loss {
        ZeroLoss::WorstAllowed if last.is_some() && travel.abs() > 512 * turn => {
            nearest.wrapping_sub(travel.signum() * span)
        }
        _ => nearest,
    }
}
