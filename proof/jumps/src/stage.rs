//! The rows of a recording while it is made.

use crate::cause::{Cause, Trace};
use crate::chance::Chance;
use crate::decidable::rivals;
use crate::device::{Kind, Scaling};
use crate::plan::Plan;
use crate::scene::{Column, Scene};
use crate::travel::Travel;

/// A row under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// When it was taken, in seconds.
    pub(crate) taken: f64,
    /// Where the sensor was at the encoder's sample.
    pub(crate) place: i64,
    pub(crate) scaling: Scaling,
    pub(crate) word: u32,
    pub(crate) out: u32,
    /// The reply of a service that is carried out here.
    pub(crate) reply: Option<u32>,
}

/// A jump that was made, by rows.
#[derive(Clone, Debug)]
pub(crate) struct Jump {
    pub(crate) cause: Cause,
    /// The first row that shows it, and the last.
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Who else can make these rows, if the axis can do what it can, and what the data sheet allows.
    pub(crate) rivals: Vec<Cause>,
    pub(crate) rivals_of_sheet: Vec<Cause>,
}

/// Rows in which a cause may be named though no jump counts there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowed {
    pub(crate) cause: Cause,
    pub(crate) from: usize,
    pub(crate) to: usize,
}

/// Everything that a fault can change.
pub(crate) struct Stage {
    pub(crate) plan: Plan,
    pub(crate) travel: Travel,
    pub(crate) moments: Vec<Moment>,
    pub(crate) jumps: Vec<Jump>,
    pub(crate) allowed: Vec<Allowed>,
    /// Known places: the row and the true position.
    pub(crate) known: Vec<(usize, i64)>,
    /// The zero was chosen for a jump.
    pub(crate) aligned: bool,
}

impl Stage {
    pub(crate) fn new(plan: Plan, travel: Travel, gap: Option<(usize, f64)>, chance: &mut Chance) -> Self {
        let phase = chance.part() * plan.device.refresh_us as f64 / 1e6;
        let mut moments = Vec::with_capacity(plan.rows);
        for row in 0..plan.rows {
            let waited = gap.filter(|(at, _)| row >= *at).map_or(0.0, |(_, seconds)| seconds);
            let taken = 0.001 + row as f64 * plan.period + waited + plan.late * chance.part();
            let place = sampled(&plan, &travel, taken, phase);
            moments.push(Moment { taken, place, scaling: plan.scaling, word: 0, out: 0, reply: None });
        }
        Self {
            plan,
            travel,
            moments,
            jumps: Vec::new(),
            allowed: Vec::new(),
            known: Vec::new(),
            aligned: false,
        }
    }

    pub(crate) fn row(&self, row: usize) -> Option<&Moment> {
        self.moments.get(row)
    }

    /// The rows from one to another, both included.
    pub(crate) fn rows_mut(&mut self, from: usize, to: usize) -> &mut [Moment] {
        let to = (to + 1).min(self.moments.len());
        self.moments.get_mut(from.min(to)..to).unwrap_or_default()
    }

    pub(crate) fn last(&self) -> usize {
        self.moments.len().saturating_sub(1)
    }

    pub(crate) fn value(&self, row: usize) -> i64 {
        self.row(row).map_or(0, |moment| moment.scaling.value(&self.plan.device, moment.place))
    }

    /// The position a little before a row was taken.
    pub(crate) fn value_before(&self, row: usize, seconds: f64) -> i64 {
        let Some(moment) = self.row(row) else { return 0 };
        let passed = self.travel.place(moment.taken) - self.travel.place(moment.taken - seconds);
        moment.scaling.value(&self.plan.device, moment.place - passed.floor() as i64)
    }

    /// Chooses the zero so that a row shows a value; once.
    pub(crate) fn align(&mut self, row: usize, value: i64) -> bool {
        let Some(mut scaling) = self.row(row).map(|moment| moment.scaling) else { return false };
        if std::mem::replace(&mut self.aligned, true) {
            return false;
        }
        let device = self.plan.device;
        scaling.preset(&device, self.row(row).map_or(0, |moment| moment.place), value);
        self.moments.iter_mut().for_each(|moment| moment.scaling.offset = scaling.offset);
        self.plan.scaling = scaling;
        true
    }

    /// Writes the words; what changes places and scalings comes before, what changes words behind.
    pub(crate) fn speak(&mut self) {
        let device = self.plan.device;
        for moment in &mut self.moments {
            moment.word = moment.reply.unwrap_or(moment.scaling.value(&device, moment.place) as u32);
        }
    }

    /// Steps a second that are shown at a row.
    pub(crate) fn speed(&self, row: usize) -> f64 {
        let shown = self.row(row).map_or(1.0, |moment| moment.scaling.shown(&self.plan.device));
        let taken = self.row(row).map_or(0.0, |moment| moment.taken);
        let falls = self.row(row).is_some_and(|moment| moment.scaling.falling);
        self.travel.speed(taken) * if falls { -shown } else { shown }
    }

