//! The master of a world: it stops and searches with a fault, and runs again behind it.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Ring, line, set, three};
use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::{ProcessImage, Verdict};
use encoring_sim::Scenario;

#[test]
fn a_cycle_is_never_shorter_than_its_frame() {
    let text = three([1_000, 2_000, 3_000]);
    let mut ring = Ring::new(&format!("{text}[ring]\nsoftware_us = 0\n"));
    // 13 * (6 + 12) bits, 1.5 for each device, and what the pause takes.
    assert!(ring.world.cycle_time().as_nanos() > 477_000);
    let sent = |ring: &Ring| ring.world.ring().sent();
    // The ring was opened before time began.
    let opened = sent(&ring);
    ring.cycles(1_000);
    let line_ns = (sent(&ring) - opened) * 2_000;
    let behind = ring.world.now().as_nanos().abs_diff(line_ns);
    assert!(behind < 20_000, "the line keeps the world's time: {behind} ns apart");
}

#[test]
fn a_silent_segment_stops_the_bus_and_it_comes_back_by_itself() {
    let events = line(50.0, 2, "silent", 200.0);
    let mut ring = Ring::new(&format!("{}{events}", three([1_000, 2_000, 3_000])));
    ring.out = vec![0x0000_0007; 3];
    ring.run_to_ms(49.0);
    let seen = ring.input.clone();
    ring.run_to_ms(120.0);
    // All encoders see OUT = 0, those before the break too: the master resets the ring to search.
    for position in 0..3 {
        assert_eq!(ring.world.ring().out_word(position).0, 0);
    }
    assert_eq!(ring.input, seen);
    let master = ring.world.ring().master();
    assert_eq!((master.place(), master.parameter()), (Some(FaultPlace::Break(2)), 0x0280));
    ring.run_to_ms(320.0);
    assert_eq!(ring.last, Verdict::Good);
    for position in 0..3 {
        assert_eq!(ring.world.ring().out_word(position).0, 7);
    }
    assert_eq!(ring.world.ring().master().status(), 0x00E0);
}

#[test]
fn a_broken_segment_is_shown_once_a_search_has_found_it() {
    for (segment, parameter) in [(0, 0x0BE1), (1, 0x0180), (2, 0x0280)] {
        let events = line(50.0, segment, "silent", 200.0);
        let mut ring = Ring::new(&format!("{}{events}", three([1_000, 2_000, 3_000])));
        let mut image = ProcessImage::new(3).unwrap();
        let mut registers = |ring: &Ring| {
            ring.world.diagnose(&mut image);
            (image.status(), image.parameter())
        };
        ring.run_to_ms(49.0);
        assert_eq!(registers(&ring), (0x00E0, 0), "before");
        ring.run_to_ms(120.0);
        assert_eq!(registers(&ring), (0x1094, parameter));
        ring.run_to_ms(400.0);
        assert_eq!(registers(&ring), (0x00E0, 0), "after");
        // Five cycles stop the bus; a search is no data cycle. Where nothing was found, nothing was located.
        let place = |k| if k == segment && segment > 0 { 5 } else { 0 };
        assert_eq!(image.faults(), [place(0), place(1), place(2), place(3)], "segment {segment}");
    }
}

#[test]
fn an_encoder_that_lost_its_supply_is_opened_again_when_it_is_back() {
    let events = format!("{}{}", set(20.0, 1, "supply_v = 0.0"), set(100.0, 1, "supply_v = 24.0"));
    let mut ring = Ring::new(&format!("{}{events}", three([1_000, 2_000, 3_000])));
    ring.run_to_ms(99.0);
    assert_ne!(ring.last, Verdict::Good);
    ring.run_to_ms(250.0);
    assert_eq!(ring.last, Verdict::Good);
    ring.cycles(3);
    assert_eq!(ring.input, [100, 2_000, 3_000]);
}

#[test]
fn chip_jumper_and_ident_break_the_ring_where_they_are() {
    for (what, back, place) in [
        ("chip_held = true", "chip_held = false", FaultPlace::Break(1)),
        ("jumper = false", "jumper = true", FaultPlace::Break(2)),
    ] {
        let events = format!("{}{}", set(20.0, 1, what), set(300.0, 1, back));
        let mut ring = Ring::new(&format!("{}{events}", three([1_000, 2_000, 3_000])));
        ring.run_to_ms(200.0);
        assert_ne!(ring.last, Verdict::Good, "{what}");
        assert_eq!(ring.world.ring().master().place(), Some(place), "{what}");
        ring.run_to_ms(500.0);
        assert_eq!(ring.last, Verdict::Good, "{what}");
    }
    let events = format!("{}{}", set(20.0, 2, "ident = 771"), set(30.0, 2, "supply_v = 0.0"));
    let events = format!("{events}{}", set(60.0, 2, "supply_v = 24.0"));
    let mut ring = Ring::new(&format!("{}{events}", three([1_000, 2_000, 3_000])));
    ring.run_to_ms(400.0);
    assert_eq!(ring.world.ring().master().place(), Some(FaultPlace::Device(2)));
    assert_ne!(ring.last, Verdict::Good);
}

#[test]
fn every_fault_of_a_segment_is_noticed_and_ends_with_its_time() {
    for fault in [
        "\"bad\"",
        "\"low\"",
        "\"high\"",
        "{ flips = 2000 }",
        "{ bursts = 2000 }",
        "{ jitter = 20000 }",
        "{ lost = 2000 }",
    ] {
        let event = format!("[[event]]\nat_s = 0.02\nsegment = 1\nline = {fault}\nfor_s = 0.1\n");
        let mut ring = Ring::new(&format!("{}{event}", three([1_000, 2_000, 3_000])));
        let mut faulty = 0;
        while ring.world.now().as_nanos() < 120 * common::MS {
            faulty += u32::from(ring.cycle().verdict != Verdict::Good);
        }
        assert!(faulty >= 20, "{fault}: {faulty}");
        ring.run_to_ms(300.0);
        assert_eq!(ring.last, Verdict::Good, "{fault}");
    }
}

#[test]
fn chances_above_a_million_are_refused() {
    let event = "[[event]]\nat_s = 0\nsegment = 1\nline = { flips = 1000001 }\n";
    let text = format!("{}{event}", three([0, 0, 0]));
    let error = Scenario::parse("x", &text, std::path::Path::new("")).unwrap_err();
    assert_eq!(error.problem, "bits in a million 1000001; the limits are 0 and 1000000");
}
