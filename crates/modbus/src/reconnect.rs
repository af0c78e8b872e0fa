//! When a connection is tried again: at once the first time, then after longer and longer pauses.

use encoring_words::{Duration, Instant};

/// The policy and where it stands. It is told the time and does nothing itself:
///
/// ```
/// use encoring_modbus::Reconnect;
/// use encoring_words::{Duration, Instant};
///
/// let mut reconnect = Reconnect::new(Duration::from_millis(100), 2, Duration::from_secs(5));
/// assert_eq!(reconnect.pause(Instant::ZERO), None);
/// assert_eq!(reconnect.failed(Instant::ZERO), Duration::from_millis(100));
/// assert_eq!(reconnect.failed(Instant::ZERO), Duration::from_millis(200));
/// assert_eq!(reconnect.pause(Instant::ZERO), Some(Duration::from_millis(200)));
/// reconnect.worked();
/// assert_eq!(reconnect.pause(Instant::ZERO), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reconnect {
    first: Duration,
    factor: u32,
    max: Duration,
    /// The pause after the last failure and when it ends; `None` after a success.
    waiting: Option<(Duration, Instant)>,
}

impl Reconnect {
    /// The first pause, what each is multiplied with to give the next, and the longest.
    #[must_use]
    pub const fn new(first: Duration, factor: u32, max: Duration) -> Self {
        Self { first, factor, max, waiting: None }
    }

    /// For a client whose calls end within `timeout`: a fifth of it, twice as long each time, up to all of it. Whoever
    /// waits at least three of them for something tries more than once.
    #[must_use]
    pub const fn within(timeout: Duration) -> Self {
        Self::new(Duration(timeout.as_nanos() / 5), 2, timeout)
    }

    /// How long there is still to wait; `None` if an attempt is due.
    #[must_use]
    pub fn pause(&self, now: Instant) -> Option<Duration> {
        let (_, until) = self.waiting?;
        Some(until.since(now)).filter(|rest| *rest > Duration::ZERO)
    }

    /// An attempt failed, or what it led to was of no use. Gives the pause until the next.
    pub fn failed(&mut self, now: Instant) -> Duration {
        let pause = match self.waiting {
            None => self.first,
            Some((last, _)) => Duration(last.as_nanos().saturating_mul(self.factor.into())),
        };
        let pause = pause.min(self.max);
        self.waiting = Some((pause, now + pause));
        pause
    }

    /// An answer came: when the connection is lost, the next attempt is due at once.
    pub fn worked(&mut self) {
        self.waiting = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    #[test]
    fn the_first_attempt_is_due_at_once() {
        assert_eq!(Reconnect::within(ms(500)).pause(Instant(7)), None);
    }

    #[test]
    fn pauses_grow_up_to_the_longest() {
        let mut reconnect = Reconnect::new(ms(100), 3, ms(1_000));
        let pauses: Vec<_> = (0..5).map(|_| reconnect.failed(Instant::ZERO)).collect();
        assert_eq!(pauses, [ms(100), ms(300), ms(900), ms(1_000), ms(1_000)]);
    }

    #[test]
    fn a_pause_ends_when_it_is_over() {
        let mut reconnect = Reconnect::new(ms(100), 2, ms(1_000));
        let now = Instant::ZERO + ms(50);
        reconnect.failed(now);
        assert_eq!(reconnect.pause(now), Some(ms(100)));
        assert_eq!(reconnect.pause(now + ms(99)), Some(ms(1)));
        assert_eq!(reconnect.pause(now + ms(100)), None);
        assert_eq!(reconnect.pause(now + ms(500)), None);
    }

    #[test]
    fn after_an_answer_it_begins_anew() {
        let mut reconnect = Reconnect::new(ms(100), 2, ms(1_000));
        reconnect.failed(Instant::ZERO);
        reconnect.failed(Instant::ZERO);
        reconnect.worked();
        assert_eq!(reconnect.pause(Instant::ZERO), None);
        assert_eq!(reconnect.failed(Instant::ZERO), ms(100));
    }

    #[test]
    fn far_pauses_saturate() {
        let mut reconnect = Reconnect::new(Duration(u64::MAX), u32::MAX, Duration(u64::MAX));
        reconnect.failed(Instant(1));
        assert_eq!(reconnect.failed(Instant(u64::MAX)), Duration(u64::MAX));
    }
}
