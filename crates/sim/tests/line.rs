//! Faults of the line: bad cycles, silence, and chance.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{DATA_CHECK, MS, Ring, SECOND, line, scenario, set, three};
use encoring_ring::Verdict;
use encoring_sim::Fault;
use encoring_sim::World;
use encoring_trace::Input;
use encoring_words::{Duration, InWord, OutWord};

const FOREVER: Duration = Duration(u64::MAX);

// [R6]
#[test]
fn the_out_words_of_a_bad_cycle_reach_no_encoder_behind_the_bad_segment() {
    for segment in 0..=3 {
        let mut ring = Ring::new(&three([1_000, 2_000, 3_000]));
        ring.cycles(3);
        let before = ring.input.clone();
        ring.world.trouble(segment, Fault::Bad, FOREVER);
        ring.out.fill(0xC200_270F);
        // The master repeats a data cycle twice before it looks where the ring ends.
        for _ in 0..3 {
            assert_eq!(ring.cycle().verdict, Verdict::Bad { segment });
            assert_eq!(ring.input, before, "the master takes nothing from a bad cycle");
        }
        for position in 0..3 {
            let taken = if position < segment { 0xC200_270F } else { 0 };
            let rows = ring.rows_of(position as u8);
            assert_eq!(rows.len(), 6, "there is an exchange at the end of bad cycles too");
            assert!(
                rows[3..].iter().all(|row| row.out == Some(taken)),
                "segment {segment} position {position}"
            );
            let served = matches!(rows[5].input, Some(Input::Word(0xC200_270F)));
            assert_eq!(served, position < segment, "segment {segment} position {position}");
        }
        // The request is taken back before the line is good again: those behind never hear of it.
        ring.out.fill(0);
        ring.world.end_trouble();
        ring.cycles(3);
        for position in 0..3 {
            let programmed = ring.service(position, 0x8200_0000) & 0x00FF_FFFF;
            assert_eq!(programmed == 0x270F, position < segment, "segment {segment} position {position}");
        }
    }
}

// [R142]
#[test]
fn transfer_errors_set_no_error_bit() {
    let noise = "[[event]]\nat_s = 0.02\nsegment = 1\nline = { flips = 2000 }\nfor_s = 1.0\n";
    let mut ring = Ring::new(&format!("{}{noise}", three([1_000, 2_000, 3_000])));
    let mut bad = 0;
    while ring.world.now().as_nanos() < 1_500 * MS {
        bad += u32::from(ring.cycle().verdict != Verdict::Good);
        assert!(ring.input.iter().all(|input| input >> 24 == 0), "{:08X?}", ring.input);
    }
    assert!(bad > 50, "{bad} cycles were disturbed");
    ring.run_to_ms(2_000.0);
    for position in 0..3 {
        assert_eq!(ring.service(position, DATA_CHECK), DATA_CHECK);
    }
}

#[test]
fn after_a_bad_cycle_the_previous_out_word_stays_and_a_reply_goes_on() {
    let mut ring = Ring::new(&three([0, 5, 0]));
    ring.cycles(3);
    ring.out[1] = 0x8300_0000;
    ring.cycles(2);
    assert_eq!(ring.input[1], 0x8300_1000);
    ring.world.trouble(1, Fault::Bad, FOREVER);
    ring.out[1] = 0;
    ring.cycles(3);
    let rows = ring.rows_of(1);
    assert_eq!(rows[rows.len() - 1].out, Some(0x8300_0000));
    assert_eq!(rows[rows.len() - 1].input, Some(Input::Word(0x8300_1000)));
    ring.world.end_trouble();
    ring.cycles(4);
    assert_eq!(ring.input[1], 5);
}

