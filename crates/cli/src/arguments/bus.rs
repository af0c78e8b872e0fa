//! Which ring, and which encoder of it.

use clap::Args;
use encoring_words::{Duration, Model};

use super::{State, TypeLabel, position, span};
use crate::output::{Failure, bad_input};

/// Where the ring is.
#[derive(Args, Debug, Clone)]
pub(crate) struct Address {
    /// Address of the ring: sim, sim:SCENARIO.toml, modbus-tcp://HOST or modbus-rtu:DEVICE (docs/bus.md)
    #[arg(long, value_name = "ADDRESS", global = true, required = false)]
    bus: Option<String>,
}

/// Which ring.
#[derive(Args, Debug, Clone)]
pub(crate) struct BusArguments {
    #[command(flatten)]
    pub(crate) place: Address,
    #[command(flatten)]
    pub(crate) memories: State,
    /// Refuse everything that changes an encoder
    #[arg(long, global = true)]
    pub(crate) read_only: bool,
}

/// Which encoder of the ring.
#[derive(Args, Debug, Clone)]
pub(crate) struct Encoder {
    #[command(flatten)]
    pub(crate) ring: BusArguments,
    /// Ring position of the encoder, 0 to 127
    #[arg(long, value_name = "POSITION", global = true, required = false, value_parser = position)]
    pub(crate) at: Option<usize>,
    #[command(flatten)]
    pub(crate) label: TypeLabel,
    /// Longest wait for each step of a handshake, at least 3 time-outs of the address [default: 2s, or 4 time-outs if that is
    /// longer]
    #[arg(long, value_name = "TIME", value_parser = span, global = true)]
    pub(crate) patience: Option<Duration>,
}

/// Who says which model an encoder is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The simulated ring, which knows.
    Ring,
    /// The user, who may be wrong.
    User,
}

/// What every report names.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) position: usize,
    pub(crate) model: Model,
    /// Steps per turn, where they are known.
    pub(crate) native: Option<u32>,
    /// Who says so.
    pub(crate) source: Source,
    /// How long each step of a handshake with it is waited for.
    pub(crate) patience: Duration,
}

impl Target {
    /// The vendor's number of the device.
    pub(crate) fn device(self) -> String {
        format!("{}.0", self.position + 1)
    }

    /// The steps per turn, or the most that it can have.
    pub(crate) fn steps_per_turn(self) -> Option<u32> {
        self.native.or(self.model.steps_per_turn().last().copied())
    }
}

impl Address {
    /// Whether one was said.
    pub(crate) const fn is_given(&self) -> bool {
        self.bus.is_some()
    }

    /// The address, which is always to be said: nobody shall believe that a simulation is the machine.
    pub(crate) fn get(&self) -> Result<&str, Failure> {
        self.bus.as_deref().ok_or_else(|| {
            bad_input("--bus ADDRESS is missing; --bus sim is the built-in ring, the others are in --help")
        })
    }
}

/// As long as a person waits for a step, and far longer than the slowest service takes.
const PATIENCE_DEFAULT: Duration = Duration::from_millis(2_000);

/// How long to wait for each step, if a lost answer costs as much as `timeout`.
pub(crate) fn patience(given: Option<Duration>, timeout: Duration) -> Result<Duration, Failure> {
    let times = |factor: u64| Duration::from_nanos(timeout.as_nanos().saturating_mul(factor));
    match given {
        None => Ok(PATIENCE_DEFAULT.max(times(4))),
        // One answer may be lost, and so may the one after it.
        Some(given) if given < times(3) => Err(bad_input(format!(
            "--patience {given}: less than three time-outs of {timeout}, so one lost answer could end the command; give at \
             least {}, or a shorter timeout_ms in the address",
            times(3)
        ))),
        Some(given) => Ok(given),
    }
}

impl BusArguments {
    /// Refuses a command that changes something.
    pub(crate) fn writing(&self, command: &str) -> Result<(), Failure> {
        if self.read_only {
            return Err(bad_input(format!(
                "{command} changes the encoder, and --read-only refuses that; leave --read-only out"
            )));
        }
        Ok(())
    }
}
