//! What `program` and `write` report.

use std::fmt;

use encoring_bus::Behind;
use encoring_bus::master::MasterError;
use encoring_host::program::{Back, ParameterRow, Prepared, Report, Stopped};
use encoring_host::service::Check;
use encoring_words::explain::Meaning;
use encoring_words::model::Effect;
use encoring_words::parameter::{Code, CountingDirection};
use encoring_words::{ErrorStatus, InWord, Model, Parameter};
use serde::Serialize;

use crate::arguments::bus::Target;
use crate::calculation::Note;
use crate::noted::{Earlier, EarlierView};
use crate::output::Answer;
use crate::told::{FailureView, Shown, StatusView, TargetView};

#[derive(Serialize)]
pub(crate) struct ProgramView {
    #[serde(flatten)]
    target: TargetView,
    /// `verified`, `already_programmed`, `planned`, `not_begun`, `taken_back` or `incomplete`.
    result: &'static str,
    /// A data check has made the values count.
    checked: bool,
    parameters: Vec<RowView>,
    /// Errors that were pending before, and are over.
    earlier: Option<StatusView>,
    status: Option<StatusView>,
    failure: Option<FailureView>,
    before: Option<Shown>,
    after: Option<Shown>,
    /// The file that holds the old values.
    backup: Option<String>,
    /// A command that was begun here before and is not known to have ended.
    journal: Option<EarlierView>,
    /// What to know of these values.
    warnings: Vec<String>,
    text: Vec<String>,
    #[serde(skip)]
    answer: Answer,
}

#[derive(Serialize)]
struct RowView {
    service: String,
    name: &'static str,
    before: Option<u32>,
    wanted: Option<u32>,
    /// `None` if it is not known.
    now: Option<u32>,
    meaning: Option<String>,
}

impl RowView {
    fn new(row: &ParameterRow, model: Model) -> Self {
        Self {
            service: format!("{:02X}", row.parameter.service().number()),
            name: row.parameter.key(),
            before: row.before,
            wanted: row.wanted,
            now: row.now,
            meaning: row.now.and_then(|value| meaning(row.parameter, model, value)),
        }
    }
}

fn meaning(parameter: Parameter, model: Model, value: u32) -> Option<String> {
    Meaning::of(parameter, model, value).map(|meaning| meaning.to_string())
}

/// The code in which a word shows the position, as far as the rows know.
fn code(rows: &[&ParameterRow], pick: impl Fn(&ParameterRow) -> Option<u32>, model: Model) -> Option<Code> {
    if !model.position_may_be_gray() {
        return Some(Code::Binary);
    }
    let direction = rows.iter().find(|row| row.parameter == Parameter::CountingDirection);
    direction.and_then(|row| pick(row)).map(|value| CountingDirection::from_data(value).code)
}

impl ProgramView {
    fn new(target: Target, rows: &[&ParameterRow], earlier: ErrorStatus) -> Self {
        let earlier = (!earlier.is_empty())
            .then(|| StatusView::of(Check { status: earlier, remains: false }, target.model));
        Self {
            target: TargetView::new(target),
            result: "verified",
            checked: false,
            parameters: rows.iter().map(|row| RowView::new(row, target.model)).collect(),
            earlier,
            status: None,
            failure: None,
            before: None,
            after: None,
            backup: None,
            journal: None,
            warnings: Vec::new(),
            text: Vec::new(),
            answer: Answer::Yes,
        }
    }

    /// What would be written.
    pub(super) fn planned(
        target: Target,
        prepared: &Prepared<MasterError>,
        behind: Option<&Behind>,
        backup: Option<String>,
    ) -> Self {
        let rows: Vec<_> = prepared.rows().collect();
        let mut view = Self::new(target, &rows, prepared.earlier());
        view.result = "planned";
        for (view, row) in view.parameters.iter_mut().zip(&rows) {
            let wanted = row.wanted.and_then(|value| meaning(row.parameter, target.model, value));
            view.meaning = wanted.or(view.meaning.take());
        }
        view.before = shown(prepared.shown(), code(&rows, |row| row.before, target.model));
        view.backup = backup;
        match prepared.stopped() {
            Some(stopped) => view.stopped(stopped, target, &rows, behind),
            None if prepared.is_programmed() => view.text.push("everything is programmed already".to_owned()),
            None => {}
        }
        view.text.push("nothing was written: --dry-run".to_owned());
        view.pending(prepared.shown());
        view
    }

