//! The EEPROM: what is kept, what a lost or older copy does, and what wears.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use common::{Bench, CellFault, Memory, ce65, ce100, every_model, la66};
use encoring_encoder::records::{self, EEPROM_BYTES, Record, write_count};
use encoring_words::{Model, Parameter};

/// How often each record of the model was written.
fn counts(bench: &mut Bench) -> Vec<(Record, u32)> {
    Record::of(bench.model()).map(|record| (record, write_count(&mut bench.memory, record))).collect()
}

/// The cells that `write` changes.
fn cells_of(bench: &Bench, write: impl FnOnce(&mut Bench)) -> Vec<usize> {
    let mut other = bench.clone();
    write(&mut other);
    (0..EEPROM_BYTES).filter(|cell| other.memory.image()[*cell] != bench.memory.image()[*cell]).collect()
}

#[test]
fn a_new_device_has_each_record_written_once() {
    for (mut bench, records) in every_model().into_iter().zip([4, 9, 8, 8]) {
        let counts = counts(&mut bench);
        // One for each programmed value, the offset; rotary: the accepted set and the turn count.
        assert_eq!(counts.len(), records, "{}", bench.model());
        assert!(counts.iter().all(|(_, count)| *count == 1), "{counts:?}");
    }
}

#[test]
fn formatting_a_memory_twice_wears_nothing() {
    for mut bench in every_model() {
        let unit = bench.unit;
        let written = bench.memory.written();
        records::format(&unit, &mut bench.memory).unwrap();
        assert_eq!(bench.memory.written(), written);
    }
}

#[test]
fn equal_values_answer_as_usual_and_do_not_wear_the_cell() {
    for mut bench in every_model() {
        bench.program(&[0xC100_0001, 0xC200_1000]);
        bench.turn_to(100_000);
        bench.service(0xC600_0123);
        let before = counts(&mut bench);
        for _ in 0..3 {
            for out in [0xC100_0001, 0xC200_1000, 0xC600_0123, 0x8800_0000] {
                assert_eq!(bench.service(out), out);
            }
        }
        assert_eq!(counts(&mut bench), before);
        assert_eq!(bench.position(), 0x0123);
    }
}

#[test]
fn equal_after_normalisation_does_not_wear_the_cell_either() {
    let mut bench = ce65();
    bench.program(&[0xC100_0101, 0xCD01_0118]);
    let written = bench.memory.written();
    for out in [0xC1FF_80FF, 0xCDFF_FF18, 0xCD01_0120] {
        assert_eq!(bench.service(out), out, "the echo is the word as sent");
    }
    assert_eq!(bench.data_check(), 0x8800_0000);
    assert_eq!(bench.memory.written(), written);
}

#[test]
fn each_write_is_counted_on_its_own_record() {
    let mut bench = ce100();
    let mut expected = counts(&mut bench);
    for (k, out) in (0..).zip([0xC100_0001, 0xC200_1000, 0xC300_0800, 0xC400_0007, 0xC500_0008, 0xC900_0002])
    {
        assert_eq!(bench.service(out), out);
        expected[k].1 += 1;
        assert_eq!(counts(&mut bench), expected);
    }
    bench.service(0xC600_0123);
    assert_eq!(expected[6].0, Record::Offset);
    expected[6].1 += 1;
    assert_eq!(counts(&mut bench), expected);
    bench.data_check();
    assert_eq!(expected[7].0, Record::Accepted);
    expected[7].1 += 1;
    assert_eq!(counts(&mut bench), expected);
    bench.position_at(5);
    bench.power_cycle();
    expected[8].1 += 1;
    assert_eq!(counts(&mut bench), expected);
}

#[test]
fn refused_values_and_normal_mode_write_nothing() {
    for mut bench in every_model() {
        let written = bench.memory.written();
        for out in [0x8700_0000, 0xC700_0001, 0xC200_0000, 0x8600_0000, 0xC800_0000, 0x8100_0000] {
            bench.service(out);
        }
        for raw in 0..100 {
            bench.position_at(raw);
        }
        assert_eq!(bench.memory.written(), written);
    }
}

