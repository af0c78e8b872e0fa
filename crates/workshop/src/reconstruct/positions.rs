//! What positions at known places tell: steps per turn or per millimetre, and the direction. Never the measuring length,
//! where the position begins again, or numerator and denominator apart.

use std::str::FromStr;

use encoring_words::word::DATA_MAX;
use encoring_words::{Model, Parameter};

use super::interval::{ExactNumber, Interval, less, product, reduced};
use crate::mark::{Reference, ReferenceUnit};
use crate::values::{number_of, parameters_of};

/// Half a millionth of a millimetre or degree: the unit of places, so that half a digit is a whole number.
const PER_UNIT: u128 = 2_000_000;

/// What the encoder showed at a known place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownPosition {
    /// In steps.
    pub shown: u32,
    /// Where.
    pub reference: Reference,
}

/// The way that the sensor measures: a turn of a shaft, or a whole rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasuredWay {
    /// In millimetres or degrees.
    pub length: ExactNumber,
    /// What it is counted in.
    pub unit: ReferenceUnit,
    /// The fewest steps that the sensor divides it into, from 1.
    pub fewest_steps: u32,
    /// The most.
    pub most_steps: u32,
}

/// Why positions do not tell the steps per turn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unsettled {
    /// One place tells nothing.
    #[error("{places} known position tells no scaling; give two that are far apart, and a third between them", places = .0)]
    TooFew(usize),
    /// A place is in another unit than the others, or than the gear.
    #[error("{0} is not in {unit}, as the others are", unit = .1.unit())]
    Unit(Reference, ReferenceUnit),
    /// The places are so near to each other that not even the direction is certain.
    #[error("the places are too near to each other: both directions fit; give one that is farther away")]
    TooClose,
    /// No scaling fits.
    #[error(
        "no scaling of this encoder fits: a position or a place is misread, or the position begins again at 0 more than \
         once between the first and the last place"
    )]
    NoLine,
    /// It may begin again between two of the places, or not.
    #[error(
        "these places leave open whether the position begins again at 0 between them: give a third place between them, or \
         --no-wrap if you know that it does not"
    )]
    WrapOpen,
    /// It begins again between two of the places.
    #[error("between {0} and {1} the position begins again at 0: give places on one side of that")]
    Wrap(Reference, Reference),
}

/// Whether the position may begin again at 0 between the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrapBetween {
    /// Once at most.
    Possible,
    /// Somebody knows that it does not.
    Excluded,
}

/// What the positions tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// The position rises with the place.
    pub rising: bool,
    /// The places in their order, in half millionths.
    span: (i128, i128),
    /// Steps for half a millionth of the unit.
    rate: Interval,
    way: MeasuredWay,
    largest: u32,
}

/// A scaling that gives the positions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssumedScaling {
    /// What to program.
    pub values: Vec<(Parameter, u32)>,
    /// Steps for the measured way: a turn, or the rod.
    pub steps: ExactNumber,
    /// It is the only one that a person would have chosen: a whole number of steps per turn or millimetre, or of
    /// micrometres per step.
    pub only_round_one: bool,
    /// So many steps a position between the places may be off at most, once a preset was made at one of them.
    pub off_at_most: u128,
}

impl FromStr for KnownPosition {
    type Err = String;

    /// `1000=12.5 mm`.
    #[expect(clippy::disallowed_methods, reason = "what a scale of the machine shows, with its unit")]
    fn from_str(text: &str) -> Result<Self, String> {
        let (shown, reference) = text
            .split_once('=')
            .ok_or_else(|| format!("{text:?}: write position and place, as \"1000=12.5 mm\""))?;
        Ok(Self { shown: number_of(shown.trim())?, reference: reference.parse()? })
    }
}

/// A place: where, how far off it may be, and what was shown.
#[derive(Clone, Copy)]
struct Place {
    at: i128,
    off: i128,
    shown: i128,
}

impl MeasuredWay {
    /// Half millionths of the unit in it.
    const fn units(self) -> ExactNumber {
        product((PER_UNIT, 1), self.length)
    }

