//! What a master finds that opens the ring of a scenario.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{line, scenario, set, three};
use encoring_ring::Ident;
use encoring_ring::diagnostics::{FaultPlace, NOTHING_FOUND};
use encoring_ring::ident::ENCODER;
use encoring_sim::scan::{Scan, scan};

fn scanned(events: &str) -> Scan {
    scan(&scenario(&format!("{}{events}", three([1_000, 2_000, 3_000])))).unwrap()
}

#[test]
fn a_sound_ring_is_found_whole() {
    let ring = scenario(&three([1_000, 2_000, 3_000]));
    let found = scan(&ring).unwrap();
    assert!(found.is_whole());
    assert_eq!(found.found, [ENCODER; 3]);
    assert_eq!((found.status, found.parameter, found.place), (0x00E0, 0, None));
    assert!(found.took.as_nanos() > 26 * common::MS, "the master is silent first");
}

// [R137]
#[test]
fn the_ring_ends_where_its_fault_is() {
    for (events, devices, place, parameter) in [
        (set(0.0, 1, "jumper = false"), 2, FaultPlace::Break(2), 0x0280),
        (set(0.0, 1, "chip_held = true"), 1, FaultPlace::Break(1), 0x0180),
        (set(0.0, 2, "supply_v = 5.0"), 2, FaultPlace::Break(2), 0x0280),
        (set(0.0, 0, "supply_v = 5.0"), 0, FaultPlace::Nowhere, NOTHING_FOUND),
        (line(0.0, 1, "silent", 1e6), 1, FaultPlace::Break(1), 0x0180),
        (line(0.0, 3, "silent", 1e6), 0, FaultPlace::Nowhere, NOTHING_FOUND),
        (set(0.0, 2, "ident = 771"), 2, FaultPlace::Device(2), 0x0300),
        (set(0.0, 2, "ident = \"303h\""), 2, FaultPlace::Device(2), 0x0300),
    ] {
        let found = scanned(&events);
        assert_eq!(found.found.len(), devices, "{events}");
        assert_eq!((found.place, found.parameter), (Some(place), parameter), "{events}");
        assert!(!found.is_whole(), "{events}");
        assert_eq!(found.other, (place == FaultPlace::Device(2)).then_some(Ident(0x0303)), "{events}");
    }
}

#[test]
fn a_bad_segment_that_lets_id_cycles_pass_is_still_told() {
    let found = scanned(&line(0.0, 1, "bad", 1e6));
    assert_eq!(found.place, Some(FaultPlace::Segment(1)));
    assert!(!found.is_whole());
}

#[test]
fn the_largest_ring_is_found_whole() {
    let device = |k| format!("[[device]]\nposition = {k}\nmodel = \"ce-100-m\"\n");
    let found =
        scan(&scenario(&format!("version = 1\n{}", (0..128).map(device).collect::<String>()))).unwrap();
    assert!(found.is_whole());
    assert_eq!(found.found.len(), 128);
}
