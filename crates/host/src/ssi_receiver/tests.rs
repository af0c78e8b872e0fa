extern crate std;

use super::*;
use encoring_words::Week;
use encoring_words::parameter::{Code, SsiValues};
use encoring_words::ssi_frame::SsiFrame;
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

const EDGES: [TakenAt; 2] = [TakenAt::Rising, TakenAt::Falling];

/// A train of pulses and the line's answer to it, as an encoder far away gives it.
#[derive(Clone, Copy)]
struct Train {
    frame: SsiFrame,
    clocks: u32,
    low_ns: u64,
    high_ns: u64,
    delay_ns: u64,
}

/// Levels from a time on.
type Change = (u64, Level, Level);

impl Train {
    fn new(position: u32, format: SsiFormat, clocks: u32) -> Self {
        let frame = SsiFrame::new(position, format);
        Self { frame, clocks, low_ns: 500, high_ns: 500, delay_ns: 0 }
    }

    fn period(self, low_ns: u64, high_ns: u64) -> Self {
        Self { low_ns, high_ns, ..self }
    }

    /// Every change, the first falling edge at 100 us; at rest before and after.
    fn changes(self) -> Vec<Change> {
        self.with_mono_period(20_001)
    }

    /// The same where Data+ is High again so long after the last falling edge.
    fn with_mono_period(self, mono_ns: u64) -> Vec<Change> {
        let mut clock = std::vec![(0, Level::High)];
        let mut data = std::vec![(0, Level::High)];
        let (mut at, mut fell, mut pulse) = (100_000, 100_000, 0);
        for _ in 0..self.clocks {
            if at > fell + 20_000 {
                data.push((fell + 20_001 + self.delay_ns, Level::High));
                pulse = 0;
            }
            fell = at;
            clock.push((at, Level::Low));
            at += self.low_ns;
            clock.push((at, Level::High));
            pulse += 1;
            data.push((at + self.delay_ns, self.frame.level(pulse)));
            at += self.high_ns;
        }
        data.push((fell + mono_ns + self.delay_ns, Level::High));
        let mut times: Vec<u64> = clock.iter().chain(&data).map(|(at, _)| *at).collect();
        times.sort_unstable();
        times.dedup();
        let level = |line: &[(u64, Level)], at| line.iter().rev().find(|(from, _)| *from <= at).unwrap().1;
        times.into_iter().map(|at| (at, level(&clock, at), level(&data, at))).collect()
    }
}

fn format(bits: u8, code: Code, repetition: bool) -> SsiFormat {
    SsiFormat::new(SsiValues { repetition, code, bits }, Week::AK40)
}

fn plain(bits: u8) -> SsiFormat {
    format(bits, Code::Binary, false)
}

fn ak40() -> SsiFormat {
    plain(31)
}

fn repeated() -> SsiFormat {
    format(24, Code::Binary, true)
}

/// What a receiver hands out for some changes.
fn received(mut receiver: SsiReceiver, changes: &[Change]) -> Vec<SsiTransfer> {
    let mut transfers: Vec<SsiTransfer> =
        changes.iter().filter_map(|(at, clock, data)| receiver.levels(Instant(*at), *clock, *data)).collect();
    let end = changes.last().map_or(0, |(at, ..)| *at + 1_000_000);
    transfers.extend(receiver.end(Instant(end)));
    transfers
}

/// The one transfer in some changes.
fn one(receiver: SsiReceiver, changes: &[Change]) -> SsiTransfer {
    let transfers = received(receiver, changes);
    let [transfer] = transfers[..] else { panic!("{transfers:?}") };
    transfer
}

fn fault(format: SsiFormat, changes: &[Change]) -> Option<SsiFault> {
    let [rising, falling] = EDGES.map(|edge| one(SsiReceiver::new(format, edge), changes).fault);
    assert_eq!(rising, falling);
    rising
}

/// The changes with Data+ as `data` makes it.
fn with_data(changes: &[Change], data: impl Fn(u64, Level) -> Level) -> Vec<Change> {
    changes.iter().map(|(at, clock, level)| (*at, *clock, data(*at, *level))).collect()
}

