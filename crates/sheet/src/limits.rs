//! The sections with figures: limits, levels, and the SSI output.

use encoring_words::explain::Values;
use encoring_words::model::SensorKind;
use encoring_words::sheet::{DataSheet, Mechanics, SsiSheet};
use encoring_words::ssi_frame::{MONO_PERIOD, REPETITION_PULSES};
use encoring_words::{Model, Service};

use crate::sections::Content;
use crate::sentences;
use crate::table::{SheetCell, SheetTable};

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

    fn cells(self) -> Vec<SheetCell> {
        let Self { quantity, numbers, unit, remark } = self;
        if numbers == [None; 3] {
            return vec![
                quantity.into(),
                SheetCell::NotStated,
                SheetCell::Empty,
                SheetCell::Empty,
                SheetCell::Empty,
                SheetCell::Empty,
            ];
        }
        let numbers = numbers.into_iter().map(SheetCell::any);
        [quantity.into()].into_iter().chain(numbers).chain([unit.into(), remark.into()]).collect()
    }
}

/// Volts.
fn volts(millivolts: u32) -> f64 {
    f64::from(millivolts) / 1_000.0
}

pub(crate) fn limits(model: Model, sheet: &DataSheet) -> Content {
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
    (SheetTable::new(&["quantity", "is", "least", "most", "unit", "remark"], rows), Vec::new())
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

pub(crate) fn levels(sheet: &DataSheet) -> Content {
    let inputs = sheet.preset_input.map(|it| {
        vec![
            "preset input".into(),
            volts(it.low_below_mv).into(),
            volts(it.high_above_mv).into(),
            volts(it.max_mv).into(),
            SheetCell::NotStated,
            SheetCell::Empty,
            "energise it with the supply voltage for at least 1 s; with 11 V it may not act".into(),
        ]
    });
    let signals = sheet.signals.iter().map(|it| {
        vec![
            it.name.into(),
            SheetCell::stated(it.low_below_mv.map(volts)),
            SheetCell::stated(it.high_above_mv.map(volts)),
            SheetCell::any(it.max_mv.map(volts)),
            SheetCell::any(it.ohms),
            SheetCell::any(it.milliamperes.map(u32::from)),
            it.remark.into(),
        ]
    });
    let columns = &["signal", "low_below_v", "high_above_v", "most_v", "ohms", "most_ma", "remark"];
    let mut notes = Vec::new();
    if sheet.ssi.is_some() {
        notes.push(sentences::ssi_rest());
    }
    (SheetTable::new(columns, inputs.into_iter().chain(signals).collect()), notes)
}

pub(crate) fn ssi_output(model: Model, ssi: SsiSheet) -> Content {
    let rates = |(low, high): (u32, u32)| format!("{} kHz to {} MHz", low / 1_000, f64::from(high) / 1e6);
    let values = Values { service: Service::SsiValues, model }.to_string();
    let rows: Vec<(&str, SheetCell)> = vec![
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
    (SheetTable::facts(rows), Vec::new())
}
