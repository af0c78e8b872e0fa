//! The SSI output of the CE-65-M, clock edge by clock edge.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::ssi::number;
use common::{Bench, MS, US, cases, ce65, ce65_8192, ce100, la66};
use encoring_words::ssi_frame::Level::{self, High, Low};
use encoring_words::{Instant, Week};
use proptest::prelude::*;

/// The longest pause between two falling edges within a transfer.
const MONO: u64 = 20 * US;

/// A CE-65-M at this place with these SSI values accepted.
fn bench_with(raw: i64, ssi: u32) -> Bench {
    let mut bench = ce65();
    bench.turn_to(raw);
    bench.program(&[0xCD00_0000 | ssi]);
    bench
}

// [R106]
#[test]
fn at_rest_data_is_high() {
    let mut bench = bench_with(0, 0x18);
    assert_eq!(bench.encoder.ssi_level(Instant(bench.now)), (High, None));
    bench.ssi_transfer(30, US);
    bench.advance(MONO);
    assert_eq!(bench.encoder.ssi_level(Instant(bench.now)), (High, None), "and again after the transfer");
    bench.power_cycle();
    assert_eq!(bench.data(), High);
}

// [R107]
#[test]
fn the_first_falling_edge_latches_and_later_movement_does_not_change_the_word() {
    let mut bench = bench_with(0x12_3456, 0x18);
    bench.fall();
    // A moving shaft, new samples, bus cycles with a data check, another number of bits: none of it counts.
    bench.turn_to(0x65_4321);
    let mut word = 0;
    for pulse in 0..24 {
        bench.advance(4 * US);
        word = word << 1 | u32::from(bench.rise() == High);
        bench.now += 3 * US;
        let out = [0xCD00_0008, 0, 0x8800_0000, 0, 0xC600_0001, 0][pulse % 6];
        bench.exchange_now(out);
        bench.advance(3 * US);
        bench.fall();
    }
    assert_eq!(word, 0x12_3456);
    assert_eq!(bench.encoder.active().ssi_values().bits, 8, "the values did change meanwhile");
    bench.advance(MS);
    bench.rise();
    let position = u64::from(bench.position());
    assert_eq!(bench.ssi_word(8), position & 0xFF, "and count from the next transfer on");
}

// [R107]
#[test]
fn the_most_significant_bit_comes_first_with_the_first_rising_edge() {
    for bit in 0..24 {
        let mut bench = bench_with(1 << bit, 0x18);
        let bits = bench.ssi_transfer(24, US);
        for (k, level) in bits.iter().enumerate() {
            assert_eq!(*level, if k == 23 - bit { High } else { Low }, "bit {bit}");
        }
    }
}

// [R108]
#[test]
fn data_changes_on_rising_edges_only_and_when_the_mono_period_ends() {
    let mut bench = bench_with(0xA5_5A33, 0x18);
    assert_eq!(bench.fall(), High, "High until the first rising edge");
    for k in 0..30 {
        let before = bench.data();
        bench.advance(900);
        assert_eq!(bench.data(), before, "not between edges");
        let level = bench.rise();
        let expected = if k < 24 { Level::from_bit(0xA5_5A33 >> (23 - k)) } else { Low };
        assert_eq!(level, expected);
        bench.advance(900);
        assert_eq!(bench.data(), level);
        assert_eq!(bench.fall(), level, "not on a falling edge");
        assert_eq!(bench.data(), level);
    }
    bench.advance(MONO);
    assert_eq!(bench.data(), Low);
    bench.advance(1);
    assert_eq!(bench.data(), High);
}

#[test]
fn the_encoder_tells_when_data_will_change_without_an_edge() {
    let mut bench = bench_with(0, 0x18);
    bench.fall();
    assert_eq!(bench.encoder.ssi_level(Instant(bench.now)), (High, None));
    let fell = bench.now;
    bench.advance(US);
    bench.rise();
    assert_eq!(bench.encoder.ssi_level(Instant(bench.now)), (Low, Some(Instant(fell + MONO + 1))));
    bench.advance(US);
    bench.fall();
    assert_eq!(bench.encoder.ssi_level(Instant(bench.now)), (Low, Some(Instant(bench.now + MONO + 1))));
}

