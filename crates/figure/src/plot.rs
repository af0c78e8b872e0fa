//! Samples over time.

use crate::axis::Axis;
use crate::svg::{Anchor, Stroke, Svg, Tenths};

/// A value at a time, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlotSample {
    /// When.
    pub time_ns: u64,
    /// What was there.
    pub value: i64,
}

/// The samples of a name that fell into one column of pixels.
#[derive(Clone, Copy, Debug)]
struct Column {
    first: i64,
    least: i64,
    most: i64,
    last: i64,
}

/// Samples over a span of time. However many there are, it keeps four values for each column of pixels: the first, the
/// least, the most and the last.
#[derive(Clone, Debug)]
pub struct Plot {
    title: String,
    axis: Axis,
    series: Vec<(String, Vec<Option<Column>>)>,
    marks: Vec<(u64, String)>,
}

/// Pixels of the values from bottom to top, and of the time axis.
const HEIGHT: i64 = 240;
const WIDTH: i64 = 720;
const TOP: i64 = 52;
const LEFT: i64 = 110;
const LEGEND: i64 = 22;

impl Plot {
    /// A plot of the time from `from` to `to`, in nanoseconds.
    #[must_use]
    pub fn new(title: &str, from: u64, to: u64) -> Self {
        let axis = Axis { from, to: to.max(from), left: LEFT, width: WIDTH };
        Self { title: title.to_owned(), axis, series: Vec::new(), marks: Vec::new() }
    }

    /// Adds a line, told apart by its dashes. What was given last is what [`Plot::sample`] adds to.
    pub fn series(&mut self, name: &str) {
        self.series.push((name.to_owned(), vec![None; WIDTH as usize + 1]));
    }

    /// Adds a sample to the last line; outside of the time it is left out.
    pub fn sample(&mut self, sample: PlotSample) {
        let PlotSample { time_ns, value } = sample;
        if time_ns < self.axis.from || time_ns > self.axis.to {
            return;
        }
        let column = (self.axis.x(time_ns).0 / 10 - LEFT).unsigned_abs() as usize;
        let Some(cell) = self.series.last_mut().and_then(|(_, columns)| columns.get_mut(column)) else {
            return;
        };
        *cell = Some(cell.map_or(
            Column { first: value, least: value, most: value, last: value },
            |Column { first, least, most, .. }| Column {
                first,
                least: least.min(value),
                most: most.max(value),
                last: value,
            },
        ));
    }

    /// Marks a moment; marks are numbered from 1 in order of time, and explained below the plot.
    pub fn mark(&mut self, at: u64, text: impl Into<String>) {
        self.marks.push((at, text.into()));
        self.marks.sort_by_key(|(at, _)| *at);
    }

    /// The least and the most of all samples.
    fn range(&self) -> (i64, i64) {
        let columns = || self.series.iter().flat_map(|(_, columns)| columns).flatten();
        let least = columns().map(|column| column.least).min().unwrap_or(0);
        let most = columns().map(|column| column.most).max().unwrap_or(0);
        (least, most)
    }

    /// The plot as a text in SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let several = if self.series.len() > 1 { self.series.len() as i64 } else { 0 };
        let bottom = TOP + HEIGHT;
        let height = bottom + 40 + (self.marks.len() as i64 + several) * LEGEND;
        let texts = self.marks.iter().map(|(_, text)| text).chain([&self.title]);
        let longest = texts.map(|text| Tenths::of_text(text).0 / 10 + 40).max().unwrap_or(0);
        let mut svg = Svg::new((LEFT + WIDTH + 40).max(longest), height, &self.title);
        svg.text(Tenths::pixels(8), Tenths::pixels(16), Anchor::Start, &self.title);
        let (least, most) = self.range();
        self.draw_values(&mut svg, least, most);
        self.axis.draw(&mut svg, Tenths::pixels(bottom + 6));
        let mut y = bottom + 32 + LEGEND - 8;
        for ((name, columns), number) in self.series.iter().zip(0..) {
            draw_series(&mut svg, columns, |value| y_of(value, least, most), Stroke::Series(number));
            if several > 0 {
                let key =
                    [(Tenths::pixels(8), Tenths::pixels(y - 4)), (Tenths::pixels(48), Tenths::pixels(y - 4))];
                svg.line(&key, Stroke::Series(number));
                svg.text(Tenths::pixels(56), Tenths::pixels(y), Anchor::Start, name);
                y += LEGEND;
            }
        }
        for ((at, text), number) in self.marks.iter().zip(1..) {
            let x = self.axis.x(*at);
            svg.line(&[(x, Tenths::pixels(TOP - 12)), (x, Tenths::pixels(bottom + 6))], Stroke::Dashed);
            svg.number(x, Tenths::pixels(TOP - 16), number);
            svg.number(Tenths::pixels(17), Tenths::pixels(y - 4), number);
            svg.text(Tenths::pixels(32), Tenths::pixels(y), Anchor::Start, text);
            y += LEGEND;
        }
        svg.finish()
    }

    /// The axis of the values: the least, the middle and the most.
    fn draw_values(&self, svg: &mut Svg, least: i64, most: i64) {
        let mut values = vec![least, i64::midpoint(least, most), most];
        values.dedup();
        for value in values {
            let y = y_of(value, least, most);
            svg.line(&[(Tenths::pixels(LEFT), y), (Tenths::pixels(LEFT + WIDTH), y)], Stroke::Dashed);
            svg.text(Tenths::pixels(LEFT - 8), y.plus(4), Anchor::End, &value.to_string());
        }
    }
}

fn y_of(value: i64, least: i64, most: i64) -> Tenths {
    let span = (i128::from(most) - i128::from(least)).max(1);
    let above = (i128::from(value) - i128::from(least)) * i128::from(HEIGHT * 10) / span;
    Tenths((TOP + HEIGHT) * 10 - above as i64)
}

/// From column to column the last value is joined with the next first one; inside a column the line goes over least and
/// most, so that no peak is lost.
fn draw_series(svg: &mut Svg, columns: &[Option<Column>], y: impl Fn(i64) -> Tenths, stroke: Stroke) {
    let mut points = Vec::new();
    for (column, x) in columns.iter().zip(LEFT..) {
        let Some(Column { first, least, most, last }) = column else { continue };
        let x = Tenths::pixels(x);
        for value in [first, least, most, last] {
            if points.last() != Some(&(x, y(*value))) {
                points.push((x, y(*value)));
            }
        }
    }
    if let [(x, y)] = points[..] {
        points.push((x.plus(1), y));
    }
    svg.line(&points, stroke);
}
