//! Jumps among positions: what does not follow from the rows before and behind it.

use std::ops::Range;

use encoring_words::word::DATA_MAX;

use crate::cause::{JumpCause, Likelihood};
use crate::episode::Episode;
use crate::motion::{Circle, scaled};
use crate::row::Row;

/// Second differences that may be anything: those of jumps.
const OUTLIERS: usize = 31;
/// No threshold is lower, in steps.
const LEAST: i64 = 5;
/// Rows after which a position that left is no longer looked for.
const AWAY_MAX: usize = 64;

/// A position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Its place among the rows.
    pub(crate) index: usize,
    pub(crate) time_ns: i64,
    pub(crate) value: i64,
}

/// What is known of the positions so far.
#[derive(Clone, Debug)]
pub(crate) struct Jumps {
    circle: Circle,
    most: i64,
}

impl Default for Jumps {
    fn default() -> Self {
        Self { circle: Circle { positions: i64::from(DATA_MAX) + 1 }, most: 0 }
    }
}

/// A run of points, and what motion can do in it.
struct Run<'a> {
    points: &'a [Point],
    rows: &'a [Row],
    circle: Circle,
    tolerance: i64,
    position: u8,
}

/// How a point that does not fit goes on.
enum Ending {
    /// The speed changed, and nothing else.
    Speed,
    /// The positions are back at this point.
    Back(usize),
    /// They stay away.
    Away,
}

impl Jumps {
    /// Looks at the points of rows `range`; the others are there to see how it goes on. Returns the row up to which all is
    /// judged.
    pub(crate) fn judge(
        &mut self,
        points: &[Point],
        range: Range<usize>,
        rows: &[Row],
        position: u8,
        found: &mut Vec<Episode>,
    ) -> usize {
        self.most = points.iter().map(|point| point.value).fold(self.most, i64::max);
        let tolerance = threshold(points, self.circle);
        let mut run = Run { points, rows, circle: self.circle, tolerance, position };
        let first = points.partition_point(|point| point.index < range.start).max(2);
        let end = points.partition_point(|point| point.index < range.end);
        let mut at = first;
        while at < end {
            if run.fits(at) {
                if run.goes_round(at) {
                    found.push(run.wrap(at, run.circle.positions));
                }
                at += 1;
                continue;
            }
            if let Some(positions) = run.wraps(at, self.most) {
                self.circle = Circle { positions };
                run.circle = self.circle;
                found.push(run.wrap(at, positions));
                at += 1;
                continue;
            }
            match run.ending(at) {
                Ending::Speed => at += 1,
                Ending::Back(back) => {
                    found.push(run.returning(at, back));
                    at = back + 2;
                }
                Ending::Away => {
                    found.push(run.episode(at, at + 1, JumpCause::Unclear, Likelihood::Possible));
                    at += 3;
                }
            }
        }
        points.get(at.wrapping_sub(1)).map_or(range.end, |point| range.end.max(point.index + 1))
    }
}

/// What second differences motion makes.
fn threshold(points: &[Point], circle: Circle) -> i64 {
    let mut seconds: Vec<i64> = points
        .windows(3)
        .filter_map(|three| match three {
            [a, b, c] => {
                let (before, after) = (b.time_ns - a.time_ns, c.time_ns - b.time_ns);
                let way = scaled(circle.way(a.value, b.value), after, before);
                Some((circle.way(b.value, c.value) - way).abs())
            }
            _ => None,
        })
        .collect();
    let rank = OUTLIERS.min(seconds.len() / 4);
    if seconds.is_empty() {
        return LEAST;
    }
    let (_, ranked, _) = seconds.select_nth_unstable_by(rank, |a, b| b.cmp(a));
    ranked.saturating_mul(3).max(LEAST)
}

