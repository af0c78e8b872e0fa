//! Rows in which nothing can have happened: a cheap look before all others.
//!
//! No jump of fewer steps than [`crate::curve::LEAST`] is looked at, no scatter and no other way to read the rows shows
//! below that, and an end of the range is a jump in the rows as they are. So rows whose second differences are smaller, as
//! they are and without their times, need not be looked at.

use crate::row::{ReadAs, Row};

/// The largest second difference of quiet rows; and where rows may come faster than the encoder's samples, whose beat shows from
/// three steps on.
const QUIET: i64 = 3;
const QUIET_OF_FAST: i64 = 2;

/// What quiet rows are like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quiet {
    /// From row to row.
    pub(crate) period_ns: i64,
    /// The smallest position, and the largest.
    pub(crate) least: i64,
    pub(crate) most: i64,
    pub(crate) has_moved: bool,
}

/// How fast rows are, against the encoder's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pace {
    /// Below this period rows may come faster than samples.
    pub(crate) fast_ns: i64,
    /// Steps a second from which a shaft may be too fast, if that is known.
    pub(crate) steps_per_s: Option<i64>,
}

/// What the rows are like, if all are positions without OUT's service bit, without a gap, and quiet.
pub(crate) fn of(rows: &[Row], pace: Pace) -> Option<Quiet> {
    let [first, second, ..] = rows else { return None };
    let last = rows.last()?;
    let spans = i64::try_from(rows.len() - 1).ok()?;
    let period_ns = (last.time_ns - first.time_ns) / spans;
    let most_bend = if period_ns < pace.fast_ns { QUIET_OF_FAST } else { QUIET };
    let start = first.position(ReadAs::Plain)?;
    let (mut before, mut step) = (start, second.position(ReadAs::Plain)? - start);
    let (mut time, mut least, mut most, mut fastest) = (first.time_ns, start, start, 0);
    for row in rows.get(1..)? {
        let value = row.position(ReadAs::Plain)?;
        let (next, span) = (value - before, row.time_ns - time);
        let is_even = (next - step).abs() <= most_bend && span > 0 && span <= period_ns * 7 / 4;
        if !is_even || row.out.is_some_and(|out| out >> 31 == 1) {
            return None;
        }
        (before, step, time) = (value, next, row.time_ns);
        (least, most) = (least.min(value), most.max(value));
        fastest = fastest.max(next.abs());
    }
    let is_slow = pace
        .steps_per_s
        .is_none_or(|limit| fastest.saturating_mul(1_000_000_000) < limit.saturating_mul(period_ns) / 2);
    let has_moved = fastest > 0;
    is_slow.then_some(Quiet { period_ns, least, most, has_moved })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Sample, Sighting};

    const PACE: Pace = Pace { fast_ns: 3_500_000, steps_per_s: Some(409_600) };

    fn rows(word: impl Fn(u32) -> u32) -> Vec<Row> {
        let row = |k: u32| Sample {
            line: k.into(),
            time_ns: u64::from(k) * 10_000_000,
            position: 0,
            out: Some(0),
            reading: Sighting::Word(word(k)),
        };
        (0..100).map(|k| Row::new(&row(k))).collect()
    }

    #[test]
    fn even_rows_are_quiet_and_any_jump_service_or_gap_is_not() {
        let even = |k: u32| 1_000 + 7 * k;
        let quiet = Quiet { period_ns: 10_000_000, least: 1_000, most: 1_693, has_moved: true };
        assert_eq!(of(&rows(even), PACE), Some(quiet));
        assert_eq!(of(&rows(|_| 5), PACE), Some(Quiet { least: 5, most: 5, has_moved: false, ..quiet }));
        assert_eq!(of(&rows(|k| if k == 50 { even(k) + 4 } else { even(k) }), PACE), None);
        assert_eq!(of(&rows(|k| if k == 50 { 0x8200_0000 } else { even(k) }), PACE), None);
        let mut asked = rows(even);
        asked[50].out = Some(0x8200_0000);
        assert_eq!(of(&asked, PACE), None);
        let mut paused = rows(even);
        paused[50..].iter_mut().for_each(|row| row.time_ns += 1_000_000_000);
        assert_eq!(of(&paused, PACE), None);
        assert_eq!(of(&rows(|k| 10_000 * k), PACE), None);
    }
}
