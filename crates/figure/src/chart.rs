//! Curves over the same time, one below the other, with numbered marks and close-ups.

use crate::axis::Axis;
use crate::envelope::Envelope;
use crate::plot::PlotSample;
use crate::svg::{Anchor, Stroke, Svg, Tenths};

mod closeup;
mod text;
mod values;

pub use closeup::Closeup;
use values::Values;

/// Pixels: the curves, and what stands around them.
const LEFT: i64 = 110;
const WIDTH: i64 = 840;
const RIGHT: i64 = 40;
const HEIGHT: i64 = 150;
/// From curve to curve, with the name between them.
const NAME: i64 = 26;
/// For the title and the numbers of the marks.
const TOP: i64 = 56;
const LEGEND: i64 = 20;
/// Numbers stand side by side if they are so far apart; else one line higher or not at all.
const NUMBER: i64 = 20;

/// A curve of a [`Chart`].
#[derive(Clone, Debug)]
struct Curve {
    name: String,
    samples: Envelope,
    values: Values,
}

/// A moment or a stretch that is explained below the curves.
#[derive(Clone, Debug)]
struct Mark {
    number: usize,
    from: u64,
    to: u64,
    text: String,
}

/// Curves over the same time with numbered marks, and a close-up of some of them.
#[derive(Clone, Debug)]
pub struct Chart {
    title: String,
    curves: Vec<Curve>,
    marks: Vec<Mark>,
    closeups: Vec<Closeup>,
    remark: String,
}

impl Chart {
    /// One without curves.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            curves: Vec::new(),
            marks: Vec::new(),
            closeups: Vec::new(),
            remark: String::new(),
        }
    }

    /// Adds a curve, which shows all of its samples.
    pub fn curve(&mut self, name: &str, samples: Envelope) {
        let values = Values::of(&samples);
        self.curves.push(Curve { name: name.to_owned(), samples, values });
    }

    /// Adds a curve of which a few peaks may reach beyond the picture, where they are cut off: so that the rest can be
    /// seen. It is called `cut` then, and else `whole`.
    pub fn curve_without_peaks(&mut self, whole: &str, cut: &str, samples: Envelope) {
        let values = Values::without_peaks(&samples);
        let name = if values == Values::of(&samples) { whole } else { cut };
        self.curves.push(Curve { name: name.to_owned(), samples, values });
    }

    /// Marks what was from a time to a time.
    pub fn mark(&mut self, number: usize, (from, to): (u64, u64), text: impl Into<String>) {
        self.marks.push(Mark { number, from, to: to.max(from), text: text.into() });
    }

    /// Adds a close-up.
    pub fn closeup(&mut self, closeup: Closeup) {
        self.closeups.push(closeup);
    }

    /// A sentence below the marks.
    pub fn remark(&mut self, text: impl Into<String>) {
        self.remark = text.into();
    }

    /// The time from the first to the last sample of all curves.
    fn ends(&self) -> (u64, u64) {
        let ends = || self.curves.iter().filter_map(|curve| curve.samples.ends());
        let from = ends().map(|(from, _)| from).min().unwrap_or(0);
        (from, ends().map(|(_, to)| to).max().unwrap_or(from))
    }

    fn overview_height(&self) -> i64 {
        let legend = self.marks.len() as i64 + i64::from(!self.remark.is_empty());
        TOP + self.curves.len() as i64 * (HEIGHT + NAME) + 36 + legend * LEGEND
    }

    fn height(&self) -> i64 {
        self.overview_height() + closeup::height(self.closeups.len())
    }

    fn width(&self) -> i64 {
        let texts = self.marks.iter().map(|mark| &mark.text).chain([&self.title, &self.remark]);
        let longest = texts.map(|text| Tenths::of_text(text).0 / 10 + 48).max().unwrap_or(0);
        (LEFT + WIDTH + RIGHT).max(longest)
    }

    /// The chart as a text in SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        Self::sheet(&self.title, std::slice::from_ref(self))
    }

    /// Several charts, one below the other, as one text in SVG.
    #[must_use]
    pub fn sheet(title: &str, charts: &[Self]) -> String {
        let width = charts.iter().map(Self::width).max().unwrap_or(LEFT + WIDTH + RIGHT);
        let height: i64 = charts.iter().map(Self::height).sum();
        let mut svg = Svg::new(width, height.max(TOP), title);
        let mut top = 0;
        for chart in charts {
            chart.draw(&mut svg, top);
            top += chart.height();
        }
        svg.finish()
    }

    fn draw(&self, svg: &mut Svg, top: i64) {
        let (from, to) = self.ends();
        let axis = Axis { from, to, left: LEFT, width: WIDTH };
        svg.text(Tenths::pixels(8), Tenths::pixels(top + 18), Anchor::Start, &self.title);
        let bottom = top + TOP + self.curves.len() as i64 * (HEIGHT + NAME);
        for mark in &self.marks {
            self.draw_stretch(svg, &axis, mark, top + TOP, bottom);
        }
        let mut y = top + TOP;
        for curve in &self.curves {
            svg.text(Tenths::pixels(LEFT), Tenths::pixels(y + 16), Anchor::Start, &curve.name);
            y += NAME;
            curve.values.draw(svg, LEFT, WIDTH, y, HEIGHT);
            let places = curve.places(&axis, y);
            svg.line(&places, Stroke::Signal);
            y += HEIGHT;
        }
        axis.draw(svg, Tenths::pixels(bottom + 4));
        self.draw_numbers(svg, &axis, top + TOP, bottom);
        self.draw_legend(svg, bottom + 44);
        closeup::draw(svg, &self.closeups, top + self.overview_height());
    }

    fn draw_stretch(&self, svg: &mut Svg, axis: &Axis, mark: &Mark, top: i64, bottom: i64) {
        let (left, right) = (axis.x(mark.from), axis.x(mark.to));
        if right.0 - left.0 > 20 {
            svg.shade((left, Tenths::pixels(top)), (right, Tenths::pixels(bottom)));
        }
    }

    /// Numbers that would cover one another stand in two lines; where these are full there is only the dashed line.
    fn draw_numbers(&self, svg: &mut Svg, axis: &Axis, top: i64, bottom: i64) {
        let mut ordered: Vec<&Mark> = self.marks.iter().collect();
        ordered.sort_by_key(|mark| mark.from);
        let mut free = [i64::MIN; 2];
        for mark in ordered {
            let x = axis.x(mark.from);
            svg.line(&[(x, Tenths::pixels(top)), (x, Tenths::pixels(bottom + 4))], Stroke::Dashed);
            let line = free.iter().position(|free| *free <= x.0);
            if let Some((line, free)) = line.and_then(|line| Some((line, free.get_mut(line)?))) {
                *free = x.0 + NUMBER * 10;
                svg.number(x, Tenths::pixels(top - 8 - line as i64 * NUMBER), mark.number);
            }
        }
    }

    fn draw_legend(&self, svg: &mut Svg, top: i64) {
        let mut y = top;
        for mark in &self.marks {
            svg.number(Tenths::pixels(19), Tenths::pixels(y - 4), mark.number);
            svg.text(Tenths::pixels(36), Tenths::pixels(y), Anchor::Start, &mark.text);
            y += LEGEND;
        }
        svg.text(Tenths::pixels(36), Tenths::pixels(y), Anchor::Start, &self.remark);
    }
}

