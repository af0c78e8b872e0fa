//! What is said of the encoder and its axis beside the recording.

use std::num::NonZeroU32;
use std::path::Path;

use clap::Args;
use encoring_diagnosis::{ActiveValues, Detector, KnownPlace, Options};
use encoring_station::NamedEncoder;
use encoring_words::model::SensorKind;
use encoring_words::word::DATA_MAX;
use encoring_words::{Duration, Model, Parameter, ParameterSet};
use encoring_workshop::ParameterFile;

use crate::arguments::{self, TypeLabel, span};
use crate::output::{Failure, bad_input, note};

/// Nanoseconds of a day.
const DAY_NS: i128 = 24 * 3_600 * 1_000_000_000;

/// What is known of the encoder.
#[derive(Args, Debug)]
#[command(next_help_heading = "The encoder and its axis")]
pub(super) struct AboutArguments {
    #[command(flatten)]
    label: TypeLabel,
    /// File with its active values, as `encoring backup` writes it, or POSITION=FILE for one of several encoders (repeatable)
    #[arg(long, value_name = "FILE")]
    parameters: Vec<String>,
    /// Length of an LA-66's rod in mm, from the type label
    #[arg(long, value_name = "MM", value_parser = arguments::millimetres)]
    rod_mm: Option<u32>,
    /// Highest speed of the shaft in turns a minute [default: that of the data sheet]
    #[arg(long, value_name = "N", value_parser = arguments::whole::<NonZeroU32>(1..=DATA_MAX))]
    max_rpm: Option<NonZeroU32>,
    /// Highest speed of the magnet in mm/s
    #[arg(long, value_name = "N", value_parser = arguments::whole::<NonZeroU32>(1..=DATA_MAX))]
    max_mm_s: Option<NonZeroU32>,
    /// True position at a time of the recording, as "12:03:04 = 1500" or "90s = 1500"; may be given several times
    #[arg(long, value_name = "TIME = STEPS", value_parser = known)]
    known: Vec<KnownAt>,
}

/// What a scaling needs.
const SCALING: [Parameter; 3] = [Parameter::MeasuringLength, Parameter::Numerator, Parameter::Denominator];

/// A file of `--parameters`.
struct GivenFile {
    /// `None`: of every encoder that has none of its own.
    position: Option<u8>,
    active: ActiveValues,
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
        [hours, minutes] => (of_day(time, hours, minutes, "0")?, true),
        [hours, minutes, seconds] => (of_day(time, hours, minutes, seconds)?, true),
        _ => (span(time)?, false),
    };
    Ok(KnownAt { time_ns: time.as_nanos(), is_of_day, steps })
}

/// A time of the day.
fn of_day(time: &str, hours: &str, minutes: &str, seconds: &str) -> Result<Duration, String> {
    let (whole, decimals) = seconds.split_once('.').unwrap_or((seconds, ""));
    for (part, limit) in [(hours, 24), (minutes, 60), (whole, 60)] {
        let value = arguments::value(part).map_err(|wrong| format!("{time}: {wrong}"))?;
        if value >= limit {
            return Err(format!(
                "{time}: {part} is above {}, the last of its kind in a time of the day",
                limit - 1
            ));
        }
    }
    if decimals.len() > 9 {
        return Err(format!("{time}: {decimals} has more digits than nanoseconds, 9"));
    }
    span(&format!("{hours}h {minutes}m {whole}s {decimals:0<9}ns"))
}

impl AboutArguments {
    /// Who looks at a recording whose times begin at `origin_ns`, of encoders that it names.
    pub(super) fn detector(&self, origin_ns: i128, named: &[NamedEncoder]) -> Result<Detector, Failure> {
        let files = self.files()?;
        let all = Options { model: NamedEncoder::only_model(named), ..self.options(origin_ns) };
        let of = |position| files.iter().find(|file| file.position == position).map(|file| file.active);
        let mut detector = Detector::new(with(all.clone(), of(None), self.label.model)?);
        for position in files.iter().filter_map(|file| file.position) {
            if named.iter().any(|one| one.position == position) {
                continue;
            }
            if !named.is_empty() {
                return Err(bad_input(format!(
                    "--parameters {position}=FILE: the recording has no position {position}"
                )));
            }
            let options = with(self.options(origin_ns), of(Some(position)), self.label.model)?;
            detector = detector.about(position, options);
        }
        for one in named {
            let file = of(Some(one.position)).or_else(|| of(None));
            let options = with(one.options(&all), file.or(one.active), self.label.model)?;
            tell_other(one, file.as_ref());
            detector = detector.about(one.position, options);
        }
        Ok(detector)
    }

    fn options(&self, origin_ns: i128) -> Options {
        let mut known: Vec<KnownPlace> = self.known.iter().map(|known| known.place(origin_ns)).collect();
        known.sort_by_key(|known| known.time_ns);
        Options { most_rpm: self.max_rpm, most_mm_s: self.max_mm_s, known, ..Options::default() }
    }

    /// The files of --parameters.
    fn files(&self) -> Result<Vec<GivenFile>, Failure> {
        let mut files: Vec<GivenFile> = Vec::new();
        for text in &self.parameters {
            let named = text
                .split_once('=')
                .and_then(|(position, file)| Some((arguments::position(position).ok()?, file)));
            let (position, name) =
                named.map_or((None, text.as_str()), |(position, file)| (Some(position), file));
            if files.iter().any(|file| file.position.map(usize::from) == position) {
                let whose =
                    position.map_or("all encoders".to_owned(), |position| format!("position {position}"));
                return Err(bad_input(format!("--parameters {text}: {whose} has a file already")));
            }
            let active = self.active(name, position)?;
            files.push(GivenFile {
                position: position.and_then(|position| u8::try_from(position).ok()),
                active,
            });
        }
        Ok(files)
    }

    /// The values of a file, if it has all that a scaling needs.
    fn active(&self, name: &str, position: Option<usize>) -> Result<ActiveValues, Failure> {
        let file = ParameterFile::read(Path::new(name)).map_err(bad_input)?;
        let kept = file.at(position).map_err(|problem| bad_input(format!("{name}: {problem}")))?;
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
        let lacks = SCALING
            .into_iter()
            .find(|parameter| model.lists(parameter.service()).is_some() && kept.value(*parameter).is_none());
        match lacks {
            Some(parameter) => Err(bad_input(format!(
                "{name} has no {}, without which the scaling is not known; add it, or leave --parameters out",
                parameter.key()
            ))),
            None => Ok(ActiveValues { model, sensor, parameters }),
        }
    }
}

/// The same with values that are active, of the model that somebody says.
fn with(options: Options, active: Option<ActiveValues>, label: Option<Model>) -> Result<Options, Failure> {
    let said = label.or(active.map(|active| active.model));
    if let (Some(said), Some(named)) = (said, options.model)
        && said != named
    {
        return Err(bad_input(format!(
            "the recording is of a {named}, and --model or --parameters says {said}; of several encoders say which with \
             --parameters POSITION=FILE"
        )));
    }
    Ok(Options { model: said.or(options.model), active, ..options })
}

/// Says where a file and the recording differ.
fn tell_other(named: &NamedEncoder, file: Option<&ActiveValues>) {
    let (Some(file), Some(memory)) = (file, &named.active) else { return };
    for parameter in SCALING {
        let (said, kept) = (file.parameters.value(parameter), memory.parameters.value(parameter));
        if said != kept {
            note(&format!(
                "note: position {}: the memory in the recording has {} = {kept}, --parameters says {said}, which is taken",
                named.position,
                parameter.key()
            ));
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
