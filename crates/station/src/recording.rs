//! What is recorded of a ring while it runs, and the file that it goes to.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use encoring_files::{Existing, Growing, LineFile};
use encoring_sim::{Cycled, Shown, Waveform, World, device_line};
use encoring_trace::bus::BusWriter;
use encoring_trace::wave::{Format, Sink};
use encoring_trace::{DeviceLine, Writer};

use crate::bus_seen::BusSeen;

/// Who is named in a waveform.
const WRITER: &str = concat!("encoring ", env!("CARGO_PKG_VERSION"));

/// What is recorded, and where it goes.
pub enum Recorder {
    /// Every exchange of every encoder, as rows.
    Exchanges(Writer<Box<dyn Write + Send>>),
    /// What the ring looks like over time. It was begun with the world that is recorded.
    Waveform(Box<Waveform<Box<dyn Sink + Send>>>),
    /// The master's image at every cycle, and every write of a client, as rows.
    Bus(BusWriter<Box<dyn Write + Send>>),
}

/// What shall stand in the file of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// Every exchange of every encoder.
    Exchanges,
    /// Signals over time, in a format and as far as they are to be shown.
    Waveform(Format, Shown),
    /// The master's image at every cycle, and every write of a client.
    Bus,
}

impl Recorder {
    /// Lets the world keep what is recorded.
    pub(crate) fn begin(&self, world: &mut World) {
        match self {
            Self::Exchanges(_) => world.record(),
            Self::Waveform(_) | Self::Bus(_) => {}
        }
    }

    /// Takes what a cycle has brought.
    pub(crate) fn cycled(&mut self, world: &mut World, cycled: &Cycled, bus: &BusSeen) -> io::Result<()> {
        match self {
            Self::Exchanges(_) => self.changed(world),
            Self::Waveform(waveform) => waveform.cycled(world, cycled),
            Self::Bus(rows) => bus.rows().try_for_each(|row| rows.write(&row)),
        }
    }

    /// Takes what a change between two cycles has brought.
    pub(crate) fn changed(&mut self, world: &mut World) -> io::Result<()> {
        match self {
            Self::Exchanges(rows) => world.take_recorded().try_for_each(|row| rows.write(&row)),
            Self::Waveform(_) | Self::Bus(_) => Ok(()),
        }
    }

    /// Whether it takes what the master sees.
    pub(crate) const fn is_of_bus(&self) -> bool {
        matches!(self, Self::Bus(_))
    }

    /// It broke off: lets the world keep nothing more for it.
    pub(crate) fn broke_off(&self, world: &mut World) {
        if !self.is_of_bus() {
            world.end_recording();
        }
    }

    /// Writes what is left.
    pub(crate) fn finish(self) -> io::Result<()> {
        match self {
            Self::Exchanges(mut rows) => rows.flush(),
            Self::Waveform(waveform) => waveform.finish()?.flush(),
            Self::Bus(mut rows) => rows.flush(),
        }
    }
}

/// The file of a recording under way.
#[derive(Debug)]
pub struct RecordingFile(Growing);

impl RecordingFile {
    /// Begins to record a world in a file.
    ///
    /// # Errors
    /// Those of [`Growing::begin`], and of writing the head.
    pub fn begin(
        file: &Path,
        existing: Existing,
        world: &mut World,
        recorded: Recorded,
    ) -> io::Result<(Self, Recorder)> {
        let growing = Growing::begin(file, existing)?;
        let file = growing.writer()?;
        let recorder = match recorded {
            Recorded::Exchanges => Writer::recording(rows(file), &devices(world)).map(Recorder::Exchanges),
            Recorded::Waveform(format, shown) => drawn(format, file, world, shown),
            Recorded::Bus => BusWriter::new(rows(file), &devices(world)).map(Recorder::Bus),
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

fn devices(world: &World) -> Vec<DeviceLine> {
    let nodes = world.places().iter().map(encoring_sim::world::Place::node);
    (0..).zip(nodes).map(|(at, node)| device_line::to_device(at, node.unit(), node.memory())).collect()
}

fn rows(file: File) -> Box<dyn Write + Send> {
    Box::new(LineFile::new(file))
}

fn drawn(format: Format, file: File, world: &mut World, shown: Shown) -> io::Result<Recorder> {
    let sink: Box<dyn Sink + Send> = Box::new(BufWriter::with_capacity(1 << 16, file));
    Waveform::new(format, sink, WRITER, world, shown).map(|waveform| Recorder::Waveform(Box::new(waveform)))
}
