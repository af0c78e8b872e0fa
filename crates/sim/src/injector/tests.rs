use super::*;
use crate::fault::PER_MILLION;

/// 4000 bits of a line, in pieces of every length.
fn pieces() -> Vec<(u64, Bits)> {
    let mut chance = Pcg64Mcg::seed_from_u64(7);
    let mut at = 1_000;
    let mut pieces = Vec::new();
    while at < 5_000 {
        let count = chance.random_range(1..=64_u32);
        pieces.push((at, Bits { bits: chance.random::<u64>() >> (64 - count), count }));
        at += u64::from(count);
    }
    pieces
}

fn bits(pieces: &[(u64, Bits)]) -> Vec<bool> {
    pieces.iter().flat_map(|(_, piece)| (0..piece.count).rev().map(|k| piece.bits >> k & 1 != 0)).collect()
}

fn through(fault: Fault, from: u64, to: u64, seed: u64, segment: usize) -> (Vec<bool>, Vec<bool>) {
    let mut segments = Segments::new(3, seed);
    segments.get_mut(segment).unwrap().set(fault, from, to);
    let before = pieces();
    let after: Vec<(u64, Bits)> =
        before.iter().map(|(at, piece)| (*at, segments.pass(segment, *at, *piece))).collect();
    (bits(&before), bits(&after))
}

fn with(per_million: u32) -> [Fault; 4] {
    [
        Fault::Flips(per_million),
        Fault::Bursts(per_million),
        Fault::Jitter(per_million),
        Fault::Lost(per_million),
    ]
}

#[test]
fn a_chance_of_0_changes_nothing_on_any_segment() {
    for segment in 0..4 {
        for fault in with(0) {
            let (before, after) = through(fault, 0, u64::MAX, 1, segment);
            assert_eq!(before, after, "{fault:?}");
        }
    }
}

#[test]
fn a_chance_of_1_changes_every_bit_on_every_segment() {
    for segment in 0..4 {
        let [flips, bursts, jitter, lost] =
            with(PER_MILLION).map(|fault| through(fault, 0, u64::MAX, 1, segment));
        assert!(flips.0.iter().zip(&flips.1).all(|(before, after)| before != after));
        // One burst after the other, and the first bit of each turns over for sure.
        let turned: Vec<bool> =
            bursts.0.iter().zip(&bursts.1).map(|(before, after)| before != after).collect();
        assert!(turned.iter().step_by(16).all(|turned| *turned));
        let others = turned.iter().enumerate().filter(|(k, turned)| k % 16 != 0 && **turned).count();
        assert!((1_700..2_100).contains(&others), "half of the others: {others}");
        let (before, after) = jitter;
        assert_eq!(after[1..], before[..before.len() - 1], "every bit is the one before");
        assert!(lost.1.iter().all(|bit| *bit));
    }
}

#[test]
fn a_line_that_stands_does_not_move() {
    for segment in 0..4 {
        let stands = |fault, level| {
            let (before, after) = through(fault, 0, u64::MAX, 1, segment);
            assert!(after.iter().all(|bit| *bit == level));
            assert_eq!(after.len(), before.len());
        };
        stands(Fault::Low, false);
        stands(Fault::High, true);
        stands(Fault::Silent, true);
    }
}

#[test]
fn a_fault_keeps_to_its_time_to_the_bit_and_to_its_segment() {
    let (before, after) = through(Fault::Flips(PER_MILLION), 1_500, 1_777, 1, 2);
    let changed: Vec<u64> = (1_000..)
        .zip(before.iter().zip(&after))
        .filter_map(|(at, (before, after))| (before != after).then_some(at))
        .collect();
    assert_eq!(changed, (1_500..1_777).collect::<Vec<u64>>());
    let mut segments = Segments::new(3, 1);
    segments.get_mut(2).unwrap().set(Fault::Low, 0, u64::MAX);
    for segment in [0, 1, 3] {
        assert_eq!(segments.pass(segment, 1_600, Bits::idle(64)), Bits::idle(64));
    }
}

#[test]
fn a_single_flip_hits_its_bit_and_no_other() {
    let before = pieces();
    for at in [1_000, 1_001, 1_063, 3_210, 4_999] {
        let mut injector = Injector::new(0);
        injector.flip(at);
        let after: Vec<_> =
            before.iter().map(|(begins, piece)| (*begins, injector.pass(*begins, *piece))).collect();
        let changed: Vec<usize> =
            (0..bits(&before).len()).filter(|k| bits(&before)[*k] != bits(&after)[*k]).collect();
        assert_eq!(changed, [(at - 1_000) as usize]);
    }
}

