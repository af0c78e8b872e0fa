//! Values that shall count, all of them or none: what `program`, `write` and `restore` do.

mod view;

use std::path::PathBuf;
use std::time::SystemTime;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::Request;
use encoring_host::program::{Prepared, Program, Stopped};
use encoring_words::explain::Meaning;
use encoring_words::model::Effect;
use encoring_words::{Model, Parameter};
use encoring_workshop::{BackupOrigin, UnitLabel, keep};

use crate::arguments::bus::{Encoder, Target};
use crate::arguments::range::Wanted;
use crate::arguments::{Consent, Output};
use crate::bus::{Deed, Opened};
use crate::dialog::{CHECK_DOES, Dialog, Undone};
use crate::noted::{Earlier, JournalFolder, Noted};
use crate::output::{Answer, Failure, bad_input, note};
use crate::told::TargetView;
pub(crate) use view::ProgramView;

/// What `program`, `write` and `restore` have in common.
#[derive(Args, Debug, Clone)]
pub(crate) struct How {
    #[command(flatten)]
    pub(crate) encoder: Encoder,
    #[command(flatten)]
    pub(crate) consent: Consent,
    /// Show what would be written, and end
    #[arg(long, global = true)]
    pub(crate) dry_run: bool,
    /// File for the old values [default: backup-MODEL-at-POSITION-TIME.toml for a real encoder, none for a simulated one]
    #[arg(long, value_name = "FILE.toml", global = true)]
    backup: Option<PathBuf>,
    /// Keep no old values
    #[arg(long, conflicts_with = "backup", global = true)]
    no_backup: bool,
    /// Run the data check even if there is nothing to write
    #[arg(long, conflicts_with = "dry_run", global = true)]
    check: bool,
    #[command(flatten)]
    journal: JournalFolder,
    #[command(flatten)]
    pub(crate) output: Output,
}

impl How {
    /// Programs what `wanted` finds for the encoder.
    pub(crate) fn run(
        &self,
        command: &str,
        wanted: impl FnOnce(Target) -> Result<Wanted, Failure>,
    ) -> Result<Answer, Failure> {
        let (mut opened, target) = self.open(command)?;
        let wanted = wanted(target)?;
        let dialog = Dialog::at_terminal(self.consent);
        let told = self.work(command, &mut opened, target, &wanted, &dialog);
        let told = told.map(|view| view.warned(&wanted.warnings)).map_err(Failure::from);
        opened.report(self.output, told, ProgramView::answer)
    }

    /// The same for values that a zero is made with afterwards: they must count, else the zero is lost when they begin to,
    /// at the next power-up.
    pub(crate) fn before_zero(&self, model: Model) -> Self {
        Self { check: self.check || model.effect() == Effect::AtDataCheck, ..self.clone() }
    }

    /// Opens the ring, and says which encoder is meant.
    pub(crate) fn open(&self, command: &str) -> Result<(Opened, Target), Failure> {
        if self.dry_run {
            return self.encoder.open();
        }
        self.encoder.ring.writing(command)?;
        self.encoder.open_to_change()
    }

    /// Programs an encoder, or shows what would be programmed.
    pub(crate) fn work(
        &self,
        command: &str,
        opened: &mut Opened,
        target: Target,
        wanted: &Wanted,
        dialog: &Dialog,
    ) -> Result<ProgramView, Undone> {
        let mut program = Program::new(target.model, target.native);
        for (parameter, change) in &wanted.values {
            program.set(*parameter, *change).map_err(bad_input)?;
        }
        opened.announce(target, if self.dry_run { Deed::Reads } else { Deed::Changes });
        let noted = self.journal.of(opened, target.position);
        Programming { how: self, command, target, wanted, noted, dialog }.run(opened, program)
    }
}

/// An encoder that is being programmed.
struct Programming<'a> {
    how: &'a How,
    command: &'a str,
    target: Target,
    wanted: &'a Wanted,
    /// None for a ring that forgets.
    noted: Option<Noted>,
    dialog: &'a Dialog,
}

