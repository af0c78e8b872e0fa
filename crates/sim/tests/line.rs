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
        for _ in 0..5 {
            assert_eq!(ring.cycle().verdict, Verdict::Bad { segment });
            assert_eq!(ring.input, before, "the master takes nothing from a bad cycle");
        }
        for position in 0..3 {
            let taken = if position < segment { 0xC200_270F } else { 0 };
            let rows = ring.rows_of(position as u8);
            assert_eq!(rows.len(), 8, "there is an exchange at the end of bad cycles too");
            assert!(rows[3..].iter().all(|row| row.out == taken), "segment {segment} position {position}");
            let served = matches!(rows[7].input, Some(Input::Word(0xC200_270F)));
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
    for level in ["word", "bit"] {
        let noise = "[[event]]\nat_s = 0.02\nsegment = 1\nline = { flips = 2000 }\nfor_s = 1.0\n";
        let text = format!("{}{noise}[ring]\nlevel = \"{level}\"\n", three([1_000, 2_000, 3_000]));
        let mut ring = Ring::new(&text);
        let mut bad = 0;
        while ring.world.now().as_nanos() < 1_500 * MS {
            bad += u32::from(ring.cycle().verdict != Verdict::Good);
            assert!(ring.input.iter().all(|input| input >> 24 == 0), "{level}: {:08X?}", ring.input);
        }
        assert!(bad > 50, "{level}: {bad} cycles were disturbed");
        ring.run_to_ms(2_000.0);
        for position in 0..3 {
            assert_eq!(ring.service(position, DATA_CHECK), DATA_CHECK, "{level}");
        }
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
    ring.cycles(100);
    let rows = ring.rows_of(1);
    assert_eq!(rows[rows.len() - 1].out, 0x8300_0000);
    assert_eq!(rows[rows.len() - 1].input, Some(Input::Word(0x8300_1000)));
    ring.world.end_trouble();
    ring.cycles(2);
    assert_eq!(ring.input[1], 5);
}

#[test]
fn silence_ends_a_held_service_after_25_ms_and_no_earlier() {
    let mut ring = Ring::new(&format!("{}{}", three([0, 5, 6]), line(20.0, 1, "silent", 60.0)));
    ring.cycles(3);
    ring.out.fill(0x8300_0000);
    ring.run_to_ms(20.0);
    // The cycle in which silence began is the first that failed.
    let last_good = ring.world.now().as_nanos() - 677_000;
    assert_eq!(ring.last, Verdict::Silent { segment: 1 });
    let frozen = ring.input.clone();
    assert_eq!(frozen[1..], [0x8300_1000, 0x8300_1000]);
    ring.run_to_ms(70.0);
    assert_eq!(ring.input, frozen, "the master sees nothing new");
    for (position, refresh, value) in [(1, MS, 5), (2, MS / 2, 6)] {
        let rows = ring.rows_of(position);
        let silent: Vec<_> = rows.iter().filter(|row| row.time_ns > last_good).collect();
        assert!(silent.len() > 40);
        for row in &silent {
            let reset = row.time_ns > last_good + 25 * MS;
            assert_eq!(row.out, if reset { 0 } else { 0x8300_0000 }, "{row:?}");
            assert_eq!(row.input, Some(Input::Word(if reset { value } else { 0x8300_1000 })), "{row:?}");
        }
        // Behind the break there is one exchange every refresh time.
        for pair in silent.windows(2) {
            assert_eq!(pair[1].time_ns - pair[0].time_ns, refresh);
        }
        assert_eq!(silent[0].time_ns, last_good + refresh);
    }
    // The encoder before the break hears its line and keeps its OUT word.
    assert!(ring.rows_of(0).iter().skip(3).all(|row| row.out == 0x8300_0000));
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
    let reset = rows.iter().find(|row| row.time_ns > last_good && row.out == 0).unwrap();
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
    ring.run_to_ms(100.0);
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
        let faulty = (0..10).filter(|_| ring.cycle().verdict != Verdict::Good).count();
        assert_eq!(faulty, 1, "{fault} for 50 us");
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
        assert!((120 * MS - 677_000..120 * MS + 677_000).contains(&last), "{fault} to {last}");
        assert_eq!(faulty.len() as u64, (last - first) / 677_000 + 1, "without a gap");
        assert_eq!(ring.input, [0, 5, 6]);
    }
}

