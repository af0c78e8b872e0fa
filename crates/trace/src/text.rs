//! Bytes of a file as UTF-8 text, whatever program wrote it.

use std::io::{self, Cursor, Read};

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use encoding_rs_io::{DecodeReaderBytes, DecodeReaderBytesBuilder};

/// What is looked at to know the encoding: at least the header, as a rule.
const LOOKED_AT: usize = 4096;

/// The text of a file: UTF-8, with lines that end with LF or CR LF.
///
/// A byte order mark says the encoding. Without one it is UTF-16 if every second byte of the first line is zero,
/// and Windows-1252 if it cannot be UTF-8.
pub(crate) struct Text<R> {
    source: DecodeReaderBytes<io::Chain<Cursor<Vec<u8>>, R>, Vec<u8>>,
    /// A CR was read, and it is not known yet what follows.
    held: bool,
    encoding: Option<&'static Encoding>,
}

impl<R: Read> Text<R> {
    pub(crate) fn new(mut source: R) -> io::Result<Self> {
        let start = start(&mut source)?;
        if start.starts_with(b"\xFF\xFE\0\0") || start.starts_with(b"\0\0\xFE\xFF") {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the text is UTF-32; save it as UTF-8"));
        }
        let encoding = encoding(&start);
        let source = DecodeReaderBytesBuilder::new()
            .encoding(encoding)
            .bom_override(true)
            .strip_bom(true)
            .utf8_passthru(true)
            .build(Cursor::new(start).chain(source));
        Ok(Self { source, held: false, encoding })
    }

    /// The encoding, if it is not UTF-8.
    pub(crate) fn encoding(&self) -> Option<&'static str> {
        self.encoding.map(Encoding::name)
    }
}

impl<R> std::fmt::Debug for Text<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Text").field("encoding", &self.encoding).finish_non_exhaustive()
    }
}

impl<R: Read> Read for Text<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let held = usize::from(std::mem::take(&mut self.held));
            if let (1, Some(first)) = (held, bytes.first_mut()) {
                *first = b'\r';
            }
            let read = self.source.read(bytes.get_mut(held..).unwrap_or_default())?;
            let mut text = bytes.get_mut(..held + read).unwrap_or_default();
            if read > 0
                && let [before @ .., b'\r'] = text
            {
                self.held = true;
                text = before;
            }
            line_ends(text);
            if !text.is_empty() || !self.held {
                return Ok(text.len());
            }
        }
    }
}

/// A CR without LF, as old spreadsheets write it, becomes LF. A CR at the end is taken for one without.
fn line_ends(text: &mut [u8]) {
    if memchr::memchr(b'\r', text).is_none() {
        return;
    }
    for index in 0..text.len() {
        if let Some([b'\r', rest @ ..]) = text.get(index..)
            && rest.first() != Some(&b'\n')
            && let Some(byte) = text.get_mut(index)
        {
            *byte = b'\n';
        }
    }
}

/// The first bytes, as far as they come at once: whoever writes into a pipe is not waited for beyond its first line.
fn start(source: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut start = vec![0; LOOKED_AT];
    let mut length = 0;
    while length < LOOKED_AT && !start.iter().take(length).any(|byte| matches!(byte, b'\n' | b'\r')) {
        match source.read(start.get_mut(length..).unwrap_or_default()) {
            Ok(0) => break,
            Ok(read) => length += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            // What came before it is read first.
            Err(error) if length == 0 => return Err(error),
            Err(_) => break,
        }
    }
    start.truncate(length);
    Ok(start)
}

fn encoding(start: &[u8]) -> Option<&'static Encoding> {
    if let Some((encoding, _)) = Encoding::for_bom(start) {
        return (encoding != encoding_rs::UTF_8).then_some(encoding);
    }
    let zeros = |odd: usize| start.iter().skip(odd).step_by(2).filter(|byte| **byte == 0).count();
    let half = start.len() / 2;
    if half >= 2 && zeros(0) == 0 && zeros(1) * 2 > half {
        Some(UTF_16LE)
    } else if half >= 2 && zeros(1) == 0 && zeros(0) * 2 > half {
        Some(UTF_16BE)
    } else {
        // A character that is cut off at the end is no reason.
        let wrong = str::from_utf8(start).err().and_then(|error| error.error_len());
        wrong.map(|_| WINDOWS_1252)
    }
}
