//! What has been told of an encoder: stretches grow, and what happens all the time is counted.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::cause::JumpCause;
use crate::episode::Episode;
use crate::evidence;
use crate::row::Row;
use crate::services::Services;
use crate::verdict::Judged;

/// Episodes of one cause that stand by themselves; further ones are counted in the last.
const APART: usize = 1_000;
/// The latest episodes, among which one is looked for.
const LATEST: usize = 64;

/// The episodes of one encoder.
#[derive(Clone, Debug)]
pub(crate) struct Ledger {
    position: u8,
    episodes: Vec<Episode>,
    /// How many episodes of each cause there are, and the place of the last.
    counts: BTreeMap<JumpCause, (usize, usize)>,
}

impl Ledger {
    pub(crate) const fn new(position: u8) -> Self {
        Self { position, episodes: Vec::new(), counts: BTreeMap::new() }
    }

    pub(crate) fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    pub(crate) fn into_episodes(self) -> Vec<Episode> {
        self.episodes
    }

    /// Whether one of the latest is of this cause, and ends at this line or behind it.
    pub(crate) fn has_told(&self, cause: JumpCause, line: u64) -> bool {
        self.episodes.iter().rev().take(LATEST).any(|known| known.cause == cause && known.to_line >= line)
    }

    /// Tells of these rows.
    pub(crate) fn tell(&mut self, all: &[Row], services: &Services, rows: Range<usize>, judged: Judged) {
        let (Some(first), Some(last)) = (all.get(rows.start), all.get(rows.end - 1)) else {
            return;
        };
        let before = rows.start.checked_sub(1).and_then(|at| all.get(at)).map_or(0, |row| row.line);
        let (line, to_line, count) = (first.line, last.line, rows.len() as u64);
        let (same, last) = self.counts.get(&judged.cause).copied().unwrap_or((0, usize::MAX));
        if let Some(known) = self.episodes.get_mut(last)
            && (same >= APART || judged.cause.lasts() && (known.to_line == before || known.to_line >= line))
        {
            known.count += count;
            known.to_line = known.to_line.max(to_line);
            return;
        }
        let apart = judged.apart(services);
        let Judged { cause, certainty, alternatives, evidence: mut told } = judged;
        if rows.len() < 4
            && let Some(before) = rows.start.checked_sub(1).and_then(|at| all.get(at))
        {
            told.insert(0, evidence::behind(first.shown(), before.shown()));
        }
        self.counts.insert(cause, (same + 1, self.episodes.len()));
        self.episodes.push(Episode {
            line,
            to_line,
            count,
            time_ns: first.time_ns.unsigned_abs(),
            position: self.position,
            cause,
            certainty,
            alternatives,
            apart,
            evidence: told,
        });
    }
}
