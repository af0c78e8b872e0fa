//! `encoring ssi`: the second output of the CE-65-M.

mod drawing;
mod encode;
mod format;

use clap::{Args, Subcommand};

use crate::output::{Answer, Failure};

/// The SSI output of the CE-65-M: what it sends
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  encoring ssi encode 9999 --bits 25
  encoring ssi encode 9999 --bits 31 --svg ak40.svg")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    question: Question,
}

#[derive(Subcommand, Debug)]
enum Question {
    Encode(encode::Arguments),
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    match &arguments.question {
        Question::Encode(arguments) => encode::run(arguments),
    }
}
