//! Whatever words, shafts, times and memories come: the device answers.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, CellFault, Memory, cases, every_model};
use encoring_encoder::records::{self, EEPROM_BYTES, Record};
use encoring_encoder::{Encoder, Magnet, ServiceTimes, Terminals};
use encoring_words::ssi_frame::Level;
use encoring_words::{InWord, Instant, OutWord};
use proptest::prelude::*;

#[derive(Clone, Debug)]
enum Act {
    Exchange { time: Time, out: u32, terminals: Terminals },
    Clock { time: Time, level: Level, terminals: Terminals },
    PowerCycle { time: Time, terminals: Terminals },
    Break { cell: Option<usize>, fault: CellFault },
    Repair,
    Cut { bytes: usize },
}

#[derive(Clone, Copy, Debug)]
enum Time {
    /// So many nanoseconds later.
    Later(u64),
    /// Any time, also an earlier one.
    At(u64),
}

fn times() -> impl Strategy<Value = Time> {
    prop_oneof![
        6 => (0..3_000_000_000_u64).prop_map(Time::Later),
        6 => (0..2_000_000_u64).prop_map(Time::Later),
        1 => any::<u64>().prop_map(Time::At),
        1 => Just(Time::At(u64::MAX)),
        1 => Just(Time::At(0)),
    ]
}

fn terminals() -> impl Strategy<Value = Terminals> {
    let raw = prop_oneof![
        4 => any::<i64>(),
        4 => -1_000_000..1_000_000_i64,
        1 => Just(i64::MIN),
        1 => Just(i64::MAX),
    ];
    let mv = prop_oneof![any::<u32>(), Just(24_000), Just(0)];
    (raw, any::<bool>(), [mv.clone(), mv]).prop_map(|(raw, missing, preset_mv)| Terminals {
        raw,
        magnet: if missing { Magnet::Missing } else { Magnet::Present },
        preset_mv,
    })
}

/// OUT words, half of them with a service number that some model knows and data near the ends of the ranges.
fn outs() -> impl Strategy<Value = u32> {
    let data =
        prop_oneof![Just(0), Just(1), Just(0x10), Just(0x63), Just(0xFFFF), Just(0xFF_FFFF), 0..1_u32 << 24];
    let service = prop_oneof![Just(1), Just(2), Just(3), Just(4), Just(6), Just(8), Just(9), Just(0xD)];
    prop_oneof![
        2 => any::<u32>(),
        4 => (service, data, any::<bool>()).prop_map(|(n, d, w)| 1 << 31 | u32::from(w) << 30 | n << 24 | d),
        3 => Just(0),
    ]
}

fn faults() -> impl Strategy<Value = CellFault> {
    prop_oneof![Just(CellFault::Read), Just(CellFault::Write), any::<u8>().prop_map(CellFault::Stuck)]
}

fn acts() -> impl Strategy<Value = Vec<Act>> {
    let level = prop_oneof![Just(Level::Low), Just(Level::High)];
    let act = prop_oneof![
        12 => (times(), outs(), terminals())
            .prop_map(|(time, out, terminals)| Act::Exchange { time, out, terminals }),
        4 => (times(), level, terminals())
            .prop_map(|(time, level, terminals)| Act::Clock { time, level, terminals }),
        2 => (times(), terminals()).prop_map(|(time, terminals)| Act::PowerCycle { time, terminals }),
        1 => (prop::option::of(0..EEPROM_BYTES), faults())
            .prop_map(|(cell, fault)| Act::Break { cell, fault }),
        1 => Just(Act::Repair),
        1 => (0..60_usize).prop_map(|bytes| Act::Cut { bytes }),
    ];
    prop::collection::vec(act, 1..60)
}

/// Does all of it and looks at every IN word.
fn play(bench: &mut Bench, acts: &[Act]) {
    for act in acts {
        match act {
            Act::Exchange { time, out, terminals } => {
                set_time(bench, *time);
                bench.terminals = *terminals;
                let input = bench.exchange_now(*out);
                match bench.encoder.handshake().reply() {
                    None => assert_eq!(input & 0xDF00_0000, 0, "normal mode: {input:08X}"),
                    Some(InWord(reply)) => {
                        assert_eq!(input, reply);
                        assert_eq!(input >> 31, 1);
                        assert_eq!(input & 1 << 28, 0);
                    }
                }
                let status = bench.encoder.latched_status();
                assert!(bench.unit.model().status_mask().contains(status));
            }
            Act::Clock { time, level, terminals } => {
                set_time(bench, *time);
                bench.encoder.ssi_clock(Instant(bench.now), *level, terminals);
                let _ = bench.encoder.ssi_level(Instant(bench.now));
                let _ = bench.encoder.ssi_level(Instant(0));
            }
            Act::PowerCycle { time, terminals } => {
                bench.power_off();
                bench.memory.power_back();
                set_time(bench, *time);
                bench.terminals = *terminals;
                bench.encoder =
                    Encoder::power_up(&bench.unit, Instant(bench.now), &bench.terminals, &mut bench.memory);
            }
            Act::Break { cell: Some(cell), fault } => bench.memory.break_cell(*cell, *fault),
            Act::Break { cell: None, fault } => bench.memory.break_all(*fault),
            Act::Repair => bench.memory.repair(),
            Act::Cut { bytes } => bench.memory.cut_after(*bytes),
        }
        for record in Record::of(bench.model()) {
            let _ = records::write_count(&mut bench.memory, record);
        }
    }
}