    /// What was written.
    pub(super) fn done(
        target: Target,
        report: &Report<MasterError>,
        behind: Option<&Behind>,
        backup: Option<String>,
    ) -> Self {
        let model = target.model;
        let rows: Vec<_> = report.rows.iter().flatten().collect();
        let mut view = Self::new(target, &rows, report.earlier);
        view.before = shown(report.shown_before, code(&rows, |row| row.before, model));
        view.after = shown(report.shown_after, code(&rows, |row| row.now, model));
        view.backup = backup;
        if let Err(stopped) = &report.result {
            view.stopped(stopped, target, &rows, behind);
        }
        view.checked = report.checked;
        let (result, text) = ended(report, model);
        view.result = result;
        view.text.push(text.to_owned());
        view.pending(report.shown_after);
        view
    }

    /// The same with where the bus is.
    pub(super) fn at(self, place: &str) -> Self {
        Self { failure: self.failure.map(|failure| failure.at(place)), ..self }
    }

    /// With what there is to know of a range.
    pub(crate) fn warned(mut self, warnings: &[Note]) -> Self {
        self.warnings =
            warnings.iter().map(|warning| format!("{}: {}", warning.topic, warning.text)).collect();
        self
    }

    /// With what was begun here before.
    pub(super) fn after(mut self, earlier: Option<&Earlier>) -> Self {
        self.journal = earlier.map(Earlier::view);
        self
    }

    /// The model whose services were used.
    pub(crate) const fn model(&self) -> &'static str {
        self.target.model
    }

    /// Whether a value is wanted that was not there.
    pub(crate) fn differs(&self) -> bool {
        self.parameters.iter().any(|row| row.wanted.is_some() && row.wanted != row.before)
    }

    /// Whether the encoder now holds what was wanted.
    pub(crate) fn is_in_order(&self) -> bool {
        matches!(self.result, "verified" | "already_programmed")
    }

    /// An error that is pending at the end is no success, whatever was done.
    fn pending(&mut self, shown: Option<InWord>) {
        if shown.is_some_and(InWord::error_bit) {
            if self.answer == Answer::Yes {
                self.answer = Answer::No;
            }
            self.text.push("an error is pending: `encoring check` tells which".to_owned());
        }
    }

    fn stopped(
        &mut self,
        stopped: &Stopped<MasterError>,
        target: Target,
        rows: &[&ParameterRow],
        behind: Option<&Behind>,
    ) {
        self.answer = Answer::No;
        match *stopped {
            Stopped::Service(ref failed) => {
                let failure = FailureView::new(failed, target, behind);
                self.answer = failure.answer();
                self.failure = Some(failure);
            }
            Stopped::WouldBeRefused(status) => {
                self.status = Some(StatusView::of(Check { status, remains: true }, target.model));
                self.text.push("the data check would refuse these values together:".to_owned());
                self.limits(rows, target.model);
            }
            Stopped::NotAccepted(check) => {
                self.status = Some(StatusView::of(check, target.model));
                self.text.push("the data check refused these values:".to_owned());
                self.limits(rows, target.model);
            }
            Stopped::NotStored { parameter, wanted, read } => self.text.push(format!(
                "{} was acknowledged as {wanted} and reads back as {read}",
                parameter.key()
            )),
            Stopped::Overruled { parameter, asked, stored } => {
                let told = |value: u32| match meaning(parameter, target.model, value) {
                    Some(meaning) => format!("{value} ({meaning})"),
                    None => value.to_string(),
                };
                self.text.push(format!(
                    "{} would be stored as {}, not as {}: with a repetition it has 24 bits, whatever is asked",
                    parameter.key(),
                    told(stored),
                    told(asked)
                ));
            }
            Stopped::Unreadable { parameter } => {
                self.answer = Answer::Unknown;
                self.text.push(format!(
                    "{} cannot be read for certain: an error is pending, and a 0 may also be a record that cannot be \
                     read",
                    parameter.key()
                ));
            }
            Stopped::Position { shown: InWord(word), length } => self.text.push(format!(
                "the values are accepted, but IN shows {word:08X}: no position from 0 to {length} without an error"
            )),
        }
    }

    /// Which limit it was, with its number.
    fn limits(&mut self, rows: &[&ParameterRow], model: Model) {
        let above = ParameterRow::above_length(rows.iter().copied(), model);
        self.text.extend(above.map(|above| above.to_string()));
    }

    pub(crate) const fn answer(&self) -> Answer {
        self.answer
    }
}

