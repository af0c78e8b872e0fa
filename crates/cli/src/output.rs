//! How every command ends and prints: the two formats, the exit codes, and pipes that close early.

use std::borrow::Cow;
use std::io;
use std::process::ExitCode;

use clap::ValueEnum;

pub(crate) mod new_file;
pub(crate) mod printer;
pub(crate) mod progress;
pub(crate) mod ratio;
pub(crate) mod reading;
pub(crate) mod time;
pub(crate) mod wrap;

/// What stands below the help of the whole program.
pub(crate) const HELP: &str = "\
Exit codes:
  0  yes, or done
  1  no: a difference, a fault, or a refusal
  2  wrong input or wrong usage
  3  no answer, or not enough was seen to answer

Examples:
  encoring sim                          # the built-in ring; Modbus TCP on 127.0.0.1:5020
  encoring watch --bus sim              # look at its encoders
  encoring decode C200270F              # what a word means
  encoring sheet ce-65-m pins           # what the manual states
  encoring calc rotary --help           # the help of a subcommand";

/// Who reads the output: people, or programs, which get one JSON object or one a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    #[default]
    Text,
    Json,
}

/// What a command found out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Yes,
    No,
    /// It could not be judged; the output says why.
    Unknown,
}

impl Answer {
    /// No if one is no, else unknown if one is.
    pub(crate) fn of_all(answers: impl IntoIterator<Item = Self>) -> Self {
        answers.into_iter().fold(Self::Yes, |all, answer| match (all, answer) {
            (Self::No, _) | (_, Self::No) => Self::No,
            (Self::Unknown, _) | (_, Self::Unknown) => Self::Unknown,
            (Self::Yes, Self::Yes) => Self::Yes,
        })
    }
}

/// Why a command has no answer.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The user's fault; the message has the place, the value and what is allowed.
    BadInput(String),
    /// The encoder, or this program, will not do it.
    Refused(String),
    /// Nobody answered, or it cannot be known.
    NoAnswer(String),
    /// The output could not be written.
    Output(io::Error),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        Self::Output(error.into())
    }
}

impl Failure {
    /// Why a step failed, and what that makes of a command that has done something before it and reports that.
    ///
    /// # Errors
    /// If nothing can be reported.
    pub(crate) fn after_the_fact(self) -> Result<(String, Answer), Self> {
        match self {
            Self::BadInput(why) | Self::Refused(why) => Ok((why, Answer::No)),
            Self::NoAnswer(why) => Ok((why, Answer::Unknown)),
            Self::Output(_) => Err(self),
        }
    }
}

/// The input is wrong; `problem` says where and how.
pub(crate) fn bad_input(problem: impl std::fmt::Display) -> Failure {
    Failure::BadInput(problem.to_string())
}

/// The exit code, after the error message if there is one.
pub(crate) fn finish(result: Result<Answer, Failure>) -> ExitCode {
    let (code, message) = match result {
        Ok(Answer::Yes) => return ExitCode::SUCCESS,
        Ok(Answer::No) => return ExitCode::from(1),
        Ok(Answer::Unknown) => return ExitCode::from(3),
        // Whoever read the output has seen enough.
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            return ExitCode::SUCCESS;
        }
        Err(Failure::BadInput(message)) => (2, message),
        Err(Failure::Refused(message)) => (1, message),
        Err(Failure::NoAnswer(message)) => (3, message),
        Err(Failure::Output(error)) => (3, format!("cannot write the output: {error}")),
    };
    note(&format!("error: {message}"));
    ExitCode::from(code)
}

/// Prints a report: for people as it displays, for programs as one JSON object.
pub(crate) fn print<V: std::fmt::Display + serde::Serialize>(format: Format, view: &V) -> io::Result<()> {
    use io::Write;
    let page = page(format, view)?;
    let mut out = io::stdout().lock();
    out.write_all(page.as_bytes())?;
    out.flush()
}

/// A report as it is printed, with the end of its last line.
pub(crate) fn page<V: std::fmt::Display + serde::Serialize>(format: Format, view: &V) -> io::Result<String> {
    let mut page = match format {
        Format::Text => view.to_string(),
        Format::Json => serde_json::to_string(view)?,
    };
    if !page.ends_with('\n') {
        page.push('\n');
    }
    Ok(page)
}

/// Prints one JSON object.
pub(crate) fn print_json<V: serde::Serialize>(view: &V) -> io::Result<()> {
    use io::Write;
    let mut page = serde_json::to_vec(view)?;
    page.push(b'\n');
    let mut out = io::stdout().lock();
    out.write_all(&page)?;
    out.flush()
}

/// A line on standard error; if that is closed there is nobody to tell.
pub(crate) fn note(line: &str) {
    use io::Write;
    let _ = writeln!(io::stderr(), "{}", without_numbers(line));
}

/// What the system said, without the numbers of its errors that the standard library writes behind.
fn without_numbers(line: &str) -> Cow<'_, str> {
    let Some((before, rest)) = line.split_once(" (os error ") else { return line.into() };
    match rest.split_once(')') {
        Some((number, rest)) if number.bytes().all(|digit| digit.is_ascii_digit()) => {
            format!("{before}{}", without_numbers(rest)).into()
        }
        _ => line.into(),
    }
}
