//! Clean logs as a poller makes them: each row has the time of a poll, and a word that the ring and the encoder made some time
//! before. Nothing jumps in them.

use std::fmt;

use encoring_diagnosis::{Detector, Episode, JumpCause, Options, Sample, Sighting};
use encoring_words::Model;

use crate::chance::Chance;
use crate::device::{Device, Kind, Scaling};
use crate::plan::{Plan, limits};
use crate::travel::{Axis, Manner, Travel};

/// Milliseconds from poll to poll.
const PERIODS_MS: [f64; 11] = [2.0, 5.0, 10.0, 10.0, 20.0, 20.0, 50.0, 100.0, 100.0, 500.0, 1_000.0];

/// How words come to be rows. Times in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Polling {
    pub(crate) period: f64,
    /// From one cycle of the ring to the next: a word is as old as that at most when it is read.
    pub(crate) ring: f64,
    /// How much later than its time a poll comes, usually, and how much later one in a hundred does.
    pub(crate) late: f64,
    pub(crate) very_late: f64,
    /// How far the stamp lies from when the word was read.
    pub(crate) stamp: f64,
}

impl Polling {
    pub(crate) fn draw(chance: &mut Chance) -> Self {
        let period = chance.of(&PERIODS_MS, 10.0) / 1_000.0;
        let late = chance.scaled(0.000_1, 0.005).min(period * 0.6);
        Self {
            period,
            ring: chance.scaled(0.000_5, 0.014),
            late,
            very_late: if chance.percent(50) { late * chance.real(1.0, 10.0) } else { late },
            stamp: chance.scaled(0.000_02, 0.005).min(late),
        }
    }

    /// When the word of a row was read, and the stamp of the row.
    pub(crate) fn read(&self, row: usize, chance: &mut Chance) -> (f64, f64) {
        let late = if chance.percent(1) { self.very_late } else { self.late };
        let read = 0.02 + row as f64 * self.period + late * chance.part();
        let stamp = if chance.percent(1) { self.stamp.max(self.very_late / 5.0) } else { self.stamp };
        (read, read + stamp * chance.real(-0.2, 0.8))
    }

    /// When the ring fetched the word that is read at a time.
    pub(crate) fn fetched(&self, read: f64, phase: f64) -> f64 {
        ((read - phase) / self.ring).floor() * self.ring + phase
    }
}

/// What was found in a log of several encoders.
#[derive(Clone, Debug)]
pub(crate) struct Alarms {
    pub(crate) seed: u64,
    pub(crate) rows: usize,
    pub(crate) polling: Polling,
    pub(crate) found: Vec<Episode>,
    pub(crate) axes: Vec<String>,
}

/// An encoder of a log.
struct Encoder {
    device: Device,
    scaling: Scaling,
    travel: Travel,
    is_told: bool,
}

impl Encoder {
    fn draw(polling: &Polling, lasting: f64, chance: &mut Chance) -> (Self, String) {
        let plan = Plan::draw(chance);
        let Plan { device, scaling, .. } = plan;
        let axis = axis(&device, polling.period, lasting, chance);
        let travel = Travel::new(&axis, lasting, chance);
        let shown = scaling.shown(&device);
        let told = format!(
            "{} {:?} with {:.0} steps/s, {:.0} steps/s^2",
            device.model,
            axis.manner,
            axis.speed * shown,
            axis.acceleration * shown
        );
        (Self { device, scaling, travel, is_told: plan.scaling_told }, told)
    }

    fn word(&self, fetched: f64, phase: f64) -> u32 {
        let refresh = self.device.refresh_us as f64 / 1e6;
        let sampled = ((fetched - phase) / refresh).floor() * refresh + phase;
        self.scaling.value(&self.device, self.travel.place(sampled.max(0.0)).floor() as i64) as u32
    }
}

/// Any motion that the data sheet allows.
fn axis(device: &Device, period: f64, lasting: f64, chance: &mut Chance) -> Axis {
    let (most, top) = limits(device);
    let manner = chance.of(
        &[Manner::Stands, Manner::Runs, Manner::Runs, Manner::Changes, Manner::Strokes, Manner::Swings],
        Manner::Runs,
    );
    let acceleration = chance.scaled(most / 1_000.0, most);
    let speed = chance.scaled(top / 2_000.0, top).min(acceleration * lasting / 6.0);
    let holds = (period * 10.0, (period * 500.0).max(speed / acceleration));
    let ends =
        (device.kind == Kind::Rod).then_some((0.03 * device.native as f64, 0.97 * device.native as f64));
    Axis { speed, acceleration, holds, ends, manner }
}

/// Makes a clean log and tells what the diagnosis finds in it, but the ends of the range.
pub(crate) fn alarms(seed: u64) -> Alarms {
    let mut chance = Chance::new(seed);
    let polling = Polling::draw(&mut chance);
    let rows = chance.scaled(20.0, 1_500.0) as usize;
    let lasting = polling.period * (rows as f64 + 10.0);
    let (encoders, axes): (Vec<Encoder>, Vec<String>) =
        (0..chance.between(1, 3)).map(|_| Encoder::draw(&polling, lasting, &mut chance)).unzip();
    let mut detector = Detector::new(Options::default());
    for (position, encoder) in (0..).zip(&encoders) {
        let model = encoder.device.model.parse::<Model>().ok().filter(|_| encoder.is_told);
        detector = detector.about(position, Options { model, ..Options::default() });
    }
    let (phase, sampling) = (chance.part() * polling.ring, chance.part() * 0.0005);
    let mut last = 0;
    for row in 0..rows {
        let (read, stamp) = polling.read(row, &mut chance);
        let fetched = polling.fetched(read, phase);
        last = last.max((stamp * 1e9) as u64);
        for (position, encoder) in (0..).zip(&encoders) {
            let reading = Sighting::Word(encoder.word(fetched, sampling));
            let line = (row * encoders.len() + usize::from(position)) as u64 + 2;
            detector.sample(Sample { line, time_ns: last, position, out: Some(0), reading });
        }
    }
    let found = detector.finish().episodes;
    // Where polls come faster than the words, it beats.
    let is_true = |cause: JumpCause| match cause {
        JumpCause::Wrap => true,
        JumpCause::Aliasing => polling.period < 4.0 * polling.ring.max(0.001),
        _ => false,
    };
    let found = found.into_iter().filter(|episode| !is_true(episode.cause)).collect();
    Alarms { seed, rows, polling, found, axes }
}

impl fmt::Display for Alarms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, rows, polling, found, axes } = self;
        let Polling { period, ring, late, very_late, stamp } = polling;
        let ms = [period, ring, late, very_late, stamp].map(|time| (time * 1e5).round() / 100.0);
        let [period, ring, late, very_late, stamp] = ms;
        write!(
            f,
            "log {seed}: {rows} rows, {period} ms, ring {ring} ms, late by {late} or {very_late}, stamp {stamp}; {} findings",
            found.len()
        )?;
        for episode in found.iter().take(4) {
            let Episode { line, position, cause, certainty, evidence, .. } = episode;
            let axis = axes.get(usize::from(*position)).map_or("", String::as_str);
            write!(f, "\n  line {line}, {axis}: {} {certainty}: {evidence:?}", cause.name())?;
        }
        Ok(())
    }
}