// [R111]
#[test]
fn a_gap_of_20_us_with_the_clock_high_is_within_a_transfer_and_one_nanosecond_more_is_not() {
    for (gap, rest) in [(MONO, 0x12_3456 & 0x7F_FFFF), (MONO + 1, 0x65_4321 >> 1)] {
        let mut bench = bench_with(0x12_3456, 0x18);
        // A refresh lies in the gap.
        bench.now = bench.now / MS * MS + MS - 5 * US;
        let fell = bench.now;
        bench.fall();
        bench.advance(US);
        assert_eq!(bench.rise(), Low, "bit 23");
        bench.turn_to(0x65_4321);
        bench.now = fell + gap;
        assert_eq!(number(&bench.ssi_transfer(23, US)), rest, "{gap} ns");
    }
}

#[test]
fn a_gap_of_20_us_with_the_clock_low_is_within_a_transfer_and_one_nanosecond_more_is_not() {
    for (gap, edge, rest) in [(MONO, Low, 0x12_3456 & 0x1F_FFFF), (MONO + 1, High, 0x12_3456 >> 3)] {
        let mut bench = bench_with(0x12_3456, 0x18);
        assert_eq!(number(&bench.ssi_transfer(2, US)), 0);
        bench.fall();
        bench.advance(gap - 1);
        assert_eq!(bench.data(), Low);
        bench.advance(1);
        assert_eq!(bench.data(), edge, "High as soon as the transfer has ended");
        assert_eq!(bench.rise(), edge, "bit 21, or an edge that is ignored");
        assert_eq!(number(&bench.ssi_transfer(21, US)), rest, "{gap} ns");
    }
}

#[test]
fn a_first_edge_that_rises_is_ignored() {
    let mut bench = bench_with(0x12_3456, 0x18);
    assert_eq!(bench.rise(), High);
    bench.advance(US);
    assert_eq!(bench.ssi_word(24), 0x12_3456);
}

#[test]
fn the_same_clock_level_told_twice_is_no_edge() {
    let mut bench = bench_with(0x12_3456, 0x18);
    let mut word = 0;
    for _ in 0..24 {
        bench.fall();
        bench.fall();
        bench.advance(US);
        bench.rise();
        word = word << 1 | u32::from(bench.rise() == High);
        bench.advance(US);
    }
    assert_eq!(word, 0x12_3456);
}

// [R116]
#[test]
fn the_number_of_bits_places_the_position_in_the_pulses() {
    let position = 0x27_0F_u32;
    for bits in [8, 9, 14, 16, 23, 24, 25, 26, 30, 32] {
        let mut bench = bench_with(position.into(), bits);
        // Leading zeros above the position, the upper bits cut where there is no room, Low after the last bit.
        let field = u64::from(position) & ((1 << bits) - 1);
        for clocks in [bits, bits + 1, 34, 50] {
            let expected = field << (clocks - bits);
            assert_eq!(bench.ssi_word(clocks), expected, "{bits} bits, {clocks} clocks");
        }
        let short = bits - 3;
        assert_eq!(bench.ssi_word(short), field >> 3, "{bits} bits, {short} clocks");
    }
}

// [R117]
#[test]
fn thirty_one_bits_are_the_ak_40_format_in_binary_with_odd_parity() {
    for ssi in [0x1F, 0x011F] {
        let mut bench = bench_with(0x27_0F, ssi);
        assert_eq!(bench.ssi_word(32), 0x0000_4E1F, "the code byte has no effect");
        assert_eq!(bench.ssi_word(31), 0x0000_270F);
        assert_eq!(bench.ssi_word(40), 0x4E1F << 8, "Low from pulse 33 on");
        assert_eq!(bench.service(0x8D00_0000), 0x8D00_0000 | ssi, "returned as written");
    }
}

