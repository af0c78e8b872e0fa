//! Which other causes can make the same rows. A jump is decidable if there is none.
//!
//! A cause that would need a coincidence counts only if its chance is above one in a hundred.

use crate::cause::{Cause, Trace};
use crate::scene::{Column, Scene};

/// A coincidence that is looked upon as none.
const CHANCE: f64 = 0.01;
/// A reading of a stretch shows itself by its smoothness: rows and steps that it takes.
const STRETCH_ROWS: f64 = 8.0;
const STRETCH_STEPS: f64 = 16.0;
/// Fewer rows may be dropped or repeated ones.
const FROZEN_ROWS: f64 = 4.0;
const NOISY_ROWS: f64 = 30.0;
/// A machine vibrates with so many periods a second.
const VIBRATION_HZ: f64 = 50.0;
/// So many refresh times are fewer than two samples of the encoder for some rows.
const REFRESHES: f64 = 1.0 / 1.4;

/// The causes that can make the rows of this jump within noise.
pub(crate) fn rivals(scene: &Scene, trace: &Trace) -> Vec<Cause> {
    let moved = |jump: f64| scene.hides(jump).then_some(Cause::Motion);
    let slow = |change: f64| change < 3.0 * scene.speed_noise();
    let found: Vec<Option<Cause>> = match *trace {
        Trace::Reply { .. } if scene.column == Column::Word || scene.out_logged => Vec::new(),
        Trace::Reply { jump, known } => vec![moved(jump), (!known).then_some(Cause::OtherSource)],
        Trace::Torn { .. } if scene.column == Column::Low16 => vec![Some(Cause::Motion)],
        Trace::Torn { bits } => {
            let met = bits == 1 && scene.carries() / 24.0 > CHANCE;
            vec![moved(65_536.0), met.then_some(Cause::SingleBit)]
        }
        Trace::Exchanged { rows, travelled, foreign } => {
            let shows = rows >= STRETCH_ROWS && travelled >= STRETCH_STEPS && scene.column != Column::Low16;
            let whole = foreign && scene.column == Column::Word;
            vec![(!shows && !whole).then_some(Cause::OtherSource)]
        }
        Trace::OtherCode { rows, travelled, .. } => {
            let stands = rows < STRETCH_ROWS || travelled < STRETCH_STEPS;
            vec![stands.then_some(Cause::Motion).or(moved(travelled / 2.0))]
        }
        Trace::Wrap { .. } if scene.loses_count() => vec![Some(Cause::Motion)],
        Trace::Wrap { times } => {
            let unsure = times < 2 && !scene.parameters_told && scene.passes(scene.positions) > CHANCE;
            vec![unsure.then_some(Cause::Preset)]
        }
        Trace::Preset { shown: true, .. } => Vec::new(),
        Trace::Preset { jump, round, .. } => {
            let seen = 2.0 * (scene.speed * scene.period + scene.noise()) / scene.positions;
            vec![moved(jump), (!round || seen > CHANCE).then_some(Cause::Mechanical)]
        }
        Trace::Rescaled { shown: true, .. } | Trace::Direction { shown: true, .. } => Vec::new(),
        Trace::Rescaled { jump, ratio, .. } => {
            let equal = slow(scene.speed * (ratio - 1.0).abs());
            let by_chance = scene.speed_noise() / (scene.speed * ratio).max(1.0) > CHANCE;
            vec![moved(jump), equal.then_some(Cause::Preset), by_chance.then_some(Cause::OtherSource)]
        }
        Trace::Direction { jump, .. } => {
            let equal = slow(2.0 * scene.speed);
            vec![moved(jump), equal.then_some(Cause::Preset)]
        }
        Trace::ZeroLost { known } => vec![(!known).then_some(Cause::Motion)],
        Trace::Aliased => {
            let shows = scene.period < scene.refresh * REFRESHES && scene.speed * scene.refresh > 3.0;
            vec![(!shows).then_some(Cause::Motion)]
        }
        Trace::OverSpeed { excess, rows } => {
            let small = excess * scene.period * rows <= 3.0 * scene.noise();
            let untold = !scene.parameters_told || small || scene.loses_count();
            vec![untold.then_some(Cause::Motion), (rows < FROZEN_ROWS).then_some(Cause::Mechanical)]
        }
        Trace::OverAcceleration { change, acceleration } => {
            let span = Scene { period: scene.period.max(change / acceleration), ..*scene };
            let hidden = span.hides(change * span.period);
            vec![(!scene.parameters_told || hidden).then_some(Cause::Motion)]
        }
        Trace::Bit { bit, carry } => {
            let torn = carry && bit == 16 && scene.column != Column::Low16;
            vec![moved(f64::from(bit).exp2()), torn.then_some(Cause::TornWords)]
        }
        Trace::Stuck { bit, changes } => {
            vec![moved(f64::from(bit).exp2()), (changes < 2).then_some(Cause::Mechanical)]
        }
        Trace::Noise { steps, rows } => {
            let vibrates = scene.period * 3.0 * VIBRATION_HZ > 1.0;
            let weak = rows < NOISY_ROWS || steps <= scene.motion();
            vec![vibrates.then_some(Cause::Mechanical), weak.then_some(Cause::Motion)]
        }
        Trace::Frozen { rows, steady } => {
            let few = (rows < FROZEN_ROWS).then_some(Cause::Motion);
            let caught_up = scene.speed * scene.period * rows;
            vec![few.or(moved(caught_up)), (!steady).then_some(Cause::Mechanical)]
        }
        Trace::Other { jump, faster, stands, returns } => {
            let equal = !returns && slow(faster.abs());
            let reply = returns && stands && scene.column != Column::Word && !scene.out_logged;
            vec![
                moved(jump),
                equal.then_some(Cause::Preset),
                equal.then_some(Cause::Mechanical),
                reply.then_some(Cause::ReplyAsPosition),
            ]
        }
        Trace::Slip { jump } => {
            let preset = !(scene.out_logged && scene.no_preset_inputs);
            vec![moved(jump), preset.then_some(Cause::Preset)]
        }
    };
    found.into_iter().flatten().collect()
}
