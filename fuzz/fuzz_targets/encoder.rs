//! Any life of an encoder: memories that fail, supplies that come and go, clocks that run backwards.
#![no_main]

use arbitrary::Arbitrary;
use crc::{CRC_32_ISO_HDLC, Crc};
use encoring_encoder::handshake::{Ending, Handshake};
use encoring_encoder::records::EEPROM_BYTES;
use encoring_encoder::{Encoder, Magnet, ServiceTimes, Terminals, Unit, ZeroLoss};
use encoring_sim::{CellFault, Eeprom, Node, Surroundings};
use encoring_words::model::Sensor;
use encoring_words::ssi_frame::Level;
use encoring_words::word::{DATA, DATA_MAX, ERROR_BIT, RESERVE_BIT};
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Week};
use libfuzzer_sys::fuzz_target;

/// More than any service takes here.
const LONG: Duration = Duration::from_secs(3600);

#[derive(Arbitrary, Debug)]
struct Life {
    kind: Kind,
    old_firmware: bool,
    worst_zero_loss: bool,
    /// In microseconds.
    service_times: Option<[u16; 4]>,
    memory: Memory,
    operations: Vec<Operation>,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Kind {
    La66 { rod_um: u32 },
    Ce100M,
    Ce65M,
    Ce65M8192,
}

#[derive(Arbitrary, Debug)]
enum Memory {
    Factory,
    Blank,
    /// Whole records, each with a check that holds, over a factory memory.
    Planted(Vec<Planted>),
    Bytes(Vec<u8>),
}

#[derive(Arbitrary, Debug)]
enum Planted {
    Programmed { parameter: u8, second: bool, count: u32, value: [u8; 3] },
    Accepted { second: bool, count: u32, value: [u8; 21] },
    Offset { second: bool, count: u32, value: [u8; 5] },
    TurnCount { second: bool, count: u32, value: [u8; 9] },
}

#[derive(Arbitrary, Debug)]
enum Operation {
    Exchange {
        after_us: u16,
        out: u32,
    },
    /// A service as a master requests it: bit 31 down, then up, then a while of waiting.
    Service {
        number: u8,
        write: bool,
        data: u32,
        wait_us: u16,
        cycles: u8,
    },
    Clock {
        after_ns: u16,
        high: bool,
    },
    Wait {
        ns: u64,
    },
    Back {
        ns: u32,
    },
    Shaft {
        raw: i64,
    },
    Travel {
        steps: i32,
    },
    Presets {
        volts: [u8; 2],
    },
    TakeMagnet {
        missing: bool,
    },
    Supply {
        millivolts: u16,
    },
    PowerCycle,
    Fail {
        kind: Failure,
        cell: Option<u16>,
    },
    Cut {
        after_bytes: u8,
    },
    Repair,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Failure {
    Read,
    Write,
    Stuck(u8),
}

impl Life {
    fn unit(&self) -> Unit {
        let (model, sensor) = match self.kind {
            Kind::La66 { rod_um } => (Model::La66, Sensor::Linear { rod_um: 10 + rod_um % 167_772_141 }),
            Kind::Ce100M => (Model::Ce100M, Sensor::Rotary { steps_per_turn: 4096 }),
            Kind::Ce65M => (Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }),
            Kind::Ce65M8192 => (Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }),
        };
        let mut unit = Unit::new(model, sensor).expect("a sensor of its model");
        if self.old_firmware {
            unit.firmware = Week::new(40, 1997).expect("a week");
        }
        if self.worst_zero_loss {
            unit.zero_loss = ZeroLoss::WorstAllowed;
        }
        if let Some(times) = self.service_times {
            let [read, write, data_check, preset_adjustment] =
                times.map(|us| Duration::from_micros(u64::from(us)));
            unit.service_times = ServiceTimes { read, write, data_check, preset_adjustment };
        }
        unit
    }

    fn node(&self, unit: Unit) -> Node {
        match &self.memory {
            Memory::Factory => Node::new(unit),
            Memory::Blank => Node::with_memory(unit, Eeprom::blank()),
            Memory::Planted(records) => {
                let mut image = *Node::new(unit).memory().image();
                for record in records {
                    record.plant(&mut image);
                }
                Node::with_memory(unit, Eeprom::from_image(image))
            }
            Memory::Bytes(bytes) => {
                let mut image = [0xFF; EEPROM_BYTES];
                for (place, byte) in image.iter_mut().zip(bytes) {
                    *place = *byte;
                }
                Node::with_memory(unit, Eeprom::from_image(image))
            }
        }
    }
}

