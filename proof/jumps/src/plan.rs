//! How a recording is made: encoder, axis, period, columns, what is told beside it. Drawn from the seed.

use crate::cause::Cause;
use crate::chance::Chance;
use crate::device::{DEVICES, Device, Kind, Scaling};
use crate::scene::Column;
use crate::travel::{Axis, Manner};

const DEFAULT: Device = DEVICES[0];
/// Milliseconds from row to row.
const PERIODS_MS: [f64; 15] =
    [0.5, 1.0, 1.0, 2.0, 2.0, 4.0, 5.0, 10.0, 10.0, 12.7, 20.0, 50.0, 100.0, 250.0, 1_000.0];
/// Steps of a sensor in a radian, and in a turn a minute.
const RADIAN: f64 = 113.0 / 710.0;

/// Everything about a recording but its jumps.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) device: Device,
    pub(crate) scaling: Scaling,
    pub(crate) axis: Axis,
    /// What the data sheet allows, in the units of the axis.
    pub(crate) sheet_acceleration: f64,
    pub(crate) top_speed: f64,
    pub(crate) rows: usize,
    /// Seconds.
    pub(crate) period: f64,
    /// How much later than its time a row is taken, at most.
    pub(crate) late: f64,
    pub(crate) stamps: Stamps,
    /// Of a thousand rows, so many are missing, and so many stand twice.
    pub(crate) dropped: u32,
    pub(crate) repeated: u32,
    pub(crate) column: Column,
    pub(crate) out_logged: bool,
    pub(crate) model_told: bool,
    pub(crate) scaling_told: bool,
    /// Another encoder stands in the same rows.
    pub(crate) neighbour: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stamps {
    Exact,
    WholeMilliseconds,
}

impl Plan {
    pub(crate) fn draw(chance: &mut Chance) -> Self {
        let device = chance.of(&DEVICES, DEFAULT);
        let period = chance.of(&PERIODS_MS, 1.0) / 1_000.0;
        let rows = chance.between(250, 1_400).unsigned_abs() as usize;
        let lasting = period * rows as f64;
        let exact = chance.percent(60);
        let column = match chance.between(0, 99) {
            0..=44 => Column::Word,
            45..=69 => Column::Low24,
            70..=77 => Column::Low16,
            _ => Column::Decimal,
        };
        let (sheet_acceleration, top_speed) = limits(&device);
        Self {
            scaling: scaling(&device, chance),
            axis: axis(&device, period, lasting, chance),
            device,
            sheet_acceleration,
            top_speed,
            rows,
            period,
            late: if exact { 0.0 } else { period * chance.real(0.01, 0.2) },
            stamps: if period >= 0.002 && chance.percent(25) {
                Stamps::WholeMilliseconds
            } else {
                Stamps::Exact
            },
            dropped: if chance.percent(25) { 10 } else { 0 },
            repeated: if chance.percent(20) { 10 } else { 0 },
            column,
            out_logged: chance.percent(40),
            model_told: chance.percent(60),
            scaling_told: chance.percent(45),
            neighbour: chance.percent(10),
        }
    }

    /// Makes it one in which this cause can happen and, often enough, be told.
    pub(crate) fn suit(&mut self, cause: Cause, chance: &mut Chance) {
        let of =
            |wanted: fn(&Device) -> bool| DEVICES.iter().copied().filter(wanted).collect::<Vec<Device>>();
        let devices = match cause {
            Cause::ZeroLost | Cause::OverSpeed | Cause::OverAcceleration | Cause::Wrap => {
                of(|device| device.kind == Kind::Shaft)
            }
            Cause::GrayAsBinary => of(|device| device.may_be_gray),
            Cause::Aliasing => of(|device| device.refresh_us == 1_000),
            Cause::Mechanical if chance.percent(60) => of(|device| !device.preset_inputs),
            _ => return,
        };
        self.device = chance.of(&devices, self.device);
        self.scaling = scaling(&self.device, chance);
        (self.sheet_acceleration, self.top_speed) = limits(&self.device);
        match cause {
            Cause::ZeroLost => {
                // A known place is said of no encoder in particular.
                self.neighbour = false;
                // Powers of two hide it.
                let (numerator, denominator) =
                    chance.of(&[(10, 1), (36, 10), (7, 2), (100, 3), (1_000, 1)], (10, 1));
                let length = self.device.native * numerator / denominator - 1;
                self.scaling = Scaling { length, numerator, denominator, ..self.scaling };
            }
            Cause::OverSpeed | Cause::OverAcceleration => {
                (self.model_told, self.scaling_told) =
                    if chance.percent(80) { (true, true) } else { (false, false) };
                self.period = chance.of(&[0.001, 0.002, 0.005, 0.01, 0.02], 0.01);
            }
            Cause::Mechanical => (self.model_told, self.out_logged) = (true, chance.percent(80)),
            Cause::Aliasing => self.period = 0.000_5,
            _ => {}
        }
        let lasting = self.period * self.rows as f64;
        self.late = self.late.min(self.period * 0.2);
        if self.period < 0.002 {
            self.stamps = Stamps::Exact;
        }
        self.axis = axis(&self.device, self.period, lasting, chance);
    }

