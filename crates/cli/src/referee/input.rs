//! The four kinds of input, each as what a referee observes.

use std::io::BufRead;
use std::str::FromStr;

use encoring_bus::Referees;
use encoring_host::referee::{LineSeen, Observed, Vantage};
use encoring_ring::diagnostics::status;
use encoring_station::refereeing::{line_seen, observed};
use encoring_trace::bus::{BusReader, MARK};
use encoring_trace::{DeviceLine, Input, Row, RowKind};
use encoring_words::{InWord, Instant, Model, OutWord};

use super::{Arguments, SeenFrom};
use crate::arguments::tell_doubts;
use crate::interrupt::Interrupt;
use crate::output::reading;
use crate::output::{Failure, bad_input, note};

/// What messages call the trace.
pub(super) fn name(arguments: &Arguments) -> &str {
    reading::name(&arguments.trace)
}

/// Rows between two looks whether a signal has come.
const LOOK_EACH: u64 = 1_024;

/// Shows the trace to referees, up to where a signal comes.
pub(super) fn read(arguments: &Arguments, interrupt: &Interrupt) -> Result<Referees, Failure> {
    let name = name(arguments);
    let mut source = reading::open(&arguments.trace, interrupt.stop())?;
    let begins = source.fill_buf().map_err(|error| bad_input(format!("cannot read {name}: {error}")))?;
    let (referees, line) = if begins.starts_with(MARK.as_bytes()) {
        bus(arguments, source, interrupt)?
    } else if begins.is_empty() && interrupt.is_interrupted() {
        (Referees::new(Vantage::Log, arguments.model), 0)
    } else {
        table(arguments, source, interrupt)?
    };
    if interrupt.is_interrupted() {
        note(&format!("note: {name}: interrupted, judged up to line {line} only"));
    }
    Ok(referees)
}

/// Whether the reading ends here, because of a signal.
fn ends(interrupt: &Interrupt, rows: u64) -> bool {
    rows.is_multiple_of(LOOK_EACH) && interrupt.is_interrupted()
}

fn referees(arguments: &Arguments, vantage: Vantage, devices: &[DeviceLine]) -> Result<Referees, Failure> {
    let mut referees = Referees::new(vantage, arguments.model);
    referees.allow_withdrawal(arguments.withdrawn_after);
    for device in devices {
        let wrong = |what: String| bad_input(format!("{} line {}: {what}", name(arguments), device.line));
        let model =
            Model::from_str(&device.model).map_err(|error| wrong(format!("{}: {error}", device.model)))?;
        if arguments.model.is_some_and(|said| said != model) {
            return Err(wrong(format!(
                "--model contradicts the trace, which is of a {model}; leave --model out"
            )));
        }
        referees.place(device.position, model);
    }
    Ok(referees)
}

/// The referees, and the last line that they were shown.
fn bus(
    arguments: &Arguments,
    source: impl BufRead,
    interrupt: &Interrupt,
) -> Result<(Referees, u64), Failure> {
    if !arguments.table.says_nothing() || arguments.seen_from.is_some() {
        return Err(bad_input(format!(
            "{} says itself what its columns are and where it was taken; leave --columns, --decimal, --period and \
             --seen-from out",
            name(arguments)
        )));
    }
    let mut reader = BusReader::new(name(arguments), source).map_err(bad_input)?;
    // Writes make it the other vantage.
    let mut referees = referees(arguments, Vantage::Cycles, reader.devices())?;
    let mut line = 0;
    for (rows, row) in (0..).zip(&mut reader) {
        if ends(interrupt, rows) {
            break;
        }
        let row = row.map_err(bad_input)?;
        line = row.line;
        referees.observe(row.position, observed(&row));
    }
    Ok((referees, line))
}

fn table(
    arguments: &Arguments,
    source: impl BufRead,
    interrupt: &Interrupt,
) -> Result<(Referees, u64), Failure> {
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
    let mut referees = referees(arguments, vantage, devices)?;
    // What a row does not say stands as it did, by ring position. Nothing is known of OUT before the first word.
    let mut standing = [(None, None); 256];
    let mut line = 0;
    for (rows, row) in (0..).zip(&mut reader) {
        if ends(interrupt, rows) {
            break;
        }
        let row = row.map_err(bad_input)?;
        line = row.line;
        if row.kind == RowKind::SsiEdge {
            continue;
        }
        if row.cycle.is_some() && said.is_none() && referees.each().next().is_none() {
            referees.look_from(Vantage::Cycles);
        }
        let position = row.position.unwrap_or_default();
        let Some((out, input)) = standing.get_mut(usize::from(position)) else { continue };
        *out = row.out.or(*out);
        *input = row.input.or(*input);
        if let Some(out) = *out {
            referees.observe(position, seen_in_row(&row, out, *input));
        }
    }
    tell_doubts(&reader, name);
    Ok((referees, line))
}

fn seen_in_row(row: &Row, out: u32, input: Option<Input>) -> Observed {
    let line = match (row.cycle, row.status) {
        (Some(cycle), _) => line_seen(cycle),
        (None, Some(register)) if register & status::RUN == 0 => LineSeen::Silent,
        (None, Some(_)) => LineSeen::Good,
        (None, None) => LineSeen::Untold,
    };
    Observed::Cycle {
        at: Instant(row.time_ns),
        out: OutWord(out),
        input: input.and_then(Input::word).map(InWord),
        line,
    }
}
