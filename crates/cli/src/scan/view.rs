//! What `scan` shows: plain data for programs. The text for people is made from the same.

use std::fmt;

use encoring_modbus::inline::Directory;
use encoring_ring::Ident;
use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::ident::{DataDirection, ENCODER, Kind, Length};
use encoring_sim::scan::Scan;
use encoring_station::view::LampsView;
use serde::Serialize;

use crate::registers::RegistersView;

/// Words that an encoder takes in each direction.
const WORDS: usize = 2;

#[derive(Serialize)]
pub(super) struct ScanView {
    bus: String,
    simulated: bool,
    /// `complete`, `ends_early`, `bad_segment`, `other_device`, `no_answer`, or `directory` of a coupler.
    result: &'static str,
    /// How many devices there should be, if somebody knows.
    configured: Option<usize>,
    found: usize,
    devices: Vec<DeviceView>,
    master: Option<MasterView>,
    warnings: Vec<&'static str>,
}

#[derive(Serialize)]
struct DeviceView {
    position: usize,
    device_number: String,
    /// `found`, `other` (not what was configured) or `not_found`.
    state: &'static str,
    ident: Option<IdentView>,
    /// Word addresses in the process image, or registers of a coupler.
    out: Option<[usize; WORDS]>,
    #[serde(rename = "in")]
    input: Option<[usize; WORDS]>,
    lamps: Option<LampsView>,
}

#[derive(Serialize)]
struct IdentView {
    word_hex: String,
    code: u8,
    code_hex: String,
    meaning: &'static str,
    length_code_hex: String,
    bits: Option<u32>,
    words: Option<u32>,
}

#[derive(Serialize)]
struct MasterView {
    #[serde(flatten)]
    registers: RegistersView,
    place: Option<String>,
    took_ns: u64,
}

const UNTOLD_MODEL: &str =
    "ident code 51 (33h) does not tell the model: all three encoders show it; look at the type label";

const fn meaning(ident: Ident) -> &'static str {
    match ident.kind() {
        Kind::Digital(DataDirection::Out) => "digital, OUT",
        Kind::Digital(DataDirection::In) => "digital, IN",
        Kind::Digital(DataDirection::Both) => "digital, IN and OUT",
        Kind::Analogue(DataDirection::Out) => "analogue, OUT",
        Kind::Analogue(DataDirection::In) => "analogue, IN",
        Kind::Analogue(DataDirection::Both) => "analogue, IN and OUT",
        Kind::Other(_) => "not known here",
    }
}

impl IdentView {
    fn new(ident: Ident) -> Self {
        let bits = ident.length().map(|length| match length {
            Length::Bytes(bytes) => u32::from(bytes) * 8,
            Length::Bits(bits) => u32::from(bits),
        });
        Self {
            word_hex: format!("{:04X}", ident.0),
            code: ident.code(),
            code_hex: format!("{:02X}", ident.code()),
            meaning: meaning(ident),
            length_code_hex: format!("{:02X}", ident.length_code()),
            bits,
            words: bits.map(|bits| bits.div_ceil(16)),
        }
    }
}

fn number(position: usize) -> String {
    format!("{}.0", position + 1)
}

fn warnings<'a>(idents: impl IntoIterator<Item = &'a Ident>) -> Vec<&'static str> {
    let any = idents.into_iter().any(|ident| ident.code() == ENCODER.code());
    if any { vec![UNTOLD_MODEL] } else { Vec::new() }
}

