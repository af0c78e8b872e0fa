//! Reading that ends, whatever the name leads to.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// A text file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TextError {
    /// The file system will not, it is no ordinary file, or it is too long.
    #[error(transparent)]
    System(#[from] io::Error),
    /// A byte that is no part of a UTF-8 text.
    #[error("not UTF-8 text")]
    NotUtf8 {
        /// Its line, from 1.
        line: usize,
    },
}

impl TextError {
    /// The line at fault, if one is.
    #[must_use]
    pub const fn line(&self) -> Option<usize> {
        match self {
            Self::System(_) => None,
            Self::NotUtf8 { line } => Some(*line),
        }
    }
}

/// An ordinary file, of which no more than a limit is read.
#[derive(Debug)]
pub struct Bounded {
    file: File,
    left: u64,
    bytes_max: u64,
}

/// Opens an ordinary file, through links too. More than `bytes_max` bytes cannot be read from it.
///
/// # Errors
/// Those of the file system, and [`io::ErrorKind::InvalidInput`] for a folder, a pipe or a device.
pub fn open(path: &Path, bytes_max: u64) -> io::Result<Bounded> {
    // Looked at before it is opened: to open a pipe is to wait for its other end.
    let found = fs::metadata(path)?;
    if !found.is_file() {
        let what = if found.is_dir() { "a folder, no file" } else { "a pipe or a device, no ordinary file" };
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    Ok(Bounded { file: File::open(path)?, left: bytes_max, bytes_max })
}

impl Read for Bounded {
    /// Fails with [`io::ErrorKind::FileTooLarge`] where the limit ends and the file does not.
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.left > 0 {
            let read = self.file.by_ref().take(self.left).read(bytes)?;
            self.left = self.left.saturating_sub(read as u64);
            return Ok(read);
        }
        match self.file.read(&mut [0])? {
            0 => Ok(0),
            _ => {
                let problem = format!("longer than {} bytes", self.bytes_max);
                Err(io::Error::new(io::ErrorKind::FileTooLarge, problem))
            }
        }
    }
}

/// The text of an ordinary file of at most `bytes_max` bytes.
///
/// # Errors
/// [`TextError`].
pub fn read_text(path: &Path, bytes_max: u64) -> Result<String, TextError> {
    let mut bytes = Vec::new();
    open(path, bytes_max)?.read_to_end(&mut bytes)?;
    String::from_utf8(bytes).map_err(|wrong| {
        let line = line_of_byte(wrong.as_bytes(), wrong.utf8_error().valid_up_to());
        TextError::NotUtf8 { line }
    })
}

/// The line, from 1, of the byte at an offset; the last one for an offset behind the end.
#[must_use]
pub fn line_at(text: &str, offset: usize) -> usize {
    line_of_byte(text.as_bytes(), offset)
}

fn line_of_byte(text: &[u8], offset: usize) -> usize {
    let before = text.get(..offset).unwrap_or(text);
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn told(path: &Path, bytes_max: u64) -> (Option<usize>, String) {
        let error = read_text(path, bytes_max).unwrap_err();
        (error.line(), error.to_string())
    }

    #[test]
    fn the_limit_is_the_last_length_that_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        assert_eq!(told(&path, 4), (None, "longer than 4 bytes".to_owned()));
        assert_eq!(read_text(Path::new("/nowhere/at/all"), 4).unwrap_err().line(), None);
    }

    #[test]
    fn a_byte_that_is_no_text_is_told_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        fs::write(&path, b"one\ntwo\nthr\xE4e\n").unwrap();
        assert_eq!(told(&path, 100), (Some(3), "not UTF-8 text".to_owned()));
    }

    #[test]
    fn a_folder_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(told(folder.path(), 4), (None, "a folder, no file".to_owned()));
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_without_a_writer_and_a_device_without_an_end_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        for path in [&*pipe, &*link, Path::new("/dev/zero")] {
            let refusal = (None, "a pipe or a device, no ordinary file".to_owned());
            assert_eq!(told(path, 1 << 20), refusal, "{}", path.display());
        }
    }

    #[test]
    fn lines_are_counted_up_to_the_byte() {
        let lines = [(0, 1), (1, 1), (2, 2), (3, 3), (9, 3)];
        for (offset, line) in lines {
            assert_eq!(line_at("a\n\nb", offset), line, "{offset}");
        }
    }
}
