//! `encoring completions`: what a shell needs to complete commands and options.

use std::io::{self, Write};

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::output::{Answer, Failure};

/// Print a completion script for a shell
///
/// Open a new shell afterwards.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  printed
  2  wrong usage

Examples:
  mkdir -p ~/.local/share/bash-completion/completions ~/.config/fish/completions
  encoring completions bash > ~/.local/share/bash-completion/completions/encoring
  encoring completions fish > ~/.config/fish/completions/encoring.fish
  encoring completions zsh > \"${fpath[1]}/_encoring\"")]
pub(crate) struct Arguments {
    /// The shell
    shell: Shell,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Arguments::command(), "encoring", &mut script);
    io::stdout().lock().write_all(&script)?;
    Ok(Answer::Yes)
}
