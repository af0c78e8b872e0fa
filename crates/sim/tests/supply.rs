//! The supply of an encoder on the ring: dips, limits, and what outlives them.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{DATA_CHECK, Ring, device, set, three};
use encoring_ring::Verdict;
use encoring_ring::diagnostics::FaultPlace;
use encoring_sim::Fault;
use encoring_trace::Input;
use encoring_words::Duration;

/// Offset writes so far, the formatting included.
fn offsets(ring: &Ring, position: usize) -> u32 {
    let mut memory = ring.world.places()[position].node().memory().clone();
    encoring_encoder::records::write_count(&mut memory, encoring_encoder::records::Record::Offset)
}

/// The rod stays where it is, the shafts turn, so that every adjustment is another offset.
fn turning() -> String {
    let speed = "motion = { kind = \"speed\", start = 100, per_s = 10_000 }";
    let devices = [device(0, "la-66", speed), device(1, "ce-100-m", speed), device(2, "ce-65-m", speed)];
    format!("version = 1\n{}", devices.concat())
}

// [R121]
#[test]
fn below_10_45_v_the_ring_is_open_at_the_encoder_and_at_10_45_v_it_is_not() {
    for position in 0..3 {
        for (volts, open) in [(10.45, false), (10.449, true), (0.0, true), (28.35, false), (28.4, false)] {
            let event = set(20.0, position, &format!("supply_v = {volts}"));
            let mut ring = Ring::new(&format!("{}{event}", three([1_000, 2_000, 3_000])));
            ring.run_to_ms(21.0);
            // The line into it is the first on which nobody hears anything.
            let expected = if open { Verdict::Silent { segment: position } } else { Verdict::Good };
            assert_eq!(ring.last, expected, "{volts} V at {position}");
            assert_eq!(ring.is_on(position), !open, "{volts} V at {position}");
            let rows = ring.rows_of(position as u8);
            assert_eq!(rows[rows.len() - 1].input == Some(Input::Off), open, "{volts} V at {position}");
        }
    }
}

// [R121]
#[test]
fn overvoltage_is_noted_above_28_35_v_and_harms_nothing() {
    for (volts, over) in [(28.35, false), (28.351, true), (30.0, true), (27.0, false), (10.0, false)] {
        let event = set(20.0, 1, &format!("supply_v = {volts}"));
        let back = set(40.0, 1, "supply_v = 24.0");
        let mut ring = Ring::new(&format!("{}{event}{back}", three([1_000, 2_000, 3_000])));
        ring.run_to_ms(30.0);
        assert_eq!(ring.world.places()[1].node().device().overvoltage(), over, "{volts} V");
        assert!(!ring.world.places()[0].node().device().overvoltage());
        ring.run_to_ms(50.0);
        assert!(!ring.world.places()[1].node().device().overvoltage());
        assert_eq!(ring.position(1), 2_000);
    }
}

#[test]
fn a_preset_input_above_30_v_is_noted_and_still_reads_1() {
    // At most 30 V [R71].
    for (position, inputs) in [(0, 1), (1, 2)] {
        for input in 1..=inputs {
            for (volts, over) in [(0.0, false), (24.0, false), (30.0, false), (30.001, true), (60.0, true)] {
                let event = set(20.0, position, &format!("preset{input}_v = {volts}"));
                let mut ring = Ring::new(&format!("{}{event}", three([1_000, 2_000, 3_000])));
                ring.run_to_ms(1_100.0);
                let noted = |position: usize| {
                    let place = &ring.world.places()[position];
                    place.around().preset_overvoltage(place.node().unit().model())
                };
                assert_eq!(noted(position), over, "preset {input} of {position} at {volts} V");
                assert!(!noted(1 - position) && !noted(2));
                // After its second the factory's preset value 0 is shown.
                let raw = if position == 0 { 100 } else { 2_000 };
                assert_eq!(ring.position(position), if volts < 11.0 { raw } else { 0 }, "{volts} V");
            }
        }
    }
}

