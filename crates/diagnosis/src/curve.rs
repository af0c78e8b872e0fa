//! Positions over time, and what motion can do between them.

use encoring_host::validity::Circle;

use crate::axis::Axis;
use crate::motion::{FARTHEST, scaled, way};
use crate::row::Row;

/// No jump is looked at that has fewer steps.
pub(crate) const LEAST: i64 = 5;

/// Rows from which the speed beside a jump is taken, at least and at most.
const SPEED_ROWS: [usize; 6] = [4, 8, 16, 32, 64, 108];
/// A speed is known well enough from so many steps, and so many refresh times.
const SURE_STEPS: i64 = 64;
const SURE_REFRESHES: i64 = 12;

/// A position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Its place among the rows.
    pub(crate) row: usize,
    pub(crate) time_ns: i64,
    pub(crate) value: i64,
    /// How far its stamp lies from an even time, if that is unusual.
    pub(crate) late_ns: i64,
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
    /// How much later or earlier than the others a row may be.
    pub(crate) late_ns: i64,
}

/// A mean speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Speed {
    pub(crate) way: i64,
    pub(crate) span_ns: i64,
    /// By how many steps one half of the way differs from the other.
    pub(crate) uneven: i64,
    /// From how many rows.
    pub(crate) rows: usize,
}

impl Speed {
    /// The way in this time.
    pub(crate) fn over(self, span_ns: i64) -> i64 {
        scaled(self.way, span_ns, self.span_ns)
    }

    /// By how many steps [`Speed::over`] may be wrong: rounding, and what the speed changed meanwhile.
    pub(crate) fn doubt(self, span_ns: i64) -> i64 {
        scaled(2 * self.uneven + 4, span_ns, self.span_ns).abs() + 1
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
        Some((way(self.circle, from.value, to.value), to.time_ns - from.time_ns))
    }

    /// The speed between two points that follow each other.
    pub(crate) fn step(&self, to: usize) -> Option<Speed> {
        let (way, span_ns) = self.way(to.checked_sub(1)?, to)?;
        Some(Speed { way, span_ns, uneven: 0, rows: 1 })
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
        self.off(at).is_none_or(|off| off.abs() <= self.may_at(at))
    }

    /// What motion may add at a point, and the times of the rows that lead to it.
    pub(crate) fn may_at(&self, at: usize) -> i64 {
        let span = self.step(at).map_or(0, |step| step.span_ns);
        self.may(span).saturating_add(self.untimely(at)).min(FARTHEST)
    }

    /// Steps that are made of times which are wrong: those of a point and the two before it.
    pub(crate) fn untimely(&self, at: usize) -> i64 {
        let late =
            |back: usize| at.checked_sub(back).and_then(|at| self.points.get(at)).map_or(0, |at| at.late_ns);
        let late_ns =
            self.late_ns.saturating_add(late(0)).saturating_add(2 * late(1)).saturating_add(late(2));
        let speed =
            |at: Option<usize>| at.and_then(|at| self.step(at)).map_or(0, |step| step.over(late_ns).abs());
        speed(Some(at)).max(speed(at.checked_sub(1)))
    }

    /// How near a point must lie to a place that it is said to be at.
    pub(crate) fn near(&self) -> i64 {
        (self.tolerance / 3).max(3)
    }

    /// What motion may add from one row to the next, see [`Axis::utmost`].
    pub(crate) fn utmost(&self, speed: i64) -> Option<[i64; 2]> {
        self.axis.utmost(self.period_ns, speed)
    }

    /// The mean speed of up to so many rows that end at a point, as far as they are even.
    pub(crate) fn speed_before(&self, at: usize, rows: usize, not_before: usize) -> Option<Speed> {
        let mut first = at;
        while first > not_before && at - first < rows && (at - first < 2 || self.fits(first + 1)) {
            first -= 1;
        }
        self.mean(first, at)
    }

    /// The speed just before a point: of as few rows as it takes to be sure of it.
    pub(crate) fn just_before(&self, at: usize, not_before: usize) -> Option<Speed> {
        self.nearest(|rows| self.speed_before(at, rows, not_before))
    }

    /// The speed just behind a point.
    pub(crate) fn just_after(&self, at: usize) -> Option<Speed> {
        self.nearest(|rows| self.speed_after(at, rows))
    }

    fn nearest(&self, speed: impl Fn(usize) -> Option<Speed>) -> Option<Speed> {
        let is_enough = |speed: &Speed| {
            speed.way.abs() >= SURE_STEPS && speed.span_ns >= SURE_REFRESHES * self.axis.refresh_ns
        };
        let mut found = None;
        for rows in SPEED_ROWS {
            found = speed(rows);
            if found.is_none_or(|found| found.rows < rows || is_enough(&found)) {
                break;
            }
        }
        found
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
        let (middle, mut half, mut way) = (first + (last - first) / 2, 0, 0_i64);
        for to in first + 1..=last {
            way = way.saturating_add(self.step(to)?.way);
            half = if to == middle { way } else { half };
        }
        let [from, between, to] = [first, middle, last].map(|at| self.points.get(at).map(|at| at.time_ns));
        let span_ns = to? - from?;
        let uneven = if middle > first { (scaled(half, span_ns, between? - from?) - way).abs() } else { 0 };
        (last > first).then_some(Speed { way, span_ns, uneven, rows: last - first })
    }

    /// Where a point should be that lies between two others.
    pub(crate) fn between(&self, before: usize, back: usize, place: usize) -> Option<i64> {
        let (way, took) = self.way(before, back)?;
        let (_, span) = self.way(before, place)?;
        Some(self.circle.moved(self.value(before)?, scaled(way, span, took)))
    }
}
