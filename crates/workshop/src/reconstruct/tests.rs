//! Reconstruction from random encoders, judged by the manual's formula.

use encoring_words::InWord;
use encoring_words::Model;
use encoring_words::Parameter;

use super::Reconstruction;
use super::positions::{KnownPosition, Line, MeasuredWay, Unsettled, WrapBetween};
use super::words::{WordEvidence, WordFindings};
use crate::mark::{Reference, ReferenceUnit};

/// Chance that can be repeated (SplitMix64).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }
}

/// An old unit: the formula of a rotary position, written down anew.
#[derive(Clone, Copy, Debug)]
struct Old {
    length: u64,
    numerator: u64,
    denominator: u64,
    falling: bool,
    offset: u64,
}

const NATIVE: u64 = 4096;

impl Old {
    fn shows(self, shaft: i64) -> u32 {
        let range = i128::from(NATIVE * self.numerator);
        let counted = if self.falling { -1 - shaft } else { shaft };
        let phase =
            (i128::from(counted) * i128::from(self.denominator) + i128::from(self.offset)).rem_euclid(range);
        (phase * i128::from(self.length + 1) / range) as u32
    }

    /// A preset at this place.
    fn preset(mut self, shaft: i64, value: u32) -> Self {
        let range = NATIVE * self.numerator;
        self.offset = 0;
        let counted = if self.falling { -1 - shaft } else { shaft };
        let phase = (i128::from(counted) * i128::from(self.denominator)).rem_euclid(i128::from(range)) as u64;
        let wanted = (u64::from(value) * range).div_ceil(self.length + 1);
        self.offset = (wanted + range - phase) % range;
        self
    }

    fn round(chance: &mut Chance) -> Self {
        let per_turn =
            [100, 200, 250, 360, 400, 500, 1000, 2000, 3600, 4000, 1024, 4096][chance.below(12) as usize];
        let turns = chance.between(8, 400);
        Self { length: per_turn * turns - 1, numerator: turns, denominator: 1, ..Self::any(chance) }
    }

    fn any(chance: &mut Chance) -> Self {
        loop {
            let (numerator, denominator) = (chance.between(1, 0xFFFF), chance.between(1, 99));
            let most = (NATIVE * numerator / denominator).min(0x100_0000);
            if most < 0x20 || numerator / denominator < 4 {
                continue;
            }
            let length = chance.between(0x10, most - 1);
            let offset = chance.below(NATIVE * numerator);
            return Self { length, numerator, denominator, falling: chance.below(2) == 1, offset };
        }
    }
}

/// Degrees with so many decimals, rounded.
fn degrees(shaft: i64, decimals: u32) -> Reference {
    let digit = 10_i64.pow(6 - decimals);
    let millionths = i128::from(shaft) * 360_000_000 / i128::from(NATIVE);
    let rounded = (millionths + i128::from(digit) / 2).div_euclid(i128::from(digit)) * i128::from(digit);
    Reference { millionths: rounded as i64, digit: digit as u32, scale: ReferenceUnit::Degrees }
}

const TURN: MeasuredWay =
    MeasuredWay { length: (360, 1), unit: ReferenceUnit::Degrees, fewest_steps: 4096, most_steps: 4096 };

/// What became of many.
#[derive(Debug, Default, PartialEq, Eq)]
struct Table {
    unique_and_right: u32,
    not_unique: u32,
    unsettled: u32,
    wrong: u32,
}

/// One old unit, some marks: whether the positions over the travel are as near as is said.
fn judge(old: Old, places: &[i64], decimals: u32, table: &mut Table) {
    let known: Vec<_> = places
        .iter()
        .map(|shaft| KnownPosition { shown: old.shows(*shaft), reference: degrees(*shaft, decimals) })
        .collect();
    let line = match Line::of(&known, TURN, WrapBetween::Possible) {
        Ok(line) => line,
        Err(Unsettled::NoLine) => {
            table.wrong += 1;
            return;
        }
        Err(_) => {
            table.unsettled += 1;
            return;
        }
    };
    let Some(scaling) = line.shaft(None) else {
        table.wrong += 1;
        return;
    };
    let value = |wanted| scaling.values.iter().find(|(parameter, _)| *parameter == wanted).unwrap().1;
    let new = Old {
        length: value(Parameter::MeasuringLength).into(),
        numerator: value(Parameter::Numerator).into(),
        denominator: value(Parameter::Denominator).into(),
        falling: value(Parameter::CountingDirection) == 1,
        offset: 0,
    };
    let new = new.preset(places[0], known[0].shown);
    let (first, last) = (*places.iter().min().unwrap(), *places.iter().max().unwrap());
    let mut worst = 0;
    for k in 0..=200 {
        let shaft = first + (last - first) * k / 200;
        // The old position may begin again within the travel only where the marks could not tell it.
        let off = old.shows(shaft).abs_diff(new.shows(shaft));
        worst = worst.max(off);
    }
    let whole = old.denominator == 1 && (old.length + 1).is_multiple_of(old.numerator);
    let another = scaling.only_round_one
        && whole
        && (new.length + 1) * old.numerator != (old.length + 1) * new.numerator;
    if u128::from(worst) > scaling.off_at_most || new.falling != old.falling || another {
        table.wrong += 1;
    } else if scaling.only_round_one {
        table.unique_and_right += 1;
    } else {
        table.not_unique += 1;
    }
}

/// Marks over a travel in which no position comes twice.
fn places(old: Old, count: u64, chance: &mut Chance) -> Vec<i64> {
    let period = (NATIVE * old.numerator / old.denominator).max(2);
    let travel = chance.between(period / 2, period - 1);
    let start = chance.below(1 << 24) as i64 - (1 << 23);
    (0..count).map(|_| start + chance.below(travel) as i64).collect()
}

