//! A bit that does not change any more: the rows behind a jump are those of an even motion with one bit held.

use encoring_words::gray;

use crate::cause::JumpCause;
use crate::curve::Curve;
use crate::evidence;
use crate::motion::way;
use crate::row::ReadAs;
use crate::verdict::Judged;

/// How often the bit must be held back until it is believed.
const HELD_BACK: usize = 3;
/// Bits of a position.
const BITS: u32 = 24;

/// A jump that a held bit may have made.
#[derive(Clone, Copy)]
pub(crate) struct Stuck<'a> {
    pub(crate) curve: Curve<'a>,
    pub(crate) way: ReadAs,
    pub(crate) at: usize,
}

impl Stuck<'_> {
    /// The end of the stretch, the steps of the bit, and what is known of it.
    pub(crate) fn judged(&self) -> Option<(usize, i64, Judged)> {
        let with = |bit: u32| self.with(bit).map(|(end, judged)| (end, 1_i64 << bit, judged));
        (0..BITS).filter_map(with).max_by_key(|(end, ..)| *end)
    }

    fn code(&self, value: i64) -> u32 {
        let value = u32::try_from(value).unwrap_or_default();
        if self.way == ReadAs::Gray { gray::encode(value) } else { value }
    }

    fn decoded(&self, bits: u32) -> i64 {
        i64::from(if self.way == ReadAs::Gray { gray::decode(bits) } else { bits })
    }

    /// Follows the curve with the bit free where it was held, as far as that goes.
    fn with(&self, bit: u32) -> Option<(usize, Judged)> {
        let mask = 1_u32 << bit;
        if i64::from(mask) <= self.curve.near().saturating_add(self.curve.untimely(self.at)) {
            return None;
        }
        let level = self.code(self.curve.value(self.at)?) & mask;
        let mut last = self.curve.value(self.at - 1)?;
        let mut speed = self.curve.step(self.at - 1)?;
        let (mut changes, mut was_held, mut end) = (0, false, self.at);
        for at in self.at..self.curve.points.len() {
            let code = self.code(self.curve.value(at)?);
            if code & mask != level {
                break;
            }
            let span = self.curve.step(at)?.span_ns;
            let should = self.curve.circle.moved(last, speed.over(span));
            let choice = [code, code ^ mask].map(|code| self.decoded(code));
            let is_there = |place: &i64| *place == choice[0] || *place < self.curve.circle.positions;
            let near = |place: &i64| way(self.curve.circle, should, *place).abs();
            let place = choice.into_iter().filter(is_there).min_by_key(near)?;
            let off = way(self.curve.circle, should, place).abs();
            if off > self.curve.may_at(at) + self.curve.tolerance {
                break;
            }
            let is_held = place != choice[0];
            changes += usize::from(is_held && !was_held);
            was_held = is_held;
            speed.way = way(self.curve.circle, last, place);
            speed.span_ns = span;
            last = place;
            end = at + 1;
        }
        let rows = end - self.at;
        let text = evidence::stuck(bit, u8::from(level != 0), rows);
        match changes {
            HELD_BACK.. => Some((end, Judged::likely(JumpCause::StuckBit, text))),
            2 => Some((
                end,
                Judged::possible(JumpCause::Unclear, text).or(&[
                    JumpCause::StuckBit,
                    JumpCause::SingleBit,
                    JumpCause::Mechanical,
                ]),
            )),
            _ => None,
        }
    }
}
