//! How often the encoder takes a new sample, from rows that come faster: how long each value stands while the axis moves.

use std::ops::Range;

use encoring_host::validity::Circle;
use encoring_words::Duration;

use crate::curve::Point;
use crate::motion::way;

/// Rows that are further apart show no refresh: every encoder takes a sample each millisecond or faster.
const SLOWEST_ROWS_NS: i64 = 1_000_000;
/// Fewer steps from one value to the next may be slow motion between two samples.
const MOVED: i64 = 3;
/// Rows for which a value stands at most.
const ROWS_MAX: usize = 64;
/// Values that must have been seen.
const VALUES_LEAST: u64 = 32;
/// Of so many values one may stand for another number of rows: rows get lost and times scatter.
const ONE_OF: u64 = 10;
/// What a measurement is rounded to.
const ROUNDED_NS: u64 = 10_000;

/// How long values stood.
#[derive(Clone, Debug)]
pub(crate) struct Refresh {
    /// By the number of rows, less one: how many values, and for how long together.
    stood: [(u64, u64); ROWS_MAX],
}

impl Default for Refresh {
    fn default() -> Self {
        Self { stood: [(0, 0); ROWS_MAX] }
    }
}

impl Refresh {
    /// Looks at the points in a range of rows.
    pub(crate) fn look(&mut self, points: &[Point], range: &Range<usize>, circle: Circle, period_ns: i64) {
        let from = points.partition_point(|point| point.row < range.start);
        let to = points.partition_point(|point| point.row < range.end);
        let points = points.get(from..to).unwrap_or_default();
        if period_ns >= SLOWEST_ROWS_NS {
            return;
        }
        // Where the value that stands now came, if it came by motion.
        let mut came: Option<i64> = None;
        for two in points.windows(2) {
            let [before, now] = two else { continue };
            let step = way(circle, before.value, now.value).saturating_abs();
            if (now.time_ns - before.time_ns) * 4 > period_ns * 7 || (1..MOVED).contains(&step) {
                came = None;
            } else if step != 0
                && let Some(time_ns) = came.replace(now.time_ns)
            {
                self.count(now.time_ns - time_ns, period_ns);
            }
        }
    }

    /// Counts a value that stood for so long.
    fn count(&mut self, stood_ns: i64, period_ns: i64) {
        let rows = usize::try_from((stood_ns + period_ns / 2) / period_ns.max(1)).unwrap_or_default();
        if let Some((values, took)) = rows.checked_sub(1).and_then(|place| self.stood.get_mut(place)) {
            *values += 1;
            *took += stood_ns.unsigned_abs();
        }
    }

    /// How often the value is a new one; `None` if that does not show.
    pub(crate) fn measured(&self) -> Option<Duration> {
        let all: u64 = self.stood.iter().map(|(values, _)| values).sum();
        let sum = |two: &[(u64, u64)]| two.iter().fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        let (first, (values, took)) =
            self.stood.windows(2).map(sum).enumerate().max_by_key(|(_, (values, _))| *values)?;
        // Where rows come hardly faster than samples, a value that stands twice may be one row that was logged twice.
        let twice = self.stood.get(first + 1).map_or(0, |(values, _)| *values);
        let is_repeated = first > 0 || twice * 5 >= values * 2;
        let is_even = (all - values) * ONE_OF <= all && values >= VALUES_LEAST;
        (is_even && is_repeated).then(|| Duration((took / values + ROUNDED_NS / 2) / ROUNDED_NS * ROUNDED_NS))
    }
}

#[cfg(test)]
mod tests {
    use crate::{Detector, Options, Sample, Sighting};

    /// What is said of the refresh of rows a period apart that have the position of the last sample, at so many steps a second.
    fn said(rows_ns: u64, refresh_ns: u64, speed: u64, is_lost: impl Fn(u64) -> bool) -> String {
        let mut detector = Detector::new(Options::default());
        for k in (0..20_000).filter(|k| !is_lost(*k)) {
            let time_ns = k * rows_ns;
            let steps = time_ns / refresh_ns * refresh_ns * speed / 1_000_000_000;
            let reading = Sighting::Word(steps as u32 & 0x00FF_FFFF);
            detector.sample(Sample { line: k + 2, time_ns, position: 0, out: None, reading });
        }
        let conclusion = detector.finish();
        let sentences = conclusion.judged.iter().chain(&conclusion.limits).map(ToString::to_string);
        sentences.filter(|sentence| sentence.contains("refresh")).collect()
    }

    #[test]
    fn rows_that_come_faster_than_samples_show_how_often_these_come() {
        for (rows_us, refresh_us, told) in [
            (500, 1_200, "1.2 ms"),
            (100, 1_000, "1 ms"),
            (250, 500, "500 us"),
            (300, 500, "500 us"),
            (500, 750, "750 us"),
            (500, 10_000, "10 ms"),
        ] {
            for lost in [0, 1] {
                // Without the beat that a whole number would have with the samples.
                let is_lost = |k: u64| (k.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) % 50 < lost;
                let said = said(rows_us * 1_000, refresh_us * 1_000, 120_000, is_lost);
                let told = format!("position 0: refreshed every {told}, measured");
                assert!(said.starts_with(&told), "{rows_us} {refresh_us} {lost}: {said}");
            }
        }
    }

    #[test]
    fn slower_rows_a_slow_axis_and_one_that_stands_do_not_show_the_refresh() {
        let not_visible = "position 0: the refresh time is not visible at this period or speed";
        for (rows_us, refresh_us, speed) in [
            (500, 500, 120_000),
            (400, 500, 120_000),
            (1_000, 2_000, 120_000),
            (250, 500, 1_000),
            (250, 500, 0),
        ] {
            let said = said(rows_us * 1_000, refresh_us * 1_000, speed, |_| false);
            assert_eq!(said, not_visible, "{rows_us} {refresh_us} {speed}");
        }
    }
}
