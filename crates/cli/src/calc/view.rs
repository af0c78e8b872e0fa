//! What `calc` shows: plain data for programs. The text for people is made from the same.

use encoring_host::scaling::{
    Choice, Deviation, Expected, Fraction, HandshakeStep, HandshakeWord, Linear, Native, Ratio, Rounding,
    ZeroRisk,
};
use encoring_words::{Model, Service};
use serde::Serialize;

use super::Asked;
use crate::output::ratio::{cut, show};

/// A calculation with all that follows from it.
#[derive(Serialize)]
pub(super) struct CalcView {
    /// `rotary` or `linear`.
    encoder: &'static str,
    pub(super) models: Vec<&'static str>,
    /// Steps per turn of the sensor.
    pub(super) native: Option<u32>,
    usable: bool,
    measuring_length: ValueView,
    numerator: Option<ValueView>,
    denominator: Option<ValueView>,
    fraction: Option<FractionView>,
    steps: StepsView,
    too_large: Option<TooLargeView>,
    zero: Option<ZeroView>,
    gray_wrap_bits: Option<u32>,
    pub(super) notes: Vec<Note>,
    pub(super) sequence: Vec<StepView>,
}

/// A value as it is programmed.
#[derive(Clone, Serialize)]
pub(super) struct ValueView {
    #[serde(skip)]
    pub(super) service: Option<Service>,
    pub(super) value: u32,
    pub(super) hex: String,
}

#[derive(Serialize)]
struct FractionView {
    choice: &'static str,
    turns: f64,
    off_turns: f64,
    off_ppm: f64,
    off_steps: f64,
}

#[derive(Serialize)]
struct StepsView {
    /// Before it was made a whole number.
    wanted: f64,
    exact: bool,
    steps_per_turn: Option<f64>,
    resolution_mm: Option<f64>,
}

#[derive(Serialize)]
struct TooLargeView {
    smallest_fraction: PairView,
    largest_measuring_length: ValueView,
}

#[derive(Serialize)]
struct PairView {
    numerator: ValueView,
    denominator: ValueView,
}

#[derive(Serialize)]
struct ZeroView {
    safe: bool,
    shift_turns: f64,
    shift_steps: f64,
}

/// A sentence or two on one topic.
#[derive(Serialize)]
pub(super) struct Note {
    pub(super) topic: &'static str,
    pub(super) text: String,
}

/// One OUT word of the sequence.
#[derive(Serialize)]
pub(super) struct StepView {
    pub(super) service: u8,
    pub(super) service_name: &'static str,
    pub(super) phase: &'static str,
    pub(super) out: String,
    pub(super) out_high: String,
    pub(super) out_low: String,
    /// `None`: the position.
    #[serde(rename = "in")]
    pub(super) input: Option<String>,
    pub(super) in_high: Option<String>,
    pub(super) in_low: Option<String>,
    /// A write's reply while an error is pending.
    pub(super) in_with_error: Option<String>,
}

/// A number of things for people.
fn counted(ratio: Ratio, thing: &str) -> String {
    let plural = if ratio == Ratio::from(1) { "" } else { "s" };
    format!("{} {thing}{plural}", show(ratio))
}

/// A number for programs, to nine decimals.
fn number(ratio: Ratio) -> f64 {
    ratio.rounded(9, Rounding::Nearest).to_string().parse().unwrap_or(0.0)
}

fn signed(deviation: Deviation) -> f64 {
    match deviation {
        Deviation::None => 0.0,
        Deviation::Below(off) => -number(off),
        Deviation::Above(off) => number(off),
    }
}

fn magnitude(deviation: Deviation) -> String {
    match deviation {
        Deviation::None => "0".to_owned(),
        Deviation::Below(off) | Deviation::Above(off) => cut(off, Rounding::Nearest).to_string(),
    }
}

impl ValueView {
    fn new(service: Service, value: u32) -> Self {
        Self { service: Some(service), value, hex: format!("{value:06X}") }
    }

    fn length(value: u32) -> Self {
        Self::new(Service::MeasuringLength, value)
    }

    fn numerator(fraction: Fraction) -> Self {
        Self::new(Service::Numerator, fraction.numerator())
    }

    fn denominator(fraction: Fraction) -> Self {
        Self::new(Service::Denominator, fraction.denominator())
    }
}

impl StepView {
    fn new(step: HandshakeWord) -> Self {
        let reply = match step.expected {
            Expected::Position => None,
            Expected::Reply(reply) => Some(reply),
        };
        let with_error = step.expected.with_error().filter(|_| step.service != Service::DataCheck);
        Self {
            service: step.service.number(),
            service_name: step.service.name(),
            phase: match step.phase {
                HandshakeStep::Prepare => "prepare",
                HandshakeStep::Request => "request",
                HandshakeStep::End => "end",
            },
            out: step.out.to_string(),
            out_high: format!("{:04X}", step.out.high()),
            out_low: format!("{:04X}", step.out.low()),
            input: reply.map(|reply| reply.to_string()),
            in_high: reply.map(|reply| format!("{:04X}", reply.high())),
            in_low: reply.map(|reply| format!("{:04X}", reply.low())),
            in_with_error: with_error.map(|reply| reply.to_string()),
        }
    }
}

