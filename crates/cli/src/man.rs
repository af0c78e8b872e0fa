//! `encoring man`: a manual page for each command, for packages.

use std::io;
use std::path::PathBuf;

use clap::{Args, CommandFactory};

use crate::output::{Answer, Failure, bad_input};

/// Write a manual page for each command into a folder
#[derive(Args, Debug)]
#[command(
    hide = true,
    after_help = "\
Exit codes:
  0  written
  2  wrong usage
  3  a page could not be written

Examples:
  mkdir -p man1
  encoring man man1    # then: man ./man1/encoring-sim.1"
)]
pub(crate) struct Arguments {
    /// Folder for the pages, which must exist; pages of the same names are replaced
    folder: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let folder = &arguments.folder;
    if !folder.is_dir() {
        return Err(bad_input(format!("{}: not a folder; make it first, with mkdir -p", folder.display())));
    }
    let told = |problem: io::Error| {
        Failure::Output(io::Error::new(problem.kind(), format!("{}: {problem}", folder.display())))
    };
    clap_mangen::generate_to(crate::Arguments::command(), folder).map_err(told)?;
    Ok(Answer::Yes)
}