    /// How far a stamp may lie from when its row was taken, in seconds.
    pub(crate) fn jitter(&self) -> f64 {
        match self.stamps {
            Stamps::Exact => 0.000_001,
            Stamps::WholeMilliseconds => 0.001,
        }
    }
}

/// The largest acceleration and speed [R124]; a rod's manual has none, so its axis is as good as the strongest here.
pub(crate) fn limits(device: &Device) -> (f64, f64) {
    match device.kind {
        Kind::Shaft => (10_000.0 * device.native as f64 * RADIAN, 100.0 * device.native as f64),
        Kind::Rod => (20.0e6, 2.0e6),
    }
}

fn axis(device: &Device, period: f64, lasting: f64, chance: &mut Chance) -> Axis {
    let native = device.native as f64;
    let manner = match chance.between(0, 99) {
        0..=9 => Manner::Stands,
        10..=39 => Manner::Runs,
        40..=74 => Manner::Changes,
        75..=94 => Manner::Strokes,
        _ if period <= 0.002 => Manner::Vibrates,
        _ => Manner::Changes,
    };
    let (speed, acceleration, ends) = match device.kind {
        Kind::Shaft => {
            let acceleration = chance.scaled(10.0, 9_000.0) * native * RADIAN;
            (chance.scaled(3.0, 5_800.0) / 60.0 * native, acceleration, None)
        }
        Kind::Rod => (
            chance.scaled(5_000.0, 1.8e6),
            chance.scaled(0.2e6, 18.0e6),
            Some((0.03 * native, 0.97 * native)),
        ),
    };
    // What cannot be reached within a part of the recording would never show.
    let speed = speed.min(acceleration * lasting / 6.0);
    let holds = (period * 40.0, (period * 500.0).max(speed / acceleration));
    Axis { speed, acceleration, holds, ends, manner }
}

fn scaling(device: &Device, chance: &mut Chance) -> Scaling {
    let falling = chance.percent(20);
    let drawn = match device.kind {
        Kind::Rod => {
            let per_mm = chance.of(&[10, 100, 100, 100, 200, 1_000], 100);
            let length = (device.native / 1_000 * per_mm).min((1 << 24) - 1);
            return Scaling {
                length,
                numerator: 1,
                denominator: 1,
                falling,
                offset: chance.between(0, 4_000_000),
            };
        }
        Kind::Shaft if chance.percent(45) => (1 << 24, 4_096, 1),
        Kind::Shaft => {
            let (numerator, denominator) = chance.of(
                &[
                    (1, 1),
                    (2, 1),
                    (7, 2),
                    (10, 1),
                    (36, 10),
                    (64, 1),
                    (100, 1),
                    (100, 3),
                    (512, 1),
                    (1_000, 1),
                    (2_048, 1),
                ],
                (10, 1),
            );
            let most = (device.native * numerator / denominator).min(1 << 24);
            (
                chance
                    .of(&[most, most, most / 2, most * 4 / 5, 1_000.min(most) * (most / 1_000).max(1)], most),
                numerator,
                denominator,
            )
        }
    };
    let (positions, numerator, denominator) = drawn;
    let offset = chance.between(0, device.native * numerator - 1);
    Scaling { length: positions - 1, numerator, denominator, falling, offset }
}
