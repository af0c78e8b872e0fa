//! Rows a second of `replay` beside the bare `csv` reader on the same bytes.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use std::io::Write;

use divan::{Bencher, counter::ItemsCount};
use encoring_encoder::{ServiceTimes, Unit};
use encoring_sim::Node;
use encoring_sim::replay::{compare, play};
use encoring_trace::Reader;
use encoring_words::Model;
use encoring_words::model::Sensor;

fn main() {
    divan::main();
}

const TRACE: &[u8] = include_bytes!("../../vectors/ce-65-m.csv");
const ROWS: u64 = 4_000;

/// How often the table holds the words of the trace: so often that finding out its columns takes no part in the time.
const TIMES: u64 = 10;

/// The words of the trace as a table of another program.
fn table() -> Vec<u8> {
    let mut table = b"Time [us],OUT,IN\n".to_vec();
    let rows: Vec<_> = Reader::new("ce-65-m.csv", TRACE).unwrap().map(Result::unwrap).collect();
    let span_us = rows.last().map_or(0, |row| row.time_ns / 1_000 + 1);
    for (time, row) in (0..TIMES).flat_map(|time| rows.iter().map(move |row| (time, row))) {
        let (out, input) = (row.out.unwrap(), row.input.unwrap());
        writeln!(table, "{},{out:08X},{input}", time * span_us + row.time_ns / 1_000).unwrap();
    }
    table
}

#[divan::bench]
fn bare_csv_reader_of_a_table(bencher: Bencher) {
    let table = table();
    bencher.counter(ItemsCount::new(TIMES * ROWS)).bench(|| assert_eq!(bare(&table), TIMES * ROWS));
}

#[divan::bench]
fn foreign_reader_of_a_table(bencher: Bencher) {
    let table = table();
    bencher.counter(ItemsCount::new(TIMES * ROWS)).bench(|| {
        let reader = Reader::new("table.csv", table.as_slice()).unwrap();
        assert!(reader.assumed().is_some(), "our own header has a way of its own");
        assert_eq!(reader.map(Result::unwrap).count() as u64, TIMES * ROWS);
    });
}

fn bare(bytes: &[u8]) -> u64 {
    let mut reader = csv::Reader::from_reader(bytes);
    let mut record = csv::ByteRecord::new();
    let mut rows = 0_u64;
    while reader.read_byte_record(&mut record).unwrap() {
        rows += 1;
    }
    rows
}

#[divan::bench]
fn bare_csv_reader(bencher: Bencher) {
    bencher.counter(ItemsCount::new(ROWS)).bench(|| assert_eq!(bare(TRACE), ROWS));
}

#[divan::bench]
fn trace_reader(bencher: Bencher) {
    bencher.counter(ItemsCount::new(ROWS)).bench(|| {
        assert_eq!(Reader::new("ce-65-m.csv", TRACE).unwrap().map(Result::unwrap).count() as u64, ROWS);
    });
}

#[divan::bench]
fn replay(bencher: Bencher) {
    let mut unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }).unwrap();
    unit.service_times = ServiceTimes::ZERO;
    bencher.counter(ItemsCount::new(ROWS)).bench(|| {
        let mut node = Node::new(unit);
        let rows = Reader::new("ce-65-m.csv", TRACE).unwrap().map(Result::unwrap);
        let differences = rows.filter_map(|row| compare(&row, play(&mut node, &row))).count();
        assert_eq!(differences, 0);
    });
}
