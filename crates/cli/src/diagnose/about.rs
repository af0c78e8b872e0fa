//! What is said of the encoder and its axis beside the recording.

use std::num::NonZeroU32;
use std::path::PathBuf;

use clap::Args;
use encoring_diagnosis::{ActiveValues, KnownPlace, Options};
use encoring_words::model::SensorKind;
use encoring_words::{Duration, Model, Parameter, ParameterSet};
use encoring_workshop::ParameterFile;

use crate::arguments::{self, TypeLabel, span};
use crate::output::{Failure, bad_input};

/// Nanoseconds of a day.
const DAY_NS: i128 = 24 * 3_600 * 1_000_000_000;

/// What is known of the encoder.
#[derive(Args, Debug)]
#[command(next_help_heading = "The encoder and its axis")]
pub(super) struct AboutArguments {
    #[command(flatten)]
    label: TypeLabel,
    /// File with its active values, as `encoring backup` writes it
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Length of an LA-66's rod in mm, from the type label
    #[arg(long, value_name = "MM", value_parser = arguments::millimetres)]
    rod_mm: Option<u32>,
    /// Highest speed of the shaft in turns a minute [default: that of the data sheet]
    #[arg(long, value_name = "N")]
    max_rpm: Option<NonZeroU32>,
    /// Highest speed of the magnet in mm/s
    #[arg(long, value_name = "N")]
    max_mm_s: Option<NonZeroU32>,
    /// True position at a time of the recording, as "12:03:04 = 1500" or "90s = 1500"; may be given several times
    #[arg(long, value_name = "TIME = STEPS", value_parser = known)]
    known: Vec<KnownAt>,
}

/// A true position at a time.
#[derive(Clone, Copy, Debug)]
struct KnownAt {
    time_ns: u64,
    /// The time is one of the day.
    is_of_day: bool,
    steps: u32,
}

fn known(text: &str) -> Result<KnownAt, String> {
    let (time, steps) = text
        .split_once('=')
        .ok_or_else(|| format!("{text:?} has no =; write it as \"12:03:04 = 1500\" or \"90s = 1500\""))?;
    let (time, steps) = (time.trim(), arguments::value(steps.trim())?);
    let parts: Vec<&str> = time.split(':').collect();
    let (time, is_of_day) = match parts[..] {
        [hours, minutes] => (span(&format!("{hours}h {minutes}m"))?, true),
        [hours, minutes, seconds] => {
            let (whole, decimals) = seconds.split_once('.').unwrap_or((seconds, ""));
            let nanos = format!("{decimals:0<9}");
            (span(&format!("{hours}h {minutes}m {whole}s {nanos}ns"))?, true)
        }
        _ => (span(time)?, false),
    };
    Ok(KnownAt { time_ns: time.as_nanos(), is_of_day, steps })
}

impl AboutArguments {
    /// For a recording whose times begin at `origin_ns`, of an encoder that it names.
    pub(super) fn options(&self, origin_ns: i128, named: Option<Model>) -> Result<Options, Failure> {
        let active = self.active()?;
        let said = self.label.model.or(active.map(|active| active.model)).or(named);
        if let (Some(said), Some(named)) = (said, named)
            && said != named
        {
            return Err(bad_input(format!(
                "the recording is of a {named}, and --model or --parameters says {said}"
            )));
        }
        let mut known: Vec<KnownPlace> = self.known.iter().map(|known| known.place(origin_ns)).collect();
        known.sort_by_key(|known| known.time_ns);
        Ok(Options {
            model: said,
            active,
            most_rpm: self.max_rpm,
            most_mm_s: self.max_mm_s,
            known,
            ..Options::default()
        })
    }

    /// The values of the file, if it has all that a scaling needs.
    fn active(&self) -> Result<Option<ActiveValues>, Failure> {
        let Some(path) = &self.parameters else { return Ok(None) };
        let name = path.display();
        let file = ParameterFile::read(path).map_err(bad_input)?;
        let kept = file.at(None).map_err(|problem| bad_input(format!("{name}: {problem}")))?;
        let model = kept.model;
        if self.label.model.is_some_and(|said| said != model) {
            return Err(bad_input(format!("{name} is of a {model}, which --model contradicts")));
        }
        let native = self.label.native.or(kept.label.native);
        let native = native.filter(|_| model.sensor_kind() == SensorKind::Rotary);
        let sensor =
            model.sensor(native, self.rod_mm).map_err(|wrong| bad_input(format!("{name}: {wrong}")))?;
        let mut parameters = ParameterSet::factory(model, sensor);
        for (parameter, value) in &kept.values {
            parameters.set(*parameter, *value);
        }
        let needed = [Parameter::MeasuringLength, Parameter::Numerator, Parameter::Denominator];
        let lacks = needed
            .into_iter()
            .find(|parameter| model.lists(parameter.service()).is_some() && kept.value(*parameter).is_none());
        match lacks {
            Some(parameter) => Err(bad_input(format!(
                "{name} has no {}, without which the scaling is not known; add it, or leave --parameters out",
                parameter.key()
            ))),
            None => Ok(Some(ActiveValues { model, sensor, parameters })),
        }
    }
}

impl KnownAt {
    fn place(&self, origin_ns: i128) -> KnownPlace {
        let begins = if self.is_of_day { origin_ns.rem_euclid(DAY_NS) } else { 0 };
        let time =
            (i128::from(self.time_ns) - begins).rem_euclid(if begins == 0 { i128::MAX } else { DAY_NS });
        let time_ns = Duration(u64::try_from(time).unwrap_or(u64::MAX)).as_nanos();
        KnownPlace { time_ns, steps: self.steps.into() }
    }
}
