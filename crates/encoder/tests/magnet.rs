//! The magnet of the LA-66.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, MS, SECOND, US, la66};
use encoring_encoder::Magnet;

fn at(bench: &mut Bench, start: u64, nanos: u64, magnet: Magnet, raw: i64) -> u32 {
    bench.now = start + nanos;
    bench.terminals.magnet = magnet;
    bench.turn_to(raw);
    bench.exchange_now(0)
}

use Magnet::{Missing, Present};

// [R96]
#[test]
fn without_the_magnet_normal_mode_shows_20h_and_the_last_good_position() {
    let mut bench = la66();
    assert_eq!(bench.position_at(250_000), 25_000);
    bench.terminals.magnet = Missing;
    assert_eq!(bench.position(), 0x2000_0000 | 25_000);
    assert_eq!(bench.position_at(400_000), 0x2000_0000 | 25_000);
}

#[test]
fn the_rod_ends_at_0_and_at_its_length() {
    for (raw, good) in
        [(0, true), (-1, false), (500_000, true), (500_001, false), (i64::MIN, false), (i64::MAX, false)]
    {
        let mut bench = la66();
        assert_eq!(bench.position_at(raw) >> 24, if good { 0x00 } else { 0x20 }, "{raw}");
        let status = if good { 0x8800_0000 } else { 0xA800_0020 };
        assert_eq!(bench.data_check(), status, "{raw}");
    }
}

// [R77]
#[test]
fn the_error_stays_until_a_data_check_with_the_magnet_back() {
    let mut bench = la66();
    bench.position_at(250_000);
    bench.terminals.magnet = Missing;
    bench.position();
    bench.terminals.magnet = Present;
    for _ in 0..10 {
        assert_eq!(bench.position(), 0x2000_0000 | 25_000);
    }
    assert_eq!(bench.service(0x8200_0000), 0xA200_C350);
    assert_eq!(bench.data_check(), 0x8800_0020);
    assert_eq!(bench.position(), 25_000);
    assert_eq!(bench.data_check(), 0x8800_0000);
}

#[test]
fn a_data_check_while_the_magnet_is_away_clears_nothing() {
    let mut bench = la66();
    bench.terminals.magnet = Missing;
    for _ in 0..3 {
        assert_eq!(bench.data_check(), 0xA800_0020);
        assert_eq!(bench.position(), 0x2000_0000);
    }
    bench.terminals.magnet = Present;
    assert_eq!(bench.position(), 0x2000_0000);
    assert_eq!(bench.data_check(), 0x8800_0020, "2^5 was kept");
    assert_eq!(bench.data_check(), 0x8800_0000);
    assert_eq!(bench.position(), 0);
}

#[test]
fn the_magnet_is_judged_in_each_exchange_and_not_only_at_samples() {
    let mut bench = la66();
    bench.position_at(100_000);
    let start = bench.now + MS;
    assert_eq!(at(&mut bench, start, 0, Present, 200_000), 20_000);
    // Between two samples: away and back.
    assert_eq!(at(&mut bench, start, 100 * US, Missing, 200_000), 0x2000_0000 | 20_000);
    assert_eq!(at(&mut bench, start, 200 * US, Present, 200_000), 0x2000_0000 | 20_000);
    assert_eq!(bench.data_check(), 0x8800_0020);
    let start = bench.now + MS;
    assert_eq!(at(&mut bench, start, 0, Present, 200_000), 20_000);
    assert_eq!(at(&mut bench, start, 100 * US, Present, 500_001), 0x2000_0000 | 20_000, "beyond the end too");
}

#[test]
fn when_the_magnet_is_back_the_position_changes_at_the_next_sample() {
    let mut bench = la66();
    bench.power_off();
    bench.power_up();
    let start = bench.now;
    assert_eq!(at(&mut bench, start, 0, Present, 0), 0);
    assert_eq!(at(&mut bench, start, MS, Present, 100_000), 10_000);
    // Away at the sample of 2 ms.
    assert_eq!(at(&mut bench, start, 2 * MS, Missing, 200_000), 0x2000_0000 | 10_000);
    assert_eq!(at(&mut bench, start, 2_500 * US, Present, 300_000), 0x2000_0000 | 10_000);
    assert_eq!(at(&mut bench, start, 3 * MS - 1, Present, 300_000), 0x2000_0000 | 10_000);
    assert_eq!(at(&mut bench, start, 3 * MS, Present, 400_000), 0x2000_0000 | 40_000);
}

#[test]
fn without_a_good_place_since_power_up_x_is_0_whatever_the_direction() {
    for (direction, shown) in [(0, 0), (1, 50_000)] {
        let mut bench = la66();
        bench.service(0xC100_0000 | direction);
        bench.position_at(250_000);
        bench.terminals.magnet = Missing;
        assert_eq!(bench.power_cycle(), 0x2000_0000 | shown);
        assert_eq!(bench.position(), 0x2000_0000 | shown, "nothing is known from before");
        assert_eq!(bench.data_check(), 0xA800_0020);
    }
}

#[test]
fn service_06_acts_on_the_held_place() {
    let mut bench = la66();
    bench.position_at(250_000);
    bench.terminals.magnet = Missing;
    bench.turn_to(400_000);
    assert_eq!(bench.service(0xC600_1234), 0xE600_1234);
    assert_eq!(bench.position(), 0x2000_1234);
    bench.terminals.magnet = Present;
    assert_eq!(bench.position_at(250_000), 0x2000_1234);
    assert_eq!(bench.data_check(), 0x8800_0020);
    assert_eq!(bench.position(), 0x1234);
    assert_eq!(bench.position_at(250_010), 0x1235);
}

#[test]
fn the_preset_input_acts_on_the_held_place() {
    let mut bench = la66();
    bench.service(0xC400_4321);
    bench.position_at(250_000);
    bench.turn_to(-5);
    bench.position();
    bench.terminals.preset_mv = [24_000, 0];
    bench.position();
    bench.advance(SECOND);
    assert_eq!(bench.position(), 0x2000_4321);
    bench.turn_to(250_000);
    assert_eq!(bench.position(), 0x2000_4321);
}

#[test]
fn a_missing_magnet_shows_in_the_replies_of_good_services() {
    let mut bench = la66();
    bench.terminals.magnet = Missing;
    assert_eq!(bench.service(0x8100_0000), 0xA100_0000);
    assert_eq!(bench.service(0xC100_0001), 0xE100_0001);
    assert_eq!(bench.service(0x8100_0000), 0xA100_0001, "and they are done");
}

#[test]
fn a_change_of_the_length_shows_at_the_held_place() {
    let mut bench = la66();
    bench.position_at(250_000);
    bench.terminals.magnet = Missing;
    bench.service(0xC200_0064);
    assert_eq!(bench.position(), 0x2000_0000 | 50);
    bench.service(0xC100_0001);
    assert_eq!(bench.position(), 0x2000_0000 | 50);
}

#[test]
fn a_magnet_that_is_away_only_between_exchanges_is_not_missed() {
    let mut bench = la66();
    bench.position_at(250_000);
    bench.terminals.magnet = Missing;
    bench.terminals.magnet = Present;
    assert_eq!(bench.position(), 25_000);
}
