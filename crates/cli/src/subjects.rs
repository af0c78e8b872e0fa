//! Which encoders are looked at, and what is known of them.

use std::num::NonZeroU32;
use std::path::Path;

use clap::Args;
use encoring_bus::watch::Subject;
use encoring_bus::{Blind, Judge, Tolerance};
use encoring_station::known::KnownFile;
use encoring_words::model::{Sensor, SensorKind};
use encoring_words::{Duration, Model};
use encoring_workshop::{KeptEncoder, ParameterFile};

use crate::arguments;
use crate::arguments::built_with;
use crate::arguments::bus::BusArguments;
use crate::arguments::positions::{Positions, positions};
use crate::arguments::span;
use crate::bus::Opened;
use crate::output::{Failure, bad_input};

/// Which encoders, on which ring.
#[derive(Args, Debug, Clone)]
pub(crate) struct SubjectArguments {
    #[command(flatten)]
    pub(crate) ring: BusArguments,
    /// Ring positions, such as 2 or 0,2 or 0-2 [default: all of a simulated ring]
    #[arg(long, value_name = "POSITIONS", value_parser = positions)]
    at: Option<Positions>,
    /// Models on the type labels: one for all, or one for each position; a simulated ring names them
    #[arg(long, value_name = "MODEL[,MODEL..]", value_parser = arguments::model(), value_delimiter = ',')]
    model: Vec<Model>,
    /// Steps per turn on the rating plates, 4096 or 8192: one for all, or one for each position
    #[arg(long, value_name = "STEPS[,STEPS..]", value_parser = arguments::native(), value_delimiter = ',')]
    native: Vec<u32>,
    /// File with the active parameters of an encoder: one for each position in the order of --at, or POSITION=FILE.toml
    /// (repeatable)
    #[arg(long, value_name = "FILE.toml")]
    parameters: Vec<String>,
    /// Age above which a word is judged stale
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = span)]
    stale_after: Duration,
    /// Highest speed of the shafts in turns a minute, to find smaller jumps [default: that of the data sheets]
    #[arg(long, value_name = "N")]
    max_rpm: Option<NonZeroU32>,
    /// Highest speed of the magnets in mm/s; without it no jump on a rod is found
    #[arg(long, value_name = "N")]
    max_mm_s: Option<NonZeroU32>,
    /// Rod lengths on the type labels in mm, for --max-mm-s: one for all, or one for each position; a simulated ring knows
    /// them
    #[arg(long, value_name = "MM[,MM..]", value_parser = arguments::millimetres, value_delimiter = ',')]
    rod_mm: Vec<u32>,
}

/// An encoder as it was asked for.
struct Asked {
    position: usize,
    model: Option<Model>,
    native: Option<u32>,
    rod_um: Option<u32>,
    file: Option<(String, KeptEncoder)>,
}

impl SubjectArguments {
    /// The encoders, each with who judges it.
    pub(crate) fn subjects(&self, opened: &Opened) -> Result<Vec<Subject>, Failure> {
        Ok(self.described(opened)?.0)
    }

    /// The same, with what their files say.
    pub(crate) fn described(&self, opened: &Opened) -> Result<(Vec<Subject>, Vec<KnownFile>), Failure> {
        let (subjects, files): (Vec<_>, Vec<_>) = self.opened_subjects(opened)?.into_iter().unzip();
        self.concern(&subjects, opened.is_simulated())?;
        Ok((subjects, files.into_iter().flatten().collect()))
    }

    fn opened_subjects(&self, opened: &Opened) -> Result<Vec<(Subject, Option<KnownFile>)>, Failure> {
        match &opened.world {
            Some(world) => {
                if !self.parameters.is_empty() {
                    return Err(bad_input(
                        "--parameters: a simulated ring knows the parameters of its encoders; leave the option out",
                    ));
                }
                if !self.rod_mm.is_empty() {
                    return Err(bad_input("--rod-mm: a simulated ring knows its rods; leave the option out"));
                }
                let all = (0..world.with(|world| world.places().len())).collect();
                let at = self.at.clone().unwrap_or(Positions(all));
                let known = |asked| Ok((self.simulated(opened, &asked)?, None));
                self.asked(&at)?.into_iter().map(known).collect()
            }
            None => {
                let Some(at) = &self.at else {
                    return Err(bad_input(
                        "--at POSITIONS is missing, like 0-2; `encoring probe` finds the encoders of a gateway",
                    ));
                };
                self.asked(at)?.into_iter().map(|asked| self.real(asked)).collect()
            }
        }
    }

    /// Refuses an option of a movement that nothing here can be judged by.
    fn concern(&self, subjects: &[Subject], simulated: bool) -> Result<(), Failure> {
        let options = [
            ("--max-rpm", self.max_rpm.is_some(), SensorKind::Rotary, "shaft"),
            ("--max-mm-s", self.max_mm_s.is_some(), SensorKind::Linear, "rod"),
            ("--rod-mm", !self.rod_mm.is_empty(), SensorKind::Linear, "rod"),
        ];
        for (option, _, kind, what) in options.into_iter().filter(|(_, given, ..)| *given) {
            let judges = || subjects.iter().map(|subject| &subject.judge);
            let mut concerned = judges().filter(|judge| judge.model().sensor_kind() == kind).peekable();
            if concerned.peek().is_none() {
                return Err(bad_input(format!("{option}: none of these encoders is a {what}")));
            }
            // A simulation shows its parameters with the first poll.
            if !simulated && concerned.all(|judge| judge.blind().contains(&Blind::Motion)) {
                return Err(bad_input(format!(
                    "{option}: the scaling of no {what} here is known, so no movement can be judged; give its \
                     parameters with --parameters FILE.toml"
                )));
            }
        }
        Ok(())
    }

