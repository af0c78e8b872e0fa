//! Every cause, as it comes into the rows. A function returns `false` where it cannot happen.

use crate::cause::{Cause, Trace};
use crate::chance::Chance;
use crate::device::{Kind, Scaling, from_gray, to_gray};
use crate::scene::Column;
use crate::stage::Stage;

/// The last of the positions that a word can hold.
const LARGEST: i64 = 0x00FF_FFFF;

/// A place for a jump: rows between which nothing else happens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// No other slot follows.
    pub(crate) last: bool,
}

impl Slot {
    fn row(&self, chance: &mut Chance) -> usize {
        let third = (self.to - self.from) / 3;
        self.from + third / 2 + chance.between(0, third as i64).unsigned_abs() as usize
    }

    /// A stretch of at least so many rows: to the end of the recording, or within the slot.
    fn stretch(&self, least: usize, stage: &Stage, chance: &mut Chance) -> (usize, usize) {
        let from = self.row(chance);
        if self.last && chance.percent(35) {
            return (from, stage.last());
        }
        let rows = chance.scaled(least as f64, (self.to - from).max(least + 1) as f64) as usize;
        (from, (from + rows).min(self.to))
    }
}

/// What changes places or scalings, before the words are made.
pub(crate) fn place(cause: Cause, stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    match cause {
        Cause::Wrap => wrap(stage, slot, chance),
        Cause::Preset => preset(stage, slot, chance),
        Cause::Rescaled => rescale(stage, slot, chance),
        Cause::Direction => turn_round(stage, slot, chance),
        Cause::Mechanical => slip(stage, slot, chance),
        _ => false,
    }
}

/// What changes words.
pub(crate) fn spoil(cause: Cause, stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    match cause {
        Cause::ReplyAsPosition => reply(stage, slot, chance),
        Cause::TornWords => tear(stage, slot, chance),
        Cause::HalvesExchanged => exchange(stage, slot, chance),
        Cause::GrayAsBinary | Cause::BinaryAsGray => recode(cause, stage, slot, chance),
        Cause::SingleBit => flip(stage, slot, chance),
        Cause::StuckBit => stick(stage, slot, chance),
        Cause::Noise => scatter(stage, slot, chance),
        Cause::Frozen => freeze(stage, slot, chance),
        Cause::OtherSource => replace(stage, slot, chance),
        _ => false,
    }
}

fn wrap(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    // It is noticed as every other.
    stage.plan.device.kind == Kind::Shaft && stage.speed(row).abs() > 0.0 && stage.align(row, 0)
}

/// A service that is seen while it is carried out: OUT and reply, in so many rows before the one that shows its effect.
fn service(stage: &mut Stage, row: usize, out: u32, chance: &mut Chance) -> bool {
    let rows = (chance.real(0.02, 0.2) / stage.plan.period) as usize;
    let rows = rows.min(20);
    let from = row.saturating_sub(rows);
    if rows == 0 || from < 2 {
        return false;
    }
    let busy = from + (rows / 3).min((0.02 / stage.plan.period) as usize);
    for moment in stage.rows_mut(from, row - 1) {
        moment.out = out;
    }
    for moment in stage.rows_mut(busy, row - 1) {
        moment.reply = Some(out);
    }
    stage.allow(Cause::ReplyAsPosition, from, row);
    stage.plan.out_logged || stage.plan.column == Column::Word && busy < row
}

/// Whether services stand in the rows at all: where neither OUT nor bit 31 is kept, a reply would be a jump of its own.
fn shows_services(stage: &Stage) -> bool {
    stage.plan.out_logged || stage.plan.column == Column::Word
}

