#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use roxmltree::Document;

use crate::{Chart, Closeup, Envelope, Lane, LaneLevel, Plot, PlotSample, TimingFigure};

fn pulses() -> TimingFigure {
    let mut timing = TimingFigure::new("three pulses", 0, 9_000);
    let mut clock = Lane::levels("clock", LaneLevel::High);
    let mut data = Lane::levels("data", LaneLevel::High);
    let mut bits = Lane::words("bit");
    for (pulse, bit) in [true, false, true].into_iter().enumerate() {
        let fall = 1_000 + 2_000 * pulse as u64;
        clock.change(fall, LaneLevel::Low);
        clock.change(fall + 1_000, LaneLevel::High);
        data.change(fall + 1_000, bit.into());
        bits.word(fall + 1_000, fall + 3_000, u8::from(bit).to_string());
    }
    data.change(8_000, LaneLevel::Unknown);
    for lane in [clock, data, bits] {
        timing.lane(lane);
    }
    timing.mark(6_000, "the third bit");
    timing.mark(1_000, "the clock falls");
    timing
}

fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.text().unwrap_or_default().to_owned()).collect()
}

#[test]
fn a_timing_figure_is_as_it_was() {
    insta::assert_snapshot!("timing", pulses().svg());
    insta::assert_snapshot!("timing_text", pulses().text(500));
}

#[test]
fn a_level_is_at_the_end_of_a_figure_what_it_was_changed_to_last() {
    let ends = |first, changed| {
        let mut timing = TimingFigure::new("a level", 0, 1_000);
        let mut lane = Lane::levels("bit", first);
        lane.change(500, changed);
        timing.lane(lane);
        let svg = timing.svg();
        let document = Document::parse(&svg).unwrap();
        let line = document.descendants().find(|node| node.attribute("stroke-width") == Some("1.5")).unwrap();
        let points = line.attribute("d").unwrap().to_owned();
        let heights: Vec<_> =
            points.rsplit('L').map(|point| point.split_once(' ').unwrap().1.to_owned()).collect();
        (heights[0].clone(), heights[1].clone(), heights.last().unwrap().clone())
    };
    for (first, changed) in [(LaneLevel::Low, LaneLevel::High), (LaneLevel::High, LaneLevel::Low)] {
        let (end, before, begin) = ends(first, changed);
        assert!(end == before && end != begin, "{end} after {before}, from {begin}");
    }
}

#[test]
fn a_plot_is_as_it_was() {
    let mut plot = Plot::new("a jump", 0, 1_000_000);
    plot.series("position");
    for time in 0..1_000_u64 {
        let value = if time < 500 { time as i64 } else { time as i64 - 4_096 };
        plot.sample(PlotSample { time_ns: time * 1_000, value });
    }
    plot.series("expected");
    for time in [0, 999] {
        plot.sample(PlotSample { time_ns: time * 1_000, value: time as i64 });
    }
    plot.mark(500_000, "4096 steps back");
    insta::assert_snapshot!("plot", plot.svg());
}

/// A saw with a spike, every text of which is `name`.
fn chart(name: &str, samples: u64) -> Chart {
    let sample = |k: u64| PlotSample {
        time_ns: k * 1_000_000,
        value: if k == 7 { 5_000 } else { (k % 100 * 10) as i64 },
    };
    let mut curve = Envelope::new();
    (0..samples).for_each(|k| curve.add(sample(k)));
    let mut chart = Chart::new(name);
    chart.curve(name, curve.clone());
    chart.curve_without_peaks(name, &format!("{name} (peaks cut off)"), curve);
    chart.mark(1, (7_000_000, 7_000_000), name);
    chart.mark(2, (9_000_000, 14_000_000), name);
    chart.closeup(Closeup {
        number: 1,
        title: name.to_owned(),
        samples: (0..15).map(sample).collect(),
        stretch: (7_000_000, 7_000_000),
    });
    chart.remark(name);
    chart
}