impl Programming<'_> {
    fn run(&self, opened: &mut Opened, program: Program) -> Result<ProgramView, Undone> {
        let Self { how, target, .. } = *self;
        let (mut prepared, behind) =
            opened.serve(target, |master| Ok((program.prepare(master), master.behind())))?;
        self.zero_fits(&prepared)?;
        if how.dry_run {
            let backup = self.asked_backup(opened, &prepared)?;
            let earlier = self.earlier(&prepared);
            return Ok(
                ProgramView::planned(target, &prepared, behind.as_ref(), backup).after(earlier.as_ref())
            );
        }
        if needs_check(&prepared) {
            let question = format!("{} It comes first: an error is pending.", self.check_question());
            self.dialog.confirmed(&question)?;
            prepared = opened.serve(target, |master| Ok(prepared.check(master)))?;
        }
        let earlier = self.earlier(&prepared);
        if let Some(earlier) = &earlier {
            note(&format!("note: {}", earlier.view()));
        }
        let backup = self.asked_backup(opened, &prepared)?;
        // What was begun here may be written and not be checked.
        let unchecked = earlier.as_ref().is_some_and(|earlier| earlier.found.is_believed());
        let check = (how.check || unchecked) && prepared.is_programmed();
        if check {
            self.dialog.confirmed(&self.check_question())?;
        } else if prepared.stopped().is_none() && prepared.changes() {
            self.dialog.confirmed(&self.question(&prepared))?;
            return Ok(self.write(opened, prepared, backup, earlier.as_ref())?);
        }
        let report = opened.serve(target, |master| {
            let report = if check { prepared.run_checked(master) } else { prepared.run(master) };
            let behind = master.behind().or(behind);
            Ok((ProgramView::done(target, &report, behind.as_ref(), backup), report))
        });
        let (view, report) = report?;
        if check {
            self.noted.iter().for_each(|noted| noted.settle(Some(&report), earlier.as_ref()));
        }
        Ok(view.after(earlier.as_ref()).at(&opened.place()))
    }

    /// Refuses a zero that the values to come do not allow, before anything is written.
    fn zero_fits(&self, prepared: &Prepared<MasterError>) -> Result<(), Failure> {
        let length = prepared.rows().find(|row| row.parameter == Parameter::MeasuringLength);
        let length = length.and_then(|row| row.wanted.or(row.before));
        match (self.wanted.zero, length) {
            (Some(zero), Some(length)) => Request::preset(self.target.model, zero, length)
                .map(|_| ())
                .map_err(|refused| bad_input(format!("{refused}; nothing was written"))),
            _ => Ok(()),
        }
    }

    /// Writes, with the old values and what is to be written on the disk before.
    fn write(
        &self,
        opened: &mut Opened,
        prepared: Prepared<MasterError>,
        mut backup: Option<String>,
        earlier: Option<&Earlier>,
    ) -> Result<ProgramView, Failure> {
        let target = self.target;
        if backup.is_none() && !self.how.no_backup && !opened.is_simulated() {
            backup = Some(self.keep(opened, &prepared, None)?);
        }
        if let Some(noted) = &self.noted {
            noted.begin(&prepared, self.command, backup.as_deref(), earlier)?;
        }
        let done = opened.serve(target, |master| {
            let report = prepared.run(master);
            Ok((ProgramView::done(target, &report, master.behind().as_ref(), backup), report))
        });
        // What failed to begin has written nothing.
        let report = done.as_ref().ok().map(|(_, report)| report);
        self.noted.iter().for_each(|noted| noted.settle(report, earlier));
        done.map(|(view, _)| view.after(earlier).at(&opened.place()))
    }

    /// What was begun on this encoder before and is not known to have ended.
    fn earlier(&self, prepared: &Prepared<MasterError>) -> Option<Earlier> {
        let before = |parameter| prepared.rows().find(|row| row.parameter == parameter)?.before;
        self.noted.as_ref()?.earlier(before)
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
                if let Some(meaning) = Meaning::of(row.parameter, self.target.model, wanted) {
                    text += &format!(" ({meaning})");
                }
            }
        }
        for warning in &self.wanted.warnings {
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
