//! A diagnosis beside the truth: what was named, how sure, and whether it was so.

use std::collections::BTreeMap;
use std::str::FromStr;

use encoring_diagnosis::{
    ActiveValues, Detector, Episode, JumpCause, KnownPlace, Likelihood, Options, Sample,
};
use encoring_trace::Reader;
use encoring_words::model::Sensor;
use encoring_words::{Model, Parameter, ParameterSet};

use crate::corpus::Case;
use crate::device::Kind;
use crate::file;
use crate::plan::Plan;
use crate::stage::Jump;

/// Rows by which a finding may lie beside its jump.
const BESIDE: u64 = 3;
/// Alternatives that count.
const ALTERNATIVES: usize = 3;

/// A cause that was named for a jump, or where there was none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Named {
    pub(crate) seed: u64,
    pub(crate) line: u64,
    pub(crate) cause: &'static str,
    pub(crate) certainty: Likelihood,
    /// The cause of the jump there; none: nothing jumped.
    pub(crate) truth: Option<&'static str>,
}

impl Named {
    pub(crate) fn is_right(&self) -> bool {
        self.truth == Some(self.cause)
    }
}

/// A jump, and what was said of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) seed: u64,
    pub(crate) cause: &'static str,
    pub(crate) line: u64,
    pub(crate) decidable: bool,
    pub(crate) decidable_within_the_data_sheet: bool,
    /// The cause was named, or is among the alternatives.
    pub(crate) told: bool,
    /// Another cause was given as certain or likely.
    pub(crate) wrongly_sure: bool,
    /// What was named, in the order of certainty.
    pub(crate) named: Vec<&'static str>,
}

/// What came of many recordings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Score {
    pub(crate) recordings: u64,
    pub(crate) named: Vec<Named>,
    pub(crate) seen: Vec<Seen>,
}

impl Score {
    pub(crate) fn of(seeds: impl Iterator<Item = u64>) -> Self {
        let mut score = Self::default();
        for seed in seeds {
            let case = Case::of(seed);
            score.add(&case, &diagnosed(&case));
        }
        score
    }

    /// The same over several threads.
    pub(crate) fn of_many(seeds: &[u64]) -> Self {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let share = seeds.len().div_ceil(threads).max(1);
        std::thread::scope(|scope| {
            let parts: Vec<_> =
                seeds.chunks(share).map(|part| scope.spawn(|| Self::of(part.iter().copied()))).collect();
            let mut whole = Self::default();
            for part in parts.into_iter().filter_map(|part| part.join().ok()) {
                whole.recordings += part.recordings;
                whole.named.extend(part.named);
                whole.seen.extend(part.seen);
            }
            whole
        })
    }

