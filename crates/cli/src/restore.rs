//! `encoring restore`: an encoder as it was when it was backed up.

mod view;

use std::path::PathBuf;

use clap::Args;
use encoring_words::Model;
use encoring_workshop::carry::{Carried, carry};
use encoring_workshop::{KeptEncoder, ParameterFile};

use crate::arguments;
use crate::arguments::TypeLabel;
use crate::arguments::bus::{Source, Target};
use crate::arguments::range::Wanted;
use crate::bus::simulated_ring;
use crate::calculation::Note;
use crate::output::{Answer, Failure, bad_input};
use crate::programming::How;
use view::RestoreView;

/// Program an encoder as a backup says, and tell the way to its zero
///
/// Shows what differs, asks, writes, checks, reads back and compares. With --dry-run it only compares: is the encoder
/// still as it was backed up? The zero is not in a backup, as no service reads it: the marks tell the presets that make
/// it again.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes: 0 done and verified, with --dry-run no difference; 1 refused, not
confirmed, another model, another master is at work, or a difference with --dry-run;
2 bad input or usage; 3 no answer, or a value is not in the file because it could not
be read.

Examples:
  encoring restore axis-3.toml --bus modbus-tcp://192.168.1.10 --dry-run
  encoring restore axis-3.toml --bus modbus-tcp://192.168.1.10 --at 2
  encoring restore axis-3.toml --bus sim --state memories --at 1 --as ce-100-m --yes")]
pub(crate) struct Arguments {
    /// A backup, or any file of parameters; what it does not hold stays
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// The encoder is of another model than the file: carry over what makes sense, and list the rest
    #[arg(long = "as", value_name = "MODEL", value_parser = arguments::model())]
    as_model: Option<Model>,
    #[command(flatten)]
    how: How,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let name = arguments.file.display().to_string();
    let file = ParameterFile::read(&arguments.file).map_err(bad_input)?;
    let kept =
        file.at(arguments.how.encoder.at).map_err(|problem| bad_input(format!("{name}: {problem}")))?;
    if let Some((parameter, _)) = kept.parts.first() {
        let told = format!(
            "{name}: {} names some of its parts alone, and a restore takes whole values; `encoring program --file {name}` \
             takes parts",
            parameter.key()
        );
        return Err(bad_input(told));
    }
    if kept.values.is_empty() {
        return Err(bad_input(format!("{name}: no value in [parameters], so nothing to restore")));
    }
    let how = arguments.of(kept)?;
    let (mut opened, target) = how.open("restore")?;
    let carried = arguments.carried(&name, kept, target)?;
    let values = carried.values.into_iter().map(|(parameter, value)| (parameter, value.into())).collect();
    let wanted = Wanted { values, warnings: warnings(&name, target, &carried.lost) };
    let told = how.work("restore", &mut opened, target, &wanted);
    let told = told.map(|program| {
        let address = opened.address.clone();
        RestoreView::new(program, &name, &address, kept, target, carried.lost)
    });
    opened.report(how.output, told, |view| view.answer(how.dry_run))
}

impl Arguments {
    /// The options, with what the file says of the encoder.
    fn of(&self, kept: &KeptEncoder) -> Result<How, Failure> {
        let mut how = self.how.clone();
        let position = how.encoder.at.or(kept.position());
        how.encoder.at = position;
        if let Some(model) = how.encoder.label.model {
            return Err(bad_input(format!(
                "--model {model}: the model is that of the file, {}; --as {model} carries its values over",
                kept.model
            )));
        }
        // A simulated ring knows its models.
        let simulated = simulated_ring(how.encoder.ring.place.get()?)?.is_some();
        let model = self.as_model.unwrap_or(kept.model);
        let native = how.encoder.label.native.or(kept.label.native.filter(|_| model == kept.model));
        how.encoder.label =
            TypeLabel { model: (!simulated).then_some(model), native: native.filter(|_| !simulated) };
        Ok(how)
    }

    /// What the encoder is to get.
    fn carried(&self, name: &str, kept: &KeptEncoder, target: Target) -> Result<Carried, Failure> {
        let (model, position) = (target.model, target.position);
        let seen = target.source == Source::Ring;
        if let Some(other) = self.as_model.filter(|other| seen && *other != model) {
            return Err(Failure::Refused(format!(
                "--as {other}: the encoder at position {position} is a {model}; nothing was written"
            )));
        }
        let carried = carry(kept, model).map_err(|problem| {
            Failure::Refused(format!(
                "{name}, encoder at position {position}: {problem}; nothing was written"
            ))
        })?;
        if model != kept.model && self.as_model.is_none() {
            let lost: String = carried.lost.iter().map(|lost| format!("\n  {lost}")).collect();
            return Err(Failure::Refused(format!(
                "{name} is of a {}, the encoder at position {position} is a {model}; nothing was written. --as {model} \
                 carries its values over{}{lost}",
                kept.model,
                if lost.is_empty() { "" } else { ", but not:" }
            )));
        }
        match (kept.label.native, target.native) {
            (Some(there), Some(own)) if there != own && model == kept.model => {
                Err(Failure::Refused(format!(
                    "{name} is of an encoder with {there} steps per turn, this one has {own}; nothing was written"
                )))
            }
            _ => Ok(carried),
        }
    }
}

/// What whoever restores must know before.
fn warnings(name: &str, target: Target, lost: &[String]) -> Vec<Note> {
    let mut warnings = Vec::new();
    if target.source == Source::User {
        warnings.push(Note::warning(
            "model",
            format!("no word tells it: {name} says {}. Look at the type label of this encoder", target.model),
        ));
    }
    for lost in lost {
        warnings.push(Note::warning("not carried over", lost.clone()));
    }
    warnings
}
