//! What `SsiGuess` finds, over captures of all kinds of motion and format.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use encoring_host::ssi_guess::{SsiGuess, SsiWord};
use encoring_words::Week;
use encoring_words::parameter::{Code, SsiValues};
use encoring_words::ssi_frame::{SsiCheck, SsiFormat, SsiFrame};

/// A fixed sequence of numbers for each seed.
struct Chance(u64);

impl Chance {
    fn next(&mut self, below: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % below
    }
}

const MOTIONS: [&str; 9] =
    ["hold", "one by one", "even steps", "speed", "slow", "sine", "moves", "vibration", "random"];

/// Shaft positions of a motion, in steps, unlimited.
fn motion(kind: &str, words: usize, chance: &mut Chance) -> Vec<i64> {
    let start = chance.next(1 << 24) as i64;
    let speed = chance.next(200_000) as i64 - 100_000;
    let (period, height) = (50 + chance.next(300) as i64, 1 + chance.next(5_000) as i64);
    let mut at = start;
    let mut step = 0_i64;
    (0..words as i64)
        .map(|k| match kind {
            "hold" => start,
            "one by one" => start + k,
            "even steps" => (start & !3) + 4 * k,
            "speed" => start + k * speed / 1_000,
            "slow" => start + k * (speed % 700) / 1_000,
            "sine" => start + ((k as f64 / period as f64 * TAU).sin() * height as f64) as i64,
            "moves" => {
                step += (k / period % 3 - 1) * (1 + speed.abs() % 3);
                at += step;
                at
            }
            "vibration" => start + chance.next(2) as i64,
            _ => chance.next(1 << 24) as i64,
        })
        .collect()
}

fn format(chance: &mut Chance) -> SsiFormat {
    let code = if chance.next(2) == 0 { Code::Binary } else { Code::Gray };
    let bits = 8 + chance.next(25) as u8;
    let repetition = chance.next(10) == 0;
    let week = if chance.next(2) == 0 { Week::AK40 } else { Week::new(40, 1997).unwrap() };
    let bits = if chance.next(6) == 0 { 31 } else { bits };
    SsiFormat::new(SsiValues { repetition, code, bits }, week)
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Found {
    Right,
    List,
    Wrong,
}

/// What is found of a capture of a seed: with the kind of its motion, and what it was.
fn guessed(seed: u64) -> (&'static str, Found, String) {
    let mut chance = Chance(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let kind = MOTIONS[chance.next(MOTIONS.len() as u64) as usize];
    let format = format(&mut chance);
    let bits = u32::from(format.bits());
    let clocks = match (format.check(), chance.next(4)) {
        (SsiCheck::Repetition, _) => 27 + chance.next(60) as u32,
        (_, 0) => bits,
        (_, 1 | 2) => bits + 1,
        _ => bits + 2 + chance.next(u64::from(bits)) as u32,
    };
    let range = 1 << (7 + chance.next(18)) as i64;
    let range = if chance.next(2) == 0 { range } else { 1 + range * 3 / 4 };
    let range = range.min(1 << 24);
    let words = 50 + chance.next(1_000) as usize;
    let mut guess = SsiGuess::new(clocks);
    for shaft in motion(kind, words, &mut chance) {
        let frame = SsiFrame::new(shaft.rem_euclid(range) as u32, format);
        let bits = (1..=clocks).fold(0, |bits, pulse| bits << 1 | u128::from(frame.level(pulse).bit()));
        guess.word(SsiWord { clocks, bits, is_late: false });
    }
    let fits: Vec<SsiFormat> = guess.fits().map(|fit| fit.format).collect();
    let told =
        format!("seed {seed}: {kind}, {format:?}, {clocks} clocks, range {range}, {words} words: {fits:?}");
    let found = match (fits.as_slice(), fits.contains(&format)) {
        ([_], true) if !guess.may_be_longer() => Found::Right,
        (_, true) => Found::List,
        _ => Found::Wrong,
    };
    (kind, found, told)
}

/// How often each was found for each motion.
fn table(seeds: std::ops::Range<u64>) -> BTreeMap<(&'static str, Found), u64> {
    let mut table = BTreeMap::new();
    for seed in seeds {
        let (kind, found, told) = guessed(seed);
        assert!(found != Found::Wrong, "{told}");
        *table.entry((kind, found)).or_default() += 1;
    }
    table
}

#[test]
fn a_format_is_found_right_or_among_a_list_and_never_wrong() {
    let table = table(0..1_000);
    let count = |kind, found| table.get(&(kind, found)).copied().unwrap_or(0);
    for kind in ["speed", "slow"] {
        let (right, list) = (count(kind, Found::Right), count(kind, Found::List));
        assert!(right > list, "{kind}: {right} right, {list} lists");
    }
    assert!(count("hold", Found::Right) < 3, "without motion hardly anything can be told apart");
}

/// The table of the page on SSI.
#[test]
#[ignore = "thirty thousand captures; .ci/long runs it"]
fn thirty_thousand_captures_are_guessed_right_or_as_a_list() {
    let table = table(0..30_000);
    for kind in MOTIONS {
        let count = |found| table.get(&(kind, found)).copied().unwrap_or(0);
        println!("| {kind} | {} | {} | {} |", count(Found::Right), count(Found::List), count(Found::Wrong));
    }
}
