//! The tables of a scenario file, as TOML has them, and how each becomes a value that exists.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::PathBuf;

use encoring_encoder::records::EEPROM_BYTES;
use encoring_encoder::unit::NoStaleService;
use encoring_encoder::{Magnet, ServiceTimes, Unit, ZeroLoss};
use encoring_files::toml_text::Wrong;
use encoring_ring::profile::{BIT_2M, BIT_500K};
use encoring_ring::slave::Jumper;
use encoring_ring::{CycleTime, ENCODERS_MAX};
use encoring_words::model::{ROD_UM_MAX, ROD_UM_MIN, Sensor, SensorKind};
use encoring_words::{Duration, Instant, Model, Week};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::limits::within;
use super::reader::{IdentText, SsiChange, SsiFaultText, SsiTable};
use super::{
    Change, Chip, Device, Event, Happening, MotionFiles, NO_LEVEL, NewMotion, Occurrence, PER_S_MAX,
    SECONDS_MAX, VOLTS_MAX,
};
use crate::fault::Fault;
use crate::memory::CellFault;
use crate::motion::{Motion, RAW_MAX};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileTable {
    pub(super) version: i64,
    #[serde(default)]
    pub(super) seed: u64,
    #[serde(default)]
    pub(super) ring: Option<RingTable>,
    #[serde(default)]
    pub(super) device: Vec<DeviceTable>,
    #[serde(default)]
    pub(super) event: Vec<EventTable>,
    #[serde(default)]
    pub(super) gateway_fault: Vec<GatewayFaultTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GatewayFaultTable {
    pub(super) fault: toml::Spanned<String>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RingTable {
    kbit_s: Option<u32>,
    software_us: Option<u32>,
    cable_m: u32,
    faulty_per_million: u32,
    level: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeviceTable {
    position: i64,
    model: String,
    rod_mm: Option<f64>,
    native: Option<i64>,
    firmware: Option<String>,
    service_times: Option<ServiceTimesTable>,
    zero_loss: Option<ZeroLossName>,
    stale_service: Option<String>,
    motion: Option<MotionTable>,
    ssi: Option<SsiTable>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum ZeroLossName {
    Nearest,
    Worst,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "service_times is \"zero\", \"default\", or a table of read_ms, write_ms, data_check_ms and preset_adjustment_ms"
)]
enum ServiceTimesTable {
    Name(ServiceTimesName),
    Each(ServiceTimesEach),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum ServiceTimesName {
    Zero,
    Default,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ServiceTimesEach {
    read_ms: Option<f64>,
    write_ms: Option<f64>,
    data_check_ms: Option<f64>,
    preset_adjustment_ms: Option<f64>,
}

/// A motion as written in a file or sent over the control port.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum MotionTable {
    /// `raw`, or where it is.
    Hold {
        /// Steps or micrometres.
        raw: Option<i64>,
    },
    /// `per_s` steps or micrometres a second, or `rpm`; from `start`, or from where it is.
    Speed {
        /// Steps or micrometres.
        start: Option<i64>,
        /// Steps or micrometres a second.
        per_s: Option<f64>,
        /// Turns a minute, for a shaft.
        rpm: Option<f64>,
    },
    /// A swing around `center`.
    Sine {
        /// Steps or micrometres.
        center: i64,
        /// Steps or micrometres.
        amplitude: i64,
        /// Seconds of one swing.
        period_s: f64,
    },
    /// From place to place.
    Moves {
        /// Steps or micrometres; 0 if not given.
        #[serde(default)]
        start: i64,
        /// One after the other.
        moves: Vec<MoveTable>,
        /// From the beginning again after the last.
        #[serde(default)]
        repeat: bool,
    },
    /// Columns `time_us` and `raw` of a trace.
    Csv {
        /// Beside the scenario, if not absolute.
        file: PathBuf,
    },
}

/// One move of [`MotionTable::Moves`].
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoveTable {
    /// Steps or micrometres.
    pub to: i64,
    /// Seconds on the way.
    pub in_s: f64,
    /// Seconds of rest after it.
    #[serde(default)]
    pub wait_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EventTable {
    at_s: f64,
    position: Option<i64>,
    set: Option<SetTable>,
    segment: Option<i64>,
    line: Option<Fault>,
    for_s: Option<f64>,
}

/// What is set at one encoder, in a file's event or over the control port. What is not named stays.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SetTable {
    /// Volts on preset input 1.
    pub preset1_v: Option<f64>,
    /// Volts on preset input 2.
    pub preset2_v: Option<f64>,
    /// Volts of supply.
    pub supply_v: Option<f64>,
    /// The LA-66's magnet: `true` present, `false` taken away.
    pub magnet: Option<bool>,
    /// Puts shaft or magnet at this place and holds it there.
    pub raw: Option<i64>,
    /// Another motion, from now on.
    pub motion: Option<MotionTable>,
    /// Makes the memory fail, or repairs it.
    pub eeprom: Option<EepromTable>,
    /// `true` holds the protocol chip in reset, `false` lets it go.
    pub chip_held: Option<bool>,
    /// The jumper for the next device: `true` there, `false` missing.
    pub jumper: Option<bool>,
    /// Another identification word.
    pub ident: Option<IdentText>,
    /// Another reader on the SSI, or `off`.
    pub ssi: Option<SsiChange>,
    /// A fault of the line from the SSI, or `none`.
    pub ssi_fault: Option<SsiFaultText>,
}

/// A fault of the memory.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "fault", rename_all = "lowercase", deny_unknown_fields)]
pub enum EepromTable {
    /// Reading fails, at one cell or everywhere.
    Read {
        /// 0..=511.
        cell: Option<i64>,
    },
    /// Writing fails, at one cell or everywhere.
    Write {
        /// 0..=511.
        cell: Option<i64>,
    },
    /// A cell keeps one value.
    Stuck {
        /// 0..=511.
        cell: i64,
        /// 0..=255.
        value: i64,
    },
    /// The power goes in the middle of a write, and stays off until the supply is set again.
    Cut {
        /// Bytes that are still written, at least 1.
        after_bytes: i64,
    },
    /// All faults end. With braces, so that other keys are refused.
    None {},
}

impl RingTable {
    pub(super) fn read(&self) -> Result<(CycleTime, u32), Wrong> {
        if self.level.is_some() {
            return Err(Wrong::at("level", format!("level: {NO_LEVEL}")));
        }
        let bit = match self.kbit_s.unwrap_or(500) {
            500 => BIT_500K,
            2000 => BIT_2M,
            other => return Err(Wrong::at("kbit_s", format!("kbit_s {other}; the bus has 500 or 2000"))),
        };
        within("cable_m", i64::from(self.cable_m), 0, 12_800)?;
        within("faulty_per_million", i64::from(self.faulty_per_million), 0, 1_000_000)?;
        let software_us = self.software_us.unwrap_or(200);
        within("software_us", i64::from(software_us), 0, 1_000_000)?;
        let software = Duration::from_micros(u64::from(software_us));
        Ok((CycleTime { bit, software, cable_m: self.cable_m }, self.faulty_per_million))
    }
}

pub(super) fn devices(tables: &[DeviceTable], files: &mut MotionFiles) -> Result<Vec<Device>, Wrong> {
    if tables.is_empty() {
        return Err(Wrong::new("no [[device]]; a ring holds at least one encoder"));
    }
    if tables.len() > ENCODERS_MAX {
        let problem = format!("{} encoders; the limit is {ENCODERS_MAX}", tables.len());
        return Err(Wrong::new(problem).inside_item(ENCODERS_MAX).inside("device"));
    }
    let mut by_position = BTreeMap::new();
    for (index, table) in tables.iter().enumerate() {
        let here = |wrong: Wrong| wrong.inside_item(index).inside("device");
        let position = table.position;
        // With as many positions as devices and none twice, there can be no gap.
        within("position", position, 0, tables.len() as i64 - 1)
            .map_err(|wrong| here(wrong.told(|it| format!("{it} (positions count from 0 without a gap)"))))?;
        let named = |wrong: Wrong| here(wrong.told(|it| format!("device at position {position}: {it}")));
        let device = table.read(files).map_err(named)?;
        if by_position.insert(position, device).is_some() {
            return Err(here(Wrong::at("position", format!("position {position} is taken twice"))));
        }
    }
    Ok(by_position.into_values().collect())
}

impl DeviceTable {
    fn read(&self, files: &mut MotionFiles) -> Result<Device, Wrong> {
        let mut unit = self.unit()?;
        if let Some(week) = &self.firmware {
            unit.firmware = week
                .parse::<Week>()
                .map_err(|wrong| Wrong::at("firmware", format!("firmware \"{week}\": {wrong}")))?;
        }
        if let Some(times) = &self.service_times {
            unit.service_times = times.read().map_err(|wrong| wrong.inside("service_times"))?;
        }
        if let Some(ZeroLossName::Worst) = self.zero_loss {
            unit.zero_loss = ZeroLoss::WorstAllowed;
        }
        if let Some(named) = &self.stale_service {
            unit.stale_service = named.parse().map_err(|wrong: NoStaleService| {
                Wrong::at("stale_service", format!("stale_service \"{named}\": {wrong}"))
            })?;
        }
        let motion = self.motion.as_ref().map(|motion| motion.read(&unit, files)).transpose();
        let motion = match motion.map_err(|wrong| wrong.inside("motion"))? {
            Some(NewMotion::Motion(motion)) => motion,
            Some(NewMotion::Onward(micro_per_s)) => Motion::Speed { start: 0, micro_per_s },
            Some(NewMotion::Stop) | None => Motion::Hold { raw: 0 },
        };
        let ssi = self.ssi.as_ref().map(|ssi| ssi.read(unit.model())).transpose();
        let ssi = ssi.map_err(|wrong| wrong.inside("ssi"))?;
        Ok(Device { unit, motion, ssi })
    }

    fn unit(&self) -> Result<Unit, Wrong> {
        let model: Model = self
            .model
            .parse()
            .map_err(|unknown| Wrong::at("model", format!("model \"{}\"; {unknown}", self.model)))?;
        let native = self.native.map(|native| within("native", native, 1, 65_536)).transpose()?;
        let rod_um = self.rod_mm.map(rod_um).transpose()?;
        let key = match model.sensor_kind() {
            SensorKind::Rotary if rod_um.is_none() => "native",
            SensorKind::Linear if native.is_some() => "native",
            _ => "rod_mm",
        };
        let sensor = model.sensor(native.map(|steps| steps as u32), rod_um);
        let unit = sensor.and_then(|sensor| Unit::new(model, sensor));
        unit.map_err(|wrong| Wrong::at(key, wrong.to_string()))
    }
}

impl ServiceTimesTable {
    fn read(&self) -> Result<ServiceTimes, Wrong> {
        match self {
            Self::Name(ServiceTimesName::Zero) => Ok(ServiceTimes::ZERO),
            Self::Name(ServiceTimesName::Default) => Ok(ServiceTimes::default()),
            Self::Each(each) => {
                let usual = ServiceTimes::default();
                let time = |name: &str, value: Option<f64>, usual: Duration| match value {
                    Some(ms) => within(name, ms, 0.0, 60_000.0).map(|ms| Duration((ms * 1e6).round() as u64)),
                    None => Ok(usual),
                };
                Ok(ServiceTimes {
                    read: time("read_ms", each.read_ms, usual.read)?,
                    write: time("write_ms", each.write_ms, usual.write)?,
                    data_check: time("data_check_ms", each.data_check_ms, usual.data_check)?,
                    preset_adjustment: time(
                        "preset_adjustment_ms",
                        each.preset_adjustment_ms,
                        usual.preset_adjustment,
                    )?,
                })
            }
        }
    }
}

impl MotionTable {
    fn read(&self, unit: &Unit, files: &mut MotionFiles) -> Result<NewMotion, Wrong> {
        let motion = match self {
            Self::Hold { raw: None } => return Ok(NewMotion::Stop),
            Self::Hold { raw: Some(raw) } => Motion::Hold { raw: place("raw", *raw)? },
            Self::Speed { start, per_s, rpm } => {
                let per_s = match (unit.sensor(), per_s, rpm) {
                    (_, Some(per_s), None) => *per_s,
                    (Sensor::Rotary { steps_per_turn }, None, Some(rpm)) => {
                        rpm * f64::from(steps_per_turn) / 60.0
                    }
                    (Sensor::Linear { .. }, None, Some(_)) => {
                        let told = format!("rpm is for shafts; a {} moves per_s micrometres", unit.model());
                        return Err(Wrong::at("rpm", told));
                    }
                    _ => return Err(Wrong::new("speed takes either per_s or rpm")),
                };
                // What is told is the speed also where it was given in turns a minute.
                let told = "speed in steps or micrometres a second";
                let per_s = limits(told, per_s, -PER_S_MAX, PER_S_MAX)
                    .map_err(|problem| Wrong::at(if rpm.is_some() { "rpm" } else { "per_s" }, problem))?;
                let micro_per_s = (per_s * 1e6).round() as i64;
                match start {
                    None => return Ok(NewMotion::Onward(micro_per_s)),
                    Some(start) => Motion::Speed { start: place("start", *start)?, micro_per_s },
                }
            }
            Self::Sine { center, amplitude, period_s } => Motion::Sine {
                center: place("center", *center)?,
                amplitude: place("amplitude", *amplitude)?,
                period: match seconds("period_s", *period_s)? {
                    Duration::ZERO => return Err(Wrong::at("period_s", "period_s 0; a swing takes time")),
                    period => period,
                },
            },
            Self::Moves { start, moves, repeat } => {
                let mut points = vec![(Instant::ZERO, place("start", *start)?)];
                for (index, step) in moves.iter().enumerate() {
                    let step = step.read(&points);
                    points.extend(step.map_err(|wrong| wrong.inside_item(index).inside("moves"))?);
                }
                Motion::Path { points, repeat: *repeat }
            }
            Self::Csv { file } => files.motion(file).map_err(|problem| Wrong::at("file", problem))?,
        };
        Ok(NewMotion::Motion(motion))
    }
}

impl MoveTable {
    /// Where it arrives and where its rest ends, after what came before.
    fn read(&self, before: &[(Instant, i64)]) -> Result<[(Instant, i64); 2], Wrong> {
        let from = before.last().map_or(Instant::ZERO, |(at, _)| *at);
        let to = place("to", self.to)?;
        let there = from + seconds("in_s", self.in_s)?;
        Ok([(there, to), (there + seconds("wait_s", self.wait_s)?, to)])
    }
}

impl EventTable {
    pub(super) fn read(&self, devices: &[Device], files: &mut MotionFiles) -> Result<Event, Wrong> {
        let at = Instant::ZERO + seconds("at_s", self.at_s)?;
        let what = match (self.position, &self.set, self.segment, self.line, self.for_s) {
            (Some(position), Some(set), None, None, None) => {
                within("position", position, 0, devices.len() as i64 - 1)?;
                let unknown = || Wrong::at("position", format!("position {position} is not on the ring"));
                let device = devices.get(position as usize).ok_or_else(unknown)?;
                let changes = set.read(&device.unit, files).map_err(|wrong| wrong.inside("set"))?;
                Happening::Device { position: position as usize, changes }
            }
            (None, None, Some(segment), Some(fault), for_s) => {
                fault.on_line().map_err(|problem| Wrong::at("line", problem))?;
                within("segment", segment, 0, devices.len() as i64)?;
                let lasting = match for_s {
                    Some(for_s) => seconds("for_s", for_s)?,
                    None => Occurrence::FOR_GOOD,
                };
                Happening::Line { segment: segment as usize, fault, lasting }
            }
            _ => {
                return Err(Wrong::new(
                    "an event has position and set, or segment and line with an optional for_s",
                ));
            }
        };
        Ok(Event { at, what })
    }
}

impl SetTable {
    /// The changes for this encoder, in the order supply, memory, magnet, motion, inputs, chip, SSI.
    ///
    /// # Errors
    /// What is wrong, with value and limit; then nothing is changed.
    pub fn read(&self, unit: &Unit, files: &mut MotionFiles) -> Result<Vec<Change>, Wrong> {
        let mut changes = Vec::new();
        if let Some(volts) = self.supply_v {
            changes.push(Change::Supply(millivolts("supply_v", volts)?));
        }
        if let Some(eeprom) = &self.eeprom {
            changes.push(eeprom.read().map_err(|wrong| wrong.inside("eeprom"))?);
        }
        if let Some(present) = self.magnet {
            if unit.model().sensor_kind() != SensorKind::Linear {
                return Err(Wrong::at("magnet", format!("magnet: a {} has none", unit.model())));
            }
            changes.push(Change::Magnet(if present { Magnet::Present } else { Magnet::Missing }));
        }
        match (self.raw, &self.motion) {
            (Some(_), Some(_)) => return Err(Wrong::at("motion", "raw and motion exclude each other")),
            (Some(raw), None) => {
                let raw = place("raw", raw)?;
                changes.push(Change::Motion(NewMotion::Motion(Motion::Hold { raw })));
            }
            (None, Some(motion)) => {
                let motion = motion.read(unit, files).map_err(|wrong| wrong.inside("motion"))?;
                changes.push(Change::Motion(motion));
            }
            (None, None) => {}
        }
        for (input, (name, volts)) in
            [("preset1_v", self.preset1_v), ("preset2_v", self.preset2_v)].into_iter().enumerate()
        {
            let Some(volts) = volts else { continue };
            let inputs = unit.model().preset_inputs().len();
            if input >= inputs {
                return Err(Wrong::at(
                    name,
                    format!("{name}: preset inputs of a {}: {inputs}", unit.model()),
                ));
            }
            changes.push(Change::Preset { input, millivolts: millivolts(name, volts)? });
        }
        if let Some(held) = self.chip_held {
            changes.push(Change::Chip(if held { Chip::Held } else { Chip::Running }));
        }
        if let Some(closed) = self.jumper {
            changes.push(Change::Jumper(if closed { Jumper::Closed } else { Jumper::Open }));
        }
        if let Some(ident) = self.ident {
            changes.push(Change::Ident(ident.into()));
        }
        if let Some(ssi) = &self.ssi {
            changes.push(ssi.read(unit.model()).map_err(|wrong| wrong.inside("ssi"))?);
        }
        if let Some(fault) = self.ssi_fault {
            changes.push(fault.read(unit.model())?);
        }
        if changes.is_empty() { Err(Wrong::new("nothing is set")) } else { Ok(changes) }
    }
}

impl EepromTable {
    fn read(&self) -> Result<Change, Wrong> {
        let cell = |cell: i64| within("cell", cell, 0, EEPROM_BYTES as i64 - 1).map(|cell| cell as usize);
        Ok(match self {
            Self::Read { cell: at } => Change::MemoryFault(CellFault::Read, at.map(cell).transpose()?),
            Self::Write { cell: at } => Change::MemoryFault(CellFault::Write, at.map(cell).transpose()?),
            Self::Stuck { cell: at, value } => {
                let value = within("value", *value, 0, 255)? as u8;
                Change::MemoryFault(CellFault::Stuck(value), Some(cell(*at)?))
            }
            Self::Cut { after_bytes } => {
                Change::PowerCut(within("after_bytes", *after_bytes, 1, 1_000_000)? as u64)
            }
            Self::None {} => Change::MemoryRepair,
        })
    }
}

fn limits<T: Copy + PartialOrd + Display>(name: &str, value: T, low: T, high: T) -> Result<T, String> {
    if (&low..=&high).contains(&&value) {
        Ok(value)
    } else {
        Err(format!("{name} {value}; the limits are {low} and {high}"))
    }
}

/// The length of a rod in micrometres [D40].
fn rod_um(rod_mm: f64) -> Result<u32, Wrong> {
    let limit = |um: u32| f64::from(um) / 1_000.0;
    let rod_mm = within("rod_mm", rod_mm, limit(ROD_UM_MIN), limit(ROD_UM_MAX))?;
    let hundredths = (rod_mm * 100.0).round();
    if (hundredths / 100.0).total_cmp(&rod_mm).is_ne() {
        return Err(Wrong::at("rod_mm", format!("rod_mm {rod_mm}; a rod is told to 0.01 mm, two decimals")));
    }
    Ok(hundredths as u32 * 10)
}

fn place(name: &str, raw: i64) -> Result<i64, Wrong> {
    within(name, raw, -RAW_MAX, RAW_MAX)
}

fn seconds(name: &str, value: f64) -> Result<Duration, Wrong> {
    within(name, value, 0.0, SECONDS_MAX).map(|value| Duration((value * 1e9).round() as u64))
}

fn millivolts(name: &str, volts: f64) -> Result<u32, Wrong> {
    within(name, volts, 0.0, VOLTS_MAX).map(|volts| (volts * 1e3).round() as u32)
}
