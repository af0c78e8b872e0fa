//! Rows that leave the curve and go on elsewhere.

use encoring_texts::{Decimal, Hex};
use encoring_words::Model;

use crate::cause::JumpCause;
use crate::curve::{Curve, Speed};
use crate::evidence;
use crate::motion::{scaled, way};
use crate::services::{Done, Services};
use crate::verdict::Judged;

/// Rows that a speed must come from to be compared with another.
const SPEED_ROWS_LEAST: usize = 4;
/// Equal rows before a jump from which they are frozen.
const FROZEN_ROWS: usize = 4;
/// The part of the positions that no coupling slips at once.
const FAR: i64 = 16;
/// Fewer steps are rounding.
const FROZEN_STEPS: i64 = 8;
/// How long before a jump a service may have been asked for.
const SERVICE_NS: i64 = 100_000_000;

/// A jump at the point `at`, behind which the positions stay away.
#[derive(Clone, Copy)]
pub(crate) struct Departure<'a> {
    pub(crate) curve: Curve<'a>,
    pub(crate) services: &'a Services,
    pub(crate) model: Option<Model>,
    /// Values that a preset may aim at.
    pub(crate) aims: &'a [i64],
    /// The largest position that was seen.
    pub(crate) most: i64,
    /// How many positions there are is given or was seen.
    pub(crate) is_circle_known: bool,
    /// The first point that does not follow.
    pub(crate) began: usize,
    pub(crate) at: usize,
    /// The first point that belongs to the same motion.
    pub(crate) not_before: usize,
}

/// What is known of the motion around a jump.
#[derive(Clone, Copy)]
struct Around {
    before: Speed,
    after: Speed,
    /// From the last point before to the first behind it.
    span_ns: i64,
    /// Steps that are not motion.
    jump: i64,
}

