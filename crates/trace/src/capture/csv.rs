//! Tables: a row for each change with its time, as Saleae's Logic writes them, or a row for each sample without one, as
//! PulseView and sigrok-cli do.

use std::io::Read;
use std::ops::ControlFlow;

use super::decimal::{SampleRate, hertz, scaled};
use super::{
    CHANNELS_MAX, CaptureChange, CaptureEnd, CapturePlace, CaptureProblem, CaptureTimes, Told, Wrong,
    wrong_line,
};
use crate::lines::Lines;
use crate::table::time::{Commas, Scale};

/// The longest row.
const LINE_MAX: usize = 64 * 1024;

/// The longest comment that is read.
const COMMENTS: [char; 2] = [';', '#'];

/// What the head says.
pub(super) struct Head {
    separator: char,
    cells: usize,
    /// Of each channel its cell.
    columns: Vec<usize>,
    times: Times,
    /// Lines before the first row.
    before: u64,
    origin_ns: i64,
    /// The rate of the samples does not stand in the file.
    is_rate_given: bool,
}

/// Where the time of a row comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Times {
    /// A cell, in units of so many decimal places of a second.
    Cell { cell: usize, places: i32 },
    /// A cell with a date or a time of day; they count from the first row.
    Dates { cell: usize, scale: Scale, first_ns: i128 },
    /// Rows are samples.
    Samples(SampleRate),
}

impl Times {
    const fn cell(self) -> Option<usize> {
        match self {
            Self::Cell { cell, .. } | Self::Dates { cell, .. } => Some(cell),
            Self::Samples(_) => None,
        }
    }
}

impl Head {
    pub(super) const fn origin_ns(&self) -> i64 {
        self.origin_ns
    }

    pub(super) const fn sample_ns(&self) -> Option<u64> {
        match self.times {
            Times::Samples(rate) => Some(rate.period_ns()),
            Times::Cell { .. } | Times::Dates { .. } => None,
        }
    }

    pub(super) const fn times(&self) -> CaptureTimes {
        match self.times {
            Times::Samples(rate) if self.is_rate_given => CaptureTimes::SampledAsGiven(rate.hertz()),
            Times::Samples(rate) => CaptureTimes::Sampled(rate.hertz()),
            Times::Cell { .. } | Times::Dates { .. } => CaptureTimes::Stamped,
        }
    }
}

fn advance<R: Read>(lines: &mut Lines<R>) -> Result<bool, Wrong> {
    lines.advance(LINE_MAX).map_err(|error| {
        let problem = match error.problem {
            crate::Problem::Read(cause) => cause.into(),
            other => CaptureProblem::refused(other),
        };
        (CapturePlace::Line(error.line), problem)
    })
}

fn text<R: Read>(lines: &Lines<R>) -> Result<&str, Wrong> {
    let line = str::from_utf8(lines.line()).map_err(|_| wrong_line(lines.number(), "not UTF-8 text"))?;
    // Spreadsheets put a byte order mark in front of the first line.
    Ok(if lines.number() == 1 { line.trim_start_matches('\u{FEFF}') } else { line })
}

/// What the comments of sigrok say.
#[derive(Default)]
struct Comments {
    samplerate: Option<u64>,
    channels: Vec<String>,
}

impl Comments {
    fn read(&mut self, comment: &str, line: u64) -> Result<(), Wrong> {
        let comment = comment.trim_start_matches(COMMENTS).trim();
        if let Some(rate) = comment.strip_prefix("Samplerate:") {
            let wrong = || wrong_line(line, format!("samplerate {:?} is no rate", rate.trim()));
            self.samplerate = Some(hertz(rate).ok_or_else(wrong)?);
        } else if let Some((_, names)) =
            comment.strip_prefix("Channels").and_then(|rest| rest.split_once(':'))
        {
            self.channels = names.split(',').map(|name| name.trim().to_owned()).collect();
        }
        Ok(())
    }
}

/// The decimal places of a second that a column of times has; `None` for a column of something else.
fn time_unit(name: &str) -> Option<Result<i32, &'static str>> {
    let name: String =
        name.chars().filter(|sign| !sign.is_whitespace()).collect::<String>().to_ascii_lowercase();
    let bare = ["timestamp", "time", "t"].into_iter().find_map(|time| name.strip_prefix(time));
    let unit = match (name.as_str(), bare) {
        ("seconds" | "milliseconds" | "microseconds" | "nanoseconds", _) => name.as_str(),
        (_, Some(unit)) => unit.trim_matches(['[', ']', '(', ')', '_']),
        _ => return None,
    };
    match unit {
        "s" | "seconds" => Some(Ok(0)),
        "ms" | "milliseconds" => Some(Ok(3)),
        "us" | "µs" | "microseconds" => Some(Ok(6)),
        "ns" | "nanoseconds" => Some(Ok(9)),
        "" => Some(Err("the column of times has no unit; call it Time [s], [ms], [us] or [ns]")),
        _ => None,
    }
}

