//! The parameters of an encoder in a file, or those of several.
//!
//! ```toml
//! version = 1
//! model = "ce-65-m"
//!
//! [unit]
//! native = 4096
//!
//! [parameters]
//! measuring_length = 9999
//! numerator = "0Ah"
//! counting_direction = { direction = "falling", code = "gray" }
//! ssi_values = { bits = 25 }
//! ```
//!
//! What is not in the file stays as it is when the file is programmed, also a part of a parameter. A backup has further tables: `[taken]`,
//! `[[mark]]`. Of several encoders each is an `[[encoder]]` with the same tables below it.

use std::io::{self, Write};
use std::path::Path;

use encoring_files::toml_text::{self, Misfit, Wrong};
use encoring_files::{Replacement, read_text};
use encoring_host::request::Request;
use encoring_words::Parameter;
use serde::Deserialize;

use crate::comments;
use crate::kept::{EncoderTable, KeptEncoder, MarkTable, TakenTable, UnitTable, rated};

/// The largest parameter file, in bytes; that of a whole ring has some 100 000.
pub const FILE_BYTES_MAX: u64 = 1024 * 1024;

/// A file with what is kept of encoders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterFile {
    /// Each of them; at least one.
    pub encoders: Vec<KeptEncoder>,
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
    /// Looked at before all else.
    #[serde(rename = "version")]
    _version: i64,
    /// How many encoders the file holds, so that one that was cut off is seen.
    encoders: Option<usize>,
    model: Option<String>,
    values: Option<usize>,
    /// Where it stood before there was `[unit]`.
    native: Option<u32>,
    #[serde(default)]
    unit: UnitTable,
    taken: Option<TakenTable>,
    #[serde(default)]
    mark: Vec<MarkTable>,
    parameters: Option<toml::Table>,
    #[serde(default)]
    encoder: Vec<EncoderTable>,
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

    /// The same with the comments of the file as remarks of its encoders, for whoever writes it again.
    ///
    /// # Errors
    /// As of [`ParameterFile::read`].
    pub fn read_with_comments(path: &Path) -> Result<Self, ParameterFileError> {
        let mut file = Self::read(path)?;
        let text = read_text(path, FILE_BYTES_MAX).unwrap_or_default();
        for (kept, comments) in file.encoders.iter_mut().zip(comments::of_encoders(&text)) {
            kept.remarks = comments;
        }
        Ok(file)
    }

    /// Reads a text. Each value is one that the encoder takes, and that the model has; whether it takes them together
    /// is for whoever programs them.
    ///
    /// # Errors
    /// [`ParameterFileError`] naming the place.
    pub fn parse(file: &str, text: &str) -> Result<Self, ParameterFileError> {
        let read = version(text)
            .and_then(|()| toml_text::ends_whole(text))
            .and_then(|()| toml_text::parse_as_typed::<FileTable>(text, "parameters"))
            .and_then(|table| Self::of(table).map_err(|wrong| wrong.in_text(text)));
        read.map_err(|Misfit { line, problem }| ParameterFileError { file: file.to_owned(), line, problem })
    }

    #[expect(clippy::disallowed_methods, reason = "a model, which `words::model` reads")]
    fn of(table: FileTable) -> Result<Self, Wrong> {
        let FileTable {
            _version,
            encoders,
            model,
            values,
            native,
            mut unit,
            taken,
            mark,
            parameters,
            encoder,
        } = table;
        if let Some(native) = native {
            if unit.native.is_some_and(|other| other != native) {
                return Err(Wrong::at("native", "native stands here and in [unit], and they differ"));
            }
            if let Some(Ok(model)) = model.as_deref().map(str::parse) {
                rated(model, native)?;
            }
            unit.native = Some(native);
        }
        if encoder.is_empty() && encoders.is_none() {
            let table = EncoderTable { model, values, unit, taken, mark, parameters };
            return Ok(Self { encoders: vec![KeptEncoder::of(&table)?] });
        }
        if model.is_some() || taken.is_some() || !mark.is_empty() || parameters.is_some() {
            return Err(Wrong::at("encoder", "a file holds one encoder, or [[encoder]] tables, not both"));
        }
        if encoder.is_empty() {
            return Err(Wrong::at("encoders", "no [[encoder]] is in the file: it was cut off"));
        }
        if let Some(encoders) = encoders.filter(|encoders| *encoders != encoder.len()) {
            let problem =
                format!("encoders = {encoders}, and {} are in the file: it was cut off", encoder.len());
            return Err(Wrong::at("encoders", problem));
        }
        let kept = encoder.iter().enumerate().map(|(k, table)| {
            let kept = match &table.parameters {
                Some(_) => KeptEncoder::of(table),
                None => Err(Wrong::new("the table [encoder.parameters] is missing: the file was cut off")),
            };
            kept.map_err(|wrong| wrong.inside_item(k).inside("encoder"))
        });
        Ok(Self { encoders: kept.collect::<Result<_, _>>()? })
    }

    /// The encoder that is meant by a ring position: the only one, or that which was at this position.
    ///
    /// # Errors
    /// The positions that the file holds.
    pub fn at(&self, position: Option<usize>) -> Result<&KeptEncoder, String> {
        if let [only] = self.encoders.as_slice() {
            return Ok(only);
        }
        let place = |kept: &KeptEncoder| kept.taken.as_ref().map(|taken| taken.position);
        let found = self.encoders.iter().find(|kept| position.is_some() && place(kept) == position);
        found.ok_or_else(|| {
            let places: Vec<_> =
                self.encoders.iter().filter_map(place).map(|place| place.to_string()).collect();
            let problem = match position {
                Some(position) => format!("position {position} is not in the file"),
                None => "which one? --at POSITION tells".to_owned(),
            };
            format!("{problem}; it holds the encoders at {}", places.join(", "))
        })
    }

    /// Refuses values of an encoder that it keeps, shows an error for, and that no service may write; `path` is where the file
    /// was read.
    ///
    /// # Errors
    /// [`ParameterFileError`] naming the place.
    pub fn may_be_written(&self, path: &Path, kept: &KeptEncoder) -> Result<(), ParameterFileError> {
        let refused = |(parameter, value): &(Parameter, u32)| {
            let refused = Request::write(kept.model, *parameter, *value).err()?;
            Some(Wrong::at(parameter.key(), refused.to_string()).inside("parameters"))
        };
        let Some(wrong) = kept.values.iter().find_map(refused) else { return Ok(()) };
        let text = read_text(path, FILE_BYTES_MAX).unwrap_or_default();
        let place = self.encoders.iter().position(|other| other == kept).unwrap_or_default();
        let Misfit { line, problem } = match self.encoders.len() {
            1 => wrong.in_text(&text),
            _ => wrong.inside_item(place).inside("encoder").in_text(&text),
        };
        Err(ParameterFileError { file: path.display().to_string(), line, problem })
    }

    /// The file's text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        if let [only] = self.encoders.as_slice() {
            only.write_remarks(&mut text);
            text += "version = 1\n";
            only.write(&mut text, "");
            return text;
        }
        text += &format!("version = 1\nencoders = {}\n", self.encoders.len());
        for kept in &self.encoders {
            text += "\n";
            kept.write_remarks(&mut text);
            text += "[[encoder]]\n";
            kept.write(&mut text, "encoder.");
        }
        text
    }

    /// Writes a new file; one that is there already is never touched. The file has its name only when it is whole.
    ///
    /// # Errors
    /// [`ParameterFileError`].
    pub fn write_new(&self, path: &Path) -> Result<(), ParameterFileError> {
        self.write(path, Replacement::keep_new)
    }

    /// Writes the file in the place of one that is there.
    ///
    /// # Errors
    /// [`ParameterFileError`].
    pub fn replace(&self, path: &Path) -> Result<(), ParameterFileError> {
        self.write(path, Replacement::replace)
    }

    fn write(
        &self,
        path: &Path,
        end: impl FnOnce(Replacement) -> io::Result<()>,
    ) -> Result<(), ParameterFileError> {
        let written = || -> io::Result<()> {
            let mut new = Replacement::begin(path)?;
            new.write_all(self.text().as_bytes())?;
            end(new)
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

impl From<KeptEncoder> for ParameterFile {
    fn from(kept: KeptEncoder) -> Self {
        Self { encoders: vec![kept] }
    }
}

/// Refuses another version before what this one does not know.
fn version(text: &str) -> Result<(), Misfit> {
    let table: toml::Table = toml_text::parse(text)?;
    match table.get("version") {
        Some(version) if version.as_integer() != Some(1) => {
            let problem = format!("version {version}; this program reads version 1");
            Err(Wrong::at("version", problem).in_text(text))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "tests")]
mod tests {
    use super::*;
    use crate::kept::{TakenFrom, UnitLabel};
    use crate::mark::MachineMark;
    use crate::values::parameters_of;
    use encoring_words::{Model, word};
    use proptest::prelude::*;
    use std::fs;

    fn refusal(text: &str) -> String {
        ParameterFile::parse("p.toml", text).unwrap_err().to_string()
    }

    fn of_one(model: Model, values: Vec<(Parameter, u32)>) -> KeptEncoder {
        KeptEncoder { values, ..KeptEncoder::new(model) }
    }

    /// Everything that can be kept of an encoder.
    fn full(position: usize) -> KeptEncoder {
        let values = vec![
            (Parameter::CountingDirection, 1),
            (Parameter::MeasuringLength, 9_999),
            (Parameter::Denominator, 1),
            (Parameter::SsiValues, 0x01_00_18),
        ];
        let taken = TakenFrom {
            at: "2026-11-27T18:00:00Z".to_owned(),
            bus: "modbus-tcp://h?unit=1".to_owned(),
            position,
            unreadable: vec![Parameter::Numerator],
        };
        let mark = |name: &str, shown, reference: &str| MachineMark {
            name: name.to_owned(),
            shown,
            reference: reference.parse().ok(),
        };
        KeptEncoder {
            label: UnitLabel {
                native: Some(8192),
                serial: Some("S \"1\"\n[parameters]".to_owned()),
                firmware: Some("41/1997".to_owned()),
                label: Some("axis 3".to_owned()),
            },
            taken: Some(taken),
            marks: vec![mark("stop = left", 0, "-12.5 mm"), mark("top", 4_711, "0 deg"), mark("x", 1, "")],
            ..of_one(Model::Ce65M, values)
        }
    }

    #[test]
    fn what_was_written_is_read_again() {
        let remarks = vec!["position 1234\nversion = 2".to_owned()];
        let one = ParameterFile::from(KeptEncoder { remarks, ..full(2) });
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.toml");
        one.write_new(&path).unwrap();
        assert_eq!(ParameterFile::read(&path).unwrap(), ParameterFile::from(full(2)));
        let again = one.write_new(&path).unwrap_err();
        assert!(again.to_string().ends_with("p.toml: it is there already and was left as it is"), "{again}");
        let ring = ParameterFile { encoders: vec![full(0), of_one(Model::La66, vec![]), full(5)] };
        ring.replace(&path).unwrap();
        assert_eq!(ParameterFile::read(&path).unwrap(), ring);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
        assert_eq!(ring.at(Some(5)), Ok(&ring.encoders[2]));
        assert_eq!(
            ring.at(Some(1)).unwrap_err(),
            "position 1 is not in the file; it holds the encoders at 0, 5"
        );
        assert!(ring.at(None).unwrap_err().starts_with("which one? --at POSITION tells"));
    }

    #[test]
    fn a_backup_that_was_cut_off_anywhere_is_refused() {
        let ring = ParameterFile { encoders: vec![full(0), full(5)] };
        for file in [ring, ParameterFile::from(full(2))] {
            let text = file.text();
            let whole = text.rfind("ssi_values").unwrap();
            for (end, _) in text.char_indices().filter(|(end, _)| {
                *end < whole + "ssi_values = { bits = 24, code = \"binary\", repetition = true }".len()
            }) {
                let read = ParameterFile::parse("p.toml", &text[..end]);
                // One without values is programmed nowhere.
                let nothing = |file: &ParameterFile| {
                    file.encoders.len() == 1 && file.encoders.iter().all(|kept| kept.values.is_empty())
                };
                assert!(read.is_err() || read.is_ok_and(|file| nothing(&file)), "{}", &text[..end]);
            }
        }
    }

    #[test]
    fn a_file_that_no_encoder_gave_and_that_was_cut_between_two_lines_is_refused() {
        let kept = KeptEncoder { taken: None, ..full(2) };
        let ring = ParameterFile { encoders: vec![full(0), kept.clone()] };
        for text in [ParameterFile::from(kept).text(), ring.text()] {
            let lines: Vec<_> = text.split_inclusive('\n').collect();
            let head = lines.iter().rposition(|line| line.starts_with("values = 4")).unwrap();
            for end in head + 1..lines.len() {
                let refused = refusal(&lines[..end].concat());
                if lines[..end].contains(&"[parameters]\n") {
                    assert!(refused.contains("the file was cut off or changed"), "{end}: {refused}");
                }
            }
            assert!(ParameterFile::parse("p.toml", &text).is_ok());
            // As they were written before there was a number, and by hand.
            let older = text.replace("values = 4\n", "");
            assert!(ParameterFile::parse("p.toml", &older).is_ok());
        }
    }

    #[test]
    fn comments_come_back_as_remarks_of_the_encoder_at_which_they_stand() {
        let text = "# about both\nversion = 1 # \"#\"\nencoders = 2\n\n# first\n[[encoder]]\nmodel = \"la-66\"\n# in it\n\
                    [encoder.unit]\nserial = '# none' # from the plate\n[encoder.parameters]\n\
                    measuring_length = 9    # service 02\n\n#second\n[[encoder]]\nmodel = \"la-66\"\n[encoder.parameters]\n#end\n";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.toml");
        fs::write(&path, text).unwrap();
        let file = ParameterFile::read_with_comments(&path).unwrap();
        let remarks: Vec<_> = file.encoders.iter().map(|kept| kept.remarks.clone()).collect();
        let first =
            ["about both", "version = 1: \"#\"", "first", "in it", "serial = '# none': from the plate"]
                .to_vec();
        assert_eq!(remarks, [first, ["second", "end"].to_vec()]);
        file.replace(&path).unwrap();
        assert_eq!(ParameterFile::read_with_comments(&path).unwrap(), file, "{}", file.text());
    }

    #[test]
    fn a_file_that_may_have_been_cut_within_its_last_number_is_refused_and_one_that_is_whole_is_read() {
        for kept in [full(2), of_one(Model::Ce100M, vec![(Parameter::MeasuringLength, 9_999)])] {
            let kept = KeptEncoder { values: vec![(Parameter::Denominator, 10)], taken: None, ..kept };
            let text = ParameterFile::from(kept).text();
            let number = text.rfind("= 10").unwrap() + "= ".len();
            for (end, told) in [(1, "behind \"denominator = 1\""), (2, "behind \"denominator = 10\"")] {
                let refused = refusal(&text[..number + end]);
                assert!(refused.contains(told) && refused.contains("add a line end"), "{refused}");
            }
            // Behind the number nothing more of the value is missing.
            for end in 3..=text.len() - number {
                let read = ParameterFile::parse("p.toml", &text[..number + end]).unwrap();
                assert_eq!(
                    read.encoders[0].value(Parameter::Denominator),
                    Some(10),
                    "{}",
                    &text[..number + end]
                );
            }
        }
        // What somebody typed without a line end, closed by a quote or a bracket.
        for value in ["\"0Ah\"", "\"10\""] {
            let text = format!("version = 1\nmodel = \"ce-65-m\"\n[parameters]\nnumerator = {value}");
            assert_eq!(
                ParameterFile::parse("p.toml", &text).unwrap().encoders[0].value(Parameter::Numerator),
                Some(10)
            );
        }
        let hexadecimal = refusal("version = 1\nmodel = \"ce-65-m\"\n[parameters]\nnumerator = 0x1F");
        assert!(
            hexadecimal.starts_with("p.toml line 4: the file ends within its last line"),
            "{hexadecimal}"
        );
    }

    #[test]
    fn marks_and_tables_that_cannot_be_are_refused_with_their_line() {
        let text = ParameterFile::from(full(2)).text();
        let changed = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}\n{text}");
            refusal(&text.replace(from, to))
        };
        for (from, to, says) in [
            (
                "shown = 4711",
                "shown = 16777216",
                "line 25: shown = 16777216; it must be a position from 0 to 16777215",
            ),
            ("shown = 4711", "shown = -1", "line 25: shown = -1; it must be"),
            (
                "reference_deg = 0",
                "reference_deg = 0\nreference_mm = 0",
                "line 26: a mark has reference_mm or",
            ),
            ("reference_deg = 0", "reference_deg = inf", "line 26: \"inf\" is no number like"),
            ("reference_deg = 0", "reference_deg = \"0\"", "line 26: reference_deg = \"0\" is no number"),
            (
                "\"numerator\"",
                "\"preset_value_1\"",
                "line 16: \"preset_value_1\" is no parameter of a ce-65-m",
            ),
            (
                "[\"numerator\"]",
                "[]",
                "line 12: numerator is neither in [parameters] nor in unreadable: the file was",
            ),
            ("denominator = 1 ", "denominator = 100 ", "denominator = 100; allowed are 1 to 99"),
            ("native = 8192", "native = 1", "line 5: native: 1 steps per turn; a ce-65-m has 4096 or 8192"),
        ] {
            let refused = changed(from, to);
            assert!(refused.contains(says), "{refused}\n{text}");
        }
    }

    #[test]
    fn a_mark_above_the_measuring_length_and_two_marks_of_one_name_are_refused_with_their_line() {
        let marks = |marks: &str| {
            format!("version = 1\nmodel = \"ce-65-m\"\n{marks}[parameters]\nmeasuring_length = 9999\n")
        };
        let mark = |name: &str, shown: u32| format!("[[mark]]\nname = \"{name}\"\nshown = {shown}\n");
        assert!(ParameterFile::parse("p.toml", &marks(&mark("a", 9_999))).is_ok());
        assert!(refusal(&marks(&mark("a", 10_000))).starts_with(
            "p.toml line 5: shown = 10000, and measuring_length = 9999: the encoder cannot show it"
        ));
        // A rod shows positions beyond its length.
        assert!(
            ParameterFile::parse("p.toml", &marks(&mark("a", 10_000)).replace("ce-65-m", "la-66")).is_ok()
        );
        let twice = refusal(&marks(&(mark("a", 1) + &mark("b", 1) + &mark("a", 2))));
        assert!(
            twice.starts_with(
                "p.toml line 10: \"a\" is the name of two marks: number 1 with shown = 1, and number 3 with shown = 2"
            ),
            "{twice}"
        );
    }

    #[test]
    fn files_of_several_encoders_say_which_of_them_is_wrong() {
        let encoder = "[[encoder]]\nmodel = \"la-66\"\n[encoder.parameters]\nmeasuring_length = 1\n";
        let file = format!("version = 1\nencoders = 2\n{encoder}{encoder}");
        assert_eq!(ParameterFile::parse("p.toml", &file).unwrap().encoders.len(), 2);
        let zero = format!("version = 1\n{encoder}{}", encoder.replace("= 1", "= 0"));
        assert!(refusal(&zero).starts_with("p.toml line 9: measuring_length = 0"), "{}", refusal(&zero));
        let one = format!("version = 1\nencoders = 2\n{encoder}");
        assert_eq!(refusal(&one), "p.toml line 2: encoders = 2, and 1 are in the file: it was cut off");
        let both = format!("version = 1\nmodel = \"la-66\"\n{encoder}");
        assert!(refusal(&both).contains("a file holds one encoder, or [[encoder]] tables, not both"));
    }

    #[test]
    fn hexadecimal_numbers_are_numbers_too() {
        let text = "version = 1\nmodel = \"la-66\"\n[parameters]\nmeasuring_length = 0xC350\n";
        let file = ParameterFile::parse("p.toml", text).unwrap();
        assert_eq!(file.encoders, [of_one(Model::La66, vec![(Parameter::MeasuringLength, 50_000)])]);
    }

    #[test]
    fn values_stand_as_people_write_them_and_parts_by_their_names() {
        let parameters = |text: &str| {
            let text = format!("version = 1\nmodel = \"CE 65 M\"\n[parameters]\n{text}\n");
            ParameterFile::parse("p.toml", &text).map(|file| file.encoders.into_iter().next().unwrap())
        };
        for (text, value) in [
            ("numerator = \"270Fh\"", 9_999),
            ("numerator = \"16#270F\"", 9_999),
            ("numerator = \"9999\"", 9_999),
            ("counting_direction = { direction = \"falling\", code = \"gray\" }", 0x01_01),
            ("counting_direction = \"falling, gray\"", 0x01_01),
            ("ssi_values = { bits = 25, code = \"gray\", repetition = false }", 0x01_19),
            ("ssi_values = { bits = \"19h\", code = \"gray\", repetition = \"false\" }", 0x01_19),
        ] {
            let kept = parameters(text).unwrap();
            assert_eq!((kept.values[0].1, kept.parts.len()), (value, 0), "{text}");
        }
        let kept = parameters("ssi_values = { code = \"gray\" }").unwrap();
        assert!(kept.values.is_empty());
        assert_eq!(kept.parts[0].1.of(0x01_00_18).number, 0x01_01_18);
        let written = ParameterFile::from(of_one(
            Model::Ce65M,
            vec![(Parameter::CountingDirection, 0x01_01), (Parameter::SsiValues, 0x19)],
        ));
        let text = written.text();
        assert!(text.contains("counting_direction = { direction = \"falling\", code = \"gray\" }"), "{text}");
        assert!(text.contains("ssi_values = { bits = 25, code = \"binary\", repetition = false }"), "{text}");
        for (wrong, told) in [
            ("numerator = \"000018\"", "numerator = \"000018\": 000018: 18, or 18h = 24; write one of them"),
            ("numerator = \"12345h\"", "numerator = 12345h; allowed are 1h to FFFFh"),
            ("numerator = 0x1_0000", "numerator = 10000h; allowed are 1h to FFFFh"),
            ("numerator = 70000", "numerator = 70000; allowed are 1 to 65535"),
            ("ssi_values = { bits = 0x21 }", "ssi_values = 21h; allowed are 8h to 20h"),
            ("ssi_values = { bits = 33 }", "ssi_values = 33; allowed are 8 to 32"),
            ("ssi_values = { bits = \"21h\" }", "ssi_values = 21h; allowed are 8h to 20h"),
            (
                "ssi_values = { code = \"grey\" }",
                "ssi_values = { code = \"grey\" }: ssi_code: grey is not binary or gray",
            ),
            (
                "ssi_values = { colour = 1 }",
                "ssi_values = { colour = .. }; its parts are: bits, code, repetition",
            ),
            ("ssi_values = {}", "ssi_values = {}; it must be a number, or name its parts"),
            ("numerator = { bits = 1 }", "numerator = { bits = .. }; it is a number and has no parts"),
        ] {
            assert_eq!(parameters(wrong).unwrap_err().to_string(), format!("p.toml line 4: {told}"));
        }
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
        for wrong in ["-1", "16777216", "1.5", "true"] {
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

    #[test]
    fn a_value_that_an_encoder_keeps_and_no_service_may_write_is_refused_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.toml");
        let head = "version = 1\nmodel = \"ce-65-m\"\n[parameters]\n";
        let of = |text: &str| {
            fs::write(&path, text).unwrap();
            let file = ParameterFile::read(&path).unwrap();
            let last = file.encoders.last().unwrap();
            file.may_be_written(&path, last).map_err(|refused| refused.to_string())
        };
        assert_eq!(of(&format!("{head}numerator = 1\n")), Ok(()));
        let told = "revolutions numerator: 0 is outside 1..65535";
        let refused = of(&format!("{head}denominator = 1\nnumerator = 0\n")).unwrap_err();
        assert_eq!(refused, format!("{} line 5: {told}", path.display()));
        let encoder = "[[encoder]]\nmodel = \"ce-65-m\"\n[encoder.parameters]\nnumerator = 1\n";
        let second = encoder.replace("= 1", "= 0");
        let refused = of(&format!("version = 1\nencoders = 2\n{encoder}{second}")).unwrap_err();
        assert_eq!(refused, format!("{} line 10: {told}", path.display()));
    }

    proptest! {
        #[test]
        fn no_text_does_harm(text: String) {
            let _ = ParameterFile::parse("p.toml", &text);
        }

        #[test]
        fn any_values_come_back(values: [u32; 7], model in prop::sample::select(encoring_words::model::MODELS.to_vec())) {
            let legal = |(parameter, value): (Parameter, u32)| {
                let value = value & word::DATA_MAX;
                parameter.normalise(model, value).is_ok().then_some((parameter, value))
            };
            let file = ParameterFile::from(of_one(model, parameters_of(model).zip(values).filter_map(legal).collect()));
            prop_assert_eq!(ParameterFile::parse("p.toml", &file.text()).unwrap(), file);
        }
    }
}
