//! Every cell of the EEPROM fails, in every way: a fault is reported, and what is shown is never a mixture.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::formula::{Rotary, rod_steps};
use common::{Bench, CellFault, Hiccup, ce65, ce100, la66};
use encoring_encoder::records::EEPROM_BYTES;
use encoring_words::model::Sensor;
use encoring_words::parameter::Direction;
use encoring_words::{Model, Parameter, ParameterSet, Service};

const FAULTS: [CellFault; 6] = [
    CellFault::Read,
    CellFault::Write,
    CellFault::Stuck(0x00),
    CellFault::Stuck(0xFF),
    CellFault::Stuck(0xA5),
    CellFault::Stuck(0x3C),
];

const MODELS: [fn() -> Bench; 3] = [la66, ce100, ce65];

/// A parameter: its service, and three values that are written one after the other. Any choice of one value for each
/// service is valid.
type Values = (u32, [u32; 3]);

const LA66: &[Values] = &[(1, [0, 1, 0]), (2, [0x1234, 0x2345, 0x3456]), (4, [0x1111, 0x2222, 0x3333])];
const CE100: &[Values] = &[
    (1, [0, 1, 0]),
    (2, [0xFFFF, 0x7FFF, 0x3FFF]),
    (3, [8192, 5000, 6000]),
    (4, [0x1111, 0x2222, 0x3333]),
    (5, [0x1112, 0x2223, 0x3334]),
    (9, [3, 2, 1]),
];
const CE65: &[Values] = &[
    (1, [0, 1, 0]),
    (2, [0xFFFF, 0x7FFF, 0x3FFF]),
    (3, [8192, 5000, 6000]),
    (9, [3, 2, 1]),
    (0xD, [0x0119, 0x01_0018, 0x0020]),
];

fn table(model: Model) -> &'static [Values] {
    match model {
        Model::La66 => LA66,
        Model::Ce100M => CE100,
        Model::Ce65M => CE65,
    }
}

fn parameter(number: u32) -> Parameter {
    Parameter::from_service(Service::from_number(u8::try_from(number).unwrap()).unwrap()).unwrap()
}

/// The set of the factory (`None`) or of one round of writes.
fn set(bench: &Bench, round: Option<usize>) -> ParameterSet {
    let mut set = ParameterSet::factory(bench.unit.model(), bench.unit.sensor());
    if let Some(round) = round {
        for (number, values) in table(bench.model()) {
            set.set(parameter(*number), values[round]);
        }
    }
    set
}

/// Where a preset was made, and to which value, in each round.
const PRESETS: [(i64, u32); 3] = [(77_770, 0x0123), (123_450, 0x0456), (200_000, 0x0789)];

fn write_all(bench: &mut Bench, round: usize) {
    for (number, values) in table(bench.model()) {
        let write = 0xC000_0000 | number << 24 | values[round];
        assert_eq!(bench.service(write), write);
    }
    assert_eq!(bench.data_check(), 0x8800_0000);
    bench.position_at(PRESETS[round].0);
    bench.service(0xC600_0000 | PRESETS[round].1);
    bench.power_cycle();
}

/// A device of which both copies of every record were written: the older one in round 0, the newer in round 1.
fn written_twice(new: fn() -> Bench) -> Bench {
    let mut bench = new();
    write_all(&mut bench, 0);
    write_all(&mut bench, 1);
    bench
}

/// The offset of a preset as a pair of numerator and denominator.
type Offset = (i128, i128);

fn rotary(set: &ParameterSet, steps_per_turn: u32) -> Rotary {
    Rotary {
        q: steps_per_turn.into(),
        s: set.measuring_length().into(),
        n: set.numerator().into(),
        d: set.denominator().into(),
        falling: set.counting_direction().direction == Direction::Falling,
    }
}

