//! The ring engine passes telegrams on without delay and in one piece. Beside it, chips that are clocked bit by bit
//! with their delay: on every line the same bits in the same order, and the same words taken. Only at the moment at
//! which a switch is thrown a few bits of a pause differ.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::ident::{ENCODER, Ident};
use encoring_ring::profile::{BIT_500K, DEVICE_DELAY_BITS};
use encoring_ring::slave::Strobe;
use encoring_ring::telegram::{Bits, CycleKind, Part, data_telegram, statuses};
use encoring_ring::{BitRing, Slave, Sound};
use encoring_words::Instant;
use proptest::prelude::*;

/// Bits of pieces, in order.
fn line(pieces: &[Bits]) -> Vec<bool> {
    pieces.iter().flat_map(|piece| (0..piece.count).rev().map(|k| piece.bits >> k & 1 != 0)).collect()
}

fn piece() -> impl Strategy<Value = Bits> {
    let telegram = (any::<u8>(), any::<bool>(), 0..5_u8).prop_map(|(byte, id, part)| {
        let cycle = if id { CycleKind::Id } else { CycleKind::Data };
        let part = [Part::Data, Part::Data, Part::Data, Part::CheckHigh, Part::EndLow][usize::from(part)];
        Bits::telegram(data_telegram(cycle, part, byte))
    });
    let noise =
        (any::<u64>(), 1..=64_u32).prop_map(|(bits, count)| Bits { bits: bits >> (64 - count), count });
    prop_oneof![
        8 => telegram,
        3 => (1..=12_u32).prop_map(statuses),
        1 => (1..=64_u32).prop_map(Bits::idle),
        1 => noise,
    ]
}

