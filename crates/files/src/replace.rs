//! Files that are there whole or not at all.

use std::borrow::Cow;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Component, Path, PathBuf, Prefix};

use tempfile::{Builder, NamedTempFile};

use crate::Lock;
use crate::lock::{sole_writer, unwritten};

/// What stands between the target's name and the digits of chance.
const MARK: &str = ".encoring-";
/// How many characters of chance end the name.
const CHANCE: usize = 6;

/// A file under way. It is written beside its target, as `.TARGET.encoring-XXXXXX`, and gets the target's name when it
/// is whole: whoever opens the target finds all of the old file or all of the new one. Dropped before that, it is gone.
///
/// It is locked as long as it is written, so what a killed program left can be told from what is under way. Only
/// remains of the same target are removed.
#[derive(Debug)]
pub struct Replacement {
    file: NamedTempFile,
    target: PathBuf,
}

impl Replacement {
    /// Begins a new file for `target`, and removes what killed writers of the same target left.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn begin(target: &Path) -> io::Result<Self> {
        let name = target.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        let folder = folder(target);
        let prefix = prefix(name);
        remove_remains(folder, &prefix);
        loop {
            let file = new_file(folder, &prefix)?;
            // Until it is locked somebody may take it for remains.
            if Lock::file(file.as_file()).is_ok() && fs::symlink_metadata(file.path()).is_ok() {
                return Ok(Self { file, target: target.to_owned() });
            }
        }
    }

    /// Takes the place of the target, whose mode it keeps.
    ///
    /// # Errors
    /// Those of the file system; then the target is as it was, unless only its folder could not be brought onto the
    /// disk.
    pub fn replace(self) -> io::Result<()> {
        if let Ok(old) = fs::symlink_metadata(&self.target)
            && old.is_file()
        {
            self.file.as_file().set_permissions(old.permissions())?;
        }
        self.file.as_file().sync_all()?;
        self.file.persist(at_any_length(&self.target))?;
        sync_folder(&self.target)
    }

    /// Becomes the target, if nothing has that name.
    ///
    /// # Errors
    /// Those of the file system, [`io::ErrorKind::AlreadyExists`] among them; then the target is as it was.
    pub fn keep_new(self) -> io::Result<()> {
        self.file.as_file().sync_all()?;
        self.file.persist_noclobber(at_any_length(&self.target))?;
        sync_folder(&self.target)
    }
}

impl Seek for Replacement {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Brings the names in the folder of `path` onto the disk, where the system can do that with a folder.
///
/// # Errors
/// Those of the disk.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    let Ok(folder) = File::open(folder(path)) else { return Ok(()) };
    match folder.sync_all() {
        Err(cause) if !matches!(cause.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            Err(cause)
        }
        _ => Ok(()),
    }
}

/// The folder that a file is in, or would be in.
#[must_use]
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

pub(crate) fn prefix(target: &OsStr) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(target);
    prefix.push(MARK);
    prefix
}

/// A file of its own name with the mode that any new file would have.
pub(crate) fn new_file(folder: &Path, prefix: &OsStr) -> io::Result<NamedTempFile> {
    let open = |path: &Path| sole_writer().read(true).write(true).create_new(true).open(path);
    let made = Builder::new().prefix(prefix).rand_bytes(CHANCE).make_in(at_any_length(folder), open);
    made.map_err(|cause| not_made(folder, cause))
}

