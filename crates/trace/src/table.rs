//! Tables of others: PLC traces, spreadsheets, exports of scopes.
//!
//! What the `csv` crate takes apart is read by the columns that the header or a [`TableLayout`] names, and what was assumed
//! is told.

pub(crate) mod head;
mod layout;
mod look;
mod names;
mod source;
pub(crate) mod time;

use std::io::{self, BufReader, Cursor, Read};

use encoring_words::number::{self, Bare};

use self::head::Head;
pub use self::layout::{Columns, TableLayout};
pub(crate) use self::look::Seen;
use self::look::{again, look};
use self::names::{Half, Meaning, Recognised, Word, recognise};
use self::source::{ROW_LIMIT, Rows};
use self::time::{Commas, Marks, Scale, Unit, decimal};
use crate::columns::{Column, CycleSeen, Doubt, Input, ROW_NS, Row, Style};
use crate::decimal::Decimal;
use crate::error::{Error, Problem, excerpt};
use crate::lines::Lines;
use crate::text::Text;

/// What to say of a decimal comma in a cell that a comma ends.
pub(crate) const DECIMAL_POINT: &str = "; where a comma separates the cells, decimals stand behind a point";

/// What was looked at, and the rest.
type Source<R> = Rows<io::Chain<Cursor<Vec<u8>>, BufReader<Text<R>>>>;

/// The rows of a table.
#[derive(Debug)]
pub(crate) struct Table<R> {
    file: String,
    reader: csv::Reader<Source<R>>,
    record: csv::ByteRecord,
    /// Lines before those that `reader` has.
    skipped: u64,
    head: Head,
    /// Cells of a row; what stands behind is empty.
    width: usize,
    style: Style,
    commas: Commas,
    time: Option<(usize, Scale)>,
    columns: Vec<(usize, Column)>,
    halves: Vec<(usize, Word, Half)>,
    /// The column that says what is wrong with a row.
    faults: Option<usize>,
    period_ns: u64,
    /// Where the times begin, less the days that have passed since.
    origin_ns: i128,
    previous_ns: Option<u64>,
    marks: Marks,
    assumed: String,
    doubt: Doubt,
}

impl<R: Read> Table<R> {
    /// Begins with lines that were read from `lines`, the first ones that are not blank and no comment.
    pub(crate) fn open(
        mut lines: Lines<Text<R>>,
        seen: Vec<Seen>,
        layout: &TableLayout,
    ) -> Result<Self, Error> {
        let (head, seen) = look(&mut lines, seen, layout)?;
        let first = seen.get(head.rows_at()).map(|row| head::cells(&row.text, head.separator));
        let says_all = layout.columns.is_some() || layout.period_ns.is_some();
        let at = seen.get(head.at).map(|seen| seen.number);
        let head = if says_all {
            head
        } else {
            head.timed(first.as_deref()).map_err(|(_, problem)| lines.error_at(at, None, problem))?
        };
        let wrong =
            |(column, problem): Misfit| lines.error_at(at, column.map(|index| head.label(index)), problem);
        let row = seen.get(head.rows_at()).map(|row| row.text.as_slice());
        check(&head, row, layout).map_err(wrong)?;
        let unit = unit(&head).map_err(wrong)?;
        let row_at = seen.get(head.rows_at()).map(|seen| seen.number);
        check_time(&head, unit, first.as_deref()).map_err(|(column, problem)| {
            lines.error_at(row_at, column.map(|index| head.label(index)), problem)
        })?;
        let time = scale(&head, unit, first.as_deref()).map_err(wrong)?;
        if time.is_some() && layout.period_ns.is_some() {
            let others = head.columns.iter().copied().filter(|(_, meaning)| !meaning.is_time()).collect();
            let to_type = head.with(others).to_type(&[]);
            let problem = format!(
                "the table has times; leave --period out, or name the columns without it, as {to_type}"
            );
            return Err(wrong((None, Problem::Table(problem))));
        }
        let filled =
            |cells: Vec<String>| cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        let own = |(index, meaning): &(usize, Meaning)| match meaning {
            Meaning::Own(column) => Some((*index, *column)),
            _ => None,
        };
        let half = |(index, meaning): &(usize, Meaning)| match meaning {
            Meaning::Half(word, half) => Some((*index, *word, *half)),
            _ => None,
        };
        let assumed = assumed(&head, layout, time, lines.source().encoding());
        let (skipped, again) = again(seen.get(head.rows_at()..).unwrap_or_default(), &lines);
        let (file, source) = lines.into_rest();
        Ok(Self {
            file,
            reader: csv::ReaderBuilder::new()
                .has_headers(false)
                .flexible(true)
                .delimiter(head.separator)
                .from_reader(Rows::new(Cursor::new(again).chain(source))),
            record: csv::ByteRecord::new(),
            skipped,
            width: if head.has_header() { head.names.len() } else { first.map_or(0, filled) },
            style: Style { bare: layout.bare },
            commas: if head.separator == b',' { Commas::Separate } else { Commas::Decimal },
            time,
            columns: head.columns.iter().filter_map(own).collect(),
            halves: head.columns.iter().filter_map(half).collect(),
            faults: head.names.iter().position(|name| layout.faults.as_ref() == Some(name)),
            head,
            period_ns: layout.period_ns.unwrap_or(ROW_NS),
            origin_ns: 0,
            previous_ns: None,
            marks: Marks::default(),
            assumed,
            doubt: Doubt::Nothing,
        })
    }

