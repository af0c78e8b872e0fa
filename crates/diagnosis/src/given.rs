//! Whether the number of positions that is given is one that the rows keep to.

use std::ops::Range;

use crate::axis::Axis;
use crate::curve::Point;
use crate::row::Row;

/// The number of positions that is given, and what was seen beyond it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    positions: Option<i64>,
    count: u64,
    /// The first one and its line.
    first: Option<(i64, u64)>,
}

impl Given {
    pub(crate) fn new(axis: &Axis) -> Self {
        let positions = axis.is_circle_known.then_some(axis.circle.positions);
        Self { positions, count: 0, first: None }
    }

    /// Counts those of a range of rows.
    pub(crate) fn look(&mut self, points: &[Point], rows: &[Row], range: &Range<usize>) {
        let Some(positions) = self.positions else { return };
        for point in points.iter().filter(|point| range.contains(&point.row) && point.value >= positions) {
            self.count += 1;
            let line = rows.get(point.row).map_or(0, |row| row.line);
            self.first.get_or_insert((point.value, line));
        }
    }

    /// What contradicts what is given; `None` if nothing does.
    pub(crate) fn contradiction(&self) -> Option<String> {
        let (positions, (first, line)) = (self.positions?, self.first?);
        let count = self.count;
        Some(format!(
            "{positions} positions are given, 0 to {}, and {count} rows have others, the first {first} at line {line}: these are \
             wrong, or another scaling was active",
            positions - 1
        ))
    }
}