// [R144]
#[test]
fn a_dip_shorter_than_a_cycle_switches_the_encoder_off_and_spoils_the_cycle() {
    let dip = [set(20.35, 1, "supply_v = 9.0"), set(20.36, 1, "supply_v = 24.0")].concat();
    let mut ring = Ring::new(&format!("{}{dip}", three([1_000, 2_000, 3_000])));
    let mut faulty = Vec::new();
    while ring.world.now().as_nanos() < 40_000_000 {
        let cycled = ring.cycle();
        if cycled.verdict != Verdict::Good {
            faulty.push((cycled.at.as_nanos() / 677_000, cycled.verdict));
        }
    }
    assert_eq!(faulty[0], (31, Verdict::Silent { segment: 1 }), "20.35 ms lie in cycle 31");
    assert!(faulty.len() < 5, "the master finds the ring whole again before it would stop: {faulty:?}");
    let off: Vec<u64> =
        ring.rows.iter().filter(|row| row.input == Some(Input::Off)).map(|row| row.time_ns).collect();
    assert_eq!(off, [20_350_000]);
    assert_eq!(ring.input, [100, 2_000, 3_000]);
}

// [R144]
#[test]
fn a_preset_that_stands_through_a_dip_moves_no_zero() {
    for position in 0..3 {
        for dip_ms in [0.01, 0.5, 1.0, 5.0, 24.0, 26.0, 100.0] {
            let dip =
                [set(50.0, position, "supply_v = 9.0"), set(50.0 + dip_ms, position, "supply_v = 24.0")];
            let mut ring = Ring::new(&format!("{}{}", turning(), dip.concat()));
            ring.cycles(3);
            ring.out[position] = 0xC600_0000;
            ring.run_to_ms(300.0);
            assert_eq!(offsets(&ring, position), 2, "a dip of {dip_ms} ms at {position}");
            assert_eq!(ring.input[position] >> 24, 0, "normal mode, since the stale bit is ignored");
            // A new rise is a request again.
            ring.out[position] = 0;
            ring.cycles(3);
            ring.out[position] = 0xC600_0000;
            ring.cycles(3);
            assert_eq!(offsets(&ring, position), 3);
        }
    }
}

// [R144]
#[test]
fn a_preset_that_stands_through_a_dip_of_the_whole_ring_moves_no_zero() {
    let mut moved = Vec::new();
    for dip_ms in [0.01, 0.5, 5.0, 24.0, 100.0] {
        let dip: String = (0..3)
            .map(|k| [set(50.0, k, "supply_v = 9.0"), set(50.0 + dip_ms, k, "supply_v = 24.0")].concat())
            .collect();
        let mut ring = Ring::new(&format!("{}{dip}", turning()));
        ring.cycles(3);
        ring.out.fill(0xC600_0000);
        ring.run_to_ms(300.0);
        let written = [0, 1, 2].map(|position| offsets(&ring, position));
        if written != [2; 3] {
            moved.push((dip_ms, written));
        }
    }
    assert_eq!(moved, [], "dip in ms, and how often each encoder has stored an offset instead of twice");
}

#[test]
fn several_encoders_that_dip_at_once_open_the_ring_at_the_first_of_them() {
    let events = [
        set(20.0, 1, "supply_v = 9.0"),
        set(20.0, 2, "supply_v = 9.0"),
        set(200.0, 1, "supply_v = 24.0"),
        set(400.0, 2, "supply_v = 24.0"),
    ];
    let mut ring = Ring::new(&format!("{}{}", three([1_000, 2_000, 3_000]), events.concat()));
    for (ms, place) in
        [(190.0, Some(FaultPlace::Break(1))), (390.0, Some(FaultPlace::Break(2))), (600.0, None)]
    {
        ring.run_to_ms(ms);
        assert_eq!(ring.world.ring().master().place(), place, "at {ms} ms");
    }
    assert_eq!(ring.last, Verdict::Good);
    assert_eq!(ring.input, [100, 2_000, 3_000]);
    let off = |position| ring.rows_of(position).iter().filter(|row| row.input == Some(Input::Off)).count();
    assert_eq!([0, 1, 2].map(off), [0, 1, 1]);
}

#[test]
fn the_turn_count_outlives_a_dip() {
    // 5000 turns are more than the 4096 that the sensor knows, and 3 is no power of two.
    let far = 5_000 * 4_096 + 17;
    for (position, model) in [(0, "ce-100-m"), (0, "ce-65-m")] {
        let motion = format!("motion = {{ kind = \"moves\", moves = [{{ to = {far}, in_s = 0.2 }}] }}");
        let dip = [set(300.0, 0, "supply_v = 0.0"), set(320.0, 0, "supply_v = 24.0")].concat();
        let mut ring = Ring::new(&format!("version = 1\n{}{dip}", device(0, model, &motion)));
        ring.cycles(3);
        for write in [0xC200_2FFF, 0xC300_0003] {
            assert_eq!(ring.service(0, write), write);
        }
        assert_eq!(ring.service(0, DATA_CHECK), DATA_CHECK);
        ring.run_to_ms(290.0);
        let expected = (far % 12_288) as u32;
        assert_eq!(ring.position(position), expected);
        ring.run_to_ms(310.0);
        assert!(!ring.is_on(0));
        ring.run_to_ms(350.0);
        assert_eq!(ring.position(position), expected);
    }
}