// [R117]
#[test]
fn firmware_of_week_40_of_1997_sends_31_plain_bits() {
    let old = |ssi: u32| {
        let mut bench = ce65().rebuilt(|unit| unit.firmware = Week::new(40, 1997).unwrap());
        bench.turn_to(0x27_0F);
        bench.program(&[0xCD00_0000 | ssi]);
        bench
    };
    assert_eq!(old(0x1F).ssi_word(31), 0x27_0F);
    assert_eq!(old(0x1F).ssi_word(32), 0x27_0F << 1, "no parity");
    assert_eq!(old(0x011F).ssi_word(31), 0x34_88, "in the programmed code");
    let newer = ce65().rebuilt(|unit| unit.firmware = Week::new(1, 1998).unwrap());
    let mut newer = newer;
    newer.turn_to(0x27_0F);
    newer.program(&[0xCD00_001F]);
    assert_eq!(newer.ssi_word(32), 0x4E1F);
}

// [R119]
#[test]
fn repetition_sends_the_latched_word_every_26_pulses() {
    for number_of_bits in [0x08, 0x18, 0x1F, 0x20] {
        let mut bench = bench_with(0xAB_CDEF, 0x01_0000 | number_of_bits);
        let mut bits = Vec::new();
        for _ in 0..3 {
            bits.push(number(&bench.ssi_transfer(26, US)));
            bench.turn_to(0x12_3456);
        }
        assert_eq!(bits, [0xAB_CDEF << 2; 3], "24 data bits and two Low, three times");
        bench.advance(MS);
        assert_eq!(bench.ssi_word(26), 0x12_3456 << 2);
    }
}

#[test]
fn repetition_in_gray() {
    let mut bench = bench_with(0x27_0F, 0x01_0118);
    assert_eq!(bench.ssi_word(52), 0x3488 << 28 | 0x3488 << 2);
}

#[test]
fn gray_is_made_of_the_whole_value_before_the_cut() {
    let mut bench = bench_with(0x180, 0x0108);
    assert_eq!(bench.ssi_word(8), 0x40);
    let mut bench = bench_with(0x27_0F, 0x0118);
    assert_eq!(bench.ssi_word(24), 0x3488);
}

// [R109]
#[test]
fn a_receiver_on_rising_edges_sees_the_bit_before() {
    let mut bench = bench_with(0x12_3456, 0x18);
    let (mut rising, mut falling) = (Vec::new(), Vec::new());
    for k in 0..25 {
        if k > 0 {
            falling.push(bench.data());
        }
        bench.fall();
        bench.advance(US);
        rising.push(bench.data());
        bench.rise();
        bench.advance(US);
    }
    assert_eq!(number(&falling), 0x12_3456);
    assert_eq!(rising[0], High, "the pause");
    assert_eq!(number(&rising[1..]), 0x12_3456);
}

// [R104]
#[test]
fn the_word_comes_at_every_clock_rate_from_50_khz_to_1_1_mhz() {
    // Half periods: 1.1 MHz, 1 MHz, 80 kHz, 50 kHz, and periods of 19.9 us.
    for half in [455, 500, 6_250, 10_000, 9_950] {
        let mut bench = bench_with(0x12_3456, 0x18);
        let start = bench.now;
        assert_eq!(number(&bench.ssi_transfer(24, half)), 0x12_3456, "{half} ns");
        assert_eq!(bench.now - start, 48 * half);
        bench.advance(100 * US);
        assert_eq!(number(&bench.ssi_transfer(26, half)), 0x12_3456 << 2);
    }
}

// [R111]
#[test]
fn a_clock_of_less_than_50_khz_restarts_the_word_at_every_pulse() {
    for half in [10_001, 10_050] {
        let mut bench = bench_with(0x92_3456, 0x18);
        let bits = bench.ssi_transfer(24, half);
        assert_eq!(number(&bits), 0xFF_FFFF, "always the first bit, which is 1");
    }
}

// [R110]
#[test]
fn after_the_last_bit_data_is_low_until_the_mono_period_has_passed() {
    let mut bench = bench_with(0x00_0001, 0x18);
    let bits = bench.ssi_transfer(24, US);
    assert_eq!(bits[23], High, "the last bit stays with exactly n clocks");
    bench.advance(10 * US);
    assert_eq!(bench.data(), High);
    // From the clock after the last bit on, whatever stood in it.
    for clocks in [25, 26, 40] {
        bench.advance(100 * US);
        let bits = bench.ssi_transfer(clocks, US);
        assert!(bits[24..].iter().all(|level| *level == Low), "{clocks} clocks");
        assert_eq!(bench.data(), Low);
        // The last falling edge was 2 us ago.
        bench.advance(MONO - 2 * US);
        assert_eq!(bench.data(), Low);
        bench.advance(1);
        assert_eq!(bench.data(), High);
    }
}

