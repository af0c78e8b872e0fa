//! The lines of a file, one at a time in bounded memory.

use std::io::{self, BufRead, BufReader, Read};

use crate::error::{Error, Problem};

/// The most bytes of a line: a memory image is longer than any row.
pub(crate) const LINE_LIMIT: usize = 64 * 1024;

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
        // Room for both bytes of a line end: a line that fills it is over the limit even without them.
        let room = limit + 2;
        self.fill(room).map_err(|error| self.error(None, Problem::Read(error)))?;
        if self.line.is_empty() {
            return Ok(false);
        }
        self.ended = self.line.ends_with(b"\n");
        for end in [b'\n', b'\r'] {
            self.line.pop_if(|byte| *byte == end);
        }
        if self.line.len() > limit { Err(self.error(None, Problem::TooLong { limit })) } else { Ok(true) }
    }

    /// Goes to the next line that is not blank and no comment; false at the end of the file.
    pub(crate) fn advance_to_row(&mut self) -> Result<bool, Error> {
        while self.advance(LINE_LIMIT)? {
            if is_header_or_row(&self.line) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Takes a line with its end, or so many bytes of it. As [`BufRead::read_until`], whose search is slower.
    fn fill(&mut self, most: usize) -> io::Result<()> {
        while self.line.len() < most {
            let there = match self.source.fill_buf() {
                Ok([]) => break,
                Ok(there) => there,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            let there = there.get(..most - self.line.len()).unwrap_or(there);
            let end = memchr::memchr(b'\n', there);
            let taken = end.map_or(there.len(), |end| end + 1);
            self.line.extend_from_slice(there.get(..taken).unwrap_or_default());
            self.source.consume(taken);
            if end.is_some() {
                break;
            }
        }
        Ok(())
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

    /// The source, which may have been read beyond this line.
    pub(crate) fn source(&self) -> &R {
        self.source.get_ref()
    }

    /// The name of the file, and all behind this line.
    pub(crate) fn into_rest(self) -> (String, BufReader<R>) {
        (self.file, self.source)
    }

    pub(crate) fn error(&self, column: Option<&str>, problem: Problem) -> Error {
        self.error_at(None, column.map(str::to_owned), problem)
    }

    /// An error of another line, if one is given.
    pub(crate) fn error_at(&self, line: Option<u64>, column: Option<String>, problem: Problem) -> Error {
        // A line that is too long or cannot be read has no end either.
        let is_cut = !self.ended && !matches!(problem, Problem::TooLong { .. } | Problem::Read(_));
        let is_half = line.is_none() && !self.line.is_empty() && is_cut;
        Error { file: self.file.clone(), line: line.unwrap_or(self.number), column, problem, is_half }
    }
}

pub(crate) fn is_header_or_row(line: &[u8]) -> bool {
    !is_comment(line) && !line.trim_ascii().is_empty()
}

/// A spreadsheet puts quotes around a comment that holds a separator.
fn is_comment(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.starts_with(b"\"#")
}
