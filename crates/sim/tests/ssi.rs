//! Readers on the SSI of simulated encoders, beside the bus.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use std::path::Path;

use common::{Ring, device, scenario, set};
use encoring_host::ssi_receiver::{SsiFault, SsiTransfer, TakenAt};
use encoring_sim::replay::{compare, play};
use encoring_sim::scenario::Change;
use encoring_sim::ssi::{PlacedReader, SsiCard, SsiSettings};
use encoring_sim::{Fault, Node, Scenario};
use encoring_trace::RowKind;
use encoring_words::Duration;
use encoring_words::parameter::Code;
use proptest::prelude::*;

/// A CE-65-M that stands, with these SSI values accepted, and a reader with so many clocks every millisecond.
fn reading(raw: i64, ssi_values: u32, khz: u32, clocks: u32, more: &str) -> Ring {
    let hold = format!("motion = {{ kind = \"hold\", raw = {raw} }}\n{more}");
    let mut ring = Ring::new(&format!("version = 1\n{}", device(0, "ce-65-m", &hold)));
    ring.cycles(3);
    ring.service(0, 0xCD00_0000 | ssi_values);
    ring.service(0, 0x8800_0000);
    hang(&mut ring, khz, clocks, 2_000);
    ring
}

fn hang(ring: &mut Ring, khz: u32, clocks: u32, every_us: u64) {
    let every = Duration::from_micros(every_us);
    let settings = SsiSettings::new(khz * 1_000, clocks, every, TakenAt::Falling).unwrap();
    ring.world.change(0, &[Change::Ssi(Some(settings))]);
}

/// What the next transfer from now on brings.
fn next(ring: &mut Ring) -> SsiTransfer {
    let before = ring.world.places()[0].ssi().unwrap().count();
    for _ in 0..100 {
        ring.cycle();
        let reader = ring.world.places()[0].ssi().unwrap();
        // The one under way may have latched before.
        if reader.count() > before + 1 {
            return reader.read().unwrap().transfer;
        }
    }
    panic!("no transfer");
}

fn trouble(ring: &mut Ring, fault: &str) {
    let fault: Fault = fault.parse().unwrap();
    ring.world.change(0, &[Change::SsiTrouble(fault.on_ssi())]);
}

// [R104, R105, R116, R117]
#[test]
fn a_reader_reads_the_worked_words_at_every_guaranteed_rate() {
    let worked = [
        (0x0018, 24, "000000000010011100001111"),
        (0x0018, 25, "000000000010011100001111"),
        (0x0019, 25, "0000000000010011100001111"),
        (0x000E, 24, "10011100001111"),
        (0x0020, 32, "00000000000000000010011100001111"),
        (0x0118, 25, "000000000011010010001000"),
        (0x001F, 33, "00000000000000000100111000011111"),
        (0x011F, 33, "00000000000000000100111000011111"),
        (0x01_0018, 52, "000000000010011100001111"),
    ];
    for (values, clocks, bits) in worked {
        for khz in [80, 500, 1_000] {
            let transfer = next(&mut reading(0x27_0F, values, khz, clocks, ""));
            assert_eq!(transfer.bits().to_string(), bits, "{values:X} {clocks} {khz}");
            assert_eq!((transfer.position(), transfer.fault), (Some(0x27_0F), None));
        }
    }
}

// [R117]
#[test]
fn the_firmware_decides_what_31_bits_mean() {
    let old = "firmware = \"40/1997\"";
    let transfer = next(&mut reading(0x27_0F, 0x011F, 500, 33, old));
    assert_eq!(transfer.bits().to_string(), "0000000000000000011010010001000", "31 plain bits in Gray");
    assert_eq!((transfer.position(), transfer.fault), (Some(0x27_0F), None));
    let transfer = next(&mut reading(0x27_0F, 0x011F, 500, 33, "firmware = \"41/1997\""));
    assert_eq!(transfer.field, 0x4E1F, "31 bits binary and their parity");
}

// [R111, R112]
#[test]
fn below_50_khz_the_word_breaks_and_above_1_1_mhz_the_limit_is_named() {
    for (khz, fault) in [
        (40, Some(SsiFault::ClockLimit)),
        (50, None),
        (79, None),
        (1_100, None),
        (1_200, Some(SsiFault::ClockLimit)),
    ] {
        let transfer = next(&mut reading(0x92_3456, 0x18, khz, 25, ""));
        assert_eq!(transfer.fault, fault, "{khz} kHz");
        assert_eq!(transfer.reading(), (khz != 40).then_some(0x92_3456), "{khz} kHz");
    }
}

