//! `encoring backup`: everything readable of encoders, into a file.

mod view;

use std::path::PathBuf;
use std::time::SystemTime;

use clap::Args;
use encoring_bus::master::MasterError;

use encoring_words::{Duration, Model, Week};
use encoring_workshop::backup::{BackupKept, BackupOrigin, keep};
use encoring_workshop::reading::Readings;
use encoring_workshop::{KeptEncoder, MachineMark, NamedMark, ParameterFile, UnitLabel};

use crate::arguments;
use crate::arguments::bus::{BusArguments, Source, Target, patience};
use crate::arguments::positions::{Positions, positions};
use crate::arguments::{Output, TypeLabel, span};
use crate::bus::{Deed, Opened};
use crate::output::{Answer, Failure, bad_input, note};
use view::{BackupView, EncoderView};

/// Save the values of an encoder, or of a whole ring, to a file
///
/// Reading changes nothing, but it uses the handshake: while it lasts IN shows the reply and no position. Stop the axis
/// first. No service reads the offset of a preset: give --mark for places of the machine, to find the zero again.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  kept
  1  a mark cannot be noted here, the file holds other values, or another master is
     at work
  2  wrong input or wrong usage
  3  no answer, or a value could not be read

Examples:
  encoring backup axis-3.toml --bus sim --at 2
  encoring backup axis-2.toml --bus modbus-tcp://192.168.1.10 --at 2 --model ce-65-m \\
    --mark 'stop left=0 mm'
  encoring backup axis-2.toml --bus modbus-tcp://192.168.1.10 --update --mark 'stop right=350 mm'
  encoring backup ring.toml --bus modbus-tcp://192.168.1.10 --at 0-2 \\
    --model la-66,ce-100-m,ce-65-m
  encoring backup today.toml --bus modbus-tcp://192.168.1.10 --like ring.toml")]
pub(crate) struct Arguments {
    /// The file to write; without --update it must not exist
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    ring: BusArguments,
    /// Ring positions, such as 2 or 0,2 or 0-2 [default: those of --like or --update, or all of a simulated ring]
    #[arg(long, value_name = "POSITIONS", value_parser = positions)]
    at: Option<Positions>,
    /// Models on the type labels: one for all, or one for each position; a simulated ring names them
    #[arg(long, value_name = "MODEL[,MODEL..]", value_parser = arguments::model(), value_delimiter = ',')]
    model: Vec<Model>,
    /// Steps per turn on the rating plates, 4096 or 8192: one for all, or one for each position
    #[arg(long, value_name = "STEPS[,STEPS..]", value_parser = arguments::native(), value_delimiter = ',')]
    native: Vec<u32>,
    /// Take positions, models and labels from this older backup
    #[arg(long, value_name = "OLD.toml", conflicts_with = "update")]
    like: Option<PathBuf>,
    /// Add marks and labels to an existing file, if the encoder still holds its values
    #[arg(long)]
    update: bool,
    /// Mark at which the machine stands now, with the number on its scale if it has one (repeatable)
    #[arg(long, value_name = "NAME[=NUMBER mm|deg]", allow_hyphen_values = true)]
    mark: Vec<NamedMark>,
    /// Serial number on the type label
    #[arg(long, value_name = "TEXT")]
    serial: Option<String>,
    /// Week and year of the firmware on the type label, such as 41/1997
    #[arg(long, value_name = "WW/YYYY", value_parser = firmware)]
    firmware: Option<String>,
    /// Your own words, such as the place of the encoder in the machine
    #[arg(long, value_name = "TEXT")]
    label: Option<String>,
    /// Longest wait for each step of a handshake, at least 3 time-outs of the address [default: 2s, or 4 time-outs if that is
    /// longer]
    #[arg(long, value_name = "TIME", value_parser = span)]
    patience: Option<Duration>,
    #[command(flatten)]
    output: Output,
}

#[expect(clippy::disallowed_methods, reason = "a week")]
fn firmware(text: &str) -> Result<String, String> {
    text.parse::<Week>().map(|_| text.to_owned()).map_err(|wrong| wrong.to_string())
}

