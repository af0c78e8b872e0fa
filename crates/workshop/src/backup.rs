//! The values of an encoder in a file, before they are changed.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use encoring_words::{InWord, Model, Parameter};

use crate::kept::{KeptEncoder, TakenFrom, UnitLabel};
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
        // Two commands may follow one another within a second.
        let time = humantime::format_rfc3339_millis(self.at);
        let name = format!("backup-{model}-at-{}-{time}.toml", self.position);
        // Windows allows no colons.
        PathBuf::from(name.replace(':', ""))
    }

    /// The backup. `None` stands for a value that could not be read.
    pub fn backup(
        &self,
        model: Model,
        label: UnitLabel,
        values: impl IntoIterator<Item = (Parameter, Option<u32>)>,
    ) -> KeptEncoder {
        let shown = self.shown.map_or_else(|| "no word".to_owned(), |word| word.to_string());
        let mut taken = TakenFrom {
            at: self.time(),
            bus: self.bus.to_owned(),
            position: self.position,
            unreadable: Vec::new(),
        };
        let mut kept = KeptEncoder { label, ..KeptEncoder::new(model) };
        kept.remarks = vec![
            format!("IN showed {shown}"),
            "programmed values: whether the position is computed with them cannot be read".to_owned(),
            "the offset of a preset adjustment is not here: no service reads it".to_owned(),
        ];
        for (parameter, value) in values {
            match value {
                Some(value) => kept.values.push((parameter, value)),
                None => taken.unreadable.push(parameter),
            }
        }
        kept.taken = Some(taken);
        kept
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
            Ok(there) if holds(&there, backup) => Ok(BackupKept::AlreadyThere),
            _ => Err(error),
        },
    }
}

fn holds(there: &ParameterFile, backup: &ParameterFile) -> bool {
    let (there, backup) = (&there.encoders, &backup.encoders);
    there.len() == backup.len() && there.iter().zip(backup).all(|(there, backup)| there.holds(backup))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::values::parameters_of;
    use std::fs;

    const ORIGIN: BackupOrigin<'_> =
        BackupOrigin { at: SystemTime::UNIX_EPOCH, bus: "sim", position: 2, shown: Some(InWord(0x181)) };

    fn backup(length: u32) -> ParameterFile {
        let values = parameters_of(Model::Ce65M)
            .map(|parameter| (parameter, (parameter != Parameter::Numerator).then_some(length)));
        let label = UnitLabel { native: Some(4096), ..UnitLabel::default() };
        let mut kept = ORIGIN.backup(Model::Ce65M, label, values);
        kept.values.retain(|(parameter, _)| *parameter == Parameter::MeasuringLength);
        kept.values.extend([(Parameter::CountingDirection, 0), (Parameter::Denominator, 1)]);
        kept.values.push((Parameter::SsiValues, 24));
        kept.values.sort_by_key(|(parameter, _)| *parameter);
        kept.into()
    }

    #[test]
    fn a_backup_says_when_where_and_what_is_missing() {
        let text = backup(9_999).text();
        for line in [
            "# IN showed 00000181",
            "at = \"1970-01-01T00:00:00Z\"",
            "bus = \"sim\"",
            "position = 2",
            "unreadable = [\"numerator\"]",
            "measuring_length = 9999",
        ] {
            assert!(text.lines().any(|there| there.starts_with(line)), "{line}\n{text}");
        }
        assert_eq!(
            ORIGIN.file_name(Model::Ce65M).to_str(),
            Some("backup-ce-65-m-at-2-1970-01-01T000000.000Z.toml")
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
