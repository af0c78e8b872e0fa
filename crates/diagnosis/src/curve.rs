//! Positions over time, and what motion can do between them.

use encoring_host::validity::Circle;

use crate::axis::Axis;
use crate::motion::{FARTHEST, scaled};
use crate::row::Row;

/// No jump is looked at that has fewer steps.
pub(crate) const LEAST: i64 = 5;

/// A position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Its place among the rows.
    pub(crate) row: usize,
    pub(crate) time_ns: i64,
    pub(crate) value: i64,
}

/// Points without a gap, and what is known of their motion.
#[derive(Clone, Copy)]
pub(crate) struct Curve<'a> {
    pub(crate) points: &'a [Point],
    pub(crate) rows: &'a [Row],
    pub(crate) circle: Circle,
    pub(crate) axis: &'a Axis,
    /// From row to row, usually.
    pub(crate) period_ns: i64,
    /// Second differences up to here are motion.
    pub(crate) tolerance: i64,
}

/// A mean speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Speed {
    pub(crate) way: i64,
    pub(crate) span_ns: i64,
    /// From how many rows.
    pub(crate) rows: usize,
}

impl Speed {
    /// The way in this time.
    pub(crate) fn over(self, span_ns: i64) -> i64 {
        scaled(self.way, span_ns, self.span_ns)
    }
}

impl Curve<'_> {
    pub(crate) fn value(&self, at: usize) -> Option<i64> {
        self.points.get(at).map(|point| point.value)
    }

    pub(crate) fn row(&self, at: usize) -> Option<&Row> {
        self.rows.get(self.points.get(at)?.row)
    }

    /// The way from one point to another, and its time.
    pub(crate) fn way(&self, from: usize, to: usize) -> Option<(i64, i64)> {
        let (from, to) = (self.points.get(from)?, self.points.get(to)?);
        Some((self.circle.way(from.value, to.value), to.time_ns - from.time_ns))
    }

    /// The speed between two points that follow each other.
    pub(crate) fn step(&self, to: usize) -> Option<Speed> {
        let (way, span_ns) = self.way(to.checked_sub(1)?, to)?;
        Some(Speed { way, span_ns, rows: 1 })
    }

    /// How far a point lies from where the two before it lead.
    pub(crate) fn off(&self, at: usize) -> Option<i64> {
        let before = self.step(at.checked_sub(1)?)?;
        let (way, span) = self.way(at - 1, at)?;
        Some(way.saturating_sub(before.over(span)))
    }

    /// What motion may add within a time.
    pub(crate) fn may(&self, span_ns: i64) -> i64 {
        let times = span_ns.saturating_add(self.period_ns / 2) / self.period_ns.max(1);
        (self.tolerance * times.clamp(1, 16) * times.clamp(1, 16)).min(FARTHEST)
    }

    pub(crate) fn fits(&self, at: usize) -> bool {
        let span = self.step(at).map_or(0, |step| step.span_ns);
        self.off(at).is_none_or(|off| off.abs() <= self.may(span))
    }

    /// How near a point must lie to a place that it is said to be at.
    pub(crate) fn near(&self) -> i64 {
        (self.tolerance / 3).max(3)
    }

    /// What motion within the permissible may add from one row to the next, beside the speed before and behind: `None`
    /// without a limit.
    pub(crate) fn utmost(&self, speed: i64) -> Option<i64> {
        let bend = self.axis.bend(self.period_ns.saturating_add(self.axis.refresh_ns))?;
        let late = scaled(speed.abs(), self.axis.refresh_ns + self.period_ns / 5, self.period_ns);
        let most = (bend / 4).saturating_mul(3).saturating_add(late).saturating_add(2);
        Some(self.axis.travel(self.period_ns).map_or(most, |travel| most.min(travel.saturating_mul(2))))
    }

    /// The mean speed of up to so many rows that end at a point, as far as they are even.
    pub(crate) fn speed_before(&self, at: usize, rows: usize, not_before: usize) -> Option<Speed> {
        let mut first = at;
        while first > not_before && at - first < rows && (at - first < 2 || self.fits(first + 1)) {
            first -= 1;
        }
        self.mean(first, at)
    }

    /// The mean speed of up to so many rows that begin at a point, as far as they are even.
    pub(crate) fn speed_after(&self, at: usize, rows: usize) -> Option<Speed> {
        let mut last = at;
        while last + 1 < self.points.len() && last - at < rows && (last < at + 1 || self.fits(last + 1)) {
            last += 1;
        }
        self.mean(at, last)
    }

    /// The mean speed from one point to another, however far that is.
    fn mean(&self, first: usize, last: usize) -> Option<Speed> {
        let mut way = 0_i64;
        for to in first + 1..=last {
            way = way.saturating_add(self.step(to)?.way);
        }
        let span_ns = self.points.get(last)?.time_ns - self.points.get(first)?.time_ns;
        (last > first).then_some(Speed { way, span_ns, rows: last - first })
    }

    /// Where a point should be that lies between two others.
    pub(crate) fn between(&self, before: usize, back: usize, place: usize) -> Option<i64> {
        let (way, took) = self.way(before, back)?;
        let (_, span) = self.way(before, place)?;
        Some(self.circle.moved(self.value(before)?, scaled(way, span, took)))
    }
}

/// What second differences motion makes: three times the one with so many larger ones.
pub(crate) fn threshold(mut bends: Vec<i64>, outliers: usize) -> i64 {
    // One wrong row makes three large differences.
    let rank = outliers.min(bends.len() * 3 / 5);
    if bends.is_empty() {
        return LEAST;
    }
    let (_, ranked, _) = bends.select_nth_unstable_by(rank, |a, b| b.cmp(a));
    ranked.saturating_mul(3).clamp(LEAST, FARTHEST)
}