    /// How far the true place may be from the last step of the sensor.
    fn grain(self) -> u128 {
        let (numerator, denominator) = self.units();
        numerator.div_ceil(denominator.saturating_mul(self.fewest_steps as u128).max(1))
    }
}

impl Line {
    /// What these positions tell.
    ///
    /// # Errors
    /// [`Unsettled`].
    pub fn of(positions: &[KnownPosition], way: MeasuredWay, wrap: WrapBetween) -> Result<Self, Unsettled> {
        if positions.len() < 2 {
            return Err(Unsettled::TooFew(positions.len()));
        }
        if let Some(other) = positions.iter().find(|known| known.reference.scale != way.unit) {
            return Err(Unsettled::Unit(other.reference, way.unit));
        }
        let mut sorted = positions.to_vec();
        sorted.sort_by_key(|known| known.reference.millionths);
        let grain = i128::try_from(way.grain()).unwrap_or(i128::MAX / 4);
        let places: Vec<Place> = sorted.iter().map(|known| Place::of(known, grain)).collect();
        let largest = sorted.iter().map(|known| known.shown).max().unwrap_or_default();
        let limit = Interval::up_to(product((u128::from(way.most_steps) + 1, 1), upside_down(way.units())));
        let straight = [1, -1].map(|sign| slope(&places, sign).and(limit));
        let wrapped = match wrap {
            WrapBetween::Possible => wraps(&places, limit, largest),
            WrapBetween::Excluded => Vec::new(),
        };
        let rate = match (straight.map(Interval::is_empty), wrapped.as_slice()) {
            ([false, false], _) => return Err(Unsettled::TooClose),
            ([true, true], []) => return Err(Unsettled::NoLine),
            ([true, true], [gap]) => {
                let place = |k: usize| sorted.get(k).map_or(Reference::ZERO, |known| known.reference);
                return Err(Unsettled::Wrap(place(*gap), place(*gap + 1)));
            }
            ([_, _], [_, ..]) => return Err(Unsettled::WrapOpen),
            ([false, true], []) => straight[0],
            ([true, false], []) => straight[1],
        };
        let ends = |place: Option<&Place>, sign: i128| place.map_or(0, |place| place.at + sign * place.off);
        let span = (ends(places.first(), -1), ends(places.last(), 1));
        Ok(Self { rising: !straight[0].is_empty(), span, rate, way, largest })
    }

    /// Steps for a turn, or for the rod: more than the first number and fewer than the second.
    #[must_use]
    pub const fn steps(&self) -> (ExactNumber, ExactNumber) {
        let steps = self.rate.times(self.way.units());
        (steps.low, steps.high)
    }

    /// The numbers of steps that a person would have chosen: none, one, or several.
    fn round_ones(&self) -> Vec<ExactNumber> {
        let steps = self.rate.times(self.way.units());
        let mut found: Vec<ExactNumber> = Vec::new();
        let mut add = |(first, count): (u128, u128), steps_of: &dyn Fn(u128) -> ExactNumber| {
            for k in first..first + count.min(2) {
                let steps = reduced(steps_of(k));
                if !found.contains(&steps) {
                    found.push(steps);
                }
            }
        };
        add(steps.whole(), &|k| (k, 1));
        if self.way.unit == ReferenceUnit::Millimetres {
            let length = self.way.length;
            add(self.rate.times((PER_UNIT, 1)).whole(), &|k| product((k, 1), length));
            if let Some(micrometres) = self.rate.times((PER_UNIT, 1)).thousandth_upside_down() {
                add(micrometres.whole(), &|k| product((1_000, k), length));
            }
        }
        found
    }

    /// The same if there is only one.
    fn only_round_one(&self) -> Option<ExactNumber> {
        match self.round_ones().as_slice() {
            [only] => Some(*only),
            _ => None,
        }
    }

    /// The roundest of them: of steps per turn or per millimetre, whichever is rounder for its size.
    fn roundest(&self) -> Option<ExactNumber> {
        let per_way = self.rate.times(self.way.units()).roundest();
        let per_mm = self.rate.times((PER_UNIT, 1)).roundest();
        let length = self.way.length;
        match (per_way, per_mm) {
            (Some((steps, unit)), Some((per_mm, unit_mm))) if self.way.unit == ReferenceUnit::Millimetres => {
                let coarser =
                    less(product((unit, 1), upside_down(steps)), product((unit_mm, 1), upside_down(per_mm)));
                Some(if coarser { product(per_mm, length) } else { steps })
            }
            (found, _) => found.map(|(steps, _)| steps),
        }
    }

