//! The parameters of an encoder in a file.
//!
//! ```toml
//! version = 1
//! model = "ce-65-m"
//! native = 4096
//!
//! [parameters]
//! measuring_length = 9999
//! numerator = 10
//! denominator = 1
//! ```
//!
//! What is not in the file stays as it is when the file is programmed.

use std::io::{self, Write};
use std::path::Path;

use encoring_files::toml_text::{self, Misfit, Wrong};
use encoring_files::{Replacement, read_text};
use encoring_words::model::Sensor;
use encoring_words::parameter::{PARAMETERS, Parameter};
use encoring_words::{Model, word};
use serde::Deserialize;

/// The largest parameter file, in bytes; a whole one has some 500.
pub const FILE_BYTES_MAX: u64 = 64 * 1024;

/// Parameters of one encoder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterFile {
    /// Which encoder.
    pub model: Model,
    /// Steps per turn on the rating plate, if they are known.
    pub native: Option<u32>,
    /// What else whoever reads the file should know: each a comment line of its own.
    pub remarks: Vec<String>,
    /// The values, in the order of the services.
    pub values: Vec<(Parameter, u32)>,
}

/// A file that holds no parameters, or cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {problem}", .line.map(|line| format!(" line {line}")).unwrap_or_default())]
pub struct ParameterFileError {
    /// The file, as it was named.
    pub file: String,
    /// The line, where one is at fault.
    pub line: Option<usize>,
    /// What is wrong: value and limit.
    pub problem: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    version: i64,
    model: String,
    native: Option<u32>,
    #[serde(default)]
    parameters: toml::Table,
}