#[test]
fn a_chart_is_as_it_was() {
    insta::assert_snapshot!("chart", chart("a saw", 300).svg());
    insta::assert_snapshot!("chart_text", chart("a saw", 300).text());
}

#[test]
fn a_chart_without_curves_samples_or_marks_is_a_figure_too() {
    let mut empty = Chart::new("");
    assert!(Document::parse(&empty.svg()).is_ok());
    assert_eq!(empty.text(), "");
    empty.curve("", Envelope::new());
    empty.closeup(Closeup { number: 1, title: String::new(), samples: Vec::new(), stretch: (0, 0) });
    assert!(Document::parse(&empty.svg()).is_ok());
    assert!(Document::parse(&Chart::sheet("", &[])).is_ok());
    assert!(!empty.text().is_empty());
}

#[test]
fn whatever_the_values_are_a_chart_is_drawn() {
    let ends = [i64::MIN, -1, 0, 1, i64::MAX];
    for (first, second) in ends.into_iter().flat_map(|first| ends.map(|second| (first, second))) {
        for times in [[0, 0], [0, u64::MAX], [u64::MAX, 0], [u64::MAX, u64::MAX]] {
            let mut curve = Envelope::new();
            for (time_ns, value) in times.into_iter().zip([first, second]) {
                curve.add(PlotSample { time_ns, value });
            }
            let mut chart = Chart::new("");
            chart.curve("", curve.clone());
            chart.curve_without_peaks("", "", curve);
            chart.mark(1, (5, 3), "");
            assert!(Document::parse(&chart.svg()).is_ok(), "{first} {second} {times:?}");
            assert!(!chart.text().is_empty());
        }
    }
}

#[test]
fn an_envelope_of_millions_of_samples_keeps_every_peak_and_stays_small() {
    let (mut few, mut many) = (Envelope::new(), Envelope::new());
    for k in 0..3_000_000_u64 {
        let value = if k == 1_234_567 { -77_777 } else { (k / 1_000) as i64 };
        many.add(PlotSample { time_ns: k * 500_000, value });
        if k % 1_000 == 0 {
            few.add(PlotSample { time_ns: k * 500_000, value });
        }
    }
    let size = |envelope: &Envelope| envelope.between(0, u64::MAX).count();
    assert!(size(&many) <= 4_096 && size(&many) > 2_000, "{}", size(&many));
    assert_eq!(size(&few), 3_000);
    let least = many.between(0, u64::MAX).map(|(_, bucket)| bucket.least).min();
    assert_eq!(least, Some(-77_777));
    let mut chart = Chart::new("");
    chart.curve("", many);
    assert!(chart.svg().len() < 120_000, "{}", chart.svg().len());
}

#[test]
fn numbers_of_marks_do_not_cover_one_another() {
    let mut chart = chart("", 300);
    (0..200).for_each(|k| chart.mark(3 + k as usize, (20_000_000 + k * 1_000, 0), "close"));
    let svg = chart.svg();
    let document = Document::parse(&svg).unwrap();
    let circles = document.descendants().filter(|node| node.has_tag_name("circle"));
    let place = |node: roxmltree::Node<'_, '_>| {
        let of = |name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
        (of("cx"), of("cy"), of("r"))
    };
    // The dots of the close-up may touch.
    let numbers: Vec<_> = circles.map(place).filter(|(.., r)| *r > 5.0).collect();
    assert!(numbers.len() > 200);
    for (at, (x, y, r)) in numbers.iter().enumerate() {
        for (other_x, other_y, _) in &numbers[..at] {
            assert!((x - other_x).hypot(y - other_y) >= 2.0 * r, "{x} {y} {other_x} {other_y}");
        }
    }
}

#[test]
fn marks_are_numbered_in_order_of_time_whatever_the_order_they_came_in() {
    let texts = texts(&pulses().svg());
    let place = |of: &str| texts.iter().position(|text| text == of).unwrap();
    assert_eq!(texts[place("the clock falls") - 1], "1");
    assert_eq!(texts[place("the third bit") - 1], "2");
}

