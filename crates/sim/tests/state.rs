//! Encoders that are switched off, kept in files, and switched on in another run.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{DATA_CHECK, ERROR_BIT, Ring, device, scenario};
use encoring_sim::state;

/// A CE-100 and a CE-65 that stand at these places after 200 ms, and an LA-66 that stands still.
fn text(from: i64, to: i64) -> String {
    let shaft =
        format!("motion = {{ kind = \"moves\", start = {from}, moves = [{{ to = {to}, in_s = 0.2 }}] }}");
    let rod = "motion = { kind = \"hold\", raw = 123_450 }";
    let devices =
        [device(0, "ce-100-m", &shaft), device(1, "ce-65-m", &shaft), device(2, "la-66", rod)].concat();
    format!("version = 1\n{devices}")
}

fn saved(ring: &Ring, folder: &std::path::Path) {
    for (position, place) in ring.world.places().iter().enumerate() {
        state::write(folder, position, place.node().unit(), &place.node().memory_at_power_off()).unwrap();
    }
}

fn restored(text: &str, folder: &std::path::Path) -> Ring {
    let scenario = scenario(text);
    let mut ring = Ring::of(&scenario);
    for (position, device) in scenario.devices.iter().enumerate() {
        let memory = state::read(folder, position, &device.unit).unwrap().unwrap().memory;
        ring.world.insert_memory(position, memory);
    }
    ring
}

#[test]
fn parameters_offset_and_turn_count_outlive_a_power_cycle_through_files() {
    // 5000 turns: what the sensor knows itself is the place modulo 4096 turns.
    let far = 5_000 * 4_096 + 17;
    let folder = tempfile::tempdir().unwrap();
    let mut ring = Ring::new(&text(0, far));
    ring.cycles(3);
    for position in 0..2 {
        // Three turns of 1000 steps, falling.
        for write in [0xC100_0001, 0xC200_0BB7, 0xC300_0003] {
            assert_eq!(ring.service(position, write), write);
        }
        assert_eq!(ring.service(position, DATA_CHECK), DATA_CHECK);
    }
    assert_eq!(ring.service(2, 0xC200_1388), 0xC200_1388);
    assert_eq!(ring.service(2, 0xC400_0777), 0xC400_0777);
    ring.run_to_ms(250.0);
    for position in 0..3 {
        assert_eq!(ring.service(position, 0xC600_0123), 0xC600_0123);
    }
    ring.cycles(3);
    assert_eq!(ring.input, [0x123; 3]);
    saved(&ring, folder.path());

    // Off, 100 turns on, and on again: three turns of 1000 steps falling, and 100 is 33 times three and one.
    let on = far + 100 * 4_096;
    let mut ring = restored(&text(on, on), folder.path());
    ring.cycles(3);
    let moved = (i64::from(0x123) - 100 * 1_000).rem_euclid(3_000) as u32;
    assert_eq!(ring.input, [moved, moved, 0x123]);
    for (position, read, value) in [
        (0, 0x8100_0000, 1),
        (0, 0x8200_0000, 0xBB7),
        (0, 0x8300_0000, 3),
        (1, 0x8100_0000, 1),
        (1, 0x8200_0000, 0xBB7),
        (1, 0x8300_0000, 3),
        (2, 0x8200_0000, 0x1388),
        (2, 0x8400_0000, 0x777),
    ] {
        assert_eq!(ring.service(position, read), read | value, "position {position}");
    }
    assert_eq!(ring.service(0, DATA_CHECK), DATA_CHECK);
}

#[test]
fn the_world_that_was_saved_goes_on_undisturbed() {
    let folder = tempfile::tempdir().unwrap();
    let mut ring = Ring::new(&text(0, 40_960));
    ring.run_to_ms(50.0);
    let mut other = Ring::new(&text(0, 40_960));
    other.run_to_ms(50.0);
    saved(&ring, folder.path());
    ring.run_to_ms(250.0);
    other.run_to_ms(250.0);
    assert_eq!(ring.rows, other.rows);
    let images =
        |ring: &Ring| ring.world.places().iter().map(|p| *p.node().memory().image()).collect::<Vec<_>>();
    assert_eq!(images(&ring), images(&other));
}

#[test]
fn a_blank_memory_comes_up_with_an_error_and_factory_values() {
    let folder = tempfile::tempdir().unwrap();
    let ring = Ring::new(&text(0, 0));
    for (position, place) in ring.world.places().iter().enumerate() {
        state::write(folder.path(), position, place.node().unit(), &encoring_sim::Eeprom::blank()).unwrap();
    }
    let mut ring = restored(&text(500, 500), folder.path());
    ring.cycles(3);
    assert_eq!(ring.input, [ERROR_BIT | 500, ERROR_BIT | 500, ERROR_BIT | 12_345]);
    assert_eq!(ring.service(0, DATA_CHECK), DATA_CHECK | 1);
    assert_eq!(ring.service(1, DATA_CHECK), DATA_CHECK | 1);
    assert_eq!(ring.service(2, DATA_CHECK), DATA_CHECK, "the LA-66 has no bit for it");
    assert_eq!(ring.position(0), 500);
}
