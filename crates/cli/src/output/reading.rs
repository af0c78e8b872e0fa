//! A long file that is read, with a bar on the terminal of standard error, or a pipe.

use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_files::Stoppable;
use indicatif::{ProgressBar, ProgressStyle};

use crate::output::{Failure, bad_input};

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

/// What messages call a file that is named like this.
pub(crate) fn name(file: &str) -> &str {
    if file == "-" { "standard input" } else { file }
}

/// Opens a file, a pipe, or standard input for `-`. What may give nothing for long ends soon after the mark, behind a line that
/// is whole; whoever reads a file looks at the mark itself.
pub(crate) fn open(file: &str, stop: Arc<AtomicBool>) -> Result<Box<dyn BufRead>, Failure> {
    let cannot = |error: io::Error| bad_input(format!("cannot open {}: {error}", name(file)));
    if file == "-" {
        return Ok(Box::new(Stoppable::new(io::stdin(), stop).map_err(cannot)?));
    }
    let opened = File::open(file).map_err(cannot)?;
    if opened.metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return Ok(Box::new(Stoppable::new(opened, stop).map_err(cannot)?));
    }
    let bar = bar(&opened, Beside::Nothing);
    Ok(Box::new(BufReader::new(bar.wrap_read(opened))))
}
