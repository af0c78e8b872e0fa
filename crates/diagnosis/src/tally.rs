//! What was seen of an encoder, and the sentences that say what was judged and what could not be.

use encoring_words::Duration;

use crate::axis::Axis;
use crate::curve::{LEAST, Point};
use crate::episode::Conclusion;
use crate::given::Given;
use crate::places::Places;
use crate::refresh::Refresh;
use crate::round::Ends;
use crate::services::Services;
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
        told.push(format!(
            "position {position}: {} rows, {} of them positions, {period} apart",
            self.rows, self.positions
        ));
        let limits = &mut conclusion.limits;
        if let Some(limit) = beside.stops.limit(beside.services) {
            limits.push(format!("position {position}: {limit}"));
        }
        if self.positions < 3 {
            limits.push(format!("position {position}: fewer than three positions: nothing can be judged"));
            return;
        }
        let motion = axis.utmost(self.period_ns, 0).unwrap_or_default();
        let [jump, utmost] = motion.map(|jump| jump.max(self.tolerance));
        if self.is_lost {
            limits.push(format!(
                "position {position}: at this period no jump can be judged: half of the positions can be passed from row to row"
            ));
        } else {
            let beyond = match utmost > jump {
                true => format!("; one of up to {utmost} may be motion within the data sheet"),
                false => String::new(),
            };
            limits.push(format!(
                "position {position}: at this period no jump of up to {jump} steps can be judged{beyond}"
            ));
        }
        if let Some(contradiction) = beside.given.contradiction() {
            limits.push(format!("position {position}: {contradiction}"));
        }
        for place in beside.places.missed() {
            let at = Duration(place.time_ns);
            limits.push(format!(
                "position {position}: the known place {} at {at} was not compared: no row is near that time",
                place.steps
            ));
        }
        let given = axis.circle.positions;
        if let Some((seen, times)) = ends.other.filter(|_| axis.is_circle_known) {
            limits.push(format!(
                "position {position}: {given} positions are given, and {times} times they begin again after about {seen}: these are \
                 wrong, or another scaling was active"
            ));
        }
        if !self.has_moved {
            limits.push(format!(
                "position {position}: it never moved: code, order of the halves, scaling, direction and held bits do not show"
            ));
        }
        let positions = axis.circle.positions;
        told.push(match (axis.is_circle_known, ends.times) {
            (true, _) => format!("position {position}: {positions} positions, as given"),
            (false, 0) => {
                format!("position {position}: S is at least {}: no end of the range was seen", ends.most)
            }
            (false, times) => {
                format!("position {position}: about {positions} positions: their end was seen {times} times")
            }
        });
        match beside.refresh.measured() {
            Some(refresh) => told.push(format!(
                "position {position}: refreshed every {refresh}, measured: by the encoder, or by what carries its words"
            )),
            None => limits
                .push(format!("position {position}: the refresh time is not visible at this period or speed")),
        }
        if !axis.is_scale_known {
            limits.push(format!(
                "position {position}: N, D and the counting direction do not show in positions; speed and acceleration were judged \
                 as steps only: give --parameters"
            ));
        }
        if !beside.services.shows_out() {
            limits.push(format!("position {position}: without OUT in every row presets and scalings are seen only by their replies"));
        }
    }
}

/// Whether half of the range can be passed from row to row, and so every place be reached.
pub(crate) fn is_lost(tolerance: i64, axis: &Axis, most: i64) -> bool {
    tolerance * 2 >= axis.circle.positions.min(most + 1).max(2)
}
