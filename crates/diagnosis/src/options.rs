//! What is said of the encoder and its axis beforehand.

use core::num::NonZeroU32;

use encoring_words::model::Sensor;
use encoring_words::{Model, ParameterSet};

/// What is known of the encoders of a recording. The default is nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The model.
    pub model: Option<Model>,
    /// What is active in the encoder.
    pub active: Option<ActiveValues>,
    /// S alone, where no more is known: the measuring length in steps of a shaft.
    pub measuring_length: Option<u32>,
    /// The highest speed of the shaft in revolutions per minute.
    pub most_rpm: Option<NonZeroU32>,
    /// The highest speed of the magnet in mm/s.
    pub most_mm_s: Option<NonZeroU32>,
    /// Places that somebody knows.
    pub known: Vec<KnownPlace>,
    /// What [`crate::Sample::line`] counts.
    pub counted: Counted,
}

/// What the number of a row counts, as it is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Counted {
    /// The lines of a file.
    #[default]
    Lines,
    /// The polls of a bus.
    Polls,
}

/// The values of an encoder that are active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActiveValues {
    /// The model.
    pub model: Model,
    /// Its sensor.
    pub sensor: Sensor,
    /// Its values.
    pub parameters: ParameterSet,
}

/// Where the axis is known to have been.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownPlace {
    /// When, in nanoseconds of the recording.
    pub time_ns: u64,
    /// The true position in steps.
    pub steps: i64,
}
