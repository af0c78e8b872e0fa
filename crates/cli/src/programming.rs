//! Values that shall count, all of them or none: what `program` and `write` do.

mod view;

use std::path::PathBuf;
use std::time::SystemTime;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::program::{Prepared, Program, Stopped};
use encoring_workshop::{BackupOrigin, UnitLabel, keep};

use crate::arguments::bus::{Encoder, Target};
use crate::arguments::range::Wanted;
use crate::arguments::{Consent, Output};
use crate::ask::{CHECK_DOES, confirmed};
use crate::bus::{Deed, Opened};
use crate::calculation::Note;
use crate::output::{Answer, Failure, bad_input};
use crate::told::TargetView;
use view::ProgramView;

/// What `program` and `write` have in common.
#[derive(Args, Debug)]
pub(crate) struct How {
    #[command(flatten)]
    pub(crate) encoder: Encoder,
    #[command(flatten)]
    consent: Consent,
    /// Show what would be written, and end
    #[arg(long, global = true)]
    dry_run: bool,
    /// Where the old values are kept; a real encoder's are kept in this folder if nothing is said
    #[arg(long, value_name = "FILE.toml", global = true)]
    backup: Option<PathBuf>,
    /// Keep no old values
    #[arg(long, conflicts_with = "backup", global = true)]
    no_backup: bool,
    /// Run the data check also if everything is programmed already
    #[arg(long, conflicts_with = "dry_run", global = true)]
    check: bool,
    #[command(flatten)]
    output: Output,
}

impl How {
    /// Programs what `wanted` finds for the encoder.
    pub(crate) fn run(
        &self,
        command: &str,
        wanted: impl FnOnce(Target) -> Result<Wanted, Failure>,
    ) -> Result<Answer, Failure> {
        let (mut opened, target) = if self.dry_run {
            self.encoder.open()?
        } else {
            self.encoder.ring.writing(command)?;
            self.encoder.open_to_change()?
        };
        let Wanted { values, warnings } = wanted(target)?;
        let mut program = Program::new(target.model, target.native);
        for (parameter, value) in values {
            program.set(parameter, value).map_err(bad_input)?;
        }
        opened.announce(target, if self.dry_run { Deed::Reads } else { Deed::Changes });
        let told = Programming { how: self, target, warnings: &warnings }.run(&mut opened, program);
        opened.report(self.output, told.map(|view| view.warned(&warnings)), ProgramView::answer)
    }
}

/// An encoder that is being programmed.
struct Programming<'a> {
    how: &'a How,
    target: Target,
    warnings: &'a [Note],
}

impl Programming<'_> {
    fn run(&self, opened: &mut Opened, program: Program) -> Result<ProgramView, Failure> {
        let Self { how, target, .. } = *self;
        let mut prepared = opened.serve(target, |master| Ok(program.prepare(master)))?;
        if how.dry_run {
            let backup = self.asked_backup(opened, &prepared)?;
            return Ok(ProgramView::planned(target, &prepared, backup));
        }
        if needs_check(&prepared) {
            let question = format!("{} It comes first: an error is pending.", self.check_question());
            confirmed(how.consent, &question)?;
            prepared = opened.serve(target, |master| Ok(prepared.check(master)))?;
        }
        let mut backup = self.asked_backup(opened, &prepared)?;
        let check = how.check && prepared.is_programmed();
        if check {
            confirmed(how.consent, &self.check_question())?;
        } else if prepared.stopped().is_none() && prepared.changes() {
            confirmed(how.consent, &self.question(&prepared))?;
            if backup.is_none() && !how.no_backup && !opened.is_simulated() {
                backup = Some(self.keep(opened, &prepared, None)?);
            }
        }
        opened.serve(target, |master| {
            let report = if check { prepared.run_checked(master) } else { prepared.run(master) };
            Ok(ProgramView::done(target, &report, master.last_error(), backup))
        })
    }

    /// The backup that was asked for, whether something is written or not.
    fn asked_backup(
        &self,
        opened: &Opened,
        prepared: &Prepared<MasterError>,
    ) -> Result<Option<String>, Failure> {
        let known = prepared.rows().any(|row| row.before.is_some());
        match &self.how.backup {
            Some(path) if known => self.keep(opened, prepared, Some(path)).map(Some),
            _ => Ok(None),
        }
    }

    /// Writes the old values into a file before they are changed.
    #[expect(clippy::disallowed_methods, reason = "a backup says when it was made, and is named so")]
    fn keep(
        &self,
        opened: &Opened,
        prepared: &Prepared<MasterError>,
        path: Option<&PathBuf>,
    ) -> Result<String, Failure> {
        let Target { position, model, native, .. } = self.target;
        let taken =
            BackupOrigin { at: SystemTime::now(), bus: &opened.address, position, shown: prepared.shown() };
        let path = path.cloned().unwrap_or_else(|| taken.file_name(model));
        let rows = prepared.rows().map(|row| (row.parameter, row.before));
        let label = UnitLabel { native, ..UnitLabel::default() };
        keep(&taken.backup(model, label, rows).into(), &path).map_err(|error| {
            bad_input(format!("the old values cannot be kept, so nothing was written: {error}"))
        })?;
        Ok(path.display().to_string())
    }

    /// Consent to a data check and no more.
    fn check_question(&self) -> String {
        format!("{}: {CHECK_DOES}", TargetView::new(self.target))
    }

    /// Consent to what will be written, and to the data check behind it.
    fn question(&self, prepared: &Prepared<MasterError>) -> String {
        let mut text = format!("{}:", TargetView::new(self.target));
        for row in prepared.rows().filter(|row| row.changes()) {
            if let (Some(before), Some(wanted)) = (row.before, row.wanted) {
                text += &format!("\n  {} {before} -> {wanted}", row.parameter.key());
            }
        }
        for warning in self.warnings {
            text += &format!("\n{}: {}", warning.topic, warning.text);
        }
        text += &format!("\nThen a data check follows: {CHECK_DOES}");
        if prepared.moves_the_position() {
            text += "\nAfterwards the same place has another position; a preset adjustment may be needed.";
        }
        text
    }
}

/// Whether a pending error hides what must be known before something is written.
fn needs_check(prepared: &Prepared<MasterError>) -> bool {
    let hidden = match prepared.stopped() {
        None => prepared.changes(),
        Some(stopped) => matches!(stopped, Stopped::Unreadable { .. }),
    };
    prepared.error_pending() && hidden
}
