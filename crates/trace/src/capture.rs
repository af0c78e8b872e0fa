//! Captures of logic analysers: levels of several lines over time, as VCD, as sigrok's `.sr`, and as CSV as Saleae and as
//! PulseView and sigrok-cli write it.
//!
//! What a file is, its first bytes say and not its name. A capture is read change by change in bounded memory, however
//! long it is, and as often as wanted. Times are whole nanoseconds; of a sampled capture each is that of the sample,
//! rounded down, so that errors do not add up.
//!
//! ```
//! use std::io::Cursor;
//! use std::ops::ControlFlow;
//! use encoring_trace::capture::Capture;
//!
//! let file = "Time [s],clock,data\n0,1,1\n0.000001,0,1\n0.000002,1,0\n";
//! let mut capture = Capture::new("bench.csv", Cursor::new(file), None)?;
//! assert_eq!(capture.channels(), ["clock", "data"]);
//! let mut seen = Vec::new();
//! capture.changes(&[0, 1], |change| {
//!     seen.push((change.time_ns, change.high));
//!     ControlFlow::Continue(())
//! })?;
//! assert_eq!(seen, [(0, 0b11), (1_000, 0b10), (2_000, 0b01)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::ControlFlow;

mod csv;
mod decimal;
mod sigrok;
#[cfg(test)]
mod tests;
mod vcd;
mod write;

pub use self::decimal::hertz;
pub use self::write::{CaptureFormat, CaptureWriter};

/// Channels of which levels are told at once.
pub const SELECTED_MAX: usize = 64;

/// Channels that a file may have.
pub const CHANNELS_MAX: usize = 4_096;

/// What the selected channels show from a time on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaptureChange {
    /// Nanoseconds from [`Capture::origin_ns`].
    pub time_ns: u64,
    /// Bit k is 1 where the k-th selected channel is high.
    pub high: u64,
    /// Bit k is 1 where the level of the k-th selected channel is known.
    pub known: u64,
}

/// Where a capture ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaptureEnd {
    /// The last time that it tells of.
    pub time_ns: u64,
    /// The line in which the file breaks off; what stands there was left out.
    pub cut_in_line: Option<u64>,
}

/// Why a capture was refused, and where.
#[derive(Debug, thiserror::Error)]
#[error("{file}{place}: {problem}")]
pub struct CaptureError {
    /// The file's name, as the caller gave it.
    pub file: String,
    /// Where in it.
    pub place: CapturePlace,
    /// What is wrong there.
    pub problem: CaptureProblem,
}

/// A place in a capture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CapturePlace {
    /// The file as a whole.
    File,
    /// A line, from 1.
    Line(u64),
    /// A column of a line.
    Column(u64, String),
    /// A part of an archive.
    Part(String),
}

impl fmt::Display for CapturePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, " line {line}"),
            Self::Column(line, column) => write!(f, " line {line}, column {}", column.escape_debug()),
            Self::Part(part) => write!(f, ", in it {}", part.escape_debug()),
        }
    }
}

/// What is wrong with a capture.
#[derive(Debug, thiserror::Error)]
pub enum CaptureProblem {
    /// The source failed.
    #[error("cannot read: {0}")]
    Read(#[from] io::Error),
    /// Something that the file must have is missing, or something is there that it must not have.
    #[error("{0}")]
    Refused(String),
}

impl CaptureProblem {
    fn refused(problem: impl fmt::Display) -> Self {
        Self::Refused(problem.to_string())
    }
}

/// A place and what is wrong there, before the file has its name.
type Wrong = (CapturePlace, CaptureProblem);

fn wrong_line(line: u64, problem: impl fmt::Display) -> Wrong {
    (CapturePlace::Line(line), CaptureProblem::refused(problem))
}

enum Kind {
    Vcd(vcd::Head),
    Sigrok(sigrok::Head),
    Csv(csv::Head),
}

/// A capture whose head was read.
pub struct Capture<R> {
    file: String,
    source: R,
    kind: Kind,
    channels: Vec<String>,
}

/// Where the times of a capture come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureTimes {
    /// Every change stands there with its time.
    Stamped,
    /// They are samples; the file names their rate, in hertz.
    Sampled(u64),
    /// They are samples, at a rate in hertz that the file does not name.
    SampledAsGiven(u64),
}

/// So many bytes tell what a file is.
const HEAD: usize = 512;