impl Curve {
    /// The line through the samples: through all four of a bucket, so that no peak is lost.
    fn places(&self, axis: &Axis, top: i64) -> Vec<(Tenths, Tenths)> {
        let mut places: Vec<(Tenths, Tenths)> = Vec::new();
        // What falls into one pixel is joined to a stroke from its least to its most.
        let mut column: Option<(i64, [i64; 4])> = None;
        let mut put = |column: Option<(i64, [i64; 4])>| {
            let Some((pixel, values)) = column else { return };
            for value in values {
                let place = (Tenths::pixels(pixel), self.values.y(value, top, HEIGHT));
                if places.last() != Some(&place) {
                    places.push(place);
                }
            }
        };
        for (time, bucket) in self.samples.between(axis.from, axis.to) {
            let pixel = axis.x(time).0 / 10;
            column = match column {
                Some((at, [first, least, most, _])) if at == pixel => {
                    Some((at, [first, least.min(bucket.least), most.max(bucket.most), bucket.last]))
                }
                before => {
                    put(before);
                    Some((pixel, [bucket.first, bucket.least, bucket.most, bucket.last]))
                }
            };
        }
        put(column);
        if let [(x, y)] = places[..] {
            places.push((x.plus(1), y));
        }
        places
    }
}

/// The samples of a row of numbers, where all of them are there.
fn envelope(samples: &[PlotSample]) -> Envelope {
    let mut envelope = Envelope::new();
    samples.iter().for_each(|sample| envelope.add(*sample));
    envelope
}
