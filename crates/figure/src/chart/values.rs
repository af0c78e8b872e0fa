//! The values of a curve from bottom to top.

use crate::envelope::Envelope;
use crate::svg::{Anchor, Stroke, Svg, Tenths};

/// Ticks that the values have at most.
const TICKS_MAX: i128 = 5;
/// Of a thousand buckets, so many may reach beyond the picture on each side.
const PEAKS: usize = 20;

/// The least and the most that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Values {
    least: i64,
    most: i64,
}

impl Values {
    /// All values.
    pub(crate) fn of(samples: &Envelope) -> Self {
        let buckets = || samples.between(0, u64::MAX).map(|(_, bucket)| bucket);
        let least = buckets().map(|bucket| bucket.least).min().unwrap_or(0);
        let most = buckets().map(|bucket| bucket.most).max().unwrap_or(0);
        Self { least, most }
    }

    /// Those of all buckets but the few that reach furthest, if these reach much further than the rest.
    pub(crate) fn without_peaks(samples: &Envelope) -> Self {
        let all = Self::of(samples);
        let buckets = || samples.between(0, u64::MAX).map(|(_, bucket)| bucket);
        let mut lowest: Vec<i64> = buckets().map(|bucket| bucket.least).collect();
        let mut highest: Vec<i64> = buckets().map(|bucket| bucket.most).collect();
        lowest.sort_unstable();
        highest.sort_unstable();
        let peaks = (lowest.len() * PEAKS).div_ceil(1_000);
        let least = lowest.get(peaks).copied().unwrap_or(all.least);
        let most = highest.iter().rev().nth(peaks).copied().unwrap_or(all.most);
        let room = (i128::from(most) - i128::from(least)) / 4 + 1;
        let within = |value: i128| i64::try_from(value).unwrap_or(i64::MAX);
        Self {
            least: all.least.max(within(i128::from(least) - room)),
            most: all.most.min(within(i128::from(most) + room)),
        }
    }

    /// The least and the most.
    pub(crate) const fn ends(&self) -> (i64, i64) {
        (self.least, self.most)
    }

    fn span(&self) -> i128 {
        (i128::from(self.most) - i128::from(self.least)).max(1)
    }

    /// The place of a value; one beyond stands at the edge.
    pub(crate) fn y(&self, value: i64, top: i64, height: i64) -> Tenths {
        let value = value.clamp(self.least, self.most.max(self.least));
        let above = (i128::from(value) - i128::from(self.least)) * i128::from(height * 10) / self.span();
        Tenths((top + height) * 10 - above as i64)
    }

    /// From tick to tick: 1, 2 or 5 times a power of ten.
    fn step(&self) -> i128 {
        let mut power = 1_i128;
        loop {
            for factor in [1, 2, 5] {
                if self.span() / (power * factor) < TICKS_MAX {
                    return power * factor;
                }
            }
            power *= 10;
        }
    }

    /// The round values that are written beside the curve; both ends if there is no other.
    pub(crate) fn ticks(&self) -> Vec<i64> {
        let step = self.step();
        let first = i128::from(self.least).div_euclid(step) * step;
        let ticks = (0..=TICKS_MAX + 1).map(|tick| first + tick * step);
        let within = |tick: &i128| (i128::from(self.least)..=i128::from(self.most)).contains(tick);
        ticks.filter(within).filter_map(|tick| i64::try_from(tick).ok()).collect()
    }

    /// A frame, and the ticks with their values at its left.
    pub(crate) fn draw(&self, svg: &mut Svg, left: i64, width: i64, top: i64, height: i64) {
        let (right, bottom) = (Tenths::pixels(left + width), Tenths::pixels(top + height));
        let (x, y) = (Tenths::pixels(left), Tenths::pixels(top));
        svg.line(&[(x, y), (right, y), (right, bottom), (x, bottom), (x, y)], Stroke::Thin);
        for tick in self.ticks() {
            let y = self.y(tick, top, height);
            svg.line(&[(x, y), (right, y)], Stroke::Dashed);
            svg.text(Tenths::pixels(left - 6), y.plus(4), Anchor::End, &tick.to_string());
        }
    }
}
