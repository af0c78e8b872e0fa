//! Where a recording comes from, and what is said of it.

use encoring_diagnosis::{Diagnosed, RecordedSamples, Unreadable};
use encoring_station::NamedEncoder;

use super::Arguments;
use crate::arguments::{tell_assumed, tell_doubts};
use crate::interrupt::Interrupt;
use crate::output::reading;
use crate::output::{Failure, bad_input};

impl From<Unreadable> for Failure {
    fn from(unreadable: Unreadable) -> Self {
        bad_input(unreadable)
    }
}

/// Reads a file up to its end or a signal.
pub(super) fn read(file: &str, arguments: &Arguments, interrupt: &Interrupt) -> Result<Diagnosed, Failure> {
    let name = reading::name(file);
    let source = reading::open(file, interrupt.stop())?;
    let table = &arguments.table;
    let layout = (!table.says_nothing()).then(|| table.layout());
    let mut recorded = RecordedSamples::open(name, source, layout.as_ref())?;
    match recorded.table() {
        None if layout.is_some() => {
            return Err(bad_input(format!(
                "{name} says itself what its columns are; leave --columns, --decimal and --period out"
            )));
        }
        None => {}
        Some(reader) => tell_assumed(reader, name),
    }
    let named = NamedEncoder::all(name, &recorded)?;
    let diagnosed = Diagnosed::read(
        &mut recorded,
        arguments.drawn.picture(),
        |recorded| arguments.about.detector(recorded.origin_ns(), &named),
        || !interrupt.is_interrupted(),
    )?;
    if let Some(reader) = recorded.table() {
        tell_doubts(reader, name);
    }
    Ok(diagnosed)
}
