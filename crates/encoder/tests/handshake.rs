//! The handshake of the service bit, exchange by exchange.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, MS, cases, ce65, ce100, every_model, la66};
use encoring_encoder::records::{Record, write_count};
use encoring_encoder::{Magnet, ServiceTimes};
use encoring_words::Duration;
use proptest::prelude::*;

fn with_default_times(bench: Bench) -> Bench {
    bench.rebuilt(|unit| unit.service_times = ServiceTimes::default())
}

/// One exchange so many nanoseconds after `start`.
fn after(bench: &mut Bench, start: u64, nanos: u64, out: u32) -> u32 {
    bench.now = start + nanos;
    bench.exchange_now(out)
}

proptest! {
    #![proptest_config(cases(200))]

    // [R13, R14]
    #[test]
    fn in_normal_mode_no_out_word_has_an_effect(outs in prop::collection::vec(0..1_u32 << 31, 1..60)) {
        // What one step of the factory's position is in raw units.
        for (mut bench, step) in every_model().into_iter().zip([10, 1, 1, 2]) {
            let memory = bench.memory.clone();
            for (k, out) in (0_u32..).zip(&outs) {
                bench.turn_to(i64::from(k * step));
                prop_assert_eq!(bench.exchange(*out), k, "{} {:08X}", bench.model(), out);
            }
            prop_assert_eq!(&bench.memory, &memory);
            prop_assert_eq!(bench.data_check(), 0x8800_0000);
        }
    }

    // [R13]
    #[test]
    fn in_normal_mode_no_out_word_clears_an_error(outs in prop::collection::vec(0..1_u32 << 31, 1..60)) {
        for mut bench in every_model() {
            bench.service(0x8700_0000);
            for out in &outs {
                prop_assert_eq!(bench.exchange(*out), 1 << 29);
            }
        }
    }

    // [R30, R36]
    #[test]
    fn replies_are_shown_in_the_exchanges_that_the_rules_name(
        steps in prop::collection::vec((any::<bool>(), 0_u64..3), 1..80),
        service_time in 0_u64..6,
    ) {
        let mut bench = ce65().rebuilt(|unit| {
            unit.service_times.read = Duration::from_millis(service_time);
        });
        // Power-up once more, so that the first bit can be a stale one.
        bench.power_off();
        bench.power_up();
        let start = bench.now;
        let mut bits = Vec::new();
        let mut times = Vec::new();
        let mut shown = Vec::new();
        let mut time = 0;
        for (bit, pause) in steps {
            time += pause;
            let out = if bit { 0x8200_0000 } else { 0x0200_0000 };
            let input = after(&mut bench, start, time * MS, out);
            prop_assert!(input == 0 || input == 0x82FF_FFFF, "whole or not at all: {input:08X}");
            bits.push(bit);
            times.push(time);
            shown.push(input != 0);
        }
        prop_assert_eq!(shown, shown_by_the_rules(&bits, &times, service_time), "{:?} {:?}", bits, times);
    }
}

/// Which exchanges show a reply, found by looking at the whole course of bit 31 at once.
fn shown_by_the_rules(bits: &[bool], times: &[u64], service_time: u64) -> Vec<bool> {
    let mut shown = vec![false; bits.len()];
    let mut seen_0 = false;
    let mut k = 0;
    while k < bits.len() {
        if !bits[k] || !seen_0 {
            seen_0 |= !bits[k];
            k += 1;
            continue;
        }
        let Some(done) = (k..bits.len()).find(|j| times[*j] >= times[k] + service_time) else { break };
        let withdrawn = (k..=done).any(|j| !bits[j]);
        let end =
            if withdrawn { done + 1 } else { (done..bits.len()).find(|j| !bits[*j]).unwrap_or(bits.len()) };
        shown[done..end].fill(true);
        // After a withdrawn service a bit that is 1 already is stale.
        seen_0 = !withdrawn || !bits[done];
        k = end;
    }
    shown
}

// [R31]
#[test]
fn a_new_device_begins_in_normal_mode_with_the_position() {
    for mut bench in every_model() {
        bench.power_off();
        bench.power_up();
        assert_eq!(bench.exchange_now(0x7FFF_FFFF), 0);
    }
}

