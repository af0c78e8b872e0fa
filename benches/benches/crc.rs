//! The check word over the frames of 3 and 128 encoders, beside the `crc` crate with tables of the same size and the
//! next larger one.
#![allow(missing_docs, clippy::expect_used, reason = "a benchmark")]

use crc::{CRC_16_IBM_3740, Crc as Peer, Table};
use divan::{Bencher, black_box};
use encoring_ring::crc::Crc;

/// Loopback word and data of 3 and of 128 encoders.
const BYTES: [usize; 2] = [2 + 4 * 3, 2 + 4 * 128];

fn main() {
    for bytes in BYTES {
        let frame = frame(bytes);
        assert_eq!(ours(&frame), PEER.checksum(&frame), "the same check word, or the times mean nothing");
    }
    divan::main();
}

static PEER: Peer<u16, Table<1>> = Peer::<u16, Table<1>>::new(&CRC_16_IBM_3740);
static LARGE: Peer<u16, Table<16>> = Peer::<u16, Table<16>>::new(&CRC_16_IBM_3740);

fn frame(bytes: usize) -> Vec<u8> {
    (0..bytes).map(|byte| (byte * 151) as u8).collect()
}

fn ours(frame: &[u8]) -> u16 {
    let mut check = Crc::NEW;
    for byte in frame {
        check.push(*byte);
    }
    check.word()
}

#[divan::bench(args = BYTES)]
fn encoring(bencher: Bencher<'_, '_>, bytes: usize) {
    let frame = frame(bytes);
    bencher.bench(|| ours(black_box(&frame)));
}

#[divan::bench(args = BYTES)]
fn crc_table_1(bencher: Bencher<'_, '_>, bytes: usize) {
    let frame = frame(bytes);
    bencher.bench(|| PEER.checksum(black_box(&frame)));
}

#[divan::bench(args = BYTES)]
fn crc_table_16(bencher: Bencher<'_, '_>, bytes: usize) {
    let frame = frame(bytes);
    bencher.bench(|| LARGE.checksum(black_box(&frame)));
}
