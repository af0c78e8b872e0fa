//! What can be wrong with a file, and where.

use std::io;

use crate::decimal::Decimal;

/// Why a file was refused, and where.
#[derive(Debug, thiserror::Error)]
#[error("{file} line {line}{}: {problem}", .column.as_ref().map_or(String::new(), |name| format!(", column {name}")))]
pub struct Error {
    /// The file's name, as the caller gave it.
    pub file: String,
    /// The line of the file, from 1.
    pub line: u64,
    /// The column's name, if one column is at fault.
    pub column: Option<String>,
    /// What is wrong there.
    pub problem: Problem,
    /// The file ends within this line, which is only a part of one: the lines before it are whole.
    pub is_half: bool,
}

/// What is wrong with a line.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The source failed.
    #[error("cannot read: {0}")]
    Read(io::Error),
    /// The line does not end within the limit.
    #[error("longer than {limit} bytes")]
    TooLong {
        /// The most bytes that a line may have there.
        limit: usize,
    },
    /// The file ends before its header.
    #[error("no header, the columns are {columns}")]
    NoHeader {
        /// The names of all columns.
        columns: String,
    },
    /// The header of a recording leaves open whose rows follow.
    #[error("a recording needs the column position")]
    NoPosition,
    /// The row does not fit the header.
    #[error("{found} cell{}, {} has {expected}{}", if *.found == 1 { "" } else { "s" },
        if *.header { "the header" } else { "the first row" },
        if *.cut {
            "; the file ends within this line: delete it, or bring the rest"
        } else if *.found == 1 {
            "; a remark must begin with #"
        } else {
            ""
        })]
    Width {
        /// The number of cells in the row.
        found: usize,
        /// The number of cells that it must have.
        expected: usize,
        /// Whether it is the last line, without its end.
        cut: bool,
        /// Whether the table has a header.
        header: bool,
    },
    /// Something of a table that was not made by us, with what to type.
    #[error("{0}")]
    Table(String),
    /// A value is not what is allowed there.
    #[error("{value:?} is not {allowed}")]
    Value {
        /// The value, at most 40 characters of it.
        value: String,
        /// What would have been allowed.
        allowed: &'static str,
    },
    /// The row is earlier than the row before it.
    #[error(
        "{} is before {}, the time of the previous row",
        Decimal::microseconds(*.time_ns),
        Decimal::microseconds(*.previous_ns)
    )]
    Backwards {
        /// The row's time.
        time_ns: u64,
        /// The time of the row before it.
        previous_ns: u64,
    },
    /// Something that may be there once is there again.
    #[error("{what} {} is there twice", .name.escape_debug())]
    Twice {
        /// A column, a device or a setting.
        what: &'static str,
        /// Its name, at most 40 characters of it.
        name: String,
    },
    /// The recording is of another version.
    #[error("version {}, this program reads 1", .version.escape_debug())]
    Version {
        /// The version, at most 40 characters of it.
        version: String,
    },
}

impl Problem {
    pub(crate) fn value(value: &[u8], allowed: &'static str) -> Self {
        let allowed = if str::from_utf8(value).is_ok() { allowed } else { "UTF-8" };
        Self::Value { value: excerpt(value), allowed }
    }
}

/// The first 40 characters, so that a message stays readable whatever the file holds.
pub(crate) fn excerpt(value: &[u8]) -> String {
    let text = String::from_utf8_lossy(value);
    let more = if text.chars().nth(40).is_some() { "..." } else { "" };
    text.chars().take(40).chain(more.chars()).collect()
}