// [R109, R117]
#[test]
fn the_ak_40_words_come_with_either_edge() {
    let words = [
        (0, 0x0000_0001),
        (1, 0x0000_0002),
        (2, 0x0000_0004),
        (3, 0x0000_0007),
        (0x27_0F, 0x0000_4E1F),
        (0x12_3456, 0x0024_68AC),
        (0xFF_FFFF, 0x01FF_FFFF),
    ];
    for (position, word) in words {
        for edge in EDGES {
            for clocks in [32, 33, 64, 96] {
                let changes = Train::new(position, ak40(), clocks).changes();
                let transfer = one(SsiReceiver::new(ak40(), edge), &changes);
                assert_eq!((transfer.field, transfer.received, transfer.fault), (word, 32, None));
                assert_eq!((transfer.position(), transfer.clocks), (Some(position), clocks));
            }
        }
    }
}

// [R116]
#[test]
fn leading_and_trailing_zeros_are_no_part_of_the_position() {
    for bits in 14..=32 {
        for clocks in u32::from(bits)..=3 * u32::from(bits) {
            let format = SsiFormat::new(
                SsiValues { repetition: false, code: Code::Gray, bits },
                Week::new(40, 1997).unwrap(),
            );
            let changes = Train::new(0x27_0F, format, clocks).changes();
            let transfer = one(SsiReceiver::new(format, TakenAt::Falling), &changes);
            assert_eq!((transfer.field, transfer.position()), (0x3488, Some(0x27_0F)), "{bits}, {clocks}");
            let text = transfer.bits().to_string();
            assert!(text.len() == usize::from(bits) && text.ends_with("11010010001000"), "{text}");
        }
    }
}

// [R104, R111]
#[test]
fn every_clock_rate_from_50_khz_to_1_1_mhz_is_received_and_others_are_named() {
    for half in [455, 500, 6_250, 9_950, 10_000] {
        let changes = Train::new(0x12_3456, plain(24), 25).period(half, half).changes();
        assert_eq!(fault(plain(24), &changes), None, "{half} ns");
    }
    let fast = Train::new(0x12_3456, plain(24), 25).period(450, 450).changes();
    assert_eq!(fault(plain(24), &fast), Some(SsiFault::ClockLimit));
    // 40 kHz: every pulse is a transfer of its own.
    let slow = Train::new(0x12_3456, plain(24), 25).period(12_500, 12_500).changes();
    let transfers = received(SsiReceiver::new(plain(24), TakenAt::Falling), &slow);
    assert_eq!(transfers.len(), 25);
    assert!(transfers.iter().all(|it| (it.clocks, it.fault) == (1, Some(SsiFault::ClockLimit))));
}

// [R104, R111]
#[test]
fn the_last_bit_is_taken_before_the_mono_period_is_over_however_slow_the_clock() {
    for half in [6_250, 6_700, 7_500, 8_333, 9_250, 9_615] {
        for mono_ns in [20_100, 20_000, 19_900, 19_500] {
            for (format, clocks) in [(plain(24), 24), (plain(24), 27), (ak40(), 32), (repeated(), 50)] {
                let train = Train::new(0x12_3456, format, clocks).period(half, half);
                assert_eq!(
                    fault(format, &train.with_mono_period(mono_ns)),
                    None,
                    "{half} {mono_ns} {clocks}"
                );
                for edge in EDGES {
                    let transfer = one(SsiReceiver::new(format, edge), &train.with_mono_period(mono_ns));
                    assert_eq!(transfer.position(), Some(0x12_3456), "{half} {mono_ns} {clocks}");
                }
            }
        }
    }
}

// [R111]
#[test]
fn a_word_that_broke_is_no_line_that_is_stuck_wherever_its_bits_are_low() {
    // Periods just above t_M, and Data+ Low within the word.
    for half in [10_001, 10_500, 12_500] {
        let changes = Train::new(9_998, plain(24), 25).period(half, half).changes();
        let changes = with_data(&changes, |at, level| if at > 140_000 { Level::Low } else { level });
        for edge in EDGES {
            let transfers = received(SsiReceiver::new(plain(24), edge), &changes);
            let told = transfers.iter().filter(|it| it.fault == Some(SsiFault::ClockLimit)).count();
            assert!(told + 1 >= transfers.len() && told > 20, "{half}: {transfers:?}");
        }
    }
}

