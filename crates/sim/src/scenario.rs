//! Scenario files: which encoders hang on the ring, how they move, and what happens to them when.
//!
//! The file is read in two steps: TOML into tables that refuse unknown keys, then tables into values that exist.
//! Every error names file, line, value and limit, and nothing is half read.

use std::path::Path;

use encoring_encoder::{Magnet, Unit};
use encoring_files::toml_text::{self, Misfit, Wrong};
use encoring_files::{line_at, read_text};
use encoring_ring::slave::Jumper;
use encoring_ring::{CycleTime, Ident};
use encoring_words::model::{MODELS, Series};
use encoring_words::{Duration, Instant, Model};

use crate::fault::{Fault, SsiTrouble};
use crate::memory::CellFault;
use crate::motion::Motion;
use crate::ssi::{PlacedReader, SsiSettings};
use tables::{FileTable, GatewayFaultTable, devices};

mod limits;
mod occurrence;
mod reader;
mod recorded;
mod tables;

pub use occurrence::Occurrence;
pub use reader::SsiTable;
pub use recorded::MotionFiles;
pub use tables::{EepromTable, MotionTable, MoveTable, SetTable};

/// The scenario of the built-in ring, as text.
pub const BUILT_IN: &str = include_str!("built_in.toml");

/// The largest scenario file, in bytes.
pub const FILE_BYTES_MAX: u64 = 1 << 20;

/// The most rows of all recorded motions together; a file that is named more than once counts once.
pub const MOTION_ROWS_MAX: usize = 1_000_000;

/// The largest file of a recorded motion, in bytes.
pub const MOTION_BYTES_MAX: u64 = 1 << 28;

/// The highest voltage that can be set, in volts.
pub const VOLTS_MAX: f64 = 1_000.0;

/// The longest time in a scenario, in seconds: some 31 years.
pub const SECONDS_MAX: f64 = 1e9;

/// Why a ring is not told its level, as older scenarios did.
pub const NO_LEVEL: &str = "there is one kind of ring now, with a master that searches: it runs every bit where one can matter; leave this out";

/// The fastest even speed, in steps or micrometres a second.
pub const PER_S_MAX: f64 = 1e9;

/// A ring with what happens to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Where all chance comes from.
    pub seed: u64,
    /// What the cycle time depends on.
    pub cycle_time: CycleTime,
    /// Data cycles in a million that fail on a segment picked by chance.
    pub faulty_per_million: u32,
    /// The encoders, by ring position.
    pub devices: Vec<Device>,
    /// What happens, in order of time.
    pub events: Vec<Event>,
    /// How the gateway before the ring misbehaves. What the texts mean the gateway knows.
    pub gateway_faults: Vec<GatewayFaultText>,
    /// What was assumed of the files of recorded motions, a line each. Whoever starts the ring should be told.
    pub notes: Vec<String>,
}

/// A fault of the gateway before a ring, as a scenario's `[[gateway_fault]]` has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GatewayFaultText {
    /// The line of the file, from 1.
    pub line: usize,
    /// What stands there.
    pub fault: String,
}

/// One encoder of the ring.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    /// What it was built as.
    pub unit: Unit,
    /// How it moves from the start.
    pub motion: Motion,
    /// The reader on its SSI, if one hangs there from the start.
    pub ssi: Option<SsiSettings>,
}

/// Something that happens at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub at: Instant,
    /// What.
    pub what: Happening,
}

/// What can happen.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// To one encoder.
    Device {
        /// Its ring position.
        position: usize,
        /// What changes, in order.
        changes: Vec<Change>,
    },
    /// To a segment of the ring.
    Line {
        /// 0..=encoders.
        segment: usize,
        /// What it suffers; a fault of a device does nothing to a line.
        fault: Fault,
        /// For how long.
        lasting: Duration,
    },
}

/// One change to what surrounds an encoder, or to its memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Voltage on a preset input, 0 or 1.
    Preset {
        /// Which input.
        input: usize,
        /// In millivolts.
        millivolts: u32,
    },
    /// Supply in millivolts.
    Supply(u32),
    /// The magnet is taken away or put back.
    Magnet(Magnet),
    /// Another motion.
    Motion(NewMotion),
    /// A cell, or all, begins to fail.
    MemoryFault(CellFault, Option<usize>),
    /// The memory is sound again.
    MemoryRepair,
    /// The power goes after so many more bytes written.
    PowerCut(u64),
    /// The reset input of the protocol chip is held or let go.
    Chip(Chip),
    /// The jumper in the outgoing plug is there or missing [R137].
    Jumper(Jumper),
    /// The chip shows another identification word.
    Ident(Ident),
    /// Another reader hangs on its SSI, or none.
    Ssi(Option<SsiSettings>),
    /// The line of its SSI is troubled, or sound again.
    SsiTrouble(Option<SsiTrouble>),
}

