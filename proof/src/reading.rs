//! The manuals as tables, and the plainest machine that follows them.
//!
//! Written from the documents alone. It shares nothing with the device under test: words are bare `u32`, the ranges
//! and masks stand here a second time, and a service takes no time.
#![allow(clippy::indexing_slicing, reason = "sixteen rows, and a service number has four bits")]

/// What one manual says of one encoder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Book {
    /// The encoder's name in reports and on the command line.
    pub(crate) name: &'static str,
    /// What each service number means.
    pub(crate) services: [Service; 16],
    /// The bits that the error status may show.
    pub(crate) status_mask: u32,
    pub(crate) sensor: Sensor,
    pub(crate) effect: Effect,
}

/// What a service number means.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Service {
    Unknown,
    /// Read and written: accepted are `low..=high` of the bits in `ranged`.
    Parameter {
        low: u32,
        high: u32,
        ranged: u32,
        layout: Layout,
        factory: u32,
    },
    /// Written only, up to a limit.
    PresetAdjustment(Limit),
    /// Read only.
    DataCheck,
}

/// What becomes of the 24 bits of a write.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Layout {
    /// They are stored as they are.
    Plain,
    /// CE-65-M 01: byte 1 and byte 0 are 0 or not 0, byte 2 is nothing.
    DirectionAndCode,
    /// CE-65-M 0D: byte 2 and byte 1 are 0 or not 0, byte 0 is a number, 24 with repetition.
    Ssi,
}

/// How far a preset adjustment may go.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Limit {
    To(u32),
    /// The measuring length that is in use.
    MeasuringLength,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Sensor {
    Shaft { steps_per_turn: u64 },
    Rod { um: u64 },
}

/// When a written value is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    AtOnce,
    AfterDataCheck,
}

const U: Service = Service::Unknown;

const fn plain(low: u32, high: u32, factory: u32) -> Service {
    Service::Parameter { low, high, ranged: 0xFF_FFFF, layout: Layout::Plain, factory }
}

const DIRECTION: Service = plain(0, 1, 0);
const DIRECTION_AND_CODE: Service =
    Service::Parameter { low: 0, high: 0, ranged: 0, layout: Layout::DirectionAndCode, factory: 0 };
const LENGTH: Service = plain(0x10, 0xFF_FFFF, 0xFF_FFFF);
const NUMERATOR: Service = plain(0, 0xFFFF, 4096);
const DENOMINATOR: Service = plain(1, 0x63, 1);
const PRESET_VALUE: Service = plain(0, 0xFF_FFFF, 0);
const ADJUSTMENT: Service = Service::PresetAdjustment(Limit::MeasuringLength);
const CHECK: Service = Service::DataCheck;
const SSI: Service =
    Service::Parameter { low: 8, high: 0x20, ranged: 0xFF, layout: Layout::Ssi, factory: 24 };

const ROD_UM: u64 = 500_000;
const ROD_LENGTH: Service = plain(1, 0xFF_FFFF, 0xC350);
const ROD_ADJUSTMENT: Service = Service::PresetAdjustment(Limit::To(0xFF_FFFF));

/// LA-66 with a rod of 500 mm.
#[rustfmt::skip]
const LA_66: Book = Book {
    name: "la-66",
    //         0  1          2           3          4             5             6               7
    services: [U, DIRECTION, ROD_LENGTH, U,         PRESET_VALUE, U,            ROD_ADJUSTMENT, U,
    //         8      9            A  B  C  D    E  F
               CHECK, U,           U, U, U, U,   U, U],
    status_mask: 0x0020,
    sensor: Sensor::Rod { um: ROD_UM },
    effect: Effect::AtOnce,
};

#[rustfmt::skip]
const CE_100_M: Book = Book {
    name: "ce-100-m",
    services: [U, DIRECTION, LENGTH,     NUMERATOR, PRESET_VALUE, PRESET_VALUE, ADJUSTMENT,     U,
               CHECK, DENOMINATOR, U, U, U, U,   U, U],
    status_mask: 0x638F,
    sensor: Sensor::Shaft { steps_per_turn: 4096 },
    effect: Effect::AfterDataCheck,
};

#[rustfmt::skip]
const CE_65_M: Book = Book {
    name: "ce-65-m",
    services: [U, DIRECTION_AND_CODE, LENGTH, NUMERATOR, U,       U,            ADJUSTMENT,     U,
               CHECK, DENOMINATOR, U, U, U, SSI, U, U],
    status_mask: 0x608F,
    sensor: Sensor::Shaft { steps_per_turn: 4096 },
    effect: Effect::AfterDataCheck,
};

const CE_65_M_8192: Book =
    Book { name: "ce-65-m-8192", sensor: Sensor::Shaft { steps_per_turn: 8192 }, ..CE_65_M };

