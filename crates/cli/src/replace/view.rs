//! What `replace` reports.

use std::fmt;

use encoring_words::InWord;
use encoring_workshop::MachineMark;
use encoring_workshop::reconstruct::constants;
use encoring_workshop::zero::{ZeroRestored, set_of};
use serde::Serialize;

use super::source::Source;
use crate::arguments::bus::{Source as SaidBy, Target};
use crate::output::wrap::wrapped;
use crate::output::{Answer, Failure};
use crate::presetting::PresetView;
use crate::programming::ProgramView;
use crate::told::{MarkView, TargetView};

#[derive(Serialize)]
pub(super) struct ReplaceView {
    old: OldView,
    /// The new unit; `None` if none was looked at.
    new: Option<TargetView>,
    model_seen: bool,
    program: Option<ProgramView>,
    /// The mark at which the zero was made.
    set_at: Option<MarkView>,
    preset: Option<PresetView>,
    comparison: Option<ComparisonView>,
    /// What a preset can restore of the zero, in sentences.
    zero: Vec<String>,
    /// What was left undone, in sentences.
    left: Vec<String>,
    /// The scaling is one of several that fit, and nobody who was asked has seen it.
    #[serde(skip)]
    is_unseen_guess: bool,
    /// How it ended, if a step failed after the programming.
    #[serde(skip)]
    ended: Answer,
}

/// What is known of the old unit.
#[derive(Serialize)]
struct OldView {
    /// `backup`, `words`, `recording` or `positions`.
    source: &'static str,
    model: &'static str,
    values: Vec<ValueView>,
    known: Vec<String>,
    assumed: Vec<String>,
    unknown: Vec<String>,
    marks: Vec<MarkView>,
}

/// A value, and the word of a PLC program that belongs to it.
#[derive(Serialize)]
struct ValueView {
    service: String,
    name: &'static str,
    value: u32,
    word: Option<String>,
}

/// The position at a second mark.
#[derive(Serialize)]
pub(super) struct ComparisonView {
    mark: MarkView,
    /// What IN showed.
    word: String,
    /// The position; `None` if IN showed none, or with an error.
    position: Option<u32>,
    /// `position` less what the old unit showed, the shorter way around.
    off: Option<i64>,
    /// `equal`, `as_expected`, `different` or `unknown`.
    result: &'static str,
    text: String,
}

impl ComparisonView {
    pub(super) fn new(
        mark: &MachineMark,
        (word, position): (InWord, Option<u32>),
        source: &Source,
        target: Target,
    ) -> Self {
        let set = set_of(target.model, &source.kept.values);
        let positions = i64::from(target.model.largest_position(set.measuring_length())) + 1;
        let position = position.filter(|_| !word.error_bit());
        let off = position.map(|position| {
            let off = (i64::from(position) - i64::from(mark.shown)).rem_euclid(positions);
            if off > positions / 2 { off - positions } else { off }
        });
        let assumed = i64::try_from(source.off_at_most).unwrap_or(i64::MAX);
        let (below, above) = match ZeroRestored::of(target.model, &set, target.native) {
            ZeroRestored::Everywhere => (assumed, assumed),
            ZeroRestored::OfARod => (assumed.max(1), assumed.max(1)),
            ZeroRestored::AtTheMark { .. } | ZeroRestored::AtLeastAtTheMark => (assumed.max(1), assumed),
        };
        let (result, text) = match off {
            None => ("unknown", format!("IN shows {word}: no position without an error")),
            Some(0) => ("equal", "equal: the old unit showed the same here".to_owned()),
            Some(off) if (-below..=above).contains(&off) => {
                ("as_expected", format!("{off:+} against the old unit: within what can be restored"))
            }
            Some(off) => (
                "different",
                format!(
                    "{off:+} against the old unit: the machine does not stand at this mark, the zero was made at another \
                     place, or direction or scaling are not those of the old unit"
                ),
            ),
        };
        Self { mark: MarkView::new(mark), word: word.to_string(), position, off, result, text }
    }

    fn answer(&self) -> Answer {
        match self.result {
            "equal" | "as_expected" => Answer::Yes,
            "different" => Answer::No,
            _ => Answer::Unknown,
        }
    }
}

impl fmt::Display for ComparisonView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = self.position.map_or_else(|| "no position".to_owned(), |position| position.to_string());
        writeln!(f, "{}, now {shown}: {}", self.mark, self.text)
    }
}

impl ReplaceView {
    pub(super) fn new(source: &Source) -> Self {
        let kept = &source.kept;
        let words: Vec<_> = constants(kept).collect();
        let values = kept.values.iter().map(|(parameter, value)| ValueView {
            service: format!("{:02X}", parameter.service().number()),
            name: parameter.key(),
            value: *value,
            word: words.iter().find(|(of, _)| of == parameter).map(|(_, word)| word.to_string()),
        });
        let old = OldView {
            source: source.kind,
            model: kept.model.name(),
            values: values.collect(),
            known: source.known.clone(),
            assumed: source.assumed.clone(),
            unknown: source.unknown.clone(),
            marks: kept.marks.iter().map(MarkView::new).collect(),
        };
        let set = set_of(kept.model, &kept.values);
        // Of known positions the largest difference is told as assumed.
        let zero = if source.can_be_programmed() && source.off_at_most == 0 {
            ZeroRestored::of(kept.model, &set, kept.label.native).told()
        } else {
            Vec::new()
        };
        Self {
            old,
            new: None,
            model_seen: false,
            program: None,
            set_at: None,
            preset: None,
            comparison: None,
            zero,
            left: Vec::new(),
            is_unseen_guess: false,
            ended: Answer::Yes,
        }
    }