// [R145]
#[test]
fn what_stands_on_the_line_is_named() {
    for (fault, expected) in [("ssi_low", SsiFault::StuckLow), ("ssi_high", SsiFault::StuckHigh)] {
        let mut ring = reading(0x27_0F, 0x18, 500, 25, "");
        assert_eq!(next(&mut ring).fault, None);
        trouble(&mut ring, fault);
        assert_eq!(next(&mut ring).fault, Some(expected));
        ring.world.change(0, &[Change::SsiTrouble(None)]);
        assert_eq!(next(&mut ring).position(), Some(0x27_0F), "sound again");
    }
}

#[test]
fn pulses_that_are_lost_or_added_shift_the_word() {
    // Every pulse is lost: the encoder sends nothing. Every pulse is doubled: every second bit is missed.
    let mut ring = reading(0x12_3456, 0x18, 500, 25, "");
    trouble(&mut ring, "ssi_lost=1000000");
    assert_eq!(next(&mut ring).fault, Some(SsiFault::StuckHigh));
    trouble(&mut ring, "ssi_added=1000000");
    // Bits 2, 4, 6 and so on of 24, then Low.
    assert_eq!(next(&mut ring).field >> 12, every_second(0x12_3456));
    trouble(&mut ring, "ssi_flips=1000000");
    let flipped = next(&mut ring);
    assert_eq!((flipped.field, flipped.fault), (!0x12_3456 & 0xFF_FFFF, Some(SsiFault::TrailingHigh)));
}

/// Of 24 bits the second, the fourth and so on.
fn every_second(word: u32) -> u32 {
    (0..12).fold(0, |bits, k| bits << 1 | word >> (22 - 2 * k) & 1)
}

// [R109]
#[test]
fn a_long_cable_spoils_the_falling_edge_first() {
    let mut ring = reading(0x12_3457, 0x18, 1_000, 26, "");
    trouble(&mut ring, "ssi_delay=200");
    assert_eq!(next(&mut ring).position(), Some(0x12_3457), "400 ns of 500");
    trouble(&mut ring, "ssi_delay=300");
    let late = next(&mut ring);
    assert_eq!((late.field, late.fault), (0x80_0000 | 0x12_3457 >> 1, Some(SsiFault::TrailingHigh)));
    trouble(&mut ring, "ssi_skew=600");
    assert_eq!(next(&mut ring).field, 0x80_0000 | 0x12_3457 >> 1, "the same 600 ns");
    let settings = SsiSettings::new(1_000_000, 26, Duration::from_millis(2), TakenAt::Rising).unwrap();
    ring.world.change(0, &[Change::Ssi(Some(settings))]);
    assert_eq!(next(&mut ring).position(), Some(0x12_3457), "the rising edge takes it");
}

#[test]
fn a_stopped_reader_reads_nothing_more_and_another_one_goes_on_counting() {
    let mut ring = reading(0, 0x18, 500, 25, "");
    next(&mut ring);
    let count = ring.world.places()[0].ssi().unwrap().count();
    hang(&mut ring, 1_000, 25, 5_000);
    assert_eq!(ring.world.places()[0].ssi().unwrap().count(), count);
    next(&mut ring);
    ring.world.change(0, &[Change::Ssi(None)]);
    assert!(ring.world.places()[0].ssi().is_none());
    ring.cycles(20);
}

#[test]
fn without_supply_the_reader_sees_low() {
    let mut ring = reading(0x27_0F, 0x18, 500, 25, "");
    ring.supply(0, 0);
    assert_eq!(next(&mut ring).fault, Some(SsiFault::StuckLow));
    ring.supply(0, 24_000);
    assert_eq!(next(&mut ring).position(), Some(0x27_0F));
}

// [R107]
#[test]
fn bus_and_ssi_show_the_same_sample() {
    let text = format!(
        "version = 1\n{}",
        device(0, "ce-65-m", "motion = { kind = \"speed\", start = 0, per_s = 400000 }")
    );
    let mut ring = Ring::new(&text);
    // Latched at the end of a refresh: 200 steps on.
    hang(&mut ring, 1_000, 24, 500);
    let mut seen = 0;
    for _ in 0..200 {
        ring.cycle();
        let place = &ring.world.places()[0];
        let (encoder, reader) = (place.node().encoder().unwrap(), place.ssi().unwrap());
        let Some(read) = reader.read() else { continue };
        let latched = read.transfer.began;
        let refreshed = encoder.refreshed_at(latched);
        assert_eq!(read.transfer.position(), Some(place.raw(refreshed) as u32), "{latched:?}");
        seen += 1;
    }
    assert!(seen > 100, "{seen}");
}

