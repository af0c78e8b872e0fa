//! The rows that are judged now, with those before and behind them.

use std::ops::Range;

use encoring_host::validity::Circle;

use crate::curve::Point;
use crate::row::{ReadAs, Row};
use crate::ways::Stretch;

/// Rows of one encoder, and their positions.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) rows: &'a [Row],
    /// The rows that are judged; the others are beside them.
    pub(crate) range: &'a Range<usize>,
    pub(crate) points: &'a [Point],
    pub(crate) circle: Circle,
    pub(crate) period_ns: i64,
    pub(crate) tolerance: i64,
    /// Rows that are not read in the usual way.
    pub(crate) stretches: &'a [Stretch],
    pub(crate) usual: ReadAs,
}

impl Part<'_> {
    /// The way in which a row is read.
    pub(crate) fn way_of(&self, row: usize) -> ReadAs {
        way_of(self.stretches, self.usual, row)
    }
}

/// The way in which a row is read.
pub(crate) fn way_of(stretches: &[Stretch], usual: ReadAs, row: usize) -> ReadAs {
    stretches.iter().find(|stretch| stretch.rows.contains(&row)).map_or(usual, |stretch| stretch.way)
}
