//! What each section of a data sheet says.

use encoring_texts::{Hex, Said};
use encoring_words::explain::{Legal, Values, effect};
use encoring_words::sheet::{DataSheet, Revision, Rule};
use encoring_words::status::STATUS_BITS;
use encoring_words::word::{Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, Duration, Model, OutWord, Service};

use crate::sentences;
use crate::table::{SheetCell, SheetTable};

/// A table and the sentences below it.
pub(crate) type Content = (SheetTable, Vec<Said>);

fn edition(revision: Revision) -> Said {
    let Revision { index, date, what } = revision;
    let what = Said::stated(what.to_owned());
    match index {
        Some(index) => sentences::edition_with_index(index, date, what),
        None => sentences::edition(date, what),
    }
}

pub(crate) fn data(model: Model, sheet: &DataSheet) -> Content {
    let DataSheet { ident_code, words, .. } = *sheet;
    let inputs = model.preset_inputs().len();
    let mut rows: Vec<(&str, SheetCell)> = vec![
        ("device", sheet.device.into()),
        ("on the ring", "remote bus module with 32 bits of I/O data, processed like a bus terminal".into()),
        ("ident number", format!("{ident_code} ({ident_code:X}h), the same for all three models").into()),
        ("word addresses", format!("{words} of IN and {words} of OUT").into()),
        ("standard of the bus", SheetCell::stated(sheet.standard)),
        ("protocol chip", SheetCell::stated(sheet.chip)),
        ("interface", SheetCell::stated(sheet.interface)),
        (
            "transfer rate",
            SheetCell::stated(
                sheet.kilobaud.map(|(gross, net)| {
                    format!("{gross} kBaud gross with control and status, {net} kBaud net")
                }),
            ),
        ),
        ("data refresh", SheetCell::stated(sheet.refresh.map(milliseconds))),
        ("resolution", sheet.resolution.into()),
        ("measuring range", sheet.range.into()),
        ("capacity", SheetCell::stated(sheet.capacity)),
        ("output code", SheetCell::stated(sheet.code)),
        ("memory", SheetCell::stated(sheet.memory)),
        ("preset inputs", if inputs == 0 { "none".into() } else { SheetCell::Number(inputs as f64) }),
        ("second interface", if sheet.ssi.is_some() { SheetCell::same("SSI") } else { "none".into() }),
    ];
    rows.extend(
        sheet.revisions.iter().map(|revision| ("edition of the manual", SheetCell::Said(edition(*revision)))),
    );
    (SheetTable::facts(rows), Vec::new())
}

/// As the manuals write a refresh.
fn milliseconds(time: Duration) -> String {
    format!("{} ms", time.as_nanos() as f64 / 1e6)
}

pub(crate) fn pins(sheet: &DataSheet) -> Content {
    let mut rows = Vec::new();
    for connector in sheet.connectors {
        for (pin, signal) in (1_u32..).zip(connector.pins) {
            let signal = if signal.is_empty() { "free" } else { signal };
            rows.push(vec![connector.name.into(), pin.into(), signal.into()]);
        }
    }
    let mut notes: Vec<Said> = sheet.wiring.iter().map(|&note| Said::stated(note.to_owned())).collect();
    notes.extend(
        sheet.next_device_jumper.map(|(connector, one, other)| sentences::jumper(connector, one, other)),
    );
    (SheetTable::new(&["connector", "pin", "signal"], rows), notes)
}

pub(crate) fn lamps(sheet: &DataSheet) -> Content {
    let row = |lamp: &encoring_words::sheet::Lamp| {
        vec![SheetCell::same(lamp.name), lamp.colour.into(), lamp.stated.into(), lamp.meaning.into()]
    };
    let notes = vec![sentences::lamp_names()];
    (SheetTable::new(&["lamp", "colour", "manual", "lit"], sheet.lamps.iter().map(row).collect()), notes)
}

/// The OUT word of a service.
fn word(service: Service, access: Access, data: u32) -> OutWord {
    let service = ServiceNumber::Known(service);
    OutWord::from(Out::Request(ServiceFields { access, error: false, reserve: false, service, data }))
}

pub(crate) fn services(model: Model) -> Content {
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
            Some(Legal::Whole { low, high }) => {
                SheetCell::same(format!("{}..{}", written(low), written(high)))
            }
            Some(_) => SheetCell::Said(sentences::with_value(Hex(written(0).0))),
            None => SheetCell::Empty,
        };
        let values = (Values { service, model }).to_string();
        let values = match Legal::of(service, model) {
            None => effect(fields(service, Access::Read), model).join("; ").into(),
            Some(Legal::Whole { .. }) if service != Service::CountingDirection => SheetCell::Same(values),
            Some(_) => values.into(),
        };
        vec![
            SheetCell::same(format!("{:02X}", service.number())),
            service.name().into(),
            may(Access::Read)
                .then(|| word(service, Access::Read, 0).to_string())
                .map_or(SheetCell::Empty, SheetCell::Same),
            if may(Access::Write) { write } else { SheetCell::Empty },
            values,
        ]
    });
    let written = effect(fields(Service::MeasuringLength, Access::Write), model).join("; ");
    let mut notes = vec![sentences::replies(), sentences::written(Said::stated(written))];
    notes.extend(model.data_sheet().programming.iter().map(|&note| Said::stated(note.to_owned())));
    (SheetTable::new(&["service", "name", "read", "write", "values"], rows.collect()), notes)
}

pub(crate) fn status(model: Model) -> Content {
    let mask = model.status_mask();
    let rows = STATUS_BITS
        .iter()
        .filter(|row| mask.bits() >> row.bit & 1 == 1)
        .map(|row| vec![SheetCell::same(format!("2^{}", row.bit)), row.meaning.into(), row.remedy.into()]);
    let mut zero: Vec<String> =
        (0..16).filter(|bit| mask.bits() >> bit & 1 == 0).map(|bit| format!("2^{bit}")).collect();
    // On every model there are several.
    let last = zero.pop().unwrap_or_default();
    let notes = vec![sentences::always_0(zero.join(", "), last)];
    (SheetTable::new(&["bit", "meaning", "remedy"], rows.collect()), notes)
}

pub(crate) fn faults(model: Model) -> Content {
    let steps = model.data_sheet().step_changes.iter();
    let steps = steps.map(|step| vec!["step changes".into(), step.cause.into(), step.remedy.into()]);
    let bits = model.status_mask().explain();
    let bits = bits.map(|row| {
        vec![SheetCell::Said(sentences::status_bit(row.bit)), row.meaning.into(), row.remedy.into()]
    });
    (SheetTable::new(&["fault", "cause", "remedy"], steps.chain(bits).collect()), Vec::new())
}

pub(crate) fn rules(rules: &[Rule]) -> Content {
    let row = |rule: &Rule| vec![SheetCell::same(rule.chapter), rule.about.into(), rule.text.into()];
    (SheetTable::new(&["chapter", "about", "rule"], rules.iter().map(row).collect()), Vec::new())
}
