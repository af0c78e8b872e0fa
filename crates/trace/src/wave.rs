//! Waveforms: signals over time as VCD or FST, as GTKWave and its like open them.
//!
//! Both formats hold the same signals and the same changes. VCD is text that almost everything reads, and what has been
//! written of it can be read while it grows; FST is several times smaller, and can be read once it is finished.
//!
//! Times are whole [units](UNIT_NS). Signals stand in scopes below one top; a name has visible ASCII characters only.
//!
//! ```
//! use encoring_trace::wave::{Format, Signals, Value, WaveWriter};
//!
//! let mut signals = Signals::new("bench");
//! signals.scope("encoder");
//! let service = signals.add("service", 1, Value::Bits(0));
//! let mut writer = WaveWriter::new(Format::Vcd, std::io::Cursor::new(Vec::new()), "a test", &signals)?;
//! writer.change(20, service, Value::Bits(1))?;
//! let file = writer.finish(40)?.into_inner();
//! assert!(String::from_utf8(file)?.ends_with("$end\n#20\n1!\n#40\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::io::{self, Seek, Write};
use std::path::Path;

mod fst;
#[cfg(test)]
mod tests;
mod vcd;

/// Nanoseconds of a unit of time.
pub const UNIT_NS: u64 = 100;

/// The widest signal.
const BITS_MAX: u32 = 32;

/// How a waveform is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Value change dump, IEEE 1364: text.
    Vcd,
    /// The same with the signals of one bit only, all in one scope and each with a name of its own: programs for logic
    /// analysers know no words, and tell signals apart by their names without scopes.
    Levels,
    /// GTKWave's fast signal trace: packed.
    Fst,
}

impl Format {
    /// What the ending of a file's name asks for, without words where a program for logic analysers would not read them;
    /// `None` if it names no waveform.
    #[must_use]
    pub fn of(file: &Path) -> Option<Self> {
        let ending = file.extension()?;
        if ending.eq_ignore_ascii_case("vcd") {
            Some(Self::Levels)
        } else if ending.eq_ignore_ascii_case("fst") {
            Some(Self::Fst)
        } else {
            None
        }
    }
}

impl Format {
    /// The same with signals of several bits.
    #[must_use]
    pub const fn with_words(self) -> Self {
        match self {
            Self::Vcd | Self::Levels => Self::Vcd,
            Self::Fst => Self::Fst,
        }
    }
}

/// Where a waveform can be written to: FST goes back to its header when it is finished.
pub trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// What a signal shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// Its bits, as many of the lowest ones as the signal has.
    Bits(u32),
    /// Nothing that is known: every bit is x.
    Unknown,
}

impl From<bool> for Value {
    fn from(bit: bool) -> Self {
        Self::Bits(u32::from(bit))
    }
}

impl Value {
    /// The characters of the bits of a signal, the highest first.
    fn characters(self, width: u32) -> impl Iterator<Item = u8> {
        (0..width).rev().map(move |k| match self {
            Self::Bits(bits) => b'0' + u8::from(bits >> k & 1 != 0),
            Self::Unknown => b'x',
        })
    }

    fn cut(self, width: u32) -> Self {
        match self {
            Self::Bits(bits) => Self::Bits(bits & u32::MAX >> (BITS_MAX - width)),
            Self::Unknown => Self::Unknown,
        }
    }
}

/// A signal of a waveform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Id(u32);

#[derive(Clone, Debug)]
struct Signal {
    name: String,
    width: u32,
    first: Value,
}

impl Signal {
    /// The bits that a name with several of them is followed by.
    fn range(&self) -> String {
        if self.width == 1 { String::new() } else { format!(" [{}:0]", self.width - 1) }
    }
}

/// The signals of a waveform, in order, and what they show at first.
#[derive(Clone, Debug)]
pub struct Signals {
    top: String,
    notes: Vec<String>,
    scopes: Vec<(String, Vec<Signal>)>,
    count: u32,
}

impl Signals {
    /// None yet, below this name.
    #[must_use]
    pub fn new(top: &str) -> Self {
        Self { top: top.to_owned(), notes: Vec::new(), scopes: Vec::new(), count: 0 }
    }

    /// Something that a reader of the file should know; FST has no place for it.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// What is added from now on stands in a scope with this name.
    pub fn scope(&mut self, name: impl Into<String>) {
        self.scopes.push((name.into(), Vec::new()));
    }

