//! What was seen on a bus: the image at every cycle, and every write to it, with who wrote.
//!
//! The first line is `# encoring-bus 1`. Lines `# device` may follow as in a recording, then the header; its columns
//! may stand in any order:
//!
//! | column | holds | if missing |
//! |---|---|---|
//! | `time_us` | microseconds, three decimals, never backwards | rows 1 ms apart from 0 |
//! | `position` | 0 to 127 | 0 |
//! | `event` | `cycle` or `write` | `cycle` |
//! | `out`, `in` | of a cycle: the words, of which only `in` may be empty, or `off`, where nothing came | 0, none |
//! | `line` | of a cycle: `good`, `bad`, `silent` or empty | empty |
//! | `client` | of a write: a number | 0 |
//! | `half` | of a write: `high`, `low`, or `both` or empty | `both` |
//! | `value` | of a write: 4 hex digits of a half, 8 of both | there is no write |

use std::io::{self, Read, Write};

use encoring_words::{OutWord, Written};

use crate::columns::{Column, CycleSeen, Input, ROW_NS, Row, Style};
use crate::csv::{cells, comment, in_order, refusal};
use crate::error::{Error, Problem, excerpt};
use crate::header::{DeviceLine, Recording};
use crate::lines::{LINE_LIMIT, Lines, is_header_or_row};

/// How the first line begins.
pub const MARK: &str = "# encoring-bus ";

/// The columns in the order in which they are written.
const COLUMNS: [&str; 9] = ["time_us", "position", "event", "out", "in", "line", "client", "half", "value"];

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusEvent {
    /// A cycle of the ring.
    Cycle {
        /// What went out.
        out: u32,
        /// What came in.
        input: Option<Input>,
        /// How it went.
        line: Option<CycleSeen>,
    },
    /// A write by a client of the master.
    Write {
        /// Who.
        client: u32,
        /// What.
        written: Written,
    },
}

/// One row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusRow {
    /// The line of the file, from 1. Not written.
    pub line: u64,
    /// Nanoseconds since the start.
    pub time_ns: u64,
    /// The ring position.
    pub position: u8,
    /// What happened there.
    pub event: BusEvent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BusColumn {
    /// As in a trace.
    Shared(Column),
    Event,
    Client,
    Half,
    Value,
}

impl BusColumn {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"event" => Self::Event,
            b"client" => Self::Client,
            b"half" => Self::Half,
            b"value" => Self::Value,
            b"time_us" | b"position" | b"out" | b"in" | b"line" => Self::Shared(Column::named(name)?),
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Shared(column) => column.name(),
            Self::Event => "event",
            Self::Client => "client",
            Self::Half => "half",
            Self::Value => "value",
        }
    }

    fn problem(self, cell: &[u8]) -> Problem {
        match self {
            Self::Shared(column) => column.problem(cell, Style::default()),
            Self::Event => Problem::value(cell, "cycle or write"),
            Self::Client => Problem::value(cell, "a whole number from 0 to 4294967295"),
            Self::Half => Problem::value(cell, "high, low or both"),
            Self::Value => Problem::value(cell, "4 hex digits of the half that the row names, or 8 of both"),
        }
    }
}

/// The cells of a row of which a trace knows nothing.
#[derive(Clone, Copy, Debug, Default)]
struct Own {
    is_write: bool,
    client: u32,
    half: Half,
    value: u32,
    /// Of the value; 0 if there is none.
    digits: usize,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Half {
    High,
    Low,
    #[default]
    Both,
}

impl Own {
    fn read(&mut self, column: BusColumn, cell: &[u8]) -> Option<()> {
        match (column, cell) {
            (_, b"") => {}
            (BusColumn::Event, b"cycle") => self.is_write = false,
            (BusColumn::Event, b"write") => self.is_write = true,
            (BusColumn::Half, b"high") => self.half = Half::High,
            (BusColumn::Half, b"low") => self.half = Half::Low,
            (BusColumn::Half, b"both") => self.half = Half::Both,
            (BusColumn::Client, digits) => self.client = number(digits, 10)?,
            (BusColumn::Value, cell) => {
                let digits = cell.strip_prefix(b"0x").unwrap_or(cell);
                (self.value, self.digits) = (number(digits, 16)?, digits.len());
            }
            _ => return None,
        }
        Some(())
    }

