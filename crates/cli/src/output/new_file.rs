//! Files that a command makes.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use encoring_files::{Existing, Replacement, folder};

use super::{Failure, bad_input};

/// Refuses a name that cannot become a file, before anything is done.
pub(crate) fn check_new_file(option: &str, file: &Path, existing: Existing) -> Result<(), Failure> {
    let refused = |why: &str| Err(bad_input(format!("{option} {}: {why}", file.display())));
    match fs::symlink_metadata(file) {
        Ok(found) if !found.is_file() => refused("not an ordinary file; name a new one"),
        Ok(_) if existing == Existing::Kept => {
            refused("it is there already; name a new one, or give --overwrite")
        }
        Err(cause) if cause.kind() != io::ErrorKind::NotFound => refused(&cause.to_string()),
        _ if !folder(file).is_dir() => {
            refused(&format!("there is no folder {}; make it, or name another", folder(file).display()))
        }
        _ => Ok(()),
    }
}

/// Why a new file is not there.
pub(crate) enum NotWritten {
    /// It could not be written.
    File(io::Error),
    /// There is nothing to write.
    Contents(Failure),
}

impl From<io::Error> for NotWritten {
    fn from(cause: io::Error) -> Self {
        Self::File(cause)
    }
}

/// Writes a file that is there whole or not at all. `option` is what named it.
pub(crate) fn write_new_file(
    option: &str,
    file: &Path,
    existing: Existing,
    write: impl FnOnce(&mut Replacement) -> Result<(), NotWritten>,
) -> Result<(), Failure> {
    check_new_file(option, file, existing)?;
    let begun = Replacement::begin(file).map_err(NotWritten::File);
    let written = begun.and_then(|mut new| {
        write(&mut new)?;
        new.flush()?;
        match existing {
            Existing::Kept => new.keep_new()?,
            Existing::Replaced => new.replace()?,
        }
        Ok(())
    });
    written.map_err(|problem| match problem {
        NotWritten::File(cause) => {
            Failure::NoAnswer(format!("{option} {}: cannot be written: {cause}", file.display()))
        }
        NotWritten::Contents(failure) => failure,
    })
}
