//! A world without faults: where the encoders are, when the master sees it, and how words lie in the image.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{MS, Ring, SECOND, SERVICE_BIT, device, scenario, three};
use encoring_ring::image::Half;
use encoring_ring::{CycleTime, ProcessImage, Verdict};
use encoring_sim::{Scenario, World};
use encoring_trace::Input;
use encoring_words::{Duration, InWord, Model, Written};

const THREE_NS: u64 = 677_000;

/// The places of the built-in ring, written down anew: a swing, 60 turns a minute, ten turns there and back.
fn built_in_raw(position: usize, ns: u64) -> i64 {
    let s = ns as f64 / 1e9;
    match position {
        0 => 250_000 + (200_000.0 * (std::f64::consts::TAU * s / 8.0).sin()).round() as i64,
        1 => (4096 * i128::from(ns) / 1_000_000_000) as i64,
        _ => match ns % 12_000_000_000 {
            t @ 0..5_000_000_000 => (40_960 * i128::from(t) / 5_000_000_000) as i64,
            5_000_000_000..6_000_000_000 => 40_960,
            t @ 6_000_000_000..11_000_000_000 => {
                let part = 40_960 * (i128::from(t) - 6_000_000_000);
                40_960 + (-part).div_euclid(5_000_000_000) as i64
            }
            _ => 0,
        },
    }
}

/// The positions that factory values make of a place: 50 000 steps on 500 mm; native steps.
fn built_in_value(position: usize, raw: i64) -> u32 {
    if position == 0 { (raw * 50_000 / 500_000) as u32 } else { raw.rem_euclid(1 << 24) as u32 }
}

#[test]
fn the_built_in_ring_shows_the_places_of_the_last_refresh() {
    let mut ring = Ring::of(&Scenario::built_in().unwrap());
    assert_eq!(ring.world.cycle_time(), Duration::from_micros(677));
    ring.cycle();
    assert_eq!(ring.input, [0, 0, 0], "nothing was loaded when the first cycle started");
    let refresh = [MS, MS, MS / 2];
    let mut seen = vec![Vec::new(); 3];
    for cycle in 2..20_000_u64 {
        assert_eq!(ring.cycle().at.as_nanos(), cycle * THREE_NS);
        // The exchange at the end of the cycle before; power-up was at the end of the first.
        let exchanged = (cycle - 1) * THREE_NS;
        for position in 0..3 {
            let sampled = exchanged - (exchanged - THREE_NS) % refresh[position];
            let expected = built_in_value(position, built_in_raw(position, sampled));
            assert_eq!(ring.input[position], expected, "cycle {cycle} position {position}");
            seen[position].push(expected);
        }
    }
    for seen in seen {
        let moves = seen.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(moves > 5_000, "{moves} moves in 20 000 cycles");
    }
}

#[test]
fn a_reply_is_seen_one_cycle_after_its_request_and_no_earlier() {
    for position in 0..3 {
        let mut ring = Ring::new(&three([1_000, 2_000, 3_000]));
        ring.cycles(3);
        let idle = ring.input.clone();
        ring.out[position] = 0x8200_0000;
        ring.cycle();
        assert_eq!(ring.input, idle, "the IN words were loaded before the request came");
        ring.cycle();
        assert_eq!(ring.input[position] & 0xFF00_0000, 0x8200_0000);
        ring.out[position] = 0;
        ring.cycle();
        assert_eq!(ring.input[position] & 0xFF00_0000, 0x8200_0000);
        ring.cycle();
        assert_eq!(ring.input, idle);
    }
}

#[test]
fn a_service_that_takes_10_ms_is_answered_after_10_ms_and_the_way_there_and_back() {
    let text =
        three([0, 7, 0]).replace("model = \"ce-100-m\"\nservice_times = \"zero\"", "model = \"ce-100-m\"");
    let mut ring = Ring::new(&text);
    ring.cycles(3);
    ring.out[1] = 0xC200_270F;
    // Taken at the end of the first; 14.8 cycles are 10 ms, so 15 later it is done, and one later it is seen.
    for _ in 0..16 {
        ring.cycle();
        assert_eq!(ring.input[1], 7, "while it is busy the position is shown");
    }
    ring.cycle();
    assert_eq!(ring.input[1], 0xC200_270F);
}

