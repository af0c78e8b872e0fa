//! Captures as files.

use std::io::{self, Seek, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::decimal::SampleRate;

/// How a capture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureFormat {
    /// Value change dump.
    Vcd,
    /// sigrok's session.
    Sigrok,
    /// A table with a row for each change, as Saleae's Logic exports it.
    Csv,
}

impl CaptureFormat {
    /// What the ending of a file's name asks for; `None` if it names no capture.
    #[must_use]
    pub fn of(file: &Path) -> Option<Self> {
        let ending = file.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "vcd" => Some(Self::Vcd),
            "sr" => Some(Self::Sigrok),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }

    /// Whether it can tell changes with their time; otherwise it holds samples only.
    #[must_use]
    pub const fn holds_changes(self) -> bool {
        !matches!(self, Self::Sigrok)
    }
}

/// Samples in one part of a session, as sigrok cuts them.
const PART: u64 = 4 << 20;

/// Writes a capture of at most eight channels, change by change, in bounded memory.
pub struct CaptureWriter<W: Write + Seek> {
    body: Body<W>,
    /// With a sample rate, changes are seen with the first sample at or after them.
    samplerate: Option<u64>,
    channels: usize,
    shown: u8,
    /// The first levels were written.
    begun: bool,
    time_ns: u64,
}

enum Body<W: Write + Seek> {
    Vcd(W),
    Csv(W),
    Sigrok { archive: Box<ZipWriter<W>>, written: u64, part: u64 },
}

impl<W: Write + Seek> CaptureWriter<W> {
    /// Begins a capture at time 0 with what its channels show then: bit k is channel k. Names have visible ASCII
    /// characters only. `samplerate` in hertz; a session needs one.
    ///
    /// # Errors
    /// Those of the sink, and [`io::ErrorKind::InvalidInput`] for more than eight channels, a name that could not be
    /// read back, or a session without a sample rate.
    pub fn new(
        format: CaptureFormat,
        mut sink: W,
        channels: &[&str],
        first: u8,
        samplerate: Option<u64>,
    ) -> io::Result<Self> {
        let is_name = |name: &&str| {
            !name.is_empty()
                && name.bytes().all(|sign| sign.is_ascii_graphic() && !matches!(sign, b',' | b'"' | b';'))
        };
        if channels.len() > 8 || !channels.iter().all(is_name) {
            return Err(refusal("these are no names of channels"));
        }
        let body = match format {
            CaptureFormat::Vcd => {
                begin_vcd(&mut sink, channels)?;
                Body::Vcd(sink)
            }
            CaptureFormat::Csv => {
                writeln!(sink, "Time [s],{}", channels.join(","))?;
                Body::Csv(sink)
            }
            CaptureFormat::Sigrok => {
                let samplerate = samplerate
                    .ok_or_else(|| refusal("a session has samples, and no sample rate was given"))?;
                let archive = Box::new(begin_session(sink, channels, samplerate)?);
                Body::Sigrok { archive, written: 0, part: 0 }
            }
        };
        let samplerate = samplerate.map(|rate| rate.max(1));
        Ok(Self { body, samplerate, channels: channels.len(), shown: first, begun: false, time_ns: 0 })
    }

    /// From `time_ns` on the channels show this. Of several changes within one sample the last one is seen.
    ///
    /// # Errors
    /// Those of the sink, and [`io::ErrorKind::InvalidInput`] for a time before that of the change before.
    pub fn change(&mut self, time_ns: u64, shown: u8) -> io::Result<()> {
        let time_ns = self.sampled(time_ns)?;
        if time_ns < self.time_ns {
            return Err(refusal("the time is before that of the change before"));
        }
        if time_ns > self.time_ns {
            self.write_shown(time_ns)?;
        }
        self.shown = shown;
        Ok(())
    }

