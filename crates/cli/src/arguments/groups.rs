//! Options that more than one command has, each written once.

use std::io;
use std::path::PathBuf;

use clap::Args;
use encoring_station::Speed;
use encoring_words::model::Sensor;
use encoring_words::{Duration, Model};

use super::{model, native, span};
use crate::output::{Failure, Format, bad_input, print, print_json};

/// How to print.
#[derive(Args, Debug, Clone, Copy)]
pub(crate) struct Output {
    /// Print text for people, or JSON for programs (docs/json.md)
    #[arg(long, default_value = "text", global = true)]
    pub(crate) format: Format,
}

impl Output {
    /// Prints a report for programs.
    pub(crate) fn json<V: serde::Serialize>(self, view: &V) -> io::Result<()> {
        print_json(view)
    }

    /// Prints a report.
    pub(crate) fn print<V: std::fmt::Display + serde::Serialize>(self, view: &V) -> io::Result<()> {
        print(self.format, view)
    }
}

/// Consent that is given before it is asked for.
#[derive(Args, Debug, Clone, Copy)]
pub(crate) struct Consent {
    /// Do not ask for confirmation
    #[arg(long, global = true)]
    pub(crate) yes: bool,
}

/// What the type label of an encoder says.
#[derive(Args, Debug, Clone, Copy)]
pub(crate) struct TypeLabel {
    /// Model on the encoder's type label; a simulated ring names it
    #[arg(long, value_parser = model(), global = true)]
    pub(crate) model: Option<Model>,
    /// Steps per turn on the rating plate of a rotary encoder
    #[arg(long, value_name = "STEPS", value_parser = native(), global = true)]
    pub(crate) native: Option<u32>,
}

/// The sensor with these steps per turn, unless the model is never built with it.
pub(crate) fn built_with(model: Model, steps_per_turn: u32) -> Result<Sensor, Failure> {
    let sensor = model.built_with(Sensor::Rotary { steps_per_turn });
    sensor.map_err(|wrong| bad_input(format!("--native: {wrong}")))
}

/// Where simulated encoders remember.
#[derive(Args, Debug, Clone)]
pub(crate) struct State {
    /// Folder for the simulated encoders' memories, made if it is missing [default: new encoders each time]
    #[arg(long, value_name = "DIR", global = true)]
    pub(crate) state: Option<PathBuf>,
}

/// When to end.
#[derive(Args, Debug, Clone, Copy)]
pub(crate) struct Lasting {
    /// End after this time, such as 90s or 1h30m; a plain number is seconds. On a simulated ring it is ring time
    #[arg(long = "for", value_name = "TIME", value_parser = span)]
    pub(crate) lasting: Option<Duration>,
}

/// How a simulated ring passes its time.
#[derive(Args, Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// Speed of time on a simulated ring: a factor from 0.001 to 1000, or max [default: 1]
    #[arg(long, value_name = "FACTOR|max")]
    pub(crate) speed: Option<Speed>,
}

impl Pace {
    pub(crate) fn or_real(self) -> Speed {
        self.speed.unwrap_or(Speed::REAL)
    }
}
