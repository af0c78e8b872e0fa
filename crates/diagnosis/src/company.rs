//! What the other encoders of the same recording did when one of them jumped.

use crate::episode::Episode;
use crate::evidence;

/// Jumps no further apart than this are at the same time: two rows of a slow log.
const TOGETHER_NS: u64 = 20_000_000;

/// Says of each jump whether others jumped with it: what one encoder or its axis did shows in one, what the bus or the log did
/// shows in several.
pub(crate) fn compare(episodes: &mut [Episode], positions: usize) {
    if positions < 2 {
        return;
    }
    let mut times: Vec<(u64, u8)> = episodes.iter().map(|one| (one.time_ns, one.position)).collect();
    times.sort_unstable();
    for episode in episodes.iter_mut().filter(|episode| episode.cause.is_jump()) {
        let from = times.partition_point(|(time, _)| time.saturating_add(TOGETHER_NS) < episode.time_ns);
        let near = times.iter().skip(from).take_while(|(time, _)| *time <= episode.time_ns + TOGETHER_NS);
        let other = near.map(|(_, position)| *position).find(|position| *position != episode.position);
        episode.evidence.push(match other {
            Some(other) => evidence::with_another(other),
            None => evidence::alone(),
        });
    }
}
