//! `encoring read`: what is programmed in an encoder.

use std::fmt;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::Services;
use encoring_host::preset::code;
use encoring_host::service::read;
use encoring_words::explain::Meaning;
use encoring_words::{Model, Parameter};
use encoring_workshop::parameter_file::parameters_of;
use serde::Serialize;

use crate::arguments::Output;
use crate::arguments::bus::{Encoder, Target};
use crate::arguments::{Parameters, parameters};
use crate::bus::Deed;
use crate::output::{Answer, Failure};
use crate::told::{Failed, FailureView, Shown, TargetView};

/// Read what is programmed in an encoder
///
/// Changes nothing, but uses the handshake: while a value is read IN shows the reply and no position, so stop the axis
/// first. No data check is run: `encoring check` tells why a read was refused.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes: 0 read; 1 an error is pending, or another master is at work; 2 bad
usage; 3 no answer, or a value that cannot be read.

Examples:
  encoring read all --bus sim --at 2
  encoring read measuring-length --bus modbus-tcp://192.168.1.10 --at 0 --model ce-100-m
  encoring read 0D --bus sim --at 2 --format json")]
pub(crate) struct Arguments {
    /// A parameter by name or number of its service, or all
    #[arg(value_name = "PARAMETER|all", default_value = "all", value_parser = parameters)]
    parameter: Parameters,
    #[command(flatten)]
    encoder: Encoder,
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
}

/// One value.
#[derive(Serialize)]
pub(crate) struct ParameterView {
    pub(crate) service: String,
    pub(crate) name: &'static str,
    /// `None` if it could not be told from the 0 of a record that cannot be read.
    pub(crate) value: Option<u32>,
    pub(crate) value_hex: Option<String>,
    pub(crate) meaning: Option<String>,
}

impl ParameterView {
    pub(crate) fn new(parameter: Parameter, model: Model, value: Option<u32>) -> Self {
        Self {
            service: format!("{:02X}", parameter.service().number()),
            name: parameter.key(),
            value,
            value_hex: value.map(|value| format!("{value:06X}")),
            meaning: value
                .and_then(|value| Meaning::of(parameter, model, value))
                .map(|meaning| meaning.to_string()),
        }
    }
}

impl fmt::Display for ParameterView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.value.map_or_else(|| "?".to_owned(), |value| value.to_string());
        let hex = self.value_hex.as_deref().unwrap_or("");
        let meaning = self.meaning.as_deref().unwrap_or("");
        let line = format!("{:<7}  {:<18}  {value:>8}  {hex:>6}  {meaning}", self.service, self.name);
        f.write_str(line.trim_end())
    }
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
        writeln!(f, "service  parameter            decimal     hex")?;
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
    let told = opened.serve(target, |master| look(master, target, &wanted));
    opened.report(arguments.output, told, ReadView::answer)
}

fn look<S: Services<Error = MasterError>>(
    services: &mut S,
    target: Target,
    wanted: &[Parameter],
) -> Result<ReadView, Failed> {
    let (mut parameters, mut failures) = (Vec::new(), Vec::new());
    for parameter in wanted {
        // One record that cannot be read leaves the others readable.
        let value = match read(services, target.model, *parameter) {
            Ok(value) => value.sure(),
            Err(failed @ Failed::Refused(_)) => {
                failures.push(FailureView::new(&failed, target, None));
                None
            }
            Err(failed) => return Err(failed),
        };
        parameters.push(ParameterView::new(*parameter, target.model, value));
    }
    let code = code(services, target.model).ok();
    let shown = Shown::new(services.look().map_err(Failed::Bus)?, code);
    Ok(ReadView { target: TargetView::new(target), parameters, failures, shown })
}
