//! Files of lines that end with a whole line, whatever happens.

use std::fs::File;
use std::io::{self, Write};

/// Lines wait until there are so many bytes of them.
const BUFFER_BYTES: usize = 64 * 1024;

/// Writes lines to a file, many at once. When the disk is full the file ends with the last line that fitted, and
/// nothing more is written.
#[derive(Debug)]
pub struct LineFile {
    file: File,
    /// Bytes in the file: whole lines.
    bytes: u64,
    waiting: Vec<u8>,
}

impl LineFile {
    /// Goes on with an empty file, or with a device or pipe.
    #[must_use]
    pub fn new(file: File) -> Self {
        Self { file, bytes: 0, waiting: Vec::with_capacity(BUFFER_BYTES) }
    }

    /// Bytes of the file, and of what waits for it.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes + self.waiting.len() as u64
    }

    /// Brings every whole line onto the disk: what is there then, a power cut does not take.
    ///
    /// # Errors
    /// Those of the file system; then the file ends with a whole line.
    pub fn sync(&mut self) -> io::Result<()> {
        self.flush()?;
        match self.file.sync_data() {
            // A device or a pipe is no disk.
            Err(cause)
                if matches!(cause.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) =>
            {
                Ok(())
            }
            synced => synced,
        }
    }

    /// Writes the whole lines that wait.
    fn drain(&mut self) -> io::Result<()> {
        let whole = end_of_lines(&self.waiting);
        let mut written = 0;
        while let Some(rest) = self.waiting.get(written..whole).filter(|rest| !rest.is_empty()) {
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
            return Err(cause);
        }
        self.bytes += written as u64;
        self.waiting.drain(..written);
        Ok(())
    }

    /// Cuts off a line of which only a part fitted.
    fn cut(&mut self, written: usize) {
        let whole = end_of_lines(self.waiting.get(..written).unwrap_or_default());
        self.bytes += whole as u64;
        // If this fails too, or it is no file, the last line is a piece; there is nothing more to be done.
        let _ = self.file.set_len(self.bytes);
        self.waiting.clear();
    }
}

/// Behind the last whole line.
fn end_of_lines(text: &[u8]) -> usize {
    text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1)
}

impl Write for LineFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= BUFFER_BYTES {
            self.drain()?;
        }
        Ok(bytes.len())
    }

    /// Writes every whole line to the file.
    fn flush(&mut self) -> io::Result<()> {
        self.drain()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn only_whole_lines_reach_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut lines = LineFile::new(File::create(&path).unwrap());
        lines.write_all(b"one\ntw").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"");
        lines.sync().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one\n");
        lines.write_all(b"o\n").unwrap();
        assert_eq!(lines.bytes(), 8);
        lines.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one\ntwo\n");
        lines.write_all(&b"0123456789abcde\n".repeat(5_000)).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().len(), 80_008, "more than the buffer does not wait");
    }

    #[test]
    fn a_line_of_which_only_a_part_fitted_is_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut lines = LineFile::new(File::create(&path).unwrap());
        lines.write_all(b"one\n").unwrap();
        lines.flush().unwrap();
        // As if the disk had taken so much.
        lines.waiting.extend_from_slice(b"two\nthree\n");
        lines.file.write_all(b"two\nthr").unwrap();
        lines.cut(7);
        assert_eq!((fs::read(&path).unwrap(), lines.bytes()), (b"one\ntwo\n".to_vec(), 8));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_told() {
        let mut lines = LineFile::new(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
        lines.write_all(b"one\n").unwrap();
        assert_eq!(lines.flush().unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(lines.bytes(), 0);
    }
}
