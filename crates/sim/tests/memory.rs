//! EEPROM faults set by events, seen from the master's side of the ring.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{DATA_CHECK, ERROR_BIT, Ring, SERVICE_BIT, set, three};
use encoring_sim::memory::CellFault;
use encoring_trace::Input;

const NEW: u32 = 0xC200_270F;
const READ: u32 = 0x8200_0000;
const OLD_VALUE: u32 = 0x00FF_FFFF;

/// One of each; `events` happen to the CE-100 at position 1.
fn ring(events: &[String]) -> Ring {
    Ring::new(&format!("{}{}", three([1_000, 2_000, 3_000]), events.concat()))
}

#[test]
fn a_memory_that_cannot_be_read_is_told_by_the_read_service_and_the_data_check() {
    let mut ring =
        ring(&[set(20.0, 1, "eeprom = { fault = \"read\" }"), set(60.0, 1, "eeprom = { fault = \"none\" }")]);
    ring.run_to_ms(21.0);
    assert_eq!(ring.service(1, READ), READ | ERROR_BIT);
    assert_eq!(ring.position(1), ERROR_BIT | 2_000, "it goes on with its working copy");
    assert_eq!(ring.service(2, READ), READ | OLD_VALUE, "the memory of the next is sound");
    ring.run_to_ms(61.0);
    assert_eq!(ring.service(1, DATA_CHECK), DATA_CHECK | 1);
    assert_eq!(ring.service(1, READ), READ | OLD_VALUE);
}

#[test]
fn a_memory_that_cannot_be_written_keeps_the_old_value_and_says_so() {
    let mut ring = ring(&[
        set(20.0, 1, "eeprom = { fault = \"write\" }"),
        set(60.0, 1, "eeprom = { fault = \"none\" }"),
    ]);
    ring.run_to_ms(21.0);
    assert_eq!(ring.service(1, NEW), NEW | ERROR_BIT);
    assert_eq!(ring.service(1, READ), READ | ERROR_BIT | OLD_VALUE);
    ring.run_to_ms(61.0);
    assert_eq!(ring.service(1, DATA_CHECK), DATA_CHECK | 2);
    assert_eq!(ring.service(1, NEW), NEW);
    assert_eq!(ring.service(1, READ), READ | 0x270F);
}

#[test]
fn a_stuck_cell_never_gives_a_value_that_nobody_wrote() {
    let mut hit = 0;
    for cell in (0..64).chain(100..110) {
        for stuck in [0x00, 0x5A, 0xFF] {
            let fault =
                set(20.0, 1, &format!("eeprom = {{ fault = \"stuck\", cell = {cell}, value = {stuck} }}"));
            let off = [set(80.0, 1, "supply_v = 0.0"), set(90.0, 1, "supply_v = 24.0")].concat();
            let mut ring = ring(&[fault, off]);
            ring.run_to_ms(21.0);
            let stored = ring.service(1, NEW) == NEW;
            let read = ring.service(1, READ);
            let value = read & OLD_VALUE;
            if stored {
                assert_eq!(read, READ | 0x270F, "cell {cell} stuck at {stuck:02X}");
            } else {
                hit += 1;
                assert_eq!(read & ERROR_BIT, ERROR_BIT);
                assert!([0, OLD_VALUE].contains(&value), "cell {cell} stuck at {stuck:02X}: {read:08X}");
                assert_eq!(ring.service(1, DATA_CHECK) & 2, 2, "cell {cell} stuck at {stuck:02X}");
            }
            ring.run_to_ms(150.0);
            let read = ring.service(1, READ);
            // What it says without an error is what was acknowledged without one.
            if read & ERROR_BIT == 0 {
                let acknowledged = if stored { 0x270F } else { OLD_VALUE };
                assert_eq!(read & OLD_VALUE, acknowledged, "cell {cell} stuck at {stuck:02X}");
            }
        }
    }
    assert!(hit > 5, "only {hit} faults hit the record");
}

#[test]
fn a_power_cut_at_any_byte_of_a_write_leaves_the_old_or_the_new_value() {
    let (mut old, mut new, mut uncut) = (0, 0, 0);
    for bytes in 1..=40 {
        let mut ring = ring(&[
            set(20.0, 1, &format!("eeprom = {{ fault = \"cut\", after_bytes = {bytes} }}")),
            set(80.0, 1, "supply_v = 24.0"),
        ]);
        ring.run_to_ms(21.0);
        ring.out[1] = NEW;
        ring.run_to_ms(60.0);
        let cut = !ring.is_on(1);
        if cut {
            let rows = ring.rows_of(1);
            assert_eq!(rows[rows.len() - 1].input, Some(Input::Off), "cut after {bytes} bytes");
            assert_eq!(rows.iter().filter(|row| row.input == Some(Input::Off)).count(), 1);
            assert_eq!(ring.input[1], 2_000, "no reply of a service that was not finished");
            assert_ne!(ring.last, encoring_ring::Verdict::Good, "the ring is open there");
        } else {
            uncut += 1;
            assert_eq!(ring.input[1], NEW);
        }
        ring.run_to_ms(100.0);
        assert!(ring.is_on(1));
        ring.out[1] = 0;
        ring.cycles(3);
        assert_eq!(ring.input[1] & SERVICE_BIT, 0);
        match ring.service(1, READ) {
            read if read == READ | 0x270F => new += 1,
            read if read == READ | OLD_VALUE => old += 1,
            read => panic!("cut after {bytes} bytes: {read:08X}"),
        }
    }
    assert!(old >= 5, "{old} cuts left the old value");
    assert!(uncut >= 5 && new > uncut, "{new} new values, {uncut} without a cut");
}

#[test]
fn a_cut_that_no_write_reached_does_not_strike_after_a_repair() {
    let mut ring = ring(&[
        set(20.0, 1, "eeprom = { fault = \"cut\", after_bytes = 1 }"),
        set(30.0, 1, "eeprom = { fault = \"none\" }"),
    ]);
    ring.run_to_ms(31.0);
    assert_eq!(ring.service(1, NEW), NEW);
    assert_eq!(ring.service(1, READ), READ | 0x270F);
}

#[test]
fn a_record_that_was_damaged_while_the_encoder_was_off_is_told_at_power_up() {
    let mut ring = ring(&[]);
    ring.cycles(3);
    ring.supply(1, 0);
    ring.cycles(1);
    ring.memory_fault(1, CellFault::Stuck(0), None);
    ring.supply(1, 24_000);
    ring.run_to_ms(60.0);
    assert_eq!(ring.input[1] & ERROR_BIT, ERROR_BIT);
    assert_eq!(ring.service(1, DATA_CHECK) & (ERROR_BIT | 1), ERROR_BIT | 1, "it cannot accept either");
}
