//! What the `csv` crate reads from: rows of a bounded length, each with a line feed behind it.

use std::error::Error;
use std::io::{self, Read};

use crate::error::Problem;

/// The most bytes of a row, about: what is read ahead is not counted.
pub(super) const ROW_LIMIT: usize = 1 << 16;

/// A row is longer than allowed.
#[derive(Debug, thiserror::Error)]
#[error("too long")]
struct TooLong;

/// Text for the `csv` crate.
#[derive(Debug)]
pub(super) struct Rows<R> {
    source: R,
    /// Bytes that may still be read before the next [`allow`](Self::allow).
    left: usize,
    last: u8,
    cut: bool,
}

impl<R> Rows<R> {
    pub(super) fn new(source: R) -> Self {
        Self { source, left: ROW_LIMIT, last: b'\n', cut: false }
    }

    /// Lets so many bytes be read: what one row may take.
    pub(super) fn allow(&mut self, bytes: usize) {
        self.left = bytes;
    }

    /// Whether the end was reached, and the last line had none.
    pub(super) fn is_cut(&self) -> bool {
        self.cut
    }
}

impl<R: Read> Read for Rows<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.left == 0 {
            return Err(io::Error::other(TooLong));
        }
        let most = self.left.min(bytes.len());
        let bytes = bytes.get_mut(..most).unwrap_or_default();
        let read = self.source.read(bytes)?;
        let Some(&last) = bytes.get(..read).and_then(<[u8]>::last) else {
            if self.last == b'\n' {
                return Ok(0);
            }
            self.cut = true;
            self.last = b'\n';
            return Ok(bytes.first_mut().map_or(0, |first| {
                *first = b'\n';
                1
            }));
        };
        self.left -= read;
        self.last = last;
        // Spaces at the end of a cell are left out, so CR LF and LF end a line alike, and lines can be counted.
        let read_now = bytes.get_mut(..read).unwrap_or_default();
        if memchr::memchr(b'\r', read_now).is_some() {
            read_now.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b' ');
        }
        Ok(read)
    }
}

/// What went wrong while a row was read.
pub(super) fn problem(error: csv::Error) -> Problem {
    match error.into_kind() {
        csv::ErrorKind::Io(error)
            if error.get_ref().is_some_and(<dyn Error + Send + Sync>::is::<TooLong>) =>
        {
            Problem::Table(format!(
                "a row of more than {ROW_LIMIT} bytes; a quote may be open: close it or delete it"
            ))
        }
        csv::ErrorKind::Io(error) => Problem::Read(error),
        other => Problem::Table(format!("cannot be read: {other:?}")),
    }
}
