//! `encoring restore`: an encoder as it was when it was backed up.

mod view;

use std::path::PathBuf;

use clap::Args;
use encoring_station::Speed;
use encoring_words::Model;
use encoring_workshop::carry::{Carried, carry};
use encoring_workshop::{KeptEncoder, ParameterFile};

use crate::arguments;
use crate::arguments::TypeLabel;
use crate::arguments::bus::{Source, Target, patience};
use crate::arguments::range::Wanted;
use crate::bus::{Opened, simulated_ring};
use crate::calculation::Note;
use crate::dialog::{Dialog, Undone};
use crate::output::{Answer, Failure, bad_input};
use crate::presetting::{Presetting, zero_place};
use crate::programming::How;
use view::{ComparedView, RestoreView, RingView};

/// Program an encoder from a backup, and make its zero at a mark
///
/// It shows the differences, asks, writes, checks, reads back and compares. A backup has no zero, since no service reads
/// it. So the command asks for a mark and makes the zero there. The answers come from the terminal or from a pipe. With
/// --yes it asks nothing and prints the presets that make the zero.
///
/// With --dry-run it only compares the encoder with the file, or without --at each encoder of the file.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  done and verified; with --dry-run no difference
  1  refused, not confirmed, another model, or another master is at work; with
     --dry-run a difference
  2  wrong input or wrong usage
  3  no answer, or the file lacks a value that could not be read when it was made

Examples:
  encoring restore axis-3.toml --bus modbus-tcp://192.168.1.10 --dry-run
  encoring restore axis-3.toml --bus modbus-tcp://192.168.1.10 --at 2
  encoring restore ring.toml --bus modbus-tcp://192.168.1.10 --dry-run
  encoring restore axis-3.toml --bus sim --state memories --at 1 --as ce-100-m --yes")]
pub(crate) struct Arguments {
    /// A backup, or another file of parameters; a parameter that is not in it stays as it is
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Restore to an encoder of this model: carry over what it can hold, and list the rest
    #[arg(long = "as", value_name = "MODEL", value_parser = arguments::model())]
    as_model: Option<Model>,
    #[command(flatten)]
    how: How,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let name = arguments.file.display().to_string();
    let file = ParameterFile::read(&arguments.file).map_err(bad_input)?;
    let how = &arguments.how;
    let whole = how.dry_run && how.encoder.at.is_none() && arguments.as_model.is_none();
    if whole && file.encoders.len() > 1 {
        return compare_ring(arguments, &name, &file);
    }
    let kept = file.at(how.encoder.at).map_err(|problem| bad_input(format!("{name}: {problem}")))?;
    if arguments.as_model.is_none() {
        file.may_be_written(&arguments.file, kept).map_err(bad_input)?;
    }
    let restoring = Restoring::new(arguments, &name, kept)?;
    let (mut opened, target) = restoring.how.open("restore")?;
    let told = restoring.restored(&mut opened, target);
    opened.report(how.output, told, |view| view.answer(how.dry_run))
}

/// Compares every encoder of a ring with the file.
fn compare_ring(arguments: &Arguments, name: &str, file: &ParameterFile) -> Result<Answer, Failure> {
    let how = &arguments.how;
    let restoring: Result<Vec<_>, _> =
        file.encoders.iter().map(|kept| Restoring::new(arguments, name, kept)).collect();
    let restoring = restoring?;
    let mut opened = how.encoder.ring.open(Speed::Max)?;
    let patience = patience(how.encoder.patience, opened.timeout())?;
    let mut encoders = Vec::new();
    for restoring in &restoring {
        let position = restoring.how.encoder.at.unwrap_or_default();
        let target = restoring.how.encoder.label.target(&opened, position, patience);
        let compared = target.and_then(|target| restoring.restored(&mut opened, target));
        encoders.push(match compared {
            Ok(view) => ComparedView::Compared(view.into()),
            // The others can be compared all the same.
            Err(Failure::BadInput(why) | Failure::Refused(why) | Failure::NoAnswer(why))
                if !opened.is_interrupted() =>
            {
                ComparedView::Failed { position, failed: why }
            }
            Err(failure) => return opened.report(how.output, Err(failure), RingView::answer),
        });
    }
    opened.report(how.output, Ok(RingView::new(name, encoders)), RingView::answer)
}

