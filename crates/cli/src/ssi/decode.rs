//! `encoring ssi decode`: what a capture holds.

mod summary;

use std::fmt;
use std::io;
use std::ops::ControlFlow;

use clap::{Args, ValueEnum};
use encoring_host::ssi_receiver::{FieldBits, SsiFault, SsiReceiver, SsiTransfer, TakenAt};
use encoring_words::Instant;
use serde::{Serialize, Serializer};

use super::captured::{CaptureArguments, Captured, Levels, Page};
use super::format::FormatArguments;
use crate::output::reading::Beside;
use crate::output::{Answer, Failure, note};
use summary::Summary;

/// Decode a capture of clock and data
///
/// It prints each transfer, then what the clock did and what is wrong. `encoring ssi guess FILE` finds the format, if you do
/// not know it.
#[derive(Args, Debug)]
#[command(after_help = "\
Faults:
  clocks           too few clocks, or other than --clocks
  parity           the parity bit of AK-40 is wrong
  repetition       the repeated data differ
  trailing_high    the data are High after the field
  stuck_low, stuck_high
  clock_limit      slower than 50 kHz (the word breaks at t_M), or faster than 1.1 MHz
  cut              the capture begins or ends within the transfer: no fault of the line

Exit codes:
  0  no fault, or none but cut
  1  a fault other than cut
  2  wrong input, or clock and data cannot be told apart
  3  no complete transfer in the capture

Examples:
  encoring ssi decode capture.sr --bits 25 --code gray
  encoring ssi decode logic.csv --clock 'Channel 0' --data 'Channel 1' --edge rising
  encoring ssi decode capture.vcd --bits 31 --format csv > words.csv")]
pub(crate) struct Arguments {
    #[command(flatten)]
    capture: CaptureArguments,
    #[command(flatten)]
    format: FormatArguments,
    /// Clock edge at which the receiver takes the data
    #[arg(long, value_name = "EDGE", default_value = "falling")]
    edge: Edge,
    /// Number of clocks of every transfer [default: any number that brings the field]
    #[arg(long, value_name = "K")]
    clocks: Option<u32>,
    /// Print text for people; or one line for each transfer, as JSON (docs/json.md) or CSV
    #[arg(long = "format", default_value = "text")]
    output: DecodeFormat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Edge {
    /// The level just before the rising edge.
    Rising,
    /// The level just before the falling edge.
    Falling,
}

impl Edge {
    pub(crate) const fn taken_at(self) -> TakenAt {
        match self {
            Self::Rising => TakenAt::Rising,
            Self::Falling => TakenAt::Falling,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DecodeFormat {
    Text,
    Json,
    Csv,
}

/// A transfer, for programs.
#[derive(Serialize)]
struct TransferView {
    time_ns: i128,
    clocks: u32,
    #[serde(serialize_with = "as_text")]
    field: FieldBits,
    position: Option<u32>,
    fault: Option<&'static str>,
}

fn as_text<S: Serializer>(field: &FieldBits, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(field)
}

impl TransferView {
    fn new(time_ns: i128, transfer: &SsiTransfer) -> Self {
        Self {
            time_ns,
            clocks: transfer.clocks,
            field: transfer.bits(),
            position: transfer.position(),
            fault: transfer.fault.map(SsiFault::name),
        }
    }
}

/// The row of a CSV file.
impl fmt::Display for TransferView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { time_ns, clocks, field, position, fault } = self;
        write!(f, "{time_ns},{clocks},{field},")?;
        if let Some(position) = position {
            write!(f, "{position}")?;
        }
        write!(f, ",{}", fault.unwrap_or_default())
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    if let Some(remark) = arguments.format.without_effect() {
        note(&format!("note: {remark}"));
    }
    let beside = if arguments.output == DecodeFormat::Text { Beside::Nothing } else { Beside::Rows };
    let mut captured = arguments.capture.open(beside)?;
    let format = arguments.format.format();
    let mut summary = Summary::new(format, arguments.edge.taken_at());
    let mut page = Page::new(io::stdout().lock());
    if arguments.output == DecodeFormat::Csv {
        page.line("time_ns,clocks,field,position,fault")?;
    }
    let (mut printed, origin) = (Ok(()), i128::from(captured.origin_ns()));
    let mut each = |transfer: &SsiTransfer, summary: &mut Summary| {
        let time_ns = i128::from(transfer.began.as_nanos()) + origin;
        let view = || TransferView::new(time_ns, transfer);
        printed = match arguments.output {
            DecodeFormat::Json => {
                serde_json::to_string(&view()).map_err(Failure::from).and_then(|line| Ok(page.line(line)?))
            }
            DecodeFormat::Csv => page.line(view()).map_err(Failure::from),
            DecodeFormat::Text => Ok(()),
        };
        summary.transfer(time_ns, transfer);
        if printed.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let receiver = SsiReceiver::new(format, arguments.edge.taken_at());
    let receiver = arguments.clocks.map_or(receiver, |clocks| receiver.expecting(clocks));
    let received = receive(&mut captured, receiver, &mut summary, &mut each);
    printed?;
    // What came before an error in the file is printed.
    page.flush()?;
    received?;
    if arguments.output == DecodeFormat::Text {
        let text = summary.to_string();
        text.lines().try_for_each(|line| page.line(line))?;
        page.flush()?;
    }
    if captured.is_interrupted() {
        note("note: interrupted: this is what stands in the part that was read");
        return Ok(Answer::Unknown);
    }
    Ok(summary.answer())
}

/// Receives all transfers of a capture.
fn receive(
    captured: &mut Captured,
    mut receiver: SsiReceiver,
    summary: &mut Summary,
    each: &mut impl FnMut(&SsiTransfer, &mut Summary) -> ControlFlow<()>,
) -> Result<(), Failure> {
    let end = captured.levels(|Levels { at, clock_and_data }| {
        let ended = match clock_and_data {
            Some((clock, data)) => {
                let ended = receiver.levels(at, clock, data);
                if let Some(ended) = &ended {
                    summary.timings.transfer(ended);
                }
                summary.timings.levels(at, clock, data);
                ended
            }
            None => receiver.end(at),
        };
        ended.map_or(ControlFlow::Continue(()), |transfer| each(&transfer, summary))
    })?;
    // A transfer that the signal came into is not cut in the file.
    let last = if captured.is_interrupted() { None } else { receiver.end(Instant(end.time_ns)) };
    if let Some(last) = last {
        summary.timings.transfer(&last);
        let _ = each(&last, summary);
    }
    summary.end(captured.time_ns(Instant(end.time_ns)), captured.resolution_ns());
    if let Some(line) = end.cut_in_line {
        note(&format!("note: the file breaks off in line {line}: what stands there was left out"));
    }
    Ok(())
}