    /// The shorter way from one position to another.
    pub(crate) fn distance(&self, row: usize, from: i64, to: i64) -> f64 {
        let positions = self.row(row).map_or(1, |moment| moment.scaling.positions(&self.plan.device));
        let up = (to - from).rem_euclid(positions);
        up.min(positions - up) as f64
    }

    /// What is known of the place of a jump.
    pub(crate) fn scene(&self, row: usize, acceleration: f64) -> Scene {
        let plan = &self.plan;
        let scaling = self.row(row).map_or(plan.scaling, |moment| moment.scaling);
        let shown = scaling.shown(&plan.device);
        let taken = self.row(row).map_or(0.0, |moment| moment.taken);
        let (from, to) = self.travel.steady(taken);
        let steady = (taken - from).min(to - taken).min(plan.period * 500.0) / plan.period;
        Scene {
            period: plan.period,
            jitter: plan.jitter(),
            refresh: plan.device.refresh_us as f64 / 1e6,
            positions: scaling.positions(&plan.device) as f64,
            speed: (self.travel.speed(taken) * shown).abs(),
            top_speed: plan.top_speed * shown,
            acceleration: acceleration * shown,
            column: plan.column,
            out_logged: plan.out_logged,
            parameters_told: plan.scaling_told && plan.model_told,
            no_preset_inputs: plan.model_told && !plan.device.preset_inputs,
            steady_rows: steady,
        }
    }

    /// Notes a jump that shows from a row to a row.
    pub(crate) fn jumped(&mut self, trace: Trace, from: usize, to: usize) {
        let of = |acceleration| rivals(&self.scene(from, acceleration), &trace);
        let acceleration = if self.plan.axis.speed > 0.0 { self.plan.axis.acceleration } else { 0.0 };
        let jump = Jump {
            cause: trace.cause(),
            from,
            to: to.min(self.last()),
            rivals: of(acceleration),
            rivals_of_sheet: of(self.plan.sheet_acceleration),
        };
        self.jumps.push(jump);
    }

    pub(crate) fn allow(&mut self, cause: Cause, from: usize, to: usize) {
        self.allowed.push(Allowed { cause, from, to });
    }

    /// The word as it stands in the rows.
    pub(crate) fn shown(&self, word: u32) -> u32 {
        match self.plan.column {
            Column::Word => word,
            Column::Low24 | Column::Decimal => word & 0x00FF_FFFF,
            Column::Low16 => word & 0xFFFF,
        }
    }

    /// Wraps and beats that come about by themselves.
    pub(crate) fn notice(&mut self) {
        self.notice_wraps();
        self.notice_beats();
    }

    fn notice_wraps(&mut self) {
        if self.plan.column == Column::Low16 {
            // 65536 positions, whatever S is: the reader sees wraps that are none of the encoder's.
            self.allow(Cause::Wrap, 0, self.last());
            return;
        }
        let device = self.plan.device;
        let mut wraps = Vec::new();
        for (row, pair) in self.moments.windows(2).enumerate() {
            let [before, after] = pair else { continue };
            // Nobody sees where the axis went in a gap.
            let follows = after.taken - before.taken < 2.0 * self.plan.period;
            if follows
                && before.scaling == after.scaling
                && before.scaling.round(&device, before.place) != after.scaling.round(&device, after.place)
            {
                wraps.push(row + 1);
            }
        }
        let lost = self.scene(wraps.first().copied().unwrap_or(0), self.plan.axis.acceleration).loses_count();
        let times = wraps.len() as u32;
        let mut counted = 0;
        for row in wraps {
            let hidden = self.jumps.iter().any(|jump| row + 2 >= jump.from && row <= jump.to + 2);
            self.allow(Cause::Wrap, row, row);
            if !hidden && !lost && counted < 2 && device.kind == Kind::Shaft {
                counted += 1;
                self.jumped(Trace::Wrap { times }, row, row);
            }
        }
    }

    fn notice_beats(&mut self) {
        let refresh = self.plan.device.refresh_us as f64 / 1e6;
        if self.plan.period > 4.0 * refresh {
            return;
        }
        self.allow(Cause::Aliasing, 0, self.last());
        let moving = |row: &usize| self.speed(*row).abs() * refresh > 3.0;
        let rows: Vec<usize> = (0..self.moments.len()).filter(moving).collect();
        if let (Some(first), Some(last)) = (rows.first(), rows.last())
            && rows.len() > 60
            && self.plan.period < refresh / 1.4
        {
            let trace = Trace::Aliased;
            let middle = rows.get(rows.len() / 2).copied().unwrap_or(0);
            let rivals = rivals(&self.scene(middle, self.plan.axis.acceleration), &trace);
            let jump = Jump {
                cause: Cause::Aliasing,
                from: *first,
                to: *last,
                rivals_of_sheet: rivals.clone(),
                rivals,
            };
            self.jumps.push(jump);
        }
    }
}

/// Where the sensor is at the encoder's last sample before a time.
fn sampled(plan: &Plan, travel: &Travel, taken: f64, phase: f64) -> i64 {
    let refresh = plan.device.refresh_us as f64 / 1e6;
    let sample = ((taken - phase) / refresh).floor() * refresh + phase;
    travel.place(sample.max(0.0)).floor() as i64
}
