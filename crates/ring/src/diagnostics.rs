//! What a master says of its ring: the diagnostic status register, the diagnostic parameter and counters.

use crate::profile::{DEVICES_MAX, QUALITY_CYCLES, QUALITY_FAULTY};

/// Bits of the diagnostic status register.
pub mod status {
    /// The configuration does not fit the ring.
    pub const USER: u16 = 0x0001;
    /// A module reports a peripheral fault.
    pub const PF: u16 = 0x0002;
    /// The bus stopped on a fault.
    pub const BUS: u16 = 0x0004;
    /// The master itself has a fault.
    pub const CTRL: u16 = 0x0008;
    /// The master looks for a fault.
    pub const DETECT: u16 = 0x0010;
    /// Data cycles run.
    pub const RUN: u16 = 0x0020;
    /// The configuration is known and ID cycles run.
    pub const ACTIVE: u16 = 0x0040;
    /// The master works.
    pub const READY: u16 = 0x0080;
    /// A bus segment is switched off.
    pub const BSA: u16 = 0x0100;
    /// Outputs are disabled.
    pub const BASP: u16 = 0x0200;
    /// The last service failed.
    pub const RESULT: u16 = 0x0400;
    /// The last synchronisation failed.
    pub const SY_RESULT: u16 = 0x0800;
    /// The last data cycle was faulty.
    pub const DC_RESULT: u16 = 0x1000;
    /// A warning time passed.
    pub const WARN: u16 = 0x2000;
    /// 20 of a million data cycles were faulty.
    pub const QUALITY: u16 = 0x4000;
    /// More is said in the parameter register.
    pub const SS_INFO: u16 = 0x8000;
}

/// Parameter: a module reports a peripheral fault.
pub const PERIPHERAL_FAULT: u16 = 0x0BB1;
/// Parameter: the master looks for the fault, and the outputs are reset.
pub const SEARCHING: u16 = 0x0BDF;
/// Parameter: the bus failed and nothing was found.
pub const NOTHING_FOUND: u16 = 0x0BE1;

/// The low byte of a parameter: the fault is at an interface, at that of the outgoing remote bus.
pub const INTERFACE: u16 = 0x80;

/// Where the ring is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Check words or telegrams are bad on a segment; the one after the last device leads home.
    Segment(usize),
    /// The ring ends before a segment: the interface of the device before it leads nowhere.
    Break(usize),
    /// A device is another one than was configured.
    Device(usize),
    /// Nobody answers at all.
    Nowhere,
}

impl Place {
    /// The diagnostic parameter: the device number in the high byte, where device numbers count from 1 and the master
    /// is 0; the position in the segment, or the interface, in the low byte.
    #[must_use]
    pub fn parameter(self, devices: usize) -> u16 {
        let number = |device: usize| (device.min(0xFF) as u16) << 8;
        match self {
            Self::Segment(segment) if segment < devices => number(segment + 1),
            Self::Segment(_) => number(devices) | INTERFACE,
            Self::Break(segment) => number(segment) | INTERFACE,
            Self::Device(position) => number(position + 1),
            Self::Nowhere => NOTHING_FOUND,
        }
    }
}

/// What a master has counted.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Data cycles run.
    pub cycles: u64,
    /// Of these, not good throughout.
    pub faulty: u64,
    /// Searches begun.
    pub searches: u64,
    segments: [u32; DEVICES_MAX + 1],
    /// Silent cycles in a row: where, only a search can tell.
    silent: u32,
    window_cycles: u32,
    window_faulty: u32,
    poor: bool,
}

impl Default for Counts {
    fn default() -> Self {
        Self {
            cycles: 0,
            faulty: 0,
            searches: 0,
            segments: [0; DEVICES_MAX + 1],
            silent: 0,
            window_cycles: 0,
            window_faulty: 0,
            poor: false,
        }
    }
}

impl Counts {
    /// Faulty cycles that were located on a segment.
    #[must_use]
    pub fn segment(&self, segment: usize) -> u32 {
        self.segments.get(segment).copied().unwrap_or_default()
    }

    /// Those of every segment, by its number.
    pub fn segments(&self) -> impl Iterator<Item = u32> {
        self.segments.iter().copied()
    }

    /// The last million data cycles had 20 faulty ones, or these have them already.
    #[must_use]
    pub const fn is_poor(&self) -> bool {
        self.poor || self.window_faulty >= QUALITY_FAULTY
    }

    pub(crate) const fn good(&mut self) {
        self.cycles += 1;
        self.silent = 0;
        self.turn_window();
    }

    pub(crate) const fn bad(&mut self) {
        self.cycles += 1;
        self.faulty += 1;
        self.window_faulty += 1;
        self.turn_window();
    }

    /// A faulty cycle that did not come home.
    pub(crate) const fn silent(&mut self) {
        self.bad();
        self.silent = self.silent.saturating_add(1);
    }

    pub(crate) fn located(&mut self, segment: usize) {
        self.add(segment, 1);
    }

    /// A search has found where the silent cycles broke off.
    pub(crate) fn found(&mut self, segment: usize) {
        let silent = core::mem::take(&mut self.silent);
        self.add(segment, silent);
    }

    fn add(&mut self, segment: usize, cycles: u32) {
        if let Some(count) = self.segments.get_mut(segment) {
            *count = count.saturating_add(cycles);
        }
    }

    const fn turn_window(&mut self) {
        self.window_cycles += 1;
        if self.window_cycles >= QUALITY_CYCLES {
            self.poor = self.window_faulty >= QUALITY_FAULTY;
            self.window_cycles = 0;
            self.window_faulty = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_told_by_the_number_of_its_device() {
        assert_eq!(Place::Segment(0).parameter(3), 0x0100);
        assert_eq!(Place::Segment(2).parameter(3), 0x0300);
        assert_eq!(Place::Segment(3).parameter(3), 0x0380, "home: the interface of the last device");
        assert_eq!(Place::Break(0).parameter(3), 0x0080, "the master's own interface");
        assert_eq!(Place::Break(2).parameter(3), 0x0280);
        assert_eq!(Place::Device(1).parameter(3), 0x0200);
        assert_eq!(Place::Nowhere.parameter(3), 0x0BE1);
    }

    #[test]
    fn silent_cycles_count_on_a_segment_once_a_search_has_found_it() {
        let mut counts = Counts::default();
        counts.silent();
        counts.good();
        for _ in 0..3 {
            counts.silent();
        }
        assert!(counts.segments().all(|count| count == 0));
        counts.found(2);
        assert_eq!(
            (counts.segment(2), counts.faulty),
            (3, 4),
            "what was over before the search has no place"
        );
        counts.found(2);
        assert_eq!(counts.segment(2), 3);
    }

    #[test]
    fn twenty_faulty_cycles_in_a_million_are_poor_quality() {
        let mut counts = Counts::default();
        for _ in 0..QUALITY_FAULTY - 1 {
            counts.bad();
        }
        assert!(!counts.is_poor());
        counts.bad();
        assert!(counts.is_poor());
        for _ in 0..QUALITY_CYCLES {
            counts.good();
        }
        assert!(counts.is_poor(), "the window in which it was poor has just ended");
        for _ in 0..QUALITY_CYCLES {
            counts.good();
        }
        assert!(!counts.is_poor());
    }
}
