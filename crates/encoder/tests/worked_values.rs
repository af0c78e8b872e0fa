//! The worked examples of the manuals and the values that were computed by hand from them.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, MS, ce65, ce65_8192, ce100, la66};
use encoring_encoder::{Unit, ZeroLoss};
use encoring_words::model::Sensor;
use encoring_words::{Model, Week};

/// Scaling, Q = 4096: the writes, then raw -> value.
fn positions(bench: &mut Bench, writes: &[u32], table: &[(i64, u32)]) {
    bench.program(writes);
    for &(raw, value) in table {
        assert_eq!(bench.position_at(raw), value, "raw {raw}");
    }
}

const TEN_TURNS: [u32; 3] = [0xC200_270F, 0xC300_000A, 0xC900_0001];

#[test]
fn ten_turns_of_1000_steps() {
    let table = [(0, 0), (4, 0), (5, 1), (4095, 999), (4096, 1000), (40_959, 9999), (40_960, 0), (-1, 9999)];
    for mut bench in [ce100(), ce65()] {
        positions(&mut bench, &TEN_TURNS, &table);
    }
}

#[test]
fn three_and_a_half_turns_of_4096_steps() {
    let table = [(4096, 4096), (14_335, 14_335), (14_336, 0)];
    for mut bench in [ce100(), ce65()] {
        positions(&mut bench, &[0xC200_37FF, 0xC300_0023, 0xC900_000A], &table);
    }
}

// [R61]
#[test]
fn three_and_a_half_turns_of_1000_steps() {
    let table = [(4096, 1000), (14_335, 3499), (14_336, 0)];
    for mut bench in [ce100(), ce65()] {
        positions(&mut bench, &[0xC200_0DAB, 0xC300_0023, 0xC900_000A], &table);
    }
}

// [R100]
#[test]
fn the_ce_65_has_4096_or_8192_steps_4096_turns_24_bits_and_two_codes() {
    let built = |steps_per_turn| Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn }).is_ok();
    assert_eq!((1..=16_384).filter(|steps| built(*steps)).collect::<Vec<_>>(), [4_096, 8_192]);
    for (mut bench, native, steps_per_value) in [(ce65(), 4_096, 1), (ce65_8192(), 8_192, 2)] {
        // 4096 turns are the whole range, and it fills 24 bits.
        let end = native * 4_096;
        assert_eq!(bench.position_at(end - 1), 0xFF_FFFF);
        assert_eq!(bench.position_at(end), 0);
        let shown = bench.position_at(0x12_3456 * steps_per_value);
        assert_eq!(shown, 0x12_3456, "binary");
        bench.program(&[0xC100_0100]);
        assert_eq!(bench.position(), 0x12_3456 ^ 0x12_3456 >> 1, "Gray");
        assert_eq!(bench.position_at(end - 1), 0x80_0000, "one bit of 24");
    }
}

// [R93, R100]
#[test]
fn more_steps_per_turn_than_the_rating_plate_is_2_to_14() {
    let judged = |mut bench: Bench, s: u32, n: u32, d: u32| {
        for write in [0xC200_0000 | s, 0xC300_0000 | n, 0xC900_0000 | d] {
            assert_eq!(bench.service(write), write);
        }
        bench.data_check()
    };
    for new in [ce100, ce65] {
        assert_eq!(judged(new(), 0xFFF, 1, 1), 0x8800_0000);
        assert_eq!(judged(new(), 0x1000, 1, 1), 0xA800_4000);
        assert_eq!(judged(new(), 0x37FF, 35, 10), 0x8800_0000);
        assert_eq!(judged(new(), 0x3800, 35, 10), 0xA800_4000);
        assert_eq!(judged(new(), 0xFF_FFFF, 0x1000, 1), 0x8800_0000);
        assert_eq!(judged(new(), 0xFF_FFFF, 0xFFF, 1), 0xA800_4000);
    }
    assert_eq!(judged(ce65_8192(), 0xFF_FFFF, 0x800, 1), 0x8800_0000);
    assert_eq!(judged(ce65_8192(), 0xFF_FFFF, 0x7FF, 1), 0xA800_4000);
    assert_eq!(judged(ce65_8192(), 0x1FFF, 1, 1), 0x8800_0000);
    assert_eq!(judged(ce65_8192(), 0x2000, 1, 1), 0xA800_4000);
}