impl ParameterFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ParameterFileError`] naming the place.
    pub fn read(path: &Path) -> Result<Self, ParameterFileError> {
        let file = path.display().to_string();
        match read_text(path, FILE_BYTES_MAX) {
            Ok(text) => Self::parse(&file, &text),
            Err(cause) => Err(ParameterFileError { file, line: cause.line(), problem: cause.to_string() }),
        }
    }

    /// Reads a text. The values are numbers of 24 bits for parameters that the model has; whether they are in their
    /// range is for whoever programs them.
    ///
    /// # Errors
    /// [`ParameterFileError`] naming the place.
    pub fn parse(file: &str, text: &str) -> Result<Self, ParameterFileError> {
        let read =
            toml_text::parse(text).and_then(|table| Self::of(&table).map_err(|wrong| wrong.in_text(text)));
        read.map_err(|Misfit { line, problem }| ParameterFileError { file: file.to_owned(), line, problem })
    }

    fn of(table: &FileTable) -> Result<Self, Wrong> {
        if table.version != 1 {
            let problem = format!("version {}; this program reads version 1", table.version);
            return Err(Wrong::at("version", problem));
        }
        let model: Model = table
            .model
            .parse()
            .map_err(|cause| Wrong::at("model", format!("model {:?}: {cause}", table.model)))?;
        if let Some(native) = table.native {
            model
                .built_with(Sensor::Rotary { steps_per_turn: native })
                .map_err(|wrong| Wrong::at("native", format!("native: {wrong}")))?;
        }
        let values = table.parameters.iter().map(|(name, value)| {
            value_of(model, name, value).map_err(|problem| Wrong::at(name, problem).inside("parameters"))
        });
        let mut values = values.collect::<Result<Vec<_>, _>>()?;
        values.sort_by_key(|(parameter, _)| *parameter);
        Ok(Self { model, native: table.native, remarks: Vec::new(), values })
    }

    /// The file's text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for remark in &self.remarks {
            // A line break in a remark would begin something else.
            text += &format!("# {}\n", remark.replace(['\n', '\r'], " "));
        }
        text += &format!("version = 1\nmodel = \"{}\"\n", self.model);
        if let Some(native) = self.native {
            text += &format!("native = {native}\n");
        }
        text += "\n[parameters]\n";
        for (parameter, value) in &self.values {
            text +=
                &format!("{} = {value}    # service {:02X}\n", parameter.key(), parameter.service().number());
        }
        text
    }

    /// Writes a new file; one that is there already is never touched. The file has its name only when it is whole.
    ///
    /// # Errors
    /// [`ParameterFileError`].
    pub fn write_new(&self, path: &Path) -> Result<(), ParameterFileError> {
        let written = || -> io::Result<()> {
            let mut new = Replacement::begin(path)?;
            new.write_all(self.text().as_bytes())?;
            new.keep_new()
        };
        written().map_err(|cause| ParameterFileError {
            file: path.display().to_string(),
            line: None,
            problem: match cause.kind() {
                io::ErrorKind::AlreadyExists => "it is there already and was left as it is".to_owned(),
                _ => cause.to_string(),
            },
        })
    }
}

fn value_of(model: Model, name: &str, value: &toml::Value) -> Result<(Parameter, u32), String> {
    let Some(parameter) = parameters_of(model).find(|parameter| parameter.key() == name) else {
        let names: Vec<_> = parameters_of(model).map(Parameter::key).collect();
        return Err(format!("{name:?} is no parameter of a {model}; it has {}", names.join(", ")));
    };
    let number = value.as_integer().and_then(|value| u32::try_from(value).ok());
    match number.filter(|value| *value <= word::DATA_MAX) {
        Some(number) => Ok((parameter, number)),
        None => Err(format!("{name} = {value}; it must be a whole number from 0 to {}", word::DATA_MAX)),
    }
}

/// The parameters that a model has, in the order of the services.
pub fn parameters_of(model: Model) -> impl Iterator<Item = Parameter> {
    PARAMETERS.into_iter().filter(move |parameter| parameter.service().known_to(model))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fs;

    fn refusal(text: &str) -> String {
        ParameterFile::parse("p.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn what_was_written_is_read_again() {
        let file = ParameterFile {
            model: Model::Ce65M,
            native: Some(8192),
            remarks: vec!["position 1234\nversion = 2".to_owned()],
            values: vec![(Parameter::MeasuringLength, 9_999), (Parameter::SsiValues, 0x01_00_18)],
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.toml");
        file.write_new(&path).unwrap();
        let read = ParameterFile::read(&path).unwrap();
        assert_eq!(read, ParameterFile { remarks: Vec::new(), ..file.clone() });
        let again = file.write_new(&path).unwrap_err();
        assert!(again.to_string().ends_with("p.toml: it is there already and was left as it is"), "{again}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn hexadecimal_numbers_are_numbers_too() {
        let text = "version = 1\nmodel = \"la-66\"\n[parameters]\nmeasuring_length = 0xC350\n";
        let file = ParameterFile::parse("p.toml", text).unwrap();
        assert_eq!(file.values, [(Parameter::MeasuringLength, 50_000)]);
    }

    #[test]
    fn bad_files_are_refused_with_line_value_and_limit() {
        let head = "version = 1\nmodel = \"ce-65-m\"\n";
        assert_eq!(
            refusal("version = 2\nmodel = \"la-66\"\n"),
            "p.toml line 1: version 2; this program reads version 1"
        );
        assert_eq!(
            refusal("version = 1\nmodel = \"ce-58\"\n"),
            "p.toml line 2: model \"ce-58\": the models are la-66, ce-100-m and ce-65-m"
        );
        assert_eq!(
            refusal(&format!("{head}native = 1000\n")),
            "p.toml line 3: native: 1000 steps per turn; a ce-65-m has 4096 or 8192"
        );
        assert_eq!(
            refusal(&format!("{head}[parameters]\npreset_value_1 = 4\n")),
            "p.toml line 4: \"preset_value_1\" is no parameter of a ce-65-m; it has counting_direction, \
             measuring_length, numerator, denominator, ssi_values"
        );
        for wrong in ["-1", "16777216", "1.5", "\"10\"", "true"] {
            assert_eq!(
                refusal(&format!("{head}[parameters]\nnumerator = {wrong}\n")),
                format!("p.toml line 4: numerator = {wrong}; it must be a whole number from 0 to 16777215")
            );
        }
        // The line of this value, not of the first that begins alike.
        assert_eq!(
            refusal(&format!(
                "{head}[parameters]\n# measuring_length = -1\n\nnumerator = 1\nmeasuring_length = -1\n"
            )),
            "p.toml line 7: measuring_length = -1; it must be a whole number from 0 to 16777215"
        );
        assert!(refusal(&format!("{head}colour = 1\n")).starts_with("p.toml line 3: unknown field"));
        assert!(refusal("").contains("missing field `version`"));
        assert!(
            refusal(&format!("{head}[parameters]\nnumerator = 1\nnumerator = 2\n"))
                .contains("line 5: duplicate key")
        );
    }

    proptest! {
        #[test]
        fn no_text_does_harm(text: String) {
            let _ = ParameterFile::parse("p.toml", &text);
        }

        #[test]
        fn any_values_come_back(values: [u32; 7], model in prop::sample::select(encoring_words::model::MODELS.to_vec())) {
            let values: Vec<_> =
                parameters_of(model).zip(values).map(|(p, value)| (p, value & word::DATA_MAX)).collect();
            let file = ParameterFile { model, native: None, remarks: Vec::new(), values };
            prop_assert_eq!(ParameterFile::parse("p.toml", &file.text()).unwrap(), file);
        }
    }
}
