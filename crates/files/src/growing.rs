//! Files that grow for long and have their name when they are whole.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use crate::Lock;
use crate::lock::unwritten;
use crate::replace::{at_any_length, folder, new_file, prefix, sync_folder};

/// What becomes of a file that has the name already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// It stays, and there is no new one.
    Kept,
    /// The new one takes its place once it is whole.
    Replaced,
}

/// A file under way. Until it is whole it is called `TARGET.partial`, where it can be looked at, and is locked.
#[derive(Debug)]
pub struct Growing {
    file: File,
    target: PathBuf,
    partial: PathBuf,
    existing: Existing,
    remains: Option<PathBuf>,
}

impl Growing {
    /// Begins a file. What a killed program left of the same target is kept under another name: see
    /// [`Growing::remains`].
    ///
    /// # Errors
    /// Those of the file system; [`io::ErrorKind::AlreadyExists`] if the target is there and shall be kept,
    /// [`io::ErrorKind::InvalidInput`] if target or partial file is a folder, a link, a pipe or a device, and
    /// [`io::ErrorKind::ResourceBusy`] if another program writes the same target.
    pub fn begin(target: &Path, existing: Existing) -> io::Result<Self> {
        let name = target.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        if is_there(target)? && existing == Existing::Kept {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, "it is there already"));
        }
        let partial = with_ending(target, "partial");
        // It is locked before it has its name, so that nobody takes it for remains.
        let mut new = new_file(folder(target), &prefix(name))?;
        let locked = Lock::file(new.as_file());
        locked.map_err(|held| io::Error::new(io::ErrorKind::ResourceBusy, held))?;
        let mut remains = None;
        loop {
            match new.persist_noclobber(at_any_length(&partial)) {
                Ok(file) => {
                    sync_folder(target)?;
                    return Ok(Self { file, target: target.to_owned(), partial, existing, remains });
                }
                Err(refused) if refused.error.kind() == io::ErrorKind::AlreadyExists => new = refused.file,
                Err(refused) => return Err(refused.error),
            }
            remains = put_aside(target, &partial)?;
        }
    }

    /// Where what a killed program left is now, if it had left something.
    #[must_use]
    pub fn remains(&self) -> Option<&Path> {
        self.remains.as_deref()
    }

    /// Its name while it is under way.
    #[must_use]
    pub fn partial(&self) -> &Path {
        &self.partial
    }

    /// Another handle to write it with.
    ///
    /// # Errors
    /// Those of the system.
    pub fn writer(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// It is whole: brings it onto the disk and gives it its name.
    ///
    /// # Errors
    /// Those of the file system; [`io::ErrorKind::AlreadyExists`] if meanwhile something else has the name that shall
    /// be kept. Then it keeps the name that it has.
    pub fn finish(self) -> io::Result<()> {
        self.file.sync_all()?;
        match self.existing {
            Existing::Kept => {
                // Dropped without its name it would be deleted.
                let path = TempPath::try_from_path(at_any_length(&self.partial))?;
                path.persist_noclobber(at_any_length(&self.target)).map_err(|refused| {
                    let _ = refused.path.keep();
                    refused.error
                })?;
            }
            Existing::Replaced => {
                if is_there(&self.target)? {
                    self.file.set_permissions(fs::metadata(&self.target)?.permissions())?;
                }
                fs::rename(&self.partial, &self.target)?;
            }
        }
        sync_folder(&self.target)
    }
}

/// Whether there is a file; anything else of that name is an error.
fn is_there(path: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_file() => Ok(true),
        Ok(_) => Err(io::Error::new(io::ErrorKind::InvalidInput, "not an ordinary file; name a new one")),
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(cause) => Err(cause),
    }
}

