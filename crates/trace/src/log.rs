//! A log that may go on for days: rows of what was seen on a bus, in files that take turns.
//!
//! `FILE.csv` is always the one that is written. When it is full it becomes `FILE.1.csv`, what was `FILE.1.csv` becomes
//! `FILE.2.csv`, and so on; beyond the number to keep the oldest is deleted. Only logs are renamed and deleted: a file
//! is one if its first line begins with `# encoring-log`, or if it is empty.
//!
//! | column | holds |
//! |---|---|
//! | `time_us` | microseconds on the bus's own clock, with up to three decimals |
//! | `position` | the ring position |
//! | `out`, `in` | the words, 8 hex digits; empty if they were not seen |
//! | `verdict` | one word on what the IN word is worth |
//! | `value` | the position in steps, if there is one |

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use encoring_files::{Lock, sync_folder};

use crate::columns::Decimal;

/// How the first line of every log begins.
const MARK: &[u8] = b"# encoring-log ";
const HEADER: &[u8] = b"time_us,position,out,in,verdict,value\n";
/// Rows wait for the next flush until there are so many bytes of them.
const BUFFER_BYTES: usize = 64 * 1024;
/// The longest row; any is shorter.
const ROW_BYTES_MAX: usize = 128;

/// One row of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogRow {
    /// Nanoseconds on the bus's own clock.
    pub time_ns: u64,
    /// The encoder's ring position.
    pub position: usize,
    /// The OUT word, if it was seen.
    pub out: Option<u32>,
    /// The IN word, if it was seen.
    pub input: Option<u32>,
    /// One word on what the IN word is worth.
    pub verdict: &'static str,
    /// The position in steps, if there is one.
    pub value: Option<u32>,
}

/// How much is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rotation {
    /// The most bytes of a file; it has at least one row all the same.
    pub bytes: u64,
    /// The most finished files.
    pub keep: u32,
}

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

/// A log under way. Rows are in the file after [`Log::flush`], at the latest.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    /// Everything before the rows.
    head: Vec<u8>,
    rotation: Rotation,
    file: File,
    /// A device or a pipe: neither renamed nor synchronised.
    special: bool,
    /// Bytes of the file.
    bytes: u64,
    /// Rows of this file, in the file or waiting.
    rows_here: u64,
    waiting: Vec<u8>,
    rows: u64,
    files: u64,
}

impl Log {
    /// Begins a log. A log that is there already becomes `FILE.1.csv`. Each of `remarks` becomes a line `# ...` at the
    /// head of every file, the first behind the mark.
    ///
    /// # Errors
    /// [`LogError`]; what is no log is left as it is.
    pub fn create(path: &Path, remarks: &[String], rotation: Rotation) -> Result<Self, LogError> {
        let mut head = MARK.to_vec();
        head.push(b'1');
        for (k, remark) in remarks.iter().enumerate() {
            head.extend_from_slice(if k == 0 { b" " } else { b"\n# " });
            // A line break in a remark would begin something else.
            head.extend_from_slice(remark.replace(['\n', '\r'], " ").as_bytes());
        }
        head.push(b'\n');
        head.extend_from_slice(HEADER);
        let found = fs::metadata(path);
        let special = found.as_ref().is_ok_and(|found| !found.is_file() && !found.is_dir());
        // A link is followed, so that the files take turns where it leads.
        let path = match fs::canonicalize(path) {
            Ok(real) if !special => real,
            _ => path.to_owned(),
        };
        let file = match found {
            _ if special => open_special(&path)?,
            Ok(_) => replace(&path, rotation)?,
            Err(_) => create(&path)?,
        };
        let waiting = Vec::with_capacity(BUFFER_BYTES + ROW_BYTES_MAX);
        let mut log =
            Self { path, head, rotation, file, special, bytes: 0, rows_here: 0, waiting, rows: 0, files: 0 };
        log.begin()?;
        Ok(log)
    }

    /// The file that is written.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// `true` for a device or a pipe: it gets the rows, and does not take turns.
    #[must_use]
    pub const fn is_special(&self) -> bool {
        self.special
    }

    /// Rows written so far.
    #[must_use]
    pub const fn rows(&self) -> u64 {
        self.rows
    }

    /// Files begun so far.
    #[must_use]
    pub const fn files(&self) -> u64 {
        self.files
    }

    /// Writes a row.
    ///
    /// # Errors
    /// [`LogError`]; then the file ends with a whole row.
    pub fn write(&mut self, row: &LogRow) -> Result<(), LogError> {
        let mut line = [0; ROW_BYTES_MAX];
        let length = print(row, &mut line).map_err(|cause| system(&self.path, "write", cause))?;
        let line = line.get(..length).unwrap_or_default();
        let bytes = self.bytes + (self.waiting.len() + line.len()) as u64;
        if bytes > self.rotation.bytes && self.rows_here > 0 && !self.special {
            self.rotate()?;
        }
        self.waiting.extend_from_slice(line);
        self.rows += 1;
        self.rows_here += 1;
        if self.waiting.len() >= BUFFER_BYTES { self.drain() } else { Ok(()) }
    }