    /// Adds a signal of 1 to 32 bits.
    pub fn add(&mut self, name: impl Into<String>, width: u32, first: Value) -> Id {
        if self.scopes.is_empty() {
            self.scope("signals");
        }
        let width = width.clamp(1, BITS_MAX);
        if let Some((_, signals)) = self.scopes.last_mut() {
            signals.push(Signal { name: name.into(), width, first: first.cut(width) });
        }
        let id = Id(self.count);
        self.count += 1;
        id
    }

    fn all(&self) -> impl Iterator<Item = &Signal> {
        self.scopes.iter().flat_map(|(_, signals)| signals)
    }

    /// What a reader would take for something else is not written.
    fn check(&self) -> io::Result<()> {
        let scopes = self.scopes.iter().map(|(name, _)| name);
        let names = scopes.chain([&self.top]).chain(self.all().map(|signal| &signal.name));
        for name in names {
            if name.is_empty() || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
                return Err(refusal(format!("{name:?} is no name of a signal")));
            }
        }
        match self.notes.iter().find(|note| note.contains("$end")) {
            Some(note) => Err(refusal(format!("{note:?} holds $end"))),
            None => Ok(()),
        }
    }
}

fn refusal(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

/// Writes a waveform, change by change. It holds a few megabytes at most, however long the file grows.
pub struct WaveWriter<W: Sink> {
    body: Body<W>,
    /// Of each signal, how wide it is and what it shows.
    signals: Vec<(u32, Value)>,
    now: Now,
}

/// How far a waveform is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Now {
    /// At time 0, of which nothing has been written: what the signals show at first may still change.
    First,
    /// At this time.
    At(u64),
}

enum Body<W: Sink> {
    Vcd(vcd::Body<W>),
    Fst(Box<fst::Body<W>>),
}

impl<W: Sink> WaveWriter<W> {
    /// Begins a waveform at time 0. `writer` is who writes it.
    ///
    /// # Errors
    /// Those of the sink, and [`io::ErrorKind::InvalidInput`] for a name that could not be read back.
    pub fn new(format: Format, sink: W, writer: &str, signals: &Signals) -> io::Result<Self> {
        signals.check()?;
        let body = match format {
            Format::Vcd => Body::Vcd(vcd::Body::new(sink, writer, signals)?),
            Format::Levels => Body::Vcd(vcd::Body::levels(sink, writer, signals)?),
            Format::Fst => Body::Fst(Box::new(fst::Body::new(sink, writer, signals)?)),
        };
        let signals = signals.all().map(|signal| (signal.width, signal.first)).collect();
        Ok(Self { body, signals, now: Now::First })
    }

    /// From `at` on a signal shows `value`. What it shows already is not written again, and at time 0 only the last value
    /// is.
    ///
    /// # Errors
    /// Those of the sink, and [`io::ErrorKind::InvalidInput`] for a time before that of the change before, or a signal
    /// of another waveform.
    pub fn change(&mut self, at: u64, id: Id, value: Value) -> io::Result<()> {
        let Some((width, shown)) = self.signals.get_mut(id.0 as usize) else {
            return Err(refusal(format!("there is no signal {}", id.0)));
        };
        let (width, value) = (*width, value.cut(*width));
        match self.now {
            Now::At(now) if at < now => {
                return Err(refusal(format!("{at} is before {now}, the time of the previous change")));
            }
            Now::First if at == 0 => {
                *shown = value;
                return Ok(());
            }
            _ if *shown == value => return Ok(()),
            _ => {}
        }
        self.advance(at)?;
        if let Some((_, shown)) = self.signals.get_mut(id.0 as usize) {
            *shown = value;
        }
        match &mut self.body {
            Body::Vcd(body) => body.change(id, width, value),
            Body::Fst(body) => body.change(id, width, value),
        }
    }

    fn advance(&mut self, at: u64) -> io::Result<()> {
        if self.now == Now::First {
            match &mut self.body {
                Body::Vcd(body) => body.first(&self.signals)?,
                Body::Fst(body) => body.first(&self.signals)?,
            }
            self.now = Now::At(0);
        }
        if Now::At(at) == self.now {
            return Ok(());
        }
        self.now = Now::At(at);
        match &mut self.body {
            Body::Vcd(body) => body.advance(at),
            Body::Fst(body) => body.advance(at),
        }
    }

    /// Ends the waveform at `at`, or at its last change if that is later.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(mut self, at: u64) -> io::Result<W> {
        let last = if let Now::At(now) = self.now { now } else { 0 };
        self.advance(at.max(last))?;
        match self.body {
            Body::Vcd(body) => body.finish(),
            Body::Fst(body) => body.finish(),
        }
    }
}
