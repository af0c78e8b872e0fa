//! Why a recording cannot be read.

use encoring_texts::{Said, own};
use encoring_trace::{Error, Problem};

mod sentences {
    use encoring_texts::{Said, texts};

    texts! {
        "unread";

        fn at_line(file: &str, line: u64, problem: Said) = "{file} line {line}: {problem}";
        fn in_column(file: &str, line: u64, column: &str, problem: Said) =
            "{file} line {line}, column {column}: {problem}";
        fn in_head(file: &str, problem: Said) = "{file}: {problem}";
        fn not_read(file: &str, problem: Said) = "cannot read {file}: {problem}";
    }
}

/// What the reader of tables says, in its words.
mod elsewhere {
    use encoring_texts::retold;

    retold! {
        "unread";

        fn too_long(limit: usize);
        fn no_header(columns: &str);
        fn no_position();
        fn width(found: usize, expected: usize);
        fn value(value: &str, allowed: &str);
        fn backwards();
        fn twice(name: &str);
        fn version(version: &str);
    }
}

pub(crate) use elsewhere::RETOLD;
pub(crate) use sentences::TEXTS;

/// Why a recording cannot be read: file, line and what is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unreadable(Said);

impl Unreadable {
    /// As a sentence.
    #[must_use]
    pub const fn said(&self) -> &Said {
        &self.0
    }

    /// In the words of whoever refused it.
    pub(crate) fn new(problem: &impl ToString) -> Self {
        Self(own(problem))
    }

    /// In the words of whoever refused what stands before the rows.
    #[must_use]
    pub fn of_head(file: &str, problem: &impl ToString) -> Self {
        Self(sentences::in_head(file, own(problem)))
    }

    pub(crate) fn not_read(file: &str, problem: &impl ToString) -> Self {
        Self(sentences::not_read(file, own(problem)))
    }

    /// In the words of whoever refused what stands at a line.
    #[must_use]
    pub fn at_line(file: &str, line: u64, problem: &impl ToString) -> Self {
        Self(sentences::at_line(file, line, own(problem)))
    }
}

impl From<Unreadable> for Said {
    fn from(unreadable: Unreadable) -> Self {
        unreadable.0
    }
}

impl From<Error> for Unreadable {
    fn from(error: Error) -> Self {
        let Error { file, line, column, problem, .. } = error;
        let problem = said(&problem);
        Self(match column {
            Some(column) => sentences::in_column(&file, line, &column, problem),
            None => sentences::at_line(&file, line, problem),
        })
    }
}

fn said(problem: &Problem) -> Said {
    match problem {
        Problem::Read(_) | Problem::Table(_) => own(problem),
        Problem::TooLong { limit } => elsewhere::too_long(problem, *limit),
        Problem::NoHeader { columns } => elsewhere::no_header(problem, columns),
        Problem::NoPosition => elsewhere::no_position(problem),
        Problem::Width { found, expected, .. } => elsewhere::width(problem, *found, *expected),
        Problem::Value { value, allowed } => elsewhere::value(problem, value, allowed),
        Problem::Backwards { .. } => elsewhere::backwards(problem),
        Problem::Twice { name, .. } => elsewhere::twice(problem, name),
        Problem::Version { version } => elsewhere::version(problem, version),
    }
}
