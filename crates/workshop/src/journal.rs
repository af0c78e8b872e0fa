//! What is being programmed, on the disk before the first value is written: a command that was killed, or a power cut,
//! leaves a note for the next.
//!
//! A set of which only a part was written becomes active at the next power-up if it is valid, with the error bit clear,
//! and nothing tells [R80]. A note is believed only as far as the values that are read match it.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use encoring_files::toml_text::{self, Misfit, Wrong};
use encoring_files::{Replacement, read_text, sync_folder};
use encoring_host::program::{Back, Prepared, Report};
use encoring_words::model::Effect;
use encoring_words::{Model, Parameter};
use serde::Deserialize;

use crate::values::parameters_of;

/// The largest note, in bytes.
const NOTE_BYTES_MAX: u64 = 64 * 1024;

/// How much of an address stands in a note's name; the rest is in a number behind it.
const NAME_MAX: usize = 80;

/// A folder of notes, one for each encoder that is being programmed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Journal {
    folder: PathBuf,
}

/// Which encoder: its bus and its ring position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncoderPlace {
    /// The bus, written alike however its address is.
    pub bus: String,
    /// Ring position.
    pub position: usize,
}

/// What a command was about to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Intent {
    /// Where.
    pub place: EncoderPlace,
    /// Which encoder.
    pub model: Model,
    /// Which command.
    pub command: String,
    /// When, as RFC 3339.
    pub begun: String,
    /// The files that hold the old values, the oldest first.
    pub backups: Vec<String>,
    /// What was to be written.
    pub values: Vec<IntendedValue>,
}

/// A value that was to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntendedValue {
    /// Of which parameter.
    pub parameter: Parameter,
    /// What it held before.
    pub before: u32,
    /// What it was to hold.
    pub wanted: u32,
}

/// What became of an intent, as far as the values tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// Every value is as it was before.
    Untouched,
    /// Some values are as they were, some are as wanted.
    PartWritten,
    /// Every value is as wanted; whether they were checked is not known.
    AllWritten,
    /// A value is neither: it is another unit, or somebody else has programmed it since.
    OtherUnit,
    /// Not all of its values were read.
    Unknown,
}

/// A note that cannot be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {problem}", .line.map(|line| format!(" line {line}")).unwrap_or_default())]
pub struct JournalError {
    /// The note, or the folder.
    pub file: String,
    /// The line, where one is at fault.
    pub line: Option<usize>,
    /// What is wrong.
    pub problem: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoteTable {
    version: i64,
    bus: String,
    position: usize,
    model: String,
    command: String,
    begun: String,
    backups: Vec<String>,
    value: Vec<ValueTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ValueTable {
    parameter: String,
    before: u32,
    wanted: u32,
}

impl Found {
    /// `true` if the note says something of this encoder.
    #[must_use]
    pub const fn is_believed(self) -> bool {
        matches!(self, Self::Untouched | Self::PartWritten | Self::AllWritten)
    }

    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Untouched => "untouched",
            Self::PartWritten => "part_written",
            Self::AllWritten => "all_written",
            Self::OtherUnit => "other_unit",
            Self::Unknown => "unknown",
        }
    }
}

impl Intent {
    /// What became of it. `read` gives what a parameter holds now, if that is known.
    pub fn found(&self, read: impl Fn(Parameter) -> Option<u32>) -> Found {
        let (mut before, mut wanted, mut unread) = (false, false, false);
        for value in &self.values {
            match read(value.parameter) {
                None => unread = true,
                // What was to stay tells nothing of how far it came.
                Some(now) if value.before == value.wanted && now == value.wanted => {}
                Some(now) if now == value.wanted => wanted = true,
                Some(now) if now == value.before => before = true,
                Some(_) => return Found::OtherUnit,
            }
        }
        match (before, wanted) {
            (true, true) => Found::PartWritten,
            _ if unread => Found::Unknown,
            (true, false) => Found::Untouched,
            _ => Found::AllWritten,
        }
    }