fn preset(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    let device = stage.plan.device;
    let Some(moment) = stage.row(row).copied() else { return false };
    let positions = moment.scaling.positions(&device);
    let round = chance.percent(50);
    let target = if round { 0 } else { chance.between(0, positions - 1) };
    let by_service = shows_services(stage) && chance.percent(60);
    let shown = by_service && service(stage, row, 0xC600_0000 | target as u32, chance);
    if !shown && !device.preset_inputs && stage.plan.out_logged {
        return false;
    }
    let before = stage.value(row);
    let mut scaling = moment.scaling;
    scaling.preset(&device, moment.place, target);
    let last = stage.last();
    stage.rows_mut(row, last).iter_mut().for_each(|moment| moment.scaling.offset = scaling.offset);
    let jump = stage.distance(row, before, target);
    let from = if shown { row.saturating_sub(20) } else { row };
    stage.jumped(Trace::Preset { jump, shown, round }, row, row);
    if shown && let Some(jump) = stage.jumps.last_mut() {
        jump.from = from;
    }
    true
}

/// Another scaling from a row on.
fn programmed(stage: &mut Stage, row: usize, scaling: Scaling) {
    let last = stage.last();
    stage.rows_mut(row, last).iter_mut().for_each(|moment| moment.scaling = scaling);
}

fn rescale(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    let device = stage.plan.device;
    let Some(old) = stage.row(row).map(|moment| moment.scaling) else { return false };
    let mut new = old;
    new.length = chance
        .of(&[(old.length + 1) / 2, (old.length + 1) / 4, (old.length + 1) * 4 / 5, (old.length + 1) * 2], 2)
        - 1;
    let whole = device.native * new.numerator;
    let legal = device.kind == Kind::Rod || (new.length + 1) * new.denominator <= whole;
    if new.length < 16 || new.length > LARGEST || !legal || new == old {
        return false;
    }
    let before = stage.value(row);
    let shown = shows_services(stage)
        && chance.percent(50)
        && service(stage, row, 0xC200_0000 | new.length as u32, chance);
    programmed(stage, row, new);
    let jump = stage.distance(row, before, stage.value(row));
    let ratio = (new.length + 1) as f64 / (old.length + 1) as f64;
    stage.jumped(Trace::Rescaled { jump, ratio, shown }, row, row);
    widen(stage, row, shown);
    true
}

/// A service that is shown may be named where it began.
fn widen(stage: &mut Stage, row: usize, shown: bool) {
    if let Some(jump) = stage.jumps.last_mut().filter(|_| shown) {
        jump.from = row.saturating_sub(20);
    }
}

fn turn_round(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    let Some(mut new) = stage.row(row).map(|moment| moment.scaling) else { return false };
    new.falling = !new.falling;
    let before = stage.value(row);
    let code = u32::from(new.falling);
    let shown =
        shows_services(stage) && chance.percent(50) && service(stage, row, 0xC100_0000 | code, chance);
    programmed(stage, row, new);
    let jump = stage.distance(row, before, stage.value(row));
    stage.jumped(Trace::Direction { jump, shown }, row, row);
    widen(stage, row, shown);
    true
}

fn slip(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    let shown = stage.row(row).map_or(1.0, |moment| moment.scaling.shown(&stage.plan.device));
    let steps = chance.scaled(20.0, 100_000.0).min(stage.plan.device.native as f64 * 0.4 * 100.0);
    let sign = if chance.percent(50) { 1.0 } else { -1.0 };
    let slipped = (sign * steps) as i64;
    let last = stage.last();
    stage.rows_mut(row, last).iter_mut().for_each(|moment| moment.place += slipped);
    stage.jumped(Trace::Slip { jump: steps * shown }, row, row);
    true
}

