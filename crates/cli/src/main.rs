//! The `encoring` command.
//!
//! A command is a file: its arguments, and a `run` that ends in an [`Answer`](output::Answer) or says why it could
//! not.

mod arguments;
mod bus;
mod calc;
mod completions;
mod decode;
mod log;
mod output;
mod read;
mod replay;
mod sim;
mod told;
mod watch;
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
    Watch(watch::Arguments),
    Log(log::Arguments),
    Completions(completions::Arguments),
}

fn main() -> ExitCode {
    output::finish(match Arguments::parse().command {
        Command::Decode(arguments) => decode::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Sim(arguments) => sim::run(&arguments),
        Command::Calc(arguments) => calc::run(&arguments),
        Command::Read(arguments) => read::run(&arguments),
        Command::Watch(arguments) => watch::run(&arguments),
        Command::Log(arguments) => log::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
    })
}
