//! Any text as a scenario: it is refused with its place, or it is a world that runs.
#![no_main]

use std::path::Path;

use encoring_sim::{Scenario, World};
use encoring_words::model::Sensor;
use encoring_words::word::In;
use encoring_words::{InWord, OutWord};
use libfuzzer_sys::fuzz_target;

/// Beside nothing, so that a recorded motion is never found.
const NOWHERE: &str = "/nonexistent/scenarios";
const CYCLES: u32 = 40;
const ENCODERS_RUN: usize = 6;
const EVENTS_RUN: usize = 50;

/// `true` if a value anywhere in the text is an absolute path: a fuzzer shall open no file, and one behind such a
/// path may be a device that never ends.
fn names_a_file(text: &str) -> bool {
    fn within(value: &toml::Value) -> bool {
        match value {
            toml::Value::String(text) => Path::new(text).is_absolute(),
            toml::Value::Array(values) => values.iter().any(within),
            toml::Value::Table(table) => table.values().any(within),
            _ => false,
        }
    }
    (text.contains("file") || text.contains('\\'))
        && toml::from_str::<toml::Table>(text).is_ok_and(|table| table.values().any(within))
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = str::from_utf8(bytes) else { return };
    if names_a_file(text) {
        return;
    }
    let scenario = match Scenario::parse("fuzz.toml", text, Path::new(NOWHERE)) {
        Ok(scenario) => scenario,
        Err(refused) => {
            let lines = text.matches('\n').count() + 1;
            assert!(refused.line.is_none_or(|line| (1..=lines).contains(&line)), "{refused}");
            assert!(!refused.problem.is_empty());
            return;
        }
    };
    assert!(scenario.events.is_sorted_by_key(|event| event.at));
    let encoders = scenario.devices.len();
    if encoders > ENCODERS_RUN || scenario.events.len() > EVENTS_RUN {
        return;
    }
    let mut world = World::new(&scenario).expect("a scenario has at most 128 encoders");
    let mut twin = World::new(&scenario).expect("a scenario has at most 128 encoders");
    let mut out = vec![OutWord(0); encoders];
    let mut input = vec![InWord(0); encoders];
    let mut twin_input = input.clone();
    for cycle in 0..CYCLES {
        for (position, word) in (0..).zip(&mut out) {
            // Services and normal mode by turns, another service every four cycles.
            let number = (cycle / 4 + position) % 16;
            *word = OutWord((cycle / 2 % 2) << 31 | (cycle / 4 % 2) << 30 | number << 24 | cycle * 77);
        }
        let before = world.now();
        let cycled = world.cycle(&out, &mut input);
        assert_eq!(cycled, twin.cycle(&out, &mut twin_input), "the same scenario gives the same world");
        assert_eq!(input, twin_input, "the same scenario gives the same words");
        assert!(world.now() >= before);
        for (place, word) in world.places().iter().zip(&input) {
            assert!(!matches!(word.decode(), In::Foreign(_)), "{word} is of no encoder");
            if let Some(encoder) = place.node().encoder()
                && let Sensor::Rotary { .. } = encoder.unit().sensor()
            {
                assert!(encoder.position() <= encoder.active().measuring_length());
            }
        }
    }
});
