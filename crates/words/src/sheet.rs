//! The data sheets: what the manuals state of pins, lamps, supply, lines and mechanics, and nothing where a manual
//! is silent [R12].

use crate::time::Duration;

mod entries;
mod rules;
#[cfg(test)]
mod tests;

pub use entries::PRESET_INPUT;
pub(crate) use entries::{CE_65_M, CE_100_M, LA_66};

/// What a manual states about its device. `None` where it says nothing; a sibling's figure is never filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataSheet {
    /// Number and date of the manual.
    pub document: &'static str,
    /// Its editions, the oldest first [R159..R161].
    pub revisions: &'static [Revision],
    /// Where it states what belongs to a section.
    pub chapters: &'static [(Section, &'static str)],
    /// What the encoder is.
    pub device: &'static str,
    /// The standard that its bus follows [R11].
    pub standard: Option<&'static str>,
    /// What the protocol chip does [R6].
    pub chip: Option<&'static str>,
    /// Steps of the sensor, as the rating plate has them [R99, R100].
    pub resolution: &'static str,
    /// How far it measures [R49, R99, R100, C5].
    pub range: &'static str,
    /// How many bits it tells apart [R99, R100, C17].
    pub capacity: Option<&'static str>,
    /// Code of the position [R99, R100].
    pub code: Option<&'static str>,
    /// Where it keeps its parameters [R97, R98].
    pub memory: Option<&'static str>,
    /// Ident code on the ring [R2].
    pub ident_code: u8,
    /// Words in each direction [R3].
    pub words: u8,
    /// Refresh of the position [R8, R9].
    pub refresh: Option<Duration>,
    /// Transfer rate in kBaud, gross and net [R7].
    pub kilobaud: Option<(u16, u16)>,
    /// What the interface is electrically [R10].
    pub interface: Option<&'static str>,
    /// Supply, the ripple and the current it draws [R121, R122].
    pub supply: Option<Supply>,
    /// Thresholds of the preset inputs [R71].
    pub preset_input: Option<PresetInputLevels>,
    /// The SSI output [R103..R105].
    pub ssi: Option<SsiSheet>,
    /// Levels of its signals, whether a pin has them or not [R129, C27].
    pub signals: &'static [SignalLevels],
    /// Temperatures in degrees Celsius [R123].
    pub temperature: Option<Temperatures>,
    /// Mechanical limits [R124..R128].
    pub mechanics: Option<Mechanics>,
    /// Connectors with their pins [R131..R136].
    pub connectors: &'static [Connector],
    /// The two pins that a plug must join so that the next device is found [R137, C33].
    pub next_device_jumper: Option<(&'static str, u8, u8)>,
    /// What else is said of the wiring [R130, R133, R137, R138].
    pub wiring: &'static [&'static str],
    /// What else is said of the services [R49, R53, R69, C4, C7, C8].
    pub programming: &'static [&'static str],
    /// Lamps [R139, C34].
    pub lamps: &'static [Lamp],
    /// Why the position steps although the shaft does not [R150..R153].
    pub step_changes: &'static [StepChange],
    /// What to look at before it is switched on [R145..R149].
    pub check_list: &'static [Rule],
    /// What whoever uses its position must know [R140..R144].
    pub safety: &'static [Rule],
}

/// A part of a data sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// What it is, and which manual says so.
    Data,
    /// Connectors and pins.
    Pins,
    /// Lamps and what they mean.
    Lamps,
    /// Services with their words and values.
    Services,
    /// Error status with remedies.
    Status,
    /// Faults with causes and remedies.
    Faults,
    /// What to look at before switching on.
    Checklist,
    /// What its position may be used for.
    Safety,
    /// Supply, climate, mechanics.
    Limits,
    /// Levels of inputs and outputs.
    Levels,
    /// The SSI output.
    Ssi,
}

/// Every section, in the order of a data sheet.
pub const SECTIONS: [Section; 11] = [
    Section::Data,
    Section::Pins,
    Section::Lamps,
    Section::Services,
    Section::Status,
    Section::Faults,
    Section::Checklist,
    Section::Safety,
    Section::Limits,
    Section::Levels,
    Section::Ssi,
];