/// Runs one encoder on the fastest ring and checks that its IN word belongs to the refresh, not to the exchange.
fn shows_one_place_a_refresh(model: &str, refresh: u64) {
    let motion = "motion = { kind = \"speed\", start = 0, per_s = 400_000_000 }";
    let text = format!("version = 1\n[ring]\nkbit_s = 2000\nsoftware_us = 0\n{}", device(0, model, motion));
    let mut ring = Ring::new(&text);
    // 13 * (6 + 4) bits and the pause that they need, 0.5 us each.
    assert_eq!(ring.world.cycle_time(), Duration(77_500));
    ring.cycles(5_000);
    let rows = ring.rows_of(0);
    assert_eq!(rows.len(), 5_000);
    let first = rows[0].time_ns;
    let interval = |ns: u64| (ns - first) / refresh;
    let mut changes = 0;
    for pair in rows.windows(2) {
        let same = interval(pair[0].time_ns) == interval(pair[1].time_ns);
        assert_eq!(pair[0].input == pair[1].input, same, "{pair:?}");
        changes += u64::from(!same);
    }
    assert_eq!(changes, interval(rows[4_999].time_ns));
    // 400 steps a microsecond from 0: the place of the refresh itself.
    for row in &rows {
        let sampled = row.time_ns - (row.time_ns - first) % refresh;
        let value = (sampled * 4 / 10) % (1 << 24);
        assert_eq!(row.input, Some(Input::Word(value as u32)), "{row:?}");
    }
}

// [R8]
#[test]
fn the_ce_100_changes_its_in_word_once_a_millisecond_at_most() {
    shows_one_place_a_refresh("ce-100-m", MS);
}

#[test]
fn the_ce_65_changes_its_in_word_once_in_half_a_millisecond_at_most() {
    shows_one_place_a_refresh("ce-65-m", MS / 2);
}

// [R1, R3]
#[test]
fn an_encoder_takes_two_words_each_way_at_its_place_in_the_ring() {
    for encoders in [1, 2, 3, 7] {
        for place in 0..encoders {
            let devices: String = (0..encoders)
                .map(|k| {
                    let raw = if k == place { 0x0012_3456 } else { 0 };
                    device(k, "ce-65-m", &format!("motion = {{ kind = \"hold\", raw = {raw} }}"))
                })
                .collect();
            let mut world = World::new(&scenario(&format!("version = 1\n{devices}"))).unwrap();
            let mut image = ProcessImage::new(encoders).unwrap();
            let mut cycle = |image: &mut ProcessImage| {
                let (out, input) = image.both();
                world.cycle(out, input);
            };
            // The words of every encoder in ring order: the place's are words 2k and 2k+1, all others are 0.
            let words = |image: &ProcessImage| -> Vec<u16> {
                let halves = |k| [Half::High, Half::Low].map(|half| image.input_half(k, half).unwrap());
                (0..encoders).flat_map(halves).collect()
            };
            cycle(&mut image);
            cycle(&mut image);
            let mut expected = vec![0; 2 * encoders];
            expected[2 * place] = 0x0012;
            expected[2 * place + 1] = 0x3456;
            assert_eq!(words(&image), expected);
            image.write_out(place, Written::Low(0x270F));
            image.write_out(place, Written::High(0xC200));
            cycle(&mut image);
            cycle(&mut image);
            expected[2 * place] = 0xC200;
            expected[2 * place + 1] = 0x270F;
            assert_eq!(words(&image), expected, "only the encoder at {place} of {encoders} replies");
        }
    }
}

// [R1]
#[test]
fn every_further_encoder_lengthens_the_cycle_by_32_bits_of_data() {
    let time = |encoders: usize| {
        let devices: String = (0..encoders).map(|k| device(k, "la-66", "")).collect();
        World::new(&scenario(&format!("version = 1\n{devices}"))).unwrap().cycle_time().as_nanos()
    };
    for encoders in 1..128 {
        // Four bytes of 13 bits and the 1.5 bits that the device itself takes, 2 us each.
        assert_eq!(time(encoders + 1) - time(encoders), 107_000);
    }
    assert_eq!(time(128), 14_052_000);
}