// [R40]
#[test]
fn the_four_phases_follow_one_another() {
    for mut bench in every_model() {
        let mut phases = Vec::new();
        for out in [0, 0x4100_0001, 0xC100_0001, 0xC100_0001, 0x4100_0001, 0, 0x8100_0000, 0] {
            phases.push((out >> 31, bench.exchange(out) >> 31));
        }
        assert_eq!(phases, [(0, 0), (0, 0), (1, 1), (1, 1), (0, 0), (0, 0), (1, 1), (0, 0)]);
        assert_eq!(bench.encoder.parameters().programmed().counting_direction().data(), 1);
    }
}

// [R15, R17]
#[test]
fn the_service_bit_makes_the_difference_between_nothing_and_a_service() {
    for mut bench in every_model() {
        assert_eq!(bench.exchange(0x4100_0001), 0);
        assert_eq!(bench.service(0x8100_0000), 0x8100_0000);
        assert_eq!(bench.service(0xC100_0001), 0xC100_0001);
        assert_eq!(bench.service(0x8100_0000), 0x8100_0001);
    }
}

// [R41]
#[test]
fn a_request_ends_with_bit_31_alone_whatever_the_rest() {
    for end in [0x4200_270F, 0, 0x7FFF_FFFF, 0x0800_0000, 0x4600_0001] {
        for mut bench in every_model() {
            bench.turn_to(200_000);
            let position = bench.position();
            bench.exchange(0x8100_0000);
            assert_eq!(bench.exchange(end), position, "{end:08X}");
            assert_eq!(bench.exchange(end), position, "{end:08X}");
            assert_eq!(bench.data_check(), 0x8800_0000);
        }
    }
}

#[test]
fn the_request_is_what_the_word_said_when_bit_31_rose() {
    for mut bench in every_model() {
        assert_eq!(bench.exchange(0xC100_0001), 0xC100_0001);
        for out in [0xC200_1000, 0x8700_0000, 0xFFFF_FFFF, 0x8800_0000, 0xC100_0000] {
            assert_eq!(bench.exchange(out), 0xC100_0001, "{out:08X} while the bit stays 1");
        }
        bench.exchange(0);
        assert_eq!(bench.service(0x8100_0000), 0x8100_0001);
        assert_eq!(bench.data_check(), 0x8800_0000, "no other service was done");
    }
}

#[test]
fn changes_while_busy_are_ignored_too() {
    let mut bench = with_default_times(ce65());
    let start = bench.now + MS;
    after(&mut bench, start, 0, 0xC200_0FFF);
    after(&mut bench, start, MS, 0xC200_1FFF);
    after(&mut bench, start, 2 * MS, 0x8700_0000);
    assert_eq!(after(&mut bench, start, 10 * MS, 0xC600_0001), 0xC200_0FFF);
    after(&mut bench, start, 11 * MS, 0);
    assert_eq!(after(&mut bench, start, 12 * MS, 0x8200_0000), 0x8200_0FFF);
}

#[test]
fn a_torn_request_is_taken_as_it_arrives() {
    let mut bench = ce65();
    bench.exchange(0x0000_FFFF);
    // Word 1 is new, word 2 still old: the encoder cannot know.
    assert_eq!(bench.exchange(0xC200_FFFF), 0xC200_FFFF);
    assert_eq!(bench.exchange(0xC200_270F), 0xC200_FFFF);
    bench.exchange(0);
    assert_eq!(bench.service(0x8200_0000), 0x8200_FFFF);
}

#[test]
fn a_stale_service_bit_at_power_up_moves_nothing() {
    for mut bench in every_model() {
        bench.turn_to(100_000);
        let position = bench.position();
        bench.exchange(0xC600_0001);
        assert_ne!(bench.exchange(0), position, "the same word was a request before");
        bench.service(0xC600_0000 | position);
        bench.power_off();
        bench.power_up();
        for k in 0..20_u32 {
            assert_eq!(bench.exchange(0xC600_0001 + k), position, "{}", bench.model());
        }
        assert_eq!(bench.exchange(0x4600_0001), position);
        assert_eq!(bench.exchange(0xC600_0001), 0xC600_0001, "after a 0 it is a request");
        assert_eq!(bench.exchange(0), 1);
    }
}

