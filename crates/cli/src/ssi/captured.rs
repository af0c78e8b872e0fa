//! A capture whose clock and data are known.

use std::fs::File;
use std::io::{self, Write};
use std::mem;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::mpsc::{self, SyncSender};
use std::thread;

use clap::Args;
use encoring_host::ssi_lines::{LinesFound, SSI_LINES_MAX, SsiLines};
use encoring_trace::capture::{Capture, CaptureChange, CaptureEnd, CaptureError, CaptureTimes};
use encoring_words::Instant;
use encoring_words::ssi_frame::Level;
use indicatif::ProgressBarIter;

use crate::interrupt::Interrupt;
use crate::output::reading::{self, Beside};
use crate::output::{Failure, bad_input, note};

/// Changes that are looked at to find the lines.
const LOOKED_AT: u64 = 1_000_000;

/// Changes that are handed on at once.
const BATCH: usize = 4096;

/// So many times as many may be read before they are taken.
const AHEAD: usize = 4;

/// Which capture, and what in it.
#[derive(Args, Debug, Clone)]
pub(crate) struct CaptureArguments {
    /// The capture: VCD, .sr of sigrok, or CSV of Saleae's Logic, PulseView or sigrok-cli
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Name of the channel of Clock+ [default: found by what the lines do]
    #[arg(long, value_name = "NAME", requires = "data")]
    clock: Option<String>,
    /// Name of the channel of Data+ [default: found by what the lines do]
    #[arg(long, value_name = "NAME", requires = "clock")]
    data: Option<String>,
    /// Sample rate of a CSV file that does not contain it, such as 1MHz
    #[arg(long, value_name = "RATE", value_parser = super::format::rate)]
    samplerate: Option<u64>,
}

/// Two lines of a capture.
pub(crate) struct Captured {
    capture: Capture<Source>,
    /// The channels of clock and data.
    lines: [usize; 2],
    interrupt: Interrupt,
}

/// The file, with a bar that shows how far it is read.
type Source = ProgressBarIter<File>;

/// What the two lines show from a time on; `None` where it is not known.
pub(crate) struct Levels {
    pub(crate) at: Instant,
    pub(crate) clock_and_data: Option<(Level, Level)>,
}

impl From<CaptureError> for Failure {
    fn from(error: CaptureError) -> Self {
        bad_input(error)
    }
}

impl CaptureArguments {
    /// Opens the capture and finds its lines; says which they are if nobody named them. From then on a signal ends the
    /// reading.
    pub(crate) fn open(&self, beside: Beside) -> Result<Captured, Failure> {
        let interrupt = Interrupt::new()?;
        interrupt.only_looks();
        let name = self.file.display().to_string();
        // Whatever is no ordinary file is told before anything waits for it.
        encoring_files::open(&self.file, 0).map_err(|cause| bad_input(format!("{name}: {cause}")))?;
        let file = File::open(&self.file).map_err(|cause| bad_input(format!("{name}: {cause}")))?;
        let source = reading::bar(&file, beside).wrap_read(file);
        let mut capture = Capture::new(&name, source, self.samplerate)?;
        self.tell_unused_rate(&name, capture.times());
        let lines = match (&self.clock, &self.data) {
            (Some(clock), Some(data)) => named(&capture, &name, clock, data)?,
            _ => found(&mut capture, &name, &interrupt)?,
        };
        Ok(Captured { capture, lines, interrupt })
    }
}

impl CaptureArguments {
    /// Says that a file knows its times better than `--samplerate`.
    fn tell_unused_rate(&self, name: &str, times: CaptureTimes) {
        let Some(given) = self.samplerate else { return };
        match times {
            CaptureTimes::Stamped => {
                note(&format!("note: {name} has a time for each change; --samplerate is not used"));
            }
            CaptureTimes::Sampled(own) if own != given => {
                note(&format!(
                    "note: {name} says itself that it was sampled at {own} Hz; --samplerate with {given} Hz is not used"
                ));
            }
            CaptureTimes::Sampled(_) | CaptureTimes::SampledAsGiven(_) => {}
        }
    }
}

/// Channels by their names.
fn named(capture: &Capture<Source>, file: &str, clock: &str, data: &str) -> Result<[usize; 2], Failure> {
    let (clock, data) = (channel(capture, file, "--clock", clock)?, channel(capture, file, "--data", data)?);
    if clock == data {
        return Err(bad_input("--clock and --data name the same channel"));
    }
    Ok([clock, data])
}

/// A channel by its whole name, or by the part behind its scopes if only one ends in that.
fn channel(capture: &Capture<Source>, file: &str, option: &str, name: &str) -> Result<usize, Failure> {
    let channels = capture.channels();
    if let Some(found) = channels.iter().position(|channel| channel == name) {
        return Ok(found);
    }
    let short = |channel: &&String| channel.rsplit('.').next() == Some(name);
    let mut found = channels.iter().enumerate().filter(|(_, channel)| short(channel));
    match (found.next(), found.next()) {
        (Some((number, _)), None) => Ok(number),
        (Some(_), Some(_)) => {
            Err(bad_input(format!("{option} {name:?}: several channels of {file} end in that")))
        }
        (None, _) => Err(bad_input(format!("{option} {name:?}: {file} has {}", listed(channels)))),
    }
}

/// The names of channels, some of them if there are many.
fn listed(channels: &[String]) -> String {
    let names: Vec<String> = channels.iter().take(20).map(|name| format!("{name:?}")).collect();
    let more = if channels.len() > names.len() { ", ..." } else { "" };
    format!("the channels {}{more}", names.join(", "))
}

