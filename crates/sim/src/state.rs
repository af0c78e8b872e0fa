//! Memory images in files: what an encoder remembers from one run to the next.
//!
//! One file for each position, `encoder-0.toml`, replaced atomically. The memory stands last, so a file that was cut
//! off anywhere is noticed.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use encoring_encoder::records::EEPROM_BYTES;
use encoring_encoder::unit::NoStaleService;
use encoring_encoder::{StaleService, Unit};
use encoring_files::{Replacement, TextError, read_text};
use encoring_words::model::Sensor;
use serde::{Deserialize, Serialize};

use crate::memory::Eeprom;

/// The largest state file, in bytes; a whole one has some 1100.
const FILE_BYTES_MAX: u64 = 64 * 1024;

/// A file that is no state of this encoder.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", .file.display())]
pub struct StateError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it: value and limit.
    pub problem: String,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct StateTable {
    version: i64,
    model: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    native: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rod_um: Option<u32>,
    /// Left out: ignored.
    #[serde(skip_serializing_if = "Option::is_none")]
    stale_service: Option<String>,
    memory: String,
}

/// What a state file holds of an encoder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Its memory.
    pub memory: Eeprom,
    /// What it made of a stale service bit when the file was written. The memory is the same either way, so it fits an
    /// encoder that does otherwise.
    pub stale_service: StaleService,
}

impl StateTable {
    fn of(unit: &Unit, memory: &Eeprom) -> Self {
        let (native, rod_um) = sensor(unit);
        let memory = memory.image().iter().map(|byte| format!("{byte:02X}")).collect();
        let stale_service =
            (unit.stale_service != StaleService::default()).then(|| unit.stale_service.to_string());
        Self { version: 1, model: unit.model().to_string(), native, rod_um, stale_service, memory }
    }
}

const fn sensor(unit: &Unit) -> (Option<u32>, Option<u32>) {
    match unit.sensor() {
        Sensor::Rotary { steps_per_turn } => (Some(steps_per_turn), None),
        Sensor::Linear { rod_um } => (None, Some(rod_um)),
    }
}

/// The file of the encoder at a position.
#[must_use]
pub fn file(folder: &Path, position: usize) -> PathBuf {
    folder.join(format!("encoder-{position}.toml"))
}

/// Reads the memory of the encoder at a position; `None` if there is no file yet.
///
/// # Errors
/// [`StateError`] if the file is cut off, of another version or of another encoder.
pub fn read(folder: &Path, position: usize, unit: &Unit) -> Result<Option<Kept>, StateError> {
    let file = file(folder, position);
    let error = |problem| StateError { file: file.clone(), problem };
    match read_text(&file, FILE_BYTES_MAX) {
        Err(TextError::System(cause)) if cause.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(cause) => Err(error(cause.to_string())),
        Ok(text) => parse(&text, position, unit).map(Some).map_err(error),
    }
}

/// The memory in the text of a state file; `position` is only named in what is wrong.
///
/// # Errors
/// What is wrong: the text is cut off, of another version or of another encoder.
pub fn parse(text: &str, position: usize, unit: &Unit) -> Result<Kept, String> {
    let table: StateTable = toml::from_str(text)
        .map_err(|cause| format!("no whole state file: {}", cause.message().replace('\n', "; ")))?;
    if table.version != 1 {
        return Err(format!("version {}; this program reads version 1", table.version));
    }
    let (native, rod_um) = sensor(unit);
    if (table.model.as_str(), table.native, table.rod_um) != (unit.model().name(), native, rod_um) {
        let shown = |model: &str, native: Option<u32>, rod_um: Option<u32>| match (native, rod_um) {
            (Some(native), _) => format!("a {model} with {native} steps per turn"),
            (_, Some(rod_um)) => format!("a {model} of {rod_um} um"),
            _ => format!("a {model}"),
        };
        return Err(format!(
            "the memory of {}; position {position} is {}",
            shown(&table.model, table.native, table.rod_um),
            shown(unit.model().name(), native, rod_um)
        ));
    }
    let stale_service = table.stale_service.as_deref().map(|named| {
        named.parse().map_err(|wrong: NoStaleService| format!("stale_service \"{named}\": {wrong}"))
    });
    let image =
        image(&table.memory).ok_or_else(|| format!("memory is not {} hex digits", 2 * EEPROM_BYTES))?;
    Ok(Kept {
        memory: Eeprom::from_image(image),
        stale_service: stale_service.transpose()?.unwrap_or_default(),
    })
}

