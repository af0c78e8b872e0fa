//! What can be seen of a simulated ring, as plain data: typed here, with words in hex in its JSON.

use encoring_encoder::handshake::Handshake;
use encoring_encoder::records::{Record, write_count};
use encoring_encoder::{Encoder, Magnet};
use encoring_host::ssi_receiver::SsiFault;
use encoring_ring::slave::Jumper;
use encoring_ring::{ProcessImage, Verdict};
use encoring_sim::ssi::SsiReader;
use encoring_sim::{Fault, World};
use encoring_words::parameter::{Code, PARAMETERS};
use encoring_words::{ErrorStatus, InWord, Model, OutWord, ParameterSet};
use serde::Serialize;

use crate::json;
use crate::refereeing::RefereeView;

/// A ring at one moment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct View {
    /// Time on the ring in nanoseconds.
    pub time_ns: u64,
    /// Time of one cycle in nanoseconds.
    pub cycle_ns: u64,
    /// What was counted.
    pub counters: Counters,
    /// How the last cycle went.
    #[serde(flatten, serialize_with = "json::line")]
    pub line: Verdict,
    /// The master's diagnostic registers.
    pub diagnosis: DiagnosisView,
    /// What a segment suffers; `None` if none does.
    pub trouble: Option<TroubleView>,
    /// The encoders, by ring position.
    pub devices: Vec<DeviceView>,
    /// Which rules of the handshake were broken; `None` if nobody looks on.
    pub referee: Option<RefereeView>,
}

/// What a segment of the simulated ring suffers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TroubleView {
    /// 0..=encoders.
    pub segment: usize,
    /// In its text form.
    #[serde(serialize_with = "json::text")]
    pub fault: Fault,
}

/// What a station counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Cycles run.
    pub cycles: u64,
    /// Of these, not good throughout.
    pub faulty_cycles: u64,
    /// Cycles left out because the machine was too slow.
    pub dropped_cycles: u64,
}

/// What the master says of the ring, as the process image has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DiagnosisView {
    /// The status register.
    #[serde(serialize_with = "json::hex")]
    pub status: u16,
    /// The parameter register.
    #[serde(serialize_with = "json::hex")]
    pub parameter: u16,
    /// Faulty cycles located on each segment, at most 65535; the last one leads back to the master.
    pub segment_faults: Vec<u16>,
}

/// One encoder at one moment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceView {
    /// Ring position from 0.
    pub position: usize,
    /// The vendor's number of the device, like `3.0`.
    pub device_number: String,
    /// Its model.
    #[serde(serialize_with = "json::text")]
    pub model: Model,
    /// Whether its supply is on.
    pub on: bool,
    /// Its supply in millivolts.
    pub supply_mv: u32,
    /// The supply is above its limit.
    pub overvoltage: bool,
    /// A preset input gets more than its limit.
    pub preset_overvoltage: bool,
    /// Voltages on the preset inputs it has.
    pub preset_mv: Vec<u32>,
    /// Whether the magnet is on the rod; a shaft has none, and `true`.
    pub magnet: bool,
    /// Whether its protocol chip is held in reset.
    pub chip_held: bool,
    /// Whether the jumper for the next device is there.
    pub jumper: bool,
    /// Shaft in sensor steps, or magnet in micrometres.
    pub raw: i64,
    /// The OUT word in the process image.
    #[serde(serialize_with = "json::text")]
    pub out: OutWord,
    /// The IN word in the process image.
    #[serde(rename = "in", serialize_with = "json::text")]
    pub input: InWord,
    /// The position in steps, in binary code; `None` while off.
    pub value: Option<u32>,
    /// Bit 29 as normal mode shows it.
    pub error: bool,
    /// How far presets have moved its positions, in steps; `None` while off.
    pub preset_shift: Option<i64>,
    /// The latched status bits.
    #[serde(serialize_with = "json::status")]
    pub latched_status: ErrorStatus,
    /// Where a service stands; `None` without supply or until the first exchange.
    #[serde(serialize_with = "json::handshake")]
    pub handshake: Option<Handshake>,
    /// The lamps.
    pub lamps: LampsView,
    /// The reader on its SSI; `None` without one.
    pub ssi: Option<SsiView>,
    /// Programmed, accepted and active parameters, by service.
    pub parameters: Vec<ParameterView>,
    /// The status bits that a data check would find in the programmed values; `None` while off.
    #[serde(serialize_with = "json::status_if_on")]
    pub data_check: Option<ErrorStatus>,
    /// Writes of the memory so far, by record.
    pub memory_writes: MemoryWrites,
    /// The kinds of records of which one cannot be read, by their names in [`MemoryWrites`].
    pub memory_lost: Vec<&'static str>,
}

