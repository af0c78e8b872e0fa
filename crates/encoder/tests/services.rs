//! The services by number: which exist, what they answer, and which bits of the OUT word count.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, cases, ce65, ce65_8192, ce100, every_model, la66};
use encoring_words::Model;
use proptest::prelude::*;

/// Makes a new device.
type New = fn() -> Bench;

/// What one OUT word does to a new device: its reply, and the reply of the data check that follows.
type Row = (u32, u32, u32);

/// One service number of a model: (number, reading, writing with this data).
fn unknown(number: u32) -> [Row; 2] {
    let (read, write) = (0x8012_3456 | number << 24, 0xC012_3456 | number << 24);
    // A read returns 0, a write the data as sent.
    [(read, 0xA000_0000 | number << 24, 0x8800_0080), (write, 0xE012_3456 | number << 24, 0x8800_0080)]
}

/// The rows of the numbers that each rotary model knows; the preset values are the CE-100's.
const DIRECTION: [Row; 2] =
    [(0x8112_3456, 0x8100_0000, 0x8800_0000), (0xC100_0001, 0xC100_0001, 0x8800_0000)];
const LENGTH: [Row; 2] = [(0x8212_3456, 0x82FF_FFFF, 0x8800_0000), (0xC200_270F, 0xC200_270F, 0x8800_0000)];
/// 10 turns are too few for the factory length.
const NUMERATOR: [Row; 2] =
    [(0x8312_3456, 0x8300_1000, 0x8800_0000), (0xC300_000A, 0xC300_000A, 0xA800_4000)];
const PRESET_1: [Row; 2] = [(0x8412_3456, 0x8400_0000, 0x8800_0000), (0xC400_4321, 0xC400_4321, 0x8800_0000)];
const PRESET_2: [Row; 2] = [(0x8512_3456, 0x8500_0000, 0x8800_0000), (0xC500_5432, 0xC500_5432, 0x8800_0000)];
const ADJUSTMENT: [Row; 2] =
    [(0x8612_3456, 0xA600_0000, 0x8800_0008), (0xC600_6543, 0xC600_6543, 0x8800_0000)];
const CHECK: [Row; 2] = [(0x8812_3456, 0x8800_0000, 0x8800_0000), (0xC812_3456, 0xE812_3456, 0x8800_0004)];
const DENOMINATOR: [Row; 2] =
    [(0x8912_3456, 0x8900_0001, 0x8800_0000), (0xC900_0002, 0xC900_0002, 0xA800_4000)];
const SSI: [Row; 2] = [(0x8D12_3456, 0x8D00_0018, 0x8800_0000), (0xCD00_0119, 0xCD00_0119, 0x8800_0000)];

fn ce100_rows() -> Vec<Row> {
    [
        unknown(0),
        DIRECTION,
        LENGTH,
        NUMERATOR,
        PRESET_1,
        PRESET_2,
        ADJUSTMENT,
        unknown(7),
        CHECK,
        DENOMINATOR,
        unknown(0xA),
        unknown(0xB),
        unknown(0xC),
        unknown(0xD),
        unknown(0xE),
        unknown(0xF),
    ]
    .concat()
}

fn ce65_rows() -> Vec<Row> {
    let mut rows = ce100_rows();
    for number in [4, 5] {
        rows[2 * number as usize..][..2].copy_from_slice(&unknown(number));
    }
    rows[2 * 0xD..][..2].copy_from_slice(&SSI);
    rows
}

fn ce65_8192_rows() -> Vec<Row> {
    let mut rows = ce65_rows();
    // With 8192 steps a turn, half the turns are enough for the factory length.
    rows[2 * 9 + 1].2 = 0x8800_0000;
    rows
}

fn la66_rows() -> Vec<Row> {
    let mut rows = ce100_rows();
    for number in [3, 5, 9] {
        rows[2 * number as usize..][..2].copy_from_slice(&unknown(number));
    }
    rows[2 * 2].1 = 0x8200_C350;
    // No fault of a service leaves a status bit.
    for row in &mut rows {
        row.2 &= !0x0000_FFDF;
    }
    rows
}

