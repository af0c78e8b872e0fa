//! The `encoring` command.
//!
//! A command is a file: its arguments, and a `run` that ends in an [`Answer`](output::Answer) or says why it could
//! not.

mod arguments;
mod ask;
mod bus;
mod calc;
mod check;
mod completions;
mod decode;
mod output;
mod preset;
mod program;
mod read;
mod replay;
mod sim;
mod told;
mod word_view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// TR absolute encoders on INTERBUS-S, as software.
#[derive(Parser)]
#[command(name = "encoring", version, max_term_width = 100, after_help = output::EXIT_CODES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Decode(decode::Arguments),
    Replay(replay::Arguments),
    Sim(sim::Arguments),
    Calc(calc::Arguments),
    Read(read::Arguments),
    Write(program::WriteArguments),
    Program(program::Arguments),
    Preset(preset::Arguments),
    Check(check::Arguments),
    Completions(completions::Arguments),
}

fn main() -> ExitCode {
    output::finish(match Arguments::parse().command {
        Command::Decode(arguments) => decode::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Sim(arguments) => sim::run(&arguments),
        Command::Calc(arguments) => calc::run(&arguments),
        Command::Read(arguments) => read::run(&arguments),
        Command::Write(arguments) => program::write(&arguments),
        Command::Program(arguments) => program::run(&arguments),
        Command::Preset(arguments) => preset::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
    })
}