impl Run<'_> {
    fn value(&self, at: usize) -> Option<i64> {
        self.points.get(at).map(|point| point.value)
    }

    /// The way from one point to another, and its time.
    fn way(&self, from: usize, to: usize) -> Option<(i64, i64)> {
        let (from, to) = (self.points.get(from)?, self.points.get(to)?);
        Some((self.circle.way(from.value, to.value), to.time_ns - from.time_ns))
    }

    /// How far a point lies from where the two before lead.
    fn off(&self, at: usize) -> Option<i64> {
        let (before, took) = self.way(at.checked_sub(2)?, at - 1)?;
        let (way, span) = self.way(at - 1, at)?;
        Some(way - scaled(before, span, took))
    }

    fn fits(&self, at: usize) -> bool {
        self.off(at).is_none_or(|off| off.abs() <= self.tolerance)
    }

    /// Whether the shorter way leads over the end of the range.
    fn goes_round(&self, at: usize) -> bool {
        let Some((way, _)) = self.way(at - 1, at) else { return false };
        let (Some(from), Some(to)) = (self.value(at - 1), self.value(at)) else { return false };
        to - from != way
    }

    /// How many positions there are, if they begin again here.
    fn wraps(&self, at: usize, most: i64) -> Option<i64> {
        let (speed, _) = self.way(at.checked_sub(2)?, at - 1)?;
        let (after, _) = self.way(at, at + 1)?;
        let (from, to) = (self.value(at - 1)?, self.value(at)?);
        let near = speed.abs().max(after.abs()) + self.tolerance;
        let ends =
            if speed > 0 { to < near && from + near >= most } else { from < near && to + near >= most };
        let goes_on = (after - speed).abs() <= self.tolerance && speed != 0;
        let positions = if speed > 0 { from - to + speed } else { to - from - speed };
        (ends && goes_on && positions > most && positions > 2 * near).then_some(positions)
    }

    fn ending(&self, at: usize) -> Ending {
        let before = self.way(at - 2, at - 1);
        let (Some((before, took)), Some((way, span))) = (before, self.way(at - 1, at)) else {
            return Ending::Away;
        };
        let before = scaled(before, span, took);
        if let Some((after, time)) = self.way(at, at + 1) {
            let after = scaled(after, span, time);
            let within = before.min(after) - self.tolerance..=before.max(after) + self.tolerance;
            if within.contains(&way) {
                return Ending::Speed;
            }
        }
        let back = (at + 1..=at + AWAY_MAX).find(|back| self.is_back(at, *back));
        back.map_or(Ending::Away, Ending::Back)
    }

    /// Whether the points from `back` on go on from those before `at`.
    fn is_back(&self, at: usize, back: usize) -> bool {
        let ways = (self.way(at - 2, at - 1), self.way(at - 1, back), self.way(back, back + 1));
        let (Some((before, took)), Some((way, span)), Some((after, time))) = ways else { return false };
        let mean = (scaled(before, span, took) + scaled(after, span, time)) / 2;
        let rows = i64::try_from(back - at + 1).unwrap_or(i64::MAX);
        let may = self.tolerance * rows;
        (way - mean).abs() <= may && self.off(at).is_some_and(|off| off.abs() > 2 * may)
    }

    /// Where a point between the one before `at` and `back` should be.
    fn between(&self, at: usize, back: usize, place: usize) -> Option<i64> {
        let (way, took) = self.way(at - 1, back)?;
        let (_, span) = self.way(at - 1, place)?;
        Some(self.circle.moved(self.value(at - 1)?, scaled(way, span, took)))
    }

    /// Points from `at` that come back at `back`.
    fn returning(&self, at: usize, back: usize) -> Episode {
        match self.one_bit(at, back) {
            Some(bit) => {
                let mut episode = self.episode(at, back, JumpCause::SingleBit, Likelihood::Likely);
                episode.evidence.push(format!("bit {bit} changed puts it where the rows around it lead"));
                episode
            }
            None => self.episode(at, back, JumpCause::Unclear, Likelihood::Possible),
        }
    }

    /// The bit that, changed in every point, puts them where they should be.
    fn one_bit(&self, at: usize, back: usize) -> Option<u32> {
        (0..24).find(|bit| {
            let flip = 1_i64 << bit;
            flip > 2 * self.tolerance
                && (at..back).all(|place| {
                    let (Some(value), Some(should)) = (self.value(place), self.between(at, back, place))
                    else {
                        return false;
                    };
                    self.circle.way(value ^ flip, should).abs() <= self.tolerance
                })
        })
    }

    fn wrap(&self, at: usize, positions: i64) -> Episode {
        let mut episode = self.episode(at, at + 1, JumpCause::Wrap, Likelihood::Likely);
        episode.evidence.push(format!("the positions go on at the other end of {positions}"));
        episode
    }

    fn episode(&self, at: usize, end: usize, cause: JumpCause, certainty: Likelihood) -> Episode {
        let row = |place: usize| self.points.get(place).and_then(|point| self.rows.get(point.index));
        let (first, last) = (row(at), row(end - 1));
        let (from, to) = (self.value(at - 1).unwrap_or_default(), self.value(at).unwrap_or_default());
        Episode {
            line: first.map_or(0, |row| row.line),
            to_line: last.map_or(0, |row| row.line),
            count: (end - at) as u64,
            time_ns: first.map_or(0, |row| row.time_ns.unsigned_abs()),
            position: self.position,
            cause,
            certainty,
            alternatives: Vec::new(),
            apart: String::new(),
            evidence: vec![format!("{from:06X}h, then {to:06X}h: {} steps", to - from)],
        }
    }
}