/// The reader on an SSI, and what it read last.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SsiView {
    /// Clock rate in hertz.
    pub clock_hz: u32,
    /// Clocks of a transfer.
    pub clocks: u32,
    /// From the beginning of a transfer to that of the next, in nanoseconds.
    pub every_ns: u64,
    /// Bits that it is set to; `None`: as the encoder sends.
    pub bits: Option<u8>,
    /// Code that it is set to; `None`: as the encoder sends.
    pub code: Option<&'static str>,
    /// Transfers so far.
    pub count: u64,
    /// When the last one was over; `None` before the first one was.
    pub time_ns: Option<u64>,
    /// The bits of its field, as they came.
    pub field: Option<String>,
    /// The position; `None` with a fault.
    pub position: Option<u32>,
    /// What is wrong with it, see `docs/ssi.md`.
    pub fault: Option<&'static str>,
}

impl SsiView {
    fn of(reader: &SsiReader) -> Self {
        let settings = reader.settings();
        let read = reader.read();
        Self {
            clock_hz: settings.hz(),
            clocks: settings.clocks(),
            every_ns: settings.every().as_nanos(),
            bits: settings.card().bits,
            code: settings.card().code.map(Code::name),
            count: reader.count(),
            time_ns: read.map(|read| read.at.as_nanos()),
            field: read.map(|read| read.transfer.bits().to_string()),
            position: read.and_then(|read| read.transfer.position()),
            fault: read.and_then(|read| read.transfer.fault).map(SsiFault::name),
        }
    }
}

/// The lamps of the CE-65-M; the other manuals show none, but the ring lights the same for all [R139].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LampsView {
    /// Supply.
    pub u: bool,
    /// Data cycles arrive.
    pub ba: bool,
    /// The incoming bus is connected.
    pub rc: bool,
    /// The outgoing bus is switched off: at the last device, and in reset.
    pub rd: bool,
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ParameterView {
    /// Number of the service.
    pub service: u8,
    /// Its name.
    pub name: &'static str,
    /// What a read returns.
    pub programmed: u32,
    /// What the last good data check took; `None` where there is no such set, or its record is lost.
    pub accepted: Option<u32>,
    /// What the position is computed with.
    pub active: u32,
}

/// How often each kind of record was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MemoryWrites {
    /// All programmed values together.
    pub programmed: u32,
    /// The accepted set.
    pub accepted: u32,
    /// The preset offset.
    pub offset: u32,
    /// The turn count.
    pub turn_count: u32,
}

impl View {
    /// What can be seen of `world`, with what stands in the process image.
    #[must_use]
    pub fn of(world: &World, image: &ProcessImage, verdict: Verdict, counters: Counters) -> Self {
        let words = image.out().iter().zip(image.input()).enumerate();
        let devices =
            words.filter_map(|(position, (out, input))| DeviceView::of(world, position, *out, *input));
        Self {
            time_ns: world.now().as_nanos(),
            cycle_ns: world.cycle_time().as_nanos(),
            counters,
            line: verdict,
            diagnosis: DiagnosisView {
                status: image.status(),
                parameter: image.parameter(),
                segment_faults: image.faults().to_vec(),
            },
            trouble: world.line_trouble().map(|(segment, fault)| TroubleView { segment, fault }),
            devices: devices.collect(),
            referee: None,
        }
    }
}