/// An encoder that is to be kept.
struct Asked {
    target: Target,
    label: UnitLabel,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    arguments.one_place()?;
    let older = arguments.older()?;
    let mut opened = arguments.ring.open(encoring_station::Speed::Max)?;
    let asked = arguments.asked(&opened, older.as_ref())?;
    for asked in &asked {
        opened.announce(asked.target, Deed::Reads);
    }
    if !opened.is_simulated() {
        note(
            "note: while a value is read IN shows the reply and no position: the PLC must not use it meanwhile",
        );
    }
    let told = arguments.keep(&mut opened, &asked, older);
    opened.report(arguments.output, told, BackupView::answer)
}

impl Arguments {
    /// The file that is there already, or that which tells what to keep.
    fn older(&self) -> Result<Option<ParameterFile>, Failure> {
        let older = match (&self.like, self.update) {
            (Some(like), _) => ParameterFile::read(like),
            (None, true) => ParameterFile::read_with_comments(&self.file),
            (None, false) => return Ok(None),
        };
        older.map(Some).map_err(bad_input)
    }

    /// The encoders that are meant.
    fn asked(&self, opened: &Opened, older: Option<&ParameterFile>) -> Result<Vec<Asked>, Failure> {
        let known = |kept: &KeptEncoder| kept.taken.as_ref().map(|taken| taken.position);
        let at = match (&self.at, older, &opened.world) {
            (Some(at), ..) => at.clone(),
            (None, Some(older), _) => Positions(older.encoders.iter().filter_map(known).collect()),
            (None, None, Some(world)) => Positions((0..world.with(|world| world.places().len())).collect()),
            (None, None, None) => Positions(Vec::new()),
        };
        if at.0.is_empty() {
            return Err(bad_input(
                "--at POSITIONS is missing, like 0-2; `encoring probe` finds the encoders of a gateway",
            ));
        }
        if at.0.len() > 1 {
            self.only_for_one(&at.0)?;
        }
        let (models, natives) = (at.each("--model", &self.model)?, at.each("--native", &self.native)?);
        let patience = patience(self.patience, opened.timeout())?;
        let asked = at.0.iter().zip(models.into_iter().zip(natives)).map(|(position, (model, native))| {
            let is_it = |kept: &&KeptEncoder| kept.position().is_none_or(|there| there == *position);
            let kept = older.and_then(|older| older.encoders.iter().find(is_it));
            if self.update && kept.is_none() {
                let file = self.file.display();
                return Err(bad_input(format!("{file}: position {position} is not in the file")));
            }
            self.one(opened, *position, TypeLabel { model, native }, kept, patience)
        });
        asked.collect()
    }

