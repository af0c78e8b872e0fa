//! What `restore` reports.

use std::fmt;

use encoring_workshop::KeptEncoder;
use encoring_workshop::zero::{ZeroRestored, set_of};
use serde::Serialize;

use crate::arguments::bus::{Source, Target};
use crate::output::Answer;
use crate::output::wrap::wrapped;
use crate::programming::ProgramView;
use crate::told::MarkView;

#[derive(Serialize)]
pub(super) struct RestoreView {
    file: String,
    #[serde(flatten)]
    program: ProgramView,
    /// The model was seen, not only taken from the file.
    model_seen: bool,
    /// What another model does not take: sentences.
    not_carried_over: Vec<String>,
    /// What the file does not have because it could not be read: sentences.
    not_in_file: Vec<String>,
    /// Presets that make the zero again, one for each mark.
    marks: Vec<MarkView>,
    /// What a preset can restore of the zero, and how.
    zero: Vec<String>,
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
            model_seen: target.source == Source::Ring,
            not_carried_over: lost,
            not_in_file: unread.collect(),
            marks: kept.marks.iter().map(MarkView::new).collect(),
            zero,
        }
    }

    pub(super) fn answer(&self, dry_run: bool) -> Answer {
        match self.program.answer() {
            Answer::Yes if dry_run && self.program.differs() => Answer::No,
            Answer::Yes if !self.not_in_file.is_empty() => Answer::Unknown,
            answer => answer,
        }
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
            writeln!(f, "the model was not seen: no word tells it, the file says {}", self.program.model())?;
        }
        self.not_carried_over.iter().try_for_each(|lost| writeln!(f, "not carried over: {lost}"))?;
        self.not_in_file.iter().try_for_each(|lost| writeln!(f, "not restored: {lost}"))?;
        if !self.zero.is_empty() {
            writeln!(f)?;
        }
        // What is to be typed stays on its line.
        let line = |line: &String| if line.starts_with(' ') { line.clone() } else { wrapped(line, 0) };
        self.zero.iter().try_for_each(|each| writeln!(f, "{}", line(each)))
    }
}
