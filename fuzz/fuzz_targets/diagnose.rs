//! Rows of two encoders, each from the one before or anything at all: the diagnosis ends with lines that exist, and its picture
//! and page are well formed.
#![no_main]

use arbitrary::Arbitrary;
use encoring_diagnosis::{ALTERNATIVES_MAX, Detector, Options, PagePart, Picture, Sample, Sighting, page};
use encoring_words::model::MODELS;
use libfuzzer_sys::fuzz_target;

/// What comes next; `Run` is many rows at once.
#[derive(Arbitrary, Debug)]
enum Next {
    Run { rows: u8, period_ns: u32, way: i32 },
    Jump(i64),
    Time(u64),
    Row { out: Option<u32>, reading: Reading },
    Kind(u8),
    Encoder(bool),
}

#[derive(Arbitrary, Debug)]
enum Reading {
    Word(u32),
    Bits24(u32),
    Bits16(u16),
    Steps(i64),
    Nothing,
}

impl From<&Reading> for Sighting {
    fn from(reading: &Reading) -> Self {
        match *reading {
            Reading::Word(word) => Self::Word(word),
            Reading::Bits24(bits) => Self::Bits24(bits),
            Reading::Bits16(half) => Self::Bits16(half),
            Reading::Steps(steps) => Self::Steps(steps),
            Reading::Nothing => Self::Nothing,
        }
    }
}

fn told(kind: u8, value: i64) -> Sighting {
    match kind % 4 {
        0 => Sighting::Word(value as u32 & 0x00FF_FFFF),
        1 => Sighting::Bits24(value as u32 & 0x00FF_FFFF),
        2 => Sighting::Bits16(value as u16),
        _ => Sighting::Steps(value),
    }
}

fuzz_target!(|told_before: (u8, Vec<Next>)| {
    let (model, script) = told_before;
    let model = MODELS.get(usize::from(model)).copied();
    let mut detector = Detector::new(Options { model, ..Options::default() });
    let mut picture = Picture::default();
    let (mut line, mut time_ns, mut value, mut kind, mut position) = (1, 0_u64, 0_i64, 0, 0);
    let mut take = |time_ns, position, out, reading| {
        line += 1;
        let sample = Sample { line, time_ns, position, out, reading };
        detector.sample(sample);
        picture.sample(&sample);
        picture.look(position, detector.told(position));
    };
    for next in &script {
        match next {
            Next::Run { rows, period_ns, way } => {
                for _ in 0..*rows {
                    time_ns = time_ns.saturating_add(u64::from(*period_ns));
                    value = value.wrapping_add(i64::from(*way));
                    take(time_ns, position, None, told(kind, value));
                }
            }
            Next::Jump(way) => value = value.wrapping_add(*way),
            Next::Time(time) => time_ns = *time,
            Next::Row { out, reading } => take(time_ns, position, *out, reading.into()),
            Next::Kind(new) => kind = *new,
            Next::Encoder(second) => position = u8::from(*second),
        }
    }
    let conclusion = detector.finish();
    for episode in &conclusion.episodes {
        assert!(2 <= episode.line && episode.line <= episode.to_line && episode.to_line <= line, "{episode:?}");
        assert!(episode.alternatives.len() <= ALTERNATIVES_MAX, "{episode:?}");
    }
    let charts = picture.charts("", 1, &conclusion.episodes);
    assert!(charts.iter().all(|chart| chart.svg().ends_with("</svg>\n")));
    let part = PagePart { name: "", conclusion: &conclusion, first: 1, charts: &charts };
    assert!(page("", &[part]).ends_with("</html>\n"));
});