fn set_time(bench: &mut Bench, time: Time) {
    bench.now = match time {
        Time::Later(nanos) => bench.now.saturating_add(nanos),
        Time::At(nanos) => nanos,
    };
}

/// The position that is shown must always be one that the active set can have.
fn position_is_legal(bench: &Bench) {
    let limit = match bench.unit.sensor() {
        encoring_words::model::Sensor::Linear { .. } => 0xFF_FFFF,
        encoring_words::model::Sensor::Rotary { .. } => bench.encoder.active().measuring_length(),
    };
    assert!(bench.encoder.position() <= limit);
}

proptest! {
    #![proptest_config(cases(150))]

    // [R24]
    #[test]
    fn no_sequence_of_acts_stops_a_device(acts in acts(), slow in any::<bool>()) {
        for bench in every_model() {
            let times = if slow { ServiceTimes::default() } else { ServiceTimes::ZERO };
            let mut bench = bench.rebuilt(|unit| unit.service_times = times);
            play(&mut bench, &acts);
            position_is_legal(&bench);
        }
    }

    #[test]
    fn no_memory_image_stops_a_device(
        image in prop::collection::vec(any::<u8>(), EEPROM_BYTES),
        markers in any::<bool>(),
        acts in acts(),
    ) {
        let mut image = image;
        if markers {
            // Slots that claim to be in force, wherever they are.
            for byte in image.iter_mut().step_by(16) {
                *byte = 0xA5;
            }
        }
        for bench in every_model() {
            let mut bench = Bench::with_memory(&bench.unit, Memory::from_image(image.clone()));
            play(&mut bench, &acts);
            position_is_legal(&bench);
        }
    }

    #[test]
    fn no_changed_byte_of_a_good_image_stops_a_device(
        outs in prop::collection::vec(outs(), 0..12),
        cell in 0..EEPROM_BYTES,
        xor in 1..=255_u8,
        acts in acts(),
    ) {
        for mut bench in every_model() {
            for out in outs.iter().filter(|out| *out >> 31 == 1) {
                bench.service(*out);
            }
            bench.power_cycle();
            bench.power_off();
            bench.memory.image_mut()[cell] ^= xor;
            bench.power_up();
            position_is_legal(&bench);
            play(&mut bench, &acts);
            position_is_legal(&bench);
        }
    }

    #[test]
    fn a_memory_of_another_device_does_not_stop_one(
        outs in prop::collection::vec(outs(), 0..20),
        acts in acts(),
    ) {
        for mut from in every_model() {
            for out in outs.iter().filter(|out| *out >> 31 == 1) {
                from.service(*out);
            }
            from.position_at(400_000);
            from.power_off();
            for to in every_model() {
                let mut bench = Bench::with_memory(&to.unit, from.memory.clone());
                position_is_legal(&bench);
                play(&mut bench, &acts);
                position_is_legal(&bench);
            }
        }
    }

    #[test]
    fn an_exchange_is_a_request_work_and_an_answer(acts in acts()) {
        for mut whole in every_model() {
            let mut parts = whole.clone();
            for act in &acts {
                let Act::Exchange { time, out, terminals } = act else { continue };
                set_time(&mut whole, *time);
                whole.terminals = *terminals;
                parts.encoder.request(Instant(whole.now), OutWord(*out), terminals);
                parts.encoder.work(terminals, &mut parts.memory);
                prop_assert_eq!(whole.exchange_now(*out), parts.encoder.answer().0);
                prop_assert_eq!(&whole.memory, &parts.memory);
            }
        }
    }
}

#[test]
fn the_same_calls_give_the_same_words() {
    for bench in every_model() {
        let words = |mut bench: Bench| -> Vec<u32> {
            let mut words = Vec::new();
            for k in 0..2000_u32 {
                bench.turn_to(i64::from(k.wrapping_mul(2_654_435_761)));
                words.push(bench.exchange(k.wrapping_mul(0x9E37_79B9)));
            }
            words
        };
        assert_eq!(words(bench.clone()), words(bench));
    }
}
