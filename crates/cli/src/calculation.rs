//! What there is to say of a range before it is programmed.

use std::fmt;

use encoring_host::request::Request;
use encoring_host::scaling::{
    Axis, Choice, Deviation, Fraction, Linear, Proposal, Purpose, Ratio, Rotary, RotaryScaling, Rounding,
    Shaft, Turns, ZeroRisk,
};
use encoring_words::model::{Demand, Effect, Listed, MODELS, SENSOR_TURNS, Series, Takes};
use encoring_words::{Model, Parameter, Service};
use serde::Serialize;

use crate::output::ratio::{cut, show};
use crate::output::wrap::wrapped;

/// Where the text of a note begins.
const INDENT: usize = 10;

/// A sentence or two on one topic.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Note {
    pub(crate) topic: &'static str,
    pub(crate) text: String,
    /// Whoever programs it must know.
    #[serde(skip)]
    weight: Weight,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Weight {
    Remark,
    Warning,
}

fn note(topic: &'static str, text: impl Into<String>) -> Note {
    Note { topic, text: text.into(), weight: Weight::Remark }
}

fn warning(topic: &'static str, text: impl Into<String>) -> Note {
    Note { weight: Weight::Warning, ..note(topic, text) }
}

impl Note {
    /// What whoever programs it must know.
    pub(crate) const fn warning(topic: &'static str, text: String) -> Self {
        Self { topic, text, weight: Weight::Warning }
    }

    /// What is good to know.
    pub(crate) fn remark(topic: &'static str, text: String) -> Self {
        note(topic, text)
    }

    pub(crate) fn warns(&self) -> bool {
        self.weight == Weight::Warning
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", wrapped(&format!("{:<1$} {2}", self.topic, INDENT - 1, self.text), INDENT))
    }
}

/// A rotary calculation with what was asked for.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) steps_per_turn: Ratio,
    /// If the steps were given as millimetres.
    pub(crate) mm_per_turn: Option<Ratio>,
    pub(crate) shaft: Shaft,
    pub(crate) model: Option<Model>,
    pub(crate) found: Rotary,
    /// If the turns were found for an axis.
    pub(crate) advice: Option<Advice>,
}

/// The turns that an axis is advised to take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Advice {
    pub(crate) axis: Axis,
    /// What was asked for; `None`: as many as there can be.
    pub(crate) wanted: Option<Ratio>,
    pub(crate) taken: Proposal,
}

impl Advice {
    /// # Errors
    /// That no number of turns is enough.
    pub(crate) fn new(axis: Axis, wanted: Option<Ratio>, shaft: Shaft) -> Result<Self, String> {
        let taken = axis
            .advice(wanted, shaft)
            .and_then(|purpose| axis.proposal(purpose, wanted, shaft))
            .ok_or_else(|| {
                let turns = axis.turns().map(show).unwrap_or_default();
                format!(
                    "--travel-mm {} needs {turns} turns and a reserve of {} mm; there are {}..{} turns: a gear is needed",
                    show(axis.travel),
                    show(axis.reserve),
                    Fraction::fewest(shaft),
                    Fraction::most(shaft).numerator(),
                )
            })?;
        Ok(Self { axis, wanted, taken })
    }

    pub(crate) fn steps_per_turn(&self) -> Ratio {
        self.taken.rotary.scaling.steps_per_turn()
    }

    pub(crate) fn turns(&self) -> Turns {
        Turns::from(self.taken.rotary.scaling.fraction)
    }

    /// Every proposal that there is, whether taken or not.
    pub(crate) fn proposals(&self, shaft: Shaft) -> impl Iterator<Item = Proposal> {
        let purposes = [Purpose::Travel, Purpose::Reserve, Purpose::Safe];
        purposes.into_iter().filter_map(move |purpose| self.axis.proposal(purpose, self.wanted, shaft))
    }

    fn note(&self) -> Note {
        let Axis { travel, reserve, per_turn } = self.axis;
        let text = format!(
            "{} mm of travel at {} mm a turn are {} turns; the range is to reach at least {} mm further, so that the end of \
             travel is not where the position wraps",
            show(travel),
            show(per_turn),
            self.axis.turns().map(show).unwrap_or_default(),
            show(reserve),
        );
        note("axis", text)
    }
}

/// The services of a shaft's scaling.
pub(crate) const SCALING: [Service; 3] = [Service::MeasuringLength, Service::Numerator, Service::Denominator];

