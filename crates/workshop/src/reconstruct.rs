//! The parameters of an encoder that does not answer any more.
//!
//! [`words`] takes them from the words of a PLC program or of a recording; [`positions`] finds what positions at known
//! places tell. What cannot be known is said, never guessed.

pub mod interval;
pub mod positions;
pub mod words;

use encoring_host::Request;
use encoring_words::explain::Meaning;
use encoring_words::model::SensorKind;
use encoring_words::{ErrorStatus, Model, OutWord, Parameter, ParameterSet};

use crate::kept::KeptEncoder;
use positions::{AssumedScaling, Line};
use words::{WordEvidence, WordFindings};

/// What is known of an encoder that does not answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reconstruction {
    /// What can be programmed.
    pub kept: KeptEncoder,
    /// What is known, and from where: sentences.
    pub known: Vec<String>,
    /// What is assumed: sentences.
    pub assumed: Vec<String>,
    /// What is not known, and what would settle it: sentences.
    pub unknown: Vec<String>,
    /// Nothing contradicts: what can be programmed is meant to be.
    pub sound: bool,
    /// So many steps a position may be off at most; 0 unless it comes from known positions.
    pub off_at_most: u128,
    /// Other numbers of steps fit the known positions as well: what is kept is a guess.
    pub is_guess: bool,
}

impl Reconstruction {
    fn new(model: Model) -> Self {
        let kept = KeptEncoder::new(model);
        Self {
            kept,
            known: Vec::new(),
            assumed: Vec::new(),
            unknown: Vec::new(),
            sound: true,
            off_at_most: 0,
            is_guess: false,
        }
    }

    /// From what words tell.
    #[must_use]
    pub fn from_words(model: Model, findings: &WordFindings) -> Self {
        let mut told = Self::new(model);
        told.kept.remarks.push("put together from words; the old unit was not read".to_owned());
        told.kept.values = findings.values();
        for (parameter, evidence) in findings.all() {
            let key = parameter.key();
            match evidence {
                WordEvidence::Known(found) => {
                    told.known.push(format!(
                        "{key} = {}: {}{}",
                        meant(parameter, model, found.value),
                        found.place,
                        one_too_many(parameter, found.value)
                    ));
                }
                WordEvidence::Contradicted(several) => {
                    let several: Vec<_> =
                        several.iter().map(|found| format!("{} ({})", found.value, found.place)).collect();
                    told.sound = false;
                    told.unknown.push(format!(
                        "{key}: the words contradict each other: {}. Leave out those that the program does not send",
                        several.join(", ")
                    ));
                }
                WordEvidence::Missing => told.unknown.push(missing(parameter)),
            }
        }
        for preset in findings.presets() {
            told.known.push(format!(
                "the program makes the position {} by a preset ({}): find out at which place of the machine",
                preset.value, preset.place
            ));
        }
        told.unknown.extend(findings.notes.iter().cloned());
        if let Some(refused) = &findings.refused {
            told.unknown.push(format!(
                "which values counted: the data check refused them together, or an error was pending ({refused}). Give the \
                 words that the program sends now: --word"
            ));
        }
        if let Some(refused) = refused_together(&told.kept) {
            told.sound = false;
            told.unknown.push(refused);
        }
        if findings.presets().is_empty() {
            told.unknown.push(
                "the zero: no word has it. A place whose position is known, and a preset there, settle it"
                    .to_owned(),
            );
        }
        told
    }

    /// From what positions at known places tell.
    #[must_use]
    pub fn from_positions(model: Model, line: &Line, turns: Option<u32>) -> Option<Self> {
        let rod = model.sensor_kind() == SensorKind::Linear;
        let scaling = if rod { line.rod(model) } else { line.shaft(turns) }?;
        let mut told = Self::new(model);
        told.kept.remarks.push("put together from known positions; the old unit was not read".to_owned());
        told.kept.values.clone_from(&scaling.values);
        told.off_at_most = scaling.off_at_most;
        told.is_guess = !scaling.only_round_one;
        let per = if rod { "over the rod" } else { "per turn" };
        let (low, high) = line.steps();
        told.known.push(format!(
            "the position {} with the place; it makes more than {} and fewer than {} steps {per}",
            if line.rising { "rises" } else { "falls" },
            decimal(low),
            decimal(high)
        ));
        told.assume(&scaling, rod, per, turns);
        Some(told)
    }

