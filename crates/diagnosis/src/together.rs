//! Encoders that move together: after a pause one of them may have another offset to the other than before.

use std::collections::BTreeMap;

use encoring_host::validity::Circle;
use encoring_texts::Said;
use encoring_words::Duration;

use crate::cause::JumpCause;
use crate::episode::Episode;
use crate::evidence;
use crate::motion::way;
use crate::verdict::Judged;

/// Encoders that are compared with each other.
const ENCODERS: usize = 8;
/// Findings that are kept.
const FOUND: usize = 64;
/// A longer pause than so many periods is a gap, and so are so many rows without a position.
const GAP: i64 = 8;
const MISSING: u32 = 3;
/// Rows before a gap can be told from the period.
const ROWS: u32 = 8;
/// Rows of both that show that they move together, before a gap and behind it, and the steps that they must have gone.
const BEFORE: u32 = 32;
const BEHIND: u32 = 8;
const MOVED: i64 = 64;
/// Of so many rows one may be something else.
const ONE_OF: u32 = 20;
/// Steps by which an offset may differ without motion.
const NEAR: i64 = 8;

/// A position and its row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) line: u64,
    pub(crate) time_ns: i64,
    /// `None`: the encoder is off, or nothing reaches it.
    pub(crate) value: Option<i64>,
    pub(crate) circle: Circle,
}

/// A pause of one encoder.
#[derive(Clone, Copy, Debug)]
struct Gap {
    line: u64,
    time_ns: i64,
    span_ns: i64,
    /// The position is the same before and behind.
    is_kept: bool,
}

/// The latest row of an encoder with a position.
#[derive(Clone, Copy, Debug)]
struct Latest {
    time_ns: i64,
    value: i64,
    step: i64,
    circle: Circle,
    period_ns: i64,
    rows: u32,
    /// Rows without a position since.
    missing: u32,
}

/// Rows of a pair between two gaps.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    /// The first offset, the position of one there, and by how many steps a row that is older by a period makes it wrong.
    first: Option<(i64, i64, i64)>,
    agree: u32,
    differ: u32,
    /// The last offset that differs: one of them was beyond the end of its range and the other was not, or a word was wrong.
    another: Option<i64>,
    /// How far offsets that agree lie from the first.
    spread: i64,
    moved: i64,
}

/// Two encoders, the one with the lower ring position first.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    before: Course,
    now: Course,
    /// The gaps between both courses.
    gaps: [Option<Gap>; 2],
}

/// An encoder with another offset to one that moved with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lost {
    pub(crate) position: u8,
    pub(crate) other: u8,
    pub(crate) line: u64,
    pub(crate) time_ns: i64,
    span_ns: i64,
    steps: i64,
    /// The other one had a pause too, and is where it was.
    is_other_kept: bool,
}

/// The encoders of a recording, and each two of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Together {
    latest: BTreeMap<u8, Latest>,
    pairs: BTreeMap<(u8, u8), Pair>,
    found: Vec<Lost>,
}

impl Together {
    /// Takes the next row of an encoder.
    pub(crate) fn row(&mut self, position: u8, place: &Place) {
        let Some(value) = place.value else {
            if let Some(latest) = self.latest.get_mut(&position) {
                latest.missing = latest.missing.saturating_add(1);
            }
            return;
        };
        if self.latest.len() >= ENCODERS && !self.latest.contains_key(&position) {
            return;
        }
        let before = self.latest.get(&position).copied();
        let gap = before.and_then(|before| before.gap(place, value));
        let now = Latest::new(before, place, value, gap.is_some());
        for (other, beside) in self.latest.iter().filter(|(other, _)| **other != position) {
            let key = (position.min(*other), position.max(*other));
            let pair = self.pairs.entry(key).or_default();
            if let Some(gap) = gap {
                self.found.extend(pair.interrupted(key, usize::from(position > *other), gap, now.circle));
            }
            let is_beside = now.time_ns - beside.time_ns <= 2 * now.period_ns && beside.missing == 0;
            if is_beside && beside.circle == now.circle {
                pair.now.look(if position < *other { [&now, beside] } else { [beside, &now] });
            }
        }
        self.found.truncate(FOUND);
        self.latest.insert(position, now);
    }

    /// The encoders that have another offset than before.
    pub(crate) fn finish(mut self) -> Vec<Lost> {
        for (key, pair) in &self.pairs {
            let circle = self.latest.get(&key.0).map(|latest| latest.circle);
            self.found.extend(circle.and_then(|circle| pair.lost(*key, circle)));
        }
        self.found
    }
}

impl Latest {
    fn new(before: Option<Self>, place: &Place, value: i64, is_gap: bool) -> Self {
        let (time_ns, circle) = (place.time_ns, place.circle);
        let none = Self { time_ns, value, step: 0, circle, period_ns: 0, rows: 0, missing: 0 };
        let Some(before) = before else { return none };
        let span_ns = (time_ns - before.time_ns).max(0);
        let step = if is_gap { before.step } else { way(circle, before.value, value).saturating_abs() };
        let period_ns = match before.period_ns {
            period if is_gap => period,
            0 => span_ns,
            period => period + (span_ns - period) / 8,
        };
        Self { step, period_ns, rows: before.rows.saturating_add(1), ..none }
    }

