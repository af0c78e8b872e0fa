//! Places that somebody knows: a zero that was lost fits one of them before a pause and none behind it.

use std::ops::Range;

use encoring_words::Duration;

use crate::cause::JumpCause;
use crate::curve::Point;
use crate::evidence;
use crate::motion::way;
use crate::options::KnownPlace;
use crate::part::Part;
use crate::verdict::Judged;

/// Pauses that are remembered.
const PAUSES: usize = 256;
/// The farthest row from a known time that shows the place at that time.
const NEAR_NS: i64 = 1_000_000_000;
const NEAR_ROWS: i64 = 4;
/// How far from a known place a position may be, in steps.
const KNOWN_NEAR: i64 = 8;

/// What is known, and what was seen of it.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    /// Those that were not compared yet, in order of time.
    known: Vec<KnownPlace>,
    /// The last that was, with how far off it is.
    last: Option<(KnownPlace, i64)>,
    /// The time and the line behind it, and how long it was.
    pauses: Vec<(i64, u64, i64)>,
    /// Those near which no row is.
    missed: Vec<KnownPlace>,
}

impl Places {
    /// Whether every place was compared that is known.
    pub(crate) const fn are_told(&self) -> bool {
        self.known.is_empty()
    }

    pub(crate) fn new(known: &[KnownPlace]) -> Self {
        Self { known: known.to_vec(), last: None, pauses: Vec::new(), missed: Vec::new() }
    }

    /// Places that could not be compared: those near which no row is, and those that no row came for.
    pub(crate) fn missed(&self) -> impl Iterator<Item = &KnownPlace> {
        self.missed.iter().chain(&self.known)
    }

    /// What places that somebody knows say: a place that fits before a gap and none behind it.
    pub(crate) fn look(&mut self, part: &Part<'_>, is_last: bool, finds: &mut Vec<(Range<usize>, Judged)>) {
        let Part { rows, points, circle, .. } = *part;
        self.remember_pauses(part);
        while let Some(known) = self.known.first().copied() {
            let time_ns = i64::try_from(known.time_ns).unwrap_or(i64::MAX);
            let behind = points.partition_point(|point| point.time_ns < time_ns);
            if behind == points.len() && !is_last {
                break;
            }
            let off = |at: &usize| points.get(*at).map_or(u64::MAX, |point| point.time_ns.abs_diff(time_ns));
            let Some(at) = [behind.saturating_sub(1), behind].into_iter().min_by_key(off) else { break };
            let Some(point) = points.get(at).copied() else { break };
            if point.row >= part.range.end {
                break;
            }
            self.known.remove(0);
            let near = NEAR_NS.max(part.period_ns.saturating_mul(NEAR_ROWS)).unsigned_abs();
            if point.time_ns.abs_diff(time_ns) > near {
                self.missed.push(known);
                continue;
            }
            let off = way(circle, known.steps, point.value);
            let was = self.last.replace((known, off));
            let Some((before, was_off)) = was else { continue };
            let apart = way(circle, was_off, off);
            if apart.saturating_abs() <= KNOWN_NEAR + most_step(part, at) {
                continue;
            }
            let evidence = evidence::from_known(apart.saturating_abs());
            let between = before.time_ns.cast_signed()..=known.time_ns.cast_signed();
            let pause = self
                .pauses
                .iter()
                .filter(|pause| between.contains(&pause.0))
                .max_by_key(|pause| pause.2)
                .copied();
            let (line, judged) = match pause {
                Some((_, line, span)) => (
                    line,
                    Judged::likely(JumpCause::ZeroLost, evidence)
                        .since(evidence::pause(Duration(span.unsigned_abs()))),
                ),
                None => (
                    rows.get(point.row).map_or(0, |row| row.line),
                    Judged::possible(JumpCause::Unclear, evidence).or(&[
                        JumpCause::ZeroLost,
                        JumpCause::Mechanical,
                        JumpCause::Preset,
                    ]),
                ),
            };
            let row = rows.partition_point(|row| row.line < line);
            finds.push((row..row + 1, judged));
        }
    }

    /// Pauses of the recording: the time, the line behind it, and how long it was.
    fn remember_pauses(&mut self, part: &Part<'_>) {
        for two in part.points.windows(2) {
            let [before, behind] = two else { continue };
            let span = behind.time_ns - before.time_ns;
            if part.range.contains(&behind.row) && span * 4 > part.period_ns * 7 {
                let line = part.rows.get(behind.row).map_or(0, |row| row.line);
                self.pauses.push((behind.time_ns, line, span));
            }
        }
        // The longest stay.
        if self.pauses.len() > PAUSES {
            self.pauses.sort_unstable_by_key(|pause| core::cmp::Reverse(pause.2));
            self.pauses.truncate(PAUSES);
        }
    }
}

/// Twice the steps from row to row at a point, on the side where there are fewer.
fn most_step(part: &Part<'_>, at: usize) -> i64 {
    let around = part.points.get(at.saturating_sub(1)..(at + 2).min(part.points.len())).unwrap_or_default();
    let step = |two: &[Point]| match two {
        [a, b] => way(part.circle, a.value, b.value).abs(),
        _ => 0,
    };
    around.windows(2).map(step).min().unwrap_or_default() * 2
}