impl Planted {
    /// A slot as the encoder writes it: marker, count, value, check.
    fn plant(&self, image: &mut [u8; EEPROM_BYTES]) {
        let (base, stride, second, count, value) = match self {
            Self::Programmed { parameter, second, count, value } => {
                (usize::from(parameter % 7) * 32, 16, second, count, &value[..])
            }
            Self::Accepted { second, count, value } => (224, 32, second, count, &value[..]),
            Self::Offset { second, count, value } => (288, 16, second, count, &value[..]),
            Self::TurnCount { second, count, value } => (320, 32, second, count, &value[..]),
        };
        let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
        let mut digest = crc.digest();
        digest.update(&(base as u32).to_le_bytes());
        digest.update(&count.to_le_bytes());
        digest.update(value);
        let slot = [&[0xA5], &count.to_le_bytes()[..], value, &digest.finalize().to_le_bytes()].concat();
        let at = base + usize::from(*second) * stride;
        image[at..at + slot.len()].copy_from_slice(&slot);
    }
}

struct Bench {
    node: Node,
    now: Instant,
    /// The latest `now` since power-up: what an earlier one counts as.
    latest: Instant,
    around: Surroundings,
    /// The OUT word whose reply is due or shown.
    asked: OutWord,
}

impl Bench {
    fn exchange(&mut self, out: OutWord) -> Option<InWord> {
        match self.node.encoder().map(|encoder| *encoder.handshake()) {
            Some(Handshake::Busy { request, .. }) => self.asked = request,
            Some(Handshake::Acknowledged { ending: Ending::Released, .. }) => {}
            _ => self.asked = out,
        }
        self.tell_time();
        let word = self.node.step(self.now, out, &self.around)?;
        let encoder = self.node.encoder().expect("an answer comes from an encoder that is on");
        match encoder.handshake().reply() {
            Some(reply) => self.is_reply(word, reply, encoder),
            None => Self::is_position(word, encoder),
        }
        Some(word)
    }

    /// Normal mode: a position, bit 29, and nothing else.
    fn is_position(word: InWord, encoder: &Encoder) {
        assert_eq!(word.0 & 0xDF00_0000, 0, "{word} in normal mode");
        assert_eq!(word.error_bit(), encoder.error_pending(), "{word}");
        if encoder.unit().model() != Model::Ce65M {
            assert_eq!(DATA.of(word.0), encoder.position(), "{word}");
        }
    }

    /// A reply carries the request's upper byte, but for the error bit and the reserve.
    fn is_reply(&self, word: InWord, reply: InWord, encoder: &Encoder) {
        let asked = self.asked;
        assert_eq!(word, reply);
        assert!(asked.service_bit(), "{word} answers {asked}, which asks for nothing");
        let fixed = !(DATA.mask() | ERROR_BIT.mask() | RESERVE_BIT.mask());
        assert_eq!(word.0 & fixed, asked.0 & fixed, "{word} answers {asked}");
        assert_eq!(word.0 & RESERVE_BIT.mask(), 0, "{word} answers {asked}");
        if asked.0 & 0x4000_0000 != 0 {
            assert_eq!(DATA.of(word.0), DATA.of(asked.0), "{word} answers {asked}");
        } else if asked.0 >> 24 & 0xF == 8 {
            let mask = u32::from(encoder.unit().model().status_mask().bits());
            assert_eq!(DATA.of(word.0) & !mask, 0, "{word} holds status bits that do not exist");
        }
    }

    fn holds(&self) {
        let Some(encoder) = self.node.encoder() else { return };
        let mask = encoder.unit().model().status_mask();
        assert!(mask.contains(encoder.latched_status()), "{:?}", encoder.latched_status());
        let highest = match encoder.unit().sensor() {
            Sensor::Rotary { .. } => encoder.active().measuring_length(),
            Sensor::Linear { .. } => DATA_MAX,
        };
        assert!(encoder.position() <= highest, "position {} of {highest}", encoder.position());
    }

    fn pass(&mut self, span: Duration) {
        self.now = self.now + span;
    }

    fn tell_time(&mut self) {
        self.latest = if self.node.encoder().is_some() { self.latest.max(self.now) } else { self.now };
    }

