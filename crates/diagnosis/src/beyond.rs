//! Motion that no permissible axis makes: too fast, or too sudden.

use std::ops::Range;

use encoring_texts::Said;

use crate::cause::JumpCause;
use crate::curve::Curve;
use crate::evidence;
use crate::scan::Find;
use crate::verdict::Judged;

/// The fewest rows from which a speed is taken.
const ROWS: usize = 4;
/// Rows in which a shaft gets to a speed that is too high, and back.
const ROWS_NEAR: usize = 100;
/// The most.
const ROWS_MAX: usize = 64;

/// The stretches of even rows that are faster, or change their speed faster, than is permissible.
pub(crate) fn stretches(curve: &Curve<'_>, jumps: &[Find]) -> Vec<Find> {
    let places = places(curve);
    let mut found = Vec::new();
    if !curve.axis.is_scale_known {
        return found;
    }
    too_fast(curve, &places, jumps, &mut found);
    too_sudden(curve, &places, jumps, &mut found);
    found
}

/// Where each point is, not wrapped.
fn places(curve: &Curve<'_>) -> Vec<i64> {
    let mut place = 0_i64;
    let step = |at: usize| curve.step(at).map_or(0, |step| step.way);
    (0..curve.points.len())
        .map(|at| {
            place = place.saturating_add(if at == 0 { 0 } else { step(at) });
            place
        })
        .collect()
}

fn is_free(range: &Range<usize>, jumps: &[Find]) -> bool {
    let apart = |find: &Find| {
        find.judged.cause == JumpCause::Wrap
            || find.judged.cause == JumpCause::Aliasing
            || find.points.end + range.len() < range.start
            || find.points.start > range.end + range.len()
    };
    jumps.iter().all(apart)
}

fn too_fast(curve: &Curve<'_>, places: &[i64], jumps: &[Find], found: &mut Vec<Find>) {
    let period = curve.period_ns.max(1);
    let rows = usize::try_from(curve.axis.refresh_ns * 20 / period).unwrap_or(ROWS_MAX).clamp(ROWS, ROWS_MAX);
    let mut stretch: Option<Range<usize>> = None;
    let mut most = 0;
    for at in rows..places.len() {
        let (Some(from), Some(to)) = (places.get(at - rows), places.get(at)) else { break };
        let span = curve.way(at - rows, at).map_or(0, |(_, span)| span);
        let doubt = curve.axis.refresh_ns + period / 5;
        let Some(travel) = curve.axis.travel(span + doubt) else { return };
        let way = (to - from).abs();
        if way > travel + 2 && are_fast(curve, at - rows..at) {
            most = most.max(
                curve
                    .axis
                    .travel(1_000_000_000)
                    .map_or(0, |_| crate::motion::scaled(way, 1_000_000_000, span)),
            );
            stretch = Some(stretch.map_or(at - rows..at + 1, |stretch| stretch.start..at + 1));
        } else if let Some(points) = stretch.take_if(|stretch| stretch.end + rows < at) {
            tell_fast(curve, points, most, jumps, found);
        }
    }
    if let Some(points) = stretch {
        tell_fast(curve, points, most, jumps, found);
    }
}

/// Whether most rows are near the limit or beyond, and not one of them alone.
fn are_fast(curve: &Curve<'_>, rows: Range<usize>) -> bool {
    let limit = curve.axis.travel(curve.period_ns).unwrap_or(i64::MAX);
    let mut steps: Vec<i64> =
        rows.filter_map(|at| Some(curve.step(at + 1)?.over(curve.period_ns).abs())).collect();
    steps.sort_unstable();
    let third = steps.get(steps.len() / 3).copied().unwrap_or_default();
    let most = steps.last().copied().unwrap_or_default();
    third >= limit / 10 * 9 && most <= third.saturating_mul(2)
}

fn tell_fast(curve: &Curve<'_>, points: Range<usize>, most: i64, jumps: &[Find], found: &mut Vec<Find>) {
    if !is_free(&points, jumps) {
        return;
    }
    let limit = curve.axis.travel(1_000_000_000).unwrap_or_default();
    let evidence = evidence::too_fast(most, points.len(), limit);
    let judged = Judged::likely(JumpCause::OverSpeed, evidence);
    found.push(Find { points, judged });
}

fn too_sudden(curve: &Curve<'_>, places: &[i64], jumps: &[Find], found: &mut Vec<Find>) {
    let Some(bend) = curve.axis.bend(curve.period_ns) else { return };
    let mut at = 0;
    while at < places.len() {
        match sudden_at(curve, places, at, bend) {
            Some(mut most) => {
                let far = most.points.end + most.points.len();
                for later in at + 1..far {
                    let other =
                        sudden_at(curve, places, later, bend).filter(|other| other.excess > most.excess);
                    most = other.unwrap_or(most);
                }
                at = far.max(most.points.end + most.points.len());
                let Sudden { points, evidence, is_far, .. } = most;
                let near = points.start.saturating_sub(ROWS_NEAR)..points.end + ROWS_NEAR;
                let follows =
                    found.iter().any(|find| find.points.start < near.end && near.start < find.points.end);
                if is_free(&points, jumps) && !follows {
                    let judged = if is_far {
                        Judged::likely(JumpCause::OverAcceleration, evidence)
                    } else {
                        Judged::possible(JumpCause::Unclear, evidence)
                            .or(&[JumpCause::OverAcceleration, JumpCause::Mechanical])
                    };
                    found.push(Find { points, judged });
                }
            }
            None => at += 1,
        }
    }
}

/// A change of speed that is too large.
struct Sudden {
    points: Range<usize>,
    evidence: Said,
    excess: i64,
    /// By far.
    is_far: bool,
}

/// Whether the speed around a point changes too fast, over as many rows as it takes to be sure.
fn sudden_at(curve: &Curve<'_>, places: &[i64], at: usize, bend: i64) -> Option<Sudden> {
    let speed = curve.step(at).map_or(0, |step| step.way).abs();
    let noise =
        crate::motion::scaled(speed, curve.axis.refresh_ns + curve.period_ns / 5, curve.period_ns) + 2;
    let mut rows = 1_usize;
    // Where the noise is a quarter of what the limit allows.
    while i64::try_from(rows * rows).ok()? * bend < 8 * noise && rows < ROWS_MAX {
        rows += 1;
    }
    // Of a step in the last row nobody knows whether it comes back.
    places.get(at + rows + 1)?;
    let [first, middle, last] = [at.checked_sub(rows)?, at, at + rows].map(|at| places.get(at).copied());
    let change = (last? - 2 * middle? + first?).abs();
    let may = bend * i64::try_from(rows * rows).ok()?;
    (change > 2 * may + 4 * noise).then(|| Sudden {
        points: at - rows..at + rows + 1,
        evidence: evidence::too_sudden(change, rows, may),
        excess: change - may,
        is_far: change > 4 * may + 8 * noise,
    })
}
