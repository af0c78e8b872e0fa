//! Rows that no recording has: whatever comes, there is an end with bounded findings and a picture that is one.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use encoring_diagnosis::{ALTERNATIVES_MAX, Detector, Options, PagePart, Picture, Sample, Sighting, page};
use encoring_words::model::MODELS;
use roxmltree::Document;

/// Chance from a seed: splitmix64.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }
}

/// A number that is small, large or at a boundary.
fn number(chance: &mut Chance) -> u64 {
    let shift = chance.below(64);
    chance.of(&[0, 1, u64::MAX, i64::MAX as u64, i64::MIN as u64, 0x00FF_FFFF, 0xFFFF])
        ^ chance.next() >> shift
}

/// Rows that go on from one another most of the time, so that there are stretches too.
fn rows(chance: &mut Chance) -> Vec<Sample> {
    let mut rows = Vec::new();
    let (mut time_ns, mut value, mut kind) = (number(chance) >> 8, number(chance), chance.below(5));
    let (mut step, mut way) = (chance.below(1 << 24), chance.below(1 << 20));
    for k in 0..chance.below(1_500) {
        match chance.below(60) {
            0 => time_ns = number(chance),
            1 => value = number(chance),
            2 => kind = chance.below(5),
            3 => step = number(chance) >> chance.below(64),
            4 => way = number(chance) >> chance.below(64),
            5 => value = value.rotate_left(16) ^ 0xC600_0000,
            _ => (time_ns, value) = (time_ns.saturating_add(step), value.wrapping_add(way)),
        }
        let reading = match kind {
            0 => Sighting::Word(value as u32),
            1 => Sighting::Bits24(value as u32),
            2 => Sighting::Bits16(value as u16),
            3 => Sighting::Steps(value as i64),
            _ => chance.of(&[Sighting::Nothing, Sighting::Word(value as u32 & 0x00FF_FFFF)]),
        };
        let out = chance.of(&[None, Some(0), Some(0xC600_0000), Some(value as u32)]);
        rows.push(Sample { line: k + 2, time_ns, position: chance.below(2) as u8, out, reading });
    }
    rows
}

#[test]
fn whatever_rows_come_there_is_an_end_and_a_picture() {
    for seed in 0..100 {
        let chance = &mut Chance(seed);
        let model = chance.of(&[None, Some(MODELS[0]), Some(MODELS[1]), Some(MODELS[2])]);
        let mut detector = Detector::new(Options { model, ..Options::default() });
        let mut picture = Picture::default();
        let rows = rows(chance);
        for sample in &rows {
            detector.sample(*sample);
            picture.sample(sample);
            picture.look(sample.position, detector.told(sample.position));
        }
        let conclusion = detector.finish();
        for episode in &conclusion.episodes {
            assert!(episode.line >= 2 && episode.to_line < rows.len() as u64 + 2, "seed {seed}: {episode:?}");
            assert!(episode.line <= episode.to_line && episode.count > 0, "seed {seed}: {episode:?}");
            assert!(episode.alternatives.len() <= ALTERNATIVES_MAX, "seed {seed}: {episode:?}");
            assert!(!episode.alternatives.contains(&episode.cause), "seed {seed}: {episode:?}");
        }
        let charts = picture.charts("", 1, &conclusion.episodes);
        for chart in &charts {
            assert!(Document::parse(&chart.svg()).is_ok(), "seed {seed}");
        }
        let part = PagePart { name: "", conclusion: &conclusion, first: 1, charts: &charts };
        assert!(page("", &[part]).ends_with("</html>\n"), "seed {seed}");
    }
}
