//! One program at a time.
//!
//! On Windows a lock keeps readers away too, and a file that is written for days must be looked at meanwhile. There the
//! way in which such a file is opened keeps other writers away: [`sole_writer`].

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
        Ok(locked(&file).is_ok().then_some(Self(file)))
    }

    /// Locks a file that was opened by [`sole_writer`] for as long as it is open.
    ///
    /// # Errors
    /// [`Held`].
    pub fn file(file: &File) -> Result<(), Held> {
        if cfg!(windows) { Ok(()) } else { locked(file) }
    }
}

fn locked(file: &File) -> Result<(), Held> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Held),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// How a file is opened that this program alone writes and anybody may read; [`Lock::file`] is the other half.
#[must_use]
pub fn sole_writer() -> OpenOptions {
    #[cfg_attr(not(windows), expect(unused_mut, reason = "Windows has sharing modes"))]
    let mut options = OpenOptions::new();
    #[cfg(windows)]
    std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, SHARE_READ | SHARE_DELETE);
    options
}

#[cfg(windows)]
const SHARE_READ: u32 = 1;
#[cfg(windows)]
const SHARE_DELETE: u32 = 4;

/// Whether Windows refuses because another program has the file open. Elsewhere that hinders nothing.
#[must_use]
pub fn is_in_use(cause: &io::Error) -> bool {
    const SHARING_VIOLATION: i32 = 32;
    const LOCK_VIOLATION: i32 = 33;
    cfg!(windows) && matches!(cause.raw_os_error(), Some(SHARING_VIOLATION | LOCK_VIOLATION))
}

/// A file that nobody writes, and that nobody else can write as long as it is open. `None` if another program does.
pub(crate) fn unwritten(path: &Path) -> io::Result<Option<File>> {
    if cfg!(windows) {
        return match sole_writer().read(true).write(true).open(path) {
            Err(cause) if is_in_use(&cause) => Ok(None),
            opened => opened.map(Some),
        };
    }
    let file = File::open(path)?;
    Ok(locked(&file).is_ok().then_some(file))
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