/// The models whose scaling is programmed with these three.
pub(crate) fn scaled() -> impl Iterator<Item = Model> {
    MODELS.into_iter().filter(|model| SCALING.iter().all(|service| service.known_to(*model)))
}

/// What a calculation takes for the steps per turn if nobody says them.
pub(crate) fn usual_steps_per_turn(model: Option<Model>) -> Option<u32> {
    model.or_else(|| scaled().next())?.steps_per_turn().first().copied()
}

/// What turns for an axis are for.
const fn why(purpose: Purpose) -> &'static str {
    match purpose {
        Purpose::Travel => "the travel alone: its end is next to the wrap",
        Purpose::Reserve => "the fewest whole turns with the reserve",
        Purpose::Safe => "the fewest turns with the reserve that keep the zero",
    }
}

/// A number of things for people.
fn counted(ratio: Ratio, thing: &str) -> String {
    let plural = if ratio == Ratio::from(1) { "" } else { "s" };
    format!("{} {thing}{plural}", show(ratio))
}

fn magnitude(deviation: Deviation) -> String {
    match deviation {
        Deviation::None => "0".to_owned(),
        Deviation::Below(off) | Deviation::Above(off) => cut(off, Rounding::Nearest).to_string(),
    }
}

/// Of a rod.
pub(crate) fn linear_notes(
    length_mm: Ratio,
    resolution_mm: Ratio,
    model: Model,
    found: &Linear,
) -> Vec<Note> {
    let largest = found.scaling.measuring_length();
    let mut notes = vec![note(
        "range",
        format!("positions 0..{largest} over {} mm, {} mm a step", show(length_mm), show(found.resolution)),
    )];
    if !found.steps.is_whole() {
        notes.push(warning(
            "rounded",
            format!(
                "{} mm in steps of {} mm would be {} steps; {largest} is the nearest whole number",
                show(length_mm),
                show(resolution_mm),
                show(found.steps)
            ),
        ));
    }
    notes.push(note(
        "active",
        match model.effect() {
            Effect::AtOnce => "with the reply to service 02; service 08 shows errors and clears them",
            Effect::AtDataCheck => "with the data check, service 08",
        },
    ));
    let has_value = Service::PresetValue1.known_to(model);
    let kept = if has_value { " Preset value 1 (service 04) keeps its number too." } else { "" };
    let preset = "the stored preset stays as so many steps, which now is another place: the position will be elsewhere. \
                  Make a preset adjustment (service 06) at the end.";
    notes.push(note("preset", format!("{preset}{kept}")));
    notes
}

impl Asked {
    /// The models that it can be of.
    pub(crate) fn models(&self) -> Vec<Model> {
        let steps_per_turn = self.shaft.steps_per_turn();
        self.candidates().filter(|model| self.taken_by(*model, steps_per_turn).is_some()).collect()
    }

    /// The model asked for, or every one that can be scaled.
    fn candidates(&self) -> impl Iterator<Item = Model> {
        let asked = self.model;
        scaled().filter(move |model| asked.is_none_or(|asked| asked == *model))
    }

    /// The shaft of a model whose services take the values, if there is one.
    fn taken_by(&self, model: Model, steps_per_turn: u32) -> Option<Shaft> {
        let shaft = Shaft::new(model, steps_per_turn).ok()?;
        let RotaryScaling { fraction, .. } = self.found.scaling;
        let fraction = Fraction::new(fraction.numerator(), fraction.denominator(), shaft).ok()?;
        RotaryScaling::new(self.found.scaling.measuring_length(), fraction, shaft).ok().map(|_| shaft)
    }

    /// What a step really is.
    pub(crate) fn resolution_mm(&self) -> Option<Ratio> {
        self.mm_per_turn?.over(self.found.scaling.steps_per_turn())
    }

    /// Everything that whoever programs it must know.
    pub(crate) fn notes(&self) -> Vec<Note> {
        let mut notes = self.meaning();
        if self.found.scaling.too_large(self.shaft).is_none() {
            self.preset_notes(&mut notes);
        }
        notes
    }

