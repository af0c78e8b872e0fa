//! The device under test on a bench where a whole life can be taken back at once.

use embedded_storage::{ReadStorage, Storage};
use encoring_encoder::records::EEPROM_BYTES;
use encoring_encoder::{Encoder, Magnet, Ram, ServiceTimes, Terminals, Unit, records};
use encoring_words::model::Sensor;
use encoring_words::{Instant, Model, OutWord};

use crate::reading::{self, Book};

/// One millisecond: a new sample on every model.
const REFRESH_NS: u64 = 1_000_000;

/// An encoder with its memory, the time and its terminals.
#[derive(Clone)]
pub(crate) struct Device {
    encoder: Encoder,
    memory: Memory,
    now: u64,
    terminals: Terminals,
    start: Encoder,
}

impl Device {
    /// A new encoder, just switched on, with its shaft or magnet here.
    pub(crate) fn new(book: &Book, place: i64) -> Self {
        let unit = unit(book);
        let mut memory = Memory::blank();
        // A memory that cannot be formatted shows in the very first comparison.
        let _ = records::format(&unit, &mut memory);
        let terminals = Terminals { raw: place, magnet: Magnet::Present, preset_mv: [0, 0] };
        let encoder = Encoder::power_up(&unit, Instant(0), &terminals, &mut memory);
        memory.mark();
        Self { start: encoder.clone(), encoder, memory, now: 0, terminals }
    }

    #[inline]
    pub(crate) fn exchange(&mut self, out: u32) -> u32 {
        let now = Instant(self.now);
        self.encoder.exchange(now, OutWord(out), &self.terminals, &mut self.memory).0
    }

    /// Shaft or magnet are here at the next refresh.
    pub(crate) fn sample(&mut self, place: i64) {
        self.now += REFRESH_NS;
        self.tell(place);
    }

    /// Shaft or magnet are here, without a refresh.
    pub(crate) fn tell(&mut self, place: i64) {
        self.terminals.raw = place;
    }

    pub(crate) fn take_magnet_away(&mut self, away: bool) {
        self.terminals.magnet = if away { Magnet::Missing } else { Magnet::Present };
    }

    pub(crate) fn break_memory(&mut self, unreadable: bool) {
        self.memory.unreadable = unreadable;
    }

    pub(crate) fn power_cycle(&mut self) {
        self.encoder.clone().power_off(&mut self.memory);
        let unit = *self.encoder.unit();
        self.encoder = Encoder::power_up(&unit, Instant(self.now), &self.terminals, &mut self.memory);
    }

    /// Tells whether the memory has been written since it was asked last.
    pub(crate) fn memory_was_written(&mut self) -> bool {
        std::mem::take(&mut self.memory.written)
    }

    /// From here `take_back` starts over.
    pub(crate) fn mark(&mut self) {
        self.start = self.encoder.clone();
        self.memory.mark();
    }

    /// As it was at `mark`; time and terminals stay.
    #[inline]
    pub(crate) fn take_back(&mut self) {
        self.encoder.clone_from(&self.start);
        self.memory.take_back();
    }
}

fn unit(book: &Book) -> Unit {
    let (model, sensor) = match (book.name, book.sensor) {
        (_, reading::Sensor::Rod { um }) => (Model::La66, Sensor::Linear { rod_um: um as u32 }),
        ("ce-100-m", _) => (Model::Ce100M, Sensor::Rotary { steps_per_turn: 4096 }),
        ("ce-65-m-8192", _) => (Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }),
        _ => (Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }),
    };
    #[expect(clippy::expect_used, reason = "the four encoders exist")]
    let mut unit = Unit::new(model, sensor).expect("an encoder that can be built");
    unit.service_times = ServiceTimes::ZERO;
    unit
}

/// An EEPROM that remembers which bytes were written, so that few need to be copied back.
#[derive(Clone)]
struct Memory {
    cells: Ram,
    before: [u8; EEPROM_BYTES],
    journal: Vec<(usize, usize)>,
    written: bool,
    unreadable: bool,
}

#[derive(Clone, Copy, Debug)]
struct Refused;

impl Memory {
    fn blank() -> Self {
        let cells = Ram::blank();
        Self { before: *cells.image(), cells, journal: Vec::new(), written: false, unreadable: false }
    }

    fn mark(&mut self) {
        self.before = *self.cells.image();
        self.journal.clear();
        self.written = false;
    }

    #[inline]
    fn take_back(&mut self) {
        for (from, to) in self.journal.drain(..) {
            if let (Some(bytes), Some(before)) =
                (self.cells.image_mut().get_mut(from..to), self.before.get(from..to))
            {
                bytes.copy_from_slice(before);
            }
        }
        self.written = false;
    }
}

impl ReadStorage for Memory {
    type Error = Refused;

    #[inline]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        if self.unreadable { Err(Refused) } else { self.cells.read(offset, bytes).map_err(|_| Refused) }
    }

    fn capacity(&self) -> usize {
        self.cells.capacity()
    }
}

impl Storage for Memory {
    #[inline]
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        self.cells.write(offset, bytes).map_err(|_| Refused)?;
        self.journal.push((offset as usize, offset as usize + bytes.len()));
        self.written = true;
        Ok(())
    }
}
