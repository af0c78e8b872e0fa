//! What a receiver notices of a disturbed transfer, counted.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

use std::fs;
use std::path::Path;

use encoring_host::ssi_receiver::{SsiReceiver, SsiTransfer, TakenAt};
use encoring_words::parameter::{Code, SsiValues};
use encoring_words::ssi_frame::{Level, SsiFormat, SsiFrame};
use encoring_words::{Instant, Week};

/// Positions that are always among those tried.
const OUTERMOST: [u32; 5] = [0, 1, 0x27_0F, 0x55_5555, 0xFF_FFFF];

const EDGES: [TakenAt; 2] = [TakenAt::Falling, TakenAt::Rising];

fn format(bits: u8, repetition: bool) -> SsiFormat {
    SsiFormat::new(SsiValues { repetition, code: Code::Binary, bits }, Week::AK40)
}

/// Positions of a fixed sequence, and the outermost ones.
fn positions(count: usize) -> Vec<u32> {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as u32
    };
    OUTERMOST.into_iter().chain(std::iter::repeat_with(&mut next)).take(count).collect()
}

/// A transfer at 500 kHz whose data have that level from each pulse's rising edge on.
fn received(format: SsiFormat, taken_at: TakenAt, clocks: u32, level: impl Fn(u32) -> Level) -> SsiTransfer {
    let mut receiver = SsiReceiver::new(format, taken_at);
    receiver.levels(Instant(0), Level::High, Level::High);
    let mut at = 100_000;
    for pulse in 1..=clocks {
        receiver.levels(Instant(at), Level::Low, if pulse == 1 { Level::High } else { level(pulse - 1) });
        receiver.levels(Instant(at + 1_000), Level::High, level(pulse));
        at += 2_000;
    }
    receiver.levels(Instant(at - 2_000 + 20_001), Level::High, Level::High).unwrap()
}

const fn turned(level: Level) -> Level {
    match level {
        Level::High => Level::Low,
        Level::Low => Level::High,
    }
}

/// How many disturbances were noticed, and how many changed a position unnoticed.
#[derive(Clone, Copy, Default)]
struct Count {
    noticed: u64,
    missed: u64,
}

impl Count {
    fn add(&mut self, transfer: &SsiTransfer, position: u32) {
        match transfer.position() {
            None => self.noticed += 1,
            Some(other) if other != position => self.missed += 1,
            // It hit nothing that says otherwise.
            Some(_) => {}
        }
    }

    /// In tenths of a percent, rounded down: only what was always noticed is 100 %.
    fn share(self) -> String {
        let tenths = 1_000 * self.noticed / (self.noticed + self.missed);
        format!("{}.{} %", tenths / 10, tenths % 10)
    }
}

/// One bit turned over, two, a pulse that the encoder did not see, and one too many.
fn disturbed(format: SsiFormat, clocks: u32) -> [Count; 4] {
    let mut counts = [Count::default(); 4];
    let [one, two, lost, added] = &mut counts;
    for position in positions(25).into_iter().skip(OUTERMOST.len()) {
        let frame = SsiFrame::new(position, format);
        let count = |count: &mut Count, level: &dyn Fn(u32) -> Level| {
            count.add(&received(format, TakenAt::Falling, clocks, level), position);
        };
        for hit in 1..=clocks {
            let flip =
                |pulse: u32| if pulse == hit { turned(frame.level(pulse)) } else { frame.level(pulse) };
            count(one, &flip);
            count(lost, &|pulse| frame.level(if pulse < hit { pulse } else { pulse - 1 }));
            count(added, &|pulse| frame.level(if pulse < hit { pulse } else { pulse + 1 }));
            for second in hit + 1..=clocks {
                count(two, &|pulse| if pulse == second { turned(flip(pulse)) } else { flip(pulse) });
            }
        }
    }
    counts
}

// [R117, R119]
#[test]
fn every_single_flip_is_noticed_with_parity_and_with_repetition_at_either_edge() {
    let repeated = [51, 52, 53, 77, 78].map(|clocks| (format(24, true), clocks, 30));
    for (format, clocks, count) in [(format(31, false), 33, 300)].into_iter().chain(repeated) {
        for position in positions(count) {
            let frame = SsiFrame::new(position, format);
            for edge in EDGES {
                assert_eq!(
                    received(format, edge, clocks, |pulse| frame.level(pulse)).position(),
                    Some(position)
                );
                for hit in 1..=clocks {
                    let flip =
                        |pulse| if pulse == hit { turned(frame.level(pulse)) } else { frame.level(pulse) };
                    let transfer = received(format, edge, clocks, flip);
                    assert!(transfer.fault.is_some(), "{position:X}, {clocks} clocks, pulse {hit}, {edge:?}");
                }
            }
        }
    }
}

#[test]
fn the_page_tells_what_is_noticed_of_disturbances() {
    let rows = [
        ("24 bits", format(24, false), 24),
        ("24 bits", format(24, false), 25),
        ("24 bits", format(24, false), 48),
        ("32 bits", format(32, false), 33),
        ("AK-40", format(31, false), 32),
        ("AK-40", format(31, false), 33),
        ("repetition", format(24, true), 51),
        ("repetition", format(24, true), 78),
    ];
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/ssi.md");
    let page = fs::read_to_string(page).unwrap();
    let mut missing = Vec::new();
    for (name, format, clocks) in rows {
        let [one, two, lost, added] = disturbed(format, clocks).map(Count::share);
        let row = format!("| {name} | {clocks} | {one} | {two} | {lost} | {added} |");
        println!("{row}");
        if !page.contains(&row) {
            missing.push(row);
        }
    }
    assert!(missing.is_empty(), "docs/ssi.md does not have\n{}", missing.join("\n"));
}
