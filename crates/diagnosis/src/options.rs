//! What is said of the encoder and its axis beforehand.

use encoring_words::Model;

/// What is known of every encoder of a recording. The default is nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The model.
    pub model: Option<Model>,
    /// Steps per turn of the position, as S, N and D make them.
    pub measuring_length: Option<u32>,
    /// The highest speed of the shaft in revolutions per minute.
    pub most_rpm: Option<u32>,
    /// The highest speed of the magnet in mm/s.
    pub most_mm_s: Option<u32>,
    /// Places that somebody knows.
    pub known: Vec<KnownPlace>,
}

/// Where the axis is known to have been.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownPlace {
    /// When, in nanoseconds of the recording.
    pub time_ns: u64,
    /// The true position in steps.
    pub steps: i64,
}