#[test]
fn silence_ends_a_held_service_after_25_ms_and_no_earlier() {
    let dead = 20 * MS;
    let mut ring = Ring::new(&format!("{}{}", three([0, 5, 6]), line(20.0, 1, "silent", 60.0)));
    ring.cycles(3);
    ring.out.fill(0x8300_0000);
    ring.run_to_ms(20.0);
    // The line died in the middle of the frame: the encoder before it has taken its word, the others have heard a part.
    assert_eq!(ring.last, Verdict::Bad { segment: 1 });
    let last_heard = ring.world.now().as_nanos();
    let frozen = ring.input.clone();
    assert_eq!(frozen[1..], [0x8300_1000, 0x8300_1000]);
    ring.run_to_ms(70.0);
    assert_eq!(ring.input, frozen, "the master sees nothing new");
    for (position, refresh, value) in [(1, MS, 5), (2, MS / 2, 6)] {
        let rows = ring.rows_of(position);
        let silent: Vec<_> = rows.iter().filter(|row| row.time_ns >= last_heard).collect();
        assert!(silent.len() > 40);
        for row in &silent {
            let reset = row.time_ns > dead + 25 * MS;
            assert_eq!(row.out, Some(if reset { 0 } else { 0x8300_0000 }), "{row:?}");
            assert_eq!(row.input, Some(Input::Word(if reset { value } else { 0x8300_1000 })), "{row:?}");
        }
        // Behind the break there is one exchange every refresh time.
        for pair in silent.windows(2) {
            assert_eq!(pair[1].time_ns - pair[0].time_ns, refresh);
        }
    }
    // The encoder before the break hears the master until that stops the bus, and is reset 25 ms later.
    let stopped = last_heard + 4 * 677_000;
    for row in ring.rows_of(0).iter().skip(3).filter(|row| row.time_ns < stopped + 25 * MS) {
        assert_eq!(row.out, Some(0x8300_0000), "{row:?}");
    }
    assert_eq!(ring.world.ring().out_word(0), OutWord(0));
}

#[test]
fn the_reset_comes_after_25_ms_on_a_long_ring_too() {
    // 128 encoders: a cycle of 14 ms, so behind a break many exchanges fall into one cycle.
    let devices: String = (0..128).map(|k| common::device(k, "ce-65-m", "")).collect();
    let mut ring = Ring::new(&format!("version = 1\n{devices}"));
    ring.cycles(3);
    ring.out.fill(0x8300_0000);
    ring.cycles(3);
    let last_good = ring.world.now().as_nanos();
    ring.world.trouble(0, Fault::Silent, FOREVER);
    ring.cycles(5);
    let rows = ring.rows_of(7);
    let reset = rows.iter().find(|row| row.time_ns > last_good && row.out == Some(0)).unwrap();
    assert_eq!((reset.time_ns - last_good) / 1_000, 25_500, "exchanges are 0.5 ms apart there");
}

#[test]
fn a_silence_of_20_ms_leaves_a_standing_service_as_it_is_and_one_of_40_ms_does_not_repeat_it() {
    let moving = three([0, 0, 0]).replace(
        "motion = { kind = \"hold\", raw = 0 }",
        "motion = { kind = \"speed\", start = 100, per_s = 10_000 }",
    );
    for lasting in [20.0, 40.0] {
        let mut ring = Ring::new(&format!("{moving}{}", line(50.0, 0, "silent", lasting)));
        ring.cycles(3);
        ring.out.fill(0xC600_0000);
        ring.run_to_ms(200.0);
        // The shaft moves on, so every adjustment is another offset.
        for position in 1..3 {
            let mut memory = ring.world.places()[position].node().memory().clone();
            let record = encoring_encoder::records::Record::Offset;
            let count = encoring_encoder::records::write_count(&mut memory, record);
            assert_eq!(count, 2, "position {position}: the first write formatted the memory");
        }
    }
}

#[test]
fn the_second_of_a_preset_input_runs_on_behind_a_break() {
    let events =
        [set(5.0, 1, "preset1_v = 0.0"), set(50.0, 1, "preset1_v = 24.0"), line(20.0, 1, "silent", 2_000.0)];
    let mut ring = Ring::new(&format!("{}{}", three([0, 5, 0]), events.concat()));
    ring.cycles(3);
    assert_eq!(ring.service(1, 0xC400_1234), 0xC400_1234);
    assert_eq!(ring.service(1, DATA_CHECK), DATA_CHECK);
    ring.out[1] = 0;
    ring.run_to_ms(2_100.0);
    assert_eq!(ring.input[1], 0x1234);
    let rows = ring.rows_of(1);
    let seen = rows.iter().find(|row| row.preset_mv[0] == 24_000).unwrap().time_ns;
    let adjusted =
        rows.iter().find(|row| row.time_ns > seen && row.input == Some(Input::Word(0x1234))).unwrap();
    assert_eq!(adjusted.time_ns - seen, SECOND, "exchanges are 1 ms apart there");
}

