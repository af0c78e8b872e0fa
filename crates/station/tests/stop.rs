//! The judge of positions beside a simulated encoder: the stop is called as soon as its error bit is there.
#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

use std::path::Path;

use encoring_host::Seen;
use encoring_host::validity::{Expectation, Limits, Stop, Validity};
use encoring_sim::{Scenario, World};
use encoring_words::{Duration, InWord, OutWord, ParameterSet};

const SCENARIO: &str = r#"
version = 1
[[device]]
position = 0
model = "la-66"
service_times = "zero"
motion = { kind = "speed", start = 1000, per_s = 100_000 }
[[event]]
at_s = 0.1
position = 0
set = { magnet = false }
[[event]]
at_s = 0.2
position = 0
set = { magnet = true }
"#;

// [R143]
#[test]
fn the_stop_is_called_in_the_first_cycle_in_which_an_encoder_shows_its_error_bit_and_once() {
    let scenario = Scenario::parse("stop", SCENARIO, Path::new("")).unwrap();
    let unit = scenario.devices.first().unwrap().unit;
    let mut world = World::new(&scenario).unwrap();
    let factory = ParameterSet::factory(unit.model(), unit.sensor());
    let expectation = Expectation::new(unit.model(), unit.sensor(), &factory).unwrap();
    let mut validity = Validity::new(expectation, Limits::of(unit.model(), world.cycle_time()));
    let mut input = [InWord(0)];
    let (mut stops, mut errors, mut valid) = (Vec::new(), Vec::new(), 0);
    while world.now().as_nanos() < 300_000_000 {
        world.cycle(&[OutWord(0)], &mut input);
        let [word] = input;
        if word.error_bit() {
            errors.push(world.now());
        }
        let now = world.now();
        let seen = Seen { input: word, age: Duration::ZERO };
        let position = validity.judge(now, Some(seen), &mut |stop| stops.push((now, stop)));
        valid += u32::from(position.valid().is_some());
        assert!(position.valid().is_none() || !word.error_bit(), "a position with bit 29 is none");
    }
    // The error stays although the magnet is back; only a data check ends it.
    assert_eq!(errors.last(), Some(&world.now()));
    assert_eq!(stops, [(*errors.first().unwrap(), Stop::Error(None))]);
    assert!(valid > 100, "before, the positions were valid: {valid}");
}
