//! What stands before the header of a recording: its version, and the encoders it starts from.

use std::fmt;

use encoring_words::number;

use crate::columns::position;
use crate::error::{Problem, excerpt};
use crate::lines::LINE_LIMIT;

/// Bounds what a device line of many short settings can occupy.
const MOST_SETTINGS: usize = 64;

/// The encoders that a recording starts from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recording {
    /// The encoders in the order of their lines, each at a position of its own.
    pub devices: Vec<DeviceLine>,
}

/// One encoder of a recording. Displayed as its line in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceLine {
    /// The line of the file, from 1. Not written.
    pub line: u64,
    /// The ring position, 0 to 127.
    pub position: u8,
    /// The model: one word without `=`.
    pub model: String,
    /// Keys and values in the order of the line, at most 64: words, each key once and without `=`.
    pub settings: Vec<(String, String)>,
    /// The memory image.
    pub memory: Vec<u8>,
}

impl fmt::Display for DeviceLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "# device {} {}", self.position, self.model)?;
        for (key, value) in &self.settings {
            write!(f, " {key}={value}")?;
        }
        f.write_str(" memory=")?;
        self.memory.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// An encoder that the head of a log names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedEncoder {
    /// The ring position, 0 to 127.
    pub position: u8,
    /// The model: one word.
    pub model: String,
    /// Its measuring length in steps, if it was known.
    pub measuring_length: Option<u32>,
}

impl LoggedEncoder {
    /// From its comment; `None` if that is another.
    pub(crate) fn of(comment: &[u8]) -> Option<Self> {
        let mut words = str::from_utf8(comment).ok()?.strip_prefix("# encoder ")?.split_ascii_whitespace();
        let position = position(words.next()?.as_bytes())?;
        let model = words.next()?.to_owned();
        let length = words.find_map(|word| word.strip_prefix("measuring_length="));
        Some(Self {
            position,
            model,
            measuring_length: length.and_then(|length| Some(number::value(length).ok()?.number)),
        })
    }
}

/// Whether the first line of a file makes it a log.
pub(crate) fn is_log(line: &[u8]) -> bool {
    line.starts_with(b"# encoring-log ")
}

/// Whether the first line of a file makes it a recording.
pub(crate) fn is_recording(line: &[u8]) -> Result<bool, Problem> {
    match line.strip_prefix(b"# encoring-trace ") {
        None => Ok(false),
        Some(b"1") => Ok(true),
        Some(version) => Err(Problem::Version { version: excerpt(version) }),
    }
}

/// The lines that read back as these devices, or why there are none.
pub(crate) fn lines(devices: &[DeviceLine]) -> Result<String, Problem> {
    let mut lines = "# encoring-trace 1\n".to_owned();
    let mut read = Recording::default();
    for device in devices {
        let line = device.to_string();
        if line.len() > LINE_LIMIT {
            return Err(Problem::TooLong { limit: LINE_LIMIT });
        }
        read.comment(device.line, line.as_bytes())?;
        if read.devices.last() != Some(device) {
            return Err(Problem::value(
                line.as_bytes(),
                "a device line: a word is empty or holds a space or =",
            ));
        }
        lines.push_str(&line);
        lines.push('\n');
    }
    Ok(lines)
}

impl Recording {
    /// Takes a device from its line; any other comment is ignored.
    pub(crate) fn comment(&mut self, number: u64, line: &[u8]) -> Result<(), Problem> {
        let Some(words) = line.strip_prefix(b"# device").filter(|rest| matches!(rest, [] | [b' ', ..]))
        else {
            return Ok(());
        };
        let words = str::from_utf8(words).map_err(|_| Problem::value(words, "UTF-8"))?;
        let device = DeviceLine::from_words(number, words)?;
        // Positions are at most 127, so this also bounds the number of devices.
        if self.devices.iter().any(|known| known.position == device.position) {
            return Err(Problem::Twice { what: "device", name: device.position.to_string() });
        }
        self.devices.push(device);
        Ok(())
    }
}

impl DeviceLine {
    fn from_words(line: u64, words: &str) -> Result<Self, Problem> {
        let mut words = words.split_ascii_whitespace();
        let not = |word: &str, allowed| Err(Problem::value(word.as_bytes(), allowed));

        let word = words.next().unwrap_or_default();
        let Some(position) = position(word.as_bytes()) else {
            return not(word, "the position of a device, 0 to 127");
        };
        let model = words.next().unwrap_or_default();
        if model.is_empty() || model.contains('=') {
            return not(model, "the model of a device");
        }
        let mut settings: Vec<(String, String)> = Vec::new();
        let memory = loop {
            let Some(word) = words.next() else { return not("", "memory=HEX, the end of a device line") };
            let Some((key, value)) = word.split_once('=').filter(|(key, _)| !key.is_empty()) else {
                return not(word, "a setting key=value");
            };
            if key == "memory" {
                match bytes(value) {
                    Some(memory) => break memory,
                    None => return not(value, "a memory image, two hex digits a byte"),
                }
            }
            if settings.iter().any(|(known, _)| known == key) {
                return Err(Problem::Twice { what: "setting", name: excerpt(key.as_bytes()) });
            }
            if settings.len() == MOST_SETTINGS {
                return not(word, "one of the first 64 settings");
            }
            settings.push((key.to_owned(), value.to_owned()));
        };
        match words.next() {
            Some(word) => not(word, "the end of a device line, which follows the memory image"),
            None => Ok(Self { line, position, model: model.to_owned(), settings, memory }),
        }
    }
}

fn bytes(hex: &str) -> Option<Vec<u8>> {
    let digit = |byte: u8| char::from(byte).to_digit(16);
    let (pairs, []) = hex.as_bytes().as_chunks() else { return None };
    pairs.iter().map(|&[high, low]| u8::try_from(digit(high)? << 4 | digit(low)?).ok()).collect()
}
