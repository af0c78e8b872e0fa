//! The picture and the page.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use encoring_diagnosis::{
    Conclusion, Detector, Episode, JumpCause, Likelihood, Options, PagePart, Picture, Sample, Sighting, page,
};
use encoring_figure::Chart;
use encoring_texts::Said;
use roxmltree::Document;

/// A slow movement of `rows` rows in which every `each`-th row has a wrong bit; what the detector says, and the picture.
fn said(text: &str) -> Said {
    Said::new("test.any", text.to_owned(), Vec::new())
}

fn recording(rows: u64, each: u64) -> (Conclusion, Picture) {
    let mut detector = Detector::new(Options::default());
    let mut picture = Picture::default();
    for k in 0..rows {
        let word = (1_000 + k) as u32 & 0x00FF_FFFF;
        let word = if k % each == each / 2 { word ^ 1 << 20 } else { word };
        let sample = Sample {
            line: k + 2,
            time_ns: k * 1_000_000,
            position: 3,
            out: None,
            reading: Sighting::Word(word),
        };
        detector.sample(sample);
        picture.sample(&sample);
        picture.look(3, detector.told(3));
    }
    (detector.finish(), picture)
}

fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.text().unwrap_or_default().to_owned()).collect()
}

fn episode(line: u64, text: &str) -> Episode {
    Episode {
        line,
        to_line: line,
        count: 1,
        time_ns: line * 1_000_000,
        position: 0,
        cause: JumpCause::SingleBit,
        certainty: Likelihood::Likely,
        alternatives: vec![JumpCause::TornWords],
        apart: vec![said(text)],
        evidence: vec![said(text)],
    }
}

#[test]
fn each_jump_is_numbered_and_has_a_close_up_even_where_its_rows_are_long_gone() {
    let (conclusion, picture) = recording(100_000, 20_000);
    assert_eq!(conclusion.episodes.len(), 5);
    let charts = picture.charts("axis.csv", 1, &conclusion.episodes);
    let texts = texts(&charts[0].svg());
    for (number, episode) in (1..).zip(&conclusion.episodes) {
        let explained = format!("line {}, ", episode.line);
        assert!(texts.iter().any(|text| text.starts_with(&explained)), "{explained} in {texts:?}");
        // On the curves, in the list, at the close-up.
        assert_eq!(texts.iter().filter(|text| **text == number.to_string()).count(), 3, "{number}");
    }
    assert_eq!(texts.iter().filter(|text| *text == "one wrong bit, likely").count(), 5);
}

#[test]
fn the_picture_is_as_large_for_any_number_of_rows_and_jumps() {
    let of = |rows, jumps| {
        let (_, picture) = recording(rows, 2_000);
        let jumps: Vec<Episode> =
            (0..jumps).map(|k| Episode { position: 3, ..episode(k * 400 + 2, "") }).collect();
        picture.charts("", 1, &jumps)[0].svg()
    };
    let (small, large) = (of(120_000, 50), of(600_000, 1_000));
    assert!(large.len() < small.len() * 3 / 2, "{} {}", small.len(), large.len());
    for (svg, beyond) in [(small, 10), (large, 960)] {
        let remark = format!("{beyond} more are not marked here; the report has them");
        assert!(texts(&svg).contains(&remark), "{remark}");
    }
}

#[test]
fn a_page_has_every_episode_with_the_number_of_the_picture_and_the_manuals_remedies() {
    let (conclusion, picture) = recording(3_000, 1_000);
    let charts = picture.charts("axis.csv", 4, &conclusion.episodes);
    let part = PagePart { name: "axis.csv", conclusion: &conclusion, first: 4, charts: &charts };
    let page = page("Jumps", &[part]);
    for (number, episode) in (4..).zip(&conclusion.episodes) {
        assert!(page.contains(&format!("<tr><td>{number}<td>line {}, ", episode.line)), "{page}");
    }
    // [R150] [R151] [R152] [R153]
    for remedy in ["shock", "insulating", "screen", "plastic"] {
        assert!(page.contains(remedy), "{remedy}");
    }
    let (clean, picture) = recording(3_000, 10_000);
    let charts = picture.charts("axis.csv", 1, &clean.episodes);
    let part = PagePart { name: "axis.csv", conclusion: &clean, first: 1, charts: &charts };
    let page = encoring_diagnosis::page("Jumps", &[part]);
    assert!(page.contains("No step change.") && !page.contains("plastic"), "{page}");
}

#[test]
fn whatever_a_text_holds_the_page_has_no_script_and_no_element_of_its_own() {
    for hostile in ["<script>alert(1)</script>", "\" onload=\"x", "</style><b>", "<!--", "&lt;", "a & b"] {
        let conclusion = Conclusion {
            episodes: vec![episode(2, hostile)],
            is_judged: true,
            judged: vec![said(hostile)],
            limits: vec![said(hostile)],
        };
        let mut picture = Picture::default();
        for k in 0..4 {
            let reading = Sighting::Steps(k);
            picture.sample(&Sample { line: k as u64, time_ns: k as u64, position: 0, out: None, reading });
        }
        let charts = picture.charts(hostile, 1, &conclusion.episodes);
        let part = PagePart { name: hostile, conclusion: &conclusion, first: 1, charts: &charts };
        let page = page(hostile, &[part]);
        for mark in ["<script", "<b>", "<!--", "onload=\"", "href", "src="] {
            assert!(!page.contains(mark), "{mark} of {hostile:?}: {page}");
        }
        assert!(page.matches("</style>").count() == 1, "{page}");
    }
}

#[test]
fn encoders_are_drawn_one_below_the_other_and_a_ninth_is_told() {
    let mut picture = Picture::default();
    for k in 0..90_u64 {
        let position = (k % 9) as u8;
        let reading = Sighting::Word(k as u32);
        picture.sample(&Sample { line: k + 2, time_ns: k * 1_000, position, out: None, reading });
    }
    let charts = picture.charts("ring.csv", 1, &[]);
    let texts = texts(&Chart::sheet("", &charts));
    assert!(texts.contains(&"ring.csv, position 0".to_owned()), "{texts:?}");
    assert!(
        texts.contains(&"ring.csv, position 7".to_owned())
            && !texts.contains(&"ring.csv, position 8".to_owned())
    );
    assert!(texts.iter().any(|text| text.starts_with("further encoders")), "{texts:?}");
}
