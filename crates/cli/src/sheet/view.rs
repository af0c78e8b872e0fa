//! What `sheet` shows of a model: its manual's statements, section by section.

use std::fmt;

use encoring_words::explain::{Legal, Values, effect};
use encoring_words::model::{MODELS, SensorKind, Series};
use encoring_words::sheet::{DataSheet, Mechanics, Rule, Section, SsiSheet};
use encoring_words::ssi_frame::{MONO_PERIOD, REPETITION_PULSES};
use encoring_words::status::STATUS_BITS;
use encoring_words::word::{Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, Duration, Model, OutWord, Service};
use serde::Serialize;

use super::table::{Cell, NOT_STATED, Table, paragraph};

/// The data sheet of a model.
#[derive(Serialize)]
pub(super) struct SheetView {
    model: &'static str,
    title: &'static str,
    document: &'static str,
    sections: Vec<SectionView>,
}

#[derive(Serialize)]
struct SectionView {
    section: &'static str,
    title: &'static str,
    /// Of the manual; `None`: it says nothing of this.
    chapters: Option<&'static str>,
    rows: Table,
    notes: Vec<String>,
}

/// A table and the sentences below it.
type Content = (Table, Vec<String>);

impl SheetView {
    pub(super) fn new(model: Model, sections: &[Section]) -> Self {
        Self {
            model: model.name(),
            title: model.title(),
            document: model.data_sheet().document,
            sections: sections.iter().map(|section| SectionView::new(model, *section)).collect(),
        }
    }

    pub(super) fn markdown(&self) -> String {
        let mut text = format!("# {}\n\nManual: {}.\n", self.title, self.document);
        for section in &self.sections {
            text.push_str(&format!("\n## {} of the {}\n\n", section.title, self.title));
            text.push_str(&section.source());
            text.push('\n');
            if !section.rows.is_empty() {
                text.push_str(&format!("\n{}", section.rows.markdown()));
            }
            for note in &section.notes {
                text.push_str(&format!("\n{note}\n"));
            }
        }
        text
    }
}

impl fmt::Display for SheetView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, manual {}", self.title, self.document)?;
        for section in &self.sections {
            writeln!(f, "\n{}", section.title.to_uppercase())?;
            paragraph(f, &section.source())?;
            if !section.rows.is_empty() {
                write!(f, "\n{}", section.rows)?;
            }
            if !section.notes.is_empty() {
                writeln!(f)?;
                section.notes.iter().try_for_each(|note| paragraph(f, note))?;
            }
        }
        Ok(())
    }
}

impl SectionView {
    fn new(model: Model, section: Section) -> Self {
        let sheet = model.data_sheet();
        let chapters = sheet.chapters(section);
        let (rows, notes) = match section {
            _ if chapters.is_none() => (Table::new(&[], Vec::new()), elsewhere(section)),
            Section::Data => data(model, sheet),
            Section::Pins => pins(sheet),
            Section::Lamps => lamps(sheet),
            Section::Services => services(model),
            Section::Status => status(model),
            Section::Faults => faults(model),
            Section::Checklist => rules(sheet.check_list),
            Section::Safety => rules(sheet.safety),
            Section::Limits => limits(model, sheet),
            Section::Levels => levels(sheet),
            Section::Ssi => sheet.ssi.map_or_else(|| rules(&[]), |ssi| ssi_output(model, ssi)),
        };
        Self { section: section.name(), title: section.title(), chapters, rows, notes }
    }

    /// Where the manual says so, or that it does not.
    fn source(&self) -> String {
        match self.chapters {
            Some(chapters) => format!("In the manual: {chapters}."),
            None => format!("{NOT_STATED} in its manual."),
        }
    }
}

/// Which manuals do state a section.
fn elsewhere(section: Section) -> Vec<String> {
    let stating: Vec<Model> =
        MODELS.into_iter().filter(|model| model.data_sheet().chapters(section).is_some()).collect();
    let commands: Vec<String> =
        stating.iter().map(|model| format!("`encoring sheet {model} {}`", section.name())).collect();
    vec![format!("Another encoder's manual states it: {}.", Series(&commands, "and"))]
}

/// Two columns.
fn facts(rows: Vec<(&str, Cell)>) -> Table {
    let rows = rows.into_iter().map(|(quantity, value)| vec![quantity.into(), value]).collect();
    Table::new(&["quantity", "value"], rows)
}

