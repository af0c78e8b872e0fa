//! The `encoring` command.
//!
//! A command is a file: its arguments, and a `run` that ends in an [`Answer`](output::Answer) or a failure.

mod acknowledging;
mod arguments;
mod backup;
mod bus;
mod calc;
mod calculation;
mod check;
mod completions;
mod decode;
mod diagnose;
mod dialog;
#[cfg(test)]
mod help_rules;
mod interrupt;
mod log;
mod man;
mod memories;
mod news;
mod noted;
mod output;
mod preset;
mod presetting;
mod probe;
mod program;
mod programming;
mod read;
mod referee;
mod registers;
mod release;
mod replace;
mod replay;
mod restore;
mod ring;
mod scan;
mod serve;
mod sheet;
mod signals;
mod sim;
mod ssi;
mod subjects;
mod told;
mod version;
mod watch;
mod web;
mod word_view;
mod write;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Simulate, read, program and watch TR absolute encoders on INTERBUS-S
#[derive(Parser)]
#[command(name = "encoring", version, long_version = version::LONG, max_term_width = 100, after_help = output::HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// A signed number in pieces, as `-15872 9999`, or with `_` is no option, though clap takes it for one. No option begins
/// with a digit, and the readers of numbers leave spaces out.
fn number_or_option(argument: OsString) -> OsString {
    let is_number = |text: &&str| {
        let mut signs = text.chars();
        signs.next() == Some('-')
            && signs.next().is_some_and(|sign| sign.is_ascii_digit())
            && text.contains([' ', '_'])
    };
    match argument.to_str().filter(is_number) {
        Some(number) => format!(" {number}").into(),
        None => argument,
    }
}

macro_rules! commands {
    ($($name:ident $module:ident,)*) => {
        #[derive(Subcommand)]
        enum Command {
            $($name($module::Arguments),)*
        }

        fn main() -> ExitCode {
            signals::tell_files_too_long();
            output::finish(match Arguments::parse_from(std::env::args_os().map(number_or_option)).command {
                $(Command::$name(arguments) => $module::run(&arguments),)*
            })
        }
    };
}

commands! {
    Decode decode, Replay replay, Sim sim, Calc calc,
    Read read, Write write, Program program, Preset preset, Check check, Release release, Probe probe,
    Backup backup, Restore restore, Replace replace,
    Watch watch, Log log, Serve serve, Diagnose diagnose, Referee referee, Scan scan, Ring ring, Ssi ssi, Sheet sheet,
    Completions completions, Man man,
}
