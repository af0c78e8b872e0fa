//! One program at a time.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;

/// An exclusive lock on a file, held until it is dropped or the program ends, however it ends.
///
/// Some file systems know no locks. There every lock is granted.
#[derive(Debug)]
pub struct Lock(#[expect(dead_code, reason = "the lock lasts as long as the file is open")] File);

/// Another program holds the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("another program uses it")]
pub struct Held;

impl Lock {
    /// Locks the file of this name; makes it if it is not there, and never changes what is in it. `None` if another
    /// program holds the lock.
    ///
    /// # Errors
    /// Those of the file system, and [`io::ErrorKind::InvalidInput`] for a link or anything else that is no file.
    pub fn on(path: &Path) -> io::Result<Option<Self>> {
        if fs::symlink_metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no ordinary file"));
        }
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        Ok(Self::file(&file).is_ok().then_some(Self(file)))
    }

    /// Locks an open file for as long as it is open.
    ///
    /// # Errors
    /// [`Held`].
    pub fn file(file: &File) -> Result<(), Held> {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(Held),
            Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_held_once_and_its_file_keeps_its_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        fs::write(&path, "somebody's notes").unwrap();
        let held = Lock::on(&path).unwrap();
        assert!(held.is_some());
        assert!(Lock::on(&path).unwrap().is_none());
        assert_eq!(fs::read_to_string(&path).unwrap(), "somebody's notes");
        drop(held);
        assert!(Lock::on(&path).unwrap().is_some());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_no_place_for_a_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        std::os::unix::fs::symlink(folder.path().join("elsewhere"), &path).unwrap();
        assert_eq!(Lock::on(&path).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        assert!(!folder.path().join("elsewhere").exists());
    }
}