/// An encoder that is to be as the file says.
struct Restoring<'a> {
    arguments: &'a Arguments,
    name: &'a str,
    kept: &'a KeptEncoder,
    /// The options, with what the file says of the encoder.
    how: How,
    dialog: Dialog,
}

impl<'a> Restoring<'a> {
    fn new(arguments: &'a Arguments, name: &'a str, kept: &'a KeptEncoder) -> Result<Self, Failure> {
        if let Some((parameter, _)) = kept.parts.first() {
            let told = format!(
                "{name}: {} names some of its parts alone, and a restore takes whole values; `encoring program --file \
                 {name}` takes parts",
                parameter.key()
            );
            return Err(bad_input(told));
        }
        if kept.values.is_empty() {
            return Err(bad_input(format!("{name}: no value in [parameters], so nothing to restore")));
        }
        let how = arguments.of(kept)?;
        let dialog = Dialog::guiding(how.consent);
        Ok(Self { arguments, name, kept, how, dialog })
    }

    /// Programs the values, or compares them, and makes the zero if somebody answers where.
    fn restored(&self, opened: &mut Opened, target: Target) -> Result<RestoreView, Failure> {
        let Self { arguments, name, kept, how, dialog } = self;
        let carried = arguments.carried(name, kept, target)?;
        let said_by = if arguments.as_model.is_some() { "--as" } else { name };
        let values = carried.values.into_iter().map(|(parameter, value)| (parameter, value.into())).collect();
        let wanted = Wanted { values, warnings: warnings(said_by, target, &carried.lost), zero: None };
        let how = if dialog.is_silent() { how } else { &how.before_zero(target.model) };
        let program = how.work("restore", opened, target, &wanted, dialog)?;
        let guided = !how.dry_run && program.is_in_order() && !dialog.is_silent();
        if guided {
            dialog.tell(&program.to_string());
        }
        let address = opened.address.clone();
        let mut view = RestoreView::new(program, name, &address, kept, target, carried.lost);
        if guided {
            self.set_zero(opened, target, &mut view)?;
        }
        Ok(view)
    }

    fn set_zero(&self, opened: &mut Opened, target: Target, view: &mut RestoreView) -> Result<(), Failure> {
        let mark = match zero_place(&self.dialog, self.kept, target) {
            Ok(Some(mark)) => mark,
            Ok(None) => {
                view.zero_left("no place was named");
                return Ok(());
            }
            Err(undone) => return left(view, undone),
        };
        let presetting = Presetting { value: mark.shown.into(), mark: Some(&mark), dialog: &self.dialog };
        match presetting.adjust(opened, target) {
            Ok(preset) => {
                view.zero_made(&mark, preset);
                Ok(())
            }
            Err(undone) => left(view, undone),
        }
    }
}

/// What is restored by now stays, and is told.
fn left(view: &mut RestoreView, undone: Undone) -> Result<(), Failure> {
    view.zero_left(match undone {
        Undone::Declined => "the answer was no",
        Undone::InputEnded => "the input has ended",
        Undone::Failed(failure) => return view.zero_failed(failure),
    });
    Ok(())
}

impl Arguments {
    /// The options, with what the file says of the encoder.
    fn of(&self, kept: &KeptEncoder) -> Result<How, Failure> {
        let mut how = self.how.clone();
        let position = how.encoder.at.or(kept.position());
        how.encoder.at = position;
        if let Some(model) = how.encoder.label.model.filter(|model| *model != kept.model) {
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
fn warnings(said_by: &str, target: Target, lost: &[String]) -> Vec<Note> {
    let mut warnings = Vec::new();
    if target.source == Source::User {
        warnings.push(Note::warning(
            "model",
            format!(
                "no word tells it: {said_by} says {}. Look at the type label of this encoder",
                target.model
            ),
        ));
    }
    for lost in lost {
        warnings.push(Note::warning("not carried over", lost.clone()));
    }
    warnings
}
