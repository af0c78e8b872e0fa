//! `encoring read`: what is programmed in an encoder.

use std::fmt;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::Services;
use encoring_host::preset::code;
use encoring_words::Parameter;
use encoring_workshop::reading::{ReadParameter, read_each};
use encoring_workshop::values::parameters_of;
use serde::Serialize;

use crate::arguments::Output;
use crate::arguments::bus::{Encoder, Target};
use crate::arguments::{Parameters, parameters};
use crate::bus::Deed;
use crate::noted::{EarlierView, JournalFolder, Noted};
use crate::output::{Answer, Failure};
use crate::told::{Failed, FailureView, ParameterView, Shown, TargetView};

/// Read the programmed values of an encoder
///
/// Reading changes nothing, but it uses the handshake: while it lasts IN shows the reply and no position. Stop the axis
/// first. No data check is run; if the encoder refuses a read, `encoring check` shows why.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  read
  1  read, and an error is pending; or another master is at work
  2  wrong usage
  3  no answer, or a value could not be read

Examples:
  encoring read all --bus sim --at 2
  encoring read measuring-length --bus modbus-tcp://192.168.1.10 --at 1 --model ce-100-m
  encoring read 0D --bus sim --at 2 --format json")]
pub(crate) struct Arguments {
    /// A parameter by its name or by the number of its service, or all
    #[arg(value_name = "PARAMETER|all", default_value = "all", value_parser = parameters)]
    parameter: Parameters,
    #[command(flatten)]
    encoder: Encoder,
    #[command(flatten)]
    journal: JournalFolder,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct ReadView {
    #[serde(flatten)]
    target: TargetView,
    parameters: Vec<ParameterView>,
    /// Reads that the encoder refused.
    failures: Vec<FailureView>,
    shown: Shown,
    /// A command that was begun here and is not known to have ended.
    journal: Option<EarlierView>,
}

impl ReadView {
    fn answer(&self) -> Answer {
        if self.parameters.iter().any(|parameter| parameter.value.is_none()) {
            Answer::Unknown
        } else if self.shown.error_bit {
            Answer::No
        } else {
            Answer::Yes
        }
    }
}

impl fmt::Display for ReadView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.target)?;
        writeln!(f, "service  parameter            decimal      hex")?;
        for parameter in &self.parameters {
            writeln!(f, "{parameter}")?;
        }
        writeln!(f, "position now: {}", self.shown)?;
        self.failures.iter().try_for_each(|failure| writeln!(f, "\n{failure}"))?;
        if self.shown.error_bit && self.failures.is_empty() {
            writeln!(
                f,
                "\nAn error is pending, so a ? may be 0 or a record that cannot be read; `encoring check` tells."
            )?;
        }
        if let Some(journal) = &self.journal {
            writeln!(f, "\n{journal}")?;
        }
        if self.parameters.len() > 1 {
            writeln!(
                f,
                "\nThese are the programmed values; the position may still be computed with those of before the last\n\
                 data check. The offset of a preset adjustment is not among them: no service reads it."
            )?;
        }
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let (mut opened, target) = arguments.encoder.open()?;
    let wanted: Vec<_> = match arguments.parameter {
        Parameters::All => parameters_of(target.model).collect(),
        Parameters::One(parameter) => vec![parameter],
    };
    opened.announce(target, Deed::Reads);
    let noted = arguments.journal.of(&opened, target.position);
    let told = opened.serve(target, |master| look(master, target, &wanted, noted.as_ref()));
    opened.report(arguments.output, told, ReadView::answer)
}

fn look<S: Services<Error = MasterError>>(
    services: &mut S,
    target: Target,
    wanted: &[Parameter],
    noted: Option<&Noted>,
) -> Result<ReadView, Failed> {
    let read = read_each(services, target.model, wanted.iter().copied())?;
    let view = |read: &ReadParameter<_>| ParameterView::new(read.parameter, target.model, read.value);
    let parameters = read.iter().map(view).collect();
    let refused = read.iter().filter_map(|read| read.refused.as_ref());
    let failures = refused.map(|failed| FailureView::new(failed, target, None)).collect();
    let code = code(services, target.model).ok();
    let shown = Shown::new(services.look().map_err(Failed::Bus)?, code);
    let value = |parameter| read.iter().find(|read| read.parameter == parameter)?.value;
    let journal = noted.and_then(|noted| noted.earlier(value)).map(|earlier| earlier.view());
    Ok(ReadView { target: TargetView::new(target), parameters, failures, shown, journal })
}
