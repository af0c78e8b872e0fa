//! Where a table begins: its separator, its header, and the lines before it.

use encoring_words::number::{self, Bare};

use super::Misfit;
use super::layout::{Columns, typed};
use super::names::{Meaning, Recognised, recognise, unit_apart};
use super::time::{Commas, Scale, Unit, decimal};
use crate::columns::Column;
use crate::error::Problem;

const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];
/// The most names that a message lists.
const LISTED: usize = 12;

/// The head of a table.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) separator: u8,
    /// The index of the header among the lines that were looked at; of the first row if there is no header.
    pub(super) at: usize,
    /// Names of the header, without the empty ones at its end; empty if there is no header.
    pub(super) names: Vec<String>,
    /// The columns to read, by index.
    pub(super) columns: Vec<(usize, Meaning)>,
    /// The cells of a row of units below the header, as oscilloscopes write it; empty if there is none.
    units: Vec<String>,
}

impl Head {
    pub(super) fn has_header(&self) -> bool {
        !self.names.is_empty()
    }

    /// The index of the first row.
    pub(super) fn rows_at(&self) -> usize {
        self.at + usize::from(self.has_header()) + usize::from(self.has_units())
    }

    pub(super) fn has_units(&self) -> bool {
        !self.units.is_empty()
    }

    /// The unit of time that stands below the name of a column.
    pub(super) fn unit_below(&self, index: usize) -> Option<Unit> {
        self.units.get(index).and_then(|cell| Unit::named(in_brackets(cell).unwrap_or(cell)))
    }

    /// The same with its row of units, if the line below is one: no data, and all in brackets or a unit below a time.
    fn above(mut self, line: &[u8]) -> Self {
        let cells = names(line, self.separator);
        let times = self.columns.iter().filter(|(_, meaning)| meaning.is_time());
        let mut times = times.filter_map(|(index, _)| cells.get(*index));
        let brackets = cells.iter().all(|cell| cell.is_empty() || in_brackets(cell).is_some());
        if self.has_header()
            && (brackets || times.any(|cell| Unit::named(cell).is_some()))
            && !cells.iter().any(|cell| is_data(cell))
        {
            self.units = cells;
        }
        self
    }

    /// Whether one of the columns holds data in this line.
    fn has_data(&self, line: &[u8]) -> bool {
        let cells = cells(line, self.separator);
        self.columns.iter().filter_map(|(index, _)| cells.get(*index)).any(|cell| is_data(cell))
    }

    /// The same with the one column that can only be the time, where none is by its name: it has a unit of time, or
    /// dates in the first row.
    pub(super) fn timed(mut self, first: Option<&[String]>) -> Result<Self, Misfit> {
        if self.columns.iter().any(|(_, meaning)| meaning.is_time()) {
            return Ok(self);
        }
        let dated = |index: usize| first.and_then(|first| Scale::of(first.get(index)?)).is_some();
        let time = |(index, name): (usize, &String)| {
            let unit = unit_apart(name).1.or_else(|| self.unit_below(index));
            let meaning = unit.map(Meaning::Time).or_else(|| dated(index).then_some(Meaning::TimeAsNamed));
            meaning.filter(|_| recognise(name) == Recognised::Other).map(|time| (index, time))
        };
        let found: Vec<_> = self.names.iter().enumerate().filter_map(time).collect();
        match *found {
            [] => {}
            [only] => self.columns.push(only),
            [(index, time), (other, _), ..] => {
                let problem = format!(
                    "{} and {} may both be the time; say which is, as {}, or give --period",
                    self.label(index),
                    self.label(other),
                    self.to_type(&[(index, time.name())])
                );
                return Err((None, Problem::Table(problem)));
            }
        }
        self.columns.sort_unstable_by_key(|(index, _)| *index);
        Ok(self)
    }

    /// Why it cannot be used if no column that is read holds words or positions; the row is the first.
    pub(super) fn without_content(&self, row: Option<&[u8]>) -> Option<Problem> {
        let there = self.columns.iter().any(|(_, meaning)| meaning.is_content());
        (!there).then(|| nameless(&self.names, &example(&self.names, row.as_ref(), false)))
    }

    /// What a column is called in messages.
    pub(super) fn label(&self, index: usize) -> String {
        match self.names.get(index) {
            Some(name) => format!("{name:?}"),
            None => (index + 1).to_string(),
        }
    }