fn image(hex: &str) -> Option<[u8; EEPROM_BYTES]> {
    let digits: Vec<u8> =
        hex.chars().map(|digit| digit.to_digit(16).map(|d| d as u8)).collect::<Option<_>>()?;
    let (pairs, rest) = digits.as_chunks::<2>();
    let bytes: Vec<u8> = pairs.iter().map(|[high, low]| high << 4 | low).collect();
    if rest.is_empty() { bytes.try_into().ok() } else { None }
}

/// Replaces the file of the encoder at a position: the old one stays until the new one is whole.
///
/// # Errors
/// Those of the file system.
pub fn write(folder: &Path, position: usize, unit: &Unit, memory: &Eeprom) -> Result<(), StateError> {
    let file = file(folder, position);
    let text = toml::to_string(&StateTable::of(unit, memory));
    let written = text.map_err(io::Error::other).and_then(|text| {
        let mut new = Replacement::begin(&file)?;
        new.write_all(text.as_bytes())?;
        new.replace()
    });
    written.map_err(|cause| StateError { file, problem: cause.to_string() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::node::Node;
    use encoring_words::Model;

    fn unit(steps_per_turn: u32) -> Unit {
        Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn }).unwrap()
    }

    #[test]
    fn a_memory_comes_back_from_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let memory = Node::new(unit(4096)).memory().clone();
        let image = || read(folder.path(), 3, &unit(4096)).unwrap().map(|kept| *kept.memory.image());
        assert_eq!(image(), None);
        write(folder.path(), 3, &unit(4096), &memory).unwrap();
        assert_eq!(image(), Some(*memory.image()));
        write(folder.path(), 3, &unit(4096), &Eeprom::blank()).unwrap();
        assert_eq!(image(), Some([0xFF; EEPROM_BYTES]));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn a_file_tells_what_its_encoder_made_of_a_stale_service_bit_and_fits_one_that_does_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let mut executes = unit(4096);
        executes.stale_service = StaleService::Executed;
        for (written, line) in [(unit(4096), None), (executes, Some("stale_service = \"executed\""))] {
            write(folder.path(), 0, &written, Node::new(written).memory()).unwrap();
            let text = fs::read_to_string(file(folder.path(), 0)).unwrap();
            assert_eq!(text.lines().find(|line| line.starts_with("stale_service")), line);
            for now in [unit(4096), executes] {
                let kept = read(folder.path(), 0, &now).unwrap().unwrap();
                assert_eq!(kept.stale_service, written.stale_service);
            }
        }
        let wrong = fs::read_to_string(file(folder.path(), 0)).unwrap().replace("executed", "done");
        let problem = parse(&wrong, 0, &executes).unwrap_err();
        assert_eq!(problem, "stale_service \"done\": a stale service bit is ignored or executed");
    }

    #[test]
    fn a_file_cut_off_anywhere_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 0, &unit(4096), Node::new(unit(4096)).memory()).unwrap();
        let text = fs::read(file(folder.path(), 0)).unwrap();
        // Without its last newline it is still whole.
        for length in 0..text.len() - 1 {
            fs::write(file(folder.path(), 0), &text[..length]).unwrap();
            assert!(read(folder.path(), 0, &unit(4096)).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn another_encoders_memory_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 0, &unit(8192), &Eeprom::blank()).unwrap();
        let message = read(folder.path(), 0, &unit(4096)).unwrap_err().to_string();
        let expected = "encoder-0.toml: the memory of a ce-65-m with 8192 steps per turn; \
                        position 0 is a ce-65-m with 4096 steps per turn";
        assert!(message.ends_with(expected), "{message}");
    }
}
