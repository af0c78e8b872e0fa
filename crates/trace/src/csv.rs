//! Traces and recordings as CSV: reading and writing.

use std::io::{self, Read, Write};
use std::iter::FusedIterator;

use crate::columns::{Column, Row};
use crate::error::{Error, Problem, excerpt};
use crate::header::{self, DEVICE_LINE_LIMIT, DeviceLine, Recording};
use crate::lines::Lines;

const LINE_LIMIT: usize = 4096;
/// How far rows are apart without the column `time_us`.
const ROW_NS: u64 = 1_000_000;

/// Reads a trace or a recording, row by row. After the first error there are no more rows.
///
/// A recording that was cut off, as a killed program leaves it, has the rows up to its last line end: a last row
/// without one may be a piece that still reads as a row, and is left out.
#[derive(Debug)]
pub struct Reader<R> {
    lines: Lines<R>,
    recording: Option<Recording>,
    columns: Vec<Column>,
    previous_ns: Option<u64>,
    piece: Option<u64>,
    ended: bool,
}

impl<R: Read> Reader<R> {
    /// Reads all up to the header. Errors call the file `file_name`. The source needs no buffer.
    pub fn new(file_name: impl Into<String>, source: R) -> Result<Self, Error> {
        let mut lines = Lines::new(file_name.into(), source);
        let mut recording: Option<Recording> = None;
        let columns = loop {
            let limit = if recording.is_some() { DEVICE_LINE_LIMIT } else { LINE_LIMIT };
            if !lines.advance(limit)? {
                return Err(lines.error(None, Problem::NoHeader));
            }
            let line = lines.line();
            let problem = |problem| lines.error(None, problem);
            if is_header_or_row(line) {
                break columns(line).map_err(problem)?;
            } else if lines.number() == 1 {
                recording = header::is_recording(line).map_err(problem)?.then(Recording::default);
            } else if let Some(recording) = &mut recording {
                recording.comment(lines.number(), line).map_err(problem)?;
            }
        };
        if recording.is_some() && !columns.contains(&Column::Position) {
            return Err(lines.error(None, Problem::NoPosition));
        }
        Ok(Self { lines, recording, columns, previous_ns: None, piece: None, ended: false })
    }

    /// The encoders that the file starts from, if it is a recording.
    pub fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    /// The line of the last row of a recording, if it has no line end and was left out; known behind the last row.
    pub const fn piece(&self) -> Option<u64> {
        self.piece
    }

    fn row(&mut self) -> Result<Option<Row>, Error> {
        loop {
            if !self.lines.advance(LINE_LIMIT)? {
                return Ok(None);
            }
            if is_header_or_row(self.lines.line()) {
                break;
            }
        }
        if self.recording.is_some() && !self.lines.is_ended() {
            self.piece = Some(self.lines.number());
            return Ok(None);
        }
        let time_ns = self.previous_ns.map_or(0, |previous_ns| previous_ns.saturating_add(ROW_NS));
        let mut row = Row { line: self.lines.number(), time_ns, ..Row::default() };
        let mut cells = cells(self.lines.line());
        let mut read = 0;
        for (column, cell) in self.columns.iter().zip(&mut cells) {
            if column.read(cell, &mut row).is_none() {
                break;
            }
            read += 1;
        }
        if read < self.columns.len() || cells.next().is_some() {
            return Err(self.misfit(read));
        }
        in_order(self.previous_ns, row.time_ns)
            .map_err(|problem| self.lines.error(Some(Column::Time.name()), problem))?;
        self.previous_ns = Some(row.time_ns);
        Ok(Some(row))
    }

    /// Why the row could not be read beyond its first `read` cells. A wrong number of cells comes first,
    /// since a cell left out makes all behind it look wrong.
    fn misfit(&self, read: usize) -> Error {
        let (found, expected) = (cells(self.lines.line()).count(), self.columns.len());
        match self.columns.get(read).zip(cells(self.lines.line()).nth(read)) {
            Some((column, cell)) if found == expected => {
                self.lines.error(Some(column.name()), Problem::value(cell, column.allowed()))
            }
            _ => self.lines.error(None, Problem::Cells { found, expected }),
        }
    }
}

impl<R: Read> Iterator for Reader<R> {
    type Item = Result<Row, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let row = self.row().transpose();
        self.ended = !matches!(row, Some(Ok(_)));
        row
    }
}

impl<R: Read> FusedIterator for Reader<R> {}

fn is_header_or_row(line: &[u8]) -> bool {
    !line.starts_with(b"#") && !line.trim_ascii().is_empty()
}

/// The cells without their quotes. No cell may hold a comma or a quote, so what else CSV allows in quotes
/// comes to an error here too.
fn cells(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|&byte| byte == b',').map(|cell| match cell {
        [b'"', inner @ .., b'"'] => inner,
        _ => cell,
    })
}

fn columns(header: &[u8]) -> Result<Vec<Column>, Problem> {
    let mut columns = Vec::new();
    for name in cells(header) {
        let Some(column) = Column::named(name) else {
            return Err(Problem::UnknownColumn { name: excerpt(name) });
        };
        if columns.contains(&column) {
            return Err(Problem::Twice { what: "column", name: column.name().to_owned() });
        }
        columns.push(column);
    }
    Ok(columns)
}

fn in_order(previous_ns: Option<u64>, time_ns: u64) -> Result<(), Problem> {
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
        for (column, end) in self.columns.iter().zip(ends(self.columns.len())) {
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

fn refusal(problem: Problem) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, problem)
}
