//! What second differences the motion of an axis makes.
//!
//! An axis that takes several rows to change its speed makes second differences of one sign, one after the other. A fault, and
//! the end of the range before it is known, makes one and takes it back in the next. So what is taken back counts only as far
//! as whole blocks of rows show it; but an axis that moves from stand to stand within a row is believed.
//!
//! A row whose word is older or newer than its time says makes second differences too, which the next takes back and which
//! grow with the speed. How many nanoseconds that is is learned for itself.

use encoring_host::validity::Circle;

use crate::axis::CYCLE_NS;
use crate::curve::{LEAST, Point};
use crate::motion::{FARTHEST, scaled, way};

/// Second differences that may be anything: those of jumps.
const OUTLIERS: usize = 31;
/// Those of ramps that may be anything.
const STRAY: usize = 8;
/// Those of rows at a wrong time that may be anything.
const UNTIMELY: usize = 6;
/// Of so many rows one may be an outlier, where there are few.
const ONE_OF: usize = 8;
/// Rows whose noise is looked at together, and how much larger than its median the largest noise is.
const BLOCK: usize = 16;
const SPREAD: i64 = 8;
/// A second difference of even motion, in whole steps.
const ROUNDING: i64 = 2;
/// Of so many rows in motion, one that moves from stand to stand makes an axis that does that.
const JOGS: usize = 4;

/// The largest second differences so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bends {
    all: Vec<i64>,
    /// Those that the next one does not take back.
    ramps: Vec<i64>,
    /// What times make them that are wrong by this.
    late: Vec<i64>,
}

/// What is usual in rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Usual {
    /// Second differences that motion makes.
    pub(crate) tolerance: i64,
    /// The error of a second difference's times.
    pub(crate) late_ns: i64,
}

/// Of one row.
#[derive(Clone, Copy)]
struct Bend {
    row: usize,
    /// From the row before.
    span_ns: i64,
    before: i64,
    after: i64,
    /// What `after` is more than `before`, over equal times.
    more: i64,
}

impl Bends {
    /// What is usual among these points; those of the rows of `counted` are remembered for later ones.
    pub(crate) fn usual(
        &mut self,
        points: &[Point],
        circle: Circle,
        longest_ns: i64,
        counted: impl Fn(usize) -> bool,
    ) -> Usual {
        let bends: Vec<Bend> =
            points.windows(3).filter_map(|three| bend(three, circle, longest_ns)).collect();
        let all = || bends.iter().map(|bend| bend.more.abs());
        let ramps = || bends.windows(2).map(ramp).chain([0]);
        let wide = ranked(all().collect(), OUTLIERS).max(ranked(self.all.clone(), OUTLIERS));
        let even = ranked(ramps().collect(), STRAY).max(ranked(self.ramps.clone(), STRAY));
        let late = || bends.windows(2).map(late).chain([0]);
        let late_ns = ranked(late().collect(), UNTIMELY).max(ranked(self.late.clone(), UNTIMELY));
        let is_counted = |(bend, _): &(&Bend, i64)| counted(bend.row);
        remember(&mut self.all, bends.iter().zip(all()).filter(is_counted).map(|(_, more)| more));
        remember(&mut self.ramps, bends.iter().zip(ramps()).filter(is_counted).map(|(_, more)| more));
        remember(&mut self.late, bends.iter().zip(late()).filter(is_counted).map(|(_, late)| late));
        let wide = wide.saturating_mul(3);
        let tight = even.saturating_mul(3).max(noise(&bends).saturating_mul(SPREAD));
        let tolerance = if jogs(&bends) { wide } else { wide.min(tight) }.clamp(LEAST, FARTHEST);
        Usual { tolerance, late_ns }
    }
}

fn remember(largest: &mut Vec<i64>, more: impl Iterator<Item = i64>) {
    largest.extend(more);
    largest.sort_unstable_by(|a, b| b.cmp(a));
    largest.truncate(OUTLIERS + 1);
}

fn bend(three: &[Point], circle: Circle, longest_ns: i64) -> Option<Bend> {
    let [a, b, c] = three else { return None };
    let (first, second) = (b.time_ns - a.time_ns, c.time_ns - b.time_ns);
    if first > longest_ns || second > longest_ns {
        return None;
    }
    let (before, after) = (way(circle, a.value, b.value), way(circle, b.value, c.value));
    let before = scaled(before, second, first);
    Some(Bend { row: c.row, span_ns: second, before, after, more: after - before })
}

/// The error of the times that makes a second difference which the next takes back; 0 if none can.
fn late(two: &[Bend]) -> i64 {
    let [a, b] = two else { return 0 };
    // A wrong time makes no way backwards.
    let is_forth = a.before.signum() * b.after.signum() > 0 && a.after.signum() * a.before.signum() >= 0;
    let steps = a.more.abs().min(b.more.abs()) - ROUNDING;
    if a.more.signum() == b.more.signum() || !is_forth || steps <= 0 {
        return 0;
    }
    let late_ns = scaled(steps, a.span_ns, a.before.abs().max(b.after.abs()));
    if late_ns <= 2 * a.span_ns.min(CYCLE_NS) { late_ns } else { 0 }
}

/// As much of a second difference as the next does not take back.
fn ramp(two: &[Bend]) -> i64 {
    match two {
        [a, b] if a.more.signum() == b.more.signum() => a.more.abs().min(b.more.abs()),
        _ => 0,
    }
}

/// The one with so many larger ones.
fn ranked(mut bends: Vec<i64>, outliers: usize) -> i64 {
    // One wrong row makes three large differences.
    let rank = outliers.min((bends.len() / ONE_OF).max(3)).min(bends.len() * 3 / 5);
    if bends.is_empty() {
        return 0;
    }
    *bends.select_nth_unstable_by(rank, |a, b| b.cmp(a)).1
}

/// The median of the noisiest block but one.
fn noise(bends: &[Bend]) -> i64 {
    let median = |block: &[Bend]| {
        let mut more: Vec<i64> = block.iter().map(|bend| bend.more.abs()).collect();
        let middle = more.len() / 2;
        *more.select_nth_unstable(middle).1
    };
    let mut medians: Vec<i64> = bends.chunks(BLOCK).map(median).collect();
    medians.sort_unstable_by(|a, b| b.cmp(a));
    medians.get(1).or(medians.first()).copied().unwrap_or_default()
}

/// Whether the axis moves from stand to stand within a row.
fn jogs(bends: &[Bend]) -> bool {
    let is_jog =
        |two: &[Bend]| matches!(two, [a, b] if a.before == 0 && b.after == 0 && a.after.abs() > LEAST);
    let jogs = bends.windows(2).filter(|two| is_jog(two)).count();
    let moving = bends.iter().filter(|bend| bend.before != 0 && bend.after != 0).count();
    jogs * JOGS > moving
}