#[test]
fn whatever_a_text_holds_the_figure_is_well_formed_and_has_no_element_of_its_own() {
    for hostile in ["<script>alert(1)</script>", "a & b", "\"/><x/>", "]]>", "\u{0}\u{b}\u{ffff}", "&amp;"] {
        let mut timing = TimingFigure::new(hostile, 0, 10);
        let mut words = Lane::words(hostile);
        words.word(0, 10, hostile);
        timing.lane(words);
        timing.mark(3, hostile);
        let mut plot = Plot::new(hostile, 0, 10);
        plot.series(hostile);
        plot.series(hostile);
        plot.mark(1, hostile);
        let chart = chart(hostile, 20);
        for svg in [timing.svg(), plot.svg(), chart.svg()] {
            let document = Document::parse(&svg).unwrap();
            let known = ["svg", "title", "rect", "text", "path", "circle"];
            let strange = document.descendants().find(|node| {
                node.is_element() && !known.contains(&node.tag_name().name())
                    || node.attributes().any(|attribute| attribute.name().starts_with("on"))
            });
            assert_eq!(strange, None, "{hostile:?}");
        }
    }
    assert!(texts(&pulses().svg()).contains(&"the clock falls".to_owned()), "texts are looked for");
    let escaped = TimingFigure::new("a < b & \"c\"", 0, 1).svg();
    assert_eq!(texts(&escaped)[0], "a < b & \"c\"");
}

#[test]
fn spans_without_length_and_times_at_the_ends_of_what_there_is_are_drawn() {
    for (from, to) in [(0, 0), (5, 5), (9, 3), (0, u64::MAX), (u64::MAX, u64::MAX)] {
        let mut timing = TimingFigure::new("edge", from, to);
        let mut lane = Lane::levels("line", LaneLevel::Unknown);
        lane.change(u64::MAX, LaneLevel::High);
        lane.change(0, LaneLevel::Low);
        timing.lane(lane);
        let mut words = Lane::words("words");
        words.word(u64::MAX, 0, "w");
        timing.lane(words);
        let mut plot = Plot::new("edge", from, to);
        plot.sample(PlotSample { time_ns: from, value: 1 });
        plot.series("line");
        for value in [i64::MIN, i64::MAX, 0] {
            plot.sample(PlotSample { time_ns: from, value });
        }
        for svg in [timing.svg(), plot.svg()] {
            Document::parse(&svg).unwrap();
            assert!(svg.len() < 20_000, "{from} to {to}: {} bytes", svg.len());
        }
        assert!(timing.text(u64::MAX / 100).len() < 10_000);
    }
}

#[test]
fn a_plot_keeps_every_peak_and_grows_with_its_width_only() {
    let mut plot = Plot::new("peak", 0, 100_000_000);
    plot.series("value");
    for time_ns in 0..100_000 {
        let value = if time_ns == 54_321 { 1_000_000 } else { (time_ns % 2) as i64 };
        plot.sample(PlotSample { time_ns: time_ns * 1_000, value });
    }
    let svg = plot.svg();
    assert!(texts(&svg).contains(&"1000000".to_owned()), "the peak is in the range");
    // The top of the values is at 52 pixels.
    assert!(svg.contains(" 52L"), "the peak is drawn");
    assert!(svg.len() < 60_000, "{} bytes", svg.len());
}

#[test]
fn a_text_figure_goes_on_below_when_it_is_too_wide_for_a_terminal() {
    let mut timing = TimingFigure::new("long", 0, 100_000);
    timing.lane(Lane::levels("line", LaneLevel::Low));
    let text = timing.text(1_000);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    assert!(lines.iter().all(|line| line.chars().count() <= 80), "{text}");
    assert_eq!(text.matches('_').count(), 100);
}