// [R111]
#[test]
fn a_clock_a_little_too_slow_breaks_the_transfer_and_is_named() {
    let uneven = Train::new(0x12_3456, plain(24), 25).period(5_000, 15_100).changes();
    let transfers = received(SsiReceiver::new(plain(24), TakenAt::Falling), &uneven);
    let faults: Vec<_> = transfers.iter().map(|it| it.fault).collect();
    assert_eq!(faults.len(), 25);
    // Only from the second on it is seen that the clock goes on.
    assert_eq!(faults[0], Some(SsiFault::Clocks));
    assert!(faults[1..].iter().all(|fault| *fault == Some(SsiFault::ClockLimit)));
}

// [R109]
#[test]
fn with_a_long_cable_the_falling_edge_takes_the_bit_before_and_the_rising_edge_the_right_one() {
    let train = Train { delay_ns: 700, ..Train::new(0x12_3457, plain(24), 26) };
    let at = |edge| one(SsiReceiver::new(plain(24), edge), &train.changes());
    assert_eq!(at(TakenAt::Rising).position(), Some(0x12_3457));
    let falling = at(TakenAt::Falling);
    assert_eq!(
        falling.field,
        0x80_0000 | 0x12_3457 >> 1,
        "the High of rest first, and the last bit is missing"
    );
    assert_eq!(falling.fault, Some(SsiFault::TrailingHigh));
}

// [R145]
#[test]
fn a_line_that_is_stuck_is_named_whichever_format() {
    for format in [plain(24), plain(32), ak40(), repeated()] {
        for position in [0, 1, 0x27_0F, 0xFF_FFFF] {
            let changes = Train::new(position, format, u32::from(format.bits()) + 1).changes();
            let stuck = |to| fault(format, &with_data(&changes, |_, _| to));
            assert_eq!(stuck(Level::Low), Some(SsiFault::StuckLow));
            assert_eq!(stuck(Level::High), Some(SsiFault::StuckHigh));
        }
    }
}

#[test]
fn all_ones_without_a_further_clock_may_be_a_position_and_are_taken_as_one() {
    let changes = Train::new(0xFF_FFFF, plain(24), 24).changes();
    assert_eq!(fault(plain(24), &changes), None);
    let longer = Train::new(0xFF_FFFF, plain(24), 25).changes();
    assert_eq!(fault(plain(24), &longer), None);
}

#[test]
fn too_few_clocks_and_other_ones_than_expected_are_named() {
    for clocks in [0, 1, 12, 23] {
        let changes = Train::new(0x12_3456, plain(24), clocks).changes();
        let transfers = received(SsiReceiver::new(plain(24), TakenAt::Falling), &changes);
        let faults: Vec<_> = transfers.iter().map(|it| (it.clocks, it.position(), it.fault)).collect();
        let expected: &[_] = if clocks == 0 { &[] } else { &[(clocks, None, Some(SsiFault::Clocks))] };
        assert_eq!(faults, expected);
    }
    for clocks in [24, 25, 26] {
        let changes = Train::new(0x12_3456, plain(24), clocks).changes();
        let receiver = SsiReceiver::new(plain(24), TakenAt::Falling).expecting(25);
        let wrong = (clocks != 25).then_some(SsiFault::Clocks);
        assert_eq!(one(receiver, &changes).fault, wrong, "{clocks}");
    }
}

#[test]
fn a_transfer_that_had_begun_or_had_not_ended_is_cut() {
    let changes = Train::new(0x12_3456, plain(24), 25).changes();
    for from in 0..changes.len() {
        for to in from..=changes.len() {
            let mut receiver = SsiReceiver::new(plain(24), TakenAt::Falling);
            let mut transfers: Vec<_> = changes[from..to]
                .iter()
                .filter_map(|(at, clock, data)| receiver.levels(Instant(*at), *clock, *data))
                .collect();
            let end = changes[..to].last().map_or(0, |(at, ..)| *at);
            transfers.extend(receiver.end(Instant(end)));
            for transfer in transfers {
                if transfer.position().is_some() {
                    assert_eq!(transfer.position(), Some(0x12_3456));
                } else {
                    assert_eq!(transfer.fault, Some(SsiFault::Cut), "{from}..{to}");
                }
            }
        }
    }
}