    /// What is written on one unit is not to be kept as another's.
    fn only_for_one(&self, at: &[usize]) -> Result<(), Failure> {
        let given = [
            ("--mark", !self.mark.is_empty()),
            ("--serial", self.serial.is_some()),
            ("--firmware", self.firmware.is_some()),
            ("--label", self.label.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(bad_input(format!(
                "{option} is of one encoder, and {} are meant; --at POSITION tells which",
                at.len()
            ))),
            None => Ok(()),
        }
    }

    fn one(
        &self,
        opened: &Opened,
        position: usize,
        given: TypeLabel,
        kept: Option<&KeptEncoder>,
        patience: Duration,
    ) -> Result<Asked, Failure> {
        let older = kept.map(|kept| kept.label.clone()).unwrap_or_default();
        // What a simulated ring says is compared with the file below.
        let by_file = kept.filter(|_| !(self.update && opened.is_simulated()));
        let label = TypeLabel {
            model: given.model.or(by_file.map(|kept| kept.model)),
            native: given.native.or(older.native),
        };
        let target = label.target(opened, position, patience)?;
        if let Some(kept) = kept.filter(|kept| self.update && kept.model != target.model) {
            return Err(self.another_model(kept, target));
        }
        let label = UnitLabel {
            native: target.native,
            serial: self.serial.clone().or(older.serial),
            firmware: self.firmware.clone().or(older.firmware),
            label: self.label.clone().or(older.label),
        };
        Ok(Asked { target, label })
    }

    /// Why nothing is read: the file is of another model, as the ring or an option says.
    fn another_model(&self, kept: &KeptEncoder, target: Target) -> Failure {
        let (file, model, position) = (self.file.display(), target.model, target.position);
        match target.source {
            Source::Ring => Failure::Refused(format!(
                "{file} is of a {}, the encoder at position {position} is a {model}; nothing was read",
                kept.model
            )),
            Source::User => bad_input(format!(
                "--model {model}: {file} is of a {}; leave --model out, or give another file",
                kept.model
            )),
        }
    }

    /// Reads the encoders, one after the other, and writes the file.
    fn keep(
        &self,
        opened: &mut Opened,
        asked: &[Asked],
        older: Option<ParameterFile>,
    ) -> Result<BackupView, Failure> {
        let mut file = older.filter(|_| self.update).unwrap_or(ParameterFile { encoders: Vec::new() });
        let mut views = Vec::new();
        for one in asked {
            let target = one.target;
            match opened.serve(target, |master| Readings::of(master, target.model)) {
                Ok(readings) => {
                    let there = self.there(&file, target.position);
                    let kept = self.kept(opened, one, &readings, there.and_then(|k| file.encoders.get(k)))?;
                    views.push(EncoderView::kept(target, &readings, &kept));
                    match there.and_then(|k| file.encoders.get_mut(k)) {
                        Some(there) => *there = kept,
                        None => file.encoders.push(kept),
                    }
                }
                // The others can be kept all the same.
                Err(Failure::NoAnswer(why) | Failure::Refused(why))
                    if asked.len() > 1 && !opened.is_interrupted() =>
                {
                    views.push(EncoderView::failed(target, why));
                }
                Err(failure) => return Err(failure),
            }
        }
        let name = self.file.display().to_string();
        if views.iter().all(EncoderView::is_failed) {
            return Ok(BackupView::new(name, "nothing", views));
        }
        let result = if self.update {
            file.replace(&self.file).map_err(bad_input)?;
            "updated"
        } else {
            let other = "; --update adds marks and labels to it, another name keeps both";
            let advice = if self.file.exists() { other } else { "" };
            match keep(&file, &self.file).map_err(|error| bad_input(format!("{error}{advice}")))? {
                BackupKept::Written => "written",
                BackupKept::AlreadyThere => {
                    let there = ParameterFile::read(&self.file).map_err(bad_input)?;
                    for (view, kept) in views.iter_mut().zip(&there.encoders) {
                        view.holds(kept);
                    }
                    "already_there"
                }
            }
        };
        Ok(BackupView::new(name, result, views))
    }

    /// Where in a file that is updated the encoder is.
    fn there(&self, file: &ParameterFile, position: usize) -> Option<usize> {
        let is_it = |kept: &KeptEncoder| kept.position().is_none_or(|there| there == position);
        file.encoders.iter().position(is_it).filter(|_| self.update)
    }

    /// The machine stands at one place, which has one number on each scale.
    fn one_place(&self) -> Result<(), Failure> {
        let references: Vec<_> = self.mark.iter().filter_map(|mark| mark.reference).collect();
        let two = references.iter().enumerate().find_map(|(k, one)| {
            let other = references.get(k + 1..)?.iter();
            let mut others =
                other.filter(|other| other.scale == one.scale && other.millionths != one.millionths);
            Some((*one, *others.next()?))
        });
        match two {
            Some((one, other)) => Err(bad_input(format!(
                "--mark: the machine cannot stand at {one} and at {other}; note one of them now, and the other one there"
            ))),
            None => Ok(()),
        }
    }

    /// What is to be kept of an encoder that was read.
    #[expect(clippy::disallowed_methods, reason = "a backup says when it was made")]
    fn kept(
        &self,
        opened: &Opened,
        asked: &Asked,
        readings: &Readings<MasterError>,
        there: Option<&KeptEncoder>,
    ) -> Result<KeptEncoder, Failure> {
        let Asked { target, label } = asked;
        let origin = BackupOrigin {
            at: SystemTime::now(),
            bus: &opened.address,
            position: target.position,
            shown: Some(readings.shown[1]),
        };
        let new = origin.backup(target.model, label.clone(), readings.values());
        let mut kept = match there {
            Some(there) => there.clone().updated(new).map_err(|differences| {
                Failure::Refused(format!(
                    "{}: the encoder at position {} no longer holds what the file does, which was left as it is:\n{}",
                    self.file.display(),
                    target.position,
                    differences.join("\n")
                ))
            })?,
            None => new,
        };
        for mark in &self.mark {
            let refused = |problem: String| {
                Failure::Refused(format!(
                    "--mark {:?}: not noted, and nothing was kept: {problem}",
                    mark.name
                ))
            };
            let shown = readings.standing().map_err(refused)?;
            kept.note(MachineMark { name: mark.name.clone(), shown, reference: mark.reference })
                .map_err(refused)?;
        }
        Ok(kept)
    }
}