#[test]
fn an_input_energised_behind_a_break_of_a_long_ring_is_not_seen_before_it_is() {
    // 128 encoders: a cycle of 14 ms, so behind a break many exchanges fall into one cycle.
    let devices: String = (0..128).map(|k| common::device(k, "ce-100-m", "")).collect();
    let events = [line(30.0, 0, "silent", 3_000.0), set(500.0, 5, "preset1_v = 24.0")];
    let mut ring = Ring::new(&format!("version = 1\n{devices}{}", events.concat()));
    ring.run_to_ms(600.0);
    let seen = ring.rows_of(5).into_iter().find(|row| row.preset_mv[0] == 24_000).unwrap();
    assert!(seen.time_ns >= 500 * MS, "energised at 500 ms, told to the encoder at {} ns", seen.time_ns);
}

#[test]
fn a_motion_that_begins_inside_a_cycle_is_not_sampled_before_it_begins() {
    // Cycles of 677 us, refreshes of 1 ms: the event lies between a refresh and the exchange that shows it.
    let mut ring = Ring::new(&three([0, 7, 0]));
    ring.run_to_ms(50.0);
    let first = ring.rows_of(1)[0].time_ns;
    let cycle = 677_000;
    let start = ring.world.now().as_nanos();
    // The first cycle that a refresh falls into in its first half.
    let k = (0..100)
        .find(|k| {
            let begin = start + k * cycle - first;
            let refresh = begin.next_multiple_of(MS);
            refresh > begin && refresh < begin + cycle / 2
        })
        .unwrap();
    let begin = start + k * cycle;
    let event = begin + cycle * 3 / 4;
    let text = format!("{}{}", three([0, 7, 0]), set(event as f64 / 1e6, 1, "raw = 900"));
    let mut ring = Ring::new(&text);
    ring.run_to_ms((begin + cycle) as f64 / 1e6);
    let last = *ring.rows_of(1).last().unwrap();
    let refresh = last.time_ns - (last.time_ns - first) % MS;
    assert!(refresh < event && event < last.time_ns);
    assert_eq!(last.input, Some(Input::Word(7)), "sampled at {refresh} ns, moved at {event} ns");
}

#[test]
fn a_standing_service_bit_after_a_long_silence_is_a_new_request_to_a_unit_that_executes_it() {
    let devices = three([0, 5, 6]).replace("service_times", "stale_service = \"executed\"\nservice_times");
    let mut ring = Ring::new(&format!("{devices}{}", line(20.0, 0, "silent", 60.0)));
    ring.cycles(3);
    ring.out[2] = 0x8900_0000;
    ring.run_to_ms(150.0);
    assert_eq!(ring.input[2], 0x8900_0001);
    let rows = ring.rows_of(2);
    let replies = rows.windows(2).filter(|pair| {
        let reply = |input: Option<Input>| input == Some(Input::Word(0x8900_0001));
        !reply(pair[0].input) && reply(pair[1].input)
    });
    assert_eq!(replies.count(), 2);
}

#[test]
fn a_disturbance_shorter_than_a_cycle_spoils_that_cycle() {
    for fault in ["bad", "silent"] {
        let mut ring = Ring::new(&format!("{}{}", three([0, 5, 6]), line(20.35, 2, fault, 0.05)));
        ring.run_to_ms(20.0);
        ring.cycles(10);
        assert_eq!(ring.world.ring().master().counts().faulty, 1, "{fault} for 50 us");
        assert_eq!(ring.last, Verdict::Good);
    }
}

