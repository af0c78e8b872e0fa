//! A service bit that stands while the bus is in reset: whether it counts afterwards [D43].
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{MS, Ring, SERVICE_BIT, device, line, set};
use encoring_encoder::records::{Record, write_count};
use encoring_ring::Verdict;
use encoring_ring::master::State;
use encoring_sim::replay::{compare, play};
use encoring_sim::{Fault, Node, World};
use encoring_words::Duration;

const PRESET: u32 = 0xC600_0000;

/// One of each model, all moving, so that every adjustment is another offset.
fn moving(more: &str) -> String {
    let devices = [
        device(0, "la-66", &format!("motion = {{ kind = \"speed\", start = 100, per_s = 10_000 }}\n{more}")),
        device(1, "ce-100-m", &format!("motion = {{ kind = \"speed\", start = 7, per_s = 90_000 }}\n{more}")),
        device(2, "ce-65-m", &format!("motion = {{ kind = \"speed\", start = 9, per_s = 70_000 }}\n{more}")),
    ];
    format!("version = 1\n{}", devices.concat())
}

/// How often each encoder has been adjusted.
fn adjusted(world: &World) -> Vec<u32> {
    let count = |place: &encoring_sim::world::Place| {
        // Formatting was the first.
        write_count(&mut place.node().memory().clone(), Record::Offset) - 1
    };
    world.places().iter().map(count).collect()
}

/// Everything that resets a bus for some time, from 50 ms on.
fn resets() -> Vec<(&'static str, String)> {
    let dip = |at| [set(50.0, at, "supply_v = 9.0"), set(90.0, at, "supply_v = 24.0")].concat();
    let held = |at| [set(50.0, at, "chip_held = true"), set(90.0, at, "chip_held = false")].concat();
    vec![
        ("a break of 30 ms before all", line(50.0, 0, "silent", 30.0)),
        ("a break of 30 ms in the middle", line(50.0, 1, "silent", 30.0)),
        ("a break of 30 ms before the last", line(50.0, 2, "silent", 30.0)),
        ("the first one's supply", dip(0)),
        ("the second one's supply", dip(1)),
        ("the first one's chip", held(0)),
        ("the last one's chip", held(2)),
        ("6 ms of bad cycles", line(50.0, 1, "bad", 6.0)),
        ("40 ms of bad cycles", line(50.0, 3, "bad", 40.0)),
    ]
}

// [R144]
#[test]
fn a_preset_that_stands_through_a_reset_of_the_bus_moves_no_zero_a_second_time() {
    for (what, events) in resets() {
        let mut ring = Ring::new(&format!("{}{events}", moving("")));
        ring.cycles(3);
        ring.out.fill(PRESET);
        ring.run_to_ms(400.0);
        assert_eq!(ring.last, Verdict::Good, "{what}");
        assert_eq!(adjusted(&ring.world), [1; 3], "{what}");
        // A bit that has been 0 is a request again.
        ring.out.fill(PRESET & !SERVICE_BIT);
        ring.cycles(3);
        assert_eq!(adjusted(&ring.world), [1; 3], "{what}");
        ring.out.fill(PRESET);
        ring.cycles(3);
        assert_eq!(adjusted(&ring.world), [2; 3], "{what}");
    }
}

#[test]
fn a_preset_that_is_asked_for_while_the_bus_is_in_reset_is_not_done_before_the_bit_has_been_0() {
    for (what, events) in resets() {
        let mut ring = Ring::new(&format!("{}{events}", moving("")));
        ring.run_to_ms(78.0);
        let is_reset: Vec<bool> =
            (0..3).map(|k| ring.world.lamps(k).is_some_and(|lamps| !lamps.rc)).collect();
        ring.out.fill(PRESET);
        ring.run_to_ms(400.0);
        for (position, adjusted) in adjusted(&ring.world).into_iter().enumerate() {
            if is_reset[position] {
                assert_eq!(adjusted, 0, "{what}, position {position}");
            }
        }
        ring.out.fill(0);
        ring.cycles(3);
        let before = adjusted(&ring.world);
        ring.out.fill(PRESET);
        ring.cycles(3);
        let after: Vec<u32> = before.iter().map(|count| count + 1).collect();
        assert_eq!(adjusted(&ring.world), after, "{what}");
    }
}

