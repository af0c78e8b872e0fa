//! A chart drawn with characters.

use std::fmt::Write;

use super::{Chart, Curve};
use crate::axis::Axis;

/// Characters of a curve.
const COLUMNS: i64 = 64;
const LINES: i64 = 9;
/// Characters for the values at its left.
const VALUES: usize = 12;

impl Chart {
    /// The first curve as characters, some ten lines of 80 columns, with the numbers of the marks above it; from 10 on
    /// they are `+`.
    #[must_use]
    pub fn text(&self) -> String {
        let Some(curve) = self.curves.first() else { return String::new() };
        let (from, to) = self.ends();
        let axis = Axis { from, to, left: 0, width: COLUMNS - 1 };
        let mut numbers = vec![' '; COLUMNS as usize];
        for mark in &self.marks {
            let column = (axis.x(mark.from).0 / 10).unsigned_abs() as usize;
            if let Some(cell) = numbers.get_mut(column).filter(|cell| **cell == ' ') {
                *cell = u32::try_from(mark.number)
                    .ok()
                    .and_then(|number| char::from_digit(number, 10))
                    .unwrap_or('+');
            }
        }
        let numbers: String = numbers.into_iter().collect();
        let mut text = format!("{:VALUES$} {}\n", "", numbers.trim_end()).replace(" \n", "\n");
        for (line, cells) in (0..).zip(curve.cells(&axis)) {
            let value = curve.beside(line).map_or(String::new(), |value| value.to_string());
            let cells: String = cells.into_iter().collect();
            let line = format!("{value:>VALUES$} {cells}");
            let _ = writeln!(text, "{}", line.trim_end());
        }
        text
    }
}

impl Curve {
    /// The value of a line, where it is written: at the top, in the middle, at the bottom.
    fn beside(&self, line: i64) -> Option<i64> {
        let at = [0, LINES / 2, LINES - 1];
        let (least, most) = self.values.ends();
        at.contains(&line).then(|| {
            let below = (i128::from(most) - i128::from(least)) * i128::from(line) / i128::from(LINES - 1);
            i64::try_from(i128::from(most) - below).unwrap_or(most)
        })
    }

    fn cells(&self, axis: &Axis) -> Vec<Vec<char>> {
        let mut cells = vec![vec![' '; COLUMNS as usize]; LINES as usize];
        let line = |value: i64| (self.values.y(value, 0, LINES - 1).0 + 5) / 10;
        for (time, bucket) in self.samples.between(axis.from, axis.to) {
            let column = (axis.x(time).0 / 10).unsigned_abs() as usize;
            let (top, bottom) = (line(bucket.most), line(bucket.least));
            for line in top..=bottom {
                let row = cells.get_mut(line.unsigned_abs() as usize);
                if let Some(cell) = row.and_then(|row| row.get_mut(column)) {
                    // A stroke that is there stays.
                    *cell = if top == bottom && *cell == ' ' {
                        '·'
                    } else if top == bottom {
                        *cell
                    } else {
                        '│'
                    };
                }
            }
        }
        cells
    }
}
