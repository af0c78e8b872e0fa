//! Values that shall count, all of them or none: what `program` and `write` do.

mod view;

use std::path::PathBuf;
use std::time::SystemTime;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::program::{Prepared, Program};
use encoring_words::{InWord, Parameter};
use encoring_workshop::ParameterFile;

use crate::arguments::bus::{Encoder, Target};
use crate::arguments::{Consent, Output};
use crate::ask::confirmed;
use crate::bus::Opened;
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
    #[command(flatten)]
    output: Output,
}

impl How {
    /// Programs what `values` finds for the encoder.
    pub(crate) fn run(
        &self,
        values: impl FnOnce(Target) -> Result<Vec<(Parameter, u32)>, Failure>,
    ) -> Result<Answer, Failure> {
        let (mut opened, target) = self.encoder.open()?;
        let mut program = Program::new(target.model, target.native);
        for (parameter, value) in values(target)? {
            program.set(parameter, value).map_err(bad_input)?;
        }
        let told = self.program(&mut opened, target, program);
        opened.close()?;
        let view = told?;
        self.output.print(&view)?;
        Ok(view.answer())
    }

    fn program(&self, opened: &mut Opened, target: Target, program: Program) -> Result<ProgramView, Failure> {
        let (simulated, address) = (opened.is_simulated(), opened.address.clone());
        let patience = self.encoder.patience;
        let prepared = opened.serve(target, patience, |master| Ok(program.prepare(master)))?;
        if self.dry_run {
            return Ok(ProgramView::planned(target, &prepared));
        }
        let mut backup = None;
        if prepared.stopped().is_none() && prepared.changes() {
            confirmed(self.consent, &question(target, &prepared))?;
            backup = self.keep(simulated, &address, target, &prepared)?;
        }
        opened.serve(target, patience, |master| {
            let report = prepared.run(master);
            Ok(ProgramView::done(target, &report, master.last_error(), backup))
        })
    }

    /// Writes the old values into a file before they are changed.
    #[expect(clippy::disallowed_methods, reason = "a backup says when it was made, and is named so")]
    fn keep(
        &self,
        simulated: bool,
        address: &str,
        target: Target,
        prepared: &Prepared<MasterError>,
    ) -> Result<Option<String>, Failure> {
        let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        let path = match &self.backup {
            Some(path) => path.clone(),
            None if self.no_backup || simulated => return Ok(None),
            None => {
                let name = format!("backup-{}-at-{}-{now}.toml", target.model, target.position);
                PathBuf::from(name.replace(':', ""))
            }
        };
        let file = ParameterFile {
            model: target.model,
            native: target.native,
            remarks: vec![
                format!("as it was before it was programmed, {now}"),
                format!("{address}, position {}", target.position),
                format!("IN showed {}", prepared.shown().unwrap_or(InWord(0))),
                "the offset of a preset adjustment is not here: no service reads it".to_owned(),
            ],
            values: prepared
                .rows()
                .filter_map(|row| row.before.map(|value| (row.parameter, value)))
                .collect(),
        };
        file.write_new(&path).map_err(|error| {
            bad_input(format!("the old values cannot be kept, so nothing was written: {error}"))
        })?;
        Ok(Some(path.display().to_string()))
    }
}

fn question(target: Target, prepared: &Prepared<MasterError>) -> String {
    let mut text = format!("{}:", TargetView::new(target));
    for row in prepared.rows().filter(|row| row.changes()) {
        if let (Some(before), Some(wanted)) = (row.before, row.wanted) {
            text += &format!("\n  {} {before} -> {wanted}", row.parameter.key());
        }
    }
    if prepared.moves_the_position() {
        text += "\nAfterwards the same place has another position; a preset adjustment may be needed.";
    }
    text
}
