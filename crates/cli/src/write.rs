//! `encoring write`: one value that shall count.

use clap::Args;
use encoring_words::Parameter;

use crate::arguments;
use crate::arguments::range::Wanted;
use crate::output::{Answer, Failure};
use crate::programming::How;

/// Write one parameter: write, check, read back, compare
///
/// The same as `program` with one value.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes: 0 done and verified; 1 refused, not confirmed, or another master is at
work; 2 bad input or usage; 3 no answer.

Examples:
  encoring write measuring-length 9999 --bus sim --at 0
  encoring write 0D 0x000119 --bus modbus-tcp://192.168.1.10 --at 2 --model ce-65-m")]
pub(crate) struct Arguments {
    /// A parameter by name, or the number of its service
    #[arg(value_parser = arguments::parameter)]
    parameter: Parameter,
    /// Decimal, or hexadecimal as 0x270F or 270Fh
    #[arg(value_parser = arguments::value)]
    value: u32,
    #[command(flatten)]
    how: How,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let values = vec![(arguments.parameter, arguments.value)];
    arguments.how.run("write", |_| Ok(Wanted { values, warnings: Vec::new() }))
}
