//! `encoring ssi`: the second output of the CE-65-M.

mod capture;
mod captured;
mod decode;
mod drawing;
mod encode;
mod format;
mod guess;
mod sweep;

use clap::{Args, Subcommand};

use crate::output::{Answer, Failure};

/// Encode, capture and decode the SSI output of the CE-65-M
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  encoring ssi encode 9999 --bits 25
  encoring ssi encode 9999 --bits 31 --svg ak40.svg
  encoring ssi capture --out capture.sr
  encoring ssi guess capture.sr
  encoring ssi decode capture.sr --bits 25")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    question: Question,
}

#[derive(Subcommand, Debug)]
enum Question {
    Encode(encode::Arguments),
    Decode(decode::Arguments),
    Guess(guess::Arguments),
    Capture(capture::Arguments),
    Sweep(sweep::Arguments),
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    match &arguments.question {
        Question::Encode(arguments) => encode::run(arguments),
        Question::Decode(arguments) => decode::run(arguments),
        Question::Guess(arguments) => guess::run(arguments),
        Question::Capture(arguments) => capture::run(arguments),
        Question::Sweep(arguments) => sweep::run(arguments),
    }
}
