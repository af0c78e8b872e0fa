//! `encoring ssi capture`: a simulated encoder, seen by a logic analyser.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use clap::Args;
use encoring_files::Existing;
use encoring_sim::Scenario;
use encoring_sim::ssi::{PlacedReader, SsiSettings};
use encoring_sim::ssi_bench::{BenchCapture, BenchError, capture};
use encoring_trace::capture::{CaptureFormat, CaptureWriter};
use encoring_words::Duration;
use encoring_words::ssi_frame::Level;

use super::format::{FormatArguments, rate};
use crate::arguments::fault::{self, Faults};
use crate::arguments::{span, whole};
use crate::bus;
use crate::interrupt::Interrupt;
use crate::output::new_file::{NotWritten, check_new_file, write_new_file};
use crate::output::progress::{Progress, RING_TIME};
use crate::output::{Answer, Failure, bad_input, note};

/// Clock rate, and time between transfers, of a reader that nobody described.
const HZ_DEFAULT: u32 = 500_000;
const EVERY_DEFAULT: Duration = Duration::from_millis(1);
/// Changes between two looks at the progress.
const SHOWN_EVERY: u64 = 10_000;

/// Samples a second of a session, which needs a rate.
const SAMPLERATE_DEFAULT: u64 = 20_000_000;

/// Make a capture of a simulated CE-65-M
///
/// With --bits, --code or --repetition it programs the encoder first. Without --ssi the reader is that of the scenario. If
/// there is none, it is one of 500 kHz, every 1 ms, with one clock more than the field has bits.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  written
  1  the encoder did not take the format
  2  wrong usage
  3  the file could not be written

Examples:
  encoring ssi capture --out capture.sr
  encoring ssi capture ring.toml --out capture.vcd --bits 25 --code gray --for 100ms
  encoring ssi capture --out late.csv --ssi 2=1000,25,1ms --skew 650
  encoring ssi capture --out short.sr --clocks 23 --samplerate 10MHz --jitter 40 --noise 1000")]
pub(crate) struct Arguments {
    /// Scenario file [default: the built-in ring]
    scenario: Option<PathBuf>,
    /// The file to write: .vcd, .sr (sigrok) or .csv (as from the Logic software of Saleae)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The reader, written as for `encoring sim`, such as 2=500,25,10ms
    #[arg(long, value_name = "POSITION=KHZ,CLOCKS,EVERY")]
    ssi: Option<PlacedReader>,
    /// Number of clocks of each transfer, right or wrong [default: those of the reader]
    #[arg(long, value_name = "K")]
    clocks: Option<u32>,
    #[command(flatten)]
    format: FormatArguments,
    /// Length of the capture in ring time
    #[arg(long = "for", value_name = "TIME", default_value = "100ms", value_parser = span)]
    lasting: Duration,
    /// Sample rate, such as 10MHz [default: 20MHz for .sr, else the exact time of every change]
    #[arg(long, value_name = "RATE", value_parser = rate)]
    samplerate: Option<u64>,
    /// Random delay of each edge, up to this number of ns, 0 to 100000
    #[arg(long, value_name = "NS", default_value_t = 0, value_parser = whole::<u32>(0..=100_000))]
    jitter: u32,
    /// Delay of the data in ns, 1 to 1000000
    #[arg(long, value_name = "NS", value_parser = whole::<u32>(1..=1_000_000))]
    skew: Option<u32>,
    /// Number of changes in a million that a spike of 100 ns follows, 0 to 1000000
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=1_000_000))]
    noise: u32,
    #[command(flatten)]
    faults: Faults,
    /// Replace the file if it exists
    #[arg(long)]
    overwrite: bool,
}

impl From<BenchError> for Failure {
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::TooMany(error) => bad_input(error),
            BenchError::NotProgrammed { .. } => Self::Refused(error.to_string()),
            BenchError::Sink(error) => Self::NoAnswer(error.to_string()),
        }
    }
}

impl From<BenchError> for NotWritten {
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::Sink(cause) => Self::File(cause),
            other => Self::Contents(other.into()),
        }
    }
}