    pub(crate) fn has(&self, column: Column) -> bool {
        self.columns.iter().any(|(_, read)| *read == column)
    }

    /// What was assumed, as one line.
    pub(crate) fn assumed(&self) -> &str {
        &self.assumed
    }

    /// Nanoseconds at which the times begin: of a date since 1970, of a time of day since midnight.
    pub(crate) const fn origin_ns(&self) -> i128 {
        self.origin_ns
    }

    /// Whether there were words, and none that could not be decimal.
    pub(crate) fn may_be_decimal(&self) -> bool {
        self.style.bare == Bare::Hexadecimal && self.doubt == Doubt::AllDigits
    }

    /// Reads the next row into one that is new; `false` behind the last.
    pub(crate) fn row(&mut self, row: &mut Row) -> Result<bool, Error> {
        let before = loop {
            let before = self.reader.position().line();
            self.reader.get_mut().allow(ROW_LIMIT);
            match self.reader.read_byte_record(&mut self.record) {
                Ok(true) if is_blank(&self.record) => {}
                Ok(true) => break before,
                Ok(false) => return Ok(false),
                Err(error) => {
                    let problem = source::problem(error);
                    return Err(self.error(self.skipped + self.reader.position().line(), None, problem));
                }
            }
        };
        row.line = self.skipped + self.line(before);
        match self.cells(row) {
            Ok(()) => Ok(true),
            Err((index, problem)) => Err(self.error(row.line, index, problem)),
        }
    }

    /// The line where the record begins, of those that `reader` has, if it began to look for it in line `before`.
    fn line(&self, before: u64) -> u64 {
        let after = self.reader.position().line();
        if after == before + 1 {
            return before;
        }
        // Each record ends with a line feed; those in quotes are within it.
        let text = self.record.as_slice();
        let within = text.iter().filter(|byte| **byte == b'\n').count();
        // In an open quote the end of the file is one.
        let ends = u64::from(text.last() != Some(&b'\n'));
        after.saturating_sub(ends + within as u64)
    }

    fn error(&self, line: u64, index: Option<usize>, problem: Problem) -> Error {
        let column = index.map(|index| self.head.label(index));
        Error { file: self.file.clone(), line, column, problem, is_half: self.reader.get_ref().is_cut() }
    }

    fn cells(&mut self, row: &mut Row) -> Result<(), Misfit> {
        let found = self.record.len();
        let behind = || self.record.iter().skip(self.width).any(|cell| !cell.trim_ascii().is_empty());
        if found != self.width && (found < self.width || behind()) {
            return Err((None, self.misfit(found)));
        }
        row.time_ns = self.time()?;
        for place in 0..self.columns.len() {
            let Some(&(index, column)) = self.columns.get(place) else { continue };
            let cell = self.record.get(index).unwrap_or_default().trim_ascii();
            if column.read(cell, row, self.style).is_none() {
                self.other(index, column, row)?;
            }
            if self.doubt != Doubt::Settled && column.is_word() {
                self.doubt = self.doubt.after(cell);
            }
        }
        if !self.halves.is_empty() {
            self.put_together(row)?;
        }
        let fault = self.faults.and_then(|index| self.record.get(index)).unwrap_or_default();
        if !fault.trim_ascii().is_empty() {
            row.cycle = Some(CycleSeen::Bad);
        }
        self.previous_ns = Some(row.time_ns);
        Ok(())
    }

