//! The values of an encoder in a file, before they are changed.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use encoring_words::{InWord, Model, Parameter};

use crate::parameter_file::{ParameterFile, ParameterFileError};

/// When and where a backup was made.
#[derive(Clone, Copy, Debug)]
pub struct BackupOrigin<'a> {
    /// When.
    pub at: SystemTime,
    /// Address of the bus, as it was named.
    pub bus: &'a str,
    /// Ring position of the encoder.
    pub position: usize,
    /// What IN showed, if it was seen.
    pub shown: Option<InWord>,
}

/// What became of a backup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BackupKept {
    /// It is a new file.
    Written,
    /// The file was there and holds the same values.
    AlreadyThere,
}

impl BackupOrigin<'_> {
    fn time(&self) -> String {
        humantime::format_rfc3339_seconds(self.at).to_string()
    }

    /// The name of a backup that was given none.
    #[must_use]
    pub fn file_name(&self, model: Model) -> PathBuf {
        let name = format!("backup-{model}-at-{}-{}.toml", self.position, self.time());
        // Windows allows no colons.
        PathBuf::from(name.replace(':', ""))
    }

    /// The backup. `None` stands for a value that could not be read: it is named in a remark.
    pub fn backup(
        &self,
        model: Model,
        native: Option<u32>,
        values: impl IntoIterator<Item = (Parameter, Option<u32>)>,
    ) -> ParameterFile {
        let shown = self.shown.map_or_else(|| "no word".to_owned(), |word| word.to_string());
        let mut file = ParameterFile {
            model,
            native,
            remarks: vec![
                format!("as it was before it was programmed, {}", self.time()),
                format!("{}, position {}", self.bus, self.position),
                format!("IN showed {shown}"),
                "the offset of a preset adjustment is not here: no service reads it".to_owned(),
            ],
            values: Vec::new(),
        };
        for (parameter, value) in values {
            match value {
                Some(value) => file.values.push((parameter, value)),
                None => file.remarks.push(format!("{} could not be read", parameter.key())),
            }
        }
        file
    }
}

/// Keeps a backup in a file. One that is there already is never touched; it counts if it holds the same values.
///
/// # Errors
/// [`ParameterFileError`], also if the file that is there is no such backup, or one of other values.
pub fn keep(backup: &ParameterFile, path: &Path) -> Result<BackupKept, ParameterFileError> {
    match backup.write_new(path) {
        Ok(()) => Ok(BackupKept::Written),
        Err(error) => match ParameterFile::read(path) {
            Ok(there) if same(&there, backup) => Ok(BackupKept::AlreadyThere),
            _ => Err(error),
        },
    }
}

fn same(one: &ParameterFile, other: &ParameterFile) -> bool {
    (one.model, one.native, &one.values) == (other.model, other.native, &other.values)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::fs;

    const ORIGIN: BackupOrigin<'_> =
        BackupOrigin { at: SystemTime::UNIX_EPOCH, bus: "sim", position: 2, shown: Some(InWord(0x181)) };

    fn backup(length: u32) -> ParameterFile {
        let values = [(Parameter::MeasuringLength, Some(length)), (Parameter::Numerator, None)];
        ORIGIN.backup(Model::Ce65M, Some(4096), values)
    }

    #[test]
    fn a_backup_says_when_where_and_what_is_missing() {
        let text = backup(9_999).text();
        for line in [
            "# as it was before it was programmed, 1970-01-01T00:00:00Z",
            "# sim, position 2",
            "# IN showed 00000181",
            "# numerator could not be read",
            "measuring_length = 9999",
        ] {
            assert!(text.lines().any(|there| there.starts_with(line)), "{line}\n{text}");
        }
        assert_eq!(
            ORIGIN.file_name(Model::Ce65M).to_str(),
            Some("backup-ce-65-m-at-2-1970-01-01T000000Z.toml")
        );
    }

    #[test]
    fn a_file_that_holds_the_same_values_counts_and_any_other_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.toml");
        assert_eq!(keep(&backup(9_999), &path), Ok(BackupKept::Written));
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(keep(&backup(9_999), &path), Ok(BackupKept::AlreadyThere));
        let refused = keep(&backup(9_998), &path).unwrap_err().to_string();
        assert!(refused.ends_with("b.toml: it is there already and was left as it is"), "{refused}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        fs::write(&path, "no backup").unwrap();
        assert!(keep(&backup(9_999), &path).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "no backup");
    }
}