/// The encoders that the proof is about.
pub(crate) static BOOKS: [Book; 4] = [LA_66, CE_100_M, CE_65_M, CE_65_M_8192];

const SERVICE_BIT: u32 = 1 << 31;
const WRITE: u32 = 1 << 30;
const ERROR: u32 = 1 << 29;

const READING_DATA: u32 = 1 << 0;
const WRITING_DATA: u32 = 1 << 1;
const ONLY_READING_ALLOWED: u32 = 1 << 2;
const ONLY_WRITING_ALLOWED: u32 = 1 << 3;
const MAGNET: u32 = 1 << 5;
const UNKNOWN_SERVICE: u32 = 1 << 7;
const PRESET_1: u32 = 1 << 8;
const PRESET_2: u32 = 1 << 9;
const NUMERATOR_0: u32 = 1 << 13;
const LENGTH_TOO_LARGE: u32 = 1 << 14;

/// An encoder as the manuals have it, its services done in no time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading<'a> {
    book: &'a Book,
    /// By service number.
    programmed: [u32; 16],
    accepted: [u32; 16],
    pending: bool,
    latched: u32,
    /// The offset, and the denominator under which it was found.
    offset: (i64, i64),
    /// Steps of the shaft, micrometres of the magnet.
    place: i64,
    magnet_away: bool,
    memory_unreadable: bool,
    service_bit_was_0: bool,
    reply: Option<u32>,
    memory_written: bool,
}

impl<'a> Reading<'a> {
    /// A new encoder, just switched on, with its shaft or magnet here.
    pub(crate) fn new(book: &'a Book, place: i64) -> Self {
        let factory = book.services.map(|service| match service {
            Service::Parameter { factory, .. } => factory,
            _ => 0,
        });
        Self {
            book,
            programmed: factory,
            accepted: factory,
            pending: false,
            latched: 0,
            offset: (0, 1),
            place,
            magnet_away: false,
            memory_unreadable: false,
            service_bit_was_0: false,
            reply: None,
            memory_written: false,
        }
    }

    /// A sample is taken here.
    pub(crate) fn sample(&mut self, place: i64) {
        self.place = place;
    }

    /// The magnet is taken away or put back where it was.
    pub(crate) fn take_magnet_away(&mut self, away: bool) {
        self.magnet_away = away;
    }

    /// The memory cannot be read, or can again.
    pub(crate) fn break_memory(&mut self, unreadable: bool) {
        self.memory_unreadable = unreadable;
    }

    /// Switched off and on again where it is.
    pub(crate) fn power_cycle(&mut self) {
        (self.pending, self.latched, self.reply, self.service_bit_was_0) = (false, 0, None, false);
        if self.validity() == 0 {
            self.accepted = self.programmed;
        } else {
            self.pending = true;
        }
        if self.magnet_away {
            self.place = 0;
        }
    }

    /// Tells whether the memory has been written since it was asked last.
    pub(crate) fn memory_was_written(&mut self) -> bool {
        std::mem::take(&mut self.memory_written)
    }

    /// One cycle.
    pub(crate) fn exchange(&mut self, out: u32) -> u32 {
        if self.magnet_away {
            self.fault(MAGNET);
        }
        if out & SERVICE_BIT == 0 {
            self.service_bit_was_0 = true;
            self.reply = None;
        } else if self.service_bit_was_0 && self.reply.is_none() {
            self.reply = Some(self.serve(out));
        }
        self.reply.unwrap_or_else(|| self.shown_position() | self.error_bit())
    }

    fn error_bit(&self) -> u32 {
        if self.pending { ERROR } else { 0 }
    }

    fn fault(&mut self, status: u32) {
        self.pending = true;
        self.latched |= status;
    }

    fn serve(&mut self, out: u32) -> u32 {
        let (number, data) = ((out >> 24 & 0xF) as usize, out & 0xFF_FFFF);
        let reply = if out & WRITE == 0 {
            out & 0x8F00_0000 | self.read(number)
        } else {
            self.write(number, data);
            out & 0xCFFF_FFFF
        };
        reply | self.error_bit()
    }

    fn read(&mut self, number: usize) -> u32 {
        match self.book.services[number] {
            Service::Unknown => self.fault(UNKNOWN_SERVICE),
            Service::PresetAdjustment(_) => self.fault(ONLY_WRITING_ALLOWED),
            Service::DataCheck => return self.data_check(),
            Service::Parameter { .. } if self.memory_unreadable => self.fault(READING_DATA),
            Service::Parameter { .. } => return self.programmed[number],
        }
        0
    }

