//! When the next cycle is due: real time turned into cycles, without drift.
//!
//! Due cycles are counted from the start, not from the last wake-up, so late sleeps do not add up. What was missed
//! for longer than [`CATCH_UP`] is dropped and counted.

use std::time::Duration as Real;

use encoring_words::Duration;

/// How far the ring may run behind real time before cycles are dropped.
pub const CATCH_UP: Real = Real::from_millis(100);

/// The most cycles run in one go, so that others get at the image.
pub const BATCH_MAX: u64 = 64;

/// How fast time passes on the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// Millionths of real time: 1 000 000 is real time.
    Millionths(u64),
    /// As fast as the machine can.
    Max,
}

impl Speed {
    /// As fast as on a real ring.
    pub const REAL: Self = Self::Millionths(1_000_000);
}

/// A text that is no speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a speed is \"max\" or a factor from 0.001 to 1000")]
pub struct NotASpeed;

impl std::str::FromStr for Speed {
    type Err = NotASpeed;

    fn from_str(text: &str) -> Result<Self, NotASpeed> {
        if text == "max" {
            return Ok(Self::Max);
        }
        let factor: f64 = text.parse().map_err(|_| NotASpeed)?;
        if (0.001..=1_000.0).contains(&factor) {
            Ok(Self::Millionths((factor * 1e6).round() as u64))
        } else {
            Err(NotASpeed)
        }
    }
}

/// Counts the cycles of a ring against real time.
#[derive(Clone, Debug)]
pub struct Pace {
    cycle_ns: u128,
    speed: Speed,
    /// Cycles run or dropped.
    accounted: u64,
    dropped: u64,
}

impl Pace {
    /// The pace of a ring with this cycle time.
    #[must_use]
    pub fn new(cycle_time: Duration, speed: Speed) -> Self {
        Self { cycle_ns: u128::from(cycle_time.as_nanos().max(1)), speed, accounted: 0, dropped: 0 }
    }

    /// How many cycles to run now, `elapsed` after the start; 0 if the next is not yet due.
    pub fn due(&mut self, elapsed: Real) -> u64 {
        let Speed::Millionths(millionths) = self.speed else { return BATCH_MAX };
        let cycles = |real: Real| {
            u64::try_from(real.as_nanos() * u128::from(millionths) / (self.cycle_ns * 1_000_000))
                .unwrap_or(u64::MAX)
        };
        let behind = cycles(elapsed).saturating_sub(self.accounted);
        let kept = cycles(CATCH_UP).max(1);
        let dropped = behind.saturating_sub(kept);
        self.dropped += dropped;
        let run = (behind - dropped).min(BATCH_MAX);
        self.accounted += dropped + run;
        run
    }

    /// How long until the next cycle is due, `elapsed` after the start.
    #[must_use]
    pub fn wait(&self, elapsed: Real) -> Real {
        let Speed::Millionths(millionths) = self.speed else { return Real::ZERO };
        let due = (u128::from(self.accounted) + 1) * self.cycle_ns * 1_000_000;
        let due =
            Real::from_nanos(u64::try_from(due.div_ceil(u128::from(millionths.max(1)))).unwrap_or(u64::MAX));
        due.saturating_sub(elapsed)
    }

    /// Cycles that were never run because the machine was too slow.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Duration = Duration::from_micros(677);

    #[test]
    fn late_wake_ups_do_not_add_up() {
        let mut pace = Pace::new(CYCLE, Speed::REAL);
        let mut run = 0;
        let mut elapsed = Real::ZERO;
        // Every sleep is late by 0.1 to 1.4 ms.
        for k in 0..100_000_u64 {
            elapsed += pace.wait(elapsed) + Real::from_micros(100 + k * 7919 % 1300);
            run += pace.due(elapsed);
        }
        assert_eq!(u128::from(run), elapsed.as_nanos() / 677_000);
        assert_eq!(pace.dropped(), 0);
    }

    #[test]
    fn a_long_sleep_is_caught_up_for_100_ms_and_the_rest_dropped() {
        let mut pace = Pace::new(Duration::from_millis(1), Speed::REAL);
        let batches: Vec<u64> = (0..4).map(|_| pace.due(Real::from_secs(5))).collect();
        assert_eq!(batches, [64, 36, 0, 0]);
        assert_eq!(pace.dropped(), 4_900);
        assert_eq!(pace.wait(Real::from_secs(5)), Real::from_millis(1));
    }

    #[test]
    fn a_factor_stretches_time() {
        let mut pace = Pace::new(Duration::from_millis(1), "0.5".parse().unwrap());
        assert_eq!(pace.wait(Real::ZERO), Real::from_millis(2));
        assert_eq!(pace.due(Real::from_millis(20)), 10);
        let mut fast = Pace::new(Duration::from_millis(1), "10".parse().unwrap());
        assert_eq!(fast.due(Real::from_millis(2)), 20);
        assert_eq!(Pace::new(CYCLE, Speed::Max).due(Real::ZERO), BATCH_MAX);
    }

    #[test]
    fn a_speed_is_a_positive_factor_or_max() {
        assert_eq!("1".parse(), Ok(Speed::REAL));
        assert_eq!("max".parse(), Ok(Speed::Max));
        for wrong in ["0", "-1", "1001", "nan", "inf", "1,5", ""] {
            assert_eq!(wrong.parse::<Speed>(), Err(NotASpeed), "{wrong}");
        }
    }
}