#[test]
fn a_chance_between_hits_about_as_often_as_it_says_and_the_same_seed_the_same_bits() {
    for fault in with(100_000) {
        let (before, after) = through(fault, 0, u64::MAX, 5, 1);
        let changed = before.iter().zip(&after).filter(|(before, after)| before != after).count();
        // Of some 4000 bits; half of the bits that jitter repeats or a gap covers were the same anyway.
        let expected = match fault {
            Fault::Lost(_) => 800..1_700,
            Fault::Jitter(_) => 130..280,
            // 8 or 9 of the 16 bits of each burst.
            Fault::Bursts(_) => 1_100..1_600,
            _ => 320..490,
        };
        assert!(expected.contains(&changed), "{fault:?}: {changed}");
        assert_eq!(through(fault, 0, u64::MAX, 5, 1).1, after);
        assert_ne!(through(fault, 0, u64::MAX, 6, 1).1, after, "another seed");
        assert_ne!(through(fault, 0, u64::MAX, 5, 2).1, after, "another segment");
    }
}

#[test]
fn a_burst_is_as_long_as_it_says() {
    let fault = Fault::Bursts(2_000);
    let (before, after) = through(fault, 0, u64::MAX, 3, 0);
    let hits: Vec<usize> = (0..before.len()).filter(|k| before[*k] != after[*k]).collect();
    assert!(!hits.is_empty());
    let mut begins = hits[0];
    let mut bursts = 1;
    for hit in hits {
        if hit - begins >= 16 {
            begins = hit;
            bursts += 1;
        }
    }
    assert!((3..20).contains(&bursts), "{bursts} in 4000 bits");
}

/// Every kind of a line, the chances with so many of a million.
fn of_a_line(per_million: u32) -> Vec<Fault> {
    let lines = Fault::kinds().filter(|(fault, ..)| fault.is_of_line());
    lines.map(|(_, form, _)| form.replace("=N", &format!("={per_million}")).parse().unwrap()).collect()
}

#[test]
fn however_a_line_is_cut_the_same_bits_are_hit() {
    for fault in of_a_line(30_000) {
        let mut single = Injector::new(4);
        single.set(fault, 1_234, 4_567);
        let before = pieces();
        let one_by_one: Vec<bool> = (1_000..)
            .zip(bits(&before))
            .map(|(at, bit)| single.pass(at, Bits { bits: u64::from(bit), count: 1 }).bits != 0)
            .collect();
        let mut pieces = Injector::new(4);
        pieces.set(fault, 1_234, 4_567);
        let after: Vec<_> = before.iter().map(|(at, piece)| (*at, pieces.pass(*at, *piece))).collect();
        assert_eq!(bits(&after), one_by_one, "{fault}");
    }
}

#[test]
fn what_is_quiet_need_not_pass() {
    // 40 telegrams a slot, each with a stop bit, so that slots end with a 1.
    let slot =
        |at: u64| (0..40).map(move |k| (at + 13 * k, Bits { bits: ((at + k) % 4_096) << 1 | 1, count: 13 }));
    for fault in of_a_line(300) {
        let (mut every, mut loud) = (Injector::new(9), Injector::new(9));
        let mut left_out = 0;
        for began in (0..400).map(|slot| 520 * slot) {
            if began == 520 * 7 {
                // From the middle of a slot to the middle of another; it begins in the past.
                for injector in [&mut every, &mut loud] {
                    injector.set(fault, 520 * 6 + 100, 520 * 390 + 17);
                }
            }
            if began == 520 * 395 {
                every.flip(began + 3);
                loud.flip(began + 3);
            }
            let is_quiet = loud.is_quiet(began, began + 520);
            left_out += u32::from(is_quiet);
            for (at, piece) in slot(began) {
                let passed = every.pass(at, piece);
                let expected = if is_quiet { piece } else { loud.pass(at, piece) };
                assert_eq!(passed, expected, "{fault} at {at}");
            }
        }
        let expected = match fault {
            Fault::Bad => 399..=399,
            Fault::Low | Fault::High | Fault::Silent => 15..=15,
            _ => 280..=380,
        };
        assert!(expected.contains(&left_out), "{fault}: {left_out}");
    }
}