    /// What became of it, in sentences, and what to do next.
    pub fn told(&self, found: Found, read: impl Fn(Parameter) -> Option<u32>) -> Vec<String> {
        let begun = format!("`encoring {}` was begun here at {} and did not end", self.command, self.begun);
        let keys = |of: fn(&IntendedValue) -> u32| -> String {
            let changes = self.values.iter().filter(|value| value.before != value.wanted);
            let those = changes.filter(|value| read(value.parameter) == Some(of(value)));
            those.map(|value| value.parameter.key()).collect::<Vec<_>>().join(", ")
        };
        let at_once = self.model.effect() == Effect::AtOnce;
        let mut text = match found {
            Found::Untouched => vec![
                format!("{begun}: the values are as they were before it"),
                "repeat that command if it is still wanted".to_owned(),
            ],
            Found::PartWritten => vec![
                format!(
                    "{begun}: it was ended in the middle. Written: {}; as before: {}",
                    keys(|value| value.wanted),
                    keys(|value| value.before)
                ),
                if at_once {
                    "the position is computed with this mixture".to_owned()
                } else {
                    "at the next power-up the position may be computed with this mixture, and nothing tells"
                        .to_owned()
                },
                "repeat that command".to_owned(),
            ],
            Found::AllWritten if at_once => vec![format!("{begun}: all its values are written, and in use")],
            Found::AllWritten => vec![
                format!("{begun}: all its values are written; whether a data check followed is not known"),
                "repeat that command, or type `encoring check`".to_owned(),
            ],
            Found::OtherUnit => vec![format!(
                "{begun}; the values are neither those of before nor those it wanted: this is another unit, or it was \
                 programmed since. The note is not believed"
            )],
            Found::Unknown => vec![
                format!("{begun}; not all of its values were read, so what became of it is not known"),
                "`encoring read all` tells".to_owned(),
            ],
        };
        if let (Some(backup), true) = (self.backups.first(), found.is_believed()) {
            text.push(format!("or take the old values back: `encoring restore {backup}`"));
        }
        text
    }

    fn text(&self) -> String {
        let quoted = |words: &str| toml::Value::String(words.to_owned()).to_string();
        let backups: Vec<_> = self.backups.iter().map(|backup| quoted(backup)).collect();
        let mut text = format!(
            "# A command has begun to write these values. It takes this note away when it has ended.\n\
             version = 1\nbus = {}\nposition = {}\nmodel = \"{}\"\ncommand = {}\nbegun = {}\nbackups = [{}]\n",
            quoted(&self.place.bus),
            self.place.position,
            self.model,
            quoted(&self.command),
            quoted(&self.begun),
            backups.join(", ")
        );
        for IntendedValue { parameter, before, wanted } in &self.values {
            text += &format!(
                "\n[[value]]\nparameter = \"{}\"\nbefore = {before}\nwanted = {wanted}\n",
                parameter.key()
            );
        }
        text
    }

    #[expect(clippy::disallowed_methods, reason = "a model, which `words::model` reads")]
    fn of(table: NoteTable) -> Result<Self, Wrong> {
        if table.version != 1 {
            let problem = format!("version {}; this program reads version 1", table.version);
            return Err(Wrong::at("version", problem));
        }
        let model: Model = table
            .model
            .parse()
            .map_err(|cause| Wrong::at("model", format!("model {:?}: {cause}", table.model)))?;
        let values = table.value.iter().enumerate().map(|(k, value)| {
            let found = parameters_of(model).find(|parameter| parameter.key() == value.parameter);
            let parameter = found.ok_or_else(|| {
                let problem = format!("{:?} is no parameter of a {model}", value.parameter);
                Wrong::at("parameter", problem).inside_item(k).inside("value")
            })?;
            Ok(IntendedValue { parameter, before: value.before, wanted: value.wanted })
        });
        let values = values.collect::<Result<_, Wrong>>()?;
        let place = EncoderPlace { bus: table.bus, position: table.position };
        let NoteTable { command, begun, backups, .. } = table;
        Ok(Self { place, model, command, begun, backups, values })
    }
}

/// The journal's page of one encoder, as whoever programs it fills it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    journal: Journal,
    place: EncoderPlace,
}

impl Page {
    /// The page of an encoder.
    #[must_use]
    pub const fn new(journal: Journal, place: EncoderPlace) -> Self {
        Self { journal, place }
    }

    /// What was begun and is not known to have ended.
    ///
    /// # Errors
    /// [`JournalError`] for a note that is none.
    pub fn pending(&self) -> Result<Option<Intent>, JournalError> {
        self.journal.pending(&self.place)
    }

