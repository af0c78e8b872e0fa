//! What a master says of its ring: the diagnostic status register, the diagnostic parameter and counters.

use core::fmt;

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

/// The bits of the diagnostic status register from the highest down, with their names.
pub const STATUS_BITS: [(u16, &str); 16] = [
    (status::SS_INFO, "SS_INFO"),
    (status::QUALITY, "QUALITY"),
    (status::WARN, "WARN"),
    (status::DC_RESULT, "DC_RESULT"),
    (status::SY_RESULT, "SY_RESULT"),
    (status::RESULT, "RESULT"),
    (status::BASP, "BASP"),
    (status::BSA, "BSA"),
    (status::READY, "READY"),
    (status::ACTIVE, "ACTIVE"),
    (status::RUN, "RUN"),
    (status::DETECT, "DETECT"),
    (status::CTRL, "CTRL"),
    (status::BUS, "BUS"),
    (status::PF, "PF"),
    (status::USER, "USER"),
];

/// The names of the bits that are set in a diagnostic status register.
pub fn names(status: u16) -> impl Iterator<Item = &'static str> {
    STATUS_BITS.into_iter().filter(move |(bit, _)| status & bit != 0).map(|(_, name)| name)
}

/// A diagnostic parameter as a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DiagnosticParameter(pub u16);

impl fmt::Display for DiagnosticParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            0 => f.write_str("nothing to tell"),
            PERIPHERAL_FAULT => f.write_str("a module reports a peripheral fault"),
            SEARCHING => f.write_str("the fault is looked for, the outputs are reset"),
            NOTHING_FOUND => f.write_str("the bus failed, and no place was found"),
            other => match (other >> 8, other as u8) {
                (0, INTERFACE_BYTE) => f.write_str("the master's outgoing interface"),
                (device, INTERFACE_BYTE) => write!(f, "the outgoing interface of device {device}.0"),
                (device, below) if below & INTERFACE_BYTE != 0 => {
                    write!(f, "another interface of device {device}.0")
                }
                (device, position) => write!(f, "device {device}.{position}"),
            },
        }
    }
}

/// DiagnosticParameter: a module reports a peripheral fault.
pub const PERIPHERAL_FAULT: u16 = 0x0BB1;
/// DiagnosticParameter: the master looks for the fault, and the outputs are reset.
pub const SEARCHING: u16 = 0x0BDF;
/// DiagnosticParameter: the bus failed and nothing was found.
pub const NOTHING_FOUND: u16 = 0x0BE1;

/// The low byte of a parameter: the fault is at an interface, at that of the outgoing remote bus.
pub const INTERFACE: u16 = 0x80;
const INTERFACE_BYTE: u8 = INTERFACE as u8;

/// Where the ring is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultPlace {
    /// Check words or telegrams are bad on a segment; the one after the last device leads home.
    Segment(usize),
    /// The ring ends before a segment: the interface of the device before it leads nowhere.
    Break(usize),
    /// A device is another one than was configured.
    Device(usize),
    /// Nobody answers at all.
    Nowhere,
}

impl FaultPlace {
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

impl fmt::Display for FaultPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Segment(0) => f.write_str("telegrams are bad on segment 0, behind the master"),
            Self::Segment(segment) => {
                write!(f, "telegrams are bad on segment {segment}, behind device {segment}.0")
            }
            Self::Break(0) | Self::Nowhere => {
                f.write_str("nobody answers: the way out of the master or the way home is broken")
            }
            Self::Break(segment) => {
                write!(f, "the ring ends behind device {segment}.0: nobody answers on segment {segment}")
            }
            Self::Device(position) => {
                write!(f, "device {}.0 is not the one that was configured", position + 1)
            }
        }
    }
}

/// The two diagnostic registers, as far as they were read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Diagnosis {
    /// The diagnostic status.
    pub status: Option<u16>,
    /// The diagnostic parameter.
    pub parameter: Option<u16>,
}

impl Diagnosis {
    /// Whether data cycles run and reach the device at a position; `None` if the status was not read.
    ///
    /// A master that goes on in front of a break says that it runs and that the bus has a fault; only those devices are
    /// reached then.
    #[must_use]
    pub fn reaches(self, position: usize) -> Option<bool> {
        let status = self.status?;
        let runs = status & status::RUN != 0 && status & status::DETECT == 0;
        Some(match self.place() {
            _ if status & status::BUS == 0 => runs,
            Some(FaultPlace::Break(segment)) => runs && position < segment,
            _ => false,
        })
    }

    /// Where the ring is at fault, if the registers say so. That the way home is bad cannot be told from a break behind
    /// the last device.
    #[must_use]
    pub fn place(self) -> Option<FaultPlace> {
        let status = self.status.unwrap_or_default();
        let [device, below] = self.parameter?.to_be_bytes();
        match (self.parameter?, usize::from(device).checked_sub(1)) {
            (PERIPHERAL_FAULT | SEARCHING, _) => None,
            (NOTHING_FOUND, _) => Some(FaultPlace::Nowhere),
            _ if below == INTERFACE_BYTE => Some(FaultPlace::Break(usize::from(device))),
            (_, None) => None,
            _ if below & INTERFACE_BYTE != 0 => None,
            (_, Some(position)) if status & status::USER != 0 => Some(FaultPlace::Device(position)),
            // A module with a fault of its own leaves the line as it is.
            _ if status & (status::PF | status::BUS) == status::PF => None,
            (_, Some(segment)) => Some(FaultPlace::Segment(segment)),
        }
    }

