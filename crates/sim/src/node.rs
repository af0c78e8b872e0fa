//! A device with its memory: what hangs at one place of the ring, and what a replay drives.

use encoring_device::{BusDevice, OFF_BELOW_MV, Surroundings};
use encoring_encoder::records;
use encoring_encoder::{Encoder, Unit};
use encoring_ring::Taken;
use encoring_words::ssi_frame::Level;
use encoring_words::{InWord, Instant, OutWord};

use crate::memory::Eeprom;

/// A device whose memory can fail.
#[derive(Clone, Debug)]
pub struct Node {
    device: BusDevice,
    memory: Eeprom,
}

impl Node {
    /// A new device, its memory formatted with factory values.
    #[must_use]
    pub fn new(unit: Unit) -> Self {
        let mut memory = Eeprom::blank();
        // A sound memory takes them; one that did not would count as lost and say so at power-up.
        let _ = records::format(&unit, &mut memory);
        Self::with_memory(unit, memory)
    }

    /// A device with the memory of an earlier life.
    #[must_use]
    pub const fn with_memory(unit: Unit, memory: Eeprom) -> Self {
        Self { device: BusDevice::new(unit), memory }
    }

    /// The OUT word that the encoder hears in its next exchange.
    pub fn hears(&mut self, taken: Taken) -> OutWord {
        self.device.hears(taken)
    }

    /// One exchange; `None` while the supply is too low.
    pub fn step(&mut self, now: Instant, out: OutWord, around: &Surroundings) -> Option<InWord> {
        self.supply(now, around.supply_mv);
        if self.is_cut_off() {
            return None;
        }
        let input = self.device.exchange(now, out, around, &mut self.memory);
        if self.is_cut_off() { None } else { input }
    }

    /// An edge of the SSI clock; Low while the supply is too low [R103..R120].
    pub fn ssi_clock(&mut self, now: Instant, clock: Level, around: &Surroundings) -> Level {
        self.supply(now, around.supply_mv);
        if self.is_cut_off() {
            return Level::Low;
        }
        let level = self.device.ssi_clock(now, clock, around, &mut self.memory);
        if self.is_cut_off() { Level::Low } else { level }
    }

    /// Tells the supply between two exchanges: any time below the limit is a power-off.
    pub fn supply(&mut self, now: Instant, millivolts: u32) {
        self.device.supply(now, millivolts, &mut self.memory);
        if millivolts < OFF_BELOW_MV {
            self.memory.power_back();
        }
    }

    /// A power cut in the middle of a write takes the encoder with it.
    fn is_cut_off(&mut self) -> bool {
        if self.memory.is_cut() {
            self.device.cut();
        }
        self.memory.is_cut()
    }

    /// The device, whatever its memory holds.
    #[must_use]
    pub const fn device(&self) -> &BusDevice {
        &self.device
    }

    /// What it was built as.
    #[must_use]
    pub const fn unit(&self) -> &Unit {
        self.device.unit()
    }

    /// The encoder, while it is on.
    #[must_use]
    pub const fn encoder(&self) -> Option<&Encoder> {
        self.device.encoder()
    }

    /// Its memory.
    #[must_use]
    pub const fn memory(&self) -> &Eeprom {
        &self.memory
    }

    /// Its memory, to be made to fail.
    pub const fn memory_mut(&mut self) -> &mut Eeprom {
        &mut self.memory
    }

    /// The memory as it would be if the supply failed now: with the turn count of the last sample. What a state
    /// file holds.
    #[must_use]
    pub fn memory_at_power_off(&self) -> Eeprom {
        let mut memory = self.memory.clone();
        if let Some(encoder) = self.encoder().cloned() {
            encoder.power_off(&mut memory);
        }
        memory
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use encoring_words::Model;
    use encoring_words::model::Sensor;

    #[test]
    fn a_power_cut_switches_the_encoder_off_whoever_looks_at_it_first() {
        let unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }).unwrap();
        for cut_before_power_up in [false, true] {
            let mut node = Node::new(unit);
            let around = Surroundings::default();
            if !cut_before_power_up {
                node.step(Instant(0), OutWord(0), &around);
            }
            node.memory_mut().cut_after(0);
            assert_eq!(node.ssi_clock(Instant(1), Level::High, &around), Level::Low);
            assert!(node.encoder().is_none());
            assert_eq!(node.step(Instant(2), OutWord(0), &around), None);
            node.supply(Instant(2), 0);
            assert!(node.step(Instant(3), OutWord(0), &around).is_some(), "back with the supply");
        }
    }
}