#[test]
fn a_unit_that_executes_a_stale_service_bit_presets_a_second_time() {
    for (what, events) in resets() {
        let text = format!("{}{events}", moving("stale_service = \"executed\"\n"));
        let mut ring = Ring::new(&text);
        ring.cycles(3);
        ring.out.fill(PRESET);
        ring.run_to_ms(400.0);
        let adjusted = adjusted(&ring.world);
        assert!(adjusted.contains(&2), "{what}: {adjusted:?}");
        assert!(adjusted.iter().all(|count| (1..=2).contains(count)), "{what}: {adjusted:?}");
    }
}

#[test]
fn a_unit_that_executes_takes_the_first_word_after_power_up_as_it_is() {
    for (stale_service, expected) in [("ignored", 0), ("executed", 1)] {
        let more = format!("stale_service = \"{stale_service}\"\n");
        let mut ring = Ring::new(&moving(&more));
        ring.out.fill(PRESET);
        ring.cycles(5);
        assert_eq!(adjusted(&ring.world), [expected; 3], "{stale_service}");
    }
}

#[test]
fn while_a_service_bit_is_held_back_bits_30_to_0_pass_and_the_recording_holds_that() {
    let mut ring = Ring::new(&format!("{}{}", moving(""), line(50.0, 1, "silent", 60.0)));
    ring.cycles(3);
    ring.out.fill(PRESET | 0x12);
    ring.run_to_ms(300.0);
    let back = ring.world.now().as_nanos() - 20 * MS;
    for position in 1..3 {
        let rows = ring.rows_of(position);
        let outs = |from: u64, to: u64| -> Vec<u32> {
            let mut outs: Vec<u32> = rows
                .iter()
                .filter(|row| (from..to).contains(&row.time_ns))
                .map(|row| row.out.unwrap())
                .collect();
            outs.dedup();
            outs
        };
        assert_eq!(outs(20 * MS, 50 * MS), [PRESET | 0x12], "{position}");
        assert_eq!(outs(80 * MS, 108 * MS), [0], "{position}");
        assert_eq!(outs(back, u64::MAX), [0x4600_0012], "{position}");
    }
}

#[test]
fn recordings_of_a_reset_of_the_bus_replay_without_a_difference() {
    for more in ["", "stale_service = \"executed\"\n"] {
        for (what, events) in resets() {
            let mut ring = Ring::new(&format!("{}{events}", moving(more)));
            ring.cycles(3);
            ring.out.fill(PRESET);
            ring.run_to_ms(300.0);
            for position in 0..3_u8 {
                let mut node = Node::new(*ring.world.places()[usize::from(position)].node().unit());
                for row in ring.rows_of(position) {
                    assert_eq!(compare(&row, play(&mut node, &row)), None, "{what}");
                }
            }
        }
    }
}

#[test]
fn a_bad_cycle_after_a_reset_brings_no_0() {
    let mut ring = Ring::new(&format!("{}{}", moving(""), line(50.0, 0, "silent", 40.0)));
    ring.cycles(3);
    ring.out.fill(PRESET);
    ring.run_to_ms(90.0);
    while ring.world.ring().master().state() != State::Run {
        ring.cycle();
    }
    ring.world.trouble(0, Fault::Bad, Duration::from_millis(2));
    ring.cycles(3);
    assert_eq!(ring.last, Verdict::Bad { segment: 0 });
    ring.run_to_ms(200.0);
    assert_eq!(ring.last, Verdict::Good);
    assert_eq!(adjusted(&ring.world), [1; 3]);
}

#[test]
fn a_service_that_stands_through_cycles_that_fail_goes_on_as_long_as_the_bus_is_not_stopped() {
    for position in 0..3 {
        let mut ring = Ring::new(&format!("{}{}", moving(""), line(50.0, 0, "silent", 2.0)));
        ring.cycles(3);
        ring.out[position] = PRESET;
        ring.run_to_ms(100.0);
        assert_eq!(ring.last, Verdict::Good);
        assert_eq!(ring.input[position], PRESET, "the reply stands as long as the bit does");
        assert_eq!(adjusted(&ring.world)[position], 1);
    }
}
