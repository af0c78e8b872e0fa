//! Stretches whose rows scatter, or repeat: noise, and the beat of log and refresh.

use std::ops::Range;

use encoring_host::validity::Circle;

use crate::axis::CYCLE_NS;
use crate::cause::JumpCause;
use crate::curve::{Curve, Point};
use crate::evidence;
use crate::motion::{scaled, way};
use crate::scan::Find;
use crate::verdict::Judged;

/// Rows that are looked at together.
const BLOCK: usize = 16;
/// Blocks of scatter in a row.
const BLOCKS: usize = 2;
/// How much larger second differences must be than in the quiet part.
const TIMES: i64 = 4;
/// The least scatter that is told, in steps.
const LEAST: i64 = 8;

/// The part of what a stamp is off that the even time follows.
const TRUST: i64 = 64;
/// How many times the usual a stamp must be off to be one that may be wrong by all of that.
const UNUSUAL: i64 = 4;
/// Second differences beyond it count no more.
const ROUGHEST: i64 = 1 << 12;

/// What a block shows.
#[derive(Clone, Copy)]
struct Block {
    /// The median of second differences.
    median: i64,
    /// The mean of the steps from row to row.
    step: i64,
    /// Whether each second difference takes back the one before.
    takes_back: bool,
    /// Rows with the value of the row before, while others go on.
    repeats: usize,
}

impl Block {
    /// Whether rows of other cycles of the bus than the next ones can scatter as much at this speed.
    fn is_timed(&self, curve: &Curve<'_>) -> bool {
        let way = scaled(self.step, curve.period_ns.min(CYCLE_NS), curve.period_ns);
        self.step > 0 && self.median <= way + way / 4
    }
}

fn blocks(curve: &Curve<'_>) -> Vec<Block> {
    let starts = (0..curve.points.len().saturating_sub(BLOCK)).step_by(BLOCK);
    starts.map(|start| block(curve, start)).collect()
}

fn block(curve: &Curve<'_>, start: usize) -> Block {
    let places = start.max(2)..start + BLOCK;
    let mut bends: Vec<i64> = places.clone().filter_map(|at| curve.off(at)).collect();
    let product = |a: i64, b: i64| i128::from(a) * i128::from(b);
    let own: i128 = bends.iter().map(|bend| product(*bend, *bend)).sum();
    let next: i128 =
        bends.windows(2).map(|two| two.iter().map(|bend| i128::from(*bend)).product::<i128>()).sum();
    let steps: Vec<i64> = places.filter_map(|at| Some(curve.step(at)?.way)).collect();
    let step = steps.iter().sum::<i64>() / i64::try_from(steps.len().max(1)).unwrap_or(1);
    let repeats = steps.windows(2).filter(|two| matches!(two, [0, next] if next.abs() > 2)).count();
    bends.iter_mut().for_each(|bend| *bend = bend.abs());
    let middle = bends.len() / 2;
    let median = if bends.is_empty() { 0 } else { *bends.select_nth_unstable(middle).1 };
    Block { median, step: step.abs(), takes_back: next * 10 < -3 * own, repeats }
}

/// The noise of quiet rows: the lower quarter of the blocks.
fn quiet(blocks: &[Block]) -> i64 {
    let mut medians: Vec<i64> = blocks.iter().map(|block| block.median).collect();
    let quarter = medians.len() / 4;
    if medians.is_empty() { 0 } else { *medians.select_nth_unstable(quarter).1 }
}

/// The stretches of a curve that scatter or repeat.
pub(crate) fn stretches(curve: &Curve<'_>, fast: bool) -> Vec<Find> {
    let blocks = blocks(curve);
    let quiet = quiet(&blocks);
    let mut found = Vec::new();
    let is_noisy = |block: &Block| {
        block.takes_back
            && block.median >= LEAST.max(TIMES * (quiet + 1))
            && block.median * 3 > block.step
            && block.repeats < BLOCK / 5
    };
    let moving = blocks.iter().filter(|block| block.is_timed(curve)).count();
    let scattering = blocks.iter().filter(|block| block.is_timed(curve) && is_noisy(block)).count();
    runs(&blocks, is_noisy, BLOCKS, |range| {
        let inner = blocks.get(range.clone()).unwrap_or_default();
        let is_timed = inner.iter().any(|block| block.is_timed(curve));
        // Where most rows in motion scatter, they do for it.
        if is_timed && scattering * 2 > moving {
            return;
        }
        let median = inner.iter().map(|block| block.median).max();
        let motion = inner.iter().map(|block| block.step).max().and_then(|step| curve.utmost(step));
        let is_moved = motion.is_some_and(|[_, strong]| median.unwrap_or_default() <= strong);
        let evidence = evidence::scatter(median.unwrap_or_default(), quiet);
        let judged = match held(curve, &range, median.unwrap_or_default()) {
            Some(bit) => Judged::possible(JumpCause::Unclear, evidence)
                .since(evidence::held(bit))
                .or(&[JumpCause::StuckBit, JumpCause::Noise]),
            None if is_timed || is_moved => Judged::possible(JumpCause::Unclear, evidence).or(&[
                JumpCause::Noise,
                JumpCause::Aliasing,
                JumpCause::Mechanical,
            ]),
            None => Judged::likely(JumpCause::Noise, evidence),
        };
        found.push(Find { points: edges(curve, range, quiet), judged });
    });
    if fast {
        runs(
            &blocks,
            |block| block.repeats * 5 >= BLOCK && block.step > 0,
            BLOCKS,
            |range| {
                let points = range.start * BLOCK..range.end * BLOCK;
                let judged = Judged::likely(JumpCause::Aliasing, evidence::beat());
                found.push(Find { points, judged });
            },
        );
    }
    found.sort_by_key(|find| find.points.start);
    found
}