fn check_rows(new: New, rows: &[Row]) {
    assert_eq!(rows.len(), 32);
    for &(out, reply, status) in rows {
        let mut bench = new();
        assert_eq!(bench.service(out), reply, "{} to {out:08X}", bench.model());
        assert_eq!(bench.data_check(), status, "data check of {} after {out:08X}", bench.model());
    }
}

// [R21, R43, R52]
#[test]
fn every_service_of_the_la_66_read_and_written() {
    check_rows(la66, &la66_rows());
}

// [R21, R89, R101]
#[test]
fn every_service_of_the_ce_100_read_and_written() {
    check_rows(ce100, &ce100_rows());
}

// [R21, R89, R102, R113]
#[test]
fn every_service_of_the_ce_65_read_and_written() {
    check_rows(ce65, &ce65_rows());
    check_rows(ce65_8192, &ce65_8192_rows());
}

// [R19]
#[test]
fn bits_28_and_29_of_out_are_ignored() {
    let tables: [(New, Vec<Row>); 3] = [(la66, la66_rows()), (ce100, ce100_rows()), (ce65, ce65_rows())];
    for (new, rows) in tables {
        for (out, reply, status) in rows {
            for extra in [1 << 28, 1 << 29, 3 << 28] {
                let mut bench = new();
                assert_eq!(bench.service(out | extra), reply, "{:08X}", out | extra);
                assert_eq!(bench.service(0x8800_0000 | extra), status, "{:08X}", out | extra);
            }
        }
    }
}

// [R26]
#[test]
fn the_handshake_completes_for_every_code_byte() {
    for mut bench in every_model() {
        for byte in 0x80..=0xFF_u32 {
            let reply = bench.exchange(byte << 24 | 0x10);
            assert_eq!(reply >> 24 & 0xDF, byte & 0xCF, "the acknowledgement names the request");
            let end = bench.exchange(0);
            assert_eq!(end & 0xDF00_0000, 0);
        }
    }
}

// [R20]
#[test]
fn the_reserve_bit_is_never_set_by_the_encoder() {
    for mut bench in every_model() {
        for byte in 0..=0xFF_u32 {
            for _ in 0..2 {
                assert_eq!(bench.exchange(byte << 24 | 0x12_3456) & 1 << 28, 0, "{byte:02X}");
            }
            assert_eq!(bench.exchange(0) & 1 << 28, 0);
        }
    }
}

// [R18]
#[test]
fn bit_30_decides_between_reading_and_writing() {
    for mut bench in every_model() {
        assert_eq!(bench.service(0x8100_0001), 0x8100_0000);
        assert_eq!(bench.service(0x8100_0000), 0x8100_0000, "reading with data writes nothing");
        assert_eq!(bench.service(0xC100_0001), 0xC100_0001);
        assert_eq!(bench.service(0x8100_0000), 0x8100_0001);
    }
}

proptest! {
    #![proptest_config(cases(200))]

    // [R16, R22, R35]
    #[test]
    fn the_data_of_a_read_service_has_no_effect(number in 0_u32..16, data in 0_u32..1 << 24) {
        for mut bench in every_model() {
            let mut other = bench.clone();
            let code = 0x8000_0000 | number << 24;
            prop_assert_eq!(bench.service(code), other.service(code | data));
            prop_assert_eq!(bench.memory.image(), other.memory.image());
            prop_assert_eq!(bench.data_check(), other.data_check());
        }
    }

    // [R25, R37]
    #[test]
    fn a_write_is_echoed_as_it_was_sent_whatever_becomes_of_it(
        number in 0_u32..16,
        data in 0_u32..1 << 24,
    ) {
        for mut bench in every_model() {
            let out = 0xC000_0000 | number << 24 | data;
            prop_assert_eq!(bench.service(out) & !(1 << 29), out);
        }
    }

    #[test]
    fn what_was_written_without_an_error_reads_back(data in 0_u32..1 << 24) {
        for mut bench in every_model() {
            for number in [1, 2, 3, 4, 5, 9] {
                let before = bench.service(0x8000_0000 | number << 24);
                let reply = bench.service(0xC000_0000 | number << 24 | data);
                let after = bench.service(0x8000_0000 | number << 24);
                bench.data_check();
                // A numerator of 0 is stored although it is an error.
                if reply & 1 << 29 == 0 || number == 3 && data == 0 && bench.model() != Model::La66 {
                    let kept = match (number, bench.model()) {
                        (1, Model::Ce65M) => u32::from(data >> 8 & 0xFF != 0) << 8 | u32::from(data & 0xFF != 0),
                        _ => data,
                    };
                    prop_assert_eq!(after & 0xFF_FFFF, kept);
                } else {
                    prop_assert_eq!(after & 0xFF_FFFF, before & 0xFF_FFFF);
                }
            }
        }
    }
}

