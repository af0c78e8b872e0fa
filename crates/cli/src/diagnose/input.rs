//! Where a recording comes from, and what is said of it.

use std::str::FromStr;

use encoring_diagnosis::{ActiveValues, Diagnosed, RecordedSamples, Unreadable};
use encoring_encoder::{Encoder, Terminals};
use encoring_sim::device_line;
use encoring_trace::{DeviceLine, LoggedEncoder};
use encoring_words::{Instant, Model};

use super::Arguments;
use super::about::NamedEncoder;
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
    let named = match recorded.devices() {
        [] => logged(name, recorded.logged())?,
        recording => devices(name, recording)?,
    };
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

/// The encoders of a recording, with what is active by their memories.
fn devices(name: &str, devices: &[DeviceLine]) -> Result<Vec<NamedEncoder>, Failure> {
    let named = |device: &DeviceLine| {
        let wrong = |error: device_line::Error| {
            bad_input(format!("{name} line {}: device {}: {error}", device.line, device.position))
        };
        let (unit, mut memory) = device_line::from_device(device).map_err(wrong)?;
        let encoder = Encoder::power_up(&unit, Instant::ZERO, &Terminals::default(), &mut memory);
        let (model, sensor) = (unit.model(), unit.sensor());
        let active = ActiveValues { model, sensor, parameters: *encoder.parameters().active() };
        Ok(NamedEncoder { position: device.position, model, active: Some(active), measuring_length: None })
    };
    devices.iter().map(named).collect()
}

/// The encoders that the head of a log names.
fn logged(name: &str, encoders: &[LoggedEncoder]) -> Result<Vec<NamedEncoder>, Failure> {
    let named = |encoder: &LoggedEncoder| {
        let LoggedEncoder { position, ref model, measuring_length } = *encoder;
        let wrong = |error| {
            bad_input(format!("{name}: the head of the log names encoder {position} {model}: {error}"))
        };
        let model = Model::from_str(model).map_err(wrong)?;
        Ok(NamedEncoder { position, model, active: None, measuring_length })
    };
    encoders.iter().map(named).collect()
}
