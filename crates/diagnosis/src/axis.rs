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
/// Of a rod nothing is permissible or not; its magnet is moved with 2 g at most, and usually with a tenth of that.
const ROD_MM_S2: u32 = 20_000;
const USUAL_OF_ROD: i64 = 10;
/// The factory resolution of a rod is 0.01 mm [R50].
const ROD_STEPS_PER_MM: i64 = 100;
/// The longest time from one cycle of a bus to the next: a word is as old as that when a poll reads it, or just new.
pub(crate) const CYCLE_NS: i64 = 15_000_000;

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
    /// What a strong axis and a usual one accelerate, in steps a second squared.
    able: [Option<i64>; 2],
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
        let is_rod = said(options).is_some_and(|model| model.sensor_kind() == SensorKind::Linear);
        let swiftest = match &given {
            Some(expectation) => expectation.swiftest(&limits),
            None => assumed(&limits, said(options)),
        };
        let able = match &given {
            _ if !is_rod => swiftest.steps_per_s2,
            Some(expectation) => {
                let strong = Limits { acceleration_mm_s2: NonZeroU32::new(ROD_MM_S2), ..limits };
                expectation.swiftest(&strong).steps_per_s2
            }
            None => Some(i64::from(ROD_MM_S2) * ROD_STEPS_PER_MM),
        };
        let usually = |able: i64| able / if is_rod { USUAL_OF_ROD } else { USUAL };
        let circle = match &given {
            Some(expectation) => expectation.circle(),
            None => Circle { positions: length.map_or(i64::from(DATA_MAX), i64::from) + 1 },
        };
        Self {
            circle,
            is_circle_known: given.is_some() || length.is_some(),
            is_scale_known: given.is_some(),
            swiftest,
            able: [able, able.map(usually)],
            refresh_ns,
        }
    }

    /// What was given is so no more: another scaling may be active.
    pub(crate) const fn forget(&mut self) {
        (self.is_circle_known, self.is_scale_known) = (false, false);
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
        self.swiftest.steps_per_s2.map(|change| bent(change, span_ns))
    }
}

impl Axis {
    /// What motion may add from one row to the next at a speed of so many steps a row: of a usual axis, and of any that is
    /// permissible. `None` without a limit.
    pub(crate) fn utmost(&self, period_ns: i64, step: i64) -> Option<[i64; 2]> {
        let late = self.late(period_ns, step);
        let travel = self.travel(period_ns).map_or(i64::MAX, |travel| travel.saturating_mul(2));
        let [strong, usual] = self.able.map(|able| {
            let bend = bent(able?, period_ns.saturating_add(self.refresh_ns));
            Some((bend / 4 * 3).saturating_add(late).min(travel))
        });
        Some([usual?, strong?.max(usual?)])
    }

    /// Steps that a row may be off at this speed, as its word is of another cycle of the bus or older than the next by a
    /// refresh, or as its time is wrong by a fifth of the period.
    pub(crate) fn late(&self, period_ns: i64, step: i64) -> i64 {
        let cycle_ns = (period_ns / 5).max(period_ns.min(CYCLE_NS));
        scaled(step.abs(), self.refresh_ns.saturating_add(cycle_ns), period_ns).saturating_add(2)
    }
}

fn bent(steps_per_s2: i64, span_ns: i64) -> i64 {
    per_second(per_second(steps_per_s2, span_ns), span_ns)
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