    /// Brings every row onto the disk: what is there then, a power cut does not take.
    ///
    /// # Errors
    /// [`LogError`]; then the file ends with a whole row.
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.drain()?;
        if self.special {
            return Ok(());
        }
        self.file.sync_data().map_err(|cause| system(&self.path, "write", cause))
    }

    fn begin(&mut self) -> Result<(), LogError> {
        (self.bytes, self.rows_here) = (0, 0);
        self.waiting.extend_from_slice(&self.head);
        // With its head on the disk a file is known as a log whatever happens.
        self.flush()?;
        self.files += 1;
        // So that the new names survive a power cut too.
        sync_folder(&self.path).map_err(|cause| system(&self.path, "write", cause))
    }

    fn rotate(&mut self) -> Result<(), LogError> {
        self.flush()?;
        retire(&self.path, self.rotation)?;
        self.file = create(&self.path)?;
        self.begin()
    }

    fn drain(&mut self) -> Result<(), LogError> {
        let mut written = 0;
        while let Some(rest) = self.waiting.get(written..).filter(|rest| !rest.is_empty()) {
            let cause = match self.file.write(rest) {
                Ok(0) => io::ErrorKind::WriteZero.into(),
                Ok(bytes) => {
                    written += bytes;
                    continue;
                }
                Err(cause) if cause.kind() == io::ErrorKind::Interrupted => continue,
                Err(cause) => cause,
            };
            self.cut(written);
            return Err(system(&self.path, "write", cause));
        }
        self.bytes += written as u64;
        self.waiting.clear();
        Ok(())
    }

    /// Cuts off a row of which only a part fitted.
    fn cut(&mut self, written: usize) {
        let written = self.waiting.get(..written).unwrap_or_default();
        let whole = written.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        if !self.special {
            // If this fails too, the last row is a piece; there is nothing more to be done.
            let _ = self.file.set_len(self.bytes + whole as u64);
        }
        self.waiting.clear();
    }
}

fn print(row: &LogRow, line: &mut [u8]) -> io::Result<usize> {
    let room = line.len();
    let mut rest = line;
    write!(rest, "{},{},", Decimal::microseconds(row.time_ns), row.position)?;
    for word in [row.out, row.input] {
        if let Some(word) = word {
            write!(rest, "{word:08X}")?;
        }
        write!(rest, ",")?;
    }
    write!(rest, "{},", row.verdict)?;
    if let Some(value) = row.value {
        write!(rest, "{value}")?;
    }
    writeln!(rest)?;
    Ok(room - rest.len())
}

/// A new file that nobody else writes.
fn create(path: &Path) -> Result<File, LogError> {
    let file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(path)
        .map_err(|cause| system(path, "make the file", cause))?;
    lock(path, &file)?;
    Ok(file)
}

fn open_special(path: &Path) -> Result<File, LogError> {
    OpenOptions::new().write(true).open(path).map_err(|cause| system(path, "open it", cause))
}

/// Takes the place of a log that is there.
fn replace(path: &Path, rotation: Rotation) -> Result<File, LogError> {
    let mut old = OpenOptions::new().read(true).write(true).open(path);
    if let Err(cause) = &old
        && cause.kind() == io::ErrorKind::PermissionDenied
    {
        // Where only the owner of the folder may write, the file can be renamed all the same.
        old = File::open(path);
    }
    let mut old = old.map_err(|cause| system(path, "open it", cause))?;
    if !is_log(&mut old).map_err(|cause| system(path, "read it", cause))? {
        return Err(foreign(path));
    }
    lock(path, &old)?;
    if old.metadata().is_ok_and(|found| found.len() == 0) {
        return Ok(old);
    }
    retire(path, rotation)?;
    create(path)
}

fn lock(path: &Path, file: &File) -> Result<(), LogError> {
    Lock::file(file).map_err(|_| LogError { file: path.to_owned(), problem: LogProblem::InUse })
}

/// Renames the file to `.1`, and those before it upwards as far as there is no gap; the oldest goes if there are too many.
fn retire(path: &Path, rotation: Rotation) -> Result<(), LogError> {
    let keep = rotation.keep.max(1);
    let mut places = Vec::new();
    for number in 1..=keep {
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
fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().map_or_else(OsString::new, OsString::from);
    name.push(format!(".{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Whether nothing but a log is lost with the file.
fn is_log(file: &mut File) -> io::Result<bool> {
    let mut begin = Vec::with_capacity(MARK.len());
    file.take(MARK.len() as u64).read_to_end(&mut begin)?;
    Ok(begin.is_empty() || begin == MARK)
}

fn foreign(path: &Path) -> LogError {
    LogError { file: path.to_owned(), problem: LogProblem::Foreign }
}

fn system(path: &Path, doing: &'static str, cause: io::Error) -> LogError {
    LogError { file: path.to_owned(), problem: LogProblem::System { doing, cause } }
}

#[cfg(test)]
mod tests;