/// What the formulas of the specification show at `raw`.
fn formula(sensor: Sensor, set: &ParameterSet, offset: Offset, raw: i64) -> u32 {
    match sensor {
        Sensor::Rotary { steps_per_turn } => {
            let rotary = rotary(set, steps_per_turn);
            rotary.value(raw, offset.0 * rotary.d / offset.1)
        }
        Sensor::Linear { rod_um } => {
            let falling = set.counting_direction().direction == Direction::Falling;
            let steps = rod_steps(raw, rod_um.into(), set.measuring_length().into(), falling);
            u32::try_from((i128::from(steps) + offset.0).rem_euclid(1 << 24)).unwrap()
        }
    }
}

/// The offset that a round's preset left, made under `set`.
fn preset(bench: &Bench, set: &ParameterSet, round: usize) -> Offset {
    let (raw, value) = PRESETS[round];
    match bench.unit.sensor() {
        Sensor::Rotary { steps_per_turn } => {
            let rotary = rotary(set, steps_per_turn);
            (rotary.preset(raw, value), rotary.d)
        }
        sensor @ Sensor::Linear { .. } => {
            (i128::from(value) - i128::from(formula(sensor, set, (0, 1), raw)), 1)
        }
    }
}

const PLACES: [i64; 6] = [0, 12_345, 77_770, 123_450, 200_000, 499_999];

/// The positions at all places under one of these offsets, or a panic: anything else is a mixture.
fn positions_follow_from(bench: &mut Bench, offsets: &[Offset], what: &str) {
    let (sensor, set) = (bench.unit.sensor(), *bench.encoder.active());
    let positions = PLACES.map(|raw| bench.position_at(raw) & 0xFF_FFFF);
    let possible = offsets.iter().any(|o| PLACES.map(|raw| formula(sensor, &set, *o, raw)) == positions);
    assert!(possible, "{what}: {positions:X?} under {set:X?}");
}

fn sweep(check: impl Fn(&Bench, usize, CellFault, &str)) {
    for new in MODELS {
        let bench = written_twice(new);
        for cell in 0..EEPROM_BYTES {
            for fault in FAULTS {
                check(&bench, cell, fault, &format!("{}, cell {cell}, {fault:?}", bench.model()));
            }
        }
    }
}

/// The fault comes while the device is off.
// [R98]
#[test]
fn a_fault_found_at_power_up_is_never_a_mixture() {
    sweep(|bench, cell, fault, what| {
        let mut bench = bench.clone();
        let (newer, older) = (set(&bench, Some(1)), set(&bench, Some(0)));
        let offsets = [preset(&bench, &newer, 1), preset(&bench, &older, 0), (0, 1)];
        bench.power_off();
        bench.memory.break_cell(cell, fault);
        bench.power_up();
        let failed = bench.exchange_now(0) >> 29 == 1;
        let status = bench.clone().data_check();
        let (lost, unwritten) = match bench.model() {
            Model::La66 => (failed, false),
            Model::Ce100M | Model::Ce65M => (status & 1 != 0, status & 2 != 0),
        };
        assert_eq!(failed, lost || unwritten, "{what}: bit 29 at power-up is 2^0 or 2^1");
        assert!(failed || status == 0x8800_0000, "{what}: {status:08X}");

        let programmed = *bench.encoder.parameters().programmed();
        let mut changed = 0;
        for (number, values) in table(bench.model()) {
            let value = programmed.value(parameter(*number));
            let factory = set(&bench, None).value(parameter(*number));
            assert!(values[..2].contains(&value) || lost && value == factory, "{what}: {number} {value:X}");
            changed += u32::from(value != values[1]);
        }
        assert!(changed <= 1, "{what}: one cell is in one record");
        let active = *bench.encoder.active();
        match bench.model() {
            Model::La66 => assert_eq!(active, programmed, "{what}"),
            _ if lost => assert!([programmed, newer, older].contains(&active), "{what}: {active:X?}"),
            // The accepted set fell back to its older copy and the take-over could not be stored.
            _ if unwritten => assert_eq!(active, older, "{what}"),
            _ => assert_eq!(active, programmed, "{what}"),
        }
        positions_follow_from(&mut bench, &offsets, what);

        match fault {
            CellFault::Write => assert_eq!((active, failed), (newer, false), "{what}: nothing was written"),
            CellFault::Stuck(_) => assert!(!lost, "{what}: the other copy is good"),
            CellFault::Read => {}
        }
    });
}