fn split(line: &str, separator: char) -> impl Iterator<Item = &str> {
    line.split(separator).map(|cell| cell.trim().trim_matches('"').trim())
}

/// The sign between the cells of a first line.
fn separator(line: &str) -> char {
    let count = |sign| line.matches(sign).count();
    let found = ['\t', ';', ','].into_iter().max_by_key(|sign| (count(*sign) > 0, *sign != ','));
    found.filter(|sign| count(*sign) > 0).unwrap_or(',')
}

/// Reads up to the first row.
pub(super) fn head<R: Read>(source: R, samplerate: Option<u64>) -> Result<(Head, Vec<String>), Wrong> {
    let mut lines = Lines::new(String::new(), source);
    let mut comments = Comments::default();
    while advance(&mut lines)? {
        let (line, number) = (text(&lines)?, lines.number());
        if line.trim().is_empty() {
            continue;
        }
        if line.starts_with(COMMENTS) {
            comments.read(line, number)?;
            continue;
        }
        let separator = separator(line);
        let cells: Vec<String> = split(line, separator).map(str::to_owned).collect();
        let is_row = cells.iter().all(|cell| scaled(&cell.replace(',', "."), 0).is_some());
        let first = if is_row || advance(&mut lines)? { text(&lines)? } else { "" };
        let first: Vec<&str> = split(first, separator).collect();
        let (mut head, names) = columns(&cells, is_row, comments, samplerate, &first)
            .map_err(|problem| wrong_line(number, problem))?;
        head.separator = separator;
        head.before = if is_row { number.saturating_sub(1) } else { number };
        head.origin_ns = origin(&head, &first);
        return Ok((head, names));
    }
    let problem =
        "no rows: a capture in CSV has a header as `Time [s],clock,data`, or comments of sigrok and samples";
    Err((CapturePlace::Line(lines.number()), CaptureProblem::refused(problem)))
}

/// A first time below 0: what is before the trigger.
fn origin(head: &Head, first: &[&str]) -> i64 {
    let Times::Cell { cell, places } = head.times else { return 0 };
    let time = first.get(cell).map(|cell| cell.replace(',', "."));
    time.and_then(|time| scaled(&time, 9 - places)).filter(|time| *time < 0).unwrap_or(0)
}

/// How the times of a column are written, by its header and its first cell.
fn times(cell: usize, unit: Result<i32, &'static str>, first: &[&str]) -> Result<Times, String> {
    let first = first.get(cell).copied().unwrap_or_default();
    // Saleae's Logic keeps `Time [s]` above dates.
    let date = Scale::of(first).and_then(|scale| Some((scale, scale.ns(first, Commas::Decimal)?)));
    match date {
        Some((scale, first_ns)) => Ok(Times::Dates { cell, scale, first_ns }),
        None => Ok(Times::Cell { cell, places: unit? }),
    }
}

fn columns(
    cells: &[String],
    is_row: bool,
    comments: Comments,
    samplerate: Option<u64>,
    first: &[&str],
) -> Result<(Head, Vec<String>), String> {
    if cells.len() > CHANNELS_MAX {
        return Err(format!("{} columns, at most {CHANNELS_MAX} are read", cells.len()));
    }
    let mut time = None;
    for (cell, name) in cells.iter().enumerate().filter(|_| !is_row) {
        if let Some(unit) = time_unit(name) {
            if time.is_some() {
                return Err("two columns of times".to_owned());
            }
            time = Some((cell, unit));
        }
    }
    let columns: Vec<usize> =
        (0..cells.len()).filter(|cell| time.is_none_or(|(time, _)| time != *cell)).collect();
    let times = match (time, comments.samplerate.or(samplerate)) {
        (Some((cell, unit)), _) => times(cell, unit, first)?,
        (None, Some(hertz)) => Times::Samples(SampleRate::new(hertz)),
        (None, None) => {
            let problem = "neither a column of times as `Time [s]` nor a comment `; Samplerate: 1 MHz` before it, so no \
                           row has a time; --samplerate tells it";
            return Err(problem.to_owned());
        }
    };
    // sigrok writes the kind of a channel above its column, and its name into a comment.
    let named = !is_row && !columns.iter().all(|cell| cells.get(*cell).is_some_and(|name| name == "logic"));
    let names = if comments.channels.len() == columns.len() {
        comments.channels
    } else if named {
        columns.iter().filter_map(|cell| cells.get(*cell)).cloned().collect()
    } else {
        (1..=columns.len()).map(|number| number.to_string()).collect()
    };
    let head = Head {
        separator: ',',
        cells: cells.len(),
        columns,
        times,
        before: 0,
        origin_ns: 0,
        is_rate_given: comments.samplerate.is_none(),
    };
    Ok((head, names))
}

