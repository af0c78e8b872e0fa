//! Questions and answers, on a terminal or through pipes.

use std::io::{self, BufRead, Write};

use encoring_workshop::MachineMark;

use crate::arguments;
use crate::arguments::Consent;
use crate::interrupt::asking;
use crate::output::wrap::wrapped;
use crate::output::{Failure, note};

use super::steps;

/// Asks on standard error, and reads the answers from standard input; with `--yes` it asks nothing.
pub(super) struct Dialog {
    silent: bool,
}

impl Dialog {
    pub(super) const fn new(consent: Consent) -> Self {
        Self { silent: consent.yes }
    }

    /// Whether nobody is asked.
    pub(super) const fn is_silent(&self) -> bool {
        self.silent
    }

    /// Says something that whoever answers must know.
    pub(super) fn tell(&self, text: &str) {
        if !self.silent {
            note(&wrapped(text.trim_end(), 4));
        }
    }

    /// Waits until somebody is ready.
    pub(super) fn pause(&self, text: &str) -> Result<(), Failure> {
        if self.silent { Ok(()) } else { self.ask(text).map(|_| ()) }
    }

    /// Whether the answer is yes.
    pub(super) fn agrees(&self, question: &str) -> Result<bool, Failure> {
        if self.silent {
            return Ok(true);
        }
        let answer = self.ask(&format!("{question} [y/N] "))?;
        Ok(matches!(answer.as_str(), "y" | "Y" | "yes"))
    }

    /// A mark or a position; `None` if the answer is empty, or nobody is asked.
    pub(super) fn place(&self, what: &str, marks: &[MachineMark]) -> Result<Option<MachineMark>, Failure> {
        if self.silent {
            return Ok(None);
        }
        let mut list = String::new();
        for (k, mark) in marks.iter().enumerate() {
            list += &format!("\n  {}  {mark}: {}", k + 1, mark.shown);
        }
        let numbers = if marks.is_empty() { "" } else { "the number of the mark, " };
        loop {
            let answer =
                self.ask(&format!("{what}{list}\nType {numbers}= and a position as =1220, or nothing: "))?;
            if answer.is_empty() {
                return Ok(None);
            }
            let typed = answer.strip_prefix('=').map(|steps| arguments::value(steps.trim()));
            let number = arguments::value(&answer).ok().and_then(|number| {
                let place = usize::try_from(number).ok()?.checked_sub(1)?;
                marks.get(place)
            });
            match (typed, number) {
                (Some(Ok(shown)), _) => return Ok(Some(steps(shown))),
                (_, Some(mark)) => return Ok(Some(mark.clone())),
                (Some(Err(wrong)), None) => self.tell(&format!("{answer}: {wrong}")),
                (None, None) => self.tell(&format!("{answer:?} is no number of this list")),
            }
        }
    }

    /// The answer to a question, without spaces around.
    pub(super) fn ask(&self, question: &str) -> Result<String, Failure> {
        let mut answer = String::new();
        // A signal may come as soon as the question can be read.
        let read = asking(|| {
            let mut terminal = io::stderr();
            write!(terminal, "\n{}", wrapped(question, 0))?;
            terminal.flush()?;
            io::stdin().lock().read_line(&mut answer)
        })?;
        if read == 0 {
            return Err(Failure::NoAnswer(
                "the input has ended before all was answered; what was done stands above, and the \
                 same command goes on from there"
                    .to_owned(),
            ));
        }
        Ok(answer.trim().to_owned())
    }
}