fn reply(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let (row, rows) = (slot.row(chance), chance.scaled(1.0, 12.0) as usize);
    let Some(moment) = stage.row(row).copied() else { return false };
    let Scaling { length, numerator, denominator, falling, .. } = moment.scaling;
    let rod = stage.plan.device.kind == Kind::Rod;
    let services = [
        (0x82, length),
        (0x88, 0),
        (0x81, i64::from(falling)),
        if rod { (0x84, 0) } else { (0x83, numerator) },
        if rod { (0x82, length) } else { (0x89, denominator) },
    ];
    let (code, data) = chance.of(&services, (0x88, 0));
    let told = stage.plan.scaling_told && stage.plan.model_told;
    let word = (code as u32) << 24 | data as u32;
    let jump = stage.distance(row, i64::from(stage.shown(moment.word)), i64::from(stage.shown(word)));
    stage
        .rows_mut(row.saturating_sub(1), row + rows - 1)
        .iter_mut()
        .for_each(|moment| moment.out = word & 0xFF00_0000);
    stage.rows_mut(row, row + rows - 1).iter_mut().for_each(|moment| moment.word = word);
    if stage.plan.column == Column::Word && stage.plan.out_logged {
        // The controller knows that this is no position.
        stage.allow(Cause::ReplyAsPosition, row, row + rows);
        return true;
    }
    stage.jumped(Trace::Reply { jump, known: data == 0 || told && code != 0x81 }, row, row + rows - 1);
    true
}

fn tear(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    // The halves are read one after the other within this time.
    let apart = stage.plan.period.min(0.005);
    let found = (slot.from + 5..slot.to.saturating_sub(5)).find_map(|row| {
        let (before, after) = (stage.value_before(row, apart) as u32, stage.value(row) as u32);
        let same = stage.row(row).is_some_and(|moment| moment.word == after);
        (same && before >> 16 != after >> 16).then_some((row, before, after))
    });
    let Some((row, before, after)) = found else { return false };
    let (high, low) = if chance.percent(50) { (before, after) } else { (after, before) };
    let word = high & 0xFFFF_0000 | low & 0xFFFF;
    if word == after || word == before || stage.distance(row, i64::from(word), i64::from(after)) < 60_000.0 {
        return false;
    }
    stage.rows_mut(row, row).iter_mut().for_each(|moment| moment.word = word);
    let bits = (before >> 16 ^ after >> 16).count_ones();
    if stage.plan.column == Column::Low16 {
        return true;
    }
    stage.jumped(Trace::Torn { bits }, row, row);
    true
}

fn exchange(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let one = chance.percent(20);
    let (from, to) = match slot.stretch(20, stage, chance) {
        (from, _) if one => (from, from),
        _ if slot.last && slot.from < 10 && chance.percent(30) => (0, stage.last()),
        stretch => stretch,
    };
    let travelled = travelled(stage, from, to);
    // Bit 15 comes to be bit 31, and bit 12 bit 28, which no reply has.
    let foreign =
        stage.row(from).is_some_and(|moment| moment.word & 0xDF00 != 0 && moment.word & 0x9000 != 0x8000);
    if stage.row(from).is_none_or(|moment| moment.word >> 16 == moment.word & 0xFFFF) {
        return false;
    }
    stage.rows_mut(from, to).iter_mut().for_each(|moment| moment.word = moment.word.rotate_left(16));
    stage.jumped(Trace::Exchanged { rows: (to - from + 1) as f64, travelled, foreign }, from, to);
    true
}

/// Steps that the axis travels in a stretch, to and fro.
fn travelled(stage: &Stage, from: usize, to: usize) -> f64 {
    (from..to).map(|row| stage.speed(row).abs() * stage.plan.period).sum()
}

fn recode(cause: Cause, stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    if cause == Cause::GrayAsBinary && !stage.plan.device.may_be_gray {
        return false;
    }
    let whole = slot.last && slot.from < 10 && chance.percent(60);
    let (from, to) = if whole { (0, stage.last()) } else { slot.stretch(40, stage, chance) };
    let travelled = travelled(stage, from, to);
    let other = if cause == Cause::GrayAsBinary { to_gray } else { from_gray };
    stage.rows_mut(from, to).iter_mut().for_each(|moment| moment.word = other(moment.word & 0x00FF_FFFF));
    stage.jumped(Trace::OtherCode { cause, rows: (to - from + 1) as f64, travelled }, from, to);
    true
}

fn flip(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    let width = if stage.plan.column == Column::Low16 { 15 } else { 23 };
    let bit = chance.between(2, width) as u32;
    let high = |row: usize| stage.value(row) >> 16;
    let carry = high(row) != high(row - 1) || high(row) != high(row + 1);
    stage.rows_mut(row, row).iter_mut().for_each(|moment| moment.word ^= 1 << bit);
    stage.jumped(Trace::Bit { bit, carry }, row, row);
    true
}

