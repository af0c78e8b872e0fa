//! Questions before something is changed that cannot be taken back.

use std::io::{self, BufRead, IsTerminal, Write};

use crate::arguments::Consent;
use crate::interrupt::asking;
use crate::output::{Failure, bad_input};

/// What a data check does that nobody expects.
pub(crate) const CHECK_DOES: &str = "the data check ends errors that are over, and makes values count that were \
                                     programmed and never checked; the position may jump.";

/// Asks, unless `--yes` was given. Without a terminal nobody can answer, so it must have been.
pub(crate) fn confirmed(consent: Consent, what: &str) -> Result<(), Failure> {
    if consent.yes {
        return Ok(());
    }
    if !can_be_asked() {
        return Err(bad_input(format!(
            "{what}\nneeds confirmation, and standard input is no terminal; pass --yes"
        )));
    }
    asked(what)
}

/// Whether somebody sits before a terminal.
pub(crate) fn can_be_asked() -> bool {
    io::stdin().is_terminal()
}

/// Asks on standard error.
pub(crate) fn asked(what: &str) -> Result<(), Failure> {
    let mut answer = String::new();
    // A signal may come as soon as the question can be read.
    asking(|| {
        let mut terminal = io::stderr();
        write!(terminal, "{what}\nGo on? [y/N] ")?;
        terminal.flush()?;
        io::stdin().lock().read_line(&mut answer)
    })?;
    match answer.trim() {
        "y" | "Y" | "yes" => Ok(()),
        _ => Err(Failure::Refused("not done: the answer was no".to_owned())),
    }
}
