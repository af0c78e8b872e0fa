//! `encoring release`: a service bit that was left on OUT.

use std::fmt;

use clap::Args;
use encoring_bus::Bus;
use encoring_bus::release::{Release, ReleaseError, STANDS_FOR, Standing};
use encoring_station::Speed;
use serde::Serialize;

use crate::arguments::bus::{BusArguments, patience};
use crate::arguments::{Consent, Output, position};
use crate::dialog::Dialog;
use crate::output::{Answer, Failure, bad_input};

/// Clear a service bit that a killed command left in an OUT word
///
/// If a command is killed, or its gateway dies, bit 31 of OUT may stay 1. Then the encoder shows a reply and no position,
/// and every other command refuses to work.
///
/// The command shows OUT and IN, watches both for 2 s and asks. Then it reads OUT again and clears bit 31 only. If a word
/// changes while it looks, a PLC is at work, and it writes nothing.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  the service bit is 0
  1  another master is at work, not confirmed, or the service bit stays 1
  2  wrong usage
  3  no answer

Examples:
  encoring release --bus modbus-tcp://192.168.1.10 --at 2")]
pub(crate) struct Arguments {
    #[command(flatten)]
    ring: BusArguments,
    /// Ring position of the encoder, 0 to 127
    #[arg(long, value_name = "POSITION", value_parser = position)]
    at: usize,
    #[command(flatten)]
    consent: Consent,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct ReleaseView {
    position: usize,
    /// `not_needed` or `released`.
    result: &'static str,
    before: StandingView,
    after: StandingView,
}

#[derive(Serialize)]
struct StandingView {
    out: String,
    r#in: String,
}

impl From<Standing> for StandingView {
    fn from(Standing { out, input }: Standing) -> Self {
        Self { out: out.to_string(), r#in: input.to_string() }
    }
}

impl fmt::Display for ReleaseView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { position, before, after, .. } = self;
        writeln!(f, "position {position}: OUT {}, IN {}", before.out, before.r#in)?;
        match self.result {
            "released" => writeln!(f, "released: OUT {}, IN {}", after.out, after.r#in),
            _ => writeln!(f, "the service bit is not set: nothing to release, nothing was written"),
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    arguments.ring.writing("release")?;
    let mut opened = arguments.ring.open(Speed::Max)?;
    let stop = opened.stop();
    let patience = patience(None, opened.timeout())?;
    let address = opened.place();
    let mut release = Release::new(&mut *opened.bus, arguments.at, patience, &stop);
    let told = arguments.release(&mut release, &address);
    opened.close_after(&told)?;
    arguments.output.print(&told?)?;
    Ok(Answer::Yes)
}

impl Arguments {
    fn release<B: Bus + ?Sized>(
        &self,
        release: &mut Release<'_, B>,
        address: &str,
    ) -> Result<ReleaseView, Failure> {
        let failure = |error: ReleaseError, written: &str| {
            let told = format!("{address}: {error}{written}");
            match &error {
                ReleaseError::Bus(missing) if missing.is_no_encoder() => {
                    bad_input(format!("--at {}: {error}", self.at))
                }
                ReleaseError::Bus(_) | ReleaseError::Interrupted | ReleaseError::Misread { .. } => {
                    Failure::NoAnswer(told)
                }
                ReleaseError::InUse { .. } | ReleaseError::Stays { .. } => Failure::Refused(told),
            }
        };
        let unwritten = |error| failure(error, "; nothing was written");
        let position = self.at;
        let before = release.look().map_err(unwritten)?;
        if !before.out.service_bit() {
            return Ok(ReleaseView {
                position,
                result: "not_needed",
                before: before.into(),
                after: before.into(),
            });
        }
        release.watch(before).map_err(unwritten)?;
        Dialog::at_terminal(self.consent).confirmed(
            &format!(
                "position {position}: OUT holds {} and IN {}, both unchanged for {STANDS_FOR}. Bit 31 of OUT shall be \
                 cleared. No PLC may be working with this encoder.",
                before.out, before.input
            ),
        )?;
        let after = release.clear(before).map_err(|error| failure(error, ""))?;
        Ok(ReleaseView { position, result: "released", before: before.into(), after: after.into() })
    }
}