    /// What is known of the old unit, as text.
    pub(super) fn source_text(&self) -> String {
        self.old.to_string()
    }

    pub(super) fn found(&mut self, target: Target) {
        self.new = Some(TargetView::new(target));
        self.model_seen = target.source == SaidBy::Ring;
    }

    pub(super) fn programmed(&mut self, program: ProgramView) {
        self.program = Some(program);
    }

    pub(super) fn preset(&mut self, mark: &MachineMark, preset: PresetView) {
        self.set_at = Some(MarkView::new(mark));
        self.preset = Some(preset);
    }

    pub(super) fn preset_answer(&self) -> Option<Answer> {
        self.preset.as_ref().map(PresetView::answer)
    }

    pub(super) fn compared(&mut self, comparison: ComparisonView) {
        self.comparison = Some(comparison);
    }

    pub(super) fn left(&mut self, what: &str) {
        self.left.push(what.to_owned());
    }

    /// The scaling was guessed, and programmed without asking anybody.
    pub(super) fn guessed_unseen(&mut self) {
        if self.comparison.is_none() {
            self.is_unseen_guess = true;
            self.left(
                "the scaling is one of several that fit, and was not compared at a second mark: --compare-at",
            );
        }
    }

    /// Whether there is a report of the programming.
    pub(super) const fn has_programmed(&self) -> bool {
        self.program.is_some()
    }

    /// A step after the programming failed; what was done before stays, and is told.
    pub(super) fn failed(&mut self, failure: Failure) -> Result<(), Failure> {
        let (why, ended) = failure.after_the_fact()?;
        self.left.push(why);
        self.ended = ended;
        Ok(())
    }

    /// Without a second place nobody knows whether a guessed scaling is that of the old unit; whoever was asked has seen that.
    const fn uncompared(&self) -> Answer {
        if self.is_unseen_guess { Answer::Unknown } else { Answer::Yes }
    }

    pub(super) fn answer(&self, dry_run: bool) -> Answer {
        let program = self.program.as_ref();
        let programmed = program.map_or(Answer::No, ProgramView::answer);
        Answer::of_all([
            match program {
                Some(program) if dry_run && programmed == Answer::Yes && program.differs() => Answer::No,
                _ => programmed,
            },
            self.preset_answer().unwrap_or(Answer::Yes),
            self.comparison.as_ref().map_or(self.uncompared(), ComparisonView::answer),
            self.ended,
        ])
    }
}

impl fmt::Display for OldView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "the old unit, a {}:", self.model)?;
        let mut sentences = |head: &str, list: &[String]| -> fmt::Result {
            let line = |line: &String| wrapped(&format!("  {head:<8} {line}"), 9);
            list.iter().try_for_each(|each| writeln!(f, "{}", line(each)))
        };
        sentences("known", &self.known)?;
        sentences("assumed", &self.assumed)?;
        sentences("unknown", &self.unknown)?;
        if !self.values.is_empty() {
            writeln!(f, "values, and the words that write them in the PLC program:")?;
        }
        for ValueView { service, name, value, word } in &self.values {
            let word = word.as_deref().unwrap_or("");
            let halves = match (word.get(..4), word.get(4..)) {
                (Some(high), Some(low)) => format!("{word} = W#16#{high} W#16#{low}"),
                _ => String::new(),
            };
            writeln!(f, "  {service}  {name:<18}  {value:>8}  {halves}")?;
        }
        self.marks.iter().try_for_each(|mark| writeln!(f, "  {mark}"))
    }
}

impl fmt::Display for ReplaceView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.old)?;
        if let Some(new) = &self.new {
            let seen = if self.model_seen { "" } else { "; its model was not seen, look at its type label" };
            writeln!(f, "\nthe new unit: {new}{seen}")?;
        }
        if let Some(program) = &self.program {
            write!(f, "{program}")?;
        }
        if let (Some(mark), Some(preset)) = (&self.set_at, &self.preset) {
            write!(f, "\nzero at {mark}\n{preset}")?;
        }
        if let Some(comparison) = &self.comparison {
            write!(f, "\n{}", wrapped(&format!("compared: {comparison}"), 2))?;
        }
        self.left.iter().try_for_each(|left| writeln!(f, "left undone: {left}"))?;
        if !self.zero.is_empty() {
            writeln!(f)?;
        }
        self.zero.iter().try_for_each(|line| writeln!(f, "{}", wrapped(line, 0)))
    }
}