// [R144]
#[test]
fn a_service_in_progress_when_the_supply_fails_is_not_done() {
    for (dip_ms, done) in [(25.0, false), (29.0, false), (31.5, true)] {
        let slow = three([1_000, 2_000, 3_000]).replace("service_times = \"zero\"\n", "");
        let dip = [set(dip_ms, 1, "supply_v = 9.0"), set(dip_ms + 10.0, 1, "supply_v = 24.0")].concat();
        let mut ring = Ring::new(&format!("{slow}{dip}"));
        ring.run_to_ms(20.0);
        ring.out[1] = 0xC200_270F;
        ring.run_to_ms(100.0);
        // A measuring length that was programmed in time has been accepted at power-up.
        let shown = if done { 2_000 * 10_000 / (4_096 * 4_096) } else { 2_000 };
        assert_eq!(ring.input[1], shown, "no reply to what was requested before");
        ring.out[1] = 0;
        ring.cycles(3);
        let programmed = ring.service(1, 0x8200_0000) & 0x00FF_FFFF;
        assert_eq!(programmed == 0x270F, done, "requested at some 20.3 ms, 10 ms long, dip at {dip_ms} ms");
    }
}

#[test]
fn an_encoder_switched_off_and_on_between_two_cycles_has_started_anew() {
    let mut ring = Ring::new(&turning());
    ring.cycles(3);
    ring.out[1] = 0xC600_0000;
    ring.cycles(3);
    ring.supply(1, 10_000);
    ring.supply(1, 24_000);
    ring.cycles(10);
    assert_eq!(offsets(&ring, 1), 2);
    assert_eq!(ring.input[1] >> 24, 0);
}

#[test]
fn what_is_programmed_without_a_data_check_holds_after_a_dip() {
    let dip = [set(50.0, 2, "supply_v = 9.0"), set(60.0, 2, "supply_v = 24.0")].concat();
    let mut ring = Ring::new(&format!("{}{dip}", three([0, 0, 4_096 * 5 + 9])));
    ring.cycles(3);
    for write in [0xC200_0FFF, 0xC300_0001] {
        assert_eq!(ring.service(2, write), write);
    }
    assert_eq!(ring.position(2), 4_096 * 5 + 9, "the old parameters until power off and on");
    ring.run_to_ms(150.0);
    assert_eq!(ring.position(2), 9);
}

#[test]
fn a_reply_that_was_formed_before_the_supply_failed_is_not_shown_after_it() {
    let mut ring = Ring::new(&three([1_000, 2_000, 3_000]));
    ring.cycles(3);
    ring.out[1] = 0x8300_0000;
    ring.cycle();
    // The reply is formed, and would be loaded at the start of the next cycle.
    ring.supply(1, 0);
    ring.cycles(2);
    ring.supply(1, 24_000);
    for _ in 0..10 {
        ring.cycle();
        assert_eq!(ring.input[1], 2_000);
    }
}

#[test]
fn a_preset_requested_while_the_encoder_is_off_moves_no_zero_even_if_a_bad_cycle_comes_first() {
    for position in 0..3 {
        let mut ring = Ring::new(&turning());
        ring.cycles(3);
        ring.supply(position, 0);
        ring.out[position] = 0xC600_0000;
        ring.cycles(2);
        ring.supply(position, 24_000);
        ring.world.trouble(0, Fault::Bad, Duration::from_millis(2));
        ring.cycles(20);
        assert_eq!(ring.last, Verdict::Good);
        assert_eq!(offsets(&ring, position), 1, "only formatted, at {position}");
    }
}

#[test]
fn a_dip_between_two_cycles_opens_the_ring_for_the_next() {
    let mut ring = Ring::new(&three([0, 5, 6]));
    ring.cycles(5);
    let supply = |mv| [encoring_sim::scenario::Change::Supply(mv)];
    ring.world.change(1, &supply(0));
    ring.world.change(1, &supply(24_000));
    ring.cycles(1);
    assert_eq!(ring.last, Verdict::Silent { segment: 1 });
    ring.cycles(4);
    assert_eq!(ring.last, Verdict::Good);
}
