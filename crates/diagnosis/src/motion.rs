//! Ways and times, without overflow.

use encoring_host::validity::Circle;

/// No way and no position is counted beyond so many steps, so that sums of them never overflow.
pub(crate) const FARTHEST: i64 = 1 << 44;

/// The shorter way from one position to another. Beyond the positions of the circle none is known: there it is the difference.
pub(crate) fn way(circle: Circle, from: i64, to: i64) -> i64 {
    let positions = 0..circle.positions;
    if positions.contains(&from) && positions.contains(&to) {
        circle.way(from, to)
    } else {
        to.saturating_sub(from)
    }
}

/// A way made in `of` nanoseconds, at the same speed in `span`.
pub(crate) fn scaled(way: i64, span: i64, of: i64) -> i64 {
    if span == of || way == 0 {
        return way;
    }
    let of = of.max(1);
    let scaled = match way.checked_mul(span) {
        Some(product) => product / of,
        None => i64::try_from(i128::from(way) * i128::from(span) / i128::from(of)).unwrap_or(FARTHEST),
    };
    scaled.clamp(-FARTHEST, FARTHEST)
}

/// Steps of a speed in this time, rounded up.
pub(crate) fn per_second(steps: i64, span_ns: i64) -> i64 {
    let product = i128::from(steps) * i128::from(span_ns);
    i64::try_from(product / 1_000_000_000 + 1).unwrap_or(FARTHEST).min(FARTHEST)
}