/// The form of a path in which Windows finds also what has more than 260 characters. The library that names files does
/// not use it by itself, as the standard library does.
pub(crate) fn at_any_length(path: &Path) -> Cow<'_, Path> {
    if !cfg!(windows) {
        return Cow::Borrowed(path);
    }
    let Ok(whole) = std::path::absolute(path) else { return Cow::Borrowed(path) };
    let (mark, skipped) = match whole.components().next() {
        Some(Component::Prefix(prefix)) if matches!(prefix.kind(), Prefix::Disk(_)) => (r"\\?\", 0),
        // \\SERVER\SHARE
        Some(Component::Prefix(prefix)) if matches!(prefix.kind(), Prefix::UNC(..)) => (r"\\?\UNC\", 2),
        _ => return Cow::Owned(whole),
    };
    match whole.to_str().and_then(|text| text.get(skipped..)) {
        Some(rest) => Cow::Owned(PathBuf::from(format!("{mark}{rest}"))),
        None => Cow::Owned(whole),
    }
}

/// Why no file could be made in a folder: the operating system does not say whether file or folder is missing.
#[must_use]
pub fn not_made(folder: &Path, cause: io::Error) -> io::Error {
    if cause.kind() == io::ErrorKind::NotFound && !folder.exists() {
        io::Error::new(cause.kind(), format!("there is no folder {}; make it first", folder.display()))
    } else {
        cause
    }
}

/// Removes the files that a killed writer left. What cannot be removed is in nobody's way.
fn remove_remains(folder: &Path, prefix: &OsStr) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if is_remains(&entry.file_name(), prefix)
            && entry.file_type().is_ok_and(|kind| kind.is_file())
            && let Ok(Some(_unwritten)) = unwritten(&entry.path())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_remains(name: &OsStr, prefix: &OsStr) -> bool {
    let chance = name.as_encoded_bytes().strip_prefix(prefix.as_encoded_bytes());
    chance.is_some_and(|chance| chance.len() == CHANCE && chance.iter().all(u8::is_ascii_alphanumeric))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn the_old_file_stays_until_the_new_one_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.toml");
        fs::write(&target, "old").unwrap();
        let mut new = Replacement::begin(&target).unwrap();
        new.write_all(b"new").unwrap();
        let [under_way, _] = &names(folder.path())[..] else { panic!("two files") };
        assert!(under_way.starts_with(".a.toml.encoring-") && under_way.len() == 23, "{under_way}");
        assert_eq!(fs::read_to_string(&target).unwrap(), "old");
        new.replace().unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
        drop(Replacement::begin(&target).unwrap());
        assert_eq!(names(folder.path()), ["a.toml"]);
    }

    #[test]
    fn what_is_there_is_not_replaced_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.toml");
        let write = |text: &str| {
            let mut new = Replacement::begin(&target).unwrap();
            new.write_all(text.as_bytes()).unwrap();
            new.keep_new().map_err(|cause| cause.kind())
        };
        assert_eq!(write("one"), Ok(()));
        assert_eq!(write("two"), Err(io::ErrorKind::AlreadyExists));
        assert_eq!(fs::read_to_string(&target).unwrap(), "one");
        assert_eq!(names(folder.path()), ["a.toml"]);
    }

    #[test]
    fn only_remains_of_the_same_target_go_and_only_dead_ones() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        let strangers = [
            ".a.toml.encoring-",
            ".a.toml.encoring-1234567",
            ".a.toml.encoring-12.456",
            ".b.toml.encoring-123456",
            ".tmpABCDEF",
            "a.toml.encoring-123456",
        ];
        for name in strangers.iter().chain(&[".a.toml.encoring-123456"]) {
            fs::write(here.join(name), "").unwrap();
        }
        let alive = Replacement::begin(&here.join("a.toml")).unwrap();
        drop(Replacement::begin(&here.join("a.toml")).unwrap());
        let alive = alive.file.path().file_name().unwrap().to_str().unwrap();
        let mut expected = [&strangers[..], &[alive]].concat();
        expected.sort_unstable();
        assert_eq!(names(here), expected);
    }

    #[cfg(unix)]
    #[test]
    fn the_mode_of_the_old_file_is_kept_and_a_new_one_has_that_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode() & 0o777;
        fs::write(folder.path().join("any"), "").unwrap();
        let target = folder.path().join("a");
        Replacement::begin(&target).unwrap().replace().unwrap();
        assert_eq!(mode("a"), mode("any"));
        fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).unwrap();
        Replacement::begin(&target).unwrap().replace().unwrap();
        assert_eq!(mode("a"), 0o640);
    }
}
