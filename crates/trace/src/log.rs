//! A log that may go on for days: rows of what was seen on a bus, in files that take turns.
//!
//! `FILE.csv` is always the one that is written. When it is full it becomes `FILE.1.csv`, what was `FILE.1.csv` becomes
//! `FILE.2.csv`, and so on; beyond the number to keep the oldest is deleted. Only logs are renamed and deleted: a file
//! is one if its first line begins with `# encoring-log`, or if it is empty. No older log takes its turn before there is
//! a word to be logged: a log that is begun often and sees nothing costs nothing.
//!
//! | column | holds |
//! |---|---|
//! | `time_us` | microseconds on the bus's own clock, with up to three decimals |
//! | `position` | the ring position |
//! | `out`, `in` | the words as `0xC200270F`, which no spreadsheet takes for a number; empty if they were not seen |
//! | `verdict` | one word on what the IN word is worth |
//! | `value` | the position in steps, if there is one |
//! | `status`, `parameter` | the diagnostic registers of the ring's master, in logs that were begun with them; empty if they were not read |
//!
//! Lines that begin with `#` stand between the rows too: what happened to the ring or the way there.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use encoring_files::{LineFile, Replacement, is_in_use, sole_writer, sync_folder};

use crate::decimal::Decimal;

mod problem;
mod turns;

pub use problem::{LogError, LogProblem};
use problem::{foreign, system};
use turns::{MARK, create, is_log, lock, numbered, retire, turns};

/// Version 1 had words without `0x`.
const VERSION: u8 = b'2';
const HEADER: &[u8] = b"time_us,position,out,in,verdict,value";
/// Rows without a word wait for the first one until there are so many bytes of them.
const AHEAD_BYTES: usize = 64 * 1024;
/// How long a full file goes on when Windows does not let it take its turn, because somebody looks at it.
const TURN_AGAIN_NS: u64 = 10_000_000_000;
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
    /// The diagnostic status of the ring's master, if it was read.
    pub status: Option<u16>,
    /// The diagnostic parameter, if it was read.
    pub parameter: Option<u16>,
}

/// Which diagnostic registers of the ring's master have a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MasterColumns {
    /// The diagnostic status.
    pub status: bool,
    /// The diagnostic parameter.
    pub parameter: bool,
}

/// How much is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rotation {
    /// The most bytes of a file; it has at least one row all the same.
    pub bytes: u64,
    /// The longest time from the first row of a file to its last, in nanoseconds on the bus's clock.
    pub time_ns: Option<u64>,
    /// The most finished files.
    pub keep: u32,
}

/// A log under way. Rows are in the file after [`Log::flush`], at the latest; those that would cost an older log wait
/// for the first word.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    /// Everything before the rows.
    head: Vec<u8>,
    columns: MasterColumns,
    rotation: Rotation,
    state: State,
    /// A device or a pipe: it does not take turns.
    special: bool,
    /// Rows of this file, in the file or waiting.
    rows_here: u64,
    /// The time of the first of them.
    first_ns: u64,
    /// When a file that could not take its turn is to try it again; 0 if it has not tried.
    again_ns: u64,
    rows: u64,
    files: u64,
}

#[derive(Debug)]
enum State {
    /// Nothing is written yet.
    Before {
        /// What has the name now, locked: an older log, or an empty file.
        found: File,
        /// Whether the older log takes its turn.
        retires: bool,
        /// `true` if the file was made for this log.
        made: bool,
        /// Rows without a word, while an older log has the name.
        ahead: Vec<u8>,
    },
    Writing(LineFile),
}

