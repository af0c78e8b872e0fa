//! How far cycles are apart, and when some are missing.

use super::{Duration, Instant};

/// Pauses that must have been seen before one of them can be too long.
const LEARNT: u32 = 8;
/// A pause is a gap if it is so many times the usual one.
const TIMES: u64 = 8;
/// Shorter pauses are none.
const SHORT: Duration = Duration::from_millis(50);

#[derive(Clone, Copy, Debug)]
pub(super) struct Cadence {
    last: Option<Instant>,
    /// The usual pause: each new one counts an eighth.
    usual: u64,
    pauses: u32,
}

impl Cadence {
    pub(super) const NEW: Self = Self { last: None, usual: 0, pauses: 0 };

    /// Takes the time of a cycle; `true` if some before it are missing.
    pub(super) fn is_gap(&mut self, at: Instant) -> bool {
        let Some(last) = self.last.replace(at) else { return false };
        let pause = at.since(last).as_nanos();
        if self.pauses >= LEARNT && pause > SHORT.as_nanos() && pause / TIMES > self.usual {
            // If it goes on like this, this is usual from now on.
            self.pauses = 0;
            return true;
        }
        self.usual = if self.pauses == 0 { pause } else { self.usual / 8 * 7 + pause / 8 };
        self.pauses = self.pauses.saturating_add(1);
        false
    }
}
