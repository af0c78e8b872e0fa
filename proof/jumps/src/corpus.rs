//! One recording for each seed: its rows, what is told beside it, and the truth.

use crate::cause::{CAUSES, Cause, Trace};
use crate::chance::Chance;
use crate::device::Kind;
use crate::faults::{Slot, place, spoil};
use crate::plan::{Plan, Stamps};
use crate::stage::{Allowed, Jump, Stage};
use crate::travel::Travel;

/// Of a hundred recordings, so many have no jump.
const CLEAN: u32 = 12;
/// Rows at both ends, and beside a slot, in which nothing happens.
const QUIET: usize = 60;

/// A row of the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CaseRow {
    pub(crate) time_us: u64,
    pub(crate) position: u8,
    pub(crate) out: Option<u32>,
    /// The IN word as far as the column keeps it.
    pub(crate) word: u32,
}

/// A recording.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) plan: Plan,
    pub(crate) rows: Vec<CaseRow>,
    /// By rows of this recording.
    pub(crate) jumps: Vec<Jump>,
    pub(crate) allowed: Vec<Allowed>,
    /// Times in microseconds, and the true positions there.
    pub(crate) known: Vec<(u64, i64)>,
}

impl Case {
    pub(crate) fn of(seed: u64) -> Self {
        let mut chance = Chance::new(seed);
        let plan = Plan::draw(&mut chance);
        let stage = staged(plan, &mut chance);
        written(seed, &stage, &mut chance)
    }

    /// The line of a file in which a row stands; the header is line 1.
    pub(crate) const fn line(row: usize) -> u64 {
        row as u64 + 2
    }
}

/// Causes that a recording shall have, one for each slot.
fn wanted(chance: &mut Chance) -> Vec<Cause> {
    if chance.percent(CLEAN) {
        return Vec::new();
    }
    // The last is motion, which is none.
    let all: Vec<Cause> =
        CAUSES.iter().map(|(cause, _)| *cause).filter(|cause| *cause != Cause::Motion).collect();
    let many = if chance.percent(70) { 1 } else { chance.between(2, 3) };
    (0..many).map(|_| chance.of(&all, Cause::SingleBit)).collect()
}

fn slots(rows: usize, many: usize) -> Vec<Slot> {
    let room = (rows - 2 * QUIET) / many.max(1);
    let slot = |at: usize| {
        let from = if many == 1 { 5 } else { QUIET + at * room };
        Slot { from, to: QUIET + at * room + room - QUIET / 2, last: at + 1 == many }
    };
    (0..many).map(slot).collect()
}

fn staged(mut plan: Plan, chance: &mut Chance) -> Stage {
    let wanted = wanted(chance);
    if let Some(first) = wanted.first() {
        plan.suit(*first, chance);
    }
    let slots = slots(plan.rows, wanted.len());
    let lasting = plan.period * (plan.rows as f64 + 10.0);
    let lost = wanted.first() == Some(&Cause::ZeroLost);
    let gap = gap(&plan, slots.first(), lost, chance);
    let waited = gap.map_or(0.0, |(_, seconds)| seconds);
    let mut travel = Travel::new(&plan.axis, lasting + waited, chance);
    let too_much = match (wanted.first(), slots.first()) {
        (Some(Cause::OverSpeed), Some(slot)) => {
            over_speed(&mut plan, &mut travel, *slot, waited == 0.0, chance)
        }
        (Some(Cause::OverAcceleration), Some(slot)) => {
            over_acceleration(&mut plan, &mut travel, *slot, waited == 0.0, chance)
        }
        _ => None,
    };
    let mut stage = Stage::new(plan, travel, gap, chance);
    if let Some((trace, from, to)) = too_much {
        stage.jumped(trace, from, to);
    }
    if let (true, Some((row, _))) = (lost, gap) {
        lose_zero(&mut stage, row, chance);
    }
    let pairs: Vec<(Cause, Slot)> = wanted.into_iter().zip(slots).collect();
    for (cause, slot) in &pairs {
        place(*cause, &mut stage, *slot, chance);
    }
    if pairs.iter().any(|(cause, _)| *cause == Cause::TornWords) {
        align_carry(&mut stage, &pairs, chance);
    }
    stage.speak();
    for (cause, slot) in &pairs {
        spoil(*cause, &mut stage, *slot, chance);
    }
    stage.notice();
    stage
}

