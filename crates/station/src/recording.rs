//! What is recorded of a ring while it runs, and the file that it goes to.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use encoring_files::{Existing, Growing, LineFile};
use encoring_sim::{Cycled, Shown, Waveform, World, device_line};
use encoring_trace::Writer;
use encoring_trace::wave::{Format, Sink};

/// Who is named in a waveform.
const WRITER: &str = concat!("encoring ", env!("CARGO_PKG_VERSION"));

/// What is recorded, and where it goes.
pub enum Recorder {
    /// Every exchange of every encoder, as rows.
    Exchanges(Writer<Box<dyn Write + Send>>),
    /// What the ring looks like over time. It was begun with the world that is recorded.
    Waveform(Box<Waveform<Box<dyn Sink + Send>>>),
}

impl Recorder {
    /// Lets the world keep what is recorded.
    pub(crate) fn begin(&self, world: &mut World) {
        match self {
            Self::Exchanges(_) => world.record(),
            Self::Waveform(_) => {}
        }
    }

    /// Takes what a cycle has brought.
    pub(crate) fn cycled(&mut self, world: &mut World, cycled: &Cycled) -> io::Result<()> {
        match self {
            Self::Exchanges(_) => self.changed(world),
            Self::Waveform(waveform) => waveform.cycled(world, cycled),
        }
    }

    /// Takes what a change between two cycles has brought.
    pub(crate) fn changed(&mut self, world: &mut World) -> io::Result<()> {
        match self {
            Self::Exchanges(rows) => world.take_recorded().try_for_each(|row| rows.write(&row)),
            Self::Waveform(_) => Ok(()),
        }
    }

    /// Writes what is left.
    pub(crate) fn finish(self) -> io::Result<()> {
        match self {
            Self::Exchanges(mut rows) => rows.flush(),
            Self::Waveform(waveform) => waveform.finish()?.flush(),
        }
    }
}

/// The file of a recording under way.
#[derive(Debug)]
pub struct RecordingFile(Growing);

impl RecordingFile {
    /// Begins to record a world in a file: its signals over time, in a format and as far as they are to be shown, or
    /// without a `waveform` its exchanges.
    ///
    /// # Errors
    /// Those of [`Growing::begin`], and of writing the head.
    pub fn begin(
        file: &Path,
        existing: Existing,
        world: &mut World,
        waveform: Option<(Format, Shown)>,
    ) -> io::Result<(Self, Recorder)> {
        let growing = Growing::begin(file, existing)?;
        let recorder = match waveform {
            Some((format, shown)) => drawn(format, growing.writer()?, world, shown),
            None => exchanges(growing.writer()?, world),
        }?;
        Ok((Self(growing), recorder))
    }

    /// Where what a killed run had recorded under this name is now, if there was something.
    #[must_use]
    pub fn remains(&self) -> Option<&Path> {
        self.0.remains()
    }

    /// Where it is until it is whole.
    #[must_use]
    pub fn partial(&self) -> &Path {
        self.0.partial()
    }

    /// Gives it its name, on the disk.
    ///
    /// # Errors
    /// Those of [`Growing::finish`].
    pub fn finish(self) -> io::Result<()> {
        self.0.finish()
    }
}

fn exchanges(file: File, world: &World) -> io::Result<Recorder> {
    let nodes = world.places().iter().map(encoring_sim::world::Place::node);
    let devices = (0..).zip(nodes).map(|(at, node)| device_line::to_device(at, node.unit(), node.memory()));
    let devices: Vec<_> = devices.collect();
    let sink: Box<dyn Write + Send> = Box::new(LineFile::new(file));
    Writer::recording(sink, &devices).map(Recorder::Exchanges)
}

fn drawn(format: Format, file: File, world: &mut World, shown: Shown) -> io::Result<Recorder> {
    let sink: Box<dyn Sink + Send> = Box::new(BufWriter::with_capacity(1 << 16, file));
    Waveform::new(format, sink, WRITER, world, shown).map(|waveform| Recorder::Waveform(Box::new(waveform)))
}