fn data(model: Model, sheet: &DataSheet) -> Content {
    let DataSheet { ident_code, words, .. } = *sheet;
    let inputs = model.preset_inputs().len();
    let mut rows: Vec<(&str, Cell)> = vec![
        ("device", sheet.device.into()),
        ("on the ring", "remote bus module with 32 bits of I/O data, processed like a bus terminal".into()),
        ("ident number", format!("{ident_code} ({ident_code:X}h), the same for all three models").into()),
        ("word addresses", format!("{words} of IN and {words} of OUT").into()),
        ("standard of the bus", Cell::stated(sheet.standard)),
        ("protocol chip", Cell::stated(sheet.chip)),
        ("interface", Cell::stated(sheet.interface)),
        (
            "transfer rate",
            Cell::stated(
                sheet.kilobaud.map(|(gross, net)| {
                    format!("{gross} kBaud gross with control and status, {net} kBaud net")
                }),
            ),
        ),
        ("data refresh", Cell::stated(sheet.refresh.map(milliseconds))),
        ("resolution", sheet.resolution.into()),
        ("measuring range", sheet.range.into()),
        ("capacity", Cell::stated(sheet.capacity)),
        ("output code", Cell::stated(sheet.code)),
        ("memory", Cell::stated(sheet.memory)),
        ("preset inputs", if inputs == 0 { "none".into() } else { inputs.to_string().into() }),
        ("second interface", if sheet.ssi.is_some() { "SSI".into() } else { "none".into() }),
    ];
    rows.extend(sheet.revisions.iter().map(|revision| {
        let index = revision.index.map(|index| format!("index {index}, ")).unwrap_or_default();
        ("edition of the manual", format!("{index}{}: {}", revision.date, revision.what).into())
    }));
    (facts(rows), Vec::new())
}

/// As the manuals write a refresh.
fn milliseconds(time: Duration) -> String {
    format!("{} ms", time.as_nanos() as f64 / 1e6)
}

fn pins(sheet: &DataSheet) -> Content {
    let mut rows = Vec::new();
    for connector in sheet.connectors {
        for (pin, signal) in (1_u32..).zip(connector.pins) {
            let signal = if signal.is_empty() { "free" } else { signal };
            rows.push(vec![connector.name.into(), pin.into(), signal.into()]);
        }
    }
    let mut notes: Vec<String> = sheet.wiring.iter().map(|&note| note.to_owned()).collect();
    notes.extend(sheet.next_device_jumper.map(|(connector, one, other)| {
        format!("So that the next device is found: {connector}, pin {one} joined to pin {other}.")
    }));
    (Table::new(&["connector", "pin", "signal"], rows), notes)
}

fn lamps(sheet: &DataSheet) -> Content {
    let row = |lamp: &encoring_words::sheet::Lamp| {
        vec![lamp.name.into(), lamp.colour.into(), lamp.stated.into(), lamp.meaning.into()]
    };
    let notes = vec![
        "The manual gives names only; the meanings of RC and BA are those of other vendors' documents."
            .to_owned(),
    ];
    (Table::new(&["lamp", "colour", "manual", "lit"], sheet.lamps.iter().map(row).collect()), notes)
}

/// The OUT word of a service.
fn word(service: Service, access: Access, data: u32) -> OutWord {
    let service = ServiceNumber::Known(service);
    OutWord::from(Out::Request(ServiceFields { access, error: false, reserve: false, service, data }))
}

fn services(model: Model) -> Content {
    let fields = |service, access| ServiceFields {
        access,
        error: false,
        reserve: false,
        service: ServiceNumber::Known(service),
        data: 0,
    };
    let rows = model.services().iter().map(|listed| {
        let service = listed.service;
        let may = |access| model.admits(ServiceNumber::Known(service), access).is_ok();
        let written = |data| word(service, Access::Write, data);
        let write = match Legal::of(service, model) {
            Some(Legal::Whole { low, high }) => format!("{}..{}", written(low), written(high)),
            Some(_) => format!("{} + value", written(0)),
            None => String::new(),
        };
        let values = match (Values { service, model }).to_string() {
            none if none.is_empty() => effect(fields(service, Access::Read), model).join("; "),
            values => values,
        };
        vec![
            format!("{:02X}", service.number()).into(),
            service.name().into(),
            Cell::any(may(Access::Read).then(|| word(service, Access::Read, 0).to_string())),
            Cell::any(may(Access::Write).then_some(write)),
            values.into(),
        ]
    });
    let written = effect(fields(Service::MeasuringLength, Access::Write), model).join("; ");
    let mut notes = vec![
        "The data of a read have no meaning. The reply to a write is the word itself, that to a read has the value in \
         bits 2^23..2^0; with an error 2^29 is set in both."
            .to_owned(),
        format!("A written value {written}."),
    ];
    notes.extend(model.data_sheet().programming.iter().map(|&note| note.to_owned()));
    (Table::new(&["service", "name", "read", "write", "values"], rows.collect()), notes)
}

