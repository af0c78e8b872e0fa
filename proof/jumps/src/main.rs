//! What can be told of a jump, and recordings whose jumps are known; see docs/diagnosis.md.

mod cause;
mod decidable;
mod scene;
mod table;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Tell what can be told of a jump, and make recordings whose jumps are known.
#[derive(Parser)]
#[command(name = "jumps", max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Print the tables of docs/diagnosis.md: cause, period and speed.
    Table,
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Table => print!("{}", table::markdown()),
    }
    ExitCode::SUCCESS
}
