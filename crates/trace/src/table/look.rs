//! The lines that were read to find the head of a table, and what becomes of them.

use std::io::Read;

use super::head::{self, Head, Search, is_row};
use super::layout::TableLayout;
use crate::error::{Error, Problem};
use crate::lines::Lines;
use crate::text::Text;

/// The most lines before a header.
const BEFORE_MAX: usize = 200;

/// The header, its units, and the first row.
const HEAD_MAX: usize = 3;

/// A line that was looked at for the header.
pub(crate) struct Seen {
    pub(super) number: u64,
    pub(crate) text: Vec<u8>,
}

impl Seen {
    /// The line that was read last.
    pub(crate) fn last_of<R: Read>(lines: &Lines<Text<R>>) -> Self {
        Self { number: lines.number(), text: lines.line().to_vec() }
    }
}

/// Looks for the head, from these lines on as far as it must.
pub(super) fn look<R: Read>(
    lines: &mut Lines<Text<R>>,
    mut seen: Vec<Seen>,
    layout: &TableLayout,
) -> Result<(Head, Vec<Seen>), Error> {
    let columns = layout.columns.as_ref();
    let mut search = Search::new(columns);
    let mut looked_at = 0;
    let has_head = |seen: &[Seen]| columns.is_some() || !seen.first().is_some_and(|seen| is_row(&seen.text));
    let found = loop {
        while let Some(line) = seen.get(looked_at) {
            looked_at += 1;
            if let Some(head) = search.line(&line.text) {
                return Ok((head, seen));
            }
        }
        if seen.len() >= BEFORE_MAX + HEAD_MAX || !has_head(&seen) {
            break None;
        }
        if !lines.advance_to_row()? {
            break search.end();
        }
        seen.push(Seen::last_of(lines));
    };
    if let Some(head) = found {
        return Ok((head, seen));
    }
    if seen.len() >= BEFORE_MAX + HEAD_MAX && columns.is_none() {
        let problem = format!(
            "no header with in, out or value in the first {BEFORE_MAX} lines; delete those before it"
        );
        return Err(lines.error(None, Problem::Table(problem)));
    }
    let texts: Vec<_> = seen.iter().map(|seen| seen.text.as_slice()).collect();
    let (at, problem) = head::missing(&texts, columns);
    Err(lines.error_at(seen.get(at).map(|seen| seen.number), None, problem))
}

/// The text of the rows that were looked at, with blank lines for those that were skipped; and the number of lines
/// before it.
pub(super) fn again<R: Read>(rows: &[Seen], lines: &Lines<Text<R>>) -> (u64, Vec<u8>) {
    let Some(from) = rows.first().map(|row| row.number) else { return (lines.number(), Vec::new()) };
    let mut text = Vec::new();
    let mut next = from;
    let blank = |text: &mut Vec<u8>, count: u64| {
        text.resize(text.len() + usize::try_from(count).unwrap_or_default(), b'\n');
    };
    for row in rows {
        blank(&mut text, row.number - next);
        text.extend_from_slice(&row.text);
        text.push(b'\n');
        next = row.number + 1;
    }
    blank(&mut text, (lines.number() + 1).saturating_sub(next));
    if !lines.is_ended() {
        text.pop();
    }
    (from - 1, text)
}
