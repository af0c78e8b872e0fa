//! What was seen of an encoder, and the sentences that say what was judged and what could not be.

use encoring_texts::Said;
use encoring_words::Duration;

use crate::axis::Axis;
use crate::curve::{LEAST, Point};
use crate::episode::Conclusion;
use crate::given::Given;
use crate::places::Places;
use crate::refresh::Refresh;
use crate::round::Ends;
use crate::services::Services;
use crate::statements;
use crate::stops::Stops;

/// What else the sentences are about.
#[derive(Clone, Copy)]
pub(crate) struct Told<'a> {
    pub(crate) position: u8,
    pub(crate) axis: &'a Axis,
    pub(crate) ends: &'a Ends,
    pub(crate) given: &'a Given,
    pub(crate) services: &'a Services,
    pub(crate) places: &'a Places,
    pub(crate) stops: &'a Stops,
    pub(crate) refresh: &'a Refresh,
}

/// What was seen, for the sentences at the end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) rows: u64,
    pub(crate) positions: u64,
    pub(crate) period_ns: i64,
    /// The largest tolerance.
    tolerance: i64,
    is_lost: bool,
    has_moved: bool,
}

impl Tally {
    /// Counts rows in which nothing can have happened.
    pub(crate) fn look_at_quiet(&mut self, positions: u64, period_ns: i64, has_moved: bool) {
        self.positions += positions;
        self.period_ns = period_ns;
        self.tolerance = self.tolerance.max(LEAST);
        self.has_moved |= has_moved;
    }

    /// What can be judged of these points.
    pub(crate) fn look(&mut self, points: &[Point], axis: &Axis, tolerance: i64, most: i64) {
        self.tolerance = self.tolerance.max(tolerance);
        self.is_lost |= points.len() > 2 && is_lost(tolerance, axis, most);
        self.has_moved |= points.windows(2).any(|two| matches!(two, [a, b] if a.value != b.value));
    }

    /// Tells it.
    pub(crate) fn tell(&self, beside: &Told<'_>, conclusion: &mut Conclusion) {
        let Told { position, axis, ends, .. } = *beside;
        let period = Duration(self.period_ns.unsigned_abs());
        let told = &mut conclusion.judged;
        told.push(match self.positions {
            0 | 1 => statements::rows_only(position, self.rows, self.positions),
            _ => statements::rows(position, self.rows, self.positions, period),
        });
        conclusion.is_judged |= self.positions > 2 && !self.is_lost;
        let limits = &mut conclusion.limits;
        limits.extend(beside.stops.limit(position, beside.services));
        if self.positions < 3 {
            limits.push(statements::few(position));
            return;
        }
        limits.push(self.smallest(position, axis));
        limits.extend(beside.given.contradiction(position));
        let missed = beside.places.missed();
        limits.extend(
            missed.map(|place| statements::known_missed(position, place.steps, Duration(place.time_ns))),
        );
        let positions = axis.circle.positions;
        if let Some((seen, times)) = ends.other.filter(|_| axis.is_circle_known) {
            limits.push(statements::other_end(position, positions, times, seen));
        }
        if !self.has_moved {
            limits.push(statements::never_moved(position));
        }
        told.extend(
            beside.given.ended().map(|(positions, line)| statements::given_until(position, positions, line)),
        );
        told.push(match (axis.is_circle_known, ends.times) {
            (true, _) => statements::given(position, positions),
            (false, 0) if beside.given.is_beyond_word() => statements::scaled(position),
            (false, 0) => statements::no_end(position, ends.most),
            (false, times) => statements::ends(position, positions, times),
        });
        match beside.refresh.measured() {
            Some(refresh) => told.push(statements::refresh(position, refresh)),
            None => limits.push(statements::no_refresh(position)),
        }
        if !axis.is_scale_known {
            limits.push(statements::no_scale(position));
        }
        if !beside.services.shows_out() {
            limits.push(statements::no_out(position));
        }
    }

    /// The smallest jump that can be judged.
    fn smallest(&self, position: u8, axis: &Axis) -> Said {
        let motion = axis.utmost(self.period_ns, 0).unwrap_or_default();
        let [jump, utmost] = motion.map(|jump| jump.max(self.tolerance));
        match self.is_lost {
            true => statements::any_jump(position),
            false if utmost > jump => statements::larger_jump(position, jump, utmost),
            false => statements::small_jump(position, jump),
        }
    }
}

/// Whether half of the range can be passed from row to row, and so every place be reached.
pub(crate) fn is_lost(tolerance: i64, axis: &Axis, most: i64) -> bool {
    tolerance * 2 >= axis.circle.positions.min(most + 1).max(2)
}