#[test]
fn a_ring_of_128_encoders_shows_every_position_and_answers_at_every_place() {
    let devices: String = (0..128)
        .map(|k| {
            let motion = format!("motion = {{ kind = \"speed\", start = {k}, per_s = {} }}", 1_000 * k);
            device(k, ["la-66", "ce-100-m", "ce-65-m"][k % 3], &motion)
        })
        .collect();
    let mut ring = Ring::new(&format!("version = 1\n{devices}"));
    for cycle in 1..60_u64 {
        assert_eq!(ring.cycle().verdict, Verdict::Good);
        for k in 0..128_u64 {
            let Some(exchanged) = cycle.checked_sub(1).filter(|n| *n > 0).map(|n| n * 14_052_000) else {
                continue;
            };
            let refresh = if k % 3 == 2 { MS / 2 } else { MS };
            let sampled = exchanged - (exchanged - 14_052_000) % refresh;
            let raw = k + k * sampled / MS;
            let value = if k % 3 == 0 { raw / 10 } else { raw };
            assert_eq!(u64::from(ring.input[k as usize]), value, "cycle {cycle} position {k}");
        }
    }
    ring.out.fill(0x8100_0000);
    ring.cycles(2);
    assert_eq!(ring.input, [0x8100_0000; 128]);
}

#[test]
fn a_world_changed_by_hand_goes_on_from_where_it_was_told() {
    use encoring_sim::motion::Motion;
    use encoring_sim::scenario::{Change, NewMotion};
    let mut ring = Ring::new(&three([0, 0, 0]));
    ring.cycles(3);
    ring.world.change(1, &[Change::Motion(NewMotion::Motion(Motion::Hold { raw: 99 }))]);
    ring.cycles(4);
    assert_eq!(ring.input, [0, 99, 0]);
    ring.world.change(1, &[Change::Motion(NewMotion::Onward(1_000_000_000))]);
    ring.cycles(1_000);
    let travelled = ring.input[1] - 99;
    assert!((670..=677).contains(&travelled), "{travelled} steps in 677 ms at 1000 a second");
    ring.world.change(1, &[Change::Motion(NewMotion::Stop)]);
    ring.cycles(4);
    let stopped = ring.input[1];
    ring.cycles(1_000);
    assert_eq!(ring.input[1], stopped);
}

#[test]
fn out_words_without_the_service_bit_change_nothing() {
    let mut ring = Ring::new(&three([1_230, 456, 789]));
    ring.cycles(3);
    let memories: Vec<_> = ring.world.places().iter().map(|place| place.node().memory().clone()).collect();
    for word in [0x7FFF_FFFF, 0x4200_270F, 0x4600_0000, 0x0800_0000, 1, 0] {
        ring.out.fill(word & !SERVICE_BIT);
        ring.cycles(3);
        assert_eq!(ring.input, [123, 456, 789]);
    }
    let after: Vec<_> = ring.world.places().iter().map(|place| place.node().memory().clone()).collect();
    assert_eq!(after, memories);
}

#[test]
fn a_position_outside_the_ring_is_ignored() {
    use encoring_sim::scenario::Change;
    let mut ring = Ring::new(&three([10, 20, 30]));
    ring.world.change(3, &[Change::Supply(0), Change::PowerCut(1)]);
    ring.cycles(3);
    assert_eq!(ring.input, [1, 20, 30]);
    assert_eq!(InWord(ring.input[0]).high(), 0);
}

#[test]
fn no_position_is_older_than_the_worst_reaction_and_some_nearly_are() {
    let turning = "motion = { kind = \"speed\", rpm = 6000.0 }";
    let steps_per_s = 6_000 / 60 * 4096;
    let devices = [device(0, "ce-100-m", turning), device(1, "ce-65-m", turning)].concat();
    let mut ring = Ring::new(&format!("version = 1\n{devices}"));
    let cycle = CycleTime::default().of_encoders(2);
    for (position, model) in [(0, Model::Ce100M), (1, Model::Ce65M)] {
        let worst = CycleTime::worst_reaction(cycle, model.refresh()).as_nanos();
        let mut oldest = 0;
        for _ in 0..2_000 {
            ring.cycle();
            // A position is replaced a cycle after it came.
            let replaced = ring.world.now().as_nanos() + cycle.as_nanos();
            let shown = u64::from(ring.input[position] & 0x00FF_FFFF);
            oldest = oldest.max(replaced.saturating_sub(shown * SECOND / steps_per_s));
        }
        // A step lasts 2.4 us, and samples come every microsecond of the cycle but not in each.
        assert!(oldest <= worst + 3_000, "{model}: {oldest} of {worst}");
        assert!(oldest + 30_000 >= worst, "{model}: {oldest} of {worst}");
    }
}
