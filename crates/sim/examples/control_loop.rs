//! The loop of a controller: one call a cycle gives a judged position, and a service runs beside it.
//!
//! `cargo run -p encoring-sim --example control_loop`. The bus is a simulated ring here; with another one only the three
//! lines that read and write it change.

use std::path::Path;

use encoring_host::axis::{AxisCycle, JudgedAxis};
use encoring_host::validity::{Expectation, Limits};
use encoring_host::{Request, Seen, Timing};
use encoring_ring::Verdict;
use encoring_sim::{Scenario, World};
use encoring_words::model::Sensor;
use encoring_words::{Duration, InWord, Instant, Model, OutWord, ParameterSet};

const RING: &str = r#"
version = 1
[[device]]
position = 0
model = "ce-65-m"
motion = { kind = "speed", rpm = 60.0, start = 1000 }
[[event]]
at_s = 0.5
segment = 0
line = "silent"
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::new(&Scenario::parse("example", RING, Path::new(""))?)?;
    let sensor = Sensor::Rotary { steps_per_turn: 4096 };
    let expectation = Expectation::new(Model::Ce65M, sensor, &ParameterSet::factory(Model::Ce65M, sensor))?;
    let limits = Limits::of(Model::Ce65M, world.cycle_time());
    let mut axis = JudgedAxis::new(Timing::DIRECT, OutWord(0), expectation, limits);
    // A device shows its position from the second cycle on.
    world.cycle(&[axis.out()], &mut [InWord(0)]);
    let (mut adjusted, mut stopped) = (false, false);
    while !stopped {
        let mut input = [InWord(0)];
        let cycled = world.cycle(&[axis.out()], &mut input);
        let seen = (cycled.verdict == Verdict::Good).then_some(Seen { input: input[0], age: Duration::ZERO });

        let ms = cycled.at.as_nanos() / 1_000_000;
        let AxisCycle { position, outcome, .. } = axis.cycle(cycled.at, seen, &mut |why| {
            println!("{ms} ms: stop the machine: {why:?}");
            stopped = true;
        });
        if let Some(outcome) = outcome {
            println!("{ms} ms: {outcome:?}, position {position:?}");
        }
        if !adjusted && cycled.at > Instant(100_000_000) {
            println!("{ms} ms: position {position:?}; it shall be 5000");
            axis.start(cycled.at, Request::preset(Model::Ce65M, 5000, 0xFF_FFFF)?)?;
            adjusted = true;
        }
    }
    Ok(())
}
