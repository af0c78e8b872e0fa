//! The rows of a recording, encoder by encoder.

use std::collections::BTreeMap;

use crate::company;
use crate::episode::{Conclusion, Episode};
use crate::options::Options;
use crate::sample::Sample;
use crate::together::Together;
use crate::window::Window;

/// Finds the step changes of every encoder of a recording. Its memory does not grow with the recording.
#[derive(Clone, Debug)]
pub struct Detector {
    options: Options,
    /// Those of single encoders.
    about: BTreeMap<u8, Options>,
    windows: BTreeMap<u8, Window>,
    together: Together,
}

impl Detector {
    /// For a recording of which this is known.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { options, about: BTreeMap::new(), windows: BTreeMap::new(), together: Together::default() }
    }

    /// With what is known of the encoder at a ring position, instead of what is known of all.
    #[must_use]
    pub fn about(mut self, position: u8, options: Options) -> Self {
        self.about.insert(position, options);
        self
    }

    /// Takes the next row, in the order of the recording.
    pub fn sample(&mut self, sample: Sample) {
        let Self { options, about, windows, together } = self;
        let options = about.get(&sample.position).unwrap_or(options);
        let has_others = windows.len() > 1;
        let window = windows.entry(sample.position);
        let window = window.or_insert_with(|| Window::new(sample.position, options));
        window.push(&sample);
        if has_others && let Some(place) = window.place() {
            together.row(sample.position, &place);
        }
    }

    /// What has been told so far of an encoder, in the order in which it was found. The rows of the latest lie no further back than
    /// some thousand.
    #[must_use]
    pub fn told(&self, position: u8) -> &[Episode] {
        self.windows.get(&position).map_or(&[], Window::told)
    }

    /// What all rows together say.
    #[must_use]
    pub fn finish(self) -> Conclusion {
        let positions = self.windows.len();
        let mut conclusion = Conclusion::default();
        let mut judged = Vec::new();
        for lost in self.together.finish() {
            let verdict = lost.judged();
            let apart =
                self.windows.get(&lost.position).map_or_else(Vec::new, |window| window.apart(&verdict));
            judged.push((lost, verdict, apart));
        }
        for (_, window) in self.windows {
            window.finish(&mut conclusion);
        }
        for (lost, verdict, apart) in judged {
            if !conclusion.episodes.iter().any(|episode| lost.is_told_by(episode)) {
                conclusion.episodes.push(lost.episode(verdict, apart));
            }
        }
        company::compare(&mut conclusion.episodes, positions);
        conclusion.episodes.sort_by_key(|episode| (episode.time_ns, episode.line));
        conclusion
    }
}