#[test]
fn a_power_up_that_takes_nothing_over_writes_nothing() {
    for mut bench in every_model() {
        bench.program(&[0xC200_1000]);
        bench.power_cycle();
        let written = bench.memory.written();
        bench.power_cycle();
        assert_eq!(bench.memory.written(), written);
    }
}

#[test]
fn a_blank_memory_counts_as_lost() {
    for new in every_model() {
        let mut bench = Bench::with_memory(&new.unit, Memory::blank());
        assert_eq!(bench.exchange_now(0), 0x2000_0000, "{}", bench.model());
        assert_eq!(bench.service(0x8200_0000), 0xA200_0000);
        let (status, raw, shown) =
            if bench.model() == Model::La66 { (0, 500_000, 0xC350) } else { (1, 0x12_3456, 0) };
        let mut factory = bench.clone();
        let expected = match bench.model() {
            Model::La66 => shown,
            _ => every_model().into_iter().find(|b| b.unit == bench.unit).unwrap().position_at(raw),
        };
        assert_eq!(factory.position_at(raw), 0x2000_0000 | expected, "the factory values work");
        assert_eq!(bench.data_check(), 0x8800_0000 | status);
    }
}

#[test]
fn a_lost_record_is_2_to_0_until_it_is_written_again() {
    for mut bench in [ce100(), ce65()] {
        let cells = cells_of(&bench, |bench| {
            bench.service(0xC200_1234);
        });
        bench.program(&[0xC200_0FFF]);
        // Both slots of the measuring length are spoilt: a third write would go to the first again.
        let mut both = cells_of(&bench, |bench| {
            bench.service(0xC200_4321);
        });
        both.extend(cells);
        bench.power_off();
        for cell in both {
            bench.memory.image_mut()[cell] ^= 0x40;
        }
        assert_eq!(write_count(&mut bench.memory, Record::Programmed(Parameter::MeasuringLength)), 0);
        bench.turn_to(4096 * 9);
        bench.power_up();
        assert_eq!(bench.exchange_now(0), 0x2000_0009, "the accepted set stays active");
        assert_eq!(bench.service(0x8200_0000), 0xA200_0000);
        assert_eq!(bench.data_check(), 0x8800_0001, "the factory length is valid and is accepted");
        assert_eq!(bench.position(), 4096 * 9);
        assert_eq!(bench.power_cycle(), 0x2000_9000, "still lost");
        assert_eq!(bench.data_check(), 0x8800_0001);
        bench.program(&[0xC200_0FFF]);
        assert_eq!(bench.power_cycle(), 9);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

/// Writes something and gives a cell of the copy that this wrote.
fn newest_cell(bench: &mut Bench, write: impl FnOnce(&mut Bench)) -> usize {
    let before = bench.memory.clone();
    write(bench);
    (0..EEPROM_BYTES).find(|cell| before.image()[*cell] != bench.memory.image()[*cell]).unwrap()
}

/// Off, a cell spoilt, and on.
fn spoil(bench: &mut Bench, cell: usize) {
    bench.power_off();
    bench.memory.image_mut()[cell] ^= 0xFF;
    bench.power_up();
}

#[test]
fn an_older_copy_takes_over() {
    for mut bench in every_model() {
        bench.program(&[0xC200_0111]);
        let cell = newest_cell(&mut bench, |bench| {
            bench.service(0xC200_0222);
        });
        spoil(&mut bench, cell);
        assert_eq!(bench.exchange_now(0), 0);
        assert_eq!(bench.service(0x8200_0000), 0x8200_0111, "{}", bench.model());
        assert_eq!(bench.data_check(), 0x8800_0000);
        bench.program(&[0xC200_0333]);
        assert_eq!(bench.power_cycle(), 0);
        assert_eq!(bench.service(0x8200_0000), 0x8200_0333);
    }
}

#[test]
fn an_older_offset_takes_over() {
    for mut bench in every_model() {
        bench.turn_to(100_000);
        bench.service(0xC600_0111);
        let cell = newest_cell(&mut bench, |bench| {
            bench.service(0xC600_0222);
        });
        spoil(&mut bench, cell);
        assert_eq!(bench.exchange_now(0), 0x0111);
        assert_eq!(bench.data_check(), 0x8800_0000);
    }
}

#[test]
fn an_older_accepted_set_takes_over() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(4096 * 6);
        bench.program(&[0xC200_0FFF]);
        bench.service(0xC200_1FFF);
        let cell = newest_cell(&mut bench, |bench| {
            bench.data_check();
        });
        // What would be taken over at power-up must not hide the older copy.
        bench.service(0xC300_0000);
        spoil(&mut bench, cell);
        assert_eq!(bench.exchange_now(0), 0x2000_0006);
        assert_eq!(bench.data_check(), 0xA800_2000);
    }
}