    fn assume(&mut self, scaling: &AssumedScaling, rod: bool, per: &str, turns: Option<u32>) {
        let steps = decimal(scaling.steps);
        self.assumed.push(if scaling.only_round_one {
            format!("{steps} steps {per}: the only round number that fits")
        } else {
            format!(
                "{steps} steps {per}: other numbers fit as well, and this is the roundest. Places that are farther apart, or \
                 known more exactly, settle it"
            )
        });
        self.assumed.push(format!(
            "between these places a position is off by at most {} step{} once a preset was made at one of them",
            scaling.off_at_most,
            if scaling.off_at_most == 1 { "" } else { "s" }
        ));
        if rod {
            self.assumed.push("direction: that of the position beside the scale; it is right if the scale begins where the rod \
                 does".to_owned());
            return;
        }
        self.assumed.push(
            "direction: the machine's scale is taken to rise when the shaft turns clockwise; if the position counts the wrong \
             way after the programming, write the other one"
                .to_owned(),
        );
        let value = |wanted| {
            let found = scaling.values.iter().find(|(parameter, _)| *parameter == wanted);
            found.map_or(0, |(_, value)| *value)
        };
        let (length, numerator) = (value(Parameter::MeasuringLength), value(Parameter::Numerator));
        let range = format!("positions 0 to {length} over {numerator} turns");
        if turns.is_none() {
            self.assumed.push(format!(
                "the range, {range}: positions never tell it. Inside the travel it makes no difference; beyond, the old \
                 position may have begun again at 0 elsewhere"
            ));
            self.unknown.push(
                "the measuring length, and numerator and denominator apart: the words of the PLC program (C2.., C3.., C9..) \
                 settle them"
                    .to_owned(),
            );
        }
    }
}

/// The words of a PLC program that write what is kept, with the service bit.
pub fn constants(kept: &KeptEncoder) -> impl Iterator<Item = (Parameter, OutWord)> {
    let model = kept.model;
    kept.values.iter().filter_map(move |(parameter, value)| {
        Request::write(model, *parameter, *value).ok().map(|request| (*parameter, request.word()))
    })
}

/// A value with its meaning.
fn meant(parameter: Parameter, model: Model, value: u32) -> String {
    match Meaning::of(parameter, model, value) {
        Some(meaning) => format!("{value} ({meaning})"),
        None => value.to_string(),
    }
}

/// What is odd about a measuring length that is itself a power of two: it is the largest position, and there is one more.
fn one_too_many(parameter: Parameter, value: u32) -> String {
    if parameter != Parameter::MeasuringLength || !value.is_power_of_two() || value < 0x100 {
        return String::new();
    }
    format!(
        ". It is the largest position, so there are {}: is {} meant, which makes {value}?",
        u64::from(value) + 1,
        value - 1
    )
}

/// Why no encoder of the model takes the scaling that is kept, however finely it divides a turn; `None` if one does, or if
/// not all of it is kept.
fn refused_together(kept: &KeptEncoder) -> Option<String> {
    let model = kept.model;
    let value = |parameter| kept.value(parameter);
    let length = value(Parameter::MeasuringLength)?;
    let (numerator, denominator) = (value(Parameter::Numerator)?, value(Parameter::Denominator)?);
    let mut set = ParameterSet::factory(model, model.finest_sensor());
    for (parameter, value) in &kept.values {
        set.set(*parameter, *value);
    }
    let status = set.validity(model, model.finest_sensor());
    status.contains(ErrorStatus::LENGTH_TOO_LARGE).then(|| {
        format!(
            "which of these words the encoder took: {} positions in {numerator}/{denominator} turns are more than any {model} \
             has, and the data check refuses them. One of the words is not of this encoder, or was misread",
            u64::from(length) + 1
        )
    })
}

/// What stays as the new unit has it.
fn missing(parameter: Parameter) -> String {
    let key = parameter.key();
    let more = match parameter {
        Parameter::CountingDirection => ". If the position counts the wrong way, it is the other one",
        Parameter::MeasuringLength | Parameter::Numerator | Parameter::Denominator => {
            ". Without it the positions are not those of the old unit unless it was never programmed"
        }
        _ => "",
    };
    format!("{key}: in no word, so it stays as the new unit has it{more}")
}

/// A number as people read it: three decimals at most.
fn decimal((numerator, denominator): (u128, u128)) -> String {
    let denominator = denominator.max(1);
    let thousandths = numerator.saturating_mul(1_000) / denominator;
    let exact = thousandths.saturating_mul(denominator) == numerator.saturating_mul(1_000);
    let (whole, rest) = (thousandths / 1_000, thousandths % 1_000);
    let text = format!("{whole}.{rest:03}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if exact { text.to_owned() } else { format!("{whole}.{rest:03}..") }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    reason = "tests"
)]
mod tests;
