//! The causes of jumps while encoders are looked at, each told a few polls behind its jump.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use encoring_bus::watch::{Poll, Sight, Subject};
use encoring_bus::{Insight, Judge, Judgement, Tolerance};
use encoring_diagnosis::{ActiveValues, Counted, Episode, FoundView, Options, Recent, Sample, Sighting};
use encoring_host::validity::Stop;

/// A cause that was found, and of which encoder.
#[derive(Clone, Debug)]
pub struct Caused {
    /// Its ring position.
    pub position: usize,
    /// The cause.
    pub found: FoundView,
}

/// Looks on at the polls.
#[derive(Debug, Default)]
pub struct Causes {
    recent: Recent,
    /// What was found of encoders whose positions are implausible now.
    standing: BTreeMap<usize, FoundView>,
}

impl Causes {
    /// Takes what a poll brought; returns the causes that have become known.
    pub fn take(&mut self, poll: &Poll, subjects: &[Subject]) -> Vec<Caused> {
        let mut told = Vec::new();
        for (sight, subject) in poll.sights.iter().zip(subjects) {
            let Ok(position) = u8::try_from(sight.position) else { continue };
            self.recent.sample(sample(position, poll.number, sight));
            if matches!(sight.stop, Some(Stop::Implausible(_))) {
                self.recent.jumped(position);
            }
            if !matches!(sight.verdict, Judgement::Implausible(_)) {
                self.standing.remove(&sight.position);
            }
            let episode = self.recent.cause(position, &options(&subject.judge));
            told.extend(episode.map(|episode| self.caused(sight, &episode)));
        }
        told
    }

    /// The causes of the jumps that are still waited for: no poll comes any more.
    #[must_use]
    pub fn rest(&mut self, subjects: &[Subject]) -> Vec<Caused> {
        let caused = |subject: &Subject| {
            let position = u8::try_from(subject.position).ok()?;
            let episode = self.recent.cause_so_far(position, &options(&subject.judge))?;
            Some(Caused { position: subject.position, found: FoundView::new(&episode) })
        };
        subjects.iter().filter_map(caused).collect()
    }

    /// What was found of an encoder whose positions are implausible now.
    #[must_use]
    pub fn of(&self, position: usize) -> Option<&FoundView> {
        self.standing.get(&position)
    }

    fn caused(&mut self, sight: &Sight, episode: &Episode) -> Caused {
        let found = FoundView::new(episode);
        if matches!(sight.verdict, Judgement::Implausible(_)) {
            self.standing.insert(sight.position, found.clone());
        }
        Caused { position: sight.position, found }
    }
}

fn sample(position: u8, poll: u64, sight: &Sight) -> Sample {
    let reading = match (&sight.verdict, sight.input) {
        (Judgement::RingStopped(said), input) => {
            Sighting::Unreached { said: *said, stands: input.map(|input| input.0.into()) }
        }
        (Judgement::Stale { .. } | Judgement::NoAnswer(_), _) | (_, None) => Sighting::Nothing,
        (_, Some(input)) => Sighting::Word(input.0),
    };
    // As the polls are counted for people.
    let line = poll + 1;
    Sample { line, time_ns: sight.at.as_nanos(), position, out: sight.out.map(|out| out.0), reading }
}

/// What is known of an encoder.
fn options(judge: &Judge) -> Options {
    let model = judge.model();
    let active =
        judge.insight().map(|Insight { sensor, active }| ActiveValues { model, sensor, parameters: active });
    let Tolerance { max_rpm, max_mm_s, .. } = judge.tolerance();
    Options {
        model: Some(model),
        active,
        most_rpm: max_rpm,
        most_mm_s: max_mm_s,
        counted: Counted::Polls,
        ..Options::default()
    }
}
