//! What a recording itself says of its encoders: their models, and what is active by their memories.

use std::io::BufRead;
use std::str::FromStr;

use encoring_diagnosis::{ActiveValues, Options, RecordedSamples, Unreadable};
use encoring_encoder::{Encoder, Terminals};
use encoring_sim::device_line;
use encoring_trace::{DeviceLine, LoggedEncoder};
use encoring_words::{Instant, Model};

/// An encoder that a recording names.
#[derive(Clone, Debug)]
pub struct NamedEncoder {
    /// Its ring position.
    pub position: u8,
    /// Its model.
    pub model: Model,
    /// What is active by its memory; `None` where the recording has none.
    pub active: Option<ActiveValues>,
    /// Its measuring length in steps, if the head of a log has it.
    pub measuring_length: Option<u32>,
}

impl NamedEncoder {
    /// All that a recording names.
    ///
    /// # Errors
    /// [`Unreadable`] if there are no such encoders.
    pub fn all<R: BufRead>(name: &str, recorded: &RecordedSamples<R>) -> Result<Vec<Self>, Unreadable> {
        match recorded.devices() {
            [] => recorded.logged().iter().map(|encoder| Self::logged(name, encoder)).collect(),
            recording => recording.iter().map(|device| Self::with_memory(name, device)).collect(),
        }
    }

    /// The model of all of them, if it is one.
    #[must_use]
    pub fn only_model(named: &[Self]) -> Option<Model> {
        let first = named.first()?.model;
        named.iter().all(|other| other.model == first).then_some(first)
    }

    /// What is known of it; the rest is that of `all`.
    #[must_use]
    pub fn options(&self, all: &Options) -> Options {
        let Self { model, active, measuring_length, .. } = *self;
        Options { model: Some(model), active, measuring_length, ..all.clone() }
    }

    /// One that a recording starts from.
    fn with_memory(name: &str, device: &DeviceLine) -> Result<Self, Unreadable> {
        let wrong = |error: device_line::Error| {
            Unreadable::at_line(name, device.line, &format!("device {}: {error}", device.position))
        };
        let (unit, mut memory) = device_line::from_device(device).map_err(wrong)?;
        let encoder = Encoder::power_up(&unit, Instant::ZERO, &Terminals::default(), &mut memory);
        let (model, sensor) = (unit.model(), unit.sensor());
        let active = ActiveValues { model, sensor, parameters: *encoder.parameters().active() };
        Ok(Self { position: device.position, model, active: Some(active), measuring_length: None })
    }

    /// One that the head of a log names.
    fn logged(name: &str, encoder: &LoggedEncoder) -> Result<Self, Unreadable> {
        let LoggedEncoder { position, ref model, measuring_length } = *encoder;
        let wrong = |error| {
            Unreadable::of_head(
                name,
                &format!("the head of the log names encoder {position} {model}: {error}"),
            )
        };
        let model = Model::from_str(model).map_err(wrong)?;
        Ok(Self { position, model, active: None, measuring_length })
    }
}
