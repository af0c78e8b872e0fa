//! Positions in a circle, and what motion alone can do.

/// A circle of positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Circle {
    /// How many positions there are until they begin again.
    pub(crate) positions: i64,
}

impl Circle {
    /// The shorter way from one position to another, in steps; upwards counts positive.
    pub(crate) const fn way(self, from: i64, to: i64) -> i64 {
        let up = (to - from).rem_euclid(self.positions);
        if up > self.positions / 2 { up - self.positions } else { up }
    }

    /// A position moved on.
    pub(crate) const fn moved(self, from: i64, steps: i64) -> i64 {
        (from + steps).rem_euclid(self.positions)
    }
}

/// A way made in `of` nanoseconds, at the same speed in `span`.
pub(crate) fn scaled(way: i64, span: i64, of: i64) -> i64 {
    if span == of || way == 0 {
        return way;
    }
    let scaled = i128::from(way) * i128::from(span) / i128::from(of.max(1));
    i64::try_from(scaled).unwrap_or(i64::MAX / 4)
}
