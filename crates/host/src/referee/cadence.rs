//! How far cycles are apart, and when some are missing.

use super::{Duration, Instant};

/// Pauses that must have been seen before one of them can be too long.
const LEARNT: u32 = 8;
/// What is usual is learnt anew from so many.
const ROUND: u32 = 16;
/// A pause is a gap if it is so many times the usual one.
const TIMES: u64 = 8;
/// Shorter pauses are none.
const SHORT: Duration = Duration::from_millis(50);
/// Before enough is learnt, a gap is longer than this, and so many times as long as all pauses together.
const UNSURE: Duration = Duration::from_millis(100);
const TIMES_UNSURE: u64 = 16;

#[derive(Clone, Copy, Debug)]
pub(super) struct Cadence {
    /// Where the round began.
    first: Instant,
    last: Instant,
    /// Pauses of this round; [`NO_ROUND`] before the first cycle.
    pauses: u32,
    /// The mean pause of the round before.
    usual: Option<u64>,
}

const NO_ROUND: u32 = u32::MAX;

impl Cadence {
    pub(super) const NEW: Self =
        Self { first: Instant::ZERO, last: Instant::ZERO, pauses: NO_ROUND, usual: None };

    /// Takes the time of a cycle; `true` if some before it are missing.
    pub(super) fn is_gap(&mut self, at: Instant) -> bool {
        let last = core::mem::replace(&mut self.last, at);
        let pause = at.since(last);
        if pause <= SHORT && self.pauses < ROUND {
            self.pauses += 1;
            return false;
        }
        self.is_long(pause, last, at)
    }

    /// The same of a long pause, or at the end of a round.
    #[cold]
    fn is_long(&mut self, pause: Duration, last: Instant, at: Instant) -> bool {
        let Self { first, pauses, usual, .. } = *self;
        let mean = (pauses >= LEARNT).then(|| last.since(first).as_nanos() / u64::from(pauses));
        let usual = if pauses == ROUND { mean } else { usual.or(mean) };
        let is_gap = pauses != NO_ROUND
            && match usual {
                Some(usual) => pause > SHORT && pause.as_nanos() / TIMES > usual,
                None => {
                    let all = last.since(first).as_nanos();
                    all > 0 && pause > UNSURE && pause.as_nanos() / TIMES_UNSURE > all
                }
            };
        *self = if is_gap || pauses == NO_ROUND {
            // If it goes on like this, this is usual from now on.
            Self { first: at, last: at, pauses: 0, usual: None }
        } else if pauses == ROUND {
            Self { first: last, last: at, pauses: 1, usual }
        } else {
            Self { pauses: pauses + 1, ..*self }
        };
        is_gap
    }
}