/// A gap, for a zero that is lost in it or for nothing.
fn gap(plan: &Plan, slot: Option<&Slot>, lost: bool, chance: &mut Chance) -> Option<(usize, f64)> {
    let seconds = (plan.period * chance.real(20.0, 200.0)).max(chance.real(1.0, 30.0));
    match slot {
        Some(slot) if lost => Some(((slot.from + slot.to) / 2, seconds)),
        // Between what happens and the end, where it hides nothing.
        _ if chance.percent(10) => Some((plan.rows - QUIET / 2, seconds)),
        _ => None,
    }
}

/// The zero is off by 4096 turns behind the gap [R63].
fn lose_zero(stage: &mut Stage, row: usize, chance: &mut Chance) {
    let device = stage.plan.device;
    let unseen = 4_096 * stage.plan.scaling.denominator % stage.plan.scaling.numerator == 0;
    if device.kind == Kind::Rod || unseen {
        return;
    }
    let known = chance.percent(60);
    if known {
        for row in [row - 1, row] {
            let value = stage.value(row);
            stage.known.push((row, value));
        }
    }
    let turns = if chance.percent(50) { 4_096 } else { -4_096 };
    let last = stage.last();
    stage.rows_mut(row, last).iter_mut().for_each(|moment| moment.place += turns * device.native);
    stage.jumped(Trace::ZeroLost { known }, row, row);
}

type TooMuch = Option<(Trace, usize, usize)>;

fn over_speed(
    plan: &mut Plan,
    travel: &mut Travel,
    slot: Slot,
    possible: bool,
    chance: &mut Chance,
) -> TooMuch {
    if plan.device.kind == Kind::Rod || !possible {
        return None;
    }
    let row = slot.from + (slot.to - slot.from) / 4;
    let from = row as f64 * plan.period;
    let most = plan.top_speed * chance.real(1.05, 1.8);
    let speed = if travel.speed(from) < 0.0 { -most } else { most };
    let rows = chance.scaled(10.0, 100.0);
    let acceleration =
        (plan.sheet_acceleration * 0.7).min(most / (plan.period * 20.0)).max(most / (plan.period * 100.0));
    if acceleration > plan.sheet_acceleration {
        return None;
    }
    plan.axis.acceleration = plan.axis.acceleration.max(acceleration);
    travel.burst(from, speed, rows * plan.period, (acceleration, acceleration));
    let is_over = |row: &usize| travel.speed(0.001 + *row as f64 * plan.period).abs() > plan.top_speed;
    let over: Vec<usize> = (row..plan.rows).filter(is_over).collect();
    let (first, last) = (*over.first()?, *over.last()?);
    let shown = plan.scaling.shown(&plan.device);
    let excess = (most - plan.top_speed) * shown;
    Some((Trace::OverSpeed { excess, rows: over.len() as f64 }, first, last))
}

fn over_acceleration(
    plan: &mut Plan,
    travel: &mut Travel,
    slot: Slot,
    possible: bool,
    chance: &mut Chance,
) -> TooMuch {
    if plan.device.kind == Kind::Rod || !possible {
        return None;
    }
    let row = slot.from + (slot.to - slot.from) / 3;
    let from = row as f64 * plan.period;
    let acceleration = plan.sheet_acceleration * chance.scaled(4.0, 30.0);
    let was = travel.speed(from);
    let change = plan.top_speed * chance.real(0.2, 0.9);
    let speed = if was > 0.0 { was - change } else { was + change };
    let back = plan.sheet_acceleration * 0.5;
    travel.burst(from, speed, plan.period * 80.0, (acceleration, back));
    plan.axis.acceleration = plan.axis.acceleration.max(back);
    let rows = (change / acceleration / plan.period) as usize;
    let shown = plan.scaling.shown(&plan.device);
    let trace = Trace::OverAcceleration { change: change * shown, acceleration: acceleration * shown };
    Some((trace, row, row + rows + 1))
}

