//! Any line to the control port: it is refused, or it is something that the world can do.
#![no_main]

use std::sync::OnceLock;

use encoring_encoder::Unit;
use encoring_sim::motion::Motion;
use encoring_sim::scenario::{Change, NewMotion};
use encoring_sim::{Scenario, World};
use encoring_station::verbs::{Command, ID_BYTES_MAX, parse};
use encoring_words::{InWord, OutWord};
use libfuzzer_sys::fuzz_target;

fn world() -> &'static (World, Vec<Unit>) {
    static WORLD: OnceLock<(World, Vec<Unit>)> = OnceLock::new();
    WORLD.get_or_init(|| {
        let scenario = Scenario::built_in().expect("it is part of the program");
        let units = scenario.devices.iter().map(|device| device.unit).collect();
        (World::new(&scenario).expect("three encoders"), units)
    })
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(line) = str::from_utf8(bytes) else { return };
    let (world, units) = world();
    let request = parse(line, &units[..]);
    if let Some(id) = request.id {
        assert!(line.contains(id.get()), "{}", id.get());
        assert!(id.get().len() <= ID_BYTES_MAX, "{}", id.get());
    }
    let mut world = world.clone();
    match request.command {
        Err(refused) => {
            assert!(!refused.to_string().is_empty());
            return;
        }
        Ok(Command::Set { position, changes }) => {
            assert!(position < units.len() && !changes.is_empty());
            for change in &changes {
                let recorded = matches!(change, Change::Motion(NewMotion::Motion(Motion::Recorded { .. })));
                assert!(!recorded, "a peer had a file opened");
            }
            world.change(position, &changes);
        }
        Ok(Command::Out { position, word }) => {
            let mut out = [OutWord(0); 3];
            *out.get_mut(position).expect("a position of the ring") = word;
            world.cycle(&out, &mut [InWord(0); 3]);
        }
        Ok(Command::Serve { position, request }) => {
            assert!(position < units.len() && request.word().service_bit());
            return;
        }
        Ok(Command::Line { segment, fault, lasting }) => {
            assert!(segment <= units.len());
            world.trouble(segment, fault, lasting);
        }
        Ok(Command::EndLine) => world.end_trouble(),
        Ok(Command::Misbehave { fault }) => {
            // Another crate reads it.
            assert!(fault.len() <= line.len());
            return;
        }
        Ok(
            Command::EndGateway { .. }
            | Command::GatewayFaults
            | Command::Acknowledge { .. }
            | Command::View
            | Command::Help,
        ) => return,
    }
    let mut input = [InWord(0); 3];
    for out in [0, 0xC200_1000, 0xC200_1000, 0] {
        world.cycle(&[OutWord(out); 3], &mut input);
    }
});
