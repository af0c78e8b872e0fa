//! A long recording of an axis that does all that the data sheet allows, and nothing else.

use encoring_diagnosis::{Detector, Episode, JumpCause, Options, Sample, Sighting};
use encoring_words::Model;

use crate::chance::Chance;
use crate::device::{DEVICES, Device, Scaling};
use crate::plan::limits;
use crate::travel::{Axis, Manner, Travel};

/// What is told beside the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    Nothing,
    Model,
}

const CE_65_M: Device = DEVICES[0];

/// How many rows there were, and what was found in them besides the ends of the range.
pub(crate) fn alarms(seed: u64, period_us: u64, seconds: u64, beside: Beside) -> (u64, Vec<Episode>) {
    let mut chance = Chance::new(seed);
    let (acceleration, speed) = limits(&CE_65_M);
    let holds = (0.05, 2.0);
    let axis = Axis { speed, acceleration, holds, ends: None, manner: Manner::Changes };
    let travel = Travel::new(&axis, seconds as f64, &mut chance);
    let scaling =
        Scaling { length: 0x00FF_FFFF, numerator: 4_096, denominator: 1, falling: false, offset: 0 };
    let model = (beside == Beside::Model).then_some(Model::Ce65M);
    let mut detector = Detector::new(Options { model, ..Options::default() });
    let rows = seconds * 1_000_000 / period_us;
    for row in 0..rows {
        let time_us = row * period_us;
        let refresh = CE_65_M.refresh_us.unsigned_abs();
        let sampled = (time_us / refresh * refresh) as f64 / 1e6;
        let word = scaling.value(&CE_65_M, travel.place(sampled).floor() as i64) as u32;
        let reading = Sighting::Word(word);
        detector.sample(Sample { line: row + 2, time_ns: time_us * 1_000, position: 0, out: None, reading });
    }
    let found = detector.finish().episodes;
    (rows, found.into_iter().filter(|episode| episode.cause != JumpCause::Wrap).collect())
}