    /// What the values mean, whether they are programmed already or not.
    pub(crate) fn meaning(&self) -> Vec<Note> {
        let mut notes: Vec<Note> = self.advice.as_ref().map(Advice::note).into_iter().collect();
        notes.extend([self.turns_note(), self.range_note()]);
        let (found, scaling) = (&self.found, self.found.scaling);
        if !found.positions.is_whole() {
            notes.push(warning(
                "rounded",
                format!(
                    "{} steps per turn over {} turns would be {} positions; {} is the nearest whole number",
                    show(self.steps_per_turn),
                    scaling.fraction,
                    show(found.positions),
                    scaling.measuring_length() + 1,
                ),
            ));
        }
        self.limit_notes(&mut notes);
        notes.push(match scaling.zero_risk() {
            ZeroRisk::Safe => note(
                "zero",
                format!(
                    "safe: {}, so moving the shaft without supply cannot shift the position",
                    sensor_turns(scaling.fraction, "a multiple")
                ),
            ),
            ZeroRisk::Shift { turns, steps } => warning(
                "zero",
                format!(
                    "can be lost: {}; after more than 512 turns without supply the position can come back wrong by \
                     {} ({}). Check it against a mark and make a preset adjustment.{}",
                    sensor_turns(scaling.fraction, "no multiple"),
                    counted(steps, "step"),
                    counted(turns, "turn"),
                    promised(scaling.fraction),
                ),
            ),
        });
        let bits = scaling.gray_wrap_bits();
        let models: Vec<Model> =
            self.models().into_iter().filter(|model| model.position_may_be_gray()).collect();
        if bits != 1 && !models.is_empty() {
            let models = Series(&models, "or");
            notes.push(warning(
                "gray",
                format!(
                    "if a {models} is set to Gray code, {bits} bits change at once between {} and 0: what is read \
                     just then can be anything. Use binary, or a number of positions that is a power of two.",
                    scaling.measuring_length()
                ),
            ));
        }
        notes
    }

    fn turns_note(&self) -> Note {
        let chosen = &self.found.chosen;
        let (fraction, wanted) = (chosen.fraction, show(chosen.wanted));
        let (most, finest) = self.shaft.largest_parts();
        if let Some(advice) = &self.advice {
            return note("turns", format!("{fraction}: {}", why(advice.taken.purpose)));
        }
        let text = match chosen.choice {
            Choice::AsGiven if fraction.denominator() != 1 && chosen.wanted.is_whole() => format!(
                "{fraction}, as given; for a whole number of turns the manual wants the denominator 1: --turns {wanted}"
            ),
            Choice::AsGiven => format!("{fraction}, as given"),
            Choice::Whole => format!("{fraction}: a whole number of turns has the denominator 1"),
            Choice::DecimalPlace => {
                format!("{fraction}: {wanted} the manual's way, the denominator from the decimal place")
            }
            Choice::Reduced => {
                format!(
                    "{fraction}: {wanted} in lowest terms, so that N is at most {most} and D at most {finest}"
                )
            }
            Choice::Nearest => {
                let side = if matches!(chosen.off, Deviation::Below(_)) { "short" } else { "long" };
                format!(
                    "{fraction}: the nearest with N up to {most} and D up to {finest}; {wanted} turns cannot be \
                     programmed. The range is too {side} by {} turns ({} ppm), that is {} steps; they add up with \
                     every pass if the machine keeps turning one way.",
                    magnitude(chosen.off),
                    magnitude(chosen.off_ppm()),
                    magnitude(self.found.steps_off()),
                )
            }
        };
        match chosen.choice {
            Choice::Nearest => warning("turns", text),
            _ => note("turns", text),
        }
    }

    fn range_note(&self) -> Note {
        let scaling = self.found.scaling;
        let step = match self.resolution_mm() {
            Some(resolution) => format!(", {} mm a step", show(resolution)),
            None => String::new(),
        };
        note(
            "range",
            format!(
                "positions 0..{} over {} turns, then 0 again; {} steps per turn{step}",
                scaling.measuring_length(),
                show(scaling.fraction.turns()),
                show(scaling.steps_per_turn()),
            ),
        )
    }

