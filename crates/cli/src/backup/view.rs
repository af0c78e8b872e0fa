//! What `backup` reports.

use std::fmt;

use encoring_bus::master::MasterError;
use encoring_words::InWord;
use encoring_workshop::KeptEncoder;
use encoring_workshop::reading::Readings;
use serde::Serialize;

use crate::arguments::bus::Target;
use crate::output::Answer;
use crate::told::{FailureView, MarkView, ParameterView, TargetView};

#[derive(Serialize)]
pub(super) struct BackupView {
    file: String,
    /// `written`, `updated`, `already_there` or `nothing`.
    result: &'static str,
    encoders: Vec<EncoderView>,
    text: Vec<String>,
}

#[derive(Serialize)]
pub(super) struct EncoderView {
    #[serde(flatten)]
    target: TargetView,
    parameters: Vec<ParameterView>,
    /// Parameters that the model can read and that were not read.
    unreadable: Vec<&'static str>,
    marks: Vec<MarkView>,
    /// What IN showed last.
    shown: Option<String>,
    error_bit: bool,
    failures: Vec<FailureView>,
    /// Why nothing of it was read.
    failed: Option<String>,
}

impl EncoderView {
    pub(super) fn kept(target: Target, readings: &Readings<MasterError>, kept: &KeptEncoder) -> Self {
        let values = readings.values();
        let [_, shown] = readings.shown;
        let refused = readings.parameters.iter().filter_map(|read| read.refused.as_ref());
        Self {
            target: TargetView::new(target),
            parameters: values
                .map(|(parameter, value)| ParameterView::new(parameter, target.model, value))
                .collect(),
            unreadable: readings
                .values()
                .filter(|(_, value)| value.is_none())
                .map(|(parameter, _)| parameter.key())
                .collect(),
            marks: kept.marks.iter().map(MarkView::new).collect(),
            shown: Some(shown.to_string()),
            error_bit: InWord::error_bit(shown),
            failures: refused.map(|failed| FailureView::new(failed, target, None)).collect(),
            failed: None,
        }
    }

    pub(super) fn failed(target: Target, why: String) -> Self {
        Self {
            target: TargetView::new(target),
            parameters: Vec::new(),
            unreadable: Vec::new(),
            marks: Vec::new(),
            shown: None,
            error_bit: false,
            failures: Vec::new(),
            failed: Some(why),
        }
    }

    /// The file that is there already has marks of its own.
    pub(super) fn holds(&mut self, kept: &KeptEncoder) {
        self.marks = kept.marks.iter().map(MarkView::new).collect();
    }

    pub(super) const fn is_failed(&self) -> bool {
        self.failed.is_some()
    }
}

impl BackupView {
    pub(super) fn new(file: String, result: &'static str, encoders: Vec<EncoderView>) -> Self {
        let mut text = vec![match result {
            "written" => format!("kept in {file}"),
            "updated" if encoders.iter().any(|encoder| !encoder.unreadable.is_empty()) => {
                format!(
                    "{file} was updated; a value that was not read now was not compared, and stays as the file had it"
                )
            }
            "updated" => format!("{file} was updated"),
            "already_there" => format!("{file} is there already and holds the same; it was left as it is"),
            _ => "nothing was read, so nothing was kept".to_owned(),
        }];
        if encoders.iter().any(|encoder| encoder.error_bit) {
            text.push(
                "an error is pending, so a ? may be 0 or a record that cannot be read; `encoring check` tells"
                    .to_owned(),
            );
        }
        if result != "nothing" {
            text.push(
                "programmed values: whether the position is computed with them cannot be read, nor the offset of a \
                 preset"
                    .to_owned(),
            );
            if encoders.iter().any(|encoder| !encoder.is_failed() && encoder.marks.is_empty()) {
                text.push(
                    "no mark is kept, so the zero cannot be found again: move to a place that can be, and type \
                     --update --mark \"NAME=0 mm\""
                        .to_owned(),
                );
            }
        }
        Self { file, result, encoders, text }
    }

    pub(super) fn answer(&self) -> Answer {
        let whole = |encoder: &EncoderView| !encoder.is_failed() && encoder.unreadable.is_empty();
        if self.encoders.iter().all(whole) { Answer::Yes } else { Answer::Unknown }
    }
}

impl fmt::Display for EncoderView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.target)?;
        if let Some(failed) = &self.failed {
            return writeln!(f, "not read: {failed}");
        }
        self.parameters.iter().try_for_each(|parameter| writeln!(f, "{parameter}"))?;
        self.marks.iter().try_for_each(|mark| writeln!(f, "{mark}"))?;
        self.failures.iter().try_for_each(|failure| writeln!(f, "{failure}"))
    }
}

impl fmt::Display for BackupView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.encoders.iter().try_for_each(|encoder| writeln!(f, "{encoder}"))?;
        self.text.iter().try_for_each(|line| writeln!(f, "{line}"))
    }
}