    /// How far apart two scalings within the bounds can come over the whole travel, in whole steps.
    fn off(&self, steps: ExactNumber) -> u128 {
        let rate = product(steps, upside_down(self.way.units()));
        let distance = |a: ExactNumber, b: ExactNumber| -> ExactNumber {
            let (one, other) = (a.0.saturating_mul(b.1), b.0.saturating_mul(a.1));
            reduced((one.abs_diff(other), a.1.saturating_mul(b.1)))
        };
        let (below, above) = (distance(rate, self.rate.low), distance(rate, self.rate.high));
        let most = if less(below, above) { above } else { below };
        let span = (self.span.1 - self.span.0).unsigned_abs();
        let (numerator, denominator) = product(most, (span, 1));
        numerator.div_ceil(denominator.max(1)) + 1
    }

    /// A scaling of a shaft that gives these positions. The range is assumed: `turns` if somebody knows it, else as many
    /// as can be, up to 4096.
    #[must_use]
    pub fn shaft(&self, turns: Option<u32>) -> Option<AssumedScaling> {
        let only = self.only_round_one();
        let bounds = self.rate.times(self.way.units());
        let candidates = [only, self.roundest(), Some(bounds.simplest())];
        let fits =
            |steps: ExactNumber| self.range(steps, turns).map(|(length, turns)| (steps, length, turns));
        let (steps, length, turns) = candidates
            .into_iter()
            .flatten()
            .filter(|steps| bounds.contains(*steps))
            .find_map(fits)
            .or_else(|| self.nearest(bounds, turns))?;
        let only_round_one = only == Some(steps);
        let direction = (Parameter::CountingDirection, u32::from(!self.rising));
        let values = vec![
            direction,
            (Parameter::MeasuringLength, length),
            (Parameter::Numerator, turns),
            (Parameter::Denominator, 1),
        ];
        Some(AssumedScaling { values, steps, only_round_one, off_at_most: self.off(steps) })
    }

    /// A scaling of a rod that gives these positions.
    #[must_use]
    pub fn rod(&self, model: Model) -> Option<AssumedScaling> {
        let bounds = self.rate.times(self.way.units());
        // The measuring length of a rod is a whole number.
        let whole = |steps: Option<ExactNumber>| steps.filter(|steps| steps.1 == 1);
        let (first, count) = bounds.whole();
        let (steps, only_round_one) = match (count, whole(self.only_round_one()), whole(self.roundest())) {
            (0, ..) => return None,
            (1, ..) => ((first, 1), true),
            (_, Some(only), _) => (only, true),
            (_, None, Some(roundest)) => (roundest, false),
            _ => ((first + (count - 1) / 2, 1), false),
        };
        let length = u32::try_from(steps.0).ok().filter(|length| *length <= DATA_MAX)?;
        let values = vec![
            (Parameter::CountingDirection, u32::from(!self.rising)),
            (Parameter::MeasuringLength, length),
        ];
        let values =
            values.into_iter().filter(|(parameter, _)| parameters_of(model).any(|has| has == *parameter));
        Some(AssumedScaling { values: values.collect(), steps, only_round_one, off_at_most: self.off(steps) })
    }

    /// Measuring length and turns for so many steps per turn: whole numbers, and every position that was seen within.
    fn range(&self, steps: ExactNumber, turns: Option<u32>) -> Option<(u32, u32)> {
        let (numerator, denominator) = steps;
        let of = |turns: u32| {
            let positions = numerator.checked_mul(turns.into()).filter(|all| all % denominator == 0)?;
            let length = u32::try_from(positions / denominator).ok()?.checked_sub(1)?;
            let fits = (0x10.max(self.largest)..=DATA_MAX).contains(&length);
            fits.then_some((length, turns))
        };
        if let Some(turns) = turns {
            return of(turns);
        }
        // A power of two loses no zero; else a multiple of the denominator.
        let powers = (0..=12).rev().map(|power| 1_u32 << power);
        let denominator = u32::try_from(denominator).ok().filter(|denominator| *denominator <= 0xFFFF)?;
        let multiples = (1..=0xFFFF / denominator).rev().map(|factor| factor * denominator);
        powers.chain(multiples).find_map(of)
    }

