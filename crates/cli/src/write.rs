//! `encoring write`: one value that shall count.

use clap::Args;
use encoring_words::change::ParameterChange;

use crate::arguments;
use crate::arguments::Named;
use crate::arguments::range::Wanted;
use crate::output::{Answer, Failure, bad_input, note};
use crate::programming::How;

/// Write one parameter, or a part of one: write, check, read back, compare
///
/// It does the same as `program`, for one value. For a part it reads the whole parameter first and keeps the rest of it.
#[derive(Args, Debug)]
#[command(after_help = "\
Parts of parameters: direction rising|falling, position-code binary|gray, ssi-bits N,
ssi-code binary|gray, ssi-repetition true|false.

Exit codes:
  0  done and verified, or nothing to change
  1  refused by the encoder, not confirmed, or another master is at work
  2  wrong input or wrong usage
  3  no answer, or the values are not known afterwards

Examples:
  encoring write measuring-length 9999 --bus sim --at 0
  encoring write ssi-bits 25 --bus sim --at 2
  encoring write ssi-values bits=25,code=gray --bus sim --at 2
  encoring write 0D 000119h --bus modbus-tcp://192.168.1.10 --at 2 --model ce-65-m")]
pub(crate) struct Arguments {
    /// A parameter by its name or by the number of its service, or a part by its name
    #[arg(value_parser = arguments::named)]
    parameter: Named,
    /// The value: decimal, hexadecimal as 270Fh, 0x270F or 16#270F, or the words of a part
    #[arg(allow_negative_numbers = true)]
    value: String,
    #[command(flatten)]
    how: How,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let text = arguments.value.as_str();
    let change = match arguments.parameter {
        Named::Part(part) => ParameterChange::part(part, text),
        Named::Parameter(parameter) => ParameterChange::read(parameter, text),
    };
    let change = change.map_err(bad_input)?;
    let parameter = arguments.parameter.parameter();
    arguments.how.run("write", |target| {
        if let Some(part) = change.unknown_part(parameter, target.model) {
            let (name, model) = (part.name(), target.model);
            return Err(bad_input(format!("{}: a {model} has no {name}", parameter.key())));
        }
        let change = change.completed(parameter, target.model);
        if !change.is_whole() {
            note(&format!(
                "note: only this part of {} changes; the rest is read first and written back as it is",
                parameter.key()
            ));
        }
        Ok(Wanted { values: vec![(parameter, change)], warnings: Vec::new(), zero: None })
    })
}