#[test]
fn a_stale_write_at_power_up_writes_nothing() {
    for mut bench in every_model() {
        let memory = bench.memory.clone();
        bench.power_up();
        bench.exchange_now(0xC100_0001);
        bench.exchange(0xC100_0001);
        assert_eq!(bench.memory, memory);
    }
}

#[test]
fn the_default_service_times_are_0_10_20_and_10_ms() {
    let times = [
        (0x8200_0000, 0, 0x82FF_FFFF),
        (0x8600_0000, 0, 0xA600_0000),
        (0x8700_0000, 0, 0xA700_0000),
        (0xC200_0FFF, 10, 0xC200_0FFF),
        (0xC700_0001, 10, 0xE700_0001),
        (0xC800_0000, 10, 0xE800_0000),
        (0xC600_0001, 10, 0xC600_0001),
        (0x8800_0000, 20, 0x8800_0000),
    ];
    for (out, ms, reply) in times {
        for bench in [ce100(), ce65()] {
            let mut bench = with_default_times(bench);
            let start = bench.now + MS;
            if ms > 0 {
                assert_eq!(after(&mut bench, start, 0, out), 0);
                assert_eq!(after(&mut bench, start, ms * MS - 1, out), 0, "{out:08X}");
            }
            assert_eq!(after(&mut bench, start, ms * MS, out), reply);
            assert_eq!(after(&mut bench, start, ms * MS + 1, out), reply);
        }
    }
}

#[test]
fn a_service_is_completed_in_the_first_exchange_after_its_time() {
    let mut bench = with_default_times(ce100());
    let start = bench.now + MS;
    after(&mut bench, start, 0, 0xC200_0FFF);
    assert_eq!(after(&mut bench, start, 9 * MS, 0xC200_0FFF), 0);
    assert_eq!(after(&mut bench, start, 33 * MS, 0xC200_0FFF), 0xC200_0FFF);
}

// [R36]
#[test]
fn a_busy_encoder_shows_the_moving_position_and_has_changed_nothing() {
    let mut bench = with_default_times(ce65());
    let memory = bench.memory.clone();
    let start = bench.now + MS;
    for k in 0..10_u32 {
        bench.turn_to(i64::from(k) * 100);
        assert_eq!(after(&mut bench, start, u64::from(k) * MS, 0xC700_0000), k * 100, "no bit 29 yet");
        assert_eq!(bench.memory, memory);
    }
    assert_eq!(after(&mut bench, start, 10 * MS, 0xC700_0000), 0xE700_0000);

    let mut bench = with_default_times(la66());
    let memory = bench.memory.clone();
    let start = bench.now + MS;
    bench.turn_to(500_000);
    for k in 0..10 {
        assert_eq!(after(&mut bench, start, k * MS, 0xC200_0064), 0xC350, "the old length");
        assert_eq!(bench.memory, memory);
    }
    assert_eq!(after(&mut bench, start, 10 * MS, 0xC200_0064), 0xC200_0064);
    assert_ne!(bench.memory, memory);
    assert_eq!(after(&mut bench, start, 11 * MS, 0), 0x64);
}

#[test]
fn a_preset_acts_on_the_sample_of_the_completing_exchange() {
    for bench in [ce100(), ce65()] {
        let mut bench = with_default_times(bench);
        let start = bench.now + MS;
        bench.turn_to(1000);
        after(&mut bench, start, 0, 0xC600_4000);
        bench.turn_to(5000);
        assert_eq!(after(&mut bench, start, 10 * MS, 0xC600_4000), 0xC600_4000);
        assert_eq!(after(&mut bench, start, 11 * MS, 0), 0x4000);
        bench.turn_to(1000);
        assert_eq!(after(&mut bench, start, 12 * MS, 0), 0x4000 - 4000);
    }
}