fn stick(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let (from, to) = slot.stretch(60, stage, chance);
    let bit = chance.between(3, 15) as u32;
    let level = u32::from(chance.percent(50)) << bit;
    let wrong: Vec<usize> = (from..=to)
        .filter(|row| stage.row(*row).is_some_and(|moment| moment.word & 1 << bit != level))
        .collect();
    let (Some(first), Some(last)) = (wrong.first().copied(), wrong.last().copied()) else { return false };
    let levels: Vec<bool> =
        stage.rows_mut(from, to).iter().map(|moment| moment.word >> bit & 1 == 1).collect();
    let changes = levels.windows(2).filter(|pair| pair.first() != pair.last()).count() as u32;
    stage.rows_mut(from, to).iter_mut().for_each(|moment| moment.word = moment.word & !(1 << bit) | level);
    stage.jumped(Trace::Stuck { bit, changes }, first, last);
    true
}

fn scatter(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let (from, to) = slot.stretch(60, stage, chance);
    let steps = chance.scaled(6.0, 3_000.0);
    for row in from..=to {
        let positions = stage.row(row).map_or(1, |moment| moment.scaling.positions(&stage.plan.device));
        let off = chance.real(-steps, steps) as i64;
        let value = (stage.value(row) + off).rem_euclid(positions) as u32;
        stage.rows_mut(row, row).iter_mut().for_each(|moment| moment.word = value);
    }
    // One that is off by up to so many is off by half of them in the mean.
    stage.jumped(Trace::Noise { steps: steps / 2.0, rows: (to - from + 1) as f64 }, from, to);
    true
}

fn freeze(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let row = slot.row(chance);
    let rows = chance.scaled(4.0, 80.0) as usize;
    let to = (row + rows).min(slot.to);
    let Some(held) = stage.row(row).map(|moment| moment.word) else { return false };
    let (before, after) = (stage.speed(row), stage.speed(to));
    let steady = (before - after).abs() <= 0.1 * before.abs();
    stage.rows_mut(row, to - 1).iter_mut().for_each(|moment| moment.word = held);
    if stage.row(to).is_none_or(|moment| moment.word == held) {
        // The axis stood: nobody can see it, and nothing jumps.
        return true;
    }
    stage.jumped(Trace::Frozen { rows: (to - row) as f64, steady }, row, to);
    true
}

fn replace(stage: &mut Stage, slot: Slot, chance: &mut Chance) -> bool {
    let (from, to) = slot.stretch(20, stage, chance);
    let Some(moment) = stage.row(from).copied() else { return false };
    let positions = moment.scaling.positions(&stage.plan.device);
    let jump = chance.real(0.05, 0.5) * positions as f64;
    let own = stage.speed(from);
    let speed = match chance.between(0, 9) {
        0..=2 => 0.0,
        3 => own,
        _ => own * chance.real(-2.0, 2.0) + chance.real(-1.0, 1.0) * stage.plan.axis.speed * 0.3,
    };
    let begin = moment.word as f64 + jump;
    let taken = moment.taken;
    for moment in stage.rows_mut(from, to) {
        let place = begin + speed * (moment.taken - taken);
        moment.word = (place as i64).rem_euclid(positions) as u32;
    }
    // Its positions begin again too.
    let round = |row: usize| {
        let taken_here = stage.row(row).map_or(taken, |moment| moment.taken);
        ((begin + speed * (taken_here - taken)) as i64).div_euclid(positions)
    };
    let wraps: Vec<usize> = (from + 1..=to).filter(|row| round(*row) != round(row - 1)).collect();
    wraps.into_iter().for_each(|row| stage.allow(Cause::Wrap, row, row));
    let returns = to < stage.last();
    let jump = jump.min(positions as f64 - jump);
    stage.jumped(Trace::Other { jump, faster: speed - own, stands: speed == 0.0, returns }, from, to);
    true
}