impl Log {
    /// Begins a log. A log that is there already becomes `FILE.1.csv` with the first word that is seen. Each of
    /// `remarks` becomes a line `# ...` at the head of every file, the first behind the mark.
    ///
    /// # Errors
    /// [`LogError`]; what is no log is left as it is.
    pub fn create(
        path: &Path,
        remarks: &[String],
        columns: MasterColumns,
        rotation: Rotation,
    ) -> Result<Self, LogError> {
        let found = fs::metadata(path);
        let special = found.as_ref().is_ok_and(|found| !found.is_file() && !found.is_dir());
        // A link is followed, so that the files take turns where it leads.
        let path = match fs::canonicalize(path) {
            Ok(real) if !special => real,
            _ => path.to_owned(),
        };
        let state = match found {
            _ if special => State::Writing(LineFile::new(open_special(&path)?)),
            Ok(_) => State::found(&path, rotation)?,
            Err(_) => State::Before { found: create(&path)?, retires: false, made: true, ahead: Vec::new() },
        };
        let mut log = Self {
            path,
            head: head(remarks, columns),
            columns,
            rotation,
            state,
            special,
            rows_here: 0,
            first_ns: 0,
            again_ns: 0,
            rows: 0,
            files: 0,
        };
        if special {
            log.files = 1;
            let head = log.head.clone();
            log.append(&head)?;
            log.flush()?;
        }
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

    /// The file that is deleted when the next one takes its turn, if it is there already; by the name that it has now.
    #[must_use]
    pub fn doomed(&self) -> Option<PathBuf> {
        let keep = self.rotation.keep.max(1);
        let retires = matches!(self.state, State::Before { retires: true, .. });
        let own = retires.then(|| self.path.clone());
        let places = own.into_iter().chain((1..=keep).map(|number| numbered(&self.path, number)));
        let there: Vec<_> = places.take_while(|file| file.exists()).collect();
        let all = there.len() >= keep as usize;
        there.into_iter().last().filter(|_| all && !self.special)
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
        let length =
            print(row, self.columns, &mut line).map_err(|cause| system(&self.path, "write", cause))?;
        let line = line.get(..length).unwrap_or_default();
        if let State::Before { ahead, retires, .. } = &mut self.state {
            ahead.extend_from_slice(line);
            self.rows_here += 1;
            if self.rows_here == 1 {
                self.first_ns = row.time_ns;
            }
            let begins = row.input.is_some() || !*retires || ahead.len() > AHEAD_BYTES;
            return if begins { self.begin_first() } else { Ok(()) };
        }
        if self.is_full(line.len() as u64, row.time_ns) {
            self.rotate(row.time_ns)?;
        }
        if self.rows_here == 0 {
            self.first_ns = row.time_ns;
        }
        self.rows += 1;
        self.rows_here += 1;
        self.append(line)
    }

    /// Writes a line `# ...` behind the rows so far. Before the first word it waits as a row does.
    ///
    /// # Errors
    /// [`LogError`]; then the file ends with a whole row.
    pub fn remark(&mut self, text: &str) -> Result<(), LogError> {
        let line = format!("# {}\n", one_line(text));
        match &mut self.state {
            State::Before { ahead, .. } if ahead.len() <= AHEAD_BYTES => {
                ahead.extend_from_slice(line.as_bytes());
                Ok(())
            }
            State::Before { .. } => Ok(()),
            State::Writing(_) => self.append(line.as_bytes()),
        }
    }

    /// Brings every row onto the disk: what is there then, a power cut does not take.
    ///
    /// # Errors
    /// [`LogError`]; then the file ends with a whole row.
    pub fn flush(&mut self) -> Result<(), LogError> {
        match &mut self.state {
            State::Writing(lines) => lines.sync().map_err(|cause| system(&self.path, "write", cause)),
            State::Before { .. } => Ok(()),
        }
    }

    /// Whether the next row, so many bytes long, belongs into another file.
    fn is_full(&self, bytes: u64, time_ns: u64) -> bool {
        let State::Writing(lines) = &self.state else { return false };
        let too_long = lines.bytes() + bytes > self.rotation.bytes;
        let too_late =
            self.rotation.time_ns.is_some_and(|most| time_ns.saturating_sub(self.first_ns) >= most);
        (too_long || too_late) && self.rows_here > 0 && !self.special && time_ns >= self.again_ns
    }

    /// What has the name takes its turn, and the rows that waited are written.
    fn begin_first(&mut self) -> Result<(), LogError> {
        let State::Before { found, retires, ahead, .. } = &mut self.state else { return Ok(()) };
        let ahead = std::mem::take(ahead);
        let file = if *retires {
            retire(&self.path, self.rotation.keep)?;
            create(&self.path)?
        } else {
            found.try_clone().map_err(|cause| system(&self.path, "open it", cause))?
        };
        let rows = self.rows_here;
        self.begin(file)?;
        self.rows_here = rows;
        self.rows += rows;
        self.append(&ahead)
    }

    fn begin(&mut self, file: File) -> Result<(), LogError> {
        self.rows_here = 0;
        self.again_ns = 0;
        self.state = State::Writing(LineFile::new(file));
        let head = self.head.clone();
        self.append(&head)?;
        // With its head on the disk a file is known as a log whatever happens.
        self.flush()?;
        self.files += 1;
        // So that the new names survive a power cut too.
        sync_folder(&self.path).map_err(|cause| system(&self.path, "write", cause))
    }

    fn rotate(&mut self, time_ns: u64) -> Result<(), LogError> {
        self.flush()?;
        match retire(&self.path, self.rotation.keep) {
            Err(held) if held.is_in_use() => {
                if self.again_ns == 0 {
                    let told = format!("# full, and goes on: {held}\n");
                    self.append(told.as_bytes())?;
                }
                self.again_ns = time_ns.saturating_add(TURN_AGAIN_NS);
                return Ok(());
            }
            retired => retired?,
        }
        let file = create(&self.path)?;
        self.begin(file)
    }

    fn append(&mut self, text: &[u8]) -> Result<(), LogError> {
        let State::Writing(lines) = &mut self.state else { return Ok(()) };
        lines.write_all(text).map_err(|cause| system(&self.path, "write", cause))
    }
}

impl Drop for Log {
    /// A file that was made for rows that never came is in the way.
    fn drop(&mut self) {
        if let State::Before { made: true, .. } = &self.state {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// A line break in a remark would begin something else.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

fn head(remarks: &[String], columns: MasterColumns) -> Vec<u8> {
    let mut head = MARK.to_vec();
    head.push(VERSION);
    for (k, remark) in remarks.iter().enumerate() {
        head.extend_from_slice(if k == 0 { b" " } else { b"\n# " });
        head.extend_from_slice(one_line(remark).as_bytes());
    }
    head.push(b'\n');
    head.extend_from_slice(HEADER);
    for (_, name) in
        [(columns.status, ",status"), (columns.parameter, ",parameter")].iter().filter(|(on, _)| *on)
    {
        head.extend_from_slice(name.as_bytes());
    }
    head.push(b'\n');
    head
}

fn print(row: &LogRow, columns: MasterColumns, line: &mut [u8]) -> io::Result<usize> {
    let room = line.len();
    let mut rest = line;
    write!(rest, "{},{},", Decimal::microseconds(row.time_ns), row.position)?;
    for word in [row.out, row.input] {
        if let Some(word) = word {
            write!(rest, "{word:#010X}")?;
        }
        write!(rest, ",")?;
    }
    write!(rest, "{},", row.verdict)?;
    if let Some(value) = row.value {
        write!(rest, "{value}")?;
    }
    for (on, register) in [(columns.status, row.status), (columns.parameter, row.parameter)] {
        match register {
            Some(register) if on => write!(rest, ",0x{register:04X}")?,
            None if on => write!(rest, ",")?,
            _ => {}
        }
    }
    writeln!(rest)?;
    Ok(room - rest.len())
}

fn open_special(path: &Path) -> Result<File, LogError> {
    OpenOptions::new().write(true).open(path).map_err(|cause| system(path, "open it", cause))
}

impl State {
    /// Locks a log that is there, and sees whether it can take its turn.
    fn found(path: &Path, rotation: Rotation) -> Result<Self, LogError> {
        let mut old = sole_writer().read(true).write(true).open(path);
        if let Err(cause) = &old
            && cause.kind() == io::ErrorKind::PermissionDenied
        {
            // Where only the owner of the folder may write, the file can be renamed all the same.
            old = File::open(path);
        }
        let mut found = old.map_err(|cause| {
            if is_in_use(&cause) {
                LogError { file: path.to_owned(), problem: LogProblem::InUse }
            } else {
                system(path, "open it", cause)
            }
        })?;
        if !is_log(&mut found).map_err(|cause| system(path, "read it", cause))? {
            return Err(foreign(path));
        }
        lock(path, &found)?;
        let retires = found.metadata().map_or(true, |found| found.len() > 0);
        if retires {
            turns(path, rotation.keep)?;
            // Whether a new file can be made there is seen now, and not with the first row.
            Replacement::begin(path).map_err(|cause| system(path, "make a file beside it", cause))?;
        }
        Ok(Self::Before { found, retires, made: false, ahead: Vec::new() })
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests")]
mod tests;