    /// The segment that the fault is on.
    #[must_use]
    pub fn segment(self) -> Option<usize> {
        match self.place()? {
            FaultPlace::Segment(segment) | FaultPlace::Break(segment) => Some(segment),
            FaultPlace::Device(_) | FaultPlace::Nowhere => None,
        }
    }

    /// The number of the device that the parameter names, and its place there: `(3, 0)` is device 3.0.
    #[must_use]
    pub fn device(self) -> Option<(u8, u8)> {
        let [device, below] = self.parameter?.to_be_bytes();
        let names = device > 0 && !matches!(self.parameter?, PERIPHERAL_FAULT | SEARCHING | NOTHING_FOUND);
        names.then_some((device, if below & INTERFACE_BYTE == 0 { below } else { 0 }))
    }
}

/// What a person must know: whether the ring runs, and where it is at fault.
impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let has = |bit| self.status.is_some_and(|status| status & bit != 0);
        f.write_str(match self.reaches(0) {
            None => "whether the ring runs is not told",
            Some(true) if has(status::BUS) => "the ring runs up to a fault",
            Some(true) => "the ring runs",
            Some(false) => "the ring stands still",
        })?;
        match self.place() {
            Some(FaultPlace::Break(segment @ 1..)) => {
                write!(f, ": it is broken or bad on segment {segment}, behind device {segment}.0")?;
            }
            Some(place) => write!(f, ": {place}")?,
            None if self.parameter.is_none_or(|parameter| parameter == 0) => {}
            None => write!(f, ": {}", DiagnosticParameter(self.parameter.unwrap_or_default()))?,
        }
        if self.status.is_some_and(|status| status & status::READY == 0) {
            f.write_str("; the master does not say that it works")?;
        }
        let marks = [
            (status::PF, "a module reports a peripheral fault"),
            (status::CTRL, "the master itself has a fault"),
            (status::BSA, "a segment is switched off"),
            (status::BASP, "the outputs are disabled"),
            (status::QUALITY, "20 of a million data cycles were faulty"),
            (status::WARN, "a warning time passed"),
        ];
        let told = |bit| bit == status::PF && self.parameter == Some(PERIPHERAL_FAULT);
        for (_, mark) in marks.into_iter().filter(|(bit, _)| has(*bit) && !told(*bit)) {
            write!(f, "; {mark}")?;
        }
        match (self.status, self.parameter) {
            (Some(status), Some(parameter)) => write!(f, " (status {status:04X}, parameter {parameter:04X})"),
            (Some(status), None) => write!(f, " (status {status:04X})"),
            (None, Some(parameter)) => write!(f, " (parameter {parameter:04X})"),
            (None, None) => Ok(()),
        }
    }
}