fn note(topic: &'static str, text: impl Into<String>) -> Note {
    Note { topic, text: text.into() }
}

impl CalcView {
    /// The encoder would take it.
    pub(super) fn usable(&self) -> bool {
        self.usable
    }

    /// The values to program, in the order of the sequence.
    pub(super) fn values(&self) -> impl Iterator<Item = &ValueView> {
        [Some(&self.measuring_length), self.numerator.as_ref(), self.denominator.as_ref()]
            .into_iter()
            .flatten()
    }

    pub(super) fn linear(length_mm: Ratio, resolution_mm: Ratio, found: Linear) -> Self {
        let largest = found.scaling.measuring_length();
        let mut notes = vec![note(
            "range",
            format!(
                "positions 0..{largest} over {} mm, {} mm a step",
                show(length_mm),
                show(found.resolution)
            ),
        )];
        if !found.steps.is_whole() {
            notes.push(note(
                "rounded",
                format!(
                    "{} mm in steps of {} mm would be {} steps; {largest} is the nearest whole number",
                    show(length_mm),
                    show(resolution_mm),
                    show(found.steps)
                ),
            ));
        }
        notes.push(note("active", "with the reply to service 02; service 08 shows errors and clears them"));
        notes.push(note(
            "preset",
            "the stored preset stays as so many steps, which now is another place: the position will be \
             elsewhere. Make a preset adjustment (service 06) at the end. Preset value 1 (service 04) keeps its \
             number too.",
        ));
        Self {
            encoder: "linear",
            models: vec![Model::La66.name()],
            native: None,
            usable: true,
            measuring_length: ValueView::length(largest),
            numerator: None,
            denominator: None,
            fraction: None,
            steps: StepsView {
                wanted: number(found.steps),
                exact: found.steps.is_whole(),
                steps_per_turn: None,
                resolution_mm: Some(number(found.resolution)),
            },
            too_large: None,
            zero: None,
            gray_wrap_bits: None,
            notes,
            sequence: found.scaling.sequence().map(StepView::new).collect(),
        }
    }

    pub(super) fn rotary(asked: &Asked) -> Self {
        let Asked { found, native, .. } = *asked;
        let scaling = found.scaling;
        let fraction = scaling.fraction;
        let too_large = scaling.too_large(native);
        let models = asked.models();
        let gray = models.contains(&Model::Ce65M);
        let zero = match scaling.zero_risk() {
            ZeroRisk::Safe => ZeroView { safe: true, shift_turns: 0.0, shift_steps: 0.0 },
            ZeroRisk::Shift { turns, steps } => {
                ZeroView { safe: false, shift_turns: number(turns), shift_steps: number(steps) }
            }
        };
        Self {
            encoder: "rotary",
            notes: asked.notes(),
            native: Some(native.steps_per_turn()),
            usable: too_large.is_none(),
            measuring_length: ValueView::length(scaling.measuring_length()),
            numerator: Some(ValueView::numerator(fraction)),
            denominator: Some(ValueView::denominator(fraction)),
            fraction: Some(FractionView {
                choice: match found.chosen.choice {
                    Choice::AsGiven => "as_given",
                    Choice::Whole => "whole",
                    Choice::DecimalPlace => "decimal_place",
                    Choice::Reduced => "reduced",
                    Choice::Nearest => "nearest",
                },
                turns: number(fraction.turns()),
                off_turns: signed(found.chosen.off),
                off_ppm: signed(found.chosen.off_ppm()),
                off_steps: signed(found.steps_off()),
            }),
            steps: StepsView {
                wanted: number(found.positions),
                exact: found.positions.is_whole(),
                steps_per_turn: Some(number(scaling.steps_per_turn())),
                resolution_mm: asked.resolution_mm().map(number),
            },
            zero: Some(zero),
            gray_wrap_bits: gray.then(|| scaling.gray_wrap_bits()),
            sequence: match too_large {
                None => scaling.sequence().map(StepView::new).collect(),
                // Nobody shall type what will be refused.
                Some(_) => Vec::new(),
            },
            too_large: too_large.map(|instead| TooLargeView {
                smallest_fraction: PairView {
                    numerator: ValueView::numerator(instead.smallest_fraction),
                    denominator: ValueView::denominator(instead.smallest_fraction),
                },
                largest_measuring_length: ValueView::length(instead.largest_measuring_length),
            }),
            models: models.into_iter().map(Model::name).collect(),
        }
    }
}

impl Asked {
    fn models(&self) -> Vec<Model> {
        match (self.model, self.native) {
            (Some(model), _) => vec![model],
            (None, Native::Q8192) => vec![Model::Ce65M],
            (None, Native::Q4096) => vec![Model::Ce100M, Model::Ce65M],
        }
    }

