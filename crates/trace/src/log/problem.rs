//! Why a log cannot be written.

use std::io;
use std::path::{Path, PathBuf};

/// A log cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", .file.display())]
pub struct LogError {
    /// The file.
    pub file: PathBuf,
    /// Why.
    pub problem: LogProblem,
}

/// Why a log cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum LogProblem {
    /// A file of this name holds something else.
    #[error("it is there and holds no log, so it was left as it is")]
    Foreign,
    /// Somebody writes this log already.
    #[error("another program writes this log")]
    InUse,
    /// The operating system will not.
    #[error("cannot {doing}: {cause}")]
    System {
        /// What was tried.
        doing: &'static str,
        /// What the operating system says.
        cause: io::Error,
    },
}

impl LogError {
    /// Whether only another program that has the file open is in the way.
    pub(super) fn is_in_use(&self) -> bool {
        matches!(&self.problem, LogProblem::System { cause, .. } if encoring_files::is_in_use(cause))
    }
}

pub(super) fn foreign(path: &Path) -> LogError {
    LogError { file: path.to_owned(), problem: LogProblem::Foreign }
}

pub(super) fn system(path: &Path, doing: &'static str, cause: io::Error) -> LogError {
    LogError { file: path.to_owned(), problem: LogProblem::System { doing, cause } }
}