/// What a master has counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Data cycles run.
    pub cycles: u64,
    /// Of these, not good throughout.
    pub faulty: u64,
    /// Searches begun.
    pub searches: u64,
    segments: [u32; DEVICES_MAX + 1],
    /// Faulty cycles in a row whose place only an ID cycle or a search can tell.
    unplaced: u32,
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
            unplaced: 0,
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
        self.unplaced = 0;
        self.turn_window();
    }

    pub(crate) const fn bad(&mut self) {
        self.cycles += 1;
        self.faulty += 1;
        self.window_faulty += 1;
        self.turn_window();
    }

    /// A faulty cycle that did not come home, or whose end word did not.
    pub(crate) const fn without_place(&mut self) {
        self.bad();
        self.unplaced = self.unplaced.saturating_add(1);
    }

    pub(crate) fn located(&mut self, segment: usize) {
        self.add(segment, 1);
    }

    /// An ID cycle or a search has found where the cycles without a place were spoilt.
    pub(crate) fn found(&mut self, segment: usize) {
        let unplaced = core::mem::take(&mut self.unplaced);
        self.add(segment, unplaced);
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
        assert_eq!(FaultPlace::Segment(0).parameter(3), 0x0100);
        assert_eq!(FaultPlace::Segment(2).parameter(3), 0x0300);
        assert_eq!(FaultPlace::Segment(3).parameter(3), 0x0380, "home: the interface of the last device");
        assert_eq!(FaultPlace::Break(0).parameter(3), 0x0080, "the master's own interface");
        assert_eq!(FaultPlace::Break(2).parameter(3), 0x0280);
        assert_eq!(FaultPlace::Device(1).parameter(3), 0x0200);
        assert_eq!(FaultPlace::Nowhere.parameter(3), 0x0BE1);
    }

    extern crate std;
    use std::string::ToString;

    #[test]
    fn registers_are_told_in_words() {
        assert_eq!(names(0x00E0).collect::<std::vec::Vec<_>>(), ["READY", "ACTIVE", "RUN"]);
        assert_eq!(STATUS_BITS.iter().fold(0, |all, (bit, _)| all | bit), 0xFFFF);
        for (parameter, told) in [
            (0, "nothing to tell"),
            (0x0301, "device 3.1"),
            (0x0080, "the master's outgoing interface"),
            (0x0280, "the outgoing interface of device 2.0"),
            (0x0281, "another interface of device 2.0"),
            (PERIPHERAL_FAULT, "a module reports a peripheral fault"),
            (SEARCHING, "the fault is looked for, the outputs are reset"),
            (NOTHING_FOUND, "the bus failed, and no place was found"),
        ] {
            assert_eq!(DiagnosticParameter(parameter).to_string(), told);
        }
        assert_eq!(
            FaultPlace::Break(2).to_string(),
            "the ring ends behind device 2.0: nobody answers on segment 2"
        );
        assert_eq!(FaultPlace::Device(2).to_string(), "device 3.0 is not the one that was configured");
    }

    #[test]
    fn both_registers_together_say_whether_the_ring_runs_and_where_it_is_at_fault() {
        let both = |status, parameter| Diagnosis { status: Some(status), parameter: Some(parameter) };
        for (status, parameter, segment, device, told) in [
            (0x00E0, 0, None, None, "the ring runs"),
            (0x10E0, 0, None, None, "the ring runs"),
            (
                0x1090,
                SEARCHING,
                None,
                None,
                "the ring stands still: the fault is looked for, the outputs are reset",
            ),
            (
                0x1094,
                0x0300,
                Some(2),
                Some((3, 0)),
                "the ring stands still: telegrams are bad on segment 2, behind device 2.0",
            ),
            (
                0x1094,
                0x0280,
                Some(2),
                Some((2, 0)),
                "the ring stands still: it is broken or bad on segment 2, behind device 2.0",
            ),
            (
                0x1095,
                0x0200,
                None,
                Some((2, 0)),
                "the ring stands still: device 2.0 is not the one that was configured",
            ),
            (
                0x1094,
                NOTHING_FOUND,
                None,
                None,
                "the ring stands still: nobody answers: the way out of the master or the way home is broken",
            ),
            (
                0x00E4,
                0x0280,
                Some(2),
                Some((2, 0)),
                "the ring runs up to a fault: it is broken or bad on segment 2, behind device 2.0",
            ),
            (0x00E2, PERIPHERAL_FAULT, None, None, "the ring runs: a module reports a peripheral fault"),
            (
                0x00E2,
                0x0301,
                None,
                Some((3, 1)),
                "the ring runs: device 3.1; a module reports a peripheral fault",
            ),
            (0x40E0, 0, None, None, "the ring runs; 20 of a million data cycles were faulty"),
            (0, 0, None, None, "the ring stands still; the master does not say that it works"),
        ] {
            let diagnosis = both(status, parameter);
            assert_eq!((diagnosis.segment(), diagnosis.device()), (segment, device), "{diagnosis}");
            let words = std::format!("{told} (status {status:04X}, parameter {parameter:04X})");
            assert_eq!(diagnosis.to_string(), words);
        }
    }

    #[test]
    fn a_device_is_reached_while_data_cycles_run_and_no_break_is_in_front_of_it() {
        let reached = |status, parameter| {
            let diagnosis = Diagnosis { status, parameter };
            [0, 1, 2].map(|position| diagnosis.reaches(position))
        };
        assert_eq!(reached(Some(0x00E0), None), [Some(true); 3]);
        assert_eq!(reached(Some(0x1090), Some(SEARCHING)), [Some(false); 3]);
        assert_eq!(reached(Some(0x1094), Some(0x0280)), [Some(false); 3]);
        assert_eq!(reached(Some(0x00C0), None), [Some(false); 3], "no data cycles yet");
        assert_eq!(reached(Some(0x00E4), Some(0x0280)), [Some(true), Some(true), Some(false)]);
        assert_eq!(reached(Some(0x00E4), None), [Some(false); 3]);
        assert_eq!(reached(None, Some(0x0280)), [None; 3]);
    }

    #[test]
    fn every_pair_of_registers_has_words() {
        for parameter in 0..=u16::MAX {
            for status in [0x00E0, 0x1094, 0x1095, 0x00E2] {
                let diagnosis = Diagnosis { status: Some(status), parameter: Some(parameter) };
                assert!(diagnosis.to_string().starts_with("the ring "));
                // What a place is told by leads back to it.
                if let Some(place) = diagnosis.place().filter(|place| *place != FaultPlace::Nowhere) {
                    assert_eq!(place.parameter(usize::MAX) | parameter & 0x7F, parameter, "{diagnosis}");
                }
            }
        }
    }

    #[test]
    fn cycles_without_a_place_count_on_a_segment_once_it_is_found() {
        let mut counts = Counts::default();
        counts.without_place();
        counts.good();
        for _ in 0..3 {
            counts.without_place();
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