    /// Reads a cell that is not as we would write it.
    fn other(&self, index: usize, column: Column, row: &mut Row) -> Result<(), Misfit> {
        let cell = self.record.get(index).unwrap_or_default().trim_ascii();
        let shown = || column.problem(cell, self.style);
        let text = head::unquoted(str::from_utf8(cell).map_err(|_| (Some(index), shown()))?);
        let comma = column.is_decimal() && self.commas == Commas::Decimal;
        let again = if comma { text.replacen(',', ".", 1) } else { text.to_ascii_lowercase() };
        column.read(again.as_bytes(), row, self.style).ok_or_else(|| match column {
            _ if column.is_decimal() && cell.contains(&b',') => {
                (Some(index), Problem::Table(format!("{}{DECIMAL_POINT}", shown())))
            }
            Column::Position => {
                let steps = "a position in steps is the column value";
                (Some(index), Problem::Table(format!("{}; {steps}", shown())))
            }
            _ => (Some(index), shown()),
        })
    }

    fn put_together(&self, row: &mut Row) -> Result<(), Misfit> {
        let (mut out, mut input) = ([None; 2], [None; 2]);
        for &(index, word, half) in &self.halves {
            let cell = self.record.get(index).unwrap_or_default().trim_ascii();
            if cell.is_empty() {
                continue;
            }
            let text =
                str::from_utf8(cell).map_err(|_| (Some(index), Problem::value(cell, "half a word")))?;
            let read = number::half(text, self.style.bare)
                .map_err(|error| (Some(index), Problem::Table(error.to_string())))?;
            let place = match word {
                Word::Out => &mut out,
                Word::In => &mut input,
            };
            let [high, low] = place;
            *(if half == Half::High { high } else { low }) = Some(read.bits);
        }
        let whole = |halves: [Option<u32>; 2], word| match halves {
            [Some(high), Some(low)] => Ok(Some(high << 16 | low)),
            [None, None] => Ok(None),
            _ => {
                let index = self.halves.iter().find(|(_, found, _)| *found == word).map(|(index, ..)| *index);
                Err((index, Problem::Table("one half of a word is there and the other is not".to_owned())))
            }
        };
        if let Some(out) = whole(out, Word::Out)? {
            row.out = Some(out);
        }
        if let Some(input) = whole(input, Word::In)? {
            row.input = Some(Input::Word(input));
        }
        Ok(())
    }

    fn misfit(&self, found: usize) -> Problem {
        if self.record.as_slice().contains(&b'\n') {
            return Problem::Table(
                "a double quote in this row is not closed, so the next one is read with it".to_owned(),
            );
        }
        let cut = self.reader.get_ref().is_cut();
        Problem::Width { found, expected: self.width, cut, header: self.head.has_header() }
    }

    fn time(&mut self) -> Result<u64, Misfit> {
        let Some((index, scale)) = self.time else {
            let next = |previous_ns: u64| previous_ns.saturating_add(self.period_ns);
            return Ok(self.previous_ns.map_or(0, next));
        };
        let cell = self.record.get(index).unwrap_or_default().trim_ascii();
        // Most tables count from where they begin, and most times are whole numbers.
        if let (Some(found), Some(previous_ns), true) =
            (scale.natural(cell), self.previous_ns, self.origin_ns == 0)
            && found >= previous_ns
        {
            return Ok(found);
        }
        self.other_time(index, scale)
    }

    /// Reads a time that is no whole number, or the first one, or not above the one before.
    #[inline(never)]
    fn other_time(&mut self, index: usize, scale: Scale) -> Result<u64, Misfit> {
        let cell = self.record.get(index).unwrap_or_default().trim_ascii();
        let natural = scale.natural(cell);
        let wrong = |problem| (Some(index), Problem::Table(problem));
        let text = head::unquoted(str::from_utf8(cell).unwrap_or_default());
        let may_be_both = self.commas == Commas::Decimal && matches!(scale, Scale::Unit(_));
        if may_be_both && self.marks.in_doubt(text, self.previous_ns.is_some()) {
            let whole = text.replace(['.', ','], "");
            let problem = format!(
                "{text}: decimals, or {whole} with a mark between its thousands, as whole times stand above; write all \
                 times with decimals, or none with a mark"
            );
            return Err(wrong(problem));
        }
        let Some(found) = natural.map(i128::from).or_else(|| scale.ns(text, self.commas)) else {
            let comma = match scale {
                Scale::Unit(_) if self.commas == Commas::Separate && cell.contains(&b',') => DECIMAL_POINT,
                _ => "",
            };
            return Err(wrong(format!("{:?} is not {}{comma}", excerpt(cell), scale.allowed())));
        };
        let Some(previous_ns) = self.previous_ns else {
            self.origin_ns = scale.start(found);
            return u64::try_from(found - self.origin_ns).map_err(|_| wrong("too large a time".to_owned()));
        };
        let previous = i128::from(previous_ns);
        let mut time_ns = found.saturating_sub(self.origin_ns);
        let days = scale.wrapped(time_ns, previous);
        self.origin_ns -= days;
        time_ns += days;
        if time_ns < previous {
            let earlier = previous.saturating_sub(time_ns);
            let advice = "sort the rows by time, or leave the column out and give --period";
            return Err(wrong(format!(
                "{:?} is {} us before the row before it; {advice}",
                excerpt(cell),
                Decimal::microseconds(u64::try_from(earlier).unwrap_or(u64::MAX))
            )));
        }
        u64::try_from(time_ns).map_err(|_| wrong("too large a time".to_owned()))
    }
}

