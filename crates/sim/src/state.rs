//! Memory images in files: what an encoder remembers from one run to the next.
//!
//! One file for each position, `encoder-0.toml`, replaced atomically. The memory stands last, so a file that was cut
//! off anywhere is noticed. A [`StateFolder`] holds them, and is used by one program at a time.

use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use encoring_encoder::records::EEPROM_BYTES;
use encoring_encoder::unit::NoStaleService;
use encoring_encoder::{StaleService, Unit};
use encoring_files::toml_text::{self, Misfit};
use encoring_files::{Lock, Replacement, TextError, read_text};
use encoring_words::model::Sensor;
use serde::{Deserialize, Serialize};

use crate::memory::Eeprom;
use crate::world::{Place, World};

/// The largest state file, in bytes; a whole one has some 1100.
const FILE_BYTES_MAX: u64 = 64 * 1024;

/// A file that is no state of this encoder or cannot be written, or a folder that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", .file.display())]
pub struct StateError {
    /// The file, or the folder.
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

/// The memories that could not be written; the others were.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotSaved(pub Vec<StateError>);

impl fmt::Display for NotSaved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if index == 0 { "" } else { "; " })?;
        }
        Ok(())
    }
}

impl std::error::Error for NotSaved {}

/// The folder of a ring's memories, while a program uses it.
#[derive(Debug)]
pub struct StateFolder {
    path: PathBuf,
    /// None where nothing can be written.
    lock: Option<Lock>,
    overruled: Vec<Overruled>,
}

/// A file that says otherwise what its encoder makes of a stale service bit; the encoder counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overruled {
    /// The encoder's ring position.
    pub position: usize,
    /// What the file has.
    pub file: StaleService,
    /// What the encoder has.
    pub encoder: StaleService,
}