#[test]
fn a_data_check_judges_the_magnet_of_the_completing_exchange() {
    let mut bench = with_default_times(la66());
    let start = bench.now + MS;
    after(&mut bench, start, 0, 0x8800_0000);
    bench.terminals.magnet = Magnet::Missing;
    assert_eq!(after(&mut bench, start, 20 * MS, 0x8800_0000), 0xA800_0020);

    let start = bench.now + MS;
    after(&mut bench, start, 0, 0);
    assert_eq!(after(&mut bench, start, MS, 0x8800_0000), 0x2000_0000);
    bench.terminals.magnet = Magnet::Present;
    assert_eq!(after(&mut bench, start, 21 * MS, 0x8800_0000), 0x8800_0020);
}

/// How often each record was written, but that of every power-off.
fn writes_but_of_turn_counts(bench: &mut Bench) -> Vec<u32> {
    let records = Record::of(bench.model()).filter(|record| *record != Record::TurnCount);
    records.map(|record| write_count(&mut bench.memory, record)).collect()
}

#[test]
fn a_service_that_the_supply_interrupts_was_not_done() {
    for bench in every_model() {
        let mut bench = with_default_times(bench);
        bench.turn_to(100_000);
        let position = bench.position();
        for out in [0xC600_0001, 0xC200_0FFF, 0xC100_0001] {
            let writes = writes_but_of_turn_counts(&mut bench);
            assert_eq!(bench.exchange(out), position);
            bench.advance(8 * MS);
            assert_eq!(bench.exchange_now(out), position);
            bench.power_off();
            bench.power_up();
            for _ in 0..30 {
                assert_eq!(bench.exchange(out), position, "no reply and no change");
            }
            bench.exchange(0);
            assert_eq!(writes_but_of_turn_counts(&mut bench), writes);
        }
    }
}

#[test]
fn a_withdrawn_service_is_done_and_its_reply_shown_once() {
    for bench in [ce100(), ce65()] {
        let mut bench = with_default_times(bench);
        let start = bench.now + MS;
        // A pulse of one exchange.
        assert_eq!(after(&mut bench, start, 0, 0xC600_0123), 0);
        for k in 1..10 {
            assert_eq!(after(&mut bench, start, k * MS, 0), 0);
        }
        assert_eq!(after(&mut bench, start, 10 * MS, 0), 0xC600_0123);
        assert_eq!(after(&mut bench, start, 11 * MS, 0), 0x0123);
    }
}

#[test]
fn a_bit_that_rises_again_before_the_withdrawn_service_is_done_is_no_request() {
    let mut bench = with_default_times(ce65());
    let start = bench.now + MS;
    after(&mut bench, start, 0, 0xC600_0123);
    after(&mut bench, start, MS, 0);
    after(&mut bench, start, 2 * MS, 0xC600_0FFF);
    assert_eq!(after(&mut bench, start, 10 * MS, 0xC600_0FFF), 0xC600_0123);
    for k in 11..40 {
        assert_eq!(after(&mut bench, start, k * MS, 0xC600_0FFF), 0x0123);
    }
    assert_eq!(after(&mut bench, start, 40 * MS, 0), 0x0123);
    after(&mut bench, start, 41 * MS, 0xC600_0FFF);
    assert_eq!(after(&mut bench, start, 51 * MS, 0xC600_0FFF), 0xC600_0FFF);
}

#[test]
fn an_error_that_appears_during_the_reply_is_seen_after_it() {
    let mut bench = la66();
    assert_eq!(bench.exchange(0x8200_0000), 0x8200_C350);
    bench.terminals.magnet = Magnet::Missing;
    for _ in 0..5 {
        assert_eq!(bench.exchange(0x8200_0000), 0x8200_C350);
    }
    assert_eq!(bench.exchange(0), 0x2000_0000);
}

// [R39]
#[test]
fn the_position_of_the_end_is_fresh_and_not_that_of_the_request() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(5);
        bench.exchange(0x8100_0000);
        bench.turn_to(77);
        assert_eq!(bench.exchange(0x8100_0000), 0x8100_0000, "no position while the reply is shown");
        assert_eq!(bench.exchange(0x0100_0000), 77);
    }
}