#[inline]
fn is_blank(record: &csv::ByteRecord) -> bool {
    // The first byte of the first cell that is not empty tells of nearly all rows.
    if record.as_slice().first().is_some_and(|byte| *byte != b'#' && !byte.is_ascii_whitespace()) {
        return false;
    }
    let first = record.iter().next().unwrap_or_default();
    first.starts_with(b"#") || record.iter().all(|cell| cell.trim_ascii().is_empty())
}

type Misfit = (Option<usize>, Problem);

/// What must be true of a header, however it was found.
fn check(head: &Head, row: Option<&[u8]>, layout: &TableLayout) -> Result<(), Misfit> {
    check_once(head, layout)?;
    if layout.columns.is_none() {
        check_close(head)?;
        if let Some(problem) = head.without_content(row) {
            return Err((None, problem));
        }
    }
    check_halves(head, Word::Out, "out", Column::Out)?;
    check_halves(head, Word::In, "in", Column::In)
}

/// No column is read twice, and none that is named could be another.
fn check_once(head: &Head, layout: &TableLayout) -> Result<(), Misfit> {
    for (place, (index, meaning)) in head.columns.iter().enumerate() {
        let twice = |(_, known): &&(usize, Meaning)| known == meaning || known.is_time() && meaning.is_time();
        if let Some((at, (first, known))) =
            head.columns.iter().take(place).enumerate().find(|(_, it)| twice(it))
        {
            // One whose unit is told is read as it is.
            let left = if *known == Meaning::TimeAsNamed { at } else { place };
            let both = if meaning.is_time() { "the time" } else { meaning.name() };
            let problem = format!(
                "{} and {} are both {both}; say which is read, as {}",
                head.label(*first),
                head.label(*index),
                head.without(left).to_type(&[])
            );
            return Err((None, Problem::Table(problem)));
        }
        let name = head.names.get(*index);
        if layout.columns.is_some()
            && name.is_some()
            && head.names.iter().filter(|known| Some(*known) == name).count() > 1
        {
            let numbered = head.to_type(&[]);
            let problem = format!("more than one column has this name; give their numbers, as {numbered}");
            return Err((Some(*index), Problem::Table(problem)));
        }
    }
    Ok(())
}

/// A word is there as a whole, or in both halves.
fn check_halves(head: &Head, word: Word, name: &str, whole: Column) -> Result<(), Misfit> {
    let there = |wanted| head.columns.iter().any(|(_, meaning)| *meaning == wanted);
    let (high, low) = (there(Meaning::Half(word, Half::High)), there(Meaning::Half(word, Half::Low)));
    let problem = if high != low {
        format!("{name}_high and {name}_low: only one of the halves is there")
    } else if high && there(Meaning::Own(whole)) {
        format!("{name}, {name}_high and {name}_low: a word is there as a whole or in halves")
    } else {
        return Ok(());
    };
    Err((None, Problem::Table(problem)))
}

/// A name that looks like ours is not left without a word.
fn check_close(head: &Head) -> Result<(), Misfit> {
    let close = head.names.iter().enumerate().filter_map(|(index, name)| match recognise(name) {
        Recognised::Close(ours) => Some((index, ours)),
        _ => None,
    });
    let close: Vec<_> = close.collect();
    let Some(&(index, ours)) = close.first() else { return Ok(()) };
    let taken = |ours: &str| head.columns.iter().any(|(_, meaning)| meaning.name() == ours);
    let without = head.to_type(&[]);
    let problem = if taken(ours) {
        format!("looks like {ours}, which is there too; to read the others and leave it, type {without}")
    } else {
        // Each of our names once: the first that looks like it.
        let first = |place: usize, ours: &str| !close.iter().take(place).any(|(_, known)| *known == ours);
        let all = close.iter().enumerate().filter(|(place, (_, ours))| !taken(ours) && first(*place, ours));
        let with = head.to_type(&all.map(|(_, close)| *close).collect::<Vec<_>>());
        let without =
            if head.columns.is_empty() { String::new() } else { format!("; if not, type {without}") };
        format!("looks like {ours}; if it is, type {with}{without}")
    };
    Err((Some(index), Problem::Table(problem)))
}