    /// Notes what will be written. When this returns it is on the disk. The backups of a command that was begun `earlier`
    /// and is believed stay named: the oldest values are those that somebody may want back.
    ///
    /// # Errors
    /// [`JournalError`]; then nothing may be written to the encoder.
    pub fn begin<E>(
        &self,
        prepared: &Prepared<E>,
        command: &str,
        begun: String,
        backup: Option<String>,
        earlier: Option<&Intent>,
    ) -> Result<(), JournalError> {
        let values = prepared.rows().filter_map(|row| {
            Some(IntendedValue { parameter: row.parameter, before: row.before?, wanted: row.wanted? })
        });
        let mut backups = earlier.map(|earlier| earlier.backups.clone()).unwrap_or_default();
        backups.extend(backup);
        self.journal.begin(&Intent {
            place: self.place.clone(),
            model: prepared.model(),
            command: command.to_owned(),
            begun,
            backups,
            values: values.collect(),
        })
    }

    /// Closes the page, unless something half done is left. Where all was taken back, what was begun `earlier` and is
    /// believed stands there again.
    ///
    /// # Errors
    /// [`JournalError`].
    pub fn settle<E>(&self, report: &Report<E>, earlier: Option<&Intent>) -> Result<(), JournalError> {
        match (&report.result, report.back) {
            (Ok(()), _) => self.journal.close(&self.place),
            (Err(_), Back::Failed) => Ok(()),
            (Err(_), _) => self.take_back(earlier),
        }
    }

    /// The page as it was before this command: nothing was begun.
    ///
    /// # Errors
    /// [`JournalError`].
    pub fn take_back(&self, earlier: Option<&Intent>) -> Result<(), JournalError> {
        match earlier {
            Some(earlier) => self.journal.begin(earlier),
            None => self.journal.close(&self.place),
        }
    }
}

impl Journal {
    /// The notes of a folder, which need not be there yet.
    #[must_use]
    pub const fn in_folder(folder: PathBuf) -> Self {
        Self { folder }
    }

    fn note(&self, place: &EncoderPlace) -> PathBuf {
        let plain: String = place
            .bus
            .chars()
            .map(|sign| if sign.is_ascii_alphanumeric() || sign == '.' { sign } else { '-' })
            .take(NAME_MAX)
            .collect();
        self.folder.join(format!("{plain}-{:016x}-at-{}.toml", fnv(&place.bus), place.position))
    }

    /// Notes an intent. When this returns it is on the disk.
    ///
    /// # Errors
    /// [`JournalError`]; then nothing may be written to the encoder.
    pub fn begin(&self, intent: &Intent) -> Result<(), JournalError> {
        let note = self.note(&intent.place);
        let written = || -> io::Result<()> {
            fs::create_dir_all(&self.folder)?;
            sync_folder(&self.folder)?;
            let mut new = Replacement::begin(&note)?;
            new.write_all(intent.text().as_bytes())?;
            new.replace()
        };
        written().map_err(|cause| failed(&note, &cause))
    }

    /// The intent of an encoder that is not known to have ended.
    ///
    /// # Errors
    /// [`JournalError`] for a note that is none.
    pub fn pending(&self, place: &EncoderPlace) -> Result<Option<Intent>, JournalError> {
        let note = self.note(place);
        if fs::symlink_metadata(&note).is_err() {
            return Ok(None);
        }
        let refused = |line, problem| JournalError { file: note.display().to_string(), line, problem };
        let text =
            read_text(&note, NOTE_BYTES_MAX).map_err(|cause| refused(cause.line(), cause.to_string()))?;
        let read = toml_text::ends_whole(&text)
            .and_then(|()| toml_text::parse::<NoteTable>(&text))
            .and_then(|table| Intent::of(table).map_err(|wrong| wrong.in_text(&text)));
        let intent = read.map_err(|Misfit { line, problem }| refused(line, problem))?;
        if intent.place != *place {
            return Err(refused(None, "it is a note of another encoder".to_owned()));
        }
        Ok(Some(intent))
    }

    /// Takes a note away: what it says is done, or undone.
    ///
    /// # Errors
    /// [`JournalError`].
    pub fn close(&self, place: &EncoderPlace) -> Result<(), JournalError> {
        let note = self.note(place);
        match fs::remove_file(&note).and_then(|()| sync_folder(&note)) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound => Err(failed(&note, &cause)),
            _ => Ok(()),
        }
    }
}

fn failed(note: &Path, cause: &io::Error) -> JournalError {
    JournalError { file: note.display().to_string(), line: None, problem: cause.to_string() }
}

/// FNV-1a: tells two addresses apart whose plain letters are the same.
fn fnv(text: &str) -> u64 {
    text.bytes()
        .fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
}
