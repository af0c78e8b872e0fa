//! Whether the rows keep to the number of positions that is given, and to what a word can hold.

use std::ops::Range;

use encoring_texts::Said;
use encoring_words::word::DATA_MAX;

use crate::axis::Axis;
use crate::curve::Point;
use crate::round::WORD;
use crate::row::Row;
use crate::statements;

/// The number of positions that is given, or that a word can hold, and what was seen outside them.
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
        let shown = 0..self.positions.unwrap_or(WORD);
        let line = |point: &Point| rows.get(point.row).map_or(0, |row| row.line);
        let is_given = |point: &Point| self.until.is_none_or(|until| line(point) < until);
        let here = points.iter().filter(|point| range.contains(&point.row) && is_given(point));
        for point in here.filter(|point| !shown.contains(&point.value)) {
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

    /// Whether all of these positions are among them.
    pub(crate) fn has(&self, positions: &Range<i64>) -> bool {
        let given = self.positions.filter(|_| self.until.is_none());
        positions.start >= 0 && positions.end <= given.unwrap_or(WORD)
    }

    /// Something was seen that no word can hold.
    pub(crate) const fn is_beyond_word(&self) -> bool {
        self.positions.is_none() && self.first.is_some()
    }

    /// What contradicts it; `None` if nothing does.
    pub(crate) fn contradiction(&self, position: u8) -> Option<Said> {
        let (first, line) = self.first?;
        Some(match self.positions {
            Some(positions) => {
                statements::beyond_given(position, positions, positions - 1, self.count, first, line)
            }
            None => statements::beyond_word(position, DATA_MAX, self.count, first, line),
        })
    }
}