fn table(seed: u64, cases: u32, make: fn(&mut Chance) -> Old) -> Table {
    let (mut chance, mut table) = (Chance(seed), Table::default());
    for _ in 0..cases {
        let old = make(&mut chance);
        let count = chance.between(2, 6);
        let decimals = chance.below(4) as u32;
        let places = places(old, count, &mut chance);
        let wrong = table.wrong;
        judge(old, &places, decimals, &mut table);
        assert_eq!(table.wrong, wrong, "seed {seed}: {old:?} at {places:?} with {decimals} decimals");
    }
    table
}

#[test]
fn known_positions_never_tell_a_wrong_scaling() {
    let round = table(1, 3_000, Old::round);
    let any = table(2, 3_000, Old::any);
    println!("round numbers of steps per turn: {round:?}\nany legal set: {any:?}");
    assert!(round.unique_and_right > 300, "{round:?}");
    assert!(any.not_unique > 300 && any.unsettled > 300, "{any:?}");
}

#[test]
fn noted_words_give_the_values_and_contradictions_are_told() {
    let mut chance = Chance(3);
    let (mut whole, mut contradicted) = (0, 0);
    for _ in 0..3_000 {
        let old = Old::any(&mut chance);
        let values = [(0x02, old.length), (0x03, old.numerator), (0x09, old.denominator)];
        let mut words = Vec::new();
        for (service, value) in values {
            for head in [0x4000_0000_u32, 0xC000_0000] {
                words.push((head | service << 24 | value as u32, format!("{service:02X}")));
            }
        }
        let other = chance.below(2) == 1;
        if other {
            words.push((0xC300_0000 | (old.numerator as u32 ^ 1).max(1), "other".to_owned()));
        }
        let found = WordFindings::noted(Model::Ce100M, words);
        let numerator = found.of(Parameter::Numerator);
        if other && (old.numerator ^ 1).max(1) != old.numerator {
            assert!(matches!(numerator, WordEvidence::Contradicted(ref both) if both.len() == 2), "{old:?}");
            contradicted += 1;
        } else {
            let expected = [
                (Parameter::MeasuringLength, old.length as u32),
                (Parameter::Numerator, old.numerator as u32),
                (Parameter::Denominator, old.denominator as u32),
            ];
            assert_eq!(found.values(), expected, "{old:?}");
            whole += 1;
        }
        assert_eq!(found.of(Parameter::CountingDirection), WordEvidence::Missing);
    }
    println!("noted words: {whole} unique and right, {contradicted} rightly contradictory, 0 wrong");
    assert!(whole > 1_000 && contradicted > 1_000);
}

#[test]
fn words_that_tell_nothing_are_told() {
    let words = [
        0x0000_1388,
        0x8200_0000,
        0xE200_270F,
        0xC700_0001,
        0xCD00_0018,
        0xC200_0001,
        0xC600_0005,
        0xC800_0000,
    ];
    let found = WordFindings::noted(Model::Ce100M, words.map(|word| (word, "program".to_owned())));
    assert_eq!(found.values(), []);
    assert_eq!(found.presets().len(), 1);
    assert_eq!(
        found.notes,
        [
            "program: 00001388 has no service number: it is a position or a plain number",
            "program: E200270F has the error bit set: the encoder refused it, or an error was pending",
            "program: C7000001 has service 07, which no encoder has",
            "program: CD000018 has service 0D, which a ce-100-m lacks: is the model right?",
            "program: C2000001 has measuring_length = 1, and a ce-100-m takes 16 to 16777215",
        ]
    );
}

#[test]
fn a_mark_at_the_edge_of_a_step_restores_the_zero_everywhere_if_the_denominator_is_1() {
    let mut chance = Chance(5);
    for _ in 0..2_000 {
        let old = Old { denominator: 1, ..Old::any(&mut chance) };
        if old.length >= NATIVE * old.numerator {
            continue;
        }
        let mut edge = chance.below(1 << 24) as i64;
        let before = |shaft: i64| if old.falling { shaft + 1 } else { shaft - 1 };
        while old.shows(before(edge)) == old.shows(edge) {
            edge = before(edge);
        }
        let new = old.preset(edge, old.shows(edge));
        for _ in 0..200 {
            let shaft = chance.below(1 << 25) as i64 - (1 << 24);
            assert_eq!(new.shows(shaft), old.shows(shaft), "{old:?}, edge {edge}, at {shaft}");
        }
    }
}

#[test]
fn a_word_that_an_encoder_refuses_tells_nothing_and_a_refused_data_check_settles_nothing() {
    let zero = WordFindings::noted(Model::Ce65M, [(0xC300_0000, "word".to_owned())]);
    assert!(zero.values().is_empty() && zero.notes[0].contains("numerator = 0"), "{:?}", zero.notes);
    let row = |word: u32| (Some(InWord(word)), format!("{word:08X}"));
    let programmed = [0xC200_270F, 0x0000_0064, 0xC300_0001, 0x0000_0064];
    for (check, counted) in [(0xA800_4000, false), (0x8800_0000, true)] {
        let words = programmed.into_iter().chain([check, 0x64]);
        let found = WordFindings::recorded(Model::Ce65M, words.map(row));
        let told = Reconstruction::from_words(Model::Ce65M, &found);
        assert_eq!(told.kept.values.len(), 2, "{check:08X}: {told:?}");
        assert_eq!(
            told.unknown.iter().any(|line| line.contains("which values counted")),
            !counted,
            "{told:?}"
        );
    }
}
