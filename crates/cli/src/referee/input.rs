//! The four kinds of input, each as what a referee observes.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::str::FromStr;

use encoring_host::referee::{LineSeen, Observed, Vantage};
use encoring_ring::diagnostics::status;
use encoring_trace::bus::{BusEvent, BusReader, BusRow, MARK};
use encoring_trace::{CycleSeen, DeviceLine, Input, Row, RowKind};
use encoring_words::{InWord, Instant, Model, OutWord};

use super::{Arguments, Panel, SeenFrom};
use crate::arguments::tell_doubts;
use crate::output::{Failure, bad_input};

/// What messages call the trace.
pub(super) fn name(arguments: &Arguments) -> &str {
    if arguments.trace == "-" { "standard input" } else { &arguments.trace }
}

/// Shows the trace to referees.
pub(super) fn read(arguments: &Arguments) -> Result<Panel, Failure> {
    let name = name(arguments);
    let mut source: Box<dyn BufRead> = if arguments.trace == "-" {
        Box::new(io::stdin().lock())
    } else {
        let file = File::open(name).map_err(|error| bad_input(format!("cannot open {name}: {error}")))?;
        Box::new(BufReader::new(file))
    };
    let begins = source.fill_buf().map_err(|error| bad_input(format!("cannot read {name}: {error}")))?;
    if begins.starts_with(MARK.as_bytes()) { bus(arguments, source) } else { table(arguments, source) }
}

fn panel(arguments: &Arguments, vantage: Vantage, devices: &[DeviceLine]) -> Result<Panel, Failure> {
    let mut panel = Panel {
        vantage,
        model: arguments.model,
        models: std::collections::BTreeMap::new(),
        referees: std::collections::BTreeMap::new(),
    };
    for device in devices {
        let wrong = |what: String| bad_input(format!("{} line {}: {what}", name(arguments), device.line));
        let model =
            Model::from_str(&device.model).map_err(|error| wrong(format!("{}: {error}", device.model)))?;
        if arguments.model.is_some_and(|said| said != model) {
            return Err(wrong(format!("--model contradicts the trace: it holds a {model}")));
        }
        panel.models.insert(device.position, model);
    }
    Ok(panel)
}

fn bus(arguments: &Arguments, source: impl BufRead) -> Result<Panel, Failure> {
    if !arguments.table.says_nothing() || arguments.seen_from.is_some() {
        return Err(bad_input(format!(
            "{} says itself what its columns are and where it was taken; leave --columns, --decimal, --period and \
             --seen-from out",
            name(arguments)
        )));
    }
    let mut reader = BusReader::new(name(arguments), source).map_err(bad_input)?;
    // Writes make it the other vantage.
    let mut panel = panel(arguments, Vantage::Cycles, reader.devices())?;
    reader.try_for_each(|row| {
        let row = row.map_err(bad_input)?;
        panel.observe(row.position, seen_on_bus(&row));
        Ok::<_, Failure>(())
    })?;
    Ok(panel)
}

fn seen_on_bus(row: &BusRow) -> Observed {
    let at = Instant(row.time_ns);
    match row.event {
        BusEvent::Cycle { out, input, line } => {
            let (out, input, line) = (OutWord(out), word(input), line.map_or(LineSeen::Untold, line_seen));
            Observed::Cycle { at, out, input, line }
        }
        BusEvent::Write { client, written } => Observed::Write { at, client, written },
    }
}

fn word(input: Option<Input>) -> Option<InWord> {
    match input {
        Some(Input::Word(word)) => Some(InWord(word)),
        Some(Input::Off) | None => None,
    }
}

const fn line_seen(cycle: CycleSeen) -> LineSeen {
    match cycle {
        CycleSeen::Good => LineSeen::Good,
        CycleSeen::Bad => LineSeen::Bad,
        CycleSeen::Silent => LineSeen::Silent,
    }
}

fn table(arguments: &Arguments, source: impl BufRead) -> Result<Panel, Failure> {
    let name = name(arguments);
    let mut reader = arguments.table.reader(name, source)?;
    let said = arguments.seen_from.map(SeenFrom::vantage);
    let vantage = match reader.recording() {
        Some(_) if said.is_some_and(|said| said != Vantage::Exchanges) => {
            return Err(bad_input(format!("{name} is a recording of exchanges; leave --seen-from out")));
        }
        Some(_) => Vantage::Exchanges,
        None => said.unwrap_or(Vantage::Log),
    };
    let devices = reader.recording().map_or(&[][..], |recording| recording.devices.as_slice());
    let mut panel = panel(arguments, vantage, devices)?;
    // What a row does not say stands as it did, by ring position.
    let mut standing = [(0, None); 256];
    for row in &mut reader {
        let row = row.map_err(bad_input)?;
        if row.kind == RowKind::SsiEdge {
            continue;
        }
        if row.cycle.is_some() && said.is_none() && panel.referees.is_empty() {
            panel.vantage = Vantage::Cycles;
        }
        let position = row.position.unwrap_or_default();
        let Some((out, input)) = standing.get_mut(usize::from(position)) else { continue };
        *out = row.out.unwrap_or(*out);
        *input = row.input.or(*input);
        panel.observe(position, seen_in_row(&row, *out, *input));
    }
    tell_doubts(&reader, name);
    Ok(panel)
}

fn seen_in_row(row: &Row, out: u32, input: Option<Input>) -> Observed {
    let line = match (row.cycle, row.status) {
        (Some(cycle), _) => line_seen(cycle),
        (None, Some(register)) if register & status::RUN == 0 => LineSeen::Silent,
        (None, Some(_)) => LineSeen::Good,
        (None, None) => LineSeen::Untold,
    };
    Observed::Cycle { at: Instant(row.time_ns), out: OutWord(out), input: word(input), line }
}
