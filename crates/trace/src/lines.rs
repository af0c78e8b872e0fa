//! The lines of a file, one at a time in bounded memory.

use std::io::{BufRead, BufReader, Read};

use crate::error::{Error, Problem};

const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

#[derive(Debug)]
pub(crate) struct Lines<R> {
    file: String,
    source: BufReader<R>,
    number: u64,
    line: Vec<u8>,
    ended: bool,
}

impl<R: Read> Lines<R> {
    pub(crate) fn new(file: String, source: R) -> Self {
        Self { file, source: BufReader::new(source), number: 0, line: Vec::new(), ended: false }
    }

    /// Goes to the next line; false at the end of the file.
    pub(crate) fn advance(&mut self, limit: usize) -> Result<bool, Error> {
        self.number += 1;
        self.line.clear();
        // Room for a byte order mark and both bytes of a line end: a line that fills it is over the limit
        // even without them.
        let room = limit + BYTE_ORDER_MARK.len() + 2;
        let read = self.source.by_ref().take(room as u64).read_until(b'\n', &mut self.line);
        if read.map_err(|error| self.error(None, Problem::Read(error)))? == 0 {
            return Ok(false);
        }
        self.ended = self.line.ends_with(b"\n");
        for end in [b'\n', b'\r'] {
            self.line.pop_if(|byte| *byte == end);
        }
        if self.number == 1 && self.line.starts_with(BYTE_ORDER_MARK) {
            self.line.drain(..BYTE_ORDER_MARK.len());
        }
        if self.line.len() > limit { Err(self.error(None, Problem::TooLong { limit })) } else { Ok(true) }
    }

    /// The line without its end.
    pub(crate) fn line(&self) -> &[u8] {
        &self.line
    }

    /// Whether the line has an end; only the last of a file may have none.
    pub(crate) const fn is_ended(&self) -> bool {
        self.ended
    }

    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    pub(crate) fn error(&self, column: Option<&'static str>, problem: Problem) -> Error {
        Error { file: self.file.clone(), line: self.number, column, problem }
    }
}