    /// With a rounded measuring length, where no simple fraction fits.
    fn nearest(&self, bounds: Interval, turns: Option<u32>) -> Option<(ExactNumber, u32, u32)> {
        let turns = turns.map_or_else(|| vec![4096, 2048, 1024, 512, 0xFFFF], |turns| vec![turns]);
        turns.into_iter().find_map(|turns| {
            let (first, count) = bounds.times((turns.into(), 1)).whole();
            let positions = (count > 0).then(|| first + (count - 1) / 2)?;
            let steps = reduced((positions, turns.into()));
            let (length, turns) = self.range(steps, Some(turns))?;
            Some((steps, length, turns))
        })
    }
}

impl Place {
    fn of(known: &KnownPosition, grain: i128) -> Self {
        let Reference { millionths, digit, .. } = known.reference;
        Self { at: i128::from(millionths) * 2, off: i128::from(digit) + grain, shown: known.shown.into() }
    }
}

const fn upside_down((numerator, denominator): ExactNumber) -> ExactNumber {
    (denominator, numerator)
}

/// The rates at which all of these positions can be shown; `sign` is -1 if the position falls with the place.
fn slope(places: &[Place], sign: i128) -> Interval {
    let mut rate = Interval::ALL;
    for (k, from) in places.iter().enumerate() {
        for to in places.iter().skip(k + 1) {
            let steps = sign * (to.shown - from.shown);
            rate = rate.and(between(from, to, steps));
        }
    }
    rate
}

/// The rates at which the position makes so many steps between two places, each position rounded down.
fn between(from: &Place, to: &Place, steps: i128) -> Interval {
    let (way, off) = (to.at - from.at, from.off + to.off);
    let (longest, shortest) = ((way + off).unsigned_abs(), way - off);
    let low = if steps > 1 { ((steps - 1).unsigned_abs(), longest) } else { (0, 1) };
    let high = match (steps + 1, shortest) {
        (..=0, 1..) => (0, 1),
        (_, ..=0) => Interval::ALL.high,
        (most, shortest) => (most.unsigned_abs(), shortest.unsigned_abs()),
    };
    Interval { low, high }
}

/// The gaps in which the position can begin again at 0, if it does so once.
fn wraps(places: &[Place], limit: Interval, largest: u32) -> Vec<usize> {
    let gaps = 0..places.len().saturating_sub(1);
    gaps.filter(|gap| [1, -1].into_iter().any(|sign| wraps_in(places, *gap, sign, limit, largest))).collect()
}

/// Whether there are a rate and a number of positions with which the position begins again in this gap.
fn wraps_in(places: &[Place], gap: usize, sign: i128, limit: Interval, largest: u32) -> bool {
    let (before, after) = places.split_at(gap + 1);
    let rate = slope(before, sign).and(slope(after, sign)).and(limit);
    if rate.is_empty() {
        return false;
    }
    // As many positions as lie between the bounds for every pair; rounded so that what may be is not left out.
    let (mut fewest, mut most) = (i128::from(largest) + 1, i128::from(DATA_MAX) + 1);
    for from in before {
        for to in after {
            let steps = sign * (to.shown - from.shown);
            let (way, off) = (to.at - from.at, from.off + to.off);
            let reach = product(rate.high, ((way + off).unsigned_abs(), 1));
            let least = product(rate.low, ((way - off).max(0).unsigned_abs(), 1));
            most = most.min(signed(reach.0.div_ceil(reach.1)) - steps + 1);
            fewest = fewest.max(signed(least.0 / least.1) - steps - 1);
        }
    }
    fewest <= most
}

fn signed(number: u128) -> i128 {
    i128::try_from(number).unwrap_or(i128::MAX / 4)
}
