//! A table as it is shown: for people, in Markdown, or as JSON objects.

use std::fmt;

use encoring_sheet::{SheetCell, SheetTable};
use serde::Serialize;
use serde::ser::{SerializeMap, SerializeSeq, Serializer};

use crate::output::wrap::lines;

/// What stands where a manual says nothing.
pub(super) const NOT_STATED: &str = "not stated";

/// The widest line for people.
const WIDTH: usize = 100;
/// The widest column but the last.
const COLUMN: usize = 36;
/// The last column is never narrower.
const LAST_COLUMN: usize = 30;
const GAP: &str = "  ";

/// Rows under named columns, as they are shown.
pub(super) struct Table(pub(super) SheetTable);

/// A cell as it is shown.
struct Cell<'a>(&'a SheetCell);

impl fmt::Display for Cell<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            SheetCell::Said(said) => said.fmt(f),
            SheetCell::Same(text) => f.write_str(text),
            // Such as 39000000000.
            SheetCell::Number(number) if *number >= 1e9 => write!(f, "{number:e}"),
            SheetCell::Number(number) => number.fmt(f),
            SheetCell::NotStated => f.write_str(NOT_STATED),
            SheetCell::Empty => Ok(()),
        }
    }
}

impl Serialize for Cell<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            SheetCell::Said(said) => serializer.serialize_str(said.text()),
            SheetCell::Same(text) => serializer.serialize_str(text),
            SheetCell::Number(number) if number.fract() == 0.0 => serializer.serialize_u64(*number as u64),
            SheetCell::Number(number) => serializer.serialize_f64(*number),
            SheetCell::NotStated | SheetCell::Empty => serializer.serialize_none(),
        }
    }
}

/// A row of a table as an object.
struct Row<'a>(&'a [&'static str], &'a [SheetCell]);

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (column, cell) in self.0.iter().zip(self.1) {
            map.serialize_entry(column, &Cell(cell))?;
        }
        map.end()
    }
}

impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut rows = serializer.serialize_seq(Some(self.0.rows.len()))?;
        for row in &self.0.rows {
            rows.serialize_element(&Row(self.0.columns, row))?;
        }
        rows.end()
    }
}

impl Table {
    pub(super) fn is_empty(&self) -> bool {
        self.0.rows.is_empty()
    }

    pub(super) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(self.0.columns.iter().map(|column| (*column).to_owned()).collect());
        text.push_str(&line(self.0.columns.iter().map(|_| "---".to_owned()).collect()));
        for row in &self.0.rows {
            text.push_str(&line(row.iter().map(|cell| Cell(cell).to_string().replace('|', "\\|")).collect()));
        }
        text
    }

    fn widths(&self) -> Vec<usize> {
        let last = self.0.columns.len().saturating_sub(1);
        let mut left = WIDTH;
        let mut widths = Vec::new();
        for (at, column) in self.0.columns.iter().enumerate() {
            let cells =
                self.0.rows.iter().filter_map(|row| row.get(at)).map(|cell| Cell(cell).to_string().len());
            let widest = cells.chain([column.len()]).max().unwrap_or(0);
            let width = if at == last { widest.min(left.max(LAST_COLUMN)) } else { widest.min(COLUMN) };
            left = left.saturating_sub(width + GAP.len());
            widths.push(width);
        }
        widths
    }
}

/// A paragraph for people.
pub(super) fn paragraph(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    lines(text, WIDTH).iter().try_for_each(|line| writeln!(f, "{line}"))
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths = self.widths();
        let mut row = |cells: Vec<String>| {
            let cells: Vec<Vec<String>> =
                cells.iter().zip(&widths).map(|(cell, width)| lines(cell, *width)).collect();
            let height = cells.iter().map(Vec::len).max().unwrap_or(0);
            (0..height).try_for_each(|at| {
                let mut line = String::new();
                for (cell, width) in cells.iter().zip(&widths) {
                    let part = cell.get(at).map_or("", String::as_str);
                    line.push_str(&format!("{part:<width$}{GAP}"));
                }
                writeln!(f, "{}", line.trim_end())
            })
        };
        row(self.0.columns.iter().map(|column| (*column).to_owned()).collect())?;
        let mut last = String::new();
        self.0.rows.iter().try_for_each(|cells| {
            let mut cells: Vec<String> = cells.iter().map(|cell| Cell(cell).to_string()).collect();
            // What stands at the left of several rows stands there once.
            if let Some(first) = cells.first_mut() {
                if *first == last { first.clear() } else { last.clone_from(first) }
            }
            row(cells)
        })
    }
}