// [R26]
#[test]
fn a_read_returns_the_value_and_not_the_data_of_the_request() {
    for mut bench in [ce100(), ce65()] {
        assert_eq!(bench.service(0x8212_3456), 0x82FF_FFFF);
        assert_eq!(bench.service(0x8312_3456), 0x8300_1000);
        assert_eq!(bench.service(0x8912_3456), 0x8900_0001);
    }
}

// [R29]
#[test]
fn replies_are_binary_although_the_position_is_gray() {
    let mut bench = ce65();
    bench.program(&[0xC100_0100, 0xC200_270F]);
    assert_eq!(bench.service(0x8200_0000), 0x8200_270F);
    assert_eq!(bench.service(0x8100_0000), 0x8100_0100);
    assert_eq!(bench.service(0xC600_1234), 0xC600_1234, "the preset value is binary too");
    assert_eq!(bench.position(), 0x1B2E, "only the position is Gray");
    assert_eq!(bench.encoder.position(), 0x1234);
    assert_eq!(bench.service(0x8700_0000), 0xA700_0000);
    assert_eq!(bench.position(), 0x2000_1B2E, "the upper byte is never Gray");
    assert_eq!(bench.data_check(), 0x8800_0080, "nor the status");
}

// [R73, R76]
#[test]
fn service_06_sets_the_position_and_cannot_be_read() {
    for mut bench in every_model() {
        bench.turn_to(123_456);
        assert_eq!(bench.exchange(0xC600_1234), 0xC600_1234);
        assert_eq!(bench.exchange(0x4600_1234), 0x1234, "{}", bench.model());
        assert_eq!(bench.service(0x8600_0000), 0xA600_0000);
        assert_eq!(bench.position(), 0x2000_1234, "reading it moves nothing");
    }
}

// [R78]
#[test]
fn writing_service_08_neither_checks_nor_clears_nor_accepts() {
    for mut bench in [ce100(), ce65()] {
        bench.program(&[0xC200_0FFF]);
        bench.turn_to(4096 * 512);
        assert_eq!(bench.position(), 512);
        assert_eq!(bench.service(0x8700_0000), 0xA700_0000);
        assert_eq!(bench.service(0xC200_1FFF), 0xE200_1FFF);
        assert_eq!(bench.service(0xC8AB_CDEF), 0xE8AB_CDEF);
        assert_eq!(bench.position(), 0x2000_0200, "not accepted");
        assert_eq!(bench.data_check(), 0x8800_0084, "neither told nor cleared before");
        assert_eq!(bench.position(), 1024);
    }
}

// [R65, R72]
#[test]
fn a_service_of_another_model_is_an_unknown_command() {
    // 03, 05 and 09 on the LA-66; 04 and 05 on the CE-65; 0D on the LA-66 and the CE-100.
    let absent: [(New, &[u32]); 3] = [(la66, &[3, 5, 9, 0xD]), (ce65, &[4, 5]), (ce100, &[0xD])];
    for (new, numbers) in absent {
        for number in numbers {
            for code in [0x8000_0000, 0xC000_0000] {
                let mut bench = new();
                let image = bench.memory.clone();
                let out = code | number << 24 | 0x18;
                let data = if code == 0xC000_0000 { 0x18 } else { 0 };
                assert_eq!(bench.service(out), code | 1 << 29 | number << 24 | data);
                assert_eq!(bench.memory, image);
                let status = if bench.model() == Model::La66 { 0 } else { 0x80 };
                assert_eq!(bench.data_check(), 0x8800_0000 | status);
            }
        }
    }
}