    /// The same without one of the columns that are read.
    pub(super) fn without(&self, place: usize) -> Self {
        let mut columns = self.columns.clone();
        columns.remove(place);
        self.with(columns)
    }

    /// The same with other columns to read.
    pub(super) fn with(&self, columns: Vec<(usize, Meaning)>) -> Self {
        Self {
            separator: self.separator,
            at: self.at,
            names: self.names.clone(),
            columns,
            units: self.units.clone(),
        }
    }

    /// `--columns` with what was recognised, and more; by numbers where a name stands twice.
    pub(super) fn to_type(&self, more: &[(usize, &str)]) -> String {
        let more = more.iter().copied();
        let mut columns: Vec<_> =
            self.columns.iter().map(|(index, meaning)| (*index, meaning.name())).chain(more).collect();
        columns.sort_unstable();
        let at = |index: usize| self.names.get(index);
        let again = |name| self.names.iter().filter(|known| *known == name).count() > 1;
        let numbered = columns.iter().filter_map(|(index, _)| at(*index)).any(again);
        let name = |index: usize| match at(index) {
            Some(name) if !numbered => typed(name),
            _ => (index + 1).to_string(),
        };
        let pairs: Vec<_> =
            columns.into_iter().map(|(index, ours)| format!("{ours}={}", name(index))).collect();
        option(&pairs.join(","))
    }
}

/// The option as it is typed into a shell.
fn option(columns: &str) -> String {
    if columns.contains(['"', '$', '`', '\\']) {
        format!("--columns '{columns}'")
    } else {
        format!("--columns \"{columns}\"")
    }
}

/// Looks for the head of a table, line by line. The first line that may be a header and has data below it is it.
pub(super) struct Search<'a> {
    columns: Option<&'a Columns>,
    lines: usize,
    /// What may be the head, as long as the line that decides it was not seen: the last lines.
    open: Vec<Head>,
    /// The first header without data below it.
    dataless: Option<Head>,
}

impl<'a> Search<'a> {
    pub(super) const fn new(columns: Option<&'a Columns>) -> Self {
        Self { columns, lines: 0, open: Vec::new(), dataless: None }
    }

    /// One more line; gives the head once it is sure.
    pub(super) fn line(&mut self, line: &[u8]) -> Option<Head> {
        let at = self.lines;
        self.lines += 1;
        for head in std::mem::take(&mut self.open) {
            // The line below a header may have its units.
            let head = if at == head.at + 1 { head.above(line) } else { head };
            if head.rows_at() > at {
                self.open.push(head);
            } else if head.has_data(line) {
                return Some(head);
            } else {
                self.leave(head);
            }
        }
        let head = match self.columns {
            Some(columns) => by_columns(line, at, columns),
            None => by_names(line, at),
        };
        let head = head?;
        if head.rows_at() == at {
            return Some(head);
        }
        self.open.push(head);
        None
    }

    /// There are no more lines: a header may stand alone.
    pub(super) fn end(mut self) -> Option<Head> {
        for head in std::mem::take(&mut self.open) {
            self.leave(head);
        }
        self.dataless
    }

    fn leave(&mut self, head: Head) {
        if self.dataless.is_none() && head.has_header() {
            self.dataless = Some(head);
        }
    }
}

/// Whether a line below this header has units and no data.
pub(crate) fn has_units_below(header: &[u8], line: &[u8]) -> bool {
    by_names(header, 0).is_some_and(|head| head.above(line).has_units())
}

