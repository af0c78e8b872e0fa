//! An encoder on a bench: polls and what comes of them. The verdicts, the arithmetic's worked values, and shafts at
//! random are one file each.
extern crate std;

use std::vec::Vec;

use encoring_words::model::Sensor;
use encoring_words::{Duration, InWord, Instant, Model, Parameter, ParameterSet};

use super::{Expectation, Limits, Position, Stop, Validity};
use crate::Seen;

mod shafts;
mod verdicts;
mod worked;

const Q4096: Sensor = Sensor::Rotary { steps_per_turn: 4096 };

/// A machine with its clock and what it was told to stop for.
struct Bench {
    validity: Validity,
    now_ns: u64,
    stops: Vec<Stop>,
}

fn set(sensor: Sensor, values: &[(Parameter, u32)]) -> ParameterSet {
    let model = match sensor {
        Sensor::Rotary { .. } => Model::Ce65M,
        Sensor::Linear { .. } => Model::La66,
    };
    let mut set = ParameterSet::factory(model, sensor);
    for (parameter, value) in values {
        set.set(*parameter, *value);
    }
    set
}

fn range(s: u32, n: u32, d: u32) -> [(Parameter, u32); 3] {
    [(Parameter::MeasuringLength, s), (Parameter::Numerator, n), (Parameter::Denominator, d)]
}

/// As its data sheet says, on a ring without a cycle time.
fn sheet(model: Model) -> Limits {
    Limits::of(model, Duration::ZERO)
}

impl Bench {
    fn new(model: Model, sensor: Sensor, values: &[(Parameter, u32)], limits: Limits) -> Self {
        let expectation = Expectation::new(model, sensor, &set(sensor, values)).unwrap();
        Self { validity: Validity::new(expectation, limits), now_ns: 1_000_000_000, stops: Vec::new() }
    }

    fn ce_65_m(limits: Limits) -> Self {
        Self::new(Model::Ce65M, Q4096, &[], limits)
    }

    fn judge(&mut self, after_us: u64, seen: Option<Seen>) -> Position {
        self.now_ns += after_us * 1_000;
        self.validity.judge(Instant(self.now_ns), seen, &mut |stop| self.stops.push(stop))
    }

    /// A word that is new.
    fn poll(&mut self, after_us: u64, word: u32) -> Position {
        self.judge(after_us, Some(Seen { input: InWord(word), age: Duration::ZERO }))
    }

    fn nothing(&mut self, after_us: u64) -> Position {
        self.judge(after_us, None)
    }
}
