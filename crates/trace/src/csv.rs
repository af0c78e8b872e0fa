//! Traces and recordings as CSV: reading and writing.

use std::io::{self, Read, Write};
use std::iter::{self, FusedIterator};
use std::mem;

use crate::columns::{Column, Doubt, ROW_NS, Row, RowKind, Style};
use crate::error::{Error, Problem};
use crate::header::{self, DeviceLine, LoggedEncoder, Recording};
use crate::lines::{LINE_LIMIT, Lines, is_header_or_row};
use crate::table::{DECIMAL_POINT, Seen, Table, TableLayout, head};
use crate::text::Text;

/// How the comment begins that tells an edge of the SSI clock.
const SSI_EDGE: &[u8] = b"# ssi ";

/// Reads a trace, a recording, a log or a table of others, row by row. After the first error there are no more rows.
///
/// A recording or a log that was cut off, as a killed program leaves it, has the rows up to its last line end: a last row
/// without one may be a piece that still reads as a row, and is left out.
#[derive(Debug)]
pub struct Reader<R> {
    rows: Rows<R>,
    recording: Option<Recording>,
    logged: Vec<LoggedEncoder>,
    ended: bool,
}

#[derive(Debug)]
enum Rows<R> {
    /// A header as we write it.
    Ours(Box<Trace<R>>),
    Foreign(Box<Table<R>>),
}

impl<R: Read> Rows<R> {
    fn has(&self, column: Column) -> bool {
        match self {
            Self::Ours(trace) => trace.columns.contains(&column),
            Self::Foreign(table) => table.has(column),
        }
    }
}

impl<R: Read> Reader<R> {
    /// Reads all up to the header. Errors call the file `file_name`. The source needs no buffer.
    pub fn new(file_name: impl Into<String>, source: R) -> Result<Self, Error> {
        Self::with(file_name, source, &TableLayout::default())
    }

    /// The same with what is said about a table.
    pub fn with(file_name: impl Into<String>, source: R, layout: &TableLayout) -> Result<Self, Error> {
        let file = file_name.into();
        let source = match Text::new(source) {
            Ok(source) => source,
            Err(error) => {
                return Err(Error {
                    file,
                    line: 1,
                    column: None,
                    problem: Problem::Read(error),
                    is_half: false,
                });
            }
        };
        let mut lines = Lines::new(file, source);
        let mut recording: Option<Recording> = None;
        let mut is_log = false;
        let mut logged: Vec<LoggedEncoder> = Vec::new();
        loop {
            if !lines.advance(LINE_LIMIT)? {
                return Err(lines.error(None, Column::no_header()));
            }
            let line = lines.line();
            let problem = |problem| lines.error(None, problem);
            if is_header_or_row(line) {
                break;
            } else if lines.number() == 1 {
                recording = header::is_recording(comment(line)).map_err(problem)?.then(Recording::default);
                is_log = header::is_log(comment(line));
            } else if let Some(recording) = &mut recording {
                recording.comment(lines.number(), comment(line)).map_err(problem)?;
            } else if is_log && let Some(encoder) = LoggedEncoder::of(comment(line)) {
                // Positions are at most 127, so this also bounds the number of encoders.
                if logged.iter().all(|known| known.position != encoder.position) {
                    logged.push(encoder);
                }
            }
        }
        let ours = columns(lines.line());
        if recording.is_some() && *layout != TableLayout::default() {
            let problem = "a recording says itself what its columns and words are; leave --columns, --decimal and \
                           --period out";
            return Err(lines.error(None, Problem::Table(problem.to_owned())));
        }
        let no_position = lines.error(None, Problem::NoPosition);
        let rows = match ours {
            Some(columns) if *layout == TableLayout::default() => {
                let header = Seen::last_of(&lines);
                // A recording has no row of units, and what it says between its rows is read with them.
                let ahead = recording.is_none() && lines.advance_to_row()?;
                if ahead && head::has_units_below(&header.text, lines.line()) {
                    let seen = vec![header, Seen::last_of(&lines)];
                    Rows::Foreign(Box::new(Table::open(lines, seen, layout)?))
                } else {
                    let origin = match (&recording, is_log) {
                        (Some(_), _) => Origin::Recording,
                        (None, true) => Origin::Log,
                        (None, false) => Origin::Others,
                    };
                    let doubt = Doubt::Nothing;
                    Rows::Ours(Box::new(Trace {
                        lines,
                        columns,
                        ahead,
                        previous_ns: None,
                        doubt,
                        origin,
                        piece: None,
                    }))
                }
            }
            _ => {
                let seen = vec![Seen::last_of(&lines)];
                Rows::Foreign(Box::new(Table::open(lines, seen, layout)?))
            }
        };
        if recording.is_some() && !rows.has(Column::Position) {
            return Err(no_position);
        }
        Ok(Self { rows, recording, logged, ended: false })
    }

    /// The encoders that the file starts from, if it is a recording.
    pub fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    /// The encoders that the head of a log names; none of any other file.
    pub fn logged(&self) -> &[LoggedEncoder] {
        &self.logged
    }

