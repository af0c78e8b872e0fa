//! The position shall be a value, here and now: what `preset` and `replace` do.

use std::fmt;

use encoring_bus::Behind;
use encoring_bus::master::MasterError;
use encoring_host::preset::{Done, Preset, PresetReport, position};
use encoring_host::service::check;
use encoring_host::session::Fate;
use encoring_words::InWord;
use encoring_words::number::TypedValue;
use encoring_words::parameter::Code;
use encoring_workshop::zero::{ZeroRestored, set_of};
use encoring_workshop::{KeptEncoder, MachineMark};
use serde::Serialize;

use crate::arguments::bus::Target;
use crate::bus::Opened;
use crate::dialog::{CHECK_DOES, Dialog, Undone};
use crate::output::{Answer, Failure, bad_input, note};
use crate::told::{Failed, FailureView, StatusView, TargetView};

/// A preset adjustment that is to be made.
#[derive(Clone, Copy)]
pub(crate) struct Presetting<'a> {
    /// What the position shall be, in steps.
    pub(crate) value: TypedValue,
    /// Where the machine stands, if it is known.
    pub(crate) mark: Option<&'a MachineMark>,
    pub(crate) dialog: &'a Dialog,
}

#[derive(Serialize)]
pub(crate) struct PresetView {
    #[serde(flatten)]
    target: TargetView,
    wanted: u32,
    /// In steps.
    before: Option<u32>,
    after: Option<u32>,
    /// The encoder acknowledged it without an error, and the position shows it.
    done: bool,
    /// What IN showed last.
    error_bit: bool,
    failure: Option<FailureView>,
    text: Vec<String>,
    #[serde(skip)]
    answer: Answer,
}

impl fmt::Display for PresetView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown =
            |position: Option<u32>| position.map_or_else(|| "not seen".to_owned(), |steps| steps.to_string());
        writeln!(f, "{}", self.target)?;
        writeln!(f, "position before: {}", shown(self.before))?;
        if let Some(failure) = &self.failure {
            writeln!(f, "{failure}")?;
        }
        let pending = if self.error_bit { ", an error is pending" } else { "" };
        writeln!(f, "position now:    {}{pending}", shown(self.after))?;
        self.text.iter().try_for_each(|line| writeln!(f, "{line}"))
    }
}

/// Where the zero shall be made, by asking; before it is told what a preset can restore. `None` if it shall not.
pub(crate) fn zero_place(
    dialog: &Dialog,
    kept: &KeptEncoder,
    target: Target,
) -> Result<Option<MachineMark>, Undone> {
    let set = set_of(target.model, &kept.values);
    let restored = ZeroRestored::of(target.model, &set, target.native).told();
    dialog.tell(&format!("\n{}", restored.join("\n")));
    dialog.place(
        "Move the machine to a mark and stop it there: its zero is made there.",
        &kept.marks,
        kept.largest_position(),
    )
}

/// What makes the old zero again.
fn way_back(report: &PresetReport<MasterError>) -> Option<String> {
    report.before.map(|before| format!("the way back, at the same place: `encoring preset {before}`"))
}

impl PresetView {
    pub(crate) const fn answer(&self) -> Answer {
        self.answer
    }
}