    fn write(&mut self, number: usize, data: u32) {
        match self.book.services[number] {
            Service::Unknown => self.fault(UNKNOWN_SERVICE),
            Service::DataCheck => self.fault(ONLY_READING_ALLOWED),
            Service::PresetAdjustment(limit) => {
                let highest = match limit {
                    Limit::To(highest) => highest,
                    Limit::MeasuringLength => self.active()[2],
                };
                if data > highest {
                    self.fault(WRITING_DATA);
                } else {
                    let offset = self.offset_for(data);
                    self.memory_written |= self.offset != offset;
                    self.offset = offset;
                }
            }
            Service::Parameter { low, high, ranged, layout, .. } => {
                let judged = data & ranged;
                if judged < low || judged > high {
                    self.fault(WRITING_DATA);
                    return;
                }
                let stored = layout.stored(data);
                self.memory_written |= self.programmed[number] != stored;
                self.programmed[number] = stored;
                if number == 3 && stored == 0 {
                    self.fault(NUMERATOR_0);
                }
            }
        }
    }

    fn active(&self) -> &[u32; 16] {
        match self.book.effect {
            Effect::AtOnce => &self.programmed,
            Effect::AfterDataCheck => &self.accepted,
        }
    }

    fn data_check(&mut self) -> u32 {
        let faults = self.validity();
        let status = (self.latched | faults) & self.book.status_mask;
        self.latched = if self.magnet_away { MAGNET } else { 0 };
        self.pending = faults != 0 || self.magnet_away;
        if faults == 0 && self.book.effect == Effect::AfterDataCheck {
            self.memory_written |= self.accepted != self.programmed;
            self.accepted = self.programmed;
        }
        status
    }

    /// What is wrong with the programmed values as a whole.
    fn validity(&self) -> u32 {
        let Sensor::Shaft { steps_per_turn } = self.book.sensor else { return 0 };
        let value = |number: usize| u64::from(self.programmed[number]);
        let (s, n, d) = (value(2), value(3), value(9));
        let mut faults = 0;
        if n == 0 {
            faults |= NUMERATOR_0;
        } else if (s + 1) * d > steps_per_turn * n {
            faults |= LENGTH_TOO_LARGE;
        }
        if value(4) > s {
            faults |= PRESET_1;
        }
        if value(5) > s {
            faults |= PRESET_2;
        }
        faults
    }

    /// Steps of the shaft, or micrometres on the rod, in the direction that counts up.
    fn counted(&self) -> i64 {
        let falling = self.active()[1] & 1 == 1;
        match self.book.sensor {
            Sensor::Shaft { .. } if falling => -1 - self.place,
            Sensor::Rod { um } if falling => um as i64 - self.place,
            _ => self.place,
        }
    }

    fn position(&self) -> i64 {
        let active = self.active();
        let s = i64::from(active[2]);
        match self.book.sensor {
            Sensor::Rod { um } => (self.counted() * s / um as i64 + self.offset.0).rem_euclid(1 << 24),
            Sensor::Shaft { steps_per_turn } => {
                let (n, d) = (i64::from(active[3]), i64::from(active[9]));
                let range = steps_per_turn as i64 * n;
                let offset = self.offset.0 * d / self.offset.1;
                let phase = (self.counted() * d + offset).rem_euclid(range);
                phase * (s + 1) / range
            }
        }
    }

    /// The offset that makes the position here this one, and the denominator it is meant with.
    fn offset_for(&self, wanted: u32) -> (i64, i64) {
        let active = self.active();
        let (s, wanted) = (i64::from(active[2]), i64::from(wanted));
        match self.book.sensor {
            Sensor::Rod { um } => {
                let scaled = self.counted() * s / um as i64;
                ((wanted - scaled).rem_euclid(1 << 24), 1)
            }
            Sensor::Shaft { steps_per_turn } => {
                let (n, d) = (i64::from(active[3]), i64::from(active[9]));
                let range = steps_per_turn as i64 * n;
                let mut phase = wanted * range / (s + 1);
                while phase * (s + 1) / range < wanted {
                    phase += 1;
                }
                ((phase - self.counted() * d).rem_euclid(range), d)
            }
        }
    }

    fn shown_position(&self) -> u32 {
        let position = self.position() as u32;
        let gray = self.active()[1] & 0x100 != 0;
        if gray { position ^ position >> 1 } else { position }
    }
}

impl Layout {
    fn stored(self, data: u32) -> u32 {
        let flag = |byte: u32| u32::from(data >> (8 * byte) & 0xFF != 0);
        match self {
            Self::Plain => data,
            Self::DirectionAndCode => flag(1) << 8 | flag(0),
            Self::Ssi => {
                let number = if flag(2) == 1 { 24 } else { data & 0xFF };
                flag(2) << 16 | flag(1) << 8 | number
            }
        }
    }
}