/// The fault comes while the device is on; then every value is written, accepted and preset anew.
// [R98]
#[test]
fn a_write_under_a_fault_is_done_or_refused_and_never_half() {
    sweep(|bench, cell, fault, what| {
        let mut bench = bench.clone();
        let old_offset = preset(&bench, &set(&bench, Some(1)), 1);
        bench.memory.break_cell(cell, fault);
        let mut in_use = set(&bench, Some(1));
        let mut refused = 0;
        for (number, values) in table(bench.model()) {
            let write = 0xC000_0000 | number << 24 | values[2];
            bench.data_check();
            let pending = bench.encoder.error_pending();
            let reply = bench.exchange(write);
            bench.exchange(0);
            assert_eq!(reply & !(1 << 29), write, "{what}");
            let stored = bench.encoder.parameters().programmed().value(parameter(*number)) == values[2];
            if stored {
                in_use.set(parameter(*number), values[2]);
                assert!(pending || reply == write, "{what}");
                assert_eq!(bench.service(0x8000_0000 | number << 24) & 0xFF_FFFF, values[2], "{what}");
            } else {
                refused += 1;
                assert_eq!(reply, write | 1 << 29, "{what}");
                let told = bench.data_check() & 2;
                assert_eq!(told, if bench.model() == Model::La66 { 0 } else { 2 }, "{what}");
            }
            assert_eq!(*bench.encoder.parameters().programmed(), in_use, "{what}: nothing else changed");
        }

        let check = bench.data_check();
        let accepted = *bench.encoder.active();
        if check == 0x8800_0000 {
            assert_eq!(accepted, in_use, "{what}");
        } else {
            refused += 1;
            assert_eq!(check, 0xA800_0002, "{what}");
        }

        bench.position_at(PRESETS[2].0);
        let before = bench.encoder.position();
        let adjusted = bench.exchange(0xC600_0000 | PRESETS[2].1) == 0xC600_0000 | PRESETS[2].1;
        let after = bench.exchange(0) & 0xFF_FFFF;
        let offset = if after == PRESETS[2].1 { preset(&bench, &accepted, 2) } else { old_offset };
        if after != PRESETS[2].1 {
            refused += 1;
            assert!(!adjusted && after == before, "{what}");
        }
        positions_follow_from(&mut bench, &[offset], what);
        assert!(refused <= 1 || check != 0x8800_0000, "{what}: one cell is in one record");

        // Old or new, also after the supply was off.
        bench.turn_to(PRESETS[2].0);
        let lost = bench.power_cycle() >> 29 == 1;
        let programmed = *bench.encoder.parameters().programmed();
        for (number, values) in table(bench.model()) {
            let value = programmed.value(parameter(*number));
            let factory = set(&bench, None).value(parameter(*number));
            if fault == CellFault::Write {
                assert_eq!(value, in_use.value(parameter(*number)), "{what}: what was in use");
            }
            assert!(values.contains(&value) || lost && value == factory, "{what}: {value:X}");
        }
        if fault == CellFault::Write {
            positions_follow_from(&mut bench, &[offset], what);
        }
    });
}

/// R85: the other way round than above, a read fault must not pass unnoticed.
// [R85]
#[test]
fn a_value_that_cannot_be_read_at_all_is_told_by_every_read_service() {
    for new in [ce100, ce65] {
        let bench = written_twice(new);
        for (number, values) in table(bench.model()) {
            let mut bench = bench.clone();
            let read = 0x8000_0000 | number << 24;
            assert_eq!(bench.service(read), read | values[1]);
            bench.memory.break_all(CellFault::Read);
            assert_eq!(bench.service(read), read | 1 << 29);
            bench.memory.repair();
            assert_eq!(bench.data_check(), 0x8800_0001);
            assert_eq!(bench.service(read), read | values[1]);
        }
    }
}

