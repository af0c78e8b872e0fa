//! The rules of a device behind its chip, one by one.
#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

use encoring_device::{BusDevice, OFF_BELOW_MV, OVERVOLTAGE_ABOVE_MV, Surroundings};
use encoring_encoder::records::{self, Record, write_count};
use encoring_encoder::{Ram, ServiceTimes, StaleService, Unit};
use encoring_ring::Taken;
use encoring_words::model::MODELS;
use encoring_words::{Instant, Model, OutWord};

const MS: u64 = 1_000_000;
const PRESET: u32 = 0xC600_0005;

/// A new device of a model, with the memory it is lent.
fn device(model: Model, stale_service: StaleService) -> (BusDevice, Ram) {
    let mut unit = Unit::new(model, model.sensor(None, None).unwrap()).unwrap();
    unit.service_times = ServiceTimes::ZERO;
    unit.stale_service = stale_service;
    let mut memory = Ram::blank();
    records::format(&unit, &mut memory).unwrap();
    (BusDevice::new(unit), memory)
}

const fn taken(word: u32) -> Taken {
    Taken { word: Some(OutWord(word)), resets: 1 }
}

const fn supplied(supply_mv: u32) -> Surroundings {
    let mut around = SOUND;
    around.supply_mv = supply_mv;
    around
}

const SOUND: Surroundings = Surroundings {
    terminals: encoring_encoder::Terminals {
        raw: 77,
        magnet: encoring_encoder::Magnet::Present,
        preset_mv: [0; 2],
    },
    supply_mv: 24_000,
};

// [R121]
#[test]
fn below_10_45_v_it_is_off_and_above_28_35_v_it_notes_an_overvoltage_and_goes_on() {
    assert_eq!((OFF_BELOW_MV, OVERVOLTAGE_ABOVE_MV), (10_450, 28_350));
    for model in MODELS {
        for (supply_mv, on, over) in [
            (0, false, false),
            (10_449, false, false),
            (10_450, true, false),
            (28_350, true, false),
            (28_351, true, true),
        ] {
            let (mut device, mut memory) = device(model, StaleService::Ignored);
            let input = device.exchange(Instant(MS), OutWord(0), &supplied(supply_mv), &mut memory);
            assert_eq!(input.is_some(), on, "a {model} at {supply_mv} mV");
            assert_eq!((device.encoder().is_some(), device.overvoltage()), (on, over), "{supply_mv} mV");
        }
    }
}

#[test]
fn a_dip_that_is_told_between_two_exchanges_is_a_power_off_with_its_turn_count() {
    for (cut, counts) in [(false, 1), (true, 0)] {
        let (mut device, mut memory) = device(Model::Ce65M, StaleService::Ignored);
        let before = write_count(&mut memory, Record::TurnCount);
        device.exchange(Instant(MS), OutWord(0), &SOUND, &mut memory);
        if cut {
            // In the middle of a write there is no time for it.
            device.cut();
        }
        device.supply(Instant(2 * MS), OFF_BELOW_MV - 1, &mut memory);
        assert!(device.encoder().is_none());
        assert_eq!(write_count(&mut memory, Record::TurnCount) - before, counts, "cut: {cut}");
        device.supply(Instant(3 * MS), 24_000, &mut memory);
        assert!(device.exchange(Instant(4 * MS), OutWord(0), &SOUND, &mut memory).is_some());
    }
}

#[test]
fn without_cycles_there_is_an_exchange_every_refresh_time_that_looks_at_that_refresh() {
    for model in MODELS {
        let (mut device, mut memory) = device(model, StaleService::Ignored);
        let began = Instant(7 * MS);
        device.exchange(began, OutWord(0), &SOUND, &mut memory);
        let until = Instant(57 * MS);
        let mut count = 0;
        while let Some(at) = device.due_without_cycles(until) {
            count += 1;
            let refreshes = at.since(began).as_nanos() / model.refresh().as_nanos();
            assert_eq!((refreshes, device.looks_at(at)), (count, at), "{model}");
            device.exchange(at, OutWord(0), &SOUND, &mut memory);
        }
        assert_eq!(count, 50 * MS / model.refresh().as_nanos(), "{model}");
        // An exchange after a cycle lies somewhere between two refreshes and shows the earlier one.
        assert_eq!(device.looks_at(Instant(57 * MS + 400_000)), until);
    }
}