impl<R: Read + Seek> Capture<R> {
    /// Reads the head of a capture. `samplerate` in hertz is that of a CSV file which does not tell it.
    ///
    /// # Errors
    /// Those of the source, and whatever is wrong with the head.
    pub fn new(file: &str, mut source: R, samplerate: Option<u64>) -> Result<Self, CaptureError> {
        let named = |(place, problem)| CaptureError { file: file.to_owned(), place, problem };
        let (kind, channels) = read_head(&mut source, samplerate).map_err(named)?;
        Ok(Self { file: file.to_owned(), source, kind, channels })
    }

    /// The names of its channels. Of a VCD those of its single bits, with their scopes.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Nanoseconds at which times of changes begin: 0, or the first time of a file that begins before 0.
    pub const fn origin_ns(&self) -> i64 {
        match &self.kind {
            Kind::Csv(head) => head.origin_ns(),
            Kind::Vcd(_) | Kind::Sigrok(_) => 0,
        }
    }

    /// Where its times come from.
    pub const fn times(&self) -> CaptureTimes {
        match &self.kind {
            Kind::Csv(head) => head.times(),
            Kind::Sigrok(head) => CaptureTimes::Sampled(head.hertz()),
            Kind::Vcd(_) => CaptureTimes::Stamped,
        }
    }

    /// Nanoseconds between two samples, rounded down; `None` if changes are told with their time.
    pub const fn sample_ns(&self) -> Option<u64> {
        match &self.kind {
            Kind::Csv(head) => head.sample_ns(),
            Kind::Sigrok(head) => Some(head.sample_ns()),
            Kind::Vcd(_) => None,
        }
    }

    /// The finest difference of two times that the file can tell.
    pub const fn resolution_ns(&self) -> Option<u64> {
        match &self.kind {
            Kind::Vcd(head) => Some(head.resolution_ns()),
            Kind::Csv(_) | Kind::Sigrok(_) => self.sample_ns(),
        }
    }

    /// Tells what the selected channels show at first and at each change, until `each` breaks it off; only the first
    /// [`SELECTED_MAX`] are looked at.
    ///
    /// # Errors
    /// Those of the source, and the first thing that is wrong in the file.
    pub fn changes(
        &mut self,
        selected: &[usize],
        each: impl FnMut(CaptureChange) -> ControlFlow<()>,
    ) -> Result<CaptureEnd, CaptureError> {
        let selected = selected.get(..SELECTED_MAX).unwrap_or(selected);
        let file = &self.file;
        let named = |(place, problem)| CaptureError { file: file.clone(), place, problem };
        self.source.seek(SeekFrom::Start(0)).map_err(in_file).map_err(named)?;
        let mut told = Told { each, last: None };
        let read = match &self.kind {
            Kind::Vcd(head) => vcd::changes(&mut self.source, head, selected, &mut told),
            Kind::Csv(head) => csv::changes(&mut self.source, head, selected, &mut told),
            Kind::Sigrok(head) => sigrok::changes(&mut self.source, head, selected, &mut told),
        };
        read.map_err(named)
    }
}

fn in_file(cause: io::Error) -> Wrong {
    (CapturePlace::File, cause.into())
}

fn read_head<R: Read + Seek>(source: &mut R, samplerate: Option<u64>) -> Result<(Kind, Vec<String>), Wrong> {
    let mut head = Vec::with_capacity(HEAD);
    source.by_ref().take(HEAD as u64).read_to_end(&mut head).map_err(in_file)?;
    source.seek(SeekFrom::Start(0)).map_err(in_file)?;
    let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&head).trim_ascii_start();
    let (kind, channels) = match text.first() {
        None => return Err((CapturePlace::File, CaptureProblem::refused("the file is empty"))),
        Some(b'P') if head.starts_with(b"PK") => {
            let (head, channels) = sigrok::head(source)?;
            (Kind::Sigrok(head), channels)
        }
        Some(b'$') => {
            let (head, channels) = vcd::head(source)?;
            (Kind::Vcd(head), channels)
        }
        Some(_) => {
            let (head, channels) = csv::head(source, samplerate)?;
            (Kind::Csv(head), channels)
        }
    };
    if channels.is_empty() {
        let problem = "no channel: there is no line of a single bit";
        return Err((CapturePlace::File, CaptureProblem::refused(problem)));
    }
    Ok((kind, channels))
}

/// Who is told of changes; what is as before is not told again.
struct Told<F> {
    each: F,
    last: Option<(u64, u64)>,
}

impl<F: FnMut(CaptureChange) -> ControlFlow<()>> Told<F> {
    #[inline]
    fn tell(&mut self, time_ns: u64, high: u64, known: u64) -> ControlFlow<()> {
        let high = high & known;
        if self.last == Some((high, known)) {
            return ControlFlow::Continue(());
        }
        self.last = Some((high, known));
        (self.each)(CaptureChange { time_ns, high, known })
    }
}
