//! Rows that go on where they should if they are read in another code, or as what 24 bits keep of exchanged halves.

use encoring_texts::Said;
use encoring_words::gray;

use crate::cause::JumpCause;
use crate::curve::Curve;
use crate::evidence;
use crate::motion::way;
use crate::verdict::Judged;

/// Rows that are followed at most.
const ROWS_MAX: usize = 2_048;
/// The fewest rows that say something.
const ROWS_LEAST: usize = 3;
/// Steps that they go at least: a reply stands.
const MOVED: i64 = 4;
/// Rows among them that are something else.
const MISSED: usize = 2;
/// A place that one of so many jumps would meet tells something, and one of so many is enough.
const TELLS: i64 = 32;
const SURE: i64 = 256;

/// What the rows can be taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    ForBinary,
    ForGray,
    Exchanged,
}

/// Rows from `at` on that do not follow from those before.
#[derive(Clone, Copy)]
pub(crate) struct Misread<'a> {
    pub(crate) curve: Curve<'a>,
    pub(crate) at: usize,
}

impl Misread<'_> {
    /// The first row behind them, and what is known.
    pub(crate) fn judged(&self) -> Option<(usize, Judged)> {
        let taken = [Taken::ForBinary, Taken::ForGray, Taken::Exchanged];
        taken.into_iter().filter_map(|taken| self.with(taken)).max_by_key(|(end, _)| *end)
    }

    fn with(&self, taken: Taken) -> Option<(usize, Judged)> {
        let mut last = self.curve.value(self.at - 1)?;
        let mut speed = self.curve.just_before(self.at - 1, 0)?;
        let near = |at: usize| self.curve.may_at(at).saturating_add(self.curve.near());
        let first = near(self.at);
        let (begin, mut end, mut missed, mut moved) = (last, self.at, 0, 0);
        for at in self.at..self.curve.points.len().min(self.at + ROWS_MAX) {
            let span = self.curve.step(at)?.span_ns;
            let (value, should) = (self.curve.value(at)?, self.curve.circle.moved(last, speed.over(span)));
            let off = |place: i64| way(self.curve.circle, should, place).abs();
            // The rows are back.
            if at > self.at && off(value) <= near(at) {
                break;
            }
            let Some(place) = taken.place(value, should).filter(|place| off(*place) <= near(at)) else {
                missed += 1;
                if at == self.at || missed > MISSED {
                    break;
                }
                last = should;
                continue;
            };
            missed = 0;
            moved = moved.max(way(self.curve.circle, begin, place).abs());
            if at > self.at {
                (speed.way, speed.span_ns) = (way(self.curve.circle, last, place), span);
            }
            last = place;
            end = at + 1;
        }
        let rows = end - self.at;
        let can_be_met =
            |part: i64| taken.chance(first, self.curve.circle.positions).saturating_mul(part) > WHOLE;
        if rows < ROWS_LEAST || taken == Taken::Exchanged && moved < MOVED || can_be_met(TELLS) {
            return None;
        }
        let (cause, evidence) = taken.told(rows);
        Some((
            end,
            if can_be_met(SURE) {
                Judged::possible(JumpCause::Unclear, evidence).or(&[
                    cause,
                    JumpCause::OtherSource,
                    JumpCause::Preset,
                ])
            } else {
                Judged::likely(cause, evidence)
            },
        ))
    }
}

/// A chance of one.
const WHOLE: i64 = 1 << 20;

impl Taken {
    /// Where the axis is, if the bits are this; near to where it should be.
    fn place(self, value: i64, should: i64) -> Option<i64> {
        let bits = u32::try_from(value).ok()?;
        match self {
            Self::ForBinary => Some(gray::decode(bits).into()),
            Self::ForGray => Some(gray::encode(bits).into()),
            Self::Exchanged => {
                let (low, high) = (i64::from(bits >> 16), i64::from(bits & 0xFF));
                let off = (low - (should & 0xFF) + 128).rem_euclid(256) - 128;
                let place = should + off;
                (bits > 0 && bits & 0xFF00 == 0 && place >> 16 == high).then_some(place)
            }
        }
    }

    /// How many of [`WHOLE`] jumps would by chance be taken for this.
    fn chance(self, near: i64, positions: i64) -> i64 {
        match self {
            Self::ForBinary | Self::ForGray => near.saturating_mul(2 * WHOLE) / positions.max(1),
            // Sixteen bits are as they must be.
            Self::Exchanged => WHOLE >> 16,
        }
    }

    fn told(self, rows: usize) -> (JumpCause, Said) {
        match self {
            Self::ForBinary => (JumpCause::GrayAsBinary, evidence::as_gray(rows)),
            Self::ForGray => (JumpCause::BinaryAsGray, evidence::as_binary(rows)),
            Self::Exchanged => (JumpCause::HalvesExchanged, evidence::as_exchanged(rows)),
        }
    }
}