/// The example of CE-100 6 and CE-65 3.3: 1000 steps a turn, 10 turns.
// [R5, R55]
#[test]
fn the_programming_example_of_the_manuals_frame_by_frame() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(0x12_3456);
        bench.service(0xC300_000A);
        bench.service(0xC900_0001);
        // 1, 2: normal mode with data and service number, then the service bit.
        assert_eq!(bench.exchange(0x4200_270F), 0x0012_3456);
        // 3: reply, words C200 and 270F.
        let reply = bench.exchange(0xC200_270F);
        assert_eq!((reply >> 16, reply & 0xFFFF), (0xC200, 0x270F));
        // 4, 5: end of the request, position again.
        assert_eq!(bench.exchange(0x4200_270F), 0x0012_3456);
        assert_eq!(bench.exchange(0x8800_0000), 0x8800_0000);
        assert_eq!(bench.exchange(0x0000_0000), (0x12_3456 % 40_960) * 10_000 / 40_960);
        assert_eq!(bench.service(0x8200_0000), 0x8200_270F);
    }
}

// [R41]
#[test]
fn the_request_of_the_example_may_end_with_4200270f_or_with_0() {
    for end in [0x4200_270F, 0x0000_0000] {
        for mut bench in [ce100(), ce65()] {
            bench.turn_to(0x33_4455);
            assert_eq!(bench.exchange(0xC200_270F), 0xC200_270F);
            assert_eq!(bench.exchange(end), 0x0033_4455);
        }
    }
}

#[test]
fn the_error_sequences_of_the_ce_65() {
    let mut bench = ce65();
    bench.program(&TEN_TURNS);
    let mut says = |table: &[(u32, u32)]| {
        for &(out, reply) in table {
            assert_eq!(bench.service(out), reply, "reply to {out:08X}");
        }
    };
    says(&[(0x8700_0000, 0xA700_0000), (0x8800_0000, 0x8800_0080), (0x8800_0000, 0x8800_0000)]);
    says(&[
        (0xC300_0000, 0xE300_0000),
        (0x8800_0000, 0xA800_2000),
        (0x8800_0000, 0xA800_2000),
        (0xC300_000A, 0xE300_000A),
        (0x8800_0000, 0x8800_0000),
    ]);
    says(&[(0xC800_0000, 0xE800_0000), (0x8800_0000, 0x8800_0004)]);
    says(&[(0x8600_0000, 0xA600_0000), (0x8800_0000, 0x8800_0008)]);
}

#[test]
fn with_the_factory_length_ten_turns_are_too_few() {
    let mut bench = ce65();
    assert_eq!(bench.service(0xC300_0000), 0xE300_0000);
    assert_eq!(bench.data_check(), 0xA800_2000);
    assert_eq!(bench.service(0xC300_000A), 0xE300_000A);
    assert_eq!(bench.data_check(), 0xA800_4000);
}

// [R50]
#[test]
fn a_rod_of_500_mm_reads_c350h_at_its_end() {
    let mut bench = la66();
    assert_eq!(bench.service(0xC200_C350), 0xC200_C350);
    assert_eq!(bench.position_at(500_000), 0xC350);
    assert_eq!(bench.position_at(0), 0);
    assert_eq!(bench.position_at(10), 1);
}

// [R51]
#[test]
fn a_tenth_of_a_millimetre_is_1388h_and_not_1288h() {
    let mut bench = la66();
    assert_eq!(bench.service(0xC200_1388), 0xC200_1388);
    assert_eq!(bench.position_at(500_000), 5000);
    assert_eq!(bench.position_at(100), 1);
    // The misprint of one extraction is 4744 steps.
    assert_eq!(bench.service(0xC200_1288), 0xC200_1288);
    assert_eq!(bench.position_at(500_000), 4744);
}

#[test]
fn gray_positions() {
    let mut bench = ce65();
    bench.program(&[0xC100_0100]);
    assert_eq!(bench.position_at(0x27_0F), 0x34_88 & 0xFF_FFFF);
    assert_eq!(bench.position_at(0x12_34), 0x1B_2E);
    assert_eq!(bench.position_at(0xFF_FFFF), 0x80_0000);
    // The wrap of a whole power of two changes one bit, that of 10000 positions five.
    let full = bench.position_at(0xFF_FFFF) ^ bench.position_at(0x100_0000);
    assert_eq!(full.count_ones(), 1);
    bench.program(&TEN_TURNS);
    let decimal = bench.position_at(40_959) ^ bench.position_at(40_960);
    assert_eq!(decimal.count_ones(), 5);
}

