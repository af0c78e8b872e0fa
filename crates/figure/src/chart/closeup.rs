//! A few samples, large enough to see each of them.

use crate::axis::Axis;
use crate::plot::PlotSample;
use crate::svg::{Anchor, Stroke, Svg, Tenths};

use super::values::Values;
use super::{LEFT, RIGHT, WIDTH, envelope};

/// Close-ups side by side.
const BESIDE: i64 = 2;
const HEIGHT: i64 = 130;
const TOP: i64 = 34;
const BOTTOM: i64 = 46;
/// Samples that are drawn as dots; more of them are a line only.
const DOTS_MAX: usize = 160;

/// A few samples around a mark.
#[derive(Clone, Debug)]
pub struct Closeup {
    /// The number of the mark, from 1.
    pub number: usize,
    /// What it is called.
    pub title: String,
    /// The samples in the order of time.
    pub samples: Vec<PlotSample>,
    /// The first and the last time that the mark is about.
    pub stretch: (u64, u64),
}

/// Pixels of so many close-ups.
pub(super) fn height(count: usize) -> i64 {
    count.div_ceil(BESIDE as usize) as i64 * (TOP + HEIGHT + BOTTOM)
}

pub(super) fn draw(svg: &mut Svg, closeups: &[Closeup], top: i64) {
    for (place, closeup) in (0..).zip(closeups) {
        let each = (LEFT + WIDTH + RIGHT) / BESIDE;
        let (left, row) = (place % BESIDE * each + LEFT, place / BESIDE);
        closeup.draw(svg, left, each - LEFT - RIGHT, top + row * (TOP + HEIGHT + BOTTOM));
    }
}

impl Closeup {
    fn draw(&self, svg: &mut Svg, left: i64, width: i64, top: i64) {
        let times = || self.samples.iter().map(|sample| sample.time_ns);
        let (from, to) = (times().min().unwrap_or(0), times().max().unwrap_or(0));
        let axis = Axis { from, to, left, width };
        svg.number(Tenths::pixels(left - LEFT + 19), Tenths::pixels(top + 16), self.number);
        svg.text(Tenths::pixels(left - LEFT + 36), Tenths::pixels(top + 20), Anchor::Start, &self.title);
        let top = top + TOP;
        let (first, last) = (axis.x(self.stretch.0), axis.x(self.stretch.1));
        let edge = Tenths::pixels(3).0;
        svg.shade(
            (Tenths((first.0 - edge).max(left * 10)), Tenths::pixels(top)),
            (Tenths((last.0 + edge).min((left + width) * 10)), Tenths::pixels(top + HEIGHT)),
        );
        let values = Values::of(&envelope(&self.samples));
        values.draw(svg, left, width, top, HEIGHT);
        let place = |sample: &PlotSample| (axis.x(sample.time_ns), values.y(sample.value, top, HEIGHT));
        let places: Vec<(Tenths, Tenths)> = self.samples.iter().map(place).collect();
        svg.line(&places, Stroke::Series(0));
        if places.len() <= DOTS_MAX {
            places.iter().for_each(|(x, y)| svg.dot(*x, *y));
        }
        axis.draw(svg, Tenths::pixels(top + HEIGHT + 4));
    }
}