/// Finds the lines by what they do.
fn found(capture: &mut Capture<Source>, file: &str, interrupt: &Interrupt) -> Result<[usize; 2], Failure> {
    let channels = capture.channels().to_vec();
    let ask = |why: &str| {
        bad_input(format!(
            "{file}: {why}; name them with --clock NAME --data NAME: it has {}",
            listed(&channels)
        ))
    };
    if channels.len() > SSI_LINES_MAX {
        return Err(ask(&format!("{} channels, too many to find clock and data among", channels.len())));
    }
    let all: Vec<usize> = (0..channels.len()).collect();
    let mut lines = SsiLines::new(channels.len());
    let mut changes = 0;
    capture.changes(&all, |change| {
        // What is not known counts as High, which is rest.
        lines.levels(Instant(change.time_ns), change.high | !change.known);
        changes += 1;
        let is_enough = changes >= LOOKED_AT || interrupt.is_interrupted();
        if is_enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if interrupt.is_interrupted() {
        return Err(Failure::NoAnswer("interrupted while clock and data were looked for".to_owned()));
    }
    let called = |line: usize| channels.get(line).map_or("", String::as_str);
    match lines.found() {
        LinesFound::Pair { clock, data } => {
            note(&format!(
                "note: clock is {:?}, data is {:?}: found by what they do",
                called(clock),
                called(data)
            ));
            Ok([clock, data])
        }
        LinesFound::StuckData { clock, data } => {
            note(&format!(
                "note: clock is {:?}; {:?} must be data, and never changes",
                called(clock),
                called(data)
            ));
            Ok([clock, data])
        }
        LinesFound::NoClock => Err(ask(
            "no line is clocked as an SSI: trains of 8 pulses or more, each Low for at most 20 us, and High in between. \
             Correct the time scale or the sample rate if it is wrong",
        )),
        LinesFound::InvertedClock { clock } => Err(ask(&format!(
            "{:?} has pulses as a clock but rests Low: Clock- was captured, or the lines are inverted",
            called(clock)
        ))),
        LinesFound::Several => Err(ask("several lines may be clock and data")),
        LinesFound::NoData { clock } => {
            Err(ask(&format!("{:?} is clocked as an SSI, and no line follows it as data do", called(clock))))
        }
    }
}

impl Captured {
    /// Tells both lines at every change, until a signal comes. The file is read beside that.
    pub(crate) fn levels(
        &mut self,
        mut each: impl FnMut(Levels) -> ControlFlow<()>,
    ) -> Result<CaptureEnd, CaptureError> {
        thread::scope(|scope| {
            let (hand_on, batches) = mpsc::sync_channel(AHEAD);
            let reading = scope.spawn(move || self.read(hand_on));
            let level = |bits: u64, bit: u32| Level::from_bit((bits >> bit) as u32);
            let _ = batches.iter().flatten().try_for_each(|CaptureChange { time_ns, high, known }| {
                let known = (known & 0b11 == 0b11).then(|| (level(high, 0), level(high, 1)));
                each(Levels { at: Instant(time_ns), clock_and_data: known })
            });
            drop(batches);
            reading.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    }

    /// Reads the changes of both lines, as long as somebody takes them.
    #[expect(clippy::needless_pass_by_value, reason = "its end, with the reading, ends the channel")]
    fn read(&mut self, hand_on: SyncSender<Vec<CaptureChange>>) -> Result<CaptureEnd, CaptureError> {
        let Self { capture, lines, interrupt } = self;
        let mut batch = Vec::with_capacity(BATCH);
        let end = capture.changes(lines, |change| {
            batch.push(change);
            let is_taken = batch.len() < BATCH
                || hand_on.send(mem::replace(&mut batch, Vec::with_capacity(BATCH))).is_ok();
            if is_taken && !interrupt.is_interrupted() {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        });
        // What stands before an error in the file counts.
        let _ = hand_on.send(batch);
        end
    }

    /// Whether a signal has ended the reading.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.is_interrupted()
    }

    /// A time as the file has it.
    pub(crate) fn time_ns(&self, at: Instant) -> i128 {
        i128::from(at.as_nanos()) + i128::from(self.capture.origin_ns())
    }

    /// The finest difference of two times that the file can tell.
    pub(crate) fn resolution_ns(&self) -> Option<u64> {
        self.capture.resolution_ns()
    }

    /// Nanoseconds at which its times begin.
    pub(crate) fn origin_ns(&self) -> i64 {
        self.capture.origin_ns()
    }
}

/// Text that is written a page at a time, so that a capture of any length is printed in bounded memory.
pub(crate) struct Page<W> {
    text: Vec<u8>,
    sink: W,
}

/// Beyond so many bytes a page is written.
const PAGE: usize = 64 * 1024;

impl<W: Write> Page<W> {
    pub(crate) fn new(sink: W) -> Self {
        Self { text: Vec::with_capacity(PAGE), sink }
    }

    /// Writes a line, sooner or later.
    pub(crate) fn line(&mut self, line: impl std::fmt::Display) -> io::Result<()> {
        writeln!(self.text, "{line}")?;
        if self.text.len() >= PAGE { self.flush() } else { Ok(()) }
    }

    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.sink.write_all(&self.text)?;
        self.text.clear();
        self.sink.flush()
    }
}
