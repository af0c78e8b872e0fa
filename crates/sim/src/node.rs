//! An encoder with its supply and its memory: what hangs at one place of the ring, and what a replay drives.

use encoring_encoder::records;
use encoring_encoder::{Encoder, Terminals, Unit};
use encoring_words::ssi_frame::Level;
use encoring_words::{InWord, Instant, OutWord};

use crate::memory::Eeprom;

/// Below this many millivolts the device is off: 11 V less 5 % ripple [R121].
pub const OFF_BELOW_MV: u32 = 10_450;

/// Above this many millivolts the supply is too high: 27 V and 5 % ripple [R121].
pub const OVERVOLTAGE_ABOVE_MV: u32 = 28_350;

/// What surrounds a device at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surroundings {
    /// Shaft or magnet, and the preset inputs.
    pub terminals: Terminals,
    /// The supply in millivolts.
    pub supply_mv: u32,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self { terminals: Terminals::default(), supply_mv: 24_000 }
    }
}

/// A device that is switched on and off.
#[derive(Clone, Debug)]
pub struct Node {
    unit: Unit,
    memory: Eeprom,
    encoder: Option<Encoder>,
    overvoltage: bool,
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
        Self { unit, memory, encoder: None, overvoltage: false }
    }

    /// One exchange; `None` while the supply is too low.
    pub fn step(&mut self, now: Instant, out: OutWord, around: &Surroundings) -> Option<InWord> {
        self.switch(now, around);
        let input = self.encoder.as_mut()?.exchange(now, out, &around.terminals, &mut self.memory);
        self.cut_off();
        self.encoder.is_some().then_some(input)
    }

    /// An edge of the SSI clock; Low while the supply is too low [R103..R120].
    pub fn ssi_clock(&mut self, now: Instant, clock: Level, around: &Surroundings) -> Level {
        self.switch(now, around);
        match &mut self.encoder {
            Some(encoder) => encoder.ssi_clock(now, clock, &around.terminals),
            None => Level::Low,
        }
    }

    /// Tells the supply between two exchanges: any time below the limit is a power-off.
    pub fn supply(&mut self, millivolts: u32) {
        self.overvoltage = millivolts > OVERVOLTAGE_ABOVE_MV;
        if millivolts < OFF_BELOW_MV {
            if let Some(encoder) = self.encoder.take() {
                encoder.power_off(&mut self.memory);
            }
            self.memory.power_back();
        }
    }

    /// Switches the encoder off or on, as the supply is.
    fn switch(&mut self, now: Instant, around: &Surroundings) {
        self.supply(around.supply_mv);
        self.cut_off();
        if self.encoder.is_none() && around.supply_mv >= OFF_BELOW_MV && !self.memory.is_cut() {
            self.encoder = Some(Encoder::power_up(&self.unit, now, &around.terminals, &mut self.memory));
            self.cut_off();
        }
    }

    /// A power cut in the middle of a write leaves the encoder no time for its turn count.
    fn cut_off(&mut self) {
        if self.memory.is_cut() {
            self.encoder = None;
        }
    }

    /// What it was built as.
    #[must_use]
    pub const fn unit(&self) -> &Unit {
        &self.unit
    }

    /// The encoder, while it is on.
    #[must_use]
    pub const fn encoder(&self) -> Option<&Encoder> {
        self.encoder.as_ref()
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

    /// `true` while the supply told last is above the limit; the device stays on.
    #[must_use]
    pub const fn overvoltage(&self) -> bool {
        self.overvoltage
    }

    /// The memory as it would be if the supply failed now: with the turn count of the last sample. What a state
    /// file holds.
    #[must_use]
    pub fn memory_at_power_off(&self) -> Eeprom {
        let mut memory = self.memory.clone();
        if let Some(encoder) = self.encoder.clone() {
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
            node.supply(0);
            assert!(node.step(Instant(3), OutWord(0), &around).is_some(), "back with the supply");
        }
    }
}