/// Whether every row of a recording replays.
fn replays(scenario: &Scenario, drive: impl Fn(&mut Ring)) -> (usize, usize) {
    let mut ring = Ring::of(scenario);
    drive(&mut ring);
    let mut node = Node::new(scenario.devices[0].unit);
    let rows = ring.rows_of(0);
    for row in &rows {
        let got = play(&mut node, row);
        assert_eq!(compare(row, got), None, "{row:?}");
    }
    let edges = rows.iter().filter(|row| row.kind == RowKind::SsiEdge).count();
    (rows.len(), edges)
}

#[test]
fn a_recording_replays_whatever_the_reader_did_between_the_cycles() {
    for every in ["0.05", "0.3", "1.0"] {
        let more = format!(
            "motion = {{ kind = \"speed\", start = 0, per_s = 400000 }}\nssi = {{ khz = 1000, clocks = 25, every_ms = {every} }}"
        );
        let events = [
            set(10.1, 0, "supply_v = 0"),
            set(30.2, 0, "supply_v = 24"),
            set(60.0, 0, "motion = { kind = \"speed\", per_s = -300000 }"),
            set(60.01, 0, "motion = { kind = \"hold\" }"),
        ];
        let text = format!("version = 1\n{}{}", device(0, "ce-65-m", &more), events.concat());
        let (rows, edges) = replays(&scenario(&text), |ring| {
            ring.out[0] = 0xC600_0005;
            ring.cycles(400);
        });
        assert!(rows > 100 && edges >= 1, "{rows} {edges}");
    }
}

// [R107]
#[test]
fn an_encoder_that_the_reader_switched_on_still_ignores_a_service_bit_that_stood() {
    let more = "ssi = { khz = 1000, clocks = 25, every_ms = 0.1 }\nmotion = { kind = \"hold\", raw = 1000 }";
    let mut ring = Ring::new(&format!("version = 1\n{}", device(0, "ce-65-m", more)));
    ring.cycles(10);
    ring.supply(0, 0);
    ring.out[0] = 0xC600_0005;
    ring.cycles(100);
    ring.supply(0, 24_000);
    ring.cycles(200);
    assert_eq!(ring.input[0], 1_000, "no preset");
}

// [R113, R114, R117, R119]
#[test]
fn a_reader_that_is_set_otherwise_than_the_encoder_shows_what_such_a_card_shows() {
    // Programmed values, bits and code of the card, its clocks, what it reads and what is wrong.
    let cards = [
        (0x0_0018, None, None, 25, Ok(9_999)),
        (0x0_0018, Some(24), Some(Code::Binary), 25, Ok(9_999)),
        (0x0_0018, None, Some(Code::Gray), 25, Ok(0x3A0A)),
        (0x0_0118, None, Some(Code::Binary), 25, Ok(0x3488)),
        // One bit too few halves the position, and the bit behind it is High; one too many doubles it.
        (0x0_0018, Some(23), None, 24, Err(SsiFault::TrailingHigh)),
        (0x0_0018, Some(25), None, 26, Ok(19_998)),
        // AK-40 as 31 plain bits, and with the parity as a bit of the position.
        (0x0_001F, Some(31), None, 33, Err(SsiFault::TrailingHigh)),
        (0x0_001F, Some(32), None, 33, Ok(0x4E1F)),
        (0x1_0018, Some(24), None, 51, Err(SsiFault::TrailingHigh)),
    ];
    for (values, bits, code, clocks, expected) in cards {
        let mut ring = reading(9_999, values, 500, clocks, "");
        let settings = ring.world.places()[0].ssi().unwrap().settings();
        let settings = settings.reading_as(SsiCard { bits, code }).unwrap();
        ring.world.change(0, &[Change::Ssi(Some(settings))]);
        let transfer = next(&mut ring);
        let seen = transfer.fault.map_or_else(|| Ok(transfer.position().unwrap()), Err);
        assert_eq!(seen, expected, "{values:05X}h, {bits:?}, {code:?}");
    }
}

#[test]
fn what_a_reader_is_set_to_is_written_behind_its_period_and_in_its_table() {
    let refused = |text: &str| text.parse::<PlacedReader>().unwrap_err();
    let reader: PlacedReader = "2=500,25,10ms, bits=20, code=GRAY".parse().unwrap();
    assert_eq!(reader.to_string(), "2=500,25,10ms,bits=20,code=gray");
    assert_eq!(reader.settings.card(), SsiCard { bits: Some(20), code: Some(Code::Gray) });
    assert_eq!(refused("2=500,25,10ms,bits=33"), "33 bits; a reader takes 8 to 32");
    let unknown = "behind the period may stand bits=24 and code=binary or code=gray";
    for part in ["24", "bits=", "bits=24,bits=24", "code=grey", ""] {
        assert!(refused(&format!("2=500,25,10ms,{part}")).ends_with(unknown), "{part}");
    }
    let scenario = |more: &str| {
        let ssi = format!("ssi = {{ khz = 500, clocks = 25, every_ms = 10, {more} }}");
        Scenario::parse("ring.toml", &format!("version = 1\n{}", device(0, "ce-65-m", &ssi)), Path::new("."))
    };
    let read = scenario("bits = 20, code = \"gray\"").unwrap().devices[0].ssi.unwrap();
    assert_eq!(read, reader.settings);
    let problem = scenario("bits = 7").unwrap_err().to_string();
    assert!(problem.contains("7 bits; a reader takes 8 to 32"), "{problem}");
}