/// The column of times, and its unit if it is told.
fn unit(head: &Head) -> Result<Option<(usize, Option<Unit>)>, Misfit> {
    let time = head.columns.iter().find(|(_, meaning)| meaning.is_time());
    let Some(&(index, meaning)) = time else { return Ok(None) };
    let name = head.names.get(index).map_or("", String::as_str);
    let named = match meaning {
        Meaning::Time(unit) => Some(unit),
        _ => names::unit_apart(name).1,
    };
    match (named, head.unit_below(index)) {
        (Some(named), Some(below)) if named != below => {
            let (named, below) = (named.name(), below.name());
            let problem =
                format!("a time in {named}, and the row of units below says {below}; correct one of them");
            Err((Some(index), Problem::Table(problem)))
        }
        (named, below) => Ok(Some((index, named.or(below)))),
    }
}

/// Times without a unit are dates or durations, or numbers whose unit is asked for.
fn check_time(
    head: &Head,
    unit: Option<(usize, Option<Unit>)>,
    first: Option<&[String]>,
) -> Result<(), Misfit> {
    let Some((index, None)) = unit else { return Ok(()) };
    let Some(cell) = first.and_then(|first| first.get(index)) else { return Ok(()) };
    if Scale::of(cell).is_some() || decimal(cell, Commas::Decimal, 0).is_some() {
        return Ok(());
    }
    let problem = format!(
        "{:?} is no time that is read, such as 2026-11-27T10:00:00.001Z, 27.11.2026 10:00:00.001 or T#1s200ms; \
         rewrite them, or leave the column out and say how far rows are apart, as {} --period 10ms",
        excerpt(cell.as_bytes()),
        others(head, index).to_type(&[])
    );
    Err((Some(index), Problem::Table(problem)))
}

/// The column of times, and how they are written.
fn scale(
    head: &Head,
    unit: Option<(usize, Option<Unit>)>,
    first: Option<&[String]>,
) -> Result<Option<(usize, Scale)>, Misfit> {
    let Some((index, unit)) = unit else { return Ok(None) };
    let scale = match (unit, first.and_then(|first| first.get(index))) {
        (Some(unit), _) => Scale::Unit(unit),
        // There are no rows.
        (None, None) => Scale::Unit(Unit::Us),
        (None, Some(cell)) => Scale::of(cell).ok_or_else(|| {
            let problem = format!(
                "no unit, and {:?} is no date; type {}, or with time_s, time_us or time_ns",
                excerpt(cell.as_bytes()),
                others(head, index).to_type(&[(index, "time_ms")])
            );
            (Some(index), Problem::Table(problem))
        })?,
    };
    Ok(Some((index, scale)))
}

/// The columns that are read but for one.
fn others(head: &Head, index: usize) -> Head {
    head.with(head.columns.iter().copied().filter(|(other, _)| *other != index).collect())
}

fn assumed(
    head: &Head,
    layout: &TableLayout,
    time: Option<(usize, Scale)>,
    encoding: Option<&'static str>,
) -> String {
    let separator = match head.separator {
        b'\t' => "a tab",
        b';' => "`;`",
        _ => "`,`",
    };
    let mut parts = vec![format!("{separator} separates the cells")];
    parts.extend(encoding.map(|encoding| format!("the text is {encoding}")));
    let from = |index: usize| format!("from {}", head.label(index));
    for (index, meaning) in &head.columns {
        parts.push(match time {
            Some((time, scale)) if time == *index => match scale {
                Scale::Unit(unit) => format!("time in {} {}", unit.name(), from(*index)),
                Scale::Span => format!("time {}", from(*index)),
                _ => format!("time {} counts from the first row", from(*index)),
            },
            _ => format!("{} {}", meaning.name(), from(*index)),
        });
    }
    if head.has_units() {
        parts.push("the row below the names has units".to_owned());
    }
    if time.is_none() && layout.period_ns.is_none() {
        parts.push("rows are 1 ms apart, see --period".to_owned());
    }
    let left = |index: &usize| !head.columns.iter().any(|(read, _)| read == index);
    let left: Vec<_> = (0..head.names.len()).filter(left).map(|index| head.label(index)).collect();
    if !left.is_empty() {
        parts.push(format!("not read: {}", left.join(", ")));
    }
    parts.join("; ")
}