impl Arguments {
    /// The scenario with its reader, and where that is.
    #[expect(clippy::disallowed_methods, reason = "a fault, which `sim::fault` reads")]
    fn scenario(&self) -> Result<(Scenario, usize), Failure> {
        let mut scenario = bus::scenario(self.scenario.as_deref())?;
        let reader = self.reader(&scenario)?;
        scenario.hang_reader(reader).map_err(|problem| bad_input(format!("--ssi {reader}: {problem}")))?;
        let PlacedReader { position, .. } = reader;
        if let (Some(device), Some(firmware)) = (scenario.devices.get_mut(position), self.format.firmware()) {
            device.unit.firmware = firmware;
        }
        fault::add(&self.faults, &mut scenario)?;
        if let Some(ns) = self.skew {
            let fault = format!("ssi_skew={ns}:{position}").parse().map_err(bad_input)?;
            scenario.add(&fault).map_err(|problem| bad_input(format!("--skew {ns}: {problem}")))?;
        }
        Ok((scenario, position))
    }

    fn reader(&self, scenario: &Scenario) -> Result<PlacedReader, Failure> {
        let of_scenario = || {
            let places = scenario.devices.iter().enumerate();
            places
                .filter_map(|(position, device)| {
                    device.ssi.map(|settings| PlacedReader { position, settings })
                })
                .next()
        };
        let reader = match self.ssi.or_else(of_scenario) {
            Some(reader) => reader,
            None => {
                let place = scenario.devices.iter().position(|device| device.unit.model().has_ssi_output());
                let position = place
                    .ok_or_else(|| bad_input("no encoder of the scenario has an SSI; a ce-65-m has one"))?;
                let clocks = u32::from(self.format.format().bits()) + 1;
                PlacedReader { position, settings: settings(HZ_DEFAULT, clocks, EVERY_DEFAULT, None)? }
            }
        };
        let clocks = self.clocks.unwrap_or(reader.settings.clocks());
        let old = reader.settings;
        Ok(PlacedReader { settings: settings(old.hz(), clocks, old.every(), Some(old))?, ..reader })
    }
}

fn settings(hz: u32, clocks: u32, every: Duration, old: Option<SsiSettings>) -> Result<SsiSettings, Failure> {
    let taken_at = old.map(SsiSettings::taken_at).unwrap_or_default();
    SsiSettings::new(hz, clocks, every, taken_at).map_err(|problem| bad_input(format!("--clocks: {problem}")))
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let file = &arguments.out;
    let format = CaptureFormat::of(file).ok_or_else(|| {
        bad_input(format!("--out {}: the name of a capture ends in .vcd, .sr or .csv", file.display()))
    })?;
    let existing = if arguments.overwrite { Existing::Replaced } else { Existing::Kept };
    check_new_file("--out", file, existing)?;
    if let Some(remark) = arguments.format.without_effect() {
        note(&format!("note: {remark}"));
    }
    let (scenario, position) = arguments.scenario()?;
    let samplerate = match (arguments.samplerate, format.holds_changes()) {
        (None, false) => Some(SAMPLERATE_DEFAULT),
        (rate, _) => rate,
    };
    let recording = BenchCapture {
        values: arguments.format.is_given().then(|| arguments.format.values()),
        lasting: arguments.lasting,
        jitter: Duration(arguments.jitter.into()),
        spikes_per_million: arguments.noise,
    };
    let interrupt = Interrupt::new()?;
    let progress = Progress::start(Some(arguments.lasting), RING_TIME)?;
    let (mut changes, mut end) = (0_u64, 0);
    write_new_file("--out", file, existing, |new| {
        let sink = BufWriter::new(new);
        let mut writer = CaptureWriter::new(format, sink, &["clock", "data"], 0b11, samplerate)?;
        end = capture(&scenario, position, &recording, |at, clock, data| {
            if interrupt.is_interrupted() {
                return Err(io::Error::new(io::ErrorKind::Interrupted, "interrupted"));
            }
            changes += 1;
            if changes.is_multiple_of(SHOWN_EVERY) {
                progress.show(Duration(at), String::new);
            }
            let high = |level| u8::from(level == Level::High);
            writer.change(at, high(clock) | high(data) << 1)
        })?;
        Ok(writer.finish(end)?.flush()?)
    })?;
    drop(progress);
    let line = format!("{changes} changes in {} of position {position}: {}", Duration(end), file.display());
    writeln!(io::stdout().lock(), "{line}")?;
    Ok(Answer::Yes)
}
