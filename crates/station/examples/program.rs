//! Programming over a bus: 1000 steps a turn over ten turns, all of it or nothing.
//!
//! `cargo run -p encoring-station --example program`. The bus is a simulated ring; `encoring_modbus::Client` is one
//! behind a gateway, and nothing else changes.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_bus::EncoderMaster;
use encoring_host::program::Program;
use encoring_sim::{Scenario, World};
use encoring_station::{Simulated, Speed};
use encoring_words::{Duration, Model, Parameter};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut bus = Simulated::new(World::new(&Scenario::built_in()?)?, Speed::Max);
    let stop = Arc::new(AtomicBool::new(false));
    let mut encoder = EncoderMaster::new(&mut bus, 2, Duration::from_millis(2_000), stop)?;

    let mut program = Program::new(Model::Ce65M, Some(4096));
    program.set(Parameter::MeasuringLength, 9_999)?;
    program.set(Parameter::Numerator, 10)?;
    program.set(Parameter::Denominator, 1)?;
    let report = program.run(&mut encoder);

    for row in report.rows.iter().flatten() {
        println!("{:<20}{:?} -> {:?}", row.parameter.key(), row.before, row.now);
    }
    println!("position {:?} -> {:?}", report.shown_before, report.shown_after);
    report.result.map_err(|stopped| format!("{stopped:?}").into())
}
