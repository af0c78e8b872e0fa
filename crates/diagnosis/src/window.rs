//! The rows of one encoder, as many as are looked at together.

use crate::cause::{JumpCause, Likelihood};
use crate::episode::{Conclusion, Episode};
use crate::jumps::{Jumps, Point};
use crate::options::Options;
use crate::row::{Row, Shown};
use crate::sample::Sample;

/// Rows that are judged together.
pub(crate) const ROWS: usize = 8_192;
/// Rows behind those that are judged now, so that it is known how it goes on.
const AHEAD: usize = 1_024;
/// Rows before them.
const BEHIND: usize = 512;
/// Episodes of one cause that stand by themselves; further ones are counted in the last.
const APART: usize = 1_000;

#[derive(Clone, Debug)]
pub(crate) struct Window {
    position: u8,
    rows: Vec<Row>,
    /// The rows before this one are judged.
    from: usize,
    count: u64,
    jumps: Jumps,
    episodes: Vec<Episode>,
}

impl Window {
    pub(crate) fn new(position: u8) -> Self {
        Self { position, rows: Vec::new(), from: 0, count: 0, jumps: Jumps::default(), episodes: Vec::new() }
    }

    pub(crate) fn push(&mut self, sample: &Sample, options: &Options) {
        self.count += 1;
        let time_ns = i64::try_from(sample.time_ns).unwrap_or(i64::MAX);
        self.rows.push(Row { line: sample.line, time_ns, shown: Shown::of(sample.reading) });
        if self.rows.len() >= ROWS {
            self.judge(self.rows.len() - AHEAD, options);
        }
    }

    /// What has been told so far.
    pub(crate) fn told(&self) -> &[Episode] {
        &self.episodes
    }

    pub(crate) fn finish(mut self, options: &Options, conclusion: &mut Conclusion) {
        self.judge(self.rows.len(), options);
        conclusion.judged.push(format!("position {}: {} rows", self.position, self.count));
        conclusion.episodes.append(&mut self.episodes);
    }

    /// Judges the rows up to `until`.
    fn judge(&mut self, until: usize, _options: &Options) {
        self.replies(until);
        let mut points = Vec::with_capacity(self.rows.len());
        for (index, row) in self.rows.iter().enumerate() {
            if let Shown::Position(value) = row.shown {
                points.push(Point { index, time_ns: row.time_ns, value });
            }
        }
        let mut found = Vec::new();
        let judged = self.jumps.judge(&points, self.from..until, &self.rows, self.position, &mut found);
        for episode in found {
            self.tell(episode);
        }
        let until = until.max(judged);
        let kept = until.saturating_sub(BEHIND);
        self.rows.drain(..kept.min(self.rows.len()));
        self.from = until - kept;
    }

    /// Replies stand out by bit 31: each run of them is an episode.
    fn replies(&mut self, until: usize) {
        let mut at = self.from;
        while at < until {
            let Some(Row { line, time_ns, shown: Shown::Reply(word) }) = self.rows.get(at).copied() else {
                at += 1;
                continue;
            };
            let run = self.rows.get(at..until).unwrap_or_default();
            let run: Vec<_> = run.iter().take_while(|row| matches!(row.shown, Shown::Reply(_))).collect();
            let to_line = run.last().map_or(line, |row| row.line);
            let (position, count) = (self.position, run.len() as u64);
            at += run.len();
            self.tell(Episode {
                line,
                to_line,
                count,
                time_ns: time_ns.unsigned_abs(),
                position,
                cause: JumpCause::ReplyAsPosition,
                certainty: Likelihood::Certain,
                alternatives: Vec::new(),
                apart: String::new(),
                evidence: vec![format!("IN {word} has bit 31, the service bit: it is a reply")],
            });
        }
    }

    fn tell(&mut self, episode: Episode) {
        let same = self.episodes.iter().filter(|known| known.cause == episode.cause).count();
        let last = self.episodes.iter_mut().rev().find(|known| known.cause == episode.cause);
        match last {
            Some(last) if same >= APART => {
                last.to_line = episode.to_line;
                last.count += episode.count;
            }
            _ => self.episodes.push(episode),
        }
    }
}
