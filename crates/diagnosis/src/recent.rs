//! The latest rows of encoders, for whoever looks on as it happens.

use std::collections::{BTreeMap, VecDeque};

use crate::apart;
use crate::cause::{JumpCause, Likelihood};
use crate::detector::Detector;
use crate::episode::Episode;
use crate::evidence;
use crate::options::Options;
use crate::sample::Sample;

/// Rows that are kept of an encoder.
const ROWS: usize = 512;
/// Rows behind a jump that are waited for, so that it is known how it goes on.
const BEHIND: u32 = 16;
/// Rows by which a finding may lie beside the jump.
const BESIDE: usize = 3;

/// Keeps the latest rows of each encoder, and tells the cause of a jump a few rows behind it.
#[derive(Clone, Debug, Default)]
pub struct Recent {
    encoders: BTreeMap<u8, Latest>,
}

#[derive(Clone, Debug, Default)]
struct Latest {
    rows: VecDeque<Sample>,
    jump: Option<Jump>,
}

/// A jump whose cause is wanted.
#[derive(Clone, Copy, Debug)]
struct Jump {
    line: u64,
    /// Rows that came since.
    behind: u32,
}

impl Recent {
    /// Takes the next row.
    pub fn sample(&mut self, sample: Sample) {
        let latest = self.encoders.entry(sample.position).or_default();
        if latest.rows.len() == ROWS {
            latest.rows.pop_front();
        }
        latest.rows.push_back(sample);
        if let Some(jump) = &mut latest.jump {
            jump.behind += 1;
        }
    }

    /// The latest row of an encoder is a jump whose cause is wanted; while one is waited for, another is not.
    pub fn jumped(&mut self, position: u8) {
        let Some(latest) = self.encoders.get_mut(&position) else { return };
        let Some(line) = latest.rows.back().map(|row| row.line) else { return };
        latest.jump.get_or_insert(Jump { line, behind: 0 });
    }

    /// The cause of a jump, as soon as enough rows came behind it; once.
    pub fn cause(&mut self, position: u8, options: &Options) -> Option<Episode> {
        let behind = self.encoders.get(&position)?.jump?.behind;
        if behind < BEHIND { None } else { self.cause_so_far(position, options) }
    }

    /// The same with the rows that there are: no more come.
    pub fn cause_so_far(&mut self, position: u8, options: &Options) -> Option<Episode> {
        let latest = self.encoders.get_mut(&position)?;
        let jump = latest.jump.take()?;
        let at = latest.rows.iter().position(|row| row.line == jump.line)?;
        let mut detector = Detector::new(options.clone());
        latest.rows.iter().for_each(|row| detector.sample(*row));
        let line = |at: usize| latest.rows.get(at.min(latest.rows.len() - 1)).map_or(0, |row| row.line);
        let near = line(at.saturating_sub(BESIDE))..=line(at + BESIDE);
        let meets = |episode: &Episode| episode.line <= *near.end() && episode.to_line >= *near.start();
        // What is wrong comes before what happens to sound encoders.
        let weight = |episode: &Episode| (episode.cause.is_fault(), episode.certainty);
        let found = detector.finish().episodes.into_iter().filter(meets).max_by_key(weight);
        Some(found.unwrap_or_else(|| untold(latest, at)))
    }
}

/// A jump that the rows around it say nothing of.
fn untold(latest: &Latest, at: usize) -> Episode {
    let row = latest.rows.get(at);
    let rows = latest.rows.len();
    Episode {
        line: row.map_or(0, |row| row.line),
        to_line: row.map_or(0, |row| row.line),
        count: 1,
        time_ns: row.map_or(0, |row| row.time_ns),
        position: row.map_or(0, |row| row.position),
        cause: JumpCause::Unclear,
        certainty: Likelihood::Possible,
        alternatives: Vec::new(),
        apart: vec![apart::poll_faster()],
        evidence: vec![evidence::like_motion(rows)],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::sample::Sighting;

    fn row(line: u32, word: u32) -> Sample {
        let time_ns = u64::from(line) * 10_000_000;
        Sample { line: line.into(), time_ns, position: 3, out: Some(0), reading: Sighting::Word(word) }
    }

    #[test]
    fn the_cause_of_a_jump_is_told_once_when_enough_rows_came_behind_it() {
        let mut recent = Recent::default();
        let mut told = Vec::new();
        for line in 1..1_000 {
            let word = 1_000 + 10 * line;
            recent.sample(row(line, if line == 700 { word ^ 1 << 20 } else { word }));
            if line == 700 {
                recent.jumped(3);
            }
            told.extend(recent.cause(3, &Options::default()).map(|episode| (line, episode)));
        }
        let [(when, episode)] = told.as_slice() else { unreachable!("{told:?}") };
        assert_eq!((*when, episode.line, episode.cause), (700 + BEHIND, 700, JumpCause::SingleBit));
        assert_eq!(recent.cause_so_far(3, &Options::default()), None);
    }

    #[test]
    fn a_jump_at_the_end_is_told_with_the_rows_that_there_are_and_of_no_jump_nothing_is() {
        let mut recent = Recent::default();
        recent.jumped(3);
        assert_eq!(recent.cause_so_far(3, &Options::default()), None);
        (1..50).for_each(|line| recent.sample(row(line, 1_000)));
        assert_eq!(recent.cause_so_far(3, &Options::default()), None);
        recent.sample(row(50, 900_000));
        recent.jumped(3);
        let episode = recent.cause_so_far(3, &Options::default()).unwrap();
        assert_eq!((episode.cause, episode.line), (JumpCause::Unclear, 50));
    }
}