fn status(model: Model) -> Content {
    let mask = model.status_mask();
    let rows = STATUS_BITS
        .iter()
        .filter(|row| mask.bits() >> row.bit & 1 == 1)
        .map(|row| vec![format!("2^{}", row.bit).into(), row.meaning.into(), row.remedy.into()]);
    let zero: Vec<String> =
        (0..16).filter(|bit| mask.bits() >> bit & 1 == 0).map(|bit| format!("2^{bit}")).collect();
    let notes = vec![format!("Always 0: {}.", Series(&zero, "and"))];
    (Table::new(&["bit", "meaning", "remedy"], rows.collect()), notes)
}

fn faults(model: Model) -> Content {
    let steps = model.data_sheet().step_changes.iter();
    let steps = steps.map(|step| vec!["step changes".into(), step.cause.into(), step.remedy.into()]);
    let bits = model.status_mask().explain();
    let bits =
        bits.map(|row| vec![format!("status 2^{}", row.bit).into(), row.meaning.into(), row.remedy.into()]);
    (Table::new(&["fault", "cause", "remedy"], steps.chain(bits).collect()), Vec::new())
}

fn rules(rules: &[Rule]) -> Content {
    let row = |rule: &Rule| vec![rule.chapter.into(), rule.about.into(), rule.text.into()];
    (Table::new(&["chapter", "about", "rule"], rules.iter().map(row).collect()), Vec::new())
}

/// A quantity, or its limits.
struct Limit {
    quantity: &'static str,
    /// What it is, its least and its most.
    numbers: [Option<f64>; 3],
    unit: &'static str,
    remark: String,
}

impl Limit {
    fn new(quantity: &'static str, numbers: [Option<f64>; 3], unit: &'static str, remark: &str) -> Self {
        Self { quantity, numbers, unit, remark: remark.to_owned() }
    }

    fn between(quantity: &'static str, range: Option<(f64, f64)>, unit: &'static str, remark: &str) -> Self {
        Self::new(quantity, [None, range.map(|range| range.0), range.map(|range| range.1)], unit, remark)
    }

    fn at_most(quantity: &'static str, most: Option<f64>, unit: &'static str, remark: &str) -> Self {
        Self::new(quantity, [None, None, most], unit, remark)
    }

    fn cells(self) -> Vec<Cell> {
        let Self { quantity, numbers, unit, remark } = self;
        if numbers == [None; 3] {
            return vec![
                quantity.into(),
                Cell::NotStated,
                Cell::Empty,
                Cell::Empty,
                Cell::Empty,
                Cell::Empty,
            ];
        }
        let numbers = numbers.into_iter().map(Cell::any);
        [quantity.into()].into_iter().chain(numbers).chain([unit.into(), remark.into()]).collect()
    }
}

/// Volts.
fn volts(millivolts: u32) -> f64 {
    f64::from(millivolts) / 1_000.0
}

fn limits(model: Model, sheet: &DataSheet) -> Content {
    let supply = sheet.supply;
    let ripple = supply.map(|it| format!("residual ripple {} % either way", it.ripple_percent));
    let current = supply.and_then(|it| it.milliamperes);
    let celsius = |(low, high): (i8, i8)| (f64::from(low), f64::from(high));
    let mut rows = vec![
        Limit::between(
            "supply voltage",
            supply.map(|it| (volts(it.millivolts.0), volts(it.millivolts.1))),
            "V DC",
            &ripple.unwrap_or_default(),
        ),
        Limit::at_most("current at 11 V", current.map(|it| it.0.into()), "mA", "below"),
        Limit::at_most("current at 27 V", current.map(|it| it.1.into()), "mA", "below"),
        Limit::between(
            "operating temperature",
            sheet.temperature.map(|it| celsius(it.operating)),
            "deg C",
            "",
        ),
        Limit::between(
            "storage temperature",
            sheet.temperature.map(|it| celsius(it.storage)),
            "deg C",
            "in a cool place",
        ),
    ];
    if model.sensor_kind() == SensorKind::Rotary {
        rows.extend(mechanics(sheet.mechanics));
    }
    let rows = rows.into_iter().map(Limit::cells).collect();
    (Table::new(&["quantity", "is", "least", "most", "unit", "remark"], rows), Vec::new())
}