impl ScanView {
    /// A simulated ring.
    pub(super) fn of_ring(address: &str, scan: &Scan) -> Self {
        let configured = scan.world.places().len();
        let devices = (0..configured).map(|position| {
            let other = scan.other.filter(|_| scan.place == Some(FaultPlace::Device(position)));
            let found = scan.found.get(position).copied();
            let address = [WORDS * position, WORDS * position + 1];
            DeviceView {
                position,
                device_number: number(position),
                state: match (found, other) {
                    (Some(_), _) => "found",
                    (None, Some(_)) => "other",
                    (None, None) => "not_found",
                },
                ident: found.or(other).map(IdentView::new),
                out: Some(address),
                input: Some(address),
                lamps: LampsView::of(&scan.world, position),
            }
        });
        Self {
            bus: address.to_owned(),
            simulated: true,
            result: match scan.place {
                None if scan.is_whole() => "complete",
                Some(FaultPlace::Segment(_)) => "bad_segment",
                Some(FaultPlace::Device(_)) => "other_device",
                Some(FaultPlace::Nowhere) => "no_answer",
                _ => "ends_early",
            },
            configured: Some(configured),
            found: scan.found.len(),
            devices: devices.collect(),
            master: Some(MasterView {
                registers: RegistersView::new(scan.status, scan.parameter),
                place: scan.place.map(|place| place.to_string()),
                took_ns: scan.took.as_nanos(),
            }),
            warnings: warnings(&scan.found),
        }
    }

    /// What an Inline coupler says of its modules.
    pub(super) fn of_coupler(address: &str, data: u16, described: &[u16], directory: &Directory) -> Self {
        let idents: Vec<Ident> = described.iter().map(|register| Ident(*register).identity()).collect();
        let devices = idents.iter().enumerate().map(|(position, ident)| {
            let words = |offset: usize| {
                let first = usize::from(data) + offset;
                [first, first + 1]
            };
            let offsets = directory.offsets(position).ok();
            DeviceView {
                position,
                device_number: number(position),
                state: "found",
                ident: Some(IdentView::new(*ident)),
                out: offsets.map(|offsets| words(offsets.out)),
                input: offsets.map(|offsets| words(offsets.input)),
                lamps: None,
            }
        });
        Self {
            bus: address.to_owned(),
            simulated: false,
            result: "directory",
            configured: None,
            found: idents.len(),
            devices: devices.collect(),
            master: None,
            warnings: warnings(&idents),
        }
    }
}

const fn lamp(on: bool) -> &'static str {
    if on { "on" } else { "-" }
}

impl fmt::Display for DeviceView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { position, device_number, state, .. } = self;
        write!(f, "{position:>8}  {device_number:<6}  ")?;
        match &self.ident {
            Some(ident) => {
                let words = ident.words.map_or_else(|| "-".to_owned(), |words| words.to_string());
                let code = format!("{}h ({})", ident.code_hex, ident.code);
                let length = format!("{}h", ident.length_code_hex);
                write!(f, "{code:<9}  {:<20}  {length:<6}  {words:>5}  ", ident.meaning)?;
            }
            None => write!(f, "{:<9}  {:<20}  {:<6}  {:>5}  ", "-", state.replace('_', " "), "-", "-")?,
        }
        let pair = |pair: Option<[usize; WORDS]>| pair.map_or("-".to_owned(), |[a, b]| format!("{a}, {b}"));
        write!(f, "{:<10}  {:<10}", pair(self.out), pair(self.input))?;
        if let Some(LampsView { u, ba, rc, rd }) = self.lamps {
            write!(f, "  {:<2}  {:<2}  {:<2}  {}", lamp(u), lamp(ba), lamp(rc), lamp(rd))?;
        }
        writeln!(f)
    }
}

impl fmt::Display for ScanView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.configured {
            Some(configured) => {
                writeln!(f, "{} of {configured} devices found by ID cycles on {}\n", self.found, self.bus)?;
            }
            None => writeln!(f, "{} modules in the directory of {}\n", self.found, self.bus)?,
        }
        write!(
            f,
            "position  device  ident      meaning               length  words  OUT         IN        "
        )?;
        writeln!(f, "{}", if self.master.is_some() { "  U   BA  RC  RD" } else { "" })?;
        self.devices.iter().try_for_each(|device| device.fmt(f))?;
        if let Some(master) = &self.master {
            writeln!(f)?;
            if let Some(place) = &master.place {
                writeln!(f, "fault      {place}")?;
            }
            master.registers.fmt(f)?;
        }
        for warning in &self.warnings {
            writeln!(f, "\nwarning: {warning}")?;
        }
        Ok(())
    }
}