#[test]
fn a_reader_is_written_in_one_piece_and_refused_with_its_limits() {
    let refused = |text: &str| text.parse::<PlacedReader>().unwrap_err();
    let reader: PlacedReader = "2=62.5,33,10ms".parse().unwrap();
    assert_eq!((reader.position, reader.settings.hz(), reader.settings.clocks()), (2, 62_500, 33));
    assert_eq!(reader.to_string(), "2=62.5,33,10ms");
    assert_eq!(refused("500,25,10ms"), "write POSITION=KHZ,CLOCKS,EVERY, as 2=500,25,10ms");
    assert_eq!(refused("2=500,25"), "write POSITION=KHZ,CLOCKS,EVERY, as 2=500,25,10ms");
    assert!(refused("2=0.5,25,10ms").starts_with("a clock of 0.5 kHz; a reader has 1 to 10000 kHz"));
    assert!(refused("2=500,0,10ms").starts_with("0 clocks; a transfer has 1 to 1000"));
    assert!(refused("2=500,25,60us").starts_with("a transfer every 60 us; 25 clocks at 500 kHz"));
    let mut scenario = Scenario::built_in().unwrap();
    let at = |position| PlacedReader { position, ..reader };
    assert_eq!(
        scenario.hang_reader(at(1)).unwrap_err(),
        "position 1 is a ce-100-m, which has no SSI; there is one at position 2"
    );
    assert_eq!(
        scenario.hang_reader(at(3)).unwrap_err(),
        "position 3 is not on the ring; there is one at position 2"
    );
    assert_eq!(scenario.hang_reader(at(2)), Ok(()));
    let fault = "ssi_flips=20:0".parse().unwrap();
    assert_eq!(
        scenario.add(&fault).unwrap_err(),
        "position 0 is a la-66, which has no SSI; there is one at position 2"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_the_encoder_is_programmed_to_its_reader_reads_the_position(
        raw in 0..0x100_0000_i64,
        bits in 24..=32_u32,
        gray in 0..=1_u32,
        repetition in 0..=1_u32,
        more in 0..60_u32,
        khz in 80..=1_000_u32,
    ) {
        let values = repetition << 16 | gray << 8 | bits;
        let field = match (repetition, bits) {
            (1, _) => 24,
            (_, 31) => 32,
            _ => bits,
        };
        let transfer = next(&mut reading(raw, values, khz, field + more, ""));
        prop_assert_eq!((transfer.position(), transfer.fault), (Some(raw as u32), None));
    }

    // [R117]
    #[test]
    fn flips_on_the_line_are_noticed_by_the_parity_if_an_odd_number_of_bits_is_hit(
        raw in 0..0x100_0000_i64,
        seed in 0..u64::MAX / 2,
    ) {
        let hold = format!("motion = {{ kind = \"hold\", raw = {raw} }}");
        let mut ring = Ring::new(&format!("version = 1\nseed = {seed}\n{}", device(0, "ce-65-m", &hold)));
        ring.cycles(3);
        ring.service(0, 0xCD00_001F);
        ring.service(0, 0x8800_0000);
        hang(&mut ring, 500, 33, 2_000);
        trouble(&mut ring, "ssi_flips=20000");
        let right = u32::try_from(raw).unwrap();
        let sent = right << 1 | (right.count_ones() + 1) & 1;
        for _ in 0..10 {
            let transfer = next(&mut ring);
            if (transfer.field ^ sent).count_ones() % 2 == 1 {
                prop_assert_ne!(transfer.fault, None);
            }
        }
    }
}

#[test]
fn a_reader_changes_nothing_on_the_bus() {
    let run = |more: &str| {
        let motion = "motion = { kind = \"sine\", center = 0, amplitude = 100000, period_s = 0.2 }";
        let mut ring =
            Ring::new(&format!("version = 1\n{}", device(0, "ce-65-m", &format!("{motion}\n{more}"))));
        (0..500)
            .map(|k| {
                ring.out[0] = if k % 50 < 25 { 0x8200_0000 } else { 0 };
                ring.cycle();
                ring.input[0]
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(run(""), run("ssi = { khz = 500, clocks = 25, every_ms = 0.7 }"));
}