    /// Ends the capture at `time_ns`, or at its last change if that is later.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(mut self, time_ns: u64) -> io::Result<W> {
        let end = self.sampled(time_ns)?.max(self.time_ns);
        self.write_shown(end)?;
        match &mut self.body {
            Body::Vcd(sink) => writeln!(sink, "#{end}")?,
            // The last row tells how long the capture is.
            Body::Csv(_) => self.csv_row(end)?,
            Body::Sigrok { .. } => {
                let last = self.sample_at_or_after(end)? + 1;
                self.write_samples(last)?;
            }
        }
        match self.body {
            Body::Vcd(mut sink) | Body::Csv(mut sink) => sink.flush().map(|()| sink),
            Body::Sigrok { archive, .. } => Ok(archive.finish()?),
        }
    }

    /// The time at which a change at `time_ns` is seen.
    fn sampled(&self, time_ns: u64) -> io::Result<u64> {
        let Some(rate) = self.samplerate else { return Ok(time_ns) };
        let sample = self.sample_at_or_after(time_ns)?;
        SampleRate::new(rate).time_ns(sample).ok_or_else(|| refusal("the time is too far away"))
    }

    fn sample_at_or_after(&self, time_ns: u64) -> io::Result<u64> {
        let rate = u128::from(self.samplerate.unwrap_or(1_000_000_000));
        // Times of samples are rounded down, so a sample may be at the very time.
        let sample = (u128::from(time_ns) * rate).div_ceil(1_000_000_000);
        let before = sample.saturating_sub(1);
        let is_there = before * 1_000_000_000 / rate >= u128::from(time_ns);
        let sample = if is_there { before } else { sample };
        u64::try_from(sample).map_err(|_| refusal("the time is too far away"))
    }

    /// Writes what is shown from the last time on; at `until` something else may come.
    fn write_shown(&mut self, until: u64) -> io::Result<()> {
        match &mut self.body {
            Body::Vcd(sink) => {
                write!(sink, "#{}", self.time_ns)?;
                for channel in 0..self.channels {
                    let code = char::from(b'!' + channel as u8);
                    write!(sink, " {}{code}", self.shown >> channel & 1)?;
                }
                writeln!(sink)?;
            }
            Body::Csv(_) => self.csv_row(self.time_ns)?,
            Body::Sigrok { .. } => {
                let next = self.sample_at_or_after(until)?;
                self.write_samples(next)?;
            }
        }
        self.begun = true;
        self.time_ns = until;
        Ok(())
    }

    fn csv_row(&mut self, time_ns: u64) -> io::Result<()> {
        let Body::Csv(sink) = &mut self.body else { return Ok(()) };
        write!(sink, "{}.{:09}", time_ns / 1_000_000_000, time_ns % 1_000_000_000)?;
        for channel in 0..self.channels {
            write!(sink, ",{}", self.shown >> channel & 1)?;
        }
        writeln!(sink)
    }

    /// Samples of what is shown, up to but without sample `end`.
    fn write_samples(&mut self, end: u64) -> io::Result<()> {
        let Body::Sigrok { archive, written, part } = &mut self.body else { return Ok(()) };
        let same = [self.shown; 4_096];
        while *written < end {
            if *written % PART == 0 {
                *part += 1;
                archive.start_file(format!("logic-1-{part}"), options())?;
            }
            let room = PART - *written % PART;
            let count = (end - *written).min(room).min(same.len() as u64);
            archive.write_all(same.get(..count as usize).unwrap_or(&same))?;
            *written += count;
        }
        Ok(())
    }
}

fn refusal(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, problem)
}

fn begin_vcd(sink: &mut impl Write, channels: &[&str]) -> io::Result<()> {
    writeln!(sink, "$timescale 1 ns $end\n$scope module capture $end")?;
    for (name, code) in channels.iter().zip(b'!'..) {
        writeln!(sink, "$var wire 1 {} {name} $end", char::from(code))?;
    }
    writeln!(sink, "$upscope $end\n$enddefinitions $end")
}

fn options() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Deflated)
}

fn begin_session<W: Write + Seek>(sink: W, channels: &[&str], samplerate: u64) -> io::Result<ZipWriter<W>> {
    let mut archive = ZipWriter::new(sink);
    archive.start_file("version", options())?;
    archive.write_all(b"2")?;
    archive.start_file("metadata", options())?;
    let count = channels.len();
    write!(
        archive,
        "[device 1]\ncapturefile=logic-1\ntotal probes={count}\nsamplerate={samplerate} Hz\ntotal analog=0\n"
    )?;
    for (name, number) in channels.iter().zip(1..) {
        writeln!(archive, "probe{number}={name}")?;
    }
    writeln!(archive, "unitsize=1")?;
    Ok(archive)
}