/// The reset input of a protocol chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Chip {
    /// It works.
    #[default]
    Running,
    /// It is held in reset: nothing passes, and the lamp U is on.
    Held,
}

/// A motion that may begin where the last one is.
#[derive(Clone, Debug, PartialEq)]
pub enum NewMotion {
    /// As told.
    Motion(Motion),
    /// It stops where it is.
    Stop,
    /// It goes on from where it is with this many millionths a second.
    Onward(i64),
}

/// Why a scenario was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {problem}", .line.map(|line| format!(" line {line}")).unwrap_or_default())]
pub struct ScenarioError {
    /// The file, as it was named.
    pub file: String,
    /// The line, where one is at fault.
    pub line: Option<usize>,
    /// What is wrong: value and limit.
    pub problem: String,
}

impl Scenario {
    /// The built-in ring: an LA-66 of 500 mm, a CE-100-M and a CE-65-M, all moving.
    ///
    /// # Errors
    /// None that a user could cause: the text is part of the program and tested.
    pub fn built_in() -> Result<Self, ScenarioError> {
        Self::parse("built-in scenario", BUILT_IN, Path::new(""))
    }

    /// Reads a scenario file; files that it names are looked for beside it.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the place.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let file = path.display().to_string();
        match read_text(path, FILE_BYTES_MAX) {
            Ok(text) => Self::parse(&file, &text, path.parent().unwrap_or(Path::new(""))),
            Err(cause) => Err(ScenarioError { file, line: cause.line(), problem: cause.to_string() }),
        }
    }

    /// Reads a scenario from text. `beside` is the folder of files that it names.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the place.
    pub fn parse(file: &str, text: &str, beside: &Path) -> Result<Self, ScenarioError> {
        let read = toml_text::parse(text)
            .and_then(|table| Self::of(&table, text, beside).map_err(|wrong| wrong.in_text(text)));
        read.map_err(|Misfit { line, problem }| ScenarioError { file: file.to_owned(), line, problem })
    }

    /// Hangs a reader on the SSI of an encoder, in place of one that the file has there.
    ///
    /// # Errors
    /// What is wrong with the place, and which are right; then nothing is changed.
    pub fn hang_reader(&mut self, reader: PlacedReader) -> Result<(), String> {
        self.has_ssi(reader.position)?;
        if let Some(device) = self.devices.get_mut(reader.position) {
            device.ssi = Some(reader.settings);
        }
        Ok(())
    }

    /// Refuses a position without an encoder that has an SSI.
    fn has_ssi(&self, position: usize) -> Result<(), String> {
        let with = |device: &Device| device.unit.model().has_ssi_output();
        match self.devices.get(position) {
            Some(device) if with(device) => return Ok(()),
            _ => {}
        }
        let found = match self.devices.get(position) {
            Some(device) => format!("position {position} is a {}, which has no SSI", device.unit.model()),
            None => format!("position {position} is not on the ring"),
        };
        let places: Vec<usize> =
            self.devices.iter().enumerate().filter(|(_, device)| with(device)).map(|(at, _)| at).collect();
        let models: Vec<Model> = MODELS.into_iter().filter(|model| model.has_ssi_output()).collect();
        Err(match places[..] {
            [] => format!("{found}; put a {} into the scenario", Series(&models, "or")),
            _ => format!("{found}; there is one at position {}", Series(&places, "or")),
        })
    }

    fn of(table: &FileTable, text: &str, beside: &Path) -> Result<Self, Wrong> {
        if table.version != 1 {
            let problem = format!("version {}; this program reads version 1", table.version);
            return Err(Wrong::at("version", problem));
        }
        let (cycle_time, faulty_per_million) = match &table.ring {
            None => (CycleTime::default(), 0),
            Some(ring) => ring.read().map_err(|wrong| wrong.inside("ring"))?,
        };
        let mut files = MotionFiles::beside(beside);
        let devices = devices(&table.device, &mut files)?;
        let mut events = Vec::new();
        for (index, event) in table.event.iter().enumerate() {
            let read = event.read(&devices, &mut files);
            events.push(read.map_err(|wrong| wrong.inside_item(index).inside("event"))?);
        }
        // Stable: events at the same time happen in the order of the file.
        events.sort_by_key(|event| event.at);
        let gateway_faults = table.gateway_fault.iter().map(|GatewayFaultTable { fault }| GatewayFaultText {
            line: line_at(text, fault.span().start),
            fault: fault.get_ref().clone(),
        });
        let gateway_faults = gateway_faults.collect();
        let notes = files.into_notes();
        Ok(Self { seed: table.seed, cycle_time, faulty_per_million, devices, events, gateway_faults, notes })
    }
}

#[cfg(test)]
mod tests;