    /// What a step really is.
    fn resolution_mm(&self) -> Option<Ratio> {
        self.mm_per_turn?.over(self.found.scaling.steps_per_turn())
    }

    fn notes(&self) -> Vec<Note> {
        let mut notes = vec![self.turns_note(), self.range_note()];
        let (found, scaling) = (&self.found, self.found.scaling);
        if !found.positions.is_whole() {
            notes.push(note(
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
            ZeroRisk::Safe => {
                note("zero", "safe: moving the shaft without supply cannot shift the position with this N/D")
            }
            ZeroRisk::Shift { turns, steps } => note(
                "zero",
                format!(
                    "can be lost: after more than 512 turns without supply the position can come back wrong by \
                     {} ({}). Check it against a mark and make a preset adjustment.",
                    counted(steps, "step"),
                    counted(turns, "turn")
                ),
            ),
        });
        let bits = scaling.gray_wrap_bits();
        if bits != 1 && self.models().contains(&Model::Ce65M) {
            notes.push(note(
                "gray",
                format!(
                    "if a ce-65-m is set to Gray code, {bits} bits change at once between {} and 0: what is read \
                     just then can be anything. Use binary, or a number of positions that is a power of two.",
                    scaling.measuring_length()
                ),
            ));
        }
        if scaling.too_large(self.native).is_none() {
            self.preset_notes(&mut notes);
        }
        notes
    }

    fn turns_note(&self) -> Note {
        let chosen = &self.found.chosen;
        let (fraction, wanted) = (chosen.fraction, show(chosen.wanted));
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
                format!("{fraction}: {wanted} in lowest terms, so that N is at most 65535 and D at most 99")
            }
            Choice::Nearest => {
                let side = if matches!(chosen.off, Deviation::Below(_)) { "short" } else { "long" };
                format!(
                    "{fraction}: the nearest with N up to 65535 and D up to 99; {wanted} turns cannot be \
                     programmed. The range is too {side} by {} turns ({} ppm), that is {} steps; they add up with \
                     every pass if the machine keeps turning one way.",
                    magnitude(chosen.off),
                    magnitude(chosen.off_ppm()),
                    magnitude(self.found.steps_off()),
                )
            }
        };
        note("turns", text)
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
        let plate = self.native.steps_per_turn();
        let Some(instead) = scaling.too_large(self.native) else {
            notes
                .push(note("2^14", format!("kept: {steps} steps per turn, the rating plate allows {plate}")));
            return;
        };
        notes.push(note(
            "2^14",
            format!(
                "REFUSED: {steps} steps per turn, but the rating plate allows {plate}. The data check would answer \
                 A8004000 and take nothing over. Do not program this. What works:"
            ),
        ));
        let fraction = instead.smallest_fraction;
        let steps = Ratio::from(scaling.measuring_length() + 1);
        notes.push(note(
            "either",
            format!(
                "N = {} ({:X}h), D = {} ({:X}h), S as above: the smallest range for {} positions, {} turns. {}",
                fraction.numerator(),
                fraction.numerator(),
                fraction.denominator(),
                fraction.denominator(),
                scaling.measuring_length() + 1,
                show(fraction.turns()),
                self.command(steps, fraction),
            ),
        ));
        let length = instead.largest_measuring_length;
        notes.push(note(
            "or",
            format!(
                "S = {length} ({length:X}h), N and D as above: the most positions over {} turns. {}",
                show(scaling.fraction.turns()),
                self.command(Ratio::from(length + 1), scaling.fraction),
            ),
        ));
        let option = self.native == Native::Q4096 && self.model != Some(Model::Ce100M);
        if option && scaling.too_large(Native::Q8192).is_none() {
            notes.push(note("or", "a ce-65-m with 8192 steps per turn takes it as it is: --native 8192"));
        }
    }

    /// How to ask for the words of what works.
    fn command(&self, positions: Ratio, fraction: Fraction) -> String {
        let Some(steps_per_turn) = positions.over(fraction.turns()) else { return String::new() };
        let steps_per_turn = steps_per_turn.rounded(9, Rounding::Nearest);
        let native = if self.native == Native::Q8192 { " --native 8192" } else { "" };
        format!(
            "Its words: encoring calc rotary --steps-per-turn {steps_per_turn} --turns {fraction}{native}"
        )
    }

    fn preset_notes(&self, notes: &mut Vec<Note>) {
        let largest = self.found.scaling.measuring_length();
        notes.push(note(
            "preset",
            format!(
                "the stored preset stays, but belongs to the old values: the position will be elsewhere. Make a \
                 preset adjustment (service 06, at most {largest}) after the data check. Another D converts the \
                 stored preset, rounded down."
            ),
        ));
        if self.models().contains(&Model::Ce100M) {
            notes.push(note(
                "presets",
                format!(
                    "of a ce-100-m: preset value 1 or 2 (services 04, 05) above {largest} makes the data check \
                     refuse everything with 2^8 or 2^9. Read them (84000000, 85000000) and lower them first."
                ),
            ));
        }
    }
}