/// Gives remains another name: `TARGET.1.partial`, or the next number that is free.
fn put_aside(target: &Path, partial: &Path) -> io::Result<Option<PathBuf>> {
    if !is_there(partial)? {
        return Ok(None);
    }
    let found = unwritten(partial)?;
    let _found =
        found.ok_or_else(|| io::Error::new(io::ErrorKind::ResourceBusy, "another program writes it"))?;
    let mut path = TempPath::try_from_path(at_any_length(partial))?;
    for number in 1_u32.. {
        let aside = with_ending(target, &format!("{number}.partial"));
        match path.persist_noclobber(at_any_length(&aside)) {
            Ok(()) => return Ok(Some(aside)),
            Err(refused) if refused.error.kind() == io::ErrorKind::AlreadyExists => path = refused.path,
            Err(refused) => {
                let _ = refused.path.keep();
                return Err(refused.error);
            }
        }
    }
    Ok(None)
}

fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path.as_os_str());
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::io::Write;

    fn text(path: &Path) -> String {
        fs::read_to_string(path).unwrap()
    }

    fn write(growing: &Growing, text: &str) {
        growing.writer().unwrap().write_all(text.as_bytes()).unwrap();
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn it_has_its_name_when_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.csv");
        let growing = Growing::begin(&target, Existing::Kept).unwrap();
        write(&growing, "one");
        assert_eq!(names(folder.path()), ["a.csv.partial"]);
        growing.finish().unwrap();
        assert_eq!((names(folder.path()), text(&target)), (vec!["a.csv".to_owned()], "one".to_owned()));
    }

    #[test]
    fn what_is_there_is_replaced_only_if_told_and_only_when_the_new_one_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.csv");
        fs::write(&target, "old").unwrap();
        let kind = Growing::begin(&target, Existing::Kept).unwrap_err().kind();
        assert_eq!(kind, io::ErrorKind::AlreadyExists);
        let growing = Growing::begin(&target, Existing::Replaced).unwrap();
        write(&growing, "new");
        assert_eq!(text(&target), "old");
        growing.finish().unwrap();
        assert_eq!((names(folder.path()), text(&target)), (vec!["a.csv".to_owned()], "new".to_owned()));
    }

    #[test]
    fn what_came_meanwhile_stays_and_so_does_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.csv");
        let growing = Growing::begin(&target, Existing::Kept).unwrap();
        write(&growing, "ours");
        fs::write(&target, "theirs").unwrap();
        assert_eq!(growing.finish().unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(text(&target), "theirs");
        assert_eq!(text(&folder.path().join("a.csv.partial")), "ours");
    }

    #[test]
    fn two_do_not_write_the_same_target_and_remains_are_kept_under_another_name() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.csv");
        for run in ["first", "second"] {
            let growing = Growing::begin(&target, Existing::Kept).unwrap();
            write(&growing, run);
            let kind = Growing::begin(&target, Existing::Kept).unwrap_err().kind();
            assert_eq!(kind, io::ErrorKind::ResourceBusy);
            // As if it had been killed: the lock goes with the last handle, the file stays.
        }
        let growing = Growing::begin(&target, Existing::Kept).unwrap();
        assert_eq!(growing.remains(), Some(&*folder.path().join("a.csv.2.partial")));
        assert_eq!(text(&folder.path().join("a.csv.1.partial")), "first");
        assert_eq!(text(&folder.path().join("a.csv.2.partial")), "second");
        assert_eq!(names(folder.path()).len(), 3);
    }

    #[cfg(unix)]
    #[test]
    fn links_and_folders_are_no_place_for_it() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = folder.path().join("elsewhere");
        fs::write(&elsewhere, "theirs").unwrap();
        for name in ["a.csv", "a.csv.partial"] {
            let path = folder.path().join(name);
            std::os::unix::fs::symlink(&elsewhere, &path).unwrap();
            for existing in [Existing::Kept, Existing::Replaced] {
                let kind = Growing::begin(&folder.path().join("a.csv"), existing).unwrap_err().kind();
                assert_eq!(kind, io::ErrorKind::InvalidInput, "{name}");
            }
            fs::remove_file(&path).unwrap();
        }
        assert_eq!(
            (names(folder.path()), text(&elsewhere)),
            (vec!["elsewhere".to_owned()], "theirs".to_owned())
        );
    }
}