fn mechanics(stated: Option<Mechanics>) -> [Limit; 9] {
    let of = |pick: fn(Mechanics) -> f64| stated.map(pick);
    [
        Limit::at_most("permissible speed", of(|it| it.speed_rpm.into()), "rpm", ""),
        Limit::at_most("angular acceleration", of(|it| it.acceleration_rad_s2.into()), "rad/s^2", ""),
        Limit::at_most(
            "axial load on the shaft",
            of(|it| it.shaft_load_n.0.into()),
            "N",
            "at the end of the shaft",
        ),
        Limit::at_most(
            "radial load on the shaft",
            of(|it| it.shaft_load_n.1.into()),
            "N",
            "at the end of the shaft",
        ),
        Limit::new(
            "bearing life",
            [None, of(|it| it.bearing_life_revolutions as f64), None],
            "revolutions",
            "at 3000 rpm, 20 N axial, 30 N radial, 60 deg C",
        ),
        Limit::new(
            "moment of inertia",
            [of(|it| f64::from(it.inertia_e9_kg_m2) / 1_000.0), None, None],
            "10^-6 kg m^2",
            "",
        ),
        Limit::new(
            "starting torque",
            [of(|it| it.starting_torque_ncm.into()), None, None],
            "Ncm",
            "at 20 deg C",
        ),
        Limit::at_most("vibration", of(|it| it.vibration_m_s2.into()), "m/s^2", "50 to 2000 Hz"),
        Limit::at_most("shock", of(|it| it.shock_m_s2.into()), "m/s^2", "11 ms"),
    ]
}

fn levels(sheet: &DataSheet) -> Content {
    let inputs = sheet.preset_input.map(|it| {
        vec![
            "preset input".into(),
            volts(it.low_below_mv).into(),
            volts(it.high_above_mv).into(),
            volts(it.max_mv).into(),
            Cell::NotStated,
            Cell::Empty,
            "energise it with the supply voltage for at least 1 s; with 11 V it may not act".into(),
        ]
    });
    let signals = sheet.signals.iter().map(|it| {
        vec![
            it.name.into(),
            Cell::stated(it.low_below_mv.map(volts)),
            Cell::stated(it.high_above_mv.map(volts)),
            Cell::any(it.max_mv.map(volts)),
            Cell::any(it.ohms),
            Cell::any(it.milliamperes.map(u32::from)),
            it.remark.into(),
        ]
    });
    let columns = &["signal", "low_below_v", "high_above_v", "most_v", "ohms", "most_ma", "remark"];
    let mut notes = Vec::new();
    if sheet.ssi.is_some() {
        notes.push("SSI: at rest Data+ and Clock+ are at +5 V, High.".to_owned());
    }
    (Table::new(columns, inputs.into_iter().chain(signals).collect()), notes)
}

fn ssi_output(model: Model, ssi: SsiSheet) -> Content {
    let rates = |(low, high): (u32, u32)| format!("{} kHz to {} MHz", low / 1_000, f64::from(high) / 1e6);
    let values = Values { service: Service::SsiValues, model }.to_string();
    let rows: Vec<(&str, Cell)> = vec![
        ("clock input", ssi.clock_input.into()),
        ("data output", ssi.data_output.into()),
        ("clock rate", rates(ssi.clock_hz).into()),
        ("clock rate at the limit", format!("about {}", rates(ssi.clock_hz_limit)).into()),
        ("mono period t_M", MONO_PERIOD.to_string().into()),
        ("at rest", "Data+ and Clock+ High (+5 V)".into()),
        ("start", "the first falling edge of the clock takes the position; the MSB comes first".into()),
        ("data change", "with each rising edge of the clock".into()),
        ("data are taken", "with the rising or the falling edge, by the receiver".into()),
        ("end", "Data+ stays Low for t_M after the last falling edge, then it is High".into()),
        ("service 0D", values.into()),
        (
            "repetition",
            format!("the word comes again every {REPETITION_PULSES} pulses, with 24 data bits").into(),
        ),
        ("AK-40", "31 data bits, binary, and an odd parity bit".into()),
    ];
    (facts(rows), Vec::new())
}