fn runs(blocks: &[Block], is: impl Fn(&Block) -> bool, least: usize, mut tell: impl FnMut(Range<usize>)) {
    let mut at = 0;
    for run in blocks.chunk_by(|a, b| is(a) == is(b)) {
        let range = at..at + run.len();
        at = range.end;
        if range.len() >= least && run.first().is_some_and(&is) {
            tell(range);
        }
    }
}

/// A bit that scatter of this size would change, and that is the same in every row.
fn held(curve: &Curve<'_>, blocks: &Range<usize>, median: i64) -> Option<u32> {
    // The first and the last block may begin before and end behind.
    let points = curve.points.get(blocks.start * BLOCK + BLOCK / 2..blocks.end * BLOCK - BLOCK / 2)?;
    let ones = points.iter().fold(-1_i64, |ones, point| ones & point.value);
    let zeros = points.iter().fold(-1_i64, |zeros, point| zeros & !point.value);
    (0..24).find(|bit| {
        let worth = 1_i64 << bit;
        (ones | zeros) & worth != 0 && worth <= 2 * median && worth * 16 >= median
    })
}

/// The points of blocks, with those beside them that scatter too.
fn edges(curve: &Curve<'_>, blocks: Range<usize>, quiet: i64) -> Range<usize> {
    let rough = |at: &usize| curve.off(*at).is_some_and(|off| off.abs() > LEAST.max(TIMES * (quiet + 1)));
    let (first, last) = (blocks.start * BLOCK, blocks.end * BLOCK);
    let from = (first.saturating_sub(BLOCK)..first).find(rough).unwrap_or(first);
    let to = (last..(last + BLOCK).min(curve.points.len())).rev().find(rough).map_or(last, |at| at + 1);
    from.saturating_sub(1)..to.min(curve.points.len())
}

/// The times of points as if they had been taken evenly, where the stamps are coarser than the rows or scatter more than the
/// positions; and the period.
pub(crate) fn period(points: &[Point]) -> i64 {
    let mut spans: Vec<i64> =
        points.windows(2).filter_map(|two| Some(two.get(1)?.time_ns - two.first()?.time_ns)).collect();
    spans.retain(|span| *span >= 0);
    let mut positive: Vec<i64> = spans.iter().copied().filter(|span| *span > 0).collect();
    if positive.is_empty() {
        return 1;
    }
    let middle = positive.len() / 2;
    let median = *positive.select_nth_unstable(middle).1;
    let usual: Vec<i64> = spans.into_iter().filter(|span| *span <= median + median * 3 / 4).collect();
    let count = i64::try_from(usual.len().max(1)).unwrap_or(1);
    (usual.iter().map(|span| i128::from(*span)).sum::<i128>() / i128::from(count))
        .try_into()
        .unwrap_or(median)
        .max(1)
}

/// Takes the times of a run as even where that makes it smoother: stamps can be coarser than the rows, and later than them.
pub(crate) fn even_times(points: &mut [Point], circle: Circle, period: i64) {
    let Some(first) = points.first().map(|point| point.time_ns) else { return };
    if points.windows(2).all(|two| matches!(two, [a, b] if b.time_ns - a.time_ns == period)) {
        return;
    }
    let mut even = first;
    let mut evened = points.to_vec();
    let mut offs = vec![0];
    for point in evened.iter_mut().skip(1) {
        let stamp = point.time_ns;
        let rows = ((stamp - even).saturating_add(period / 2) / period).max(1);
        even = even.saturating_add(rows.saturating_mul(period));
        let off = stamp - even;
        offs.push(off.abs());
        even = if off.abs() * 4 > period * 3 { stamp } else { even + scaled(off, 1, TRUST) };
        point.time_ns = even;
    }
    if roughness(&evened, circle) < roughness(points, circle) {
        points.copy_from_slice(&evened);
    }
    let mut sorted = offs.clone();
    let usual = *sorted.select_nth_unstable(offs.len() / 2).1;
    for (point, off) in points.iter_mut().zip(offs).filter(|(_, off)| *off > UNUSUAL * usual) {
        point.late_ns = off;
    }
}

/// The sum of second differences, of which jumps are a small part.
fn roughness(points: &[Point], circle: Circle) -> i64 {
    let bend = |three: &[Point]| match three {
        [a, b, c] => {
            let straight =
                scaled(way(circle, a.value, b.value), c.time_ns - b.time_ns, b.time_ns - a.time_ns);
            (way(circle, b.value, c.value) - straight).abs().min(ROUGHEST)
        }
        _ => 0,
    };
    points.windows(3).map(bend).sum()
}
