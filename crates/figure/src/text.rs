//! A timing figure drawn with characters.

use crate::timing::{Content, Lane, LaneLevel, TimingFigure};

/// Columns of a line, the name of the lane included.
const COLUMNS: usize = 80;
/// Between the name and the line.
const GAP: usize = 2;

impl TimingFigure {
    /// The lines as characters, each of which stands for `column_ns` nanoseconds: `‾` High, `_` Low, `?` unknown. What is
    /// wider than 80 columns goes on below. Marks and axis are left out.
    #[must_use]
    pub fn text(&self, column_ns: u64) -> String {
        let names = self.lanes.iter().map(|lane| lane.name.chars().count()).max().unwrap_or(0) + GAP;
        let room = COLUMNS.saturating_sub(names).max(1);
        let columns = (self.to - self.from).div_ceil(column_ns.max(1)).min(u64::from(u16::MAX)) as usize;
        let mut text = String::new();
        for first in (0..columns).step_by(room) {
            if first > 0 {
                text.push('\n');
            }
            for lane in &self.lanes {
                let drawn = self.drawn(lane, column_ns.max(1), columns);
                let line: String = drawn.iter().skip(first).take(room).collect();
                let line = format!("{:<names$}{line}", lane.name);
                text.push_str(line.trim_end());
                text.push('\n');
            }
        }
        text
    }

    fn drawn(&self, lane: &Lane, column_ns: u64, columns: usize) -> Vec<char> {
        match &lane.content {
            Content::Levels { first, changes } => {
                let mut changes = changes.iter().copied().peekable();
                let mut shown = *first;
                let middles = (0..columns as u64).map(|column| {
                    self.from.saturating_add(column.saturating_mul(column_ns)).saturating_add(column_ns / 2)
                });
                let level = |middle: u64| {
                    while let Some((_, next)) = changes.next_if(|(at, _)| *at <= middle) {
                        shown = next;
                    }
                    match shown {
                        LaneLevel::High => '‾',
                        LaneLevel::Low => '_',
                        LaneLevel::Unknown => '?',
                    }
                };
                middles.map(level).collect()
            }
            Content::Words(words) => {
                let mut line = vec![' '; columns];
                for word in words {
                    let column = |at: u64| (at.saturating_sub(self.from) / column_ns) as usize;
                    let (from, to) = (column(word.from), column(word.to));
                    let cells = line.iter_mut().take(to).skip(from);
                    cells.zip(word.text.chars()).for_each(|(cell, sign)| *cell = sign);
                }
                line
            }
        }
    }
}