#[test]
fn a_disturbance_lasts_as_long_as_told() {
    for fault in ["bad", "silent"] {
        let mut ring = Ring::new(&format!("{}{}", three([0, 5, 6]), line(20.0, 2, fault, 100.0)));
        let mut faulty = Vec::new();
        while ring.world.now().as_nanos() < 200 * MS {
            let cycled = ring.cycle();
            if cycled.verdict != Verdict::Good {
                faulty.push(cycled.at.as_nanos());
            }
        }
        let (first, last) = (faulty[0], faulty[faulty.len() - 1]);
        assert!((20 * MS..20 * MS + 677_000).contains(&first), "{fault} from {first}");
        // Behind it the master may have just begun its silence of 26 ms, and opens the ring after that.
        assert!((120 * MS..152 * MS).contains(&last), "{fault} to {last}");
        assert_eq!(faulty.len() as u64, (last - first) / 677_000 + 1, "without a gap");
        assert_eq!(ring.input, [0, 5, 6]);
    }
}

#[test]
fn an_encoder_that_ran_without_a_ring_goes_on_with_its_cycles() {
    let mut ring = Ring::new(&three([0, 5, 6]));
    // Silent from the start: the encoders run by themselves, with OUT = 0.
    ring.world.trouble(0, Fault::Silent, FOREVER);
    ring.run_to_ms(60.0);
    assert!((0..3).all(|position| ring.is_on(position)));
    ring.world.end_trouble();
    ring.run_to_ms(120.0);
    assert_eq!(ring.last, Verdict::Good);
    let before = ring.rows_of(1).len();
    ring.cycles(10);
    assert_eq!(ring.rows_of(1).len() - before, 10, "one exchange at the end of each cycle");
    assert!(ring.rows.is_sorted_by_key(|row| row.time_ns), "exchanges are told in order of time");
}

fn verdicts(faulty_per_million: u32, seed: u64, out: u32) -> Vec<Verdict> {
    verdicts_of(2_000, faulty_per_million, seed, out)
}

fn verdicts_of(cycles: u32, faulty_per_million: u32, seed: u64, out: u32) -> Vec<Verdict> {
    let text = three([0, 5, 6]).replace(
        "version = 1",
        &format!("version = 1\nseed = {seed}\n[ring]\nfaulty_per_million = {faulty_per_million}"),
    );
    let mut world = World::new(&scenario(&text)).unwrap();
    let mut input = [InWord(0); 3];
    let out = |k| OutWord(if k % 7 < 3 { out } else { 0 });
    (0..cycles).map(|k| world.cycle(&[out(k); 3], &mut input).verdict).collect()
}

#[test]
fn chance_of_0_spoils_no_cycle_and_of_a_million_every_cycle() {
    assert!(verdicts(0, 1, 0).iter().all(|verdict| *verdict == Verdict::Good));
    for seed in 0..4 {
        assert!(verdicts(1_000_000, seed, 0).iter().all(|verdict| *verdict != Verdict::Good));
    }
    let first: Vec<Verdict> = (0..400).map(|seed| verdicts_of(1, 1_000_000, seed, 0)[0]).collect();
    for segment in 0..=3 {
        let hits = first.iter().filter(|verdict| **verdict == Verdict::Bad { segment }).count();
        assert!((70..130).contains(&hits), "segment {segment}: {hits} of 400");
    }
}

#[test]
fn chance_follows_the_seed_and_not_the_out_words() {
    let some = verdicts(100_000, 1, 0);
    assert_eq!(verdicts(100_000, 1, 0), some);
    assert_eq!(verdicts(100_000, 1, 0xC600_0000), some);
    assert_ne!(verdicts(100_000, 2, 0), some);
    let faulty = some.iter().filter(|verdict| **verdict != Verdict::Good).count();
    // A tenth, and the cycle after each, in which the master looks where the ring ends, as far as it does.
    assert!((120..500).contains(&faulty), "{faulty} of 2000 at a tenth");
    // More chance keeps the fault that came first.
    let first = |verdicts: &[Verdict]| verdicts.iter().position(|verdict| *verdict != Verdict::Good);
    assert!(first(&verdicts(500_000, 1, 0)) <= first(&some));
}