    fn add(&mut self, case: &Case, episodes: &[Episode]) {
        self.recordings += 1;
        let mut named: BTreeMap<(Option<usize>, &'static str), Named> = BTreeMap::new();
        for episode in episodes.iter().filter(|episode| episode.cause != JumpCause::Unclear) {
            let Some(jump) = place(case, episode) else { continue };
            let truth = jump.and_then(|at| case.jumps.get(at)).map(|jump| jump.cause.name());
            let new = Named {
                seed: case.seed,
                line: episode.line,
                cause: episode.cause.name(),
                certainty: episode.certainty,
                truth,
            };
            let kept = named.entry((jump, new.cause)).or_insert_with(|| new.clone());
            kept.certainty = kept.certainty.max(new.certainty);
        }
        let sure = |at: usize, jump: &Jump| {
            named.iter().any(|((of, cause), named)| {
                *of == Some(at) && *cause != jump.cause.name() && named.certainty >= Likelihood::Likely
            })
        };
        for (at, jump) in case.jumps.iter().enumerate() {
            let there: Vec<&Episode> = episodes.iter().filter(|episode| meets(case, jump, episode)).collect();
            let mut ordered = there.clone();
            ordered.sort_by_key(|episode| std::cmp::Reverse(episode.certainty));
            let is = |cause: &JumpCause| cause.name() == jump.cause.name();
            let told = there
                .iter()
                .any(|episode| is(&episode.cause) || episode.alternatives.iter().take(ALTERNATIVES).any(is));
            self.seen.push(Seen {
                seed: case.seed,
                cause: jump.cause.name(),
                line: Case::line(jump.from),
                decidable: jump.rivals.is_empty(),
                decidable_within_the_data_sheet: jump.rivals_of_sheet.is_empty(),
                told,
                wrongly_sure: sure(at, jump),
                named: ordered.iter().map(|episode| episode.cause.name()).take(3).collect(),
            });
        }
        self.named.extend(named.into_values());
    }
}

/// What the diagnosis says of a recording, read from its file.
pub(crate) fn diagnosed(case: &Case) -> Vec<Episode> {
    let plan = &case.plan;
    let known =
        case.known.iter().map(|(us, steps)| KnownPlace { time_ns: us * 1_000, steps: *steps }).collect();
    let model = Model::from_str(plan.device.model).ok();
    let mut detector = Detector::new(Options {
        model: model.filter(|_| plan.model_told),
        active: model.filter(|_| plan.scaling_told).map(|model| active(model, plan)),
        known,
        ..Options::default()
    });
    let text = file::table(case);
    let Ok(reader) = Reader::new("corpus", text.as_bytes()) else { return Vec::new() };
    for sample in reader.filter_map(|row| Sample::of_row(&row.ok()?)) {
        detector.sample(sample);
    }
    detector.finish().episodes
}

/// The values of the encoder, as a backup would have them.
fn active(model: Model, plan: &Plan) -> ActiveValues {
    let native = plan.device.native as u32;
    let sensor = match plan.device.kind {
        Kind::Shaft => Sensor::Rotary { steps_per_turn: native },
        Kind::Rod => Sensor::Linear { rod_um: native },
    };
    let mut parameters = ParameterSet::factory(model, sensor);
    let values = [
        (Parameter::CountingDirection, i64::from(plan.scaling.falling)),
        (Parameter::MeasuringLength, plan.scaling.length),
        (Parameter::Numerator, plan.scaling.numerator),
        (Parameter::Denominator, plan.scaling.denominator),
    ];
    for (parameter, value) in values {
        parameters.set(parameter, value as u32);
    }
    ActiveValues { model, sensor, parameters }
}

/// Whether a finding is about the rows of a jump.
fn meets(case: &Case, jump: &Jump, episode: &Episode) -> bool {
    episode.position == 0 && overlap(case, (jump.from, jump.to), episode)
}

fn overlap(case: &Case, (from, to): (usize, usize), episode: &Episode) -> bool {
    let beside = if case.plan.neighbour { 2 * BESIDE } else { BESIDE };
    episode.line <= Case::line(to) + beside && episode.to_line + beside >= Case::line(from)
}

/// The jump that a finding is about, the one of its cause first; `Some(None)` if there is none, `None` if the cause may be
/// named here all the same.
fn place(case: &Case, episode: &Episode) -> Option<Option<usize>> {
    let there = || case.jumps.iter().enumerate().filter(|(_, jump)| meets(case, jump, episode));
    let name = episode.cause.name();
    let same = there().find(|(_, jump)| jump.cause.name() == name);
    let allowed = case.allowed.iter().any(|allowed| {
        allowed.cause.name() == name
            && episode.position == 0
            && overlap(case, (allowed.from, allowed.to), episode)
    });
    match (same, allowed) {
        (Some((at, _)), _) => Some(Some(at)),
        (None, true) => None,
        // A jump of a row lies within a stretch: it is the one that is meant.
        (None, false) => Some(there().min_by_key(|(_, jump)| jump.to - jump.from).map(|(at, _)| at)),
    }
}