    /// What was assumed of a table of others, as one line.
    pub fn assumed(&self) -> Option<&str> {
        match &self.rows {
            Rows::Ours(_) => None,
            Rows::Foreign(table) => Some(table.assumed()),
        }
    }

    /// Nanoseconds at which the times of the rows begin: of dates since 1970, of times of day since midnight; 0 where times
    /// are as they stand. Known behind the first row.
    pub fn origin_ns(&self) -> i128 {
        match &self.rows {
            Rows::Ours(_) => 0,
            Rows::Foreign(table) => table.origin_ns(),
        }
    }

    /// Whether so far every word was read as hexadecimal and could be decimal.
    pub fn may_be_decimal(&self) -> bool {
        match &self.rows {
            Rows::Ours(trace) => trace.doubt == Doubt::AllDigits,
            Rows::Foreign(table) => table.may_be_decimal(),
        }
    }

    /// The line of the last row of a recording or a log, if it has no line end and was left out; known behind the last row.
    pub fn piece(&self) -> Option<u64> {
        match &self.rows {
            Rows::Ours(trace) => trace.piece,
            Rows::Foreign(_) => None,
        }
    }
}

impl<R: Read> Iterator for Reader<R> {
    type Item = Result<Row, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let mut row = Row::default();
        let read = match &mut self.rows {
            Rows::Ours(trace) => trace.row(&mut row),
            Rows::Foreign(table) => table.row(&mut row),
        };
        if matches!(read, Ok(true)) {
            return Some(Ok(row));
        }
        self.ended = true;
        read.err().map(Err)
    }
}

impl<R: Read> FusedIterator for Reader<R> {}

/// The rows behind a header as we write it.
#[derive(Debug)]
struct Trace<R> {
    lines: Lines<Text<R>>,
    columns: Vec<Column>,
    /// The line is the first row.
    ahead: bool,
    previous_ns: Option<u64>,
    doubt: Doubt,
    origin: Origin,
    /// Of a recording or a log the line of a last row without its end, once it was seen.
    piece: Option<u64>,
}

/// Who wrote a file, as its first line says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    Recording,
    Log,
    /// Somebody else, who may leave out the last line end.
    Others,
}

impl<R: Read> Trace<R> {
    /// Reads the next row into one that is new; `false` behind the last.
    fn row(&mut self, row: &mut Row) -> Result<bool, Error> {
        let kind = loop {
            if !mem::take(&mut self.ahead) && !self.lines.advance(LINE_LIMIT)? {
                return Ok(false);
            }
            match self.lines.line() {
                line if is_header_or_row(line) => break RowKind::Exchange,
                line if self.origin == Origin::Recording && comment(line).starts_with(SSI_EDGE) => {
                    break RowKind::SsiEdge;
                }
                _ => {}
            }
        };
        if self.origin == Origin::Recording && self.is_piece() {
            return Ok(false);
        }
        row.time_ns = self.previous_ns.map_or(0, |previous_ns| previous_ns.saturating_add(ROW_NS));
        (row.line, row.kind) = (self.lines.number(), kind);
        let (columns, line): (&[Column], _) = match kind {
            RowKind::Exchange => (&self.columns, self.lines.line()),
            RowKind::SsiEdge => {
                (&Column::SSI_EDGE, comment(self.lines.line()).get(SSI_EDGE.len()..).unwrap_or_default())
            }
        };
        let mut cells = cells(line);
        let mut read = 0;
        for (column, cell) in columns.iter().zip(&mut cells) {
            if column.read(cell, row, Style::default()).is_none()
                && column.read(cell.trim_ascii(), row, Style::default()).is_none()
            {
                break;
            }
            if self.doubt != Doubt::Settled && column.is_word() {
                self.doubt = self.doubt.after(cell);
            }
            read += 1;
        }
        if read < columns.len() || cells.any(|cell| !cell.trim_ascii().is_empty()) {
            return Err(self.misfit(columns, line, read));
        }
        drop(cells);
        in_order(self.previous_ns, row.time_ns)
            .map_err(|problem| self.lines.error(Some(Column::Time.name()), problem))?;
        self.previous_ns = Some(row.time_ns);
        // What does not read as a row is told as the half line that it is.
        Ok(self.origin != Origin::Log || !self.is_piece())
    }

    /// Whether the line has no end. Recordings and logs are written a line at a time: it may be a piece that reads as a row.
    fn is_piece(&mut self) -> bool {
        if !self.lines.is_ended() {
            self.piece = Some(self.lines.number());
        }
        self.piece.is_some()
    }

    /// Why the row could not be read beyond its first `read` cells. A wrong number of cells comes first,
    /// since a cell left out makes all behind it look wrong.
    fn misfit(&self, columns: &[Column], line: &[u8], read: usize) -> Error {
        let (found, expected) = (cells(line).count(), columns.len());
        match columns.get(read).zip(cells(line).nth(read)) {
            Some((column, cell)) if found == expected => {
                self.lines.error(Some(column.name()), column.problem(cell, Style::default()))
            }
            _ => {
                // A quoted cell with a decimal comma was taken for two.
                let whole = head::cells(line, b',');
                let comma = columns.iter().zip(&whole).find(|(_, cell)| cell.contains(','));
                if let Some((column, cell)) = comma
                    && whole.len() == expected
                {
                    let problem = column.problem(cell.as_bytes(), Style::default());
                    let problem = Problem::Table(format!("{problem}{DECIMAL_POINT}"));
                    return self.lines.error(Some(column.name()), problem);
                }
                let cut = !self.lines.is_ended();
                self.lines.error(None, Problem::Width { found, expected, cut, header: true })
            }
        }
    }
}