#[test]
fn an_encoder_that_was_cycled_without_a_ring_goes_on_through_bad_cycles() {
    let mut ring = Ring::new(&three([0, 5, 6]));
    // Silent from the start: the encoders run by themselves, with OUT = 0.
    ring.world.trouble(0, Fault::Silent, FOREVER);
    ring.run_to_ms(60.0);
    assert!((0..3).all(|position| ring.is_on(position)));
    ring.world.trouble(0, Fault::Bad, FOREVER);
    let before = ring.rows_of(1).len();
    ring.cycles(10);
    assert_eq!(ring.rows_of(1).len() - before, 10, "one exchange at the end of each bad cycle");
    ring.world.trouble(0, Fault::Silent, FOREVER);
    ring.cycles(10);
    assert!(ring.rows.is_sorted_by_key(|row| row.time_ns), "exchanges are told in order of time");
}

fn verdicts(faulty_per_million: u32, seed: u64, out: u32) -> Vec<Verdict> {
    let text = three([0, 5, 6]).replace(
        "version = 1",
        &format!("version = 1\nseed = {seed}\n[ring]\nfaulty_per_million = {faulty_per_million}"),
    );
    let mut world = World::new(&scenario(&text)).unwrap();
    let mut input = [InWord(0); 3];
    let out = |k| OutWord(if k % 7 < 3 { out } else { 0 });
    (0..2_000).map(|k| world.cycle(&[out(k); 3], &mut input).verdict).collect()
}

#[test]
fn chance_of_0_spoils_no_cycle_and_of_a_million_every_cycle() {
    assert!(verdicts(0, 1, 0).iter().all(|verdict| *verdict == Verdict::Good));
    let always = verdicts(1_000_000, 1, 0);
    for segment in 0..=3 {
        let hits = always.iter().filter(|verdict| **verdict == Verdict::Bad { segment }).count();
        assert!((400..600).contains(&hits), "segment {segment}: {hits} of 2000");
    }
    assert!(always.iter().all(|verdict| *verdict != Verdict::Good));
}

#[test]
fn chance_follows_the_seed_and_not_the_out_words() {
    let some = verdicts(100_000, 1, 0);
    assert_eq!(verdicts(100_000, 1, 0), some);
    assert_eq!(verdicts(100_000, 1, 0xC600_0000), some);
    assert_ne!(verdicts(100_000, 2, 0), some);
    let faulty = some.iter().filter(|verdict| **verdict != Verdict::Good).count();
    assert!((120..280).contains(&faulty), "{faulty} of 2000 at a tenth");
    // More chance keeps the faults that were there.
    let more = verdicts(500_000, 1, 0);
    let kept = some.iter().zip(&more).all(|(few, many)| *few == Verdict::Good || few == many);
    assert!(kept);
}

#[test]
fn of_two_faults_in_one_cycle_silence_wins_and_then_the_earlier_segment() {
    let text = three([0, 5, 6]).replace("version = 1", "version = 1\n[ring]\nfaulty_per_million = 1_000_000");
    let mut ring = Ring::new(&text);
    ring.world.trouble(2, Fault::Bad, FOREVER);
    for _ in 0..50 {
        let verdict = ring.cycle().verdict;
        assert!(matches!(verdict, Verdict::Bad { segment: 0..=2 }), "{verdict:?}");
    }
    ring.world.trouble(3, Fault::Silent, FOREVER);
    assert_eq!(ring.cycle().verdict, Verdict::Silent { segment: 3 });
    ring.supply(1, 0);
    assert_eq!(ring.cycle().verdict, Verdict::Silent { segment: 2 });
}
