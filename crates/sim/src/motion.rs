//! How a shaft turns or a magnet moves: a place for every moment, the same on every machine.
//!
//! Places are whole sensor steps (rotary) or micrometres (linear) and are computed in whole numbers; only the sine
//! goes through floating point, with a software sine that gives the same bits everywhere.

use std::sync::Arc;

use encoring_words::{Duration, Instant};

/// The farthest place, both ways.
pub const RAW_MAX: i64 = 1 << 62;

/// A motion, told in time since it began.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// It stands.
    Hold {
        /// Where.
        raw: i64,
    },
    /// It moves evenly.
    Speed {
        /// Where it begins.
        start: i64,
        /// Millionths of a step (or micrometre) a second.
        micro_per_s: i64,
    },
    /// It swings.
    Sine {
        /// Middle.
        center: i64,
        /// Farthest distance from the middle.
        amplitude: i64,
        /// Time of one swing; not zero.
        period: Duration,
    },
    /// It goes from place to place, evenly from each to the next, and stays at the last.
    Path {
        /// Places with their times, in rising order; before the first it is there already.
        points: Vec<(Instant, i64)>,
        /// After the last place it begins again.
        repeat: bool,
    },
    /// It jumps from one recorded place to the next.
    Recorded {
        /// Places with their times, in rising order; before the first it is there already.
        points: Arc<[(Instant, i64)]>,
    },
}

impl Motion {
    /// Where it is after `elapsed`.
    #[must_use]
    pub fn at(&self, elapsed: Duration) -> i64 {
        let t = elapsed.as_nanos();
        match self {
            Self::Hold { raw } => *raw,
            Self::Speed { start, micro_per_s } => {
                let travel = (i128::from(*micro_per_s) * i128::from(t)).div_euclid(1_000_000_000_000_000);
                clamp(i128::from(*start) + travel)
            }
            Self::Sine { center, amplitude, period } => {
                let period = period.as_nanos().max(1);
                let turn = (t % period) as f64 / period as f64;
                let swing = libm::round(*amplitude as f64 * libm::sin(turn * std::f64::consts::TAU));
                clamp(i128::from(*center) + swing as i128)
            }
            Self::Path { points, repeat } => {
                let last = points.last().map_or(0, |(at, _)| at.as_nanos());
                let t = if *repeat && last > 0 { t % last } else { t };
                match around(points, Instant(t)) {
                    (None, None) => 0,
                    (Some((_, raw)), None) | (None, Some((_, raw))) => raw,
                    (Some((from, a)), Some((to, b))) => {
                        let whole = i128::from(to.since(from).as_nanos().max(1));
                        let part = i128::from(Instant(t).since(from).as_nanos());
                        clamp(i128::from(a) + ((i128::from(b) - i128::from(a)) * part).div_euclid(whole))
                    }
                }
            }
            Self::Recorded { points } => match around(points, Instant(t)) {
                (Some((_, raw)), _) | (None, Some((_, raw))) => raw,
                (None, None) => 0,
            },
        }
    }
}

fn clamp(raw: i128) -> i64 {
    raw.clamp(i128::from(-RAW_MAX), i128::from(RAW_MAX)) as i64
}

type Point = (Instant, i64);

/// The last point not after `t` and the first after it.
fn around(points: &[Point], t: Instant) -> (Option<Point>, Option<Point>) {
    let after = points.partition_point(|(at, _)| *at <= t);
    (after.checked_sub(1).and_then(|before| points.get(before)).copied(), points.get(after).copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn even_speed_is_exact_over_years() {
        // 6000 rpm at 4096 steps.
        let motion = Motion::Speed { start: 5, micro_per_s: 409_600_000_000 };
        assert_eq!(motion.at(Duration(0)), 5);
        assert_eq!(motion.at(Duration::from_micros(500)), 5 + 204);
        assert_eq!(motion.at(Duration::from_millis(5)), 5 + 2048);
        assert_eq!(motion.at(Duration(1_000_000_000 * S)), 5 + 409_600 * 1_000_000_000);
        assert_eq!(Motion::Speed { start: 0, micro_per_s: -1 }.at(Duration(1)), -1);
        assert_eq!(Motion::Speed { start: 0, micro_per_s: i64::MIN }.at(Duration(u64::MAX)), -RAW_MAX);
    }

    #[test]
    fn a_sine_meets_its_turning_points() {
        let motion = Motion::Sine { center: 250_000, amplitude: 200_000, period: Duration(4 * S) };
        let seen: Vec<i64> = (0..=4).map(|s| motion.at(Duration(s * S))).collect();
        assert_eq!(seen, [250_000, 450_000, 250_000, 50_000, 250_000]);
    }

    #[test]
    fn a_path_goes_evenly_and_repeats_if_told() {
        let points = vec![(Instant(S), 0), (Instant(3 * S), 1000), (Instant(4 * S), -1000)];
        let once = Motion::Path { points: points.clone(), repeat: false };
        let at = |motion: &Motion, ms: u64| motion.at(Duration::from_millis(ms));
        assert_eq!([0, 1000, 2000, 3000, 3500, 9000].map(|ms| at(&once, ms)), [0, 0, 500, 1000, 0, -1000]);
        let again = Motion::Path { points, repeat: true };
        assert_eq!(at(&again, 6000), 500);
    }

    #[test]
    fn a_recording_holds_each_place() {
        let motion = Motion::Recorded { points: [(Instant(10), 1), (Instant(20), 2)].into() };
        assert_eq!([0, 10, 19, 20, 99].map(|t| motion.at(Duration(t))), [1, 1, 1, 2, 2]);
    }
}