/// Puts a change of the high half where words are to be torn.
fn align_carry(stage: &mut Stage, pairs: &[(Cause, Slot)], chance: &mut Chance) {
    let positions = stage.plan.scaling.positions(&stage.plan.device);
    let slot = pairs.iter().find(|(cause, _)| *cause == Cause::TornWords).map(|(_, slot)| *slot);
    let (Some(slot), true) = (slot, positions > 3 * 65_536) else { return };
    let row = (slot.from + slot.to) / 2;
    let within = (stage.speed(row).abs() * stage.plan.period.min(0.005)) as i64;
    let over = if stage.speed(row) > 0.0 {
        chance.between(0, within / 2)
    } else {
        -1 - chance.between(0, within / 2)
    };
    let carry = chance.between(1, positions / 65_536 - 1) * 65_536;
    stage.align(row, (carry + over).rem_euclid(positions));
}

/// The rows as a file has them: some missing, some twice, stamps as they are kept.
fn written(seed: u64, stage: &Stage, chance: &mut Chance) -> Case {
    let plan = &stage.plan;
    let mut rows = Vec::with_capacity(stage.moments.len() * 2);
    // Where each row of the stage stands, or the next that does.
    let mut places = Vec::with_capacity(stage.moments.len());
    let mut last_us = 0;
    for (row, moment) in stage.moments.iter().enumerate() {
        places.push(rows.len());
        // A row that shows a jump is not the one that is missing.
        let shows = stage.jumps.iter().any(|jump| row >= jump.from && row <= jump.from + 1 || row == jump.to);
        if !shows && chance.between(0, 999) < i64::from(plan.dropped) {
            continue;
        }
        let time_us = match plan.stamps {
            Stamps::Exact => (moment.taken * 1e6) as u64,
            Stamps::WholeMilliseconds => (moment.taken * 1e3) as u64 * 1_000,
        };
        last_us = time_us.max(last_us);
        let out = plan.out_logged.then_some(moment.out);
        let written = CaseRow { time_us: last_us, position: 0, out, word: stage.shown(moment.word) };
        rows.push(written);
        if chance.between(0, 999) < i64::from(plan.repeated) {
            rows.push(written);
        }
    }
    if plan.neighbour {
        (rows, places) = beside(&rows, &places, plan.out_logged);
    }
    let end = rows.len().saturating_sub(1);
    let at = |row: usize| places.get(row).copied().unwrap_or(end).min(end);
    let jumps = stage.jumps.iter().map(|jump| Jump { from: at(jump.from), to: at(jump.to), ..jump.clone() });
    let allowed = stage.allowed.iter().map(|some| Allowed { from: at(some.from), to: at(some.to), ..*some });
    let time = |row: usize| rows.get(at(row)).map_or(0, |row| row.time_us);
    Case {
        seed,
        jumps: jumps.collect(),
        allowed: allowed.collect(),
        known: stage.known.iter().map(|(row, value)| (time(*row), *value)).collect(),
        plan: plan.clone(),
        rows,
    }
}

/// The same with another encoder, which stands still, in every second row.
fn beside(rows: &[CaseRow], places: &[usize], out_logged: bool) -> (Vec<CaseRow>, Vec<usize>) {
    let out = out_logged.then_some(0);
    let both = rows.iter().flat_map(|row| [*row, CaseRow { position: 1, word: 0x1234, out, ..*row }]);
    (both.collect(), places.iter().map(|place| place * 2).collect())
}