/// A sound frame of a ring behind which `bytes` bytes were sent, with one chance in three of a flipped bit.
fn frame() -> impl Strategy<Value = Vec<Bits>> {
    (prop::collection::vec(any::<u8>(), 0..9), any::<bool>(), prop::option::of((0..150_usize, 0..3_u8)))
        .prop_map(|(bytes, id, flip)| {
            let cycle = if id { CycleKind::Id } else { CycleKind::Data };
            let mut crc = encoring_ring::crc::Crc::NEW;
            let mut pieces = vec![statuses(3)];
            for byte in bytes {
                crc.push(byte);
                pieces.push(Bits::telegram(data_telegram(cycle, Part::Data, byte)));
            }
            let check = crc.word().to_be_bytes();
            for (part, byte) in [
                (Part::CheckHigh, check[0]),
                (Part::CheckLow, check[1]),
                (Part::EndHigh, 0),
                (Part::EndLow, 0),
            ] {
                pieces.push(Bits::telegram(data_telegram(cycle, part, byte)));
            }
            pieces.push(statuses(2));
            if let Some((at, 0)) = flip {
                let length = pieces.len();
                pieces[at % length].bits ^= 1 << (at % 5);
            }
            pieces
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn many_bits_at_once_are_the_same_as_one_after_the_other(
        frames in prop::collection::vec(prop_oneof![frame(), prop::collection::vec(piece(), 1..20)], 1..12),
        code in 0..10_u8,
        input: [u8; 8],
    ) {
        let pieces: Vec<Bits> = frames.concat();
        let mut at_once = Slave::new(Ident::new(0x33, code), BIT_500K);
        let mut clocked = at_once.clone();
        at_once.load(&input);
        clocked.load(&input);
        let sent: Vec<Bits> = pieces.iter().map(|piece| at_once.regenerate(*piece)).collect();
        let mut bits: Vec<bool> = line(&pieces).iter().map(|bit| clocked.clock(*bit).0).collect();
        let mut drained = clocked.clone();
        bits.extend((0..DEVICE_DELAY_BITS).map(|_| drained.clock(true).0));
        prop_assert_eq!(&line(&sent)[..], &bits[DEVICE_DELAY_BITS as usize..]);
        prop_assert_eq!(at_once.latched(), clocked.latched());
        prop_assert_eq!(at_once.identification(), clocked.identification());
        prop_assert_eq!(at_once.outgoing(), clocked.outgoing());
        prop_assert_eq!(at_once.taken(), clocked.taken());
        prop_assert_eq!(at_once.ages(), clocked.ages());
        for bits in 0..100 {
            prop_assert_eq!(at_once.taken_before(bits), clocked.taken_before(bits));
        }
        prop_assert_eq!(at_once.lamps(), clocked.lamps());
    }
}

#[test]
fn chips_with_their_delay_carry_the_same_bits_and_take_the_same_words() {
    let idents = [ENCODER, Ident::new(0x01, 0x01), Ident::new(0x03, 0x00), Ident::new(0x32, 0x0B), ENCODER];
    let slaves = idents.map(|ident| Slave::new(ident, BIT_500K));
    let mut ring = BitRing::new(slaves, BIT_500K);
    // What entered every segment, from the first silence on: 26 ms are 13 000 bits.
    let mut lines = vec![Vec::new(); idents.len() + 1];
    let mut tap = |segment: usize, _: u64, bits: Bits| {
        lines[segment].extend(line(&[bits]));
        bits
    };
    ring.bring_up(&mut tap, 1_000).unwrap();
    let opened = ring.sent() as usize;
    for cycle in 1..=20_u64 {
        for position in 0..idents.len() {
            let bytes = [cycle as u8, position as u8, 0xE3, 0xA5];
            for (place, byte) in ring.master_mut().out_mut(position).iter_mut().zip(bytes) {
                *place = byte;
            }
            ring.slaves_mut()[position].load(&[!(cycle as u8), position as u8, 0x5A, 0xFF]);
        }
        ring.run(Instant(opened as u64 * 2_000 + cycle * 2_000_000), &mut tap);
    }
    // The same line into clocked chips, each after the one before and its delay.
    let mut clocked = idents.map(|ident| Slave::new(ident, BIT_500K));
    let mut cycles = [0_u64; 5];
    let delay = DEVICE_DELAY_BITS as usize;
    let length = lines[0].len();
    let mut wires = vec![vec![true; 0]; idents.len() + 1];
    for at in 0..length + delay * idents.len() {
        let mut bit = lines[0].get(at).copied().unwrap_or(true);
        let mut home = None;
        for (position, slave) in clocked.iter_mut().enumerate() {
            wires[position].push(bit);
            // Before the first cycle is loaded everybody shows zeros.
            let cycle = cycles[position] + 1;
            if at > 13_000 && cycle <= 20 {
                slave.load(&[!(cycle as u8), position as u8, 0x5A, 0xFF]);
            }
            let (tx, strobe) = slave.clock(bit);
            cycles[position] += u64::from(strobe == Strobe::Load);
            bit = tx;
            if slave.outgoing() == encoring_ring::frame::Outgoing::Off {
                home.get_or_insert(tx);
                bit = true;
            }
        }
        wires[idents.len()].push(home.unwrap_or(bit));
    }
    assert_eq!(cycles, [20; 5]);
    for (segment, wire) in wires.iter().enumerate() {
        // Where a switch is thrown the engine sends the whole piece, and a chip the rest of it; then they agree.
        let (from, to) = (opened + delay * segment, length + delay * segment);
        assert_eq!(&wire[from..to], &lines[segment][opened..], "segment {segment}");
    }
    for (position, slave) in clocked.iter().enumerate() {
        assert_eq!(slave.latched(), ring.slaves()[position].latched());
        assert_eq!(slave.latched(), &[20, position as u8, 0xE3, 0xA5][..slave.latched().len()]);
    }
}

#[test]
fn a_ring_of_mixed_devices_moves_every_byte_to_its_place() {
    let idents: Vec<Ident> =
        [0x01, 0x02, 0x00, 0x0B, 0x09, 0x14, 0x17].map(|code| Ident::new(3, code)).into();
    let slaves: Vec<Slave> = idents.iter().map(|ident| Slave::new(*ident, BIT_500K)).collect();
    let mut ring = BitRing::new(slaves, BIT_500K);
    ring.bring_up(&mut Sound, 1_000).unwrap();
    for round in 0..4_usize {
        for position in 0..idents.len() {
            let length = ring.slaves()[position].bytes();
            let input: Vec<u8> = (0..length).map(|k| (k * 7 + position * 31 + round) as u8).collect();
            ring.slaves_mut()[position].load(&input);
            for (k, place) in ring.master_mut().out_mut(position).iter_mut().enumerate() {
                *place = (k * 3 + position * 17 + round) as u8;
            }
        }
        ring.run(Instant(0), &mut Sound);
        for position in 0..idents.len() {
            let length = ring.slaves()[position].bytes();
            let out: Vec<u8> = (0..length).map(|k| (k * 3 + position * 17 + round) as u8).collect();
            let input: Vec<u8> = (0..length).map(|k| (k * 7 + position * 31 + round) as u8).collect();
            assert_eq!(ring.slaves()[position].latched(), out, "position {position}");
            assert_eq!(ring.master().input(position), input, "position {position}");
        }
    }
}