impl Presetting<'_> {
    /// Asks, and sets the zero.
    pub(crate) fn adjust(self, opened: &mut Opened, target: Target) -> Result<PresetView, Undone> {
        let mut prepared = self.prepare(opened, target)?;
        // Consent to the preset is none to a data check.
        if let Err(pending @ (Failed::ErrorPending { .. } | Failed::NotActive { .. })) = &prepared
            && self.dialog.can_ask()
        {
            self.dialog.confirmed(&format!(
                "{}\n{}: {CHECK_DOES} It comes first.",
                FailureView::new(pending, target, None),
                TargetView::new(target)
            ))?;
            let checked = opened.serve(target, |master| check(master))?;
            note(&StatusView::of(checked, target.model).to_string());
            prepared = self.prepare(opened, target)?;
        }
        let preset = match prepared {
            Ok(preset) => preset,
            Err(failed) => return Ok(self.not_begun(target, &failed)),
        };
        let shown = preset.before().ok_or_else(|| bad_input("the encoder shows no position"))?;
        let moves = match preset.steps_per_s() {
            Some(0) => None,
            Some(steps) => Some(format!("the shaft or magnet moves, by some {steps} steps a second")),
            None => Some("whether the shaft or magnet moves was not seen".to_owned()),
        };
        let question = format!(
            "{}: the position is {shown} now and shall be {}.{}{} The old zero cannot be read back.",
            TargetView::new(target),
            self.value.number,
            self.mark.map(|mark| format!(" The machine must stand at {mark}.")).unwrap_or_default(),
            moves.as_ref().map(|moves| format!(" Stop the axis: {moves}.")).unwrap_or_default()
        );
        self.dialog.confirmed(&question)?;
        if let (true, Some(moves)) = (self.dialog.is_silent(), &moves) {
            note(&format!("note: {moves}"));
        }
        let view = opened.serve(target, |master| {
            let report = preset.adjust(master);
            Ok(self.told(target, &report, master.behind().as_ref(), moves))
        })?;
        let failure = view.failure.map(|failure| failure.at(&opened.place()));
        Ok(PresetView { failure, ..view })
    }

    /// What hinders a preset adjustment is a finding; that nobody answers is none.
    fn prepare(self, opened: &mut Opened, target: Target) -> Result<Result<Preset, Failed>, Failure> {
        opened.serve(target, |master| match Preset::prepare(master, target.model, self.value) {
            Err(
                failed @ (Failed::ErrorPending { .. }
                | Failed::NotActive { .. }
                | Failed::Refused(_)
                | Failed::Unreadable { .. }),
            ) => Ok(Err(failed)),
            prepared => prepared.map(Ok),
        })
    }

    fn not_begun(self, target: Target, failed: &Failed) -> PresetView {
        let failure = FailureView::new(failed, target, None);
        // Whether it is in Gray code would have to be asked.
        let shown = match failed {
            Failed::ErrorPending { shown } if !target.model.position_may_be_gray() => {
                position(*shown, Code::Binary)
            }
            Failed::NotActive { position, .. } => Some(*position),
            _ => None,
        };
        PresetView {
            target: TargetView::new(target),
            wanted: self.value.number,
            before: shown,
            after: shown,
            done: false,
            // What else it is, the encoder has an error pending because of it or before it.
            error_bit: !matches!(failed, Failed::NotActive { .. }),
            answer: failure.answer(),
            failure: Some(failure),
            text: vec!["not done: the zero is as it was".to_owned()],
        }
    }

    fn told(
        self,
        target: Target,
        report: &PresetReport<MasterError>,
        behind: Option<&Behind>,
        moves: Option<String>,
    ) -> PresetView {
        let failure = report.result.as_ref().err().map(|failed| FailureView::new(failed, target, behind));
        let error_bit = report.shown.is_some_and(InWord::error_bit);
        let answer = match (&failure, &report.result) {
            (Some(failure), _) => failure.answer(),
            (None, Ok(Done::Confirmed)) if !error_bit => Answer::Yes,
            (None, Ok(Done::Confirmed)) => Answer::No,
            (None, _) => Answer::Unknown,
        };
        let mut text = self.text(report);
        text.extend(moves);
        PresetView {
            target: TargetView::new(target),
            wanted: self.value.number,
            before: report.before,
            after: report.after,
            done: report.result == Ok(Done::Confirmed),
            error_bit,
            failure,
            text,
            answer,
        }
    }

    /// What the report comes to.
    fn text(self, report: &PresetReport<MasterError>) -> Vec<String> {
        let mut text = match &report.result {
            Ok(Done::Confirmed) if report.after == Some(self.value.number) => vec!["done".to_owned()],
            Ok(Done::Confirmed) => vec![format!(
                "done: the position is no longer {}, as far from it as it moved before",
                self.value.number
            )],
            Ok(Done::Acknowledged) => vec![
                "acknowledged, not confirmed: the encoder reported no error, but the position does not show the \
                 value. Compare it with a mark on the machine"
                    .to_owned(),
            ],
            Err(failed) => return self.not_done(report, failed),
        };
        text.extend(way_back(report));
        text
    }

    fn not_done(self, report: &PresetReport<MasterError>, failed: &Failed) -> Vec<String> {
        if failed.is_not_sent() {
            return vec!["not done: the zero is as it was".to_owned()];
        }
        let mut text = vec!["not repeated: a second preset adjustment could set another zero".to_owned()];
        let fate = match failed {
            Failed::TimedOut { timed_out, .. } => timed_out.fate,
            Failed::GivenUp { given_up, .. } => given_up.fate,
            // An error that came up meanwhile shows in the same bit.
            _ => Fate::Unknown,
        };
        if fate == Fate::Unknown {
            let seems = match (report.before, report.after) {
                (Some(before), Some(after)) if after == self.value.number && before != after => {
                    "the position is what was asked for, so it seems to be done"
                }
                (Some(before), Some(after)) if after == before => {
                    "the position has not changed, so it seems not to be done"
                }
                _ => "compare the position with a mark on the machine",
            };
            text.push(seems.to_owned());
        }
        text.extend(way_back(report).map(|way| format!("if it was done, {way}")));
        text
    }
}
