//! Whether the number of positions that is given is one that the rows keep to.

use std::ops::Range;

use encoring_texts::Said;

use crate::axis::Axis;
use crate::curve::Point;
use crate::row::Row;
use crate::statements;

/// The number of positions that is given, and what was seen beyond it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    positions: Option<i64>,
    /// The line up to which it is.
    until: Option<u64>,
    count: u64,
    /// The first one and its line.
    first: Option<(i64, u64)>,
}

impl Given {
    pub(crate) fn new(axis: &Axis) -> Self {
        let positions = axis.is_circle_known.then_some(axis.circle.positions);
        Self { positions, until: None, count: 0, first: None }
    }

    /// Counts those of a range of rows.
    pub(crate) fn look(&mut self, points: &[Point], rows: &[Row], range: &Range<usize>) {
        let Some(positions) = self.positions else { return };
        let line = |point: &Point| rows.get(point.row).map_or(0, |row| row.line);
        let is_given = |point: &Point| self.until.is_none_or(|until| line(point) < until);
        let here = points.iter().filter(|point| range.contains(&point.row) && is_given(point));
        for point in here.filter(|point| point.value >= positions) {
            self.count += 1;
            let line = line(point);
            self.first.get_or_insert((point.value, line));
        }
    }

    /// It is given up to this line only.
    pub(crate) const fn end(&mut self, line: u64) {
        self.until = Some(line);
    }

    /// The number of positions, and the line up to which it is, if it is not to the end.
    pub(crate) fn ended(&self) -> Option<(i64, u64)> {
        self.positions.zip(self.until)
    }

    /// What contradicts what is given; `None` if nothing does.
    pub(crate) fn contradiction(&self, position: u8) -> Option<Said> {
        let (positions, (first, line)) = (self.positions?, self.first?);
        Some(statements::beyond_given(position, positions, positions - 1, self.count, first, line))
    }
}
