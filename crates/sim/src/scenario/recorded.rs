//! Recorded motions: each file is read once, and all together are bounded.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use encoring_trace::Reader;
use encoring_words::Instant;

use super::{MOTION_BYTES_MAX, MOTION_ROWS_MAX};
use crate::motion::Motion;

/// The files of recorded motions that a scenario names.
#[derive(Debug)]
pub struct MotionFiles<'a> {
    beside: &'a Path,
    read: BTreeMap<PathBuf, Motion>,
    rows_left: usize,
    notes: Vec<String>,
}

impl<'a> MotionFiles<'a> {
    /// Files are looked for in this folder, if they are not absolute.
    #[must_use]
    pub fn beside(folder: &'a Path) -> Self {
        Self { beside: folder, read: BTreeMap::new(), rows_left: MOTION_ROWS_MAX, notes: Vec::new() }
    }

    /// The motion of a file.
    ///
    /// # Errors
    /// What is wrong with it, or that all files together are too long.
    pub(super) fn motion(&mut self, file: &Path) -> Result<Motion, String> {
        let path = self.beside.join(file);
        if let Some(motion) = self.read.get(&path) {
            return Ok(motion.clone());
        }
        let name = path.display().to_string();
        let source =
            encoring_files::open(&path, MOTION_BYTES_MAX).map_err(|cause| format!("{name}: {cause}"))?;
        let rows = Reader::new(name.clone(), source).map_err(|cause| cause.to_string())?;
        self.notes.extend(rows.assumed().map(|assumed| format!("{name}: {assumed}")));
        let points = points(&name, rows, self.rows_left)?;
        self.rows_left -= points.len();
        let motion = Motion::Recorded { points };
        self.read.insert(path, motion.clone());
        Ok(motion)
    }

    /// What was assumed of files that were not written by us, a line each.
    pub(super) fn into_notes(self) -> Vec<String> {
        self.notes
    }
}

fn points<R: Read>(name: &str, rows: Reader<R>, rows_max: usize) -> Result<Arc<[(Instant, i64)]>, String> {
    let mut points = Vec::new();
    for row in rows {
        let row = row.map_err(|cause| cause.to_string())?;
        if points.len() == rows_max {
            let line = row.line;
            return Err(format!(
                "{name} line {line}: all recorded motions have more than {MOTION_ROWS_MAX} rows"
            ));
        }
        points.push((Instant(row.time_ns), row.raw));
    }
    if points.is_empty() { Err(format!("{name} has no rows")) } else { Ok(points.into()) }
}