impl Departure<'_> {
    /// Why they left, with the point at which it began; `None` if it may be motion.
    pub(crate) fn judged(&self) -> Option<(usize, Judged)> {
        if let Some(frozen) = self.frozen() {
            return Some(frozen);
        }
        let around = self.around()?;
        let judged = self.serviced(&around).or_else(|| self.too_sudden()).or_else(|| self.wraps(&around));
        let judged = judged.or_else(|| {
            self.reversed(&around).or_else(|| self.rescaled(&around)).or_else(|| self.same_speed(&around))
        });
        if judged.is_none() && self.only_speed(&around) {
            return None;
        }
        let judged = judged.unwrap_or_else(|| self.other_speed(&around));
        let judged =
            if self.may_be_sudden(&around) { judged.or_first(JumpCause::OverAcceleration) } else { judged };
        let judged = if self.stood() { judged.or_first(JumpCause::Frozen) } else { judged };
        Some((self.at, judged))
    }

    fn around(&self) -> Option<Around> {
        let span_ns = self.curve.step(self.at)?.span_ns;
        let stands = Speed { way: 0, span_ns: span_ns.max(1), uneven: 0, rows: 0 };
        let before = self.curve.just_before(self.at - 1, self.not_before).unwrap_or(stands);
        let after = self.curve.just_after(self.at).unwrap_or(stands);
        let (way, _) = self.curve.way(self.at - 1, self.at)?;
        let near = |speed: Option<Speed>| speed.unwrap_or(stands).over(span_ns);
        let motion = (near(self.curve.speed_before(self.at - 1, 3, self.not_before))
            + near(self.curve.speed_after(self.at, 3)))
            / 2;
        Some(Around { before, after, span_ns, jump: way - motion })
    }

    /// Equal rows, and then the way that was gone meanwhile.
    fn frozen(&self) -> Option<(usize, Judged)> {
        let value = self.curve.value(self.at - 1);
        let rows = self.equal_before();
        let first = self.at - rows;
        if rows < FROZEN_ROWS || first == 0 {
            return None;
        }
        let before = self.curve.just_before(first, self.not_before)?;
        let after = self.curve.just_after(self.at)?;
        let (_, span) = self.curve.way(first, self.at)?;
        let (slow, fast) = (before.over(span), after.over(span));
        let mean = (slow + fast) / 2;
        let even = (slow - fast).abs() * 5 < mean.abs();
        let off = mean.abs() * if even { 15 } else { 35 } / 100 + self.curve.near();
        let row = scaled(mean, self.curve.period_ns, span);
        let circle = self.curve.circle;
        let should = circle.moved(value?, mean);
        let missed = way(circle, should, self.curve.value(self.at)?).abs();
        let is_long = mean.abs() >= FROZEN_STEPS && mean.abs() * 2 > row.abs() * 5;
        if missed > off || off.saturating_mul(8) > circle.positions || !is_long {
            return None;
        }
        let way = mean + way(circle, should, self.curve.value(self.at)?);
        let evidence = evidence::stood(rows, way);
        let is_sure = before.rows.min(after.rows) >= SPEED_ROWS_LEAST;
        let judged = if is_sure {
            Judged::likely(JumpCause::Frozen, evidence)
        } else {
            Judged::possible(JumpCause::Unclear, evidence).or(&[JumpCause::Frozen, JumpCause::OtherSource])
        };
        Some((first + 1, judged))
    }

    /// Equal rows before, and motion before them.
    fn stood(&self) -> bool {
        let rows = self.equal_before();
        let first = self.at - rows;
        let moved = self.curve.just_before(first, self.not_before).map_or(0, |speed| speed.way.abs());
        rows >= FROZEN_ROWS && first > 0 && moved >= FROZEN_STEPS
    }

    /// How many rows before have the value of the last.
    fn equal_before(&self) -> usize {
        let value = self.curve.value(self.at - 1);
        (self.not_before..self.at).rev().take_while(|place| self.curve.value(*place) == value).count()
    }

    /// No more steps than a change of the speed within a row or two makes.
    fn may_be_sudden(&self, around: &Around) -> bool {
        let Around { before, after, span_ns, jump } = *around;
        let change = (before.over(span_ns) - after.over(span_ns)).abs();
        jump.abs() <= change + self.curve.near() && change > self.curve.tolerance
    }

    /// The way from the last point before to here is one between both speeds: nothing but the speed changed.
    fn too_sudden(&self) -> Option<Judged> {
        let bend = self.curve.axis.bend(self.curve.period_ns).filter(|_| self.curve.axis.is_scale_known)?;
        let (way, span) = self.curve.way(self.began - 1, self.at)?;
        let before = self.curve.just_before(self.began - 1, self.not_before)?;
        let after = self.curve.just_after(self.at)?;
        let (was, is) = (before.over(span), after.over(span));
        let rows = span / self.curve.period_ns.max(1);
        let may = self.curve.near() + bend.saturating_mul(rows);
        let is_between = (was.min(is) - may..=was.max(is) + may).contains(&way);
        let (slow, fast) = (before.over(self.curve.period_ns), after.over(self.curve.period_ns));
        let change = (fast - slow).abs();
        let doubt = before.doubt(self.curve.period_ns) + after.doubt(self.curve.period_ns);
        let permissible = bend.saturating_mul(rows + 1) + doubt;
        (is_between && change > permissible).then(|| {
            Judged::likely(
                JumpCause::OverAcceleration,
                evidence::too_sudden_between(change, rows, permissible),
            )
        })
    }

    /// Whether the way is one between both speeds, and no more than that changed.
    fn only_speed(&self, around: &Around) -> bool {
        let Around { before, after, span_ns, .. } = *around;
        let (was, is) = (before.over(span_ns), after.over(span_ns));
        let may = self.curve.may_at(self.at);
        let way = self.curve.way(self.at - 1, self.at).map_or(0, |(way, _)| way);
        let able = self.curve.utmost(was).map_or(i64::MAX, |[_, strong]| strong);
        (was - is).abs() <= able && (was.min(is) - may..=was.max(is) + may).contains(&way)
    }

    /// A jump at 0 against the motion, to or from the largest position that was seen, while nobody has said how many there
    /// are.
    fn wraps(&self, around: &Around) -> Option<Judged> {
        if self.is_circle_known || !self.is_same_speed(around) {
            return None;
        }
        let (from, to) = (self.curve.value(self.at - 1)?, self.curve.value(self.at)?);
        let speed = if around.after.way == 0 { around.before.way } else { around.after.way };
        let near = around.after.over(around.span_ns).abs() + self.curve.near();
        let evidence = evidence::at_zero(to - from);
        let is_at_top = |place: i64| place + near >= self.most;
        if speed < 0 && (0..=near).contains(&from) && to > from && is_at_top(to) {
            return Some(Judged::likely(JumpCause::Wrap, evidence).or(&[JumpCause::Preset]));
        }
        (speed > 0 && (0..=near).contains(&to) && to < from && is_at_top(from)).then(|| {
            Judged::possible(JumpCause::Unclear, evidence).or(&[
                JumpCause::Wrap,
                JumpCause::Preset,
                JumpCause::Mechanical,
            ])
        })
    }

    fn serviced(&self, around: &Around) -> Option<Judged> {
        let to = self.curve.row(self.at)?.time_ns;
        let from = self.curve.row(self.at - 1)?.time_ns - SERVICE_NS.max(self.curve.period_ns * 10);
        // What was asked for before the last jump made that one.
        let used = self.not_before.checked_sub(1).and_then(|last| self.curve.row(last));
        let from = used.map_or(from, |row| from.max(row.time_ns));
        let mut checked = false;
        for mark in self.services.between(from, to) {
            let place = self.services.place(mark.line);
            match mark.done {
                Done::Check => checked = true,
                Done::Preset(value) => {
                    let landed = self.curve.value(self.at)?;
                    let off = way(self.curve.circle, value.into(), landed).abs();
                    let may =
                        around.after.over(around.span_ns).abs().max(around.before.over(around.span_ns).abs());
                    let judged = Judged::certain(JumpCause::Preset, evidence::preset_at(Hex(value), place));
                    return Some(if off <= may * 4 + self.curve.near() {
                        judged
                    } else {
                        judged.since(evidence::preset_off(off))
                    });
                }
                Done::Scaling => {
                    return Some(Judged::certain(JumpCause::Rescaled, evidence::scaling_written(place)));
                }
                Done::Direction => {
                    return Some(Judged::certain(JumpCause::Direction, evidence::direction_written(place)));
                }
            }
        }
        let older = self.services.between(i64::MIN, to).find(|mark| !matches!(mark.done, Done::Check))?;
        let written = self.services.place(older.line);
        match older.done {
            Done::Scaling if checked => {
                Some(Judged::certain(JumpCause::Rescaled, evidence::scaling_checked(written)))
            }
            Done::Direction if checked => {
                Some(Judged::certain(JumpCause::Direction, evidence::direction_checked(written)))
            }
            _ => None,
        }
    }

    fn reversed(&self, around: &Around) -> Option<Judged> {
        let Around { before, after, .. } = *around;
        if before.rows < SPEED_ROWS_LEAST || after.rows < SPEED_ROWS_LEAST {
            return None;
        }
        let (was, is) = (before.over(after.span_ns), after.way);
        let doubt = before.doubt(after.span_ns) + after.doubt(after.span_ns);
        let opposite = was.signum() == -is.signum() && was != 0;
        if !opposite || was.abs() < 4 * doubt || (was + is).abs() > doubt + was.abs() / 8 {
            return None;
        }
        let (from, to) = (self.curve.value(self.at - 1)?, self.curve.value(self.at)?);
        let mirrored = way(self.curve.circle, self.curve.circle.positions - 1 - from, to).abs();
        let may = before.over(around.span_ns).abs() * 2 + self.curve.near();
        let evidence = evidence::other_way();
        Some(if mirrored <= may {
            Judged::likely(JumpCause::Direction, evidence).since(evidence::mirrored(mirrored))
        } else {
            Judged::possible(JumpCause::Unclear, evidence).or(&[
                JumpCause::Direction,
                JumpCause::Preset,
                JumpCause::OtherSource,
            ])
        })
    }

    /// Positions and speed in the same ratio to those before.
    fn rescaled(&self, around: &Around) -> Option<Judged> {
        let Around { before, after, span_ns, .. } = *around;
        if before.rows < SPEED_ROWS_LEAST || after.rows < SPEED_ROWS_LEAST {
            return None;
        }
        let (was, is) = (before.over(after.span_ns), after.way);
        let doubt = before.doubt(after.span_ns) + after.doubt(after.span_ns);
        let differs = (was - is).abs() > doubt + was.abs().max(is.abs()) / 16;
        if was.signum() != is.signum() || !differs || was.abs().min(is.abs()) < 4 * doubt {
            return None;
        }
        let from = self.curve.value(self.at - 1)? + before.over(span_ns);
        let to = self.curve.value(self.at)?;
        // to / from = is / was, with the doubt of both speeds.
        let (left, right) = (i128::from(to) * i128::from(was), i128::from(from) * i128::from(is));
        let may = (i128::from(from.abs()) + i128::from(to.abs())) * i128::from(doubt)
            + i128::from(self.curve.near()) * i128::from(was.abs() + is.abs());
        ((left - right).abs() <= may && from > 0).then(|| {
            let ratio = i128::from(to) * 100 / i128::from(from.max(1));
            let ratio = Decimal::Hundredths(u64::try_from(ratio).unwrap_or_default());
            Judged::likely(JumpCause::Rescaled, evidence::ratio(ratio))
        })
    }

    /// Whether the speed is the same on both sides, as far as the rows show it.
    fn is_same_speed(&self, around: &Around) -> bool {
        let Around { before, after, span_ns, .. } = *around;
        let (was, is) = (before.over(after.span_ns), after.way);
        let doubt = before.doubt(after.span_ns) + after.doubt(after.span_ns);
        let [near_before, near_after] =
            [self.curve.speed_before(self.at - 1, 3, self.not_before), self.curve.speed_after(self.at, 3)]
                .map(|speed| speed.map_or(0, |speed| speed.over(span_ns)));
        if was.signum() == -is.signum() && was != 0 && !self.is_slow(around) {
            return false;
        }
        let near = (near_before - near_after).abs() <= self.curve.tolerance + near_before.abs() / 16;
        near || (was - is).abs() <= doubt + was.abs().max(is.abs()) / 16
    }

    /// Too slow on one side for its speed to be compared with that on the other.
    fn is_slow(&self, around: &Around) -> bool {
        let is_unsure = |speed: Speed| speed.way.abs() < 4 * speed.doubt(speed.span_ns);
        is_unsure(around.before) || is_unsure(around.after)
    }

    /// Where a preset that people choose may have put the position, if it is there.
    fn aim(&self, around: &Around) -> Option<i64> {
        let landed = self.curve.value(self.at)?;
        let speed = self.curve.speed_after(self.at, 3).map_or(0, |speed| speed.over(around.span_ns));
        let may = speed.abs() + self.curve.near();
        // A place that a hundredth of all jumps would meet tells nothing.
        if may.saturating_mul(100 * (1 + i64::try_from(self.aims.len()).unwrap_or(i64::MAX)))
            > self.curve.circle.positions
        {
            return None;
        }
        [0].iter().chain(self.aims).copied().find(|aim| {
            let off = way(self.curve.circle, *aim, landed);
            off.abs() <= self.curve.near() || speed != 0 && (0..=may).contains(&(off * speed.signum()))
        })
    }

    fn same_speed(&self, around: &Around) -> Option<Judged> {
        if !self.is_same_speed(around) {
            return None;
        }
        let jump = around.jump;
        let evidence = evidence::same_speed(jump);
        let out = self.services.shows_out();
        let inputs = self.model.is_none_or(|model| !model.preset_inputs().is_empty());
        if let Some(aim) = self.aim(around)
            && (!out || inputs)
        {
            return Some(
                Judged::likely(JumpCause::Preset, evidence)
                    .since(evidence::aimed(aim))
                    .or(&[JumpCause::Mechanical]),
            );
        }
        if out && !inputs {
            let is_bit = is_one_bit(jump, self.curve.near());
            let is_far = jump.abs().saturating_mul(FAR) > self.curve.circle.positions.min(self.most + 1);
            return Some(if self.is_slow(around) || is_bit || is_far {
                let other = match (is_bit, is_far) {
                    (true, _) => JumpCause::StuckBit,
                    (_, true) => JumpCause::OtherSource,
                    _ => JumpCause::Rescaled,
                };
                Judged::possible(JumpCause::Unclear, evidence).since(evidence::no_preset()).or(&[
                    JumpCause::Mechanical,
                    other,
                    JumpCause::OtherSource,
                    JumpCause::Rescaled,
                ])
            } else {
                Judged::likely(JumpCause::Mechanical, evidence).since(evidence::no_preset())
            });
        }
        let mut others = vec![JumpCause::Mechanical, JumpCause::Preset, JumpCause::OtherSource];
        if is_one_bit(jump, self.curve.near()) {
            others.insert(0, JumpCause::StuckBit);
        }
        Some(Judged::possible(JumpCause::Unclear, evidence).or(&others))
    }

    fn other_speed(&self, around: &Around) -> Judged {
        let speed = |speed: Speed| speed.over(1_000_000_000);
        let evidence = evidence::other_speed(around.jump, speed(around.before), speed(around.after));
        if around.before.way.signum() * around.after.way.signum() < 0 {
            return Judged::possible(JumpCause::Unclear, evidence).or(&[
                JumpCause::Direction,
                JumpCause::Preset,
                JumpCause::OtherSource,
            ]);
        }
        let few = around.before.rows < SPEED_ROWS_LEAST || around.after.rows < SPEED_ROWS_LEAST;
        if few {
            return Judged::possible(JumpCause::Unclear, evidence).or(&[
                JumpCause::Preset,
                JumpCause::Mechanical,
                JumpCause::OtherSource,
            ]);
        }
        Judged::possible(JumpCause::Unclear, evidence).or(&[
            JumpCause::OtherSource,
            JumpCause::Rescaled,
            JumpCause::Preset,
        ])
    }
}

/// Whether a jump is that of one bit, within so many steps.
fn is_one_bit(jump: i64, near: i64) -> bool {
    (0..24).any(|bit| {
        let flip = 1_i64 << bit;
        flip > 4 * near && (jump.abs() - flip).abs() <= near
    })
}