    /// A half that is missing is no zero.
    fn written(self) -> Option<Written> {
        match (self.half, self.digits) {
            (Half::High, 4) => Some(Written::High(u16::try_from(self.value).ok()?)),
            (Half::Low, 4) => Some(Written::Low(u16::try_from(self.value).ok()?)),
            (Half::Both, 8) => Some(Written::Both(OutWord(self.value))),
            _ => None,
        }
    }
}

fn number(digits: &[u8], base: u32) -> Option<u32> {
    digits.iter().try_fold(0_u32, |number, digit| {
        number.checked_mul(base)?.checked_add(char::from(*digit).to_digit(base)?)
    })
}

/// Reads what was seen on a bus, row by row. After the first error there are no more rows.
#[derive(Debug)]
pub struct BusReader<R> {
    lines: Lines<R>,
    columns: Vec<BusColumn>,
    recording: Recording,
    previous_ns: Option<u64>,
    ended: bool,
}

impl<R: Read> BusReader<R> {
    /// Reads all up to the header. Errors call the file `file_name`.
    ///
    /// # Errors
    /// What is wrong with the head, and where.
    pub fn new(file_name: impl Into<String>, source: R) -> Result<Self, Error> {
        let mut lines = Lines::new(file_name.into(), source);
        let mut recording = Recording::default();
        loop {
            if !lines.advance(LINE_LIMIT)? {
                let problem = Problem::NoHeader { columns: COLUMNS.join(", ") };
                return Err(lines.error(None, problem));
            }
            let line = lines.line();
            if is_header_or_row(line) {
                break;
            }
            let read = match comment(line).strip_prefix(MARK.as_bytes()) {
                Some(b"1") => Ok(()),
                Some(version) => Err(Problem::Version { version: excerpt(version) }),
                None => recording.comment(lines.number(), comment(line)),
            };
            read.map_err(|problem| lines.error(None, problem))?;
        }
        let mut columns = Vec::new();
        for name in cells(lines.line()) {
            let Some(column) = BusColumn::named(name) else {
                return Err(lines.error(None, Problem::value(name, "a column of what was seen on a bus")));
            };
            if columns.contains(&column) {
                let twice = Problem::Twice { what: "column", name: column.name().to_owned() };
                return Err(lines.error(None, twice));
            }
            columns.push(column);
        }
        Ok(Self { lines, columns, recording, previous_ns: None, ended: false })
    }

    /// The encoders that the file names.
    pub fn devices(&self) -> &[DeviceLine] {
        &self.recording.devices
    }

    fn row(&mut self) -> Result<Option<BusRow>, Error> {
        loop {
            if !self.lines.advance(LINE_LIMIT)? {
                return Ok(None);
            }
            if is_header_or_row(self.lines.line()) {
                break;
            }
        }
        let found = cells(self.lines.line()).count();
        if found != self.columns.len() {
            let (expected, cut) = (self.columns.len(), !self.lines.is_ended());
            return Err(self.lines.error(None, Problem::Width { found, expected, cut, header: true }));
        }
        let time_ns = self.previous_ns.map_or(0, |previous| previous.saturating_add(ROW_NS));
        let mut row = Row { time_ns, ..Row::default() };
        let mut own = Own::default();
        let error = |column: BusColumn, cell| self.lines.error(Some(column.name()), column.problem(cell));
        let mut value: &[u8] = b"";
        for (column, cell) in self.columns.iter().zip(cells(self.lines.line())) {
            let cell = cell.trim_ascii();
            let read = match column {
                BusColumn::Shared(column) => column.read(cell, &mut row, Style::default()),
                column => own.read(*column, cell),
            };
            read.ok_or_else(|| error(*column, cell))?;
            value = if *column == BusColumn::Value { cell } else { value };
        }
        let out_column = BusColumn::Shared(Column::Out);
        let event = if own.is_write {
            let written = own.written().ok_or_else(|| error(BusColumn::Value, value))?;
            BusEvent::Write { client: own.client, written }
        } else if row.out.is_none() && self.columns.contains(&out_column) {
            let problem = Problem::value(b"", "a word: each cycle says what stood on OUT");
            return Err(self.lines.error(Some(out_column.name()), problem));
        } else {
            BusEvent::Cycle { out: row.out.unwrap_or_default(), input: row.input, line: row.cycle }
        };
        in_order(self.previous_ns, row.time_ns)
            .map_err(|problem| self.lines.error(Some(Column::Time.name()), problem))?;
        self.previous_ns = Some(row.time_ns);
        let (line, position) = (self.lines.number(), row.position.unwrap_or_default());
        Ok(Some(BusRow { line, time_ns: row.time_ns, position, event }))
    }
}

impl<R: Read> Iterator for BusReader<R> {
    type Item = Result<BusRow, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let row = self.row().transpose();
        self.ended = !matches!(row, Some(Ok(_)));
        row
    }
}

