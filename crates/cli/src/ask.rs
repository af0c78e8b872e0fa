//! Questions before something is changed that cannot be taken back.

use std::io::{self, BufRead, IsTerminal, Write};

use crate::arguments::Consent;
use crate::output::{Failure, bad_input};

/// Asks on standard error. Without a terminal nobody can answer, so `--yes` must have been given.
pub(crate) fn confirmed(consent: Consent, what: &str) -> Result<(), Failure> {
    if consent.yes {
        return Ok(());
    }
    let stdin = io::stdin();
    if !stdin.is_terminal() {
        return Err(bad_input(format!(
            "{what}\nthis asks first, and there is no terminal to ask on: give --yes"
        )));
    }
    let mut terminal = io::stderr();
    write!(terminal, "{what}\nGo on? [y/N] ")?;
    terminal.flush()?;
    let mut answer = String::new();
    stdin.lock().read_line(&mut answer)?;
    match answer.trim() {
        "y" | "Y" | "yes" => Ok(()),
        _ => Err(Failure::Refused("not done: the answer was no".to_owned())),
    }
}
