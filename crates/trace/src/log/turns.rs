//! The files of a log take turns: what is a log, which names the finished ones have, and how the next one takes its place.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use encoring_files::{Lock, folder, not_made, sole_writer};

use super::problem::{LogError, LogProblem, foreign, system};

/// How the first line of every log begins, whatever its version.
pub(super) const MARK: &[u8] = b"# encoring-log ";

/// A new file that nobody else writes.
pub(super) fn create(path: &Path) -> Result<File, LogError> {
    let file = sole_writer()
        .write(true)
        .create_new(true)
        .open(path)
        .map_err(|cause| system(path, "make the file", not_made(folder(path), cause)))?;
    lock(path, &file)?;
    Ok(file)
}

/// Keeps every other program from writing the log.
pub(super) fn lock(path: &Path, file: &File) -> Result<(), LogError> {
    Lock::file(file).map_err(|_| LogError { file: path.to_owned(), problem: LogProblem::InUse })
}

/// The names of the finished files, up to the first that is free or the last that is kept; only logs may have them.
pub(super) fn turns(path: &Path, keep: u32) -> Result<Vec<PathBuf>, LogError> {
    let mut places = Vec::new();
    for number in 1..=keep.max(1) {
        let place = numbered(path, number);
        let vacant = match File::open(&place) {
            Ok(mut found) => {
                if !found.metadata().is_ok_and(|found| found.is_file())
                    || !is_log(&mut found).unwrap_or(false)
                {
                    return Err(foreign(&place));
                }
                false
            }
            Err(cause) if cause.kind() == io::ErrorKind::NotFound => true,
            Err(cause) => return Err(system(&place, "read it", cause)),
        };
        places.push(place);
        if vacant {
            break;
        }
    }
    Ok(places)
}

/// Renames the file to `.1`, and those before it upwards as far as there is no gap; the oldest goes if there are too many.
pub(super) fn retire(path: &Path, keep: u32) -> Result<(), LogError> {
    let places = turns(path, keep)?;
    // Whatever is at the last place is a log that is beyond the number, or nothing.
    let mut to = None;
    for place in places.iter().rev() {
        match to {
            None => match fs::remove_file(place) {
                Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                    return Err(system(place, "delete it", cause));
                }
                _ => {}
            },
            Some(to) => fs::rename(place, to).map_err(|cause| system(place, "rename it", cause))?,
        }
        to = Some(place);
    }
    match to {
        Some(to) => fs::rename(path, to).map_err(|cause| system(path, "rename it", cause)),
        None => Ok(()),
    }
}

/// `FILE.csv` becomes `FILE.1.csv`.
pub(super) fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().map_or_else(OsString::new, OsString::from);
    name.push(format!(".{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Whether nothing but a log is lost with the file.
pub(super) fn is_log(file: &mut File) -> io::Result<bool> {
    let mut begin = Vec::with_capacity(MARK.len());
    file.take(MARK.len() as u64).read_to_end(&mut begin)?;
    Ok(begin.is_empty() || begin == MARK)
}