/// A line as the header that `--columns` names, or, where it takes numbers, as the first row.
fn by_columns(line: &[u8], at: usize, columns: &Columns) -> Option<Head> {
    let heads = SEPARATORS.into_iter().filter_map(|separator| {
        let names = names(line, separator);
        let place = |name: &str| {
            let place = |same: &dyn Fn(&str) -> bool| names.iter().position(|known| same(known));
            place(&|known| known == name)
                .or_else(|| place(&|known| known.eq_ignore_ascii_case(name)))
                .or_else(|| place(&|known| known.replace('"', "").eq_ignore_ascii_case(name)))
        };
        let named: Option<Vec<_>> =
            columns.0.iter().map(|(meaning, name)| Some((place(name)?, *meaning))).collect();
        if let Some(columns) = named {
            return Some(Head { separator, at, names, columns, units: Vec::new() });
        }
        let numbered: Option<Vec<_>> =
            columns.0.iter().map(|(meaning, name)| Some((column_number(name)?, *meaning))).collect();
        let head = Head { separator, at, names: Vec::new(), columns: numbered?, units: Vec::new() };
        let cells = cells(line, separator);
        let fits = head.columns.iter().all(|(index, _)| *index < cells.len());
        // A sentence stands in the lines before the rows.
        let has_digits =
            |cell: &String| cell.is_empty() || cell.contains(|letter: char| letter.is_ascii_digit());
        let time = head.columns.iter().find(|(_, meaning)| meaning.is_time());
        let timed = time.and_then(|(index, _)| cells.get(*index)).is_none_or(has_digits);
        (fits && timed && head.has_data(line)).then_some(head)
    });
    heads.max_by_key(|head| cells(line, head.separator).len())
}

/// An index from a number from 1.
fn column_number(name: &str) -> Option<usize> {
    usize::try_from(number::value(name).ok()?.number).ok()?.checked_sub(1)
}

/// A line as a header in which we know a name.
fn by_names(line: &[u8], at: usize) -> Option<Head> {
    let heads = SEPARATORS.into_iter().filter_map(|separator| {
        let names = names(line, separator);
        if names.iter().any(|name| is_data(name)) {
            return None;
        }
        let known: Vec<_> = names.iter().map(|name| recognise(name)).collect();
        let columns: Vec<_> = (0..)
            .zip(&known)
            .filter_map(|(index, known)| match known {
                Recognised::As(meaning) => Some((index, *meaning)),
                _ => None,
            })
            .collect();
        let close = known.iter().any(|known| matches!(known, Recognised::Close(_)));
        let told = !columns.is_empty() || close && names.len() > 1;
        told.then_some((columns.len(), Head { separator, at, names, columns, units: Vec::new() }))
    });
    heads.max_by_key(|(known, head)| (*known, head.names.len())).map(|(_, head)| head)
}

/// Why there is no header, with the line to type; and the index of the line to point at.
pub(super) fn missing(lines: &[&[u8]], columns: Option<&Columns>) -> (usize, Problem) {
    let widest = |line: &&[u8]| SEPARATORS.into_iter().map(|separator| names(line, separator).len()).max();
    let width = lines.iter().filter_map(widest).max().unwrap_or(0);
    let at = lines.iter().position(|line| widest(line) == Some(width)).unwrap_or(0);
    let Some(line) = lines.get(at) else { return (0, Column::no_header()) };
    let names = SEPARATORS.map(|separator| names(line, separator)).into_iter().max_by_key(Vec::len);
    let names = names.unwrap_or_default();
    if let [only] = names.as_slice()
        && only.contains(['|', ' '])
        && columns.is_none()
    {
        let problem =
            format!("{only:?} is one cell: cells are separated by `,`, `;` or a tab; write one of them");
        return (at, Problem::Table(problem));
    }
    let headless = is_row(line);
    let row = if headless { Some(line) } else { lines.get(at + 1) };
    let example = example(&names, row, headless);
    let there = listed(&names);
    let sentence = match columns {
        Some(columns) if !headless => {
            let absent = columns
                .0
                .iter()
                .map(|(_, name)| name)
                .find(|name| !names.iter().any(|known| known.eq_ignore_ascii_case(name)));
            let absent = absent.map_or("", String::as_str);
            format!("--columns: no column is called {absent:?}; the columns are {there}")
        }
        Some(_) => format!("no header, so --columns takes numbers from 1, as {example}"),
        None if headless => format!("no header: say which column is which by its number, as {example}"),
        None => return (at, nameless(&names, &example)),
    };
    (at, Problem::Table(sentence))
}

/// No column holds words or positions by its name.
fn nameless(names: &[String], example: &str) -> Problem {
    let there = listed(names);
    Problem::Table(format!(
        "none of the columns {there} is in, out or value by its name; say which, as {example}"
    ))
}

fn listed(names: &[String]) -> String {
    let listed: Vec<_> = names.iter().take(LISTED).map(|name| format!("{name:?}")).collect();
    let more = if names.len() > LISTED { " and more" } else { "" };
    format!("{}{more}", listed.join(", "))
}