// [R144, D43]
#[test]
fn a_device_that_was_switched_on_waits_for_its_first_word_or_for_25_ms() {
    for model in MODELS {
        let (mut device, mut memory) = device(model, StaleService::Ignored);
        assert!(!device.exchanges_after_cycle(taken(0)), "without supply there is none");
        let on = Instant(100 * MS);
        device.supply(on, 24_000, &mut memory);
        assert!(!device.exchanges_after_cycle(Taken::default()), "a bad cycle brings no word");
        assert!(device.exchanges_after_cycle(taken(PRESET)));
        assert_eq!(device.due_without_cycles(Instant(125 * MS)), None);
        let late = Instant(125 * MS + 1);
        assert_eq!(device.due_without_cycles(late), Some(late), "once, and not for all the time before");
        let out = device.hears(Taken::default());
        assert_eq!((out, device.looks_at(late)), (OutWord(0), late));
        assert!(device.exchange(late, out, &SOUND, &mut memory).is_some());
        assert_eq!(device.due_without_cycles(late), None);
        assert!(device.exchanges_after_cycle(Taken::default()), "from now on it follows every cycle");
    }
}

/// What the encoder hears of what its chip holds, exchange by exchange, from power-up on.
fn heard(stale_service: StaleService, held: &[Taken]) -> Vec<u32> {
    let (mut device, mut memory) = device(Model::Ce65M, stale_service);
    let exchange = |(at, held): (usize, &Taken)| {
        let out = device.hears(*held);
        device.exchange(Instant(at as u64 * MS), out, &SOUND, &mut memory);
        out.0
    };
    held.iter().enumerate().map(exchange).collect()
}

// [R144, D43]
#[test]
fn after_a_reset_a_service_bit_is_held_back_until_a_cycle_has_brought_0() {
    let first = taken(0);
    let reset = first.reset();
    let after = |word: u32| Taken { word: Some(OutWord(word)), ..reset };
    let held = [first, taken(PRESET), reset, reset, after(PRESET), after(0x4600_0005), after(PRESET)];
    let ignored = [0, PRESET, 0, 0, 0x4600_0005, 0x4600_0005, PRESET];
    assert_eq!(heard(StaleService::Ignored, &held), ignored);
    let executed = [0, PRESET, 0, 0, PRESET, 0x4600_0005, PRESET];
    assert_eq!(heard(StaleService::Executed, &held), executed);
}

#[test]
fn a_reset_that_was_over_before_the_next_exchange_holds_the_service_bit_back_too() {
    let reset = taken(0).reset();
    let held = [taken(0), Taken { word: Some(OutWord(PRESET)), ..reset }];
    assert_eq!(heard(StaleService::Ignored, &held), [0, 0x4600_0005]);
}

// [R144, D1]
#[test]
fn the_first_word_after_power_up_passes_whole_and_is_the_encoders_affair() {
    for (stale_service, adjusted) in [(StaleService::Ignored, 0), (StaleService::Executed, 1)] {
        let (mut device, mut memory) = device(Model::Ce65M, stale_service);
        let formatted = write_count(&mut memory, Record::Offset);
        for at in 0..3 {
            let out = device.hears(taken(PRESET));
            assert_eq!(out, OutWord(PRESET));
            device.exchange(Instant(at * MS), out, &SOUND, &mut memory);
        }
        assert_eq!(write_count(&mut memory, Record::Offset) - formatted, adjusted, "{stale_service}");
    }
}

// [R71]
#[test]
fn a_preset_input_above_30_v_is_an_overvoltage_where_the_model_has_the_input() {
    for (model, input, noted) in [
        (Model::La66, 0, true),
        (Model::La66, 1, false),
        (Model::Ce100M, 0, true),
        (Model::Ce100M, 1, true),
        (Model::Ce65M, 0, false),
    ] {
        for (millivolts, over) in [(30_000, false), (30_001, true)] {
            let mut around = SOUND;
            *around.terminals.preset_mv.get_mut(input).unwrap() = millivolts;
            assert_eq!(around.preset_overvoltage(model), over && noted, "{model} {input} {millivolts} mV");
        }
    }
}