    fn operate(&mut self, operation: &Operation) {
        match *operation {
            Operation::Exchange { after_us, out } => {
                self.pass(Duration::from_micros(u64::from(after_us)));
                self.exchange(OutWord(out));
            }
            Operation::Service { number, write, data, wait_us, cycles } => {
                let low = u32::from(write) << 30 | u32::from(number & 0xF) << 24 | data & DATA_MAX;
                self.exchange(OutWord(low));
                for _ in 0..=cycles % 4 {
                    self.exchange(OutWord(low | 0x8000_0000));
                    self.pass(Duration::from_micros(u64::from(wait_us)));
                }
            }
            Operation::Clock { after_ns, high } => {
                self.pass(Duration::from_nanos(u64::from(after_ns)));
                self.tell_time();
                let level = self.node.ssi_clock(self.now, Level::from_bit(u32::from(high)), &self.around);
                // A power cut in the memory holds from the next exchange on.
                let is_on = !self.node.memory().is_cut();
                let with_output = |encoder: &&Encoder| encoder.unit().model() == Model::Ce65M;
                match self.node.encoder().filter(with_output) {
                    Some(_) if !is_on => {}
                    Some(encoder) => assert_eq!(encoder.ssi_level(self.latest).0, level),
                    None => assert_eq!(level, Level::Low, "there is no output, or no supply"),
                }
            }
            Operation::Wait { ns } => self.pass(Duration::from_nanos(ns)),
            Operation::Back { ns } => self.now = Instant(self.now.0.saturating_sub(u64::from(ns))),
            // Within +-2^62.
            Operation::Shaft { raw } => self.around.terminals.raw = raw >> 1,
            Operation::Travel { steps } => {
                let raw = self.around.terminals.raw + i64::from(steps);
                self.around.terminals.raw = raw.clamp(-(1 << 62), 1 << 62);
            }
            Operation::Presets { volts } => {
                self.around.terminals.preset_mv = volts.map(|volts| u32::from(volts) * 1000);
            }
            Operation::TakeMagnet { missing } => {
                self.around.terminals.magnet = if missing { Magnet::Missing } else { Magnet::Present };
            }
            Operation::Supply { millivolts } => {
                self.around.supply_mv = u32::from(millivolts);
                self.node.supply(self.now, self.around.supply_mv);
            }
            Operation::PowerCycle => {
                self.node.supply(self.now, 0);
                self.around.supply_mv = 24_000;
            }
            Operation::Fail { kind, cell } => {
                let kind = match kind {
                    Failure::Read => CellFault::Read,
                    Failure::Write => CellFault::Write,
                    Failure::Stuck(value) => CellFault::Stuck(value),
                };
                self.node.memory_mut().fail(kind, cell.map(|cell| usize::from(cell) % EEPROM_BYTES));
            }
            Operation::Cut { after_bytes } => self.node.memory_mut().cut_after(u64::from(after_bytes)),
            Operation::Repair => self.node.memory_mut().repair(),
        }
        self.holds();
    }

    /// Whatever happened, a new supply and a sound memory make it answer again.
    fn recovers(mut self) {
        self.node.supply(self.now, 0);
        self.node.memory_mut().repair();
        self.around.supply_mv = 24_000;
        self.exchange(OutWord(0));
        self.exchange(OutWord(0x8800_0000));
        self.pass(LONG);
        let word = self.exchange(OutWord(0x8800_0000)).expect("it has its supply");
        assert_eq!(word.0 >> 24 & 0xDF, 0x88, "{word} is no reply to a data check");
        self.holds();
        // Nothing is lost by switching it off and on again.
        self.node.supply(self.now, 0);
        let before = *self.node.memory().image();
        self.exchange(OutWord(0));
        self.node.supply(self.now, 0);
        let sound = Node::with_memory(*self.node.unit(), Eeprom::from_image(before));
        assert_eq!(sound.memory().image(), self.node.memory().image(), "standing still writes nothing");
    }
}

fuzz_target!(|life: Life| {
    let unit = life.unit();
    let around = Surroundings { terminals: Terminals::default(), ..Surroundings::default() };
    let mut bench =
        Bench { node: life.node(unit), now: Instant::ZERO, latest: Instant::ZERO, around, asked: OutWord(0) };
    for operation in &life.operations {
        bench.operate(operation);
    }
    bench.recovers();
});
