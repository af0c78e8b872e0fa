//! Questions and answers, on a terminal or through a pipe; nothing that cannot be taken back is done before a yes.

use std::cell::Cell;
use std::io::{self, BufRead, IsTerminal, Write};

use encoring_workshop::MachineMark;

use crate::arguments;
use crate::arguments::Consent;
use crate::interrupt::asking;
use crate::output::wrap::wrapped;
use crate::output::{Failure, bad_input, note};

/// What a data check does that nobody expects.
pub(crate) const CHECK_DOES: &str = "the data check ends errors that are over, and makes values count that were \
                                     programmed and never checked; the position may jump.";

/// Asks on standard error, and reads the answers from standard input.
pub(crate) struct Dialog {
    answers: Answers,
    /// So many questions were asked.
    asked: Cell<u32>,
}

/// Who answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answers {
    /// Nobody is asked: `--yes`.
    Given,
    /// A person before a terminal.
    Terminal,
    /// Whoever writes to standard input.
    Anyone,
}

/// Why something was not done.
pub(crate) enum Undone {
    /// The answer was no.
    Declined,
    /// Nobody answers any more.
    InputEnded,
    Failed(Failure),
}

impl From<Failure> for Undone {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

impl From<Undone> for Failure {
    fn from(undone: Undone) -> Self {
        match undone {
            Undone::Declined => Self::Refused("not done: the answer was no".to_owned()),
            Undone::InputEnded => Self::NoAnswer(
                "the input has ended before all was answered; what was done stands above, and the same command goes on \
                 from there"
                    .to_owned(),
            ),
            Undone::Failed(failure) => failure,
        }
    }
}

impl Dialog {
    /// Consent to one thing, which a person before a terminal gives.
    pub(crate) const fn at_terminal(consent: Consent) -> Self {
        Self::with(consent, Answers::Terminal)
    }

    /// A guide step by step, which a pipe may answer.
    pub(crate) const fn guiding(consent: Consent) -> Self {
        Self::with(consent, Answers::Anyone)
    }

    const fn with(consent: Consent, answers: Answers) -> Self {
        let answers = if consent.yes { Answers::Given } else { answers };
        Self { answers, asked: Cell::new(0) }
    }

    /// Whether nobody is asked.
    pub(crate) fn is_silent(&self) -> bool {
        self.answers == Answers::Given
    }

    /// Whether somebody may answer a question.
    pub(crate) fn can_ask(&self) -> bool {
        match self.answers {
            Answers::Given => false,
            Answers::Terminal => io::stdin().is_terminal(),
            Answers::Anyone => true,
        }
    }

    /// Asks for consent, unless it was given.
    pub(crate) fn confirmed(&self, what: &str) -> Result<(), Undone> {
        if self.is_silent() {
            return Ok(());
        }
        if !self.can_ask() {
            let told = format!("{what}\nneeds confirmation, and standard input is no terminal; pass --yes");
            return Err(bad_input(told).into());
        }
        match self.agrees(&format!("{what}\nGo on?")) {
            Ok(true) => Ok(()),
            Ok(false) => Err(Undone::Declined),
            Err(Undone::InputEnded) if self.asked.get() == 1 => {
                Err(bad_input("\nnothing was done: it needs confirmation, and nobody answers; pass --yes")
                    .into())
            }
            Err(undone) => Err(undone),
        }
    }

    /// Says something that whoever answers must know.
    pub(crate) fn tell(&self, text: &str) {
        if !self.is_silent() {
            note(&wrapped(text.trim_end(), 4));
        }
    }

    /// Waits until somebody is ready.
    pub(crate) fn pause(&self, text: &str) -> Result<(), Undone> {
        if self.is_silent() { Ok(()) } else { self.ask(text).map(|_| ()) }
    }

    /// Whether the answer is yes.
    fn agrees(&self, question: &str) -> Result<bool, Undone> {
        let answer = self.ask(&format!("{question} [y/N] "))?;
        Ok(matches!(answer.as_str(), "y" | "Y" | "yes"))
    }

    /// A mark or a position up to the largest that the encoder shows; `None` if the answer is empty, or nobody is asked.
    pub(crate) fn place(
        &self,
        what: &str,
        marks: &[MachineMark],
        largest: u32,
    ) -> Result<Option<MachineMark>, Undone> {
        if self.is_silent() {
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
                (Some(Ok(shown)), _) if shown > largest => {
                    self.tell(&format!(
                        "{shown} is above the measuring length {largest}; type a smaller position"
                    ));
                }
                (Some(Ok(shown)), _) => return Ok(Some(steps(shown))),
                (_, Some(mark)) => return Ok(Some(mark.clone())),
                (Some(Err(wrong)), None) => self.tell(&format!("{answer}: {wrong}")),
                (None, None) => self.tell(&format!("{answer:?} is no number of this list")),
            }
        }
    }

    /// The answer to a question, without spaces around.
    pub(crate) fn ask(&self, question: &str) -> Result<String, Undone> {
        self.asked.set(self.asked.get().saturating_add(1));
        let mut answer = String::new();
        // A signal may come as soon as the question can be read.
        let read = asking(|| {
            let mut terminal = io::stderr();
            write!(terminal, "\n{}", wrapped(question, 0))?;
            terminal.flush()?;
            io::stdin().lock().read_line(&mut answer)
        });
        match read.map_err(Failure::from)? {
            0 => Err(Undone::InputEnded),
            _ => Ok(answer.trim().to_owned()),
        }
    }
}

/// A place that only its position names.
pub(crate) fn steps(shown: u32) -> MachineMark {
    MachineMark { name: format!("position {shown}"), shown, reference: None }
}
