//! A long file that is read, with a bar on the terminal of standard error.

use std::fs::File;
use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

/// Files of fewer bytes are read before a bar could be.
const LONG_FILE: u64 = 8 << 20;

/// What else goes to standard output while the file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    Nothing,
    /// Rows, which would tear the bar apart if both went to the same terminal.
    Rows,
}

/// A bar over the bytes of a file; a hidden one where nobody would see it.
pub(crate) fn bar(file: &File, beside: Beside) -> ProgressBar {
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let is_torn = beside == Beside::Rows && io::stdout().is_terminal();
    if !io::stderr().is_terminal() || is_torn || length < LONG_FILE {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    match ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