/// The result in a word and in a sentence.
fn ended(report: &Report<MasterError>, model: Model) -> (&'static str, &'static str) {
    match report.back {
        Back::NotNeeded if report.checked => ("verified", verified(report)),
        // A written value is in use at once [C7].
        Back::NotNeeded if model.effect() == Effect::AtOnce => {
            ("already_programmed", "already programmed, and in use")
        }
        Back::NotNeeded => (
            "already_programmed",
            "already programmed; whether the position is computed with it cannot be read. `encoring check`, or \
             --check, makes it count",
        ),
        Back::NothingWritten => ("not_begun", "nothing was written: the encoder holds what it held"),
        Back::Restored => (
            "taken_back",
            "the old values were written back, checked and read back: the encoder holds what it held",
        ),
        Back::Failed => (
            "incomplete",
            "the old values could not be written back completely. The column now says what the encoder holds, \
             ? is not known;\nwith which of these values the position is computed is not known. Repeat the \
             command, or write the backup back.",
        ),
    }
}

fn verified(report: &Report<MasterError>) -> &'static str {
    if report.rows.iter().flatten().any(ParameterRow::changes) {
        "done and verified: written, checked, read back"
    } else {
        "done and verified: checked, read back; nothing had to be written"
    }
}

fn shown(word: Option<InWord>, code: Option<Code>) -> Option<Shown> {
    word.map(|word| Shown::new(word, code))
}

impl fmt::Display for ProgramView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number =
            |value: Option<u32>, none: &str| value.map_or(none.to_owned(), |value| value.to_string());
        writeln!(f, "{}", self.target)?;
        writeln!(f, "service  parameter             before    wanted       now")?;
        for row in &self.parameters {
            let line = format!(
                "{:<7}  {:<18}  {:>8}  {:>8}  {:>8}  {}",
                row.service,
                row.name,
                number(row.before, "?"),
                number(row.wanted, "-"),
                number(row.now, "?"),
                row.meaning.as_deref().unwrap_or("")
            );
            writeln!(f, "{}", line.trim_end())?;
        }
        if let Some(before) = &self.before {
            writeln!(f, "position before: {before}")?;
        }
        if let Some(after) = &self.after {
            writeln!(f, "position now:    {after}")?;
        }
        if let Some(earlier) = &self.earlier {
            writeln!(f, "pending before:  {earlier}")?;
        }
        if let Some(failure) = &self.failure {
            writeln!(f, "{failure}")?;
        }
        if let (Some(status), Some((first, rest))) = (&self.status, self.text.split_first()) {
            writeln!(f, "{first}\n{status}")?;
            rest.iter().try_for_each(|line| writeln!(f, "{line}"))?;
        } else {
            self.text.iter().try_for_each(|line| writeln!(f, "{line}"))?;
        }
        self.warnings.iter().try_for_each(|warning| writeln!(f, "{warning}"))?;
        if let Some(backup) = &self.backup {
            writeln!(f, "the old values are in {backup}")?;
        }
        Ok(())
    }
}