/// An option that may be what is wanted.
fn example(names: &[String], row: Option<&&[u8]>, headless: bool) -> String {
    let row = row.map(|row| {
        let rows = SEPARATORS.map(|separator| cells(row, separator));
        rows.into_iter().max_by_key(Vec::len).unwrap_or_default()
    });
    let cell = |index: usize| row.as_ref().and_then(|row| row.get(index)).map_or("", String::as_str);
    let name = |index: usize| match names.get(index) {
        Some(name) if !headless => typed(name),
        _ => (index + 1).to_string(),
    };
    let time = (0..names.len()).find(|index| Scale::of(cell(*index)).is_some());
    let time = time.or((names.len() > 1).then_some(0));
    // Outputs are O, Q and in German A.
    let outward = |index: &usize| {
        let first = names.get(*index).and_then(|name| name.chars().next()).unwrap_or(' ');
        matches!(first.to_ascii_lowercase(), 'o' | 'q' | 'a')
    };
    let words: Vec<_> = (0..names.len()).filter(|index| Some(*index) != time).collect();
    let (out, input) = match *words {
        [first, second, ..] => {
            let out = words.iter().copied().find(outward).unwrap_or(first);
            (Some(out), Some(if out == first { second } else { first }))
        }
        [only] => (None, Some(only)),
        [] => (None, None),
    };
    let unit = time.and_then(|index| names.get(index)).and_then(|name| match recognise(name) {
        Recognised::As(Meaning::Time(unit)) => Some(unit),
        _ => unit_apart(name).1,
    });
    let time_name = match (time.map(cell).and_then(Scale::of), unit) {
        (Some(_), _) => "time".to_owned(),
        (None, unit) => format!("time_{}", unit.unwrap_or(Unit::Ms).name()),
    };
    let pairs = [(time, time_name.as_str()), (out, "out"), (input, "in")];
    let pairs = pairs.into_iter().filter_map(|(index, ours)| Some(format!("{ours}={}", name(index?))));
    option(&pairs.collect::<Vec<_>>().join(","))
}

/// The cells of a line.
pub(crate) fn cells(line: &[u8], separator: u8) -> Vec<String> {
    let text = |cell: &[u8]| unquoted(String::from_utf8_lossy(cell).trim()).to_owned();
    // To make a reader costs as much as to read a thousand rows.
    if !line.contains(&b'"') {
        return line.split(|byte| *byte == separator).map(text).collect();
    }
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).delimiter(separator).from_reader(line);
    let mut record = csv::ByteRecord::new();
    // A slice cannot fail; a line with an open quote gives what there is.
    let _ = reader.read_byte_record(&mut record);
    record.iter().map(text).collect()
}

/// A cell without quotes that a space stood before.
pub(super) fn unquoted(cell: &str) -> &str {
    cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(cell)
}

/// The cells of a line without the empty ones at its end, where a separator too many stands.
fn names(line: &[u8], separator: u8) -> Vec<String> {
    let mut names = cells(line, separator);
    while names.pop_if(|name| name.is_empty()).is_some() {}
    names
}

/// What stands in brackets, as `(ms)`.
fn in_brackets(cell: &str) -> Option<&str> {
    let within = |open, close| cell.strip_prefix(open)?.strip_suffix(close).map(str::trim);
    within('(', ')').or_else(|| within('[', ']'))
}

/// Whether every cell reads as a time, a number or a word.
pub(super) fn is_row(line: &[u8]) -> bool {
    SEPARATORS.into_iter().any(|separator| {
        let cells = names(line, separator);
        cells.len() > 1 && cells.iter().all(|cell| is_data(cell))
    })
}

fn is_data(cell: &str) -> bool {
    decimal(cell, Commas::Decimal, 0).is_some()
        || Scale::of(cell).is_some()
        || [Bare::Hexadecimal, Bare::Decimal].into_iter().any(|bare| number::word([cell], bare).is_ok())
        || cell.contains(['#', '=']) && number::half(cell, Bare::Hexadecimal).is_ok()
        || cell.len() > 2 && cell.starts_with("0x") && number::half(cell, Bare::Hexadecimal).is_ok()
}
