//! The supply fails after every single byte that is written: old or new, never a mixture.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, Memory, ce65, ce65_8192, ce100, every_model, la66};
use encoring_encoder::records;
use encoring_words::Model;
use encoring_words::model::Sensor;

/// All that can be seen of a device after it is switched on: replies to every read, positions, the error bit before
/// and the status after.
fn seen(bench: &Bench) -> Vec<u32> {
    let mut bench = bench.clone();
    let mut words = vec![bench.exchange_now(0)];
    for number in 0..16 {
        if number != 8 {
            words.push(bench.exchange(0x8000_0000 | number << 24));
            words.push(bench.exchange(0) & 0x2000_0000);
        }
    }
    for raw in [0, 1, 4096, 40_961, 123_456, 250_000, 499_999] {
        words.push(bench.position_at(raw));
    }
    words.push(bench.data_check());
    for raw in [0, 4096, 250_000] {
        words.push(bench.position_at(raw));
    }
    words
}

/// Switches a device off without a word, and on again.
fn restarted(bench: &Bench) -> Bench {
    let mut bench = bench.clone();
    bench.memory.power_back();
    bench.power_up();
    bench
}

/// Cuts the supply after each byte that `act` writes. After it the device is as before, or as if nothing had failed,
/// and `act` can be repeated.
fn sweep(name: &str, bench: &Bench, act: impl Fn(&mut Bench)) {
    let old = seen(&restarted(bench));
    let mut done = bench.clone();
    act(&mut done);
    let bytes = done.memory.written() - bench.memory.written();
    let new = seen(&restarted(&done));
    assert!(bytes > 0, "{name} writes something");
    assert_ne!(old, new, "{name} can be seen");
    let mut is_new = false;
    for cut in 0..=bytes {
        let mut cut_short = bench.clone();
        cut_short.memory.cut_after(cut);
        act(&mut cut_short);
        let mut after = restarted(&cut_short);
        let words = seen(&after);
        assert!(words == old || words == new, "{name}, cut after {cut} of {bytes} bytes");
        assert!(words == new || !is_new, "{name}: once new it stays new ({cut})");
        is_new = words == new;
        // The memory has taken no harm.
        after.exchange_now(0);
        act(&mut after);
        assert_eq!(seen(&restarted(&after)), new, "{name}, repeated after a cut at {cut}");
    }
    assert!(is_new, "{name} is done after its last byte");
}

/// Does `act` to a device in the state after `earlier` writes of the same kind: with one or both copies written.
fn sweep_write(bench: &Bench, writes: [u32; 3], settle: &[u32]) {
    for earlier in 0..3 {
        let mut bench = bench.clone();
        bench.turn_to(123_456);
        bench.exchange(0);
        for write in &writes[..earlier] {
            bench.exchange(*write);
            bench.exchange(0);
            for out in settle {
                bench.exchange(*out);
                bench.exchange(0);
            }
        }
        let write = writes[earlier];
        let name = format!("{} {write:08X} as write number {}", bench.model(), earlier + 2);
        sweep(&name, &bench, |bench| {
            bench.exchange(write);
            bench.exchange(0);
        });
    }
}

// [R144]
#[test]
fn every_parameter_of_every_model() {
    let direction = [0xC100_0001, 0xC100_0000, 0xC100_0001];
    let length = [0xC200_1234, 0xC2AB_CDEF, 0xC200_0FFF];
    let numerator = [0xC300_7FFF, 0xC300_FFFF, 0xC300_1001];
    let denominator = [0xC900_0000 | 2, 0xC900_0063, 0xC900_0001];
    let preset_1 = [0xC4FF_0000, 0xC400_00FF, 0xC412_3456];
    let preset_2 = [0xC5FF_0000, 0xC500_00FF, 0xC512_3456];
    let ssi = [0xCD01_0118, 0xCD00_0120, 0xCD00_0008];
    for writes in [direction, length, preset_1] {
        sweep_write(&la66(), writes, &[]);
    }
    for writes in [direction, length, numerator, denominator, preset_1, preset_2] {
        sweep_write(&ce100(), writes, &[]);
    }
    for writes in [direction, length, numerator, denominator, ssi] {
        sweep_write(&ce65(), writes, &[]);
    }
    sweep_write(&ce65_8192(), length, &[]);
}

#[test]
fn parameters_that_each_data_check_accepted_before() {
    for bench in [ce100(), ce65()] {
        sweep_write(&bench, [0xC200_1234, 0xC2AB_CDEF, 0xC200_0FFF], &[0x8800_0000]);
    }
}

// [R144]
#[test]
fn the_preset_offset_of_every_model() {
    for bench in every_model() {
        sweep_write(&bench, [0xC600_1234, 0xC600_0001, 0xC600_FFFF], &[]);
    }
}

