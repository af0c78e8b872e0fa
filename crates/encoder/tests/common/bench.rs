//! One encoder on a bench: its memory, its terminals and the time.

use encoring_encoder::{Encoder, Magnet, ServiceTimes, Terminals, Unit, records};
use encoring_words::model::Sensor;
use encoring_words::{InWord, Instant, Model, OutWord};

use super::memory::Memory;

pub const US: u64 = 1_000;
pub const MS: u64 = 1_000_000;
pub const SECOND: u64 = 1_000_000_000;

const SERVICE_BIT: u32 = 1 << 31;

#[derive(Clone, Debug)]
pub struct Bench {
    pub unit: Unit,
    pub memory: Memory,
    pub encoder: Encoder,
    /// Nanoseconds.
    pub now: u64,
    pub terminals: Terminals,
}

/// An LA-66 with a rod of 500 mm, service times 0.
pub fn la66() -> Bench {
    Bench::new(unit(Model::La66, Sensor::Linear { rod_um: 500_000 }))
}

/// A CE-100-M, service times 0.
pub fn ce100() -> Bench {
    Bench::new(unit(Model::Ce100M, Sensor::Rotary { steps_per_turn: 4096 }))
}

/// A CE-65-M with 4096 steps per turn, service times 0.
pub fn ce65() -> Bench {
    Bench::new(unit(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }))
}

/// A CE-65-M with 8192 steps per turn, service times 0.
pub fn ce65_8192() -> Bench {
    Bench::new(unit(Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }))
}

pub fn every_model() -> [Bench; 4] {
    [la66(), ce100(), ce65(), ce65_8192()]
}

fn unit(model: Model, sensor: Sensor) -> Unit {
    let mut unit = Unit::new(model, sensor).unwrap();
    unit.service_times = ServiceTimes::ZERO;
    unit
}

impl Bench {
    /// A new device at time 0, which has seen one exchange with OUT = 0.
    pub fn new(unit: Unit) -> Self {
        let mut memory = Memory::blank();
        records::format(&unit, &mut memory).unwrap();
        let mut bench = Self::with_memory(&unit, memory);
        bench.exchange_now(0);
        bench
    }

    /// A device with this memory, just switched on, before its first exchange.
    pub fn with_memory(unit: &Unit, mut memory: Memory) -> Self {
        let terminals = Terminals { raw: 0, magnet: Magnet::Present, preset_mv: [0, 0] };
        let encoder = Encoder::power_up(unit, Instant(0), &terminals, &mut memory);
        Self { unit: *unit, memory, encoder, now: 0, terminals }
    }

    /// The same device built otherwise: `change` edits what it was built as, and it is switched off and on.
    pub fn rebuilt(mut self, change: impl FnOnce(&mut Unit)) -> Self {
        change(&mut self.unit);
        self.power_cycle();
        self
    }

    pub fn model(&self) -> Model {
        self.unit.model()
    }

    pub fn advance(&mut self, nanos: u64) {
        self.now += nanos;
    }

    /// One exchange now.
    pub fn exchange_now(&mut self, out: u32) -> u32 {
        let InWord(word) =
            self.encoder.exchange(Instant(self.now), OutWord(out), &self.terminals, &mut self.memory);
        word
    }

    /// One exchange 1 ms later: long enough for a new sample on every model.
    pub fn exchange(&mut self, out: u32) -> u32 {
        self.advance(MS);
        self.exchange_now(out)
    }

    /// A request, its reply, and the end of the request.
    pub fn service(&mut self, out: u32) -> u32 {
        let reply = self.exchange(out);
        assert_eq!(reply & SERVICE_BIT, SERVICE_BIT, "no reply to {out:08X}: {reply:08X}");
        let end = self.exchange(out & !SERVICE_BIT);
        assert_eq!(end & 0xDF00_0000, 0, "no normal mode after {out:08X}: {end:08X}");
        reply
    }

    /// Service 08 with its reply.
    pub fn data_check(&mut self) -> u32 {
        self.service(0x8800_0000)
    }

    /// Writes that succeed, then a data check that finds nothing.
    pub fn program(&mut self, writes: &[u32]) {
        for &write in writes {
            assert_eq!(self.service(write), write);
        }
        assert_eq!(self.data_check(), 0x8800_0000);
    }

    pub fn turn_to(&mut self, raw: i64) {
        self.terminals.raw = raw;
    }

    /// The IN word of normal mode at this shaft or magnet position.
    pub fn position_at(&mut self, raw: i64) -> u32 {
        self.turn_to(raw);
        self.exchange(0)
    }

    /// The IN word of normal mode, where shaft or magnet are.
    pub fn position(&mut self) -> u32 {
        self.exchange(0)
    }

    /// Switches the supply off, the regular way.
    pub fn power_off(&mut self) {
        self.encoder.clone().power_off(&mut self.memory);
    }

    /// Switches the supply on, without an exchange.
    pub fn power_up(&mut self) {
        self.advance(10 * MS);
        self.encoder = Encoder::power_up(&self.unit, Instant(self.now), &self.terminals, &mut self.memory);
    }

    /// Off and on; gives the IN word of the first exchange, with OUT = 0.
    pub fn power_cycle(&mut self) -> u32 {
        self.power_off();
        self.power_up();
        self.exchange_now(0)
    }

    /// Off, moved to `raw` while off, and on; gives the IN word of the first exchange, with OUT = 0.
    pub fn power_cycle_moved_to(&mut self, raw: i64) -> u32 {
        self.power_off();
        self.turn_to(raw);
        self.power_up();
        self.exchange_now(0)
    }
}
