//! What the axis can do between two rows.

use core::num::NonZeroU32;

use encoring_host::validity::{Circle, Expectation, Limits, Swiftest};
use encoring_words::model::{MODELS, SensorKind};
use encoring_words::word::DATA_MAX;
use encoring_words::{Duration, Model};

use crate::motion::{per_second, scaled};
use crate::options::Options;

/// The part of the permissible acceleration that an axis has usually: 100 of 10 000 rad/s^2.
const USUAL: i64 = 100;

/// What is known or assumed of an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) circle: Circle,
    /// S is given.
    pub(crate) is_circle_known: bool,
    /// N, D and the sensor are given, so that steps are parts of a turn or of a millimetre.
    pub(crate) is_scale_known: bool,
    /// The largest speed and acceleration that are permissible.
    pub(crate) swiftest: Swiftest,
    pub(crate) refresh_ns: i64,
}

impl Axis {
    pub(crate) fn new(options: &Options) -> Self {
        let limits = limits(options);
        let refresh_ns = i64::try_from(limits.refresh.as_nanos()).unwrap_or(i64::MAX);
        let given = options
            .active
            .and_then(|active| Expectation::new(active.model, active.sensor, &active.parameters).ok());
        // Of a rod positions go on beyond its length [C7].
        let is_shaft = said(options).is_some_and(|model| model.sensor_kind() == SensorKind::Rotary);
        let length = options.measuring_length.filter(|length| is_shaft && *length <= DATA_MAX);
        match given {
            Some(expectation) => Self {
                circle: expectation.circle(),
                is_circle_known: true,
                is_scale_known: true,
                swiftest: expectation.swiftest(&limits),
                refresh_ns,
            },
            None => Self {
                circle: Circle { positions: length.map_or(i64::from(DATA_MAX), i64::from) + 1 },
                is_circle_known: length.is_some(),
                is_scale_known: false,
                swiftest: assumed(&limits, said(options)),
                refresh_ns,
            },
        }
    }

    /// Steps a second that are permissible, if steps are known parts of a turn or of a millimetre.
    pub(crate) fn limit(&self) -> Option<i64> {
        self.swiftest.steps_per_s.filter(|_| self.is_scale_known)
    }

    /// Steps of a speed in this time, rounded up.
    pub(crate) fn travel(&self, span_ns: i64) -> Option<i64> {
        self.swiftest.steps_per_s.map(|speed| per_second(speed, span_ns))
    }

    /// Steps by which the largest acceleration leaves a straight line in this time and the same again.
    pub(crate) fn bend(&self, span_ns: i64) -> Option<i64> {
        self.swiftest.steps_per_s2.map(|change| per_second(per_second(change, span_ns), span_ns))
    }
}

impl Axis {
    /// What motion may add from one row to the next, beside so many steps before and behind: of a usual axis, and within the
    /// permissible. `None` without a limit.
    pub(crate) fn utmost(&self, period_ns: i64, step: i64) -> Option<[i64; 2]> {
        let bend = self.bend(period_ns.saturating_add(self.refresh_ns))?;
        let late = scaled(step.abs(), self.refresh_ns + period_ns / 5, period_ns);
        let travel = self.travel(period_ns).map_or(i64::MAX, |travel| travel.saturating_mul(2));
        Some([bend / USUAL, bend].map(|bend| (bend / 4 * 3).saturating_add(late + 2).min(travel)))
    }
}

/// Those of the model; of no model those of a shaft, and the longest refresh.
fn limits(options: &Options) -> Limits {
    let said = said(options);
    let like = said.or_else(|| MODELS.into_iter().find(|model| model.mechanics().is_some()));
    let mut limits = Limits::of(like.unwrap_or(MODELS[0]), Duration::ZERO);
    if said.is_none() {
        limits.refresh = MODELS.iter().map(|model| model.refresh()).max().unwrap_or(limits.refresh);
    }
    limits.speed_rpm = options.most_rpm.or(limits.speed_rpm);
    limits.speed_mm_s = options.most_mm_s.or(limits.speed_mm_s);
    limits
}

fn said(options: &Options) -> Option<Model> {
    options.model.or(options.active.map(|active| active.model))
}

/// For a shaft whose scaling is not known: no position has more steps a turn than the finest sensor [R99, R100].
fn assumed(limits: &Limits, model: Option<Model>) -> Swiftest {
    let finest = |model: &Model| model.steps_per_turn().last().copied().map_or(0, i64::from);
    let steps = match &model {
        Some(model) => finest(model),
        None => MODELS.iter().map(finest).max().unwrap_or_default(),
    };
    let per_turn = |limit: Option<NonZeroU32>| limit.map(|limit| i64::from(limit.get()) * steps);
    Swiftest {
        steps_per_s: per_turn(limits.speed_rpm).map(|steps| steps / 60),
        // 710/113 is a little more than the radians of a turn.
        steps_per_s2: per_turn(limits.acceleration_rad_s2).map(|steps| steps * 113 / 710 + 1),
    }
}
