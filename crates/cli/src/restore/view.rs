//! What `restore` reports.

use std::fmt;

use encoring_workshop::zero::{ZeroRestored, set_of};
use encoring_workshop::{KeptEncoder, MachineMark};
use serde::Serialize;

use crate::arguments::bus::{Source, Target};
use crate::output::wrap::wrapped;
use crate::output::{Answer, Failure};
use crate::presetting::PresetView;
use crate::programming::ProgramView;
use crate::told::MarkView;

#[derive(Serialize)]
pub(super) struct RestoreView {
    file: String,
    #[serde(flatten)]
    program: ProgramView,
    /// That of the file.
    #[serde(skip)]
    file_model: &'static str,
    /// How the zero ended, if it was begun and has no report of its own.
    #[serde(skip)]
    zero_ended: Answer,
    /// The model was seen, not only taken from the file.
    model_seen: bool,
    /// What another model does not take: sentences.
    not_carried_over: Vec<String>,
    /// What the file does not have because it could not be read: sentences.
    not_in_file: Vec<String>,
    /// Presets that make the zero again, one for each mark.
    marks: Vec<MarkView>,
    /// The mark at which the zero was made.
    set_at: Option<MarkView>,
    preset: Option<PresetView>,
    /// What a preset can restore of the zero, and how.
    zero: Vec<String>,
}

/// Every encoder of a file.
#[derive(Serialize)]
pub(super) struct RingView {
    file: String,
    encoders: Vec<ComparedView>,
}

#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum ComparedView {
    Compared(Box<RestoreView>),
    /// Why it was not compared.
    Failed {
        position: usize,
        failed: String,
    },
}

impl RingView {
    pub(super) fn new(file: &str, encoders: Vec<ComparedView>) -> Self {
        Self { file: file.to_owned(), encoders }
    }

    pub(super) fn answer(&self) -> Answer {
        Answer::of_all(self.encoders.iter().map(|encoder| match encoder {
            ComparedView::Compared(view) => view.answer(true),
            ComparedView::Failed { .. } => Answer::Unknown,
        }))
    }
}

impl fmt::Display for RingView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.encoders.iter().try_for_each(|encoder| match encoder {
            ComparedView::Compared(view) => writeln!(f, "{view}"),
            ComparedView::Failed { position, failed } => {
                writeln!(f, "position {position}: not compared: {failed}\n")
            }
        })
    }
}

impl RestoreView {
    pub(super) fn new(
        program: ProgramView,
        file: &str,
        address: &str,
        kept: &KeptEncoder,
        target: Target,
        lost: Vec<String>,
    ) -> Self {
        let unread = kept.unreadable().iter().map(|parameter| {
            format!("{}: it could not be read when the file was made; it stays as it is", parameter.key())
        });
        let zero = if program.is_in_order() { zero(address, kept, target) } else { Vec::new() };
        Self {
            file: file.to_owned(),
            program,
            file_model: kept.model.name(),
            zero_ended: Answer::Yes,
            model_seen: target.source == Source::Ring,
            not_carried_over: lost,
            not_in_file: unread.collect(),
            marks: kept.marks.iter().map(MarkView::new).collect(),
            set_at: None,
            preset: None,
            zero,
        }
    }

    /// The zero was tried to be made here.
    pub(super) fn zero_made(&mut self, mark: &MachineMark, preset: PresetView) {
        if preset.answer() == Answer::Yes {
            self.zero.clear();
        }
        self.set_at = Some(MarkView::new(mark));
        self.preset = Some(preset);
    }

    /// The zero was not made; the way to it stands below.
    pub(super) fn zero_left(&mut self, why: &str) {
        self.zero.insert(0, format!("The zero was not made: {why}."));
    }

    /// The zero could not be made; what is programmed stays, and is told.
    pub(super) fn zero_failed(&mut self, failure: Failure) -> Result<(), Failure> {
        let (why, ended) = failure.after_the_fact()?;
        self.zero_left(&why);
        self.zero_ended = ended;
        Ok(())
    }

    pub(super) fn answer(&self, dry_run: bool) -> Answer {
        let program = match self.program.answer() {
            Answer::Yes if dry_run && self.program.differs() => Answer::No,
            Answer::Yes if !self.not_in_file.is_empty() => Answer::Unknown,
            answer => answer,
        };
        let preset = self.preset.as_ref().map_or(Answer::Yes, PresetView::answer);
        Answer::of_all([program, preset, self.zero_ended])
    }
}

/// The way to the zero.
fn zero(address: &str, kept: &KeptEncoder, target: Target) -> Vec<String> {
    let mut text = vec!["The zero is not restored: no service reads the offset of a preset.".to_owned()];
    if kept.marks.is_empty() {
        text.push("No mark is in the file: at a place whose position you know, type".to_owned());
        text.push(format!("  encoring preset POSITION {}", options(address, target)));
    } else {
        text.push("Move to one of these marks, stop there, and type:".to_owned());
    }
    for mark in &kept.marks {
        text.push(format!("  at {mark}: encoring preset {} {}", mark.shown, options(address, target)));
    }
    let set = set_of(target.model, &kept.values);
    text.extend(ZeroRestored::of(target.model, &set, target.native).told());
    text
}

/// The options that lead to the same encoder.
fn options(address: &str, target: Target) -> String {
    let Target { position, model, source, .. } = target;
    let model = if source == Source::Ring { String::new() } else { format!(" --model {model}") };
    // An address may hold signs that a shell would take.
    let quoted = if address.contains(['?', '&', ' ']) { format!("'{address}'") } else { address.to_owned() };
    format!("--bus {quoted} --at {position}{model}")
}

impl fmt::Display for RestoreView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.program)?;
        if !self.model_seen {
            let model = self.program.model();
            let said_by = if model == self.file_model { "the file" } else { "--as" };
            writeln!(f, "the model was not seen: no word tells it, {said_by} says {model}")?;
        }
        self.not_carried_over.iter().try_for_each(|lost| writeln!(f, "not carried over: {lost}"))?;
        self.not_in_file.iter().try_for_each(|lost| writeln!(f, "not restored: {lost}"))?;
        if let (Some(mark), Some(preset)) = (&self.set_at, &self.preset) {
            write!(f, "\nzero at {mark}\n{preset}")?;
        }
        if !self.zero.is_empty() {
            writeln!(f)?;
        }
        // What is to be typed stays on its line.
        let line = |line: &String| if line.starts_with(' ') { line.clone() } else { wrapped(line, 0) };
        self.zero.iter().try_for_each(|each| writeln!(f, "{}", line(each)))
    }
}