impl LampsView {
    /// Those of the encoder at a position of `world`.
    #[must_use]
    pub fn of(world: &World, position: usize) -> Option<Self> {
        world.lamps(position).map(Self::from)
    }
}

impl From<encoring_ring::slave::Lamps> for LampsView {
    fn from(lamps: encoring_ring::slave::Lamps) -> Self {
        let encoring_ring::slave::Lamps { u, ba, rc, rd } = lamps;
        Self { u, ba, rc, rd }
    }
}

impl DeviceView {
    fn of(world: &World, position: usize, out: OutWord, input: InWord) -> Option<Self> {
        let place = world.places().get(position)?;
        let (node, around, now) = (place.node(), place.around(), world.now());
        let unit = node.unit();
        let encoder = node.encoder();
        let (programmed, active) = match encoder {
            Some(encoder) => (*encoder.parameters().programmed(), *encoder.active()),
            None => (ParameterSet::default(), ParameterSet::default()),
        };
        // Reading needs a memory to itself: a failing one fails here too, and shows 0.
        let mut memory = node.memory().clone();
        let accepted = encoder.and_then(|encoder| encoder.parameters().accepted(&mut memory));
        let parameters = PARAMETERS
            .into_iter()
            .filter(|parameter| encoder.is_some() && parameter.service().known_to(unit.model()))
            .map(|parameter| ParameterView {
                service: parameter.service().number(),
                name: parameter.service().name(),
                programmed: programmed.value(parameter),
                accepted: accepted.map(|accepted| accepted.value(parameter)),
                active: active.value(parameter),
            });
        let mut writes = |record| write_count(&mut memory, record);
        // Whoever delivers an encoder has written every record once.
        let mut lost: Vec<_> =
            Record::of(unit.model()).filter(|record| writes(*record) == 0).map(kind).collect();
        lost.dedup();
        Some(Self {
            position,
            device_number: format!("{}.0", position + 1),
            model: unit.model(),
            on: place.is_supplied(),
            supply_mv: around.supply_mv,
            overvoltage: node.device().overvoltage(),
            preset_overvoltage: around.preset_overvoltage(unit.model()),
            preset_mv: around
                .terminals
                .preset_mv
                .into_iter()
                .take(unit.model().preset_inputs().len())
                .collect(),
            magnet: around.terminals.magnet == Magnet::Present,
            chip_held: place.is_held(),
            jumper: world.ring().slaves().get(position)?.jumper() == Jumper::Closed,
            raw: place.raw(now),
            out,
            input,
            value: encoder.map(Encoder::position),
            error: encoder.is_some_and(Encoder::error_pending),
            preset_shift: encoder.map(Encoder::preset_shift),
            latched_status: encoder.map_or(ErrorStatus::empty(), Encoder::latched_status),
            handshake: encoder.map(Encoder::handshake).copied(),
            lamps: LampsView::of(world, position)?,
            ssi: place.ssi().map(SsiView::of),
            parameters: parameters.collect(),
            data_check: encoder.map(|encoder| encoder.parameters().validity()),
            memory_writes: MemoryWrites {
                programmed: PARAMETERS
                    .into_iter()
                    .map(|parameter| writes(Record::Programmed(parameter)))
                    .sum(),
                accepted: writes(Record::Accepted),
                offset: writes(Record::Offset),
                turn_count: writes(Record::TurnCount),
            },
            memory_lost: lost,
        })
    }
}

/// What a record is called.
const fn kind(record: Record) -> &'static str {
    match record {
        Record::Programmed(_) => "programmed",
        Record::Accepted => "accepted",
        Record::Offset => "offset",
        Record::TurnCount => "turn_count",
    }
}
