//! Goes along a curve and judges what does not follow from the rows before.

use std::ops::Range;

use encoring_host::validity::Circle;
use encoring_words::Model;

use crate::cause::{JumpCause, Likelihood};
use crate::curve::Curve;
use crate::evidence;
use crate::misread::Misread;
use crate::motion::{scaled, way};
use crate::returning::Excursion;
use crate::row::ReadAs;
use crate::services::Services;
use crate::staying::Departure;
use crate::stuck::Stuck;
use crate::verdict::Judged;

/// Rows after which a position that left is no longer looked for.
const AWAY_MAX: usize = 64;
/// Rows that must follow from one another for a curve to go on.
const EVEN: usize = 3;

/// What is found at points of a curve.
#[derive(Clone, Debug)]
pub(crate) struct Find {
    pub(crate) points: Range<usize>,
    pub(crate) judged: Judged,
}

/// What is known beside the curve.
#[derive(Clone, Copy)]
pub(crate) struct Beside<'a> {
    pub(crate) services: &'a Services,
    pub(crate) model: Option<Model>,
    pub(crate) way: ReadAs,
    /// S, N and D.
    pub(crate) told: &'a [i64],
    /// Values that a preset may aim at.
    pub(crate) aims: &'a [i64],
    /// Other numbers of positions, of other scalings.
    pub(crate) circles: &'a [i64],
    /// The largest position that was seen.
    pub(crate) most: i64,
    /// Where the positions begin again is known.
    pub(crate) is_circle_sure: bool,
}

/// How a point that does not follow goes on.
enum Ending {
    /// The speed changed, and nothing else.
    Speed,
    /// The positions are back at this point.
    Back(usize),
    /// They go on elsewhere from this point.
    Away(usize),
    /// There are no more.
    Open,
}

/// Goes along the points of a range.
pub(crate) fn scan(curve: &Curve<'_>, range: Range<usize>, beside: Beside<'_>, found: &mut Vec<Find>) {
    let mut walk = Walk { curve: *curve, beside, not_before: 0, found };
    let mut at = range.start.max(walk.even_from() + 2);
    while at < range.end {
        at = walk.look(at);
    }
}

struct Walk<'a, 'f> {
    curve: Curve<'a>,
    beside: Beside<'a>,
    not_before: usize,
    found: &'f mut Vec<Find>,
}

impl Walk<'_, '_> {
    /// The first point from which the curve is even.
    fn even_from(&self) -> usize {
        let is_even = |first: &usize| self.curve.fits(first + 2);
        (0..AWAY_MAX.min(self.curve.points.len())).find(is_even).unwrap_or(0)
    }

    /// Judges a point; returns the next to be looked at.
    fn look(&mut self, at: usize) -> usize {
        if self.curve.fits(at) {
            if self.goes_round(at) {
                self.wrap(at);
            }
            return at + 1;
        }
        if let Some(circle) = self.other_circle(at) {
            self.curve.circle = circle;
            self.beside.is_circle_sure = false;
            self.wrap(at);
            return at + 1;
        }
        let ending = self.ending(at);
        if !matches!(ending, Ending::Speed)
            && self.beside.way == ReadAs::Plain
            && let Some((end, judged)) = (Misread { curve: self.curve, at }).judged()
        {
            let judged = self.doubted_if_small(judged, at, self.curve.off(at).unwrap_or_default());
            self.found.push(Find { points: at..end, judged });
            self.not_before = end;
            return end + 2;
        }
        match ending {
            Ending::Speed => at + 1,
            Ending::Back(back) => {
                let Beside { services, way, told, .. } = self.beside;
                let excursion = Excursion { curve: self.curve, services, way, told, at, back };
                let off = excursion.farthest();
                if let Some(judged) = excursion.judged()
                    && (judged.certainty == Likelihood::Certain
                        || off > self.late(at)
                        || !excursion.is_in_order())
                {
                    let judged = self.doubted_if_small(judged, at, off);
                    self.found.push(Find { points: at..back, judged });
                }
                back + 2
            }
            Ending::Away(from) => self.away(at, from),
            Ending::Open => at + 1,
        }
    }

    /// The circle of another scaling, if the point follows in it.
    fn other_circle(&self, at: usize) -> Option<Circle> {
        let circles = self.beside.circles.iter().map(|positions| Circle { positions: *positions });
        circles.filter(|circle| *circle != self.curve.circle).find(|circle| {
            let other = Walk {
                curve: Curve { circle: *circle, ..self.curve },
                beside: self.beside,
                not_before: 0,
                found: &mut Vec::new(),
            };
            other.curve.fits(at) && other.curve.fits(at + 1) && other.goes_round(at)
        })
    }

    fn away(&mut self, at: usize, from: usize) -> usize {
        if from == at
            && let Some((end, steps, judged)) =
                (Stuck { curve: self.curve, way: self.beside.way, at }).judged()
        {
            let judged = self.doubted_if_small(judged, at, steps);
            self.found.push(Find { points: at..end, judged });
            self.not_before = end;
            return end + 2;
        }
        let Beside { services, model, aims, most, is_circle_sure, .. } = self.beside;
        let departure = Departure {
            curve: self.curve,
            services,
            model,
            aims,
            most,
            is_circle_known: is_circle_sure,
            began: at,
            at: from,
            not_before: self.not_before,
        };
        if let Some((first, judged)) = departure.judged()
            && let Some(judged) = self.weighed(judged, from)
        {
            let end = from.max(at).max(first) + 1;
            self.found.push(Find { points: first.min(at)..end, judged });
        }
        self.not_before = from;
        from + 2
    }