#[test]
fn a_clock_that_never_stops_finds_data_low() {
    let mut bench = bench_with(0xFF_FFFF, 0x18);
    bench.ssi_transfer(24, US);
    assert!(bench.ssi_transfer(100_000, US).iter().all(|level| *level == Low));
}

// [R48, R105]
#[test]
fn bus_code_and_ssi_code_are_independent() {
    for (bus, ssi) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut bench = bench_with(0x27_0F, ssi << 8 | 0x18);
        bench.program(&[0xC100_0000 | bus << 8]);
        assert_eq!(bench.position(), if bus == 1 { 0x3488 } else { 0x270F });
        assert_eq!(bench.ssi_word(24), if ssi == 1 { 0x3488 } else { 0x270F });
    }
}

// [R113]
#[test]
fn only_accepted_ssi_values_count() {
    let mut bench = ce65();
    bench.turn_to(0x27_0F);
    bench.exchange(0);
    assert_eq!(bench.service(0xCD00_010E), 0xCD00_010E);
    assert_eq!(bench.ssi_word(24), 0x27_0F);
    assert_eq!(bench.data_check(), 0x8800_0000);
    assert_eq!(bench.ssi_word(14), 0x3488);
    assert_eq!(bench.service(0xCD00_0020), 0xCD00_0020);
    bench.power_cycle();
    assert_eq!(bench.ssi_word(32), 0x27_0F, "or from the next power-up on");
}

#[test]
fn an_error_is_not_seen_on_the_ssi() {
    let mut bench = bench_with(0x27_0F, 0x20);
    bench.service(0x8700_0000);
    assert_eq!(bench.position(), 0x2000_270F);
    assert_eq!(bench.ssi_word(32), 0x27_0F);
}

#[test]
fn scaling_and_preset_are_those_of_the_bus() {
    for mut bench in [ce65(), ce65_8192()] {
        bench.program(&[0xC200_270F, 0xC300_000A]);
        bench.turn_to(123_456);
        bench.service(0xC600_04D2);
        assert_eq!(bench.ssi_word(24), 1234);
        bench.turn_to(-987_654);
        assert_eq!(u64::from(bench.position()), bench.ssi_word(24));
    }
}

// [R11]
#[test]
fn only_the_ce_65_has_an_ssi_output_beside_the_bus() {
    for mut bench in [ce65(), ce65_8192()] {
        let position = bench.position_at(0x12_3456);
        assert_eq!(bench.data(), High);
        assert_eq!(bench.ssi_word(24), u64::from(position));
        assert!(position > 0x01_0000, "more than zeros: {position:X}");
    }
    for mut bench in [la66(), ce100()] {
        bench.turn_to(0x12_3456);
        assert_eq!(bench.data(), Low);
        assert_eq!(bench.ssi_word(32), 0);
        assert_eq!(bench.encoder.ssi_level(Instant(bench.now)), (Low, None));
    }
}

proptest! {
    #![proptest_config(cases(200))]

    // [R120]
    #[test]
    fn neighbouring_positions_differ_in_one_bit_of_gray(raw in 0..0xFF_FFFF_i64) {
        let mut bench = bench_with(raw, 0x0118);
        let word = bench.ssi_word(24);
        bench.turn_to(raw + 1);
        bench.advance(MS);
        prop_assert_eq!((word ^ bench.ssi_word(24)).count_ones(), 1);
    }

    #[test]
    fn every_ak_40_word_has_odd_parity_and_a_stuck_line_even(position in 0..=0xFF_FFFF_i64) {
        let mut bench = bench_with(position, 0x1F);
        let word = bench.ssi_word(32);
        prop_assert_eq!(word.count_ones() % 2, 1);
        prop_assert_eq!(i64::try_from(word >> 1).unwrap(), position);
        prop_assert_eq!(u32::MIN.count_ones() % 2, 0);
        prop_assert_eq!(u32::MAX.count_ones() % 2, 0);
    }
}