impl StateFolder {
    /// Makes the folder if it is not there, keeps other programs away from it, and puts the memories of earlier runs
    /// into the encoders. A folder that cannot be written is only read, without keeping anybody away.
    ///
    /// # Errors
    /// [`StateError`] if another program uses it, or a file in it is none of the ring's; then the world is as it was.
    pub fn open(path: &Path, world: &mut World) -> Result<Self, StateError> {
        let error = |problem: String| StateError { file: path.to_owned(), problem };
        fs::create_dir_all(path).map_err(|cause| error(cause.to_string()))?;
        let lock_file = path.join("lock");
        let lock = match Lock::on(&lock_file) {
            Ok(Some(lock)) => Some(lock),
            Ok(None) => return Err(error("another simulation uses this folder".to_owned())),
            Err(cause) if is_read_only(&cause) => None,
            Err(cause) => return Err(StateError { file: lock_file, problem: cause.to_string() }),
        };
        // First all are read, so that of a folder with one foreign file nothing is taken.
        let units: Vec<Unit> = world.places().iter().map(|place| *place.node().unit()).collect();
        let kept = units.iter().enumerate().map(|(position, unit)| read(path, position, unit));
        let kept: Vec<_> = kept.collect::<Result<_, _>>()?;
        let mut overruled = Vec::new();
        for (position, (kept, unit)) in kept.into_iter().zip(&units).enumerate() {
            let Some(Kept { memory, stale_service: file }) = kept else { continue };
            let encoder = unit.stale_service;
            if file != encoder {
                overruled.push(Overruled { position, file, encoder });
            }
            world.insert_memory(position, memory);
        }
        Ok(Self { path: path.to_owned(), lock, overruled })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// `true` if nothing can be written there.
    #[must_use]
    pub const fn is_read_only(&self) -> bool {
        self.lock.is_none()
    }

    /// The files that say otherwise what their encoder makes of a stale service bit.
    #[must_use]
    pub fn overruled(&self) -> &[Overruled] {
        &self.overruled
    }

    /// Writes what every encoder remembers if the supply fails now.
    ///
    /// # Errors
    /// [`NotSaved`]; every one is tried.
    pub fn save(&self, world: &World) -> Result<(), NotSaved> {
        let nodes = world.places().iter().map(Place::node);
        self.save_all(nodes.map(|node| (*node.unit(), node.memory_at_power_off())))
    }

    /// Writes memories, by position.
    ///
    /// # Errors
    /// [`NotSaved`]; every one is tried.
    pub fn save_all(&self, memories: impl IntoIterator<Item = (Unit, Eeprom)>) -> Result<(), NotSaved> {
        let written = memories
            .into_iter()
            .enumerate()
            .map(|(position, (unit, memory))| write(&self.path, position, &unit, &memory));
        let errors: Vec<_> = written.filter_map(Result::err).collect();
        if errors.is_empty() { Ok(()) } else { Err(NotSaved(errors)) }
    }
}

fn is_read_only(cause: &io::Error) -> bool {
    matches!(cause.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
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
    // It would be replaced by a file when it is written.
    if fs::symlink_metadata(&file).is_ok_and(|found| found.is_symlink()) {
        return Err(error("a link; a memory is a file of its own".to_owned()));
    }
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
    let table: StateTable = toml_text::parse(text).map_err(|Misfit { line, problem }| {
        let line = line.map_or_else(String::new, |line| format!("line {line}: "));
        format!("no whole state file: {line}{problem}")
    })?;
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

    fn world() -> World {
        let text = "version = 1\n[[device]]\nposition = 0\nmodel = \"ce-65-m\"\n[[device]]\nposition = 1\nmodel = \"la-66\"\n";
        World::new(&crate::Scenario::parse("s.toml", text, Path::new("")).unwrap()).unwrap()
    }

    #[test]
    fn a_folder_is_used_by_one_program_and_read_under_its_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new");
        let used = StateFolder::open(&path, &mut world()).unwrap();
        assert!(!used.is_read_only());
        // Who comes second does not even look at the files.
        fs::write(file(&path, 0), "half a file").unwrap();
        let message = StateFolder::open(&path, &mut world()).unwrap_err().to_string();
        assert!(message.ends_with("new: another simulation uses this folder"), "{message}");
        drop(used);
        let message = StateFolder::open(&path, &mut world()).unwrap_err().to_string();
        assert!(message.contains("encoder-0.toml: no whole state file: line 1: "), "{message}");
    }

    #[test]
    fn one_memory_that_cannot_be_written_does_not_keep_the_others_from_it() {
        let folder = tempfile::tempdir().unwrap();
        let world = world();
        let state = StateFolder::open(folder.path(), &mut World::clone(&world)).unwrap();
        fs::create_dir(file(folder.path(), 0)).unwrap();
        let NotSaved(errors) = state.save(&world).unwrap_err();
        assert_eq!(errors.iter().map(|error| &error.file).collect::<Vec<_>>(), [&file(folder.path(), 0)]);
        assert!(file(folder.path(), 1).is_file());
    }

    #[cfg(unix)]
    #[test]
    fn links_and_special_files_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = folder.path().join("elsewhere");
        fs::write(&elsewhere, "").unwrap();
        for name in ["encoder-1.toml", "lock"] {
            let path = folder.path().join(name);
            let _ = fs::remove_file(&path);
            std::os::unix::fs::symlink(&elsewhere, &path).unwrap();
            let error = StateFolder::open(folder.path(), &mut world()).unwrap_err();
            assert_eq!(error.file, path);
            fs::remove_file(&path).unwrap();
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
            let error = StateFolder::open(folder.path(), &mut world()).unwrap_err();
            assert_eq!(error.file, path);
            fs::remove_file(&path).unwrap();
        }
        assert_eq!(fs::read(&elsewhere).unwrap(), b"");
    }

    #[test]
    fn what_a_killed_run_left_of_a_memory_is_removed_with_the_next_write() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(".encoder-3.toml.encoring-aB3dE6"), "half").unwrap();
        fs::write(folder.path().join(".tmpaB3dE6"), "somebody's").unwrap();
        write(folder.path(), 3, &unit(4096), &Eeprom::blank()).unwrap();
        let mut names: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, [".tmpaB3dE6", "encoder-3.toml"]);
    }
}