impl Section {
    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Data => "data",
            Self::Pins => "pins",
            Self::Lamps => "lamps",
            Self::Services => "services",
            Self::Status => "status",
            Self::Faults => "faults",
            Self::Checklist => "checklist",
            Self::Safety => "safety",
            Self::Limits => "limits",
            Self::Levels => "levels",
            Self::Ssi => "ssi",
        }
    }

    /// Its heading.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Data => "Data sheet",
            Self::Pins => "Pins",
            Self::Lamps => "Lamps",
            Self::Services => "Services",
            Self::Status => "Error status",
            Self::Faults => "Faults, causes and remedies",
            Self::Checklist => "Check list before switching on",
            Self::Safety => "Safety",
            Self::Limits => "Limits",
            Self::Levels => "Levels",
            Self::Ssi => "SSI output",
        }
    }
}

impl DataSheet {
    /// The chapters of the manual that state a section; `None` if it is silent.
    #[must_use]
    pub fn chapters(&self, section: Section) -> Option<&'static str> {
        self.chapters.iter().find(|(of, _)| *of == section).map(|(_, chapters)| *chapters)
    }
}

/// An edition of a manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revision {
    /// Its index, where the manual gives one.
    pub index: Option<&'static str>,
    /// Its date, as the manual writes it.
    pub date: &'static str,
    /// What changed.
    pub what: &'static str,
}

/// A lamp of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lamp {
    /// Its name.
    pub name: &'static str,
    /// Its colour.
    pub colour: &'static str,
    /// What the manual says of it.
    pub stated: &'static str,
    /// What it shows while it is on [C34, D38].
    pub meaning: &'static str,
}

/// A cause of step changes, with what helps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepChange {
    /// Why the position steps.
    pub cause: &'static str,
    /// What to do about it.
    pub remedy: &'static str,
}

/// A rule of a manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// The chapter of the manual.
    pub chapter: &'static str,
    /// What it is about.
    pub about: &'static str,
    /// The rule.
    pub text: &'static str,
}

/// The supply of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supply {
    /// Lowest and highest voltage in millivolts.
    pub millivolts: (u32, u32),
    /// Residual ripple in per cent, both ways.
    pub ripple_percent: u8,
    /// Largest current in milliamperes at the lowest and at the highest voltage.
    pub milliamperes: Option<(u16, u16)>,
}

/// What counts as 0 and as 1 on a preset input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetInputLevels {
    /// Below this many millivolts: 0.
    pub low_below_mv: u32,
    /// Above this many millivolts: 1.
    pub high_above_mv: u32,
    /// Not to be exceeded, in millivolts.
    pub max_mv: u32,
}

/// The SSI output's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiSheet {
    /// Clock rate in hertz, guaranteed from..to.
    pub clock_hz: (u32, u32),
    /// Clock rate in hertz, physically possible from..to, approximately [R111, R112].
    pub clock_hz_limit: (u32, u32),
    /// Clock input.
    pub clock_input: &'static str,
    /// Data output.
    pub data_output: &'static str,
}

/// The levels of a kind of signal, as the manual lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalLevels {
    /// Its name, as the pins use it.
    pub name: &'static str,
    /// Below this many millivolts: 0.
    pub low_below_mv: Option<u32>,
    /// Above this many millivolts: 1.
    pub high_above_mv: Option<u32>,
    /// Not to be exceeded in either direction, in millivolts.
    pub max_mv: Option<u32>,
    /// Its resistance in ohms.
    pub ohms: Option<u32>,
    /// The largest current of an output in milliamperes.
    pub milliamperes: Option<u16>,
    /// What else is said of it.
    pub remark: &'static str,
}

/// Temperatures in degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Temperatures {
    /// Operating from..to.
    pub operating: (i8, i8),
    /// Storage from..to.
    pub storage: (i8, i8),
}

/// Mechanical limits of a rotary encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mechanics {
    /// Permissible speed in revolutions per minute.
    pub speed_rpm: u32,
    /// Largest angular acceleration in rad/s^2.
    pub acceleration_rad_s2: u32,
    /// Shaft load in newtons, axial and radial, at the end of the shaft.
    pub shaft_load_n: (u16, u16),
    /// Least bearing life in revolutions, at 3000 rpm, 20 N axial, 30 N radial, 60 degrees.
    pub bearing_life_revolutions: u64,
    /// Moment of inertia in 10^-9 kg m^2.
    pub inertia_e9_kg_m2: u32,
    /// Starting torque at 20 degrees, in newton centimetres.
    pub starting_torque_ncm: u8,
    /// Vibration from 50 to 2000 Hz, in m/s^2.
    pub vibration_m_s2: u16,
    /// Shock of 11 ms, in m/s^2.
    pub shock_m_s2: u16,
}

/// A connector and its pins, counted from 1; an empty name is a free pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connector {
    /// Name and kind.
    pub name: &'static str,
    /// Signals by pin.
    pub pins: &'static [&'static str],
}
