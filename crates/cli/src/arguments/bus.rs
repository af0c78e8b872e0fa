//! Which ring, and which encoder of it.

use std::path::PathBuf;

use clap::Args;
use encoring_words::{Duration, Model};

use super::{model, span};
use crate::output::{Failure, bad_input};

/// Which ring.
#[derive(Args, Debug, Clone)]
pub(crate) struct BusArguments {
    /// Where the ring is: sim, sim:SCENARIO.toml, modbus-tcp://HOST... or modbus-rtu:DEVICE... (docs/bus.md)
    #[arg(long, value_name = "ADDRESS", global = true, required = false)]
    pub(crate) bus: Option<String>,
    /// Folder of the simulated encoders' memories; without it they are new every time.
    #[arg(long, value_name = "DIR", global = true)]
    pub(crate) state: Option<PathBuf>,
    /// Refuse everything that changes something in an encoder.
    #[arg(long, global = true)]
    pub(crate) read_only: bool,
}

/// Which encoder of the ring.
#[derive(Args, Debug, Clone)]
pub(crate) struct Encoder {
    #[command(flatten)]
    pub(crate) ring: BusArguments,
    /// Ring position of the encoder, from 0.
    #[arg(long, value_name = "POSITION", global = true, required = false)]
    pub(crate) at: Option<usize>,
    /// The encoder's model; a simulated ring knows it.
    #[arg(long, value_parser = model(), global = true)]
    pub(crate) model: Option<Model>,
    /// Steps per turn on the rating plate, 4096 or 8192.
    #[arg(long, value_name = "STEPS", value_parser = ["4096", "8192"], global = true)]
    pub(crate) native: Option<String>,
    /// How long to wait for each step of a handshake.
    #[arg(long, value_name = "TIME", default_value = "1s", value_parser = span, global = true)]
    pub(crate) patience: Duration,
}

/// What every report names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) position: usize,
    pub(crate) model: Model,
    /// Steps per turn, where they are known.
    pub(crate) native: Option<u32>,
}

impl Target {
    /// The vendor's number of the device.
    pub(crate) fn device(self) -> String {
        format!("{}.0", self.position + 1)
    }

    /// The most steps per turn that it can have.
    pub(crate) fn steps_per_turn(self) -> u32 {
        self.native.unwrap_or(match self.model {
            Model::La66 | Model::Ce100M => 4096,
            Model::Ce65M => 8192,
        })
    }
}

impl BusArguments {
    /// The address, which is always to be said: nobody shall believe that a simulation is the machine.
    pub(crate) fn address(&self) -> Result<&str, Failure> {
        self.bus.as_deref().ok_or_else(|| {
            bad_input("--bus ADDRESS is missing; --bus sim is the built-in ring, the others are in --help")
        })
    }

    /// Refuses a command that changes something.
    pub(crate) fn writing(&self, command: &str) -> Result<(), Failure> {
        if self.read_only {
            return Err(bad_input(format!("{command} changes the encoder, and --read-only is given")));
        }
        Ok(())
    }
}