#[test]
fn the_last_bit_counts_as_soon_as_it_would_have_been_taken() {
    let mut receiver = SsiReceiver::new(plain(24), TakenAt::Falling);
    for (at, clock, data) in Train::new(0x12_3457, plain(24), 24).changes() {
        if at < 123_600 {
            receiver.levels(Instant(at), clock, data);
        }
    }
    let mut copy = receiver;
    assert_eq!(copy.end(Instant(124_000)).unwrap().fault, Some(SsiFault::Cut));
    assert_eq!(receiver.end(Instant(124_001)).unwrap().position(), Some(0x12_3457));
}

#[test]
fn the_periods_are_those_between_falling_edges() {
    let changes = Train::new(0, plain(24), 25).period(300, 900).changes();
    let transfer = one(SsiReceiver::new(plain(24), TakenAt::Rising), &changes);
    let period = Duration::from_nanos(1_200);
    assert_eq!((transfer.periods, transfer.began), (Some((period, period)), Instant(100_000)));
    assert_eq!(transfer.ended, Instant(100_000 + 24 * 1_200));
}

#[test]
fn every_fault_has_a_name_of_its_own() {
    let names: Vec<_> = SSI_FAULTS.iter().map(|fault| fault.name()).collect();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), names.len());
    assert!(SSI_FAULTS.is_sorted());
}

/// The changes with the bit that stands for one pulse turned over; 0 is the level of rest.
fn flipped(changes: &[Change], pulse: u64) -> Vec<Change> {
    let (from, to) = match pulse {
        0 => (100_000, 100_500),
        pulse => (99_500 + pulse * 1_000, 100_500 + pulse * 1_000),
    };
    with_data(changes, |at, level| match level {
        Level::High if (from..to).contains(&at) => Level::Low,
        Level::Low if (from..to).contains(&at) => Level::High,
        level => level,
    })
}

// [R117, R119]
#[test]
fn a_single_flip_is_always_noticed_with_parity_and_with_repetition() {
    for (format, clocks) in [(ak40(), 33), (repeated(), 51), (repeated(), 52), (repeated(), 78)] {
        for position in [0, 1, 0x27_0F, 0x55_5555, 0xFF_FFFF] {
            let changes = Train::new(position, format, clocks).changes();
            assert_eq!(fault(format, &changes), None);
            for pulse in 1..=u64::from(clocks) {
                let flipped = flipped(&changes, pulse);
                assert_ne!(fault(format, &flipped), None, "{format:?} {position:X} pulse {pulse}");
            }
        }
    }
}

fn levels() -> impl Strategy<Value = (u64, Level, Level)> {
    let level = || prop_oneof![Just(Level::Low), Just(Level::High)];
    let wait = prop_oneof![8 => 0..2_000_u64, 2 => 0..60_000_u64, 1 => any::<u64>()];
    (wait, level(), level())
}

proptest! {
    #[test]
    fn whatever_was_sent_is_received(
        position in 0..=0xFF_FFFF_u32,
        bits in 24..=32_u8,
        gray: bool,
        repetition: bool,
        more in 0..64_u32,
        halves in (455..9_000_u64, 455..9_000_u64),
        rising: bool,
        delay in 0..300_u64,
    ) {
        let format = format(bits, if gray { Code::Gray } else { Code::Binary }, repetition);
        let edge = if rising { TakenAt::Rising } else { TakenAt::Falling };
        let train = Train { delay_ns: delay, ..Train::new(position, format, u32::from(format.bits()) + more) };
        let changes = train.period(halves.0, halves.1).changes();
        let transfer = one(SsiReceiver::new(format, edge), &changes);
        prop_assert_eq!((transfer.position(), transfer.fault), (Some(position), None));
        prop_assert_eq!(transfer.clocks, train.clocks);
    }

    #[test]
    fn any_levels_at_any_times_are_taken(
        changes in prop::collection::vec(levels(), 0..200),
        bits: u8,
        code: bool,
        repetition: bool,
        rising: bool,
    ) {
        let format = format(bits, if code { Code::Gray } else { Code::Binary }, repetition);
        let mut receiver = SsiReceiver::new(format, if rising { TakenAt::Rising } else { TakenAt::Falling });
        let mut now = 0_u64;
        for (wait, clock, data) in changes {
            now = now.wrapping_add(wait);
            if let Some(transfer) = receiver.levels(Instant(now), clock, data) {
                prop_assert!(transfer.received <= format.bits() && transfer.began <= transfer.ended);
                prop_assert_eq!(transfer.reading().is_some(), transfer.received == format.bits());
            }
        }
        receiver.end(Instant(now));
    }
}