/// A comment without the empty cells and the quotes of a spreadsheet.
pub(crate) fn comment(mut line: &[u8]) -> &[u8] {
    while let [before @ .., b',' | b';' | b'\t'] = line {
        line = before;
    }
    match line {
        [b'"', inner @ .., b'"'] => inner,
        _ => line,
    }
}

/// The cells without their quotes. No cell may hold a comma or a quote, so what else CSV allows in quotes
/// comes to an error here too.
pub(crate) fn cells(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(line);
    iter::from_fn(move || {
        let (cell, behind) = rest?.split_at_checked(before_comma(rest?))?;
        rest = behind.get(1..);
        Some(match cell {
            [b'"', inner @ .., b'"'] => inner,
            _ => cell,
        })
    })
}

/// The number of bytes up to a comma or the end. Most cells are so short that a search for the comma begins with its
/// last step: eight bytes at once.
fn before_comma(text: &[u8]) -> usize {
    const EACH: u64 = 0x0101_0101_0101_0101;
    let mut start = 0;
    if let Some(first) = text.first_chunk() {
        let differs = u64::from_le_bytes(*first) ^ (EACH * u64::from(b','));
        // The lowest bit that is set is in the first byte that is zero.
        let zeros = differs.wrapping_sub(EACH) & !differs & (EACH << 7);
        if zeros != 0 {
            return zeros.trailing_zeros() as usize / 8;
        }
        start = first.len();
    }
    let behind = text.iter().skip(start).position(|byte| *byte == b',');
    behind.map_or(text.len(), |more| start + more)
}

/// The columns of a header as we write it; `None` if it is another.
fn columns(header: &[u8]) -> Option<Vec<Column>> {
    let mut columns = Vec::new();
    for name in cells(header) {
        columns.push(Column::named(name).filter(|column| !columns.contains(column))?);
    }
    Some(columns)
}

pub(crate) fn in_order(previous_ns: Option<u64>, time_ns: u64) -> Result<(), Problem> {
    match previous_ns {
        Some(previous_ns) if time_ns < previous_ns => Err(Problem::Backwards { time_ns, previous_ns }),
        _ => Ok(()),
    }
}

/// Writes a trace or a recording, each row with one call of the sink. What a [`Reader`] would refuse is
/// refused with [`io::ErrorKind::InvalidInput`], and nothing of it is written.
#[derive(Debug)]
pub struct Writer<W> {
    sink: W,
    columns: &'static [Column],
    previous_ns: Option<u64>,
    line: Vec<u8>,
}

impl<W: Write> Writer<W> {
    /// Begins a trace of one encoder. Its rows are written without [`Row::position`].
    pub fn new(sink: W) -> io::Result<Self> {
        Self::begin(sink, Vec::new(), &Column::TRACE)
    }

    /// Begins a recording of these encoders. Its rows must have a [`Row::position`].
    pub fn recording(sink: W, devices: &[DeviceLine]) -> io::Result<Self> {
        let head = header::lines(devices).map_err(refusal)?;
        Self::begin(sink, head.into_bytes(), &Column::RECORDING)
    }

    fn begin(mut sink: W, mut head: Vec<u8>, columns: &'static [Column]) -> io::Result<Self> {
        for (column, end) in columns.iter().zip(ends(columns.len())) {
            head.extend_from_slice(column.name().as_bytes());
            head.push(end);
        }
        sink.write_all(&head)?;
        Ok(Self { sink, columns, previous_ns: None, line: Vec::new() })
    }

    /// Writes one row.
    pub fn write(&mut self, row: &Row) -> io::Result<()> {
        in_order(self.previous_ns, row.time_ns).map_err(refusal)?;
        self.line.clear();
        let columns = match row.kind {
            RowKind::Exchange => self.columns,
            RowKind::SsiEdge => {
                self.line.extend_from_slice(SSI_EDGE);
                &Column::SSI_EDGE
            }
        };
        for (column, end) in columns.iter().zip(ends(columns.len())) {
            column.write(row, &mut self.line)?;
            self.line.push(end);
        }
        self.sink.write_all(&self.line)?;
        self.previous_ns = Some(row.time_ns);
        Ok(())
    }

    /// Flushes the sink.
    pub fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }

    /// The sink, with all that was written.
    pub fn into_inner(self) -> W {
        self.sink
    }
}

/// What follows each cell of a line: a comma, and a line feed after the last.
fn ends(cells: usize) -> impl Iterator<Item = u8> {
    (1..=cells).map(move |cell| if cell < cells { b',' } else { b'\n' })
}

pub(crate) fn refusal(problem: Problem) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, problem)
}