    /// Brings the lists together.
    fn asked(&self, at: &Positions) -> Result<Vec<Asked>, Failure> {
        let count = at.0.len();
        let (models, natives) = (at.each("--model", &self.model)?, at.each("--native", &self.native)?);
        let rods = at.each("--rod-mm", &self.rod_mm)?;
        let labels = at.0.iter().zip(models).zip(natives).zip(rods);
        let mut asked: Vec<Asked> = labels
            .map(|(((position, model), native), rod_um)| Asked {
                position: *position,
                model,
                native,
                rod_um,
                file: None,
            })
            .collect();
        for (k, text) in self.parameters.iter().enumerate() {
            let named = text
                .split_once('=')
                .and_then(|(position, file)| Some((arguments::position(position).ok()?, file)));
            let (place, name) = match named {
                Some((position, file)) => {
                    let place = asked.iter_mut().find(|asked| asked.position == position);
                    let other =
                        || bad_input(format!("--parameters {text}: position {position} is not in --at"));
                    (place.ok_or_else(other)?, file)
                }
                None if self.parameters.len() == count => match asked.get_mut(k) {
                    Some(place) => (place, text.as_str()),
                    None => break,
                },
                None => {
                    let given = self.parameters.len();
                    return Err(bad_input(format!(
                        "--parameters {text}: {given} files for {count} encoders; give one for each, or write \
                         POSITION={text}"
                    )));
                }
            };
            if place.file.is_some() {
                return Err(bad_input(format!(
                    "--parameters {text}: position {} has a file already",
                    place.position
                )));
            }
            let file = ParameterFile::read(Path::new(name)).map_err(bad_input)?;
            let kept =
                file.at(Some(place.position)).map_err(|problem| bad_input(format!("{name}: {problem}")))?;
            place.file = Some((name.to_owned(), kept.clone()));
        }
        Ok(asked)
    }

    fn tolerance(&self) -> Tolerance {
        Tolerance { stale_after: self.stale_after, max_rpm: self.max_rpm, max_mm_s: self.max_mm_s }
    }

    fn simulated(&self, opened: &Opened, asked: &Asked) -> Result<Subject, Failure> {
        let position = asked.position;
        let Some(unit) = opened.unit(position)? else { return Err(bad_input("no simulated ring")) };
        if let Some(model) = asked.model.filter(|model| *model != unit.model()) {
            let found = unit.model();
            return Err(bad_input(format!(
                "--model {model}: the encoder at position {position} is a {found}"
            )));
        }
        // Its parameters are seen with every poll.
        let judge =
            Judge::new(unit.model(), Some(unit.sensor()), &[], self.tolerance()).map_err(bad_input)?;
        Ok(Subject { position, judge })
    }

    fn real(&self, asked: Asked) -> Result<(Subject, Option<KnownFile>), Failure> {
        let Asked { position, model, native, rod_um, file } = asked;
        let from_file = file.as_ref().map(|(_, file)| file.model);
        let Some(model) = model.or(from_file) else {
            return Err(bad_input(
                "--model MODEL is missing: no word of an encoder shows its model, so read it from the type label",
            ));
        };
        let name = file.as_ref().map_or("", |(name, _)| name.as_str());
        if from_file.is_some_and(|other| other != model) {
            let problem = format!(
                "{name}: the file is not for the {model} at position {position}; write POSITION=FILE.toml for another position"
            );
            return Err(bad_input(problem));
        }
        let native = native.or(file.as_ref().and_then(|(_, file)| file.label.native));
        let sensor = sensor(model, native, rod_um)?;
        let values = file.as_ref().map(|(_, file)| file.values.clone()).unwrap_or_default();
        let judge = Judge::new(model, sensor, &values, self.tolerance())
            .map_err(|error| bad_input(format!("{name}: {error}")))?;
        let is_rod = model.sensor_kind() == SensorKind::Linear;
        if is_rod && sensor.is_none() && self.max_mm_s.is_some() && !judge.blind().contains(&Blind::Motion) {
            return Err(bad_input(format!(
                "--max-mm-s: the length of the rod at position {position} is not known; give it with --rod-mm N, from \
                 the type label"
            )));
        }
        let file = file.map(|(name, kept)| known(position, &name, kept));
        Ok((Subject { position, judge }, file))
    }
}

/// What a file says of the encoder at a position, for whoever shows it.
fn known(position: usize, name: &str, kept: KeptEncoder) -> KnownFile {
    let shown = Path::new(name).file_name().map(|name| name.to_string_lossy().into_owned());
    KnownFile {
        position,
        name: shown.unwrap_or_default(),
        taken: kept.taken.map(|taken| taken.at),
        serial: kept.label.serial,
        label: kept.label.label,
        values: kept.values,
    }
}

/// What an encoder measures with, as far as it is known. One number may be meant for all, so that of another kind is
/// left aside.
fn sensor(model: Model, native: Option<u32>, rod_um: Option<u32>) -> Result<Option<Sensor>, Failure> {
    let rod = |rod_um| {
        let built = model.built_with(Sensor::Linear { rod_um });
        built.map_err(|wrong| bad_input(format!("--rod-mm: {wrong}")))
    };
    Ok(match (model.sensor_kind(), model.steps_per_turn(), native) {
        (SensorKind::Linear, ..) => rod_um.map(rod).transpose()?,
        (SensorKind::Rotary, [only], None) => Some(Sensor::Rotary { steps_per_turn: *only }),
        (SensorKind::Rotary, _, None) => None,
        (SensorKind::Rotary, _, Some(native)) => Some(built_with(model, native)?),
    })
}