/// Reads all rows.
pub(super) fn changes<R: Read, F: FnMut(CaptureChange) -> ControlFlow<()>>(
    source: R,
    head: &Head,
    selected: &[usize],
    told: &mut Told<F>,
) -> Result<CaptureEnd, Wrong> {
    let mut lines = Lines::new(String::new(), source);
    while lines.number() < head.before && advance(&mut lines)? {}
    let mut rows = Rows::new(head, selected);
    while advance(&mut lines)? {
        let (line, number) = (text(&lines)?, lines.number());
        if line.is_empty() || line.starts_with(COMMENTS) {
            continue;
        }
        let time_ns = rows.time_ns;
        match rows.row(line, number) {
            Ok(()) => {}
            Err(_) if !lines.is_ended() => return Ok(CaptureEnd { time_ns, cut_in_line: Some(number) }),
            Err(wrong) => return Err(wrong),
        }
        if told.tell(rows.time_ns, rows.high, rows.known).is_break() {
            break;
        }
    }
    Ok(CaptureEnd { time_ns: rows.time_ns, cut_in_line: None })
}

/// Rows under way.
struct Rows<'a> {
    head: &'a Head,
    /// Of each cell the bits of the selected channels.
    bits: Vec<u64>,
    known: u64,
    high: u64,
    time_ns: u64,
    samples: u64,
}

impl<'a> Rows<'a> {
    fn new(head: &'a Head, selected: &[usize]) -> Self {
        let mut bits = vec![0; head.cells];
        let mut known = 0;
        for (channel, bit) in selected.iter().zip(0..) {
            if let Some(cell) = head.columns.get(*channel).and_then(|cell| bits.get_mut(*cell)) {
                *cell |= 1 << bit;
                known |= 1 << bit;
            }
        }
        Self { head, bits, known, high: 0, time_ns: 0, samples: 0 }
    }

    fn row(&mut self, line: &str, number: u64) -> Result<(), Wrong> {
        let (mut high, mut time_ns, mut cells) = (0, self.time_ns, 0);
        for (cell, value) in split(line, self.head.separator).enumerate() {
            cells += 1;
            let bits = self.bits.get(cell).copied().unwrap_or_default();
            if bits != 0 {
                high |= match value {
                    "0" => 0,
                    "1" => bits,
                    _ => return Err(wrong_cell(number, cell, format!("{value:?} is neither 0 nor 1"))),
                };
            } else if self.head.times.cell() == Some(cell) {
                time_ns = self.time(value).map_err(|problem| wrong_cell(number, cell, problem))?;
            }
        }
        if cells != self.head.cells {
            return Err(wrong_line(number, format!("{cells} cells, the first row has {}", self.head.cells)));
        }
        if let Times::Samples(rate) = self.head.times {
            time_ns =
                rate.time_ns(self.samples).ok_or_else(|| wrong_line(number, "the capture is too long"))?;
            self.samples += 1;
        }
        (self.high, self.time_ns) = (high, time_ns);
        Ok(())
    }

    /// Nanoseconds from the origin.
    fn time(&self, value: &str) -> Result<u64, String> {
        let from_origin = match self.head.times {
            Times::Cell { places, .. } => {
                let time = match value.contains(',') {
                    true => scaled(&value.replace(',', "."), 9 - places),
                    false => scaled(value, 9 - places),
                };
                time.map(|time| i128::from(time) - i128::from(self.head.origin_ns))
            }
            Times::Dates { scale, first_ns, .. } => {
                scale.ns(value, Commas::Decimal).map(|time| time.saturating_sub(first_ns))
            }
            Times::Samples(_) => None,
        };
        let from_origin = from_origin.ok_or_else(|| format!("{value:?} is no time"))?;
        if from_origin < i128::from(self.time_ns) {
            return Err(format!("{value} is before the time of the row before"));
        }
        u64::try_from(from_origin).map_err(|_| format!("{value:?} is too far away"))
    }
}

/// Columns are counted from 1 for people.
fn wrong_cell(line: u64, cell: usize, problem: String) -> Wrong {
    (CapturePlace::Column(line, (cell + 1).to_string()), CaptureProblem::Refused(problem))
}