/// The cells of the copy that a write changes, in a device that is then thrown away.
fn next_copy(bench: &Bench, outs: &[u32]) -> Vec<usize> {
    let mut bench = bench.clone();
    let before = bench.memory.clone();
    for out in outs {
        bench.service(*out);
    }
    (0..EEPROM_BYTES).filter(|cell| bench.memory.image()[*cell] != before.image()[*cell]).collect()
}

#[test]
fn an_unreadable_cell_in_the_older_copy_of_the_offset_does_not_move_the_position() {
    for new in MODELS {
        let bench = written_twice(new);
        // The next write would go to the older copy.
        for cell in next_copy(&bench, &[0xC600_0789]) {
            let mut bench = bench.clone();
            let position = bench.position() & 0xFF_FFFF;
            bench.power_off();
            bench.memory.break_cell(cell, CellFault::Read);
            bench.power_up();
            let shown = bench.exchange_now(0) & 0xFF_FFFF;
            assert_eq!(shown, position, "{}, cell {cell}: the newer copy is good", bench.model());
        }
    }
}

#[test]
fn an_unreadable_cell_in_the_older_copy_of_a_value_does_not_lose_the_newer() {
    for new in MODELS {
        let bench = written_twice(new);
        for (number, values) in table(bench.model()) {
            let write = 0xC000_0000 | number << 24 | values[2];
            for cell in next_copy(&bench, &[write]) {
                let mut bench = bench.clone();
                bench.memory.break_cell(cell, CellFault::Read);
                let reply = bench.service(0x8000_0000 | number << 24) & 0xFF_FFFF;
                assert_eq!(reply, values[1], "{}, service {number:X}, cell {cell}", bench.model());
            }
        }
    }
}

/// One call to the memory goes wrong during a service; what the reply says must be what the next power-up finds.
fn hiccups(write: u32, hiccup: Hiccup, looked_at: impl Fn(&mut Bench) -> u32) {
    for new in MODELS {
        let bench = written_twice(new);
        let old = looked_at(&mut bench.clone());
        let mut done = bench.clone();
        assert_eq!(done.service(write), write);
        done.power_cycle();
        let new = looked_at(&mut done);
        assert_ne!(old, new);
        let mut calls = 0;
        loop {
            let mut bench = bench.clone();
            bench.memory.hiccup_after(calls, hiccup);
            let refused = bench.service(write) & 1 << 29 != 0;
            if bench.memory.hiccup_is_ahead() {
                break;
            }
            bench.power_cycle();
            let what = format!("{} {write:08X}, call {calls} {hiccup:?}", bench.model());
            assert_eq!(looked_at(&mut bench), if refused { old } else { new }, "{what}");
            calls += 1;
        }
        assert!(calls > 8, "{calls} calls");
    }
}

#[test]
fn after_a_single_failing_call_the_next_power_up_finds_what_the_reply_said() {
    hiccups(0xC200_3456, Hiccup::NotDone, |bench| bench.service(0x8200_0000));
    hiccups(0xC600_0789, Hiccup::NotDone, |bench| bench.position_at(250_000));
}

#[test]
fn after_a_call_that_was_done_but_answered_with_an_error_the_next_power_up_finds_what_the_reply_said() {
    hiccups(0xC200_3456, Hiccup::DoneAfterAll, |bench| bench.service(0x8200_0000));
    hiccups(0xC600_0789, Hiccup::DoneAfterAll, |bench| bench.position_at(250_000));
}

/// What cannot be read may be the newer copy, so it is not written over.
#[test]
fn while_one_copy_cannot_be_read_another_value_is_refused_and_nothing_is_touched() {
    let mut bench = ce65();
    bench.exchange(0);
    assert_eq!(bench.service(0xC200_1234), 0xC200_1234);
    // Service 02 has its copies at 32 and 48; the newer is the second.
    bench.memory.break_cell(48, CellFault::Read);
    let before = bench.memory.image().to_vec();
    assert_eq!(bench.service(0xC200_2345), 0xE200_2345);
    assert_eq!(bench.memory.image(), before);
}