/// Moves by `turns` without supply, with the worst that the manual allows, and gives by how much the position is off.
fn lost_by(bench: &mut Bench, turns: i64, s: u32) -> u32 {
    bench.turn_to(0);
    bench.position();
    bench.position_at(turns * 4096);
    let right = bench.position();
    bench.turn_to(0);
    bench.position();
    let found = bench.power_cycle_moved_to(turns * 4096);
    (right + s + 1 - found) % (s + 1)
}

#[test]
fn one_lost_round_of_4096_turns_shifts_ten_turns_by_6000_steps() {
    let mut bench = ce65().rebuilt(|unit| unit.zero_loss = ZeroLoss::WorstAllowed);
    bench.program(&TEN_TURNS);
    assert_eq!(lost_by(&mut bench, 512, 9999), 0);
    assert_eq!(lost_by(&mut bench, 513, 9999), 6000);
    assert_eq!(lost_by(&mut bench, -513, 9999), 4000, "the other way round");
}

#[test]
fn one_lost_round_of_4096_turns_shifts_three_and_a_half_turns_by_4096_steps() {
    let mut bench = ce100().rebuilt(|unit| unit.zero_loss = ZeroLoss::WorstAllowed);
    bench.program(&[0xC200_37FF, 0xC300_0023, 0xC900_000A]);
    assert_eq!(lost_by(&mut bench, 512, 14_335), 0);
    assert_eq!(lost_by(&mut bench, 600, 14_335), 4096);
}

#[test]
fn a_lost_round_shows_exactly_where_the_ratio_is_not_zero_safe() {
    let safe = [(4096, 1), (2048, 1), (1, 1), (5, 10), (1, 99), (24, 3), (4096, 3)];
    let unsafe_ratios = [(10, 1), (3, 1), (35, 10), (8192, 1), (65_535, 1)];
    let shift = |n: u32, d: u32| {
        let mut bench = ce65().rebuilt(|unit| unit.zero_loss = ZeroLoss::WorstAllowed);
        // The finest legal resolution: a shift of any number of turns would be seen.
        let s = (4096 * n / d - 1).min(0xFF_FFFF);
        bench.program(&[0xC200_0000 | s, 0xC300_0000 | n, 0xC900_0000 | d]);
        lost_by(&mut bench, 1000, s)
    };
    for (n, d) in safe {
        assert_eq!(shift(n, d), 0, "{n}/{d} is safe");
    }
    for (n, d) in unsafe_ratios {
        assert_ne!(shift(n, d), 0, "{n}/{d} is not safe");
    }
}

#[test]
fn ssi_words_of_the_ak_40_format() {
    let table = [
        (0, 0x0000_0001),
        (1, 0x0000_0002),
        (2, 0x0000_0004),
        (3, 0x0000_0007),
        (0x27_0F, 0x0000_4E1F),
        (0x12_3456, 0x0024_68AC),
        (0xFF_FFFF, 0x01FF_FFFF),
    ];
    let mut bench = ce65();
    assert_eq!(bench.unit.firmware, Week::AK40);
    bench.program(&[0xCD00_001F]);
    for (position, word) in table {
        bench.turn_to(position);
        bench.advance(MS);
        assert_eq!(bench.ssi_word(32), word, "position {position}");
    }
}

#[test]
fn ssi_words_of_the_plain_format() {
    let mut bench = ce65();
    bench.turn_to(0x27_0F);
    let mut word = |number: u32, clocks: u32| {
        bench.program(&[0xCD00_0000 | number]);
        bench.ssi_word(clocks)
    };
    assert_eq!(word(24, 24), 0x00_270F);
    assert_eq!(word(25, 25), 0x00_270F);
    assert_eq!(word(14, 14), 0b10_0111_0000_1111);
    assert_eq!(word(32, 32), 0x0000_270F);
    assert_eq!(word(14, 24), 0b10_0111_0000_1111 << 10);
}

#[test]
fn the_gray_cut_of_180h_to_8_bits_is_40h() {
    let mut bench = ce65();
    bench.turn_to(0x180);
    bench.program(&[0xCD00_0108]);
    assert_eq!(bench.ssi_word(8), 0x40);
}