    fn gap(&self, place: &Place, value: i64) -> Option<Gap> {
        let span_ns = place.time_ns - self.time_ns;
        let is_gap =
            self.rows >= ROWS && (span_ns > self.period_ns.saturating_mul(GAP) || self.missing >= MISSING);
        let moved = way(self.circle, self.value, value).saturating_abs();
        is_gap.then_some(Gap {
            line: place.line,
            time_ns: place.time_ns,
            span_ns,
            is_kept: moved <= NEAR + 2 * self.step,
        })
    }
}

impl Course {
    fn look(&mut self, [one, other]: [&Latest; 2]) {
        let circle = one.circle;
        let offset = way(circle, other.value, one.value);
        let late = one.step.saturating_add(other.step);
        let (first, from, first_late) = *self.first.get_or_insert((offset, one.value, late));
        let off = way(circle, first, offset).saturating_abs();
        if off <= (NEAR + late).saturating_add(first_late) {
            self.agree = self.agree.saturating_add(1);
            self.spread = self.spread.max(off);
            self.moved = self.moved.max(way(circle, from, one.value).saturating_abs());
        } else {
            self.differ = self.differ.saturating_add(1);
            self.another = Some(offset);
        }
    }

    const fn is_together(&self, rows: u32) -> bool {
        self.agree >= rows && self.differ.saturating_mul(ONE_OF) <= self.agree
    }
}

impl Pair {
    /// A gap of one of them: that of the other may have been before.
    fn interrupted(&mut self, key: (u8, u8), which: usize, gap: Gap, circle: Circle) -> Option<Lost> {
        let lost = self.lost(key, circle);
        if self.now.first.is_some() {
            *self = Self { before: self.now, ..Self::default() };
        }
        if let Some(place) = self.gaps.get_mut(which) {
            *place = Some(gap);
        }
        lost
    }

    /// The one that has another offset; `None` if both may have moved meanwhile.
    fn lost(&self, key: (u8, u8), circle: Circle) -> Option<Lost> {
        let Self { before, now, gaps } = self;
        let is_shown = before.is_together(BEFORE) && before.moved >= MOVED && now.is_together(BEHIND);
        let near = NEAR + 2 * (before.spread + now.spread);
        let from = |offset: i64| Some(way(circle, offset, now.first?.0).saturating_abs());
        let steps = from(before.first?.0)?;
        let was_seen = before.another.and_then(from).is_some_and(|steps| steps <= near);
        if !is_shown || steps <= near || was_seen {
            return None;
        }
        let (position, other, gap) = match *gaps {
            [Some(gap), None] => (key.0, key.1, gap),
            [None, Some(gap)] => (key.1, key.0, gap),
            [Some(gap), Some(other)] if other.is_kept && !gap.is_kept => (key.0, key.1, gap),
            [Some(other), Some(gap)] if other.is_kept && !gap.is_kept => (key.1, key.0, gap),
            _ => return None,
        };
        let Gap { line, time_ns, span_ns, .. } = gap;
        let is_other_kept = gaps.iter().all(Option::is_some);
        Some(Lost { position, other, line, time_ns, span_ns, steps, is_other_kept })
    }
}

impl Lost {
    pub(crate) fn judged(&self) -> Judged {
        let Self { other, span_ns, steps, is_other_kept, .. } = self;
        let company = match is_other_kept {
            true => evidence::other_is_kept(*other),
            false => evidence::other_had_no_pause(*other),
        };
        let pause = Duration(span_ns.unsigned_abs());
        Judged::likely(JumpCause::ZeroLost, evidence::offset_differs(pause, *other, *steps))
            .since(company)
            .or(&[JumpCause::Mechanical, JumpCause::Preset])
    }

    /// With what would tell it apart.
    pub(crate) fn episode(&self, judged: Judged, apart: Vec<Said>) -> Episode {
        let Judged { cause, certainty, alternatives, evidence } = judged;
        Episode {
            line: self.line,
            to_line: self.line,
            count: 1,
            time_ns: self.time_ns.unsigned_abs(),
            position: self.position,
            cause,
            certainty,
            alternatives,
            apart,
            evidence,
        }
    }

    /// Whether another event tells it: one of this encoder at the end of the pause, or one that the other had meanwhile.
    pub(crate) fn is_told_by(&self, episode: &Episode) -> bool {
        let until = self.time_ns.unsigned_abs();
        let from = until.saturating_sub(self.span_ns.unsigned_abs());
        let is_meanwhile = (from..=until).contains(&episode.time_ns);
        let is_own = episode.position == self.position
            && matches!(
                episode.cause,
                JumpCause::ZeroLost | JumpCause::Preset | JumpCause::Rescaled | JumpCause::Direction
            );
        is_meanwhile && (is_own || episode.position == self.other && episode.cause.is_jump())
    }
}