// [R144]
#[test]
fn the_accepted_set() {
    // The restart takes over what was programmed, unless that is bad: so a bad numerator follows the check.
    for bench in [ce100(), ce65()] {
        for earlier in 0..3 {
            let mut bench = bench.clone();
            bench.turn_to(123_456);
            let sets = [[0xC200_0FFF, 0xC100_0001], [0xC200_1FFF, 0xC100_0000], [0xC200_3FFF, 0xC100_0001]];
            for set in &sets[..earlier] {
                bench.program(set);
            }
            for out in sets[earlier] {
                bench.service(out);
            }
            let restart = |bench: &Bench| {
                // As if the numerator had become bad: the accepted set is all that is left.
                let mut bench = bench.clone();
                bench.memory.power_back();
                bench.service(0xC300_0000);
                bench.power_up();
                bench
            };
            let positions = |bench: &Bench| -> Vec<u32> {
                let mut bench = restart(bench);
                [0, 1, 4096, 123_456, 999_999].map(|raw| bench.position_at(raw)).to_vec()
            };
            let old = positions(&bench);
            let mut done = bench.clone();
            done.data_check();
            let new = positions(&done);
            assert_ne!(old, new);
            let bytes = done.memory.written() - bench.memory.written();
            assert!(bytes >= 18, "{bytes}");
            for cut in 0..=bytes {
                let mut cut_short = bench.clone();
                cut_short.memory.cut_after(cut);
                cut_short.data_check();
                let words = positions(&cut_short);
                assert!(words == old || words == new, "cut after {cut}");
                if cut == bytes {
                    assert_eq!(words, new);
                }
            }
        }
    }
}

#[test]
fn the_take_over_at_power_up() {
    for bench in [ce100(), ce65()] {
        let mut bench = bench;
        bench.program(&[0xC200_3FFF]);
        bench.turn_to(123_456);
        bench.service(0xC200_1FFF);
        bench.service(0xC100_0001);
        let mut done = bench.clone();
        done.power_up();
        let bytes = done.memory.written() - bench.memory.written();
        let expected = seen(&done);
        assert!(bytes > 0);
        for cut in 0..=bytes {
            let mut cut_short = bench.clone();
            cut_short.memory.cut_after(cut);
            cut_short.power_up();
            // The next power-up does what this one could not.
            assert_eq!(seen(&restarted(&cut_short)), expected, "cut after {cut}");
        }
    }
}

// [R144]
#[test]
fn the_turn_count() {
    for bench in [ce100(), ce65(), ce65_8192()] {
        let Sensor::Rotary { steps_per_turn } = bench.unit.sensor() else { panic!("a shaft") };
        let turn = i64::from(steps_per_turn);
        // Ten turns, so that 4096 turns more or less are seen. 1500 turns beyond the old count's reach.
        let mut bench = bench;
        bench.program(&[0xC200_270F, 0xC300_000A]);
        for (old, new) in [(0, 3500), (100, -3400), (7000, 10_500), (-1, 3456)] {
            bench.position_at(old * turn);
            bench.power_cycle();
            bench.position_at(old * turn);
            bench.position_at(new * turn);
            let mut done = bench.clone();
            done.power_off();
            let bytes = done.memory.written() - bench.memory.written();
            assert!(bytes > 0);
            let expected = seen(&restarted(&done));
            let before = seen(&restarted(&bench));
            assert_ne!(expected, before);
            for cut in 0..=bytes {
                let mut cut_short = bench.clone();
                cut_short.memory.cut_after(cut);
                cut_short.power_off();
                let words = seen(&restarted(&cut_short));
                assert!(words == expected || words == before, "cut after {cut}");
                assert!(cut < bytes || words == expected);
            }
            bench.power_cycle();
        }
    }
}

#[test]
fn a_format_that_is_cut_leaves_a_lost_memory_or_a_formatted_one() {
    for bench in every_model() {
        let mut memory = Memory::blank();
        records::format(&bench.unit, &mut memory).unwrap();
        let bytes = memory.written();
        for cut in 0..=bytes {
            let mut memory = Memory::blank();
            memory.cut_after(cut);
            assert_eq!(records::format(&bench.unit, &mut memory).is_ok(), cut == bytes);
            memory.power_back();
            let mut restarted = Bench::with_memory(&bench.unit, memory.clone());
            let lost = cut < bytes;
            assert_eq!(restarted.exchange_now(0), u32::from(lost) << 29, "{cut}");
            for raw in [0, 250_000, 400_000] {
                let factory = bench.clone().position_at(raw);
                assert_eq!(restarted.position_at(raw), factory | u32::from(lost) << 29);
            }
            let status = u32::from(lost && bench.model() != Model::La66);
            assert_eq!(restarted.data_check(), 0x8800_0000 | status);
            // Formatting once more heals it.
            records::format(&bench.unit, &mut memory).unwrap();
            let mut healed = Bench::with_memory(&bench.unit, memory);
            assert_eq!(healed.exchange_now(0), 0);
        }
    }
}

#[test]
fn the_first_write_to_a_blank_memory() {
    for bench in every_model() {
        let mut blank = Bench::with_memory(&bench.unit, Memory::blank());
        blank.exchange_now(0);
        blank.turn_to(123_456);
        for write in [0xC200_1234, 0xC100_0001, 0xC600_0123] {
            sweep(&format!("{} {write:08X}, blank", bench.model()), &blank, |bench| {
                bench.exchange(write);
                bench.exchange(0);
            });
        }
    }
}