#[test]
fn working_copies_are_not_reloaded_while_the_device_is_on() {
    let mut bench = ce65();
    bench.turn_to(4096 * 6);
    bench.program(&[0xC200_0FFF]);
    let cell = newest_cell(&mut bench, |bench| {
        bench.service(0xC200_1FFF);
    });
    assert_eq!(bench.data_check(), 0x8800_0000);
    bench.memory.image_mut()[cell] ^= 0xFF;
    assert_eq!(bench.service(0x8200_0000), 0x8200_0FFF, "the read service reads the record");
    assert_eq!(bench.position(), 12, "the position does not change");
    assert_eq!(bench.data_check(), 0x8800_0000);
    assert_eq!(bench.position(), 12, "nor with a data check");
}

#[test]
fn a_lost_accepted_set_gives_way_to_valid_programmed_values() {
    for mut bench in [ce100(), ce65()] {
        bench.turn_to(4096 * 6);
        bench.program(&[0xC200_0FFF]);
        let accepted = accepted_cells(&bench);
        bench.power_off();
        for cell in &accepted {
            bench.memory.image_mut()[*cell] ^= 0x21;
        }
        bench.power_up();
        assert_eq!(bench.exchange_now(0), 0x2000_0006, "2^0 and the programmed values");
        assert_eq!(bench.data_check(), 0x8800_0001);
        assert_eq!(bench.power_cycle(), 6, "it has been written again");

        // Programmed values that are not valid give way to the factory's.
        bench.service(0xC300_0000);
        bench.power_off();
        for cell in accepted {
            bench.memory.image_mut()[cell] ^= 0x42;
        }
        bench.power_up();
        assert_eq!(bench.exchange_now(0), 0x2000_6000);
        assert_eq!(bench.data_check(), 0xA800_2001);
    }
}

/// Cells of both copies of the accepted set: those that two accepted changes touch and the writes before them do not.
fn accepted_cells(bench: &Bench) -> Vec<usize> {
    let mut bench = bench.clone();
    let mut cells = Vec::new();
    for out in [0xC200_1FFF, 0xC200_2FFF] {
        bench.service(out);
        cells.extend(cells_of(&bench, |bench| {
            bench.data_check();
        }));
        bench.data_check();
    }
    cells
}

#[test]
fn a_memory_that_fails_altogether_never_stops_the_device() {
    for fault in [CellFault::Read, CellFault::Write, CellFault::Stuck(0), CellFault::Stuck(0xA5)] {
        for mut bench in every_model() {
            bench.position_at(100_000);
            let position = bench.position();
            bench.memory.break_all(fault);
            for byte in 0x80..=0xFF_u32 {
                bench.service(byte << 24 | 0x20);
            }
            assert_eq!(bench.position() & 0xFF_FFFF, position, "{} {fault:?}", bench.model());
            bench.power_cycle();
            bench.data_check();
        }
    }
}

#[test]
fn a_record_at_another_place_is_none() {
    let mut bench = ce100();
    bench.program(&[0xC400_0111, 0xC500_0222]);
    let places = |out: u32| {
        cells_of(&bench, |bench| {
            bench.service(out);
        })
    };
    let (one, two) = (places(0xC400_0333)[0], places(0xC500_0333)[0]);
    let image = bench.memory.image().to_vec();
    for (byte, k) in image.iter().skip(one).zip(0..12) {
        bench.memory.image_mut()[two + k] = *byte;
    }
    assert_eq!(bench.service(0x8500_0000), 0x8500_0222);
}

#[test]
fn the_la_66_keeps_no_turn_count_and_no_accepted_set() {
    let mut bench = la66();
    bench.position_at(250_000);
    let written = bench.memory.written();
    bench.power_cycle();
    bench.data_check();
    assert_eq!(bench.memory.written(), written);
}