    /// What the limits of motion leave of a jump that stays: nothing where a usual axis can make it within one row, a doubt
    /// where one at the limits of the data sheet can.
    fn weighed(&self, judged: Judged, at: usize) -> Option<Judged> {
        if judged.certainty == Likelihood::Certain
            || matches!(judged.cause, JumpCause::Frozen | JumpCause::OverAcceleration)
        {
            return Some(judged);
        }
        let (way, span) = self.curve.way(at - 1, at)?;
        let before = self.curve.step(at.saturating_sub(1))?;
        let jump = (way - before.over(span)).abs();
        match self.motion(at) {
            Some([usual, _]) if jump <= usual => None,
            _ => Some(self.doubted_if_small(judged, at, jump)),
        }
    }

    /// A doubt where motion, or a row that is older or newer than its time says, can be the cause.
    fn doubted_if_small(&self, judged: Judged, at: usize, jump: i64) -> Judged {
        let is_small = self.motion(at).is_some_and(|[_, utmost]| jump.abs() <= utmost);
        if is_small { judged.doubted() } else { judged }
    }

    /// Steps by which a row may be off for its time alone.
    fn late(&self, at: usize) -> i64 {
        let step = |at: usize| self.curve.step(at).map_or(0, |step| step.over(self.curve.period_ns).abs());
        self.curve.axis.late(self.curve.period_ns, step(at - 1).max(step(at + 2)))
    }

    /// What motion may add at a point, see [`Curve::utmost`].
    fn motion(&self, at: usize) -> Option<[i64; 2]> {
        let before = self.curve.step(at.saturating_sub(1))?;
        self.curve.utmost(before.over(self.curve.period_ns))
    }

    /// Whether the shorter way leads over the end of the range.
    fn goes_round(&self, at: usize) -> bool {
        let (Some(from), Some(to)) = (self.curve.value(at - 1), self.curve.value(at)) else { return false };
        to - from != way(self.curve.circle, from, to)
    }

    fn wrap(&mut self, at: usize) {
        let positions = self.curve.circle.positions;
        let evidence = evidence::end_to_end(positions);
        let is_slow = self.curve.tolerance.saturating_mul(16) < positions;
        let judged = if self.beside.is_circle_sure && is_slow {
            Judged::certain(JumpCause::Wrap, evidence)
        } else {
            Judged::likely(JumpCause::Wrap, evidence).or(&[JumpCause::Preset, JumpCause::OtherSource])
        };
        self.found.push(Find { points: at..at + 1, judged });
    }

    fn ending(&self, at: usize) -> Ending {
        let Some(step) = self.curve.step(at) else { return Ending::Open };
        let Some(before) = self.curve.step(at - 1) else { return Ending::Open };
        let before = before.over(step.span_ns);
        let Some(next) = self.curve.step(at + 1) else { return Ending::Open };
        let after = next.over(step.span_ns);
        let may = self.curve.may_at(at);
        if (before.min(after) - may..=before.max(after) + may).contains(&step.way) && self.goes_on(at) {
            return Ending::Speed;
        }
        let stands = self.constant_until(at);
        let near = at + 1..=at + AWAY_MAX;
        if let Some(back) = near.chain([stands]).find(|back| self.is_back(at, *back)) {
            return Ending::Back(back);
        }
        let even = |from: &usize| (from + 2..from + 2 + EVEN).all(|at| self.curve.fits(at));
        Ending::Away((at..at + AWAY_MAX).find(even).unwrap_or(at))
    }

    /// Whether the point behind the next follows from both.
    fn goes_on(&self, at: usize) -> bool {
        self.curve.fits(at + 2) || self.curve.step(at + 2).is_none()
    }

    /// The first point behind this one that has another value.
    fn constant_until(&self, at: usize) -> usize {
        let value = self.curve.value(at);
        let same = self.curve.points.iter().skip(at).take_while(|point| Some(point.value) == value);
        at + same.count()
    }

    /// Whether the points from `back` on go on from those before `at`.
    fn is_back(&self, at: usize, back: usize) -> bool {
        let (Some(before), Some((way, span)), Some(after)) =
            (self.curve.step(at - 1), self.curve.way(at - 1, back), self.curve.step(back + 1))
        else {
            return false;
        };
        let (was, is) = (before.over(span), after.over(span));
        let mean = (was + is) / 2;
        let rows = span / self.curve.period_ns.max(1);
        let may = self.curve.tolerance.saturating_mul(rows.max(2)) / 2;
        let jump = self.curve.off(at).unwrap_or_default().abs();
        let speeds = (was - is).abs() <= 4 * may.max(scaled(was.abs(), 1, 4));
        // One row comes back by as much as it left; a speed that begins to change goes on.
        let takes_back = |left: i64| self.curve.off(back).is_none_or(|off| off.signum() != left.signum());
        if back == at + 1 && !self.curve.off(at).is_none_or(takes_back) {
            return false;
        }
        (way - mean).abs() <= may && jump * 2 > 3 * may && speeds
    }
}