    fn limit_notes(&self, notes: &mut Vec<Note>) {
        let scaling = self.found.scaling;
        let steps = show(scaling.steps_per_turn());
        let plate = self.shaft.steps_per_turn();
        let Some(instead) = scaling.too_large(self.shaft) else {
            notes
                .push(note("2^14", format!("kept: {steps} steps per turn, the rating plate allows {plate}")));
            return;
        };
        notes.push(warning(
            "2^14",
            format!(
                "REFUSED: {steps} steps per turn, but the rating plate allows {plate}. The data check would answer \
                 A8004000 and take nothing over. Do not program this. What works:"
            ),
        ));
        let steps = Ratio::from(scaling.measuring_length() + 1);
        notes.extend(instead.smallest_fraction.map(|fraction| {
            let (n, d) = (fraction.numerator(), fraction.denominator());
            warning(
                "either",
                format!(
                    "N = {n} ({n:X}h), D = {d} ({d:X}h), S as above: the smallest range for {} positions, {} turns. {}",
                    scaling.measuring_length() + 1,
                    show(fraction.turns()),
                    self.command(steps, fraction),
                ),
            )
        }));
        notes.extend(instead.largest_measuring_length.map(|length| {
            warning(
                "or",
                format!(
                    "S = {length} ({length:X}h), N and D as above: the most positions over {} turns. {}",
                    show(scaling.fraction.turns()),
                    self.command(Ratio::from(length + 1), scaling.fraction),
                ),
            )
        }));
        for model in self.candidates() {
            let finer = model.steps_per_turn().iter().copied().find(|steps| {
                let shaft = self.taken_by(model, *steps).filter(|_| *steps > plate);
                shaft.is_some_and(|shaft| scaling.too_large(shaft).is_none())
            });
            if let Some(steps) = finer {
                let text =
                    format!("a {model} with {steps} steps per turn takes it as it is: --native {steps}");
                notes.push(warning("or", text));
            }
        }
    }

    /// How to ask for the words of what works.
    fn command(&self, positions: Ratio, fraction: Fraction) -> String {
        let Some(steps_per_turn) = positions.over(fraction.turns()) else { return String::new() };
        let steps_per_turn = steps_per_turn.rounded(9, Rounding::Nearest);
        let native = match self.shaft.steps_per_turn() {
            steps if usual_steps_per_turn(self.model) == Some(steps) => String::new(),
            steps => format!(" --native {steps}"),
        };
        format!(
            "Its words: encoring calc rotary --steps-per-turn {steps_per_turn} --turns {fraction}{native}"
        )
    }

    fn preset_notes(&self, notes: &mut Vec<Note>) {
        let largest = self.found.scaling.measuring_length();
        let models = self.models();
        let adjustments = models.iter().filter_map(|model| model.lists(Service::PresetAdjustment));
        let highest = adjustments.map(|listed| listed.takes.largest(largest)).min().unwrap_or(largest);
        notes.push(note(
            "preset",
            format!(
                "the stored preset stays, but belongs to the old values: the position will be elsewhere. Make a \
                 preset adjustment (service 06, at most {highest}) after the data check. Another D converts the \
                 stored preset, rounded down."
            ),
        ));
        notes.extend(models.into_iter().filter_map(|model| checked_presets(model, largest)));
    }
}

/// Presets that the data check compares with the measuring length [R70, R90].
fn checked_presets(model: Model, largest: u32) -> Option<Note> {
    let is_checked = |listed: &&Listed| {
        matches!(listed.takes, Takes::Number { demand: Demand::UpToMeasuringLength(_), .. })
    };
    let checked = || model.services().iter().filter(is_checked);
    let numbers: Vec<_> = checked().map(|listed| format!("{:02X}", listed.service.number())).collect();
    let reads: Vec<_> = checked()
        .filter_map(|listed| Request::read(model, Parameter::from_service(listed.service)?).ok())
        .map(|request| request.word().to_string())
        .collect();
    let bits: Vec<_> = checked()
        .flat_map(|listed| listed.takes.invalid_beside(u32::MAX, 0).explain())
        .map(|row| format!("2^{}", row.bit))
        .collect();
    let text = format!(
        "of a {model}: a preset value (services {}) above {largest} makes the data check refuse everything with {}. \
         Read them ({}) and lower them first.",
        numbers.join(", "),
        Series(&bits, "or"),
        reads.join(", "),
    );
    (!numbers.is_empty()).then(|| note("presets", text))
}

/// Why the zero is kept or not: the sensor tells 4096 turns apart [C29].
fn sensor_turns(fraction: Fraction, relation: &str) -> String {
    let (n, d) = (fraction.numerator(), fraction.denominator());
    format!("{SENSOR_TURNS} * D = {} is {relation} of N = {n}", SENSOR_TURNS * d)
}

/// What the manual promises of a number of turns whose zero can be lost all the same [C29].
fn promised(fraction: Fraction) -> &'static str {
    let turns = fraction.numerator() / fraction.denominator().max(1);
    if fraction.turns().is_whole() && turns.is_power_of_two() {
        " The manual promises the zero for a power of two; that it is lost above 4096 turns is from a sibling's manual."
    } else {
        ""
    }
}