/// Writes what is seen on a bus, each row with one call of the sink.
#[derive(Debug)]
pub struct BusWriter<W> {
    sink: W,
    line: Vec<u8>,
}

impl<W: Write> BusWriter<W> {
    /// Begins a file that names these encoders.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn new(mut sink: W, devices: &[DeviceLine]) -> io::Result<Self> {
        let mut head = format!("{MARK}1\n");
        for device in devices {
            head += &format!("{device}\n");
        }
        head += &COLUMNS.join(",");
        head.push('\n');
        sink.write_all(head.as_bytes())?;
        Ok(Self { sink, line: Vec::new() })
    }

    /// Writes one row.
    ///
    /// # Errors
    /// Those of the sink; a position above 127 is refused.
    pub fn write(&mut self, row: &BusRow) -> io::Result<()> {
        let shared = Row { time_ns: row.time_ns, position: Some(row.position), ..Row::default() };
        self.line.clear();
        Column::Time.write(&shared, &mut self.line)?;
        self.line.push(b',');
        Column::Position.write(&shared, &mut self.line)?;
        match row.event {
            BusEvent::Cycle { out, input, line } => {
                write!(self.line, ",cycle,{out:08X},")?;
                input.map_or(Ok(()), |input| write!(self.line, "{input}"))?;
                writeln!(self.line, ",{},,,", line.map_or("", CycleSeen::name))?;
            }
            BusEvent::Write { client, written } => {
                write!(self.line, ",write,,,,{client},")?;
                match written {
                    Written::High(value) => writeln!(self.line, "high,{value:04X}"),
                    Written::Low(value) => writeln!(self.line, "low,{value:04X}"),
                    Written::Both(word) => writeln!(self.line, "both,{word}"),
                }?;
            }
        }
        self.sink.write_all(&self.line).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidInput => refusal(Problem::Read(error)),
            _ => error,
        })
    }

    /// Flushes the sink.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(file: &str) -> Result<Vec<BusRow>, Error> {
        BusReader::new("bus.csv", file.as_bytes())?.collect()
    }

    #[test]
    fn what_was_written_reads_back() {
        let cycle = |input, line| BusEvent::Cycle { out: 0xC200_270F, input, line };
        let write = |written| BusEvent::Write { client: 7, written };
        let events = [
            cycle(Some(Input::Word(0x64)), Some(CycleSeen::Good)),
            cycle(Some(Input::Off), Some(CycleSeen::Bad)),
            cycle(None, Some(CycleSeen::Silent)),
            write(Written::High(0xC200)),
            write(Written::Low(5)),
            write(Written::Both(OutWord(0x0200_0000))),
        ];
        let mut writer = BusWriter::new(Vec::new(), &[]).unwrap();
        let mut wanted = Vec::new();
        for (k, event) in (0_u8..).zip(events) {
            let row = BusRow { line: u64::from(k) + 3, time_ns: u64::from(k) * 1_500, position: k, event };
            writer.write(&row).unwrap();
            wanted.push(row);
        }
        let file = String::from_utf8(writer.sink).unwrap();
        assert!(file.starts_with("# encoring-bus 1\ntime_us,position,event,out,in,line,client,half,value\n"));
        assert!(file.contains("\n4.5,3,write,,,,7,high,C200\n"), "{file}");
        assert_eq!(rows(&file).unwrap(), wanted);
    }

    #[test]
    fn what_cannot_be_read_is_told_with_its_place() {
        let head = "# encoring-bus 1\ntime_us,event,half,value\n";
        for (rest, told) in [
            (
                "5,write,high,12345\n",
                "bus.csv line 3, column value: \"12345\" is not 4 hex digits of the half",
            ),
            ("5,write,high,\n", "bus.csv line 3, column value: \"\" is not 4 hex digits of the half"),
            ("5,write,,C600\n", "bus.csv line 3, column value: \"C600\" is not 4 hex digits of the half"),
            ("5,reset,,\n", "bus.csv line 3, column event: \"reset\" is not cycle or write"),
            ("5,write,mid,0\n", "bus.csv line 3, column half: \"mid\" is not high, low or both"),
            ("5,cycle\n", "bus.csv line 3: 2 cells, the header has 4"),
            ("5,cycle,,\n4,cycle,,\n", "bus.csv line 4, column time_us: 4 is before 5"),
        ] {
            let error = rows(&format!("{head}{rest}")).unwrap_err().to_string();
            assert!(error.starts_with(told), "{error}");
        }
        for head in
            ["# encoring-bus 2\n", "# encoring-bus 1\ntime_us,raw\n", "# encoring-bus 1\nout,out\n", ""]
        {
            rows(head).unwrap_err();
        }
    }
}
