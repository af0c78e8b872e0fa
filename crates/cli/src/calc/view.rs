//! What `calc` shows: plain data for programs. The text for people is made from the same.

use encoring_host::scaling::{
    Axis, Choice, Deviation, Expected, Fraction, HandshakeStep, HandshakeWord, Linear, LinearScaling,
    Proposal, Purpose, Ratio, Rounding, Shaft, ZeroRisk,
};
use encoring_words::model::{MODELS, SensorKind};
use encoring_words::{Model, Service};
use serde::Serialize;

use crate::calculation::{Advice, Asked, Note, linear_notes};
use crate::output::ratio::cut;

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
    pub(super) axis: Option<AxisView>,
    pub(super) sequence: Vec<StepView>,
}

/// What an axis can be programmed to.
#[derive(Serialize)]
pub(super) struct AxisView {
    travel_mm: f64,
    reserve_mm: f64,
    turns: Option<f64>,
    pub(super) proposals: Vec<ProposalView>,
}

#[derive(Serialize)]
pub(super) struct ProposalView {
    /// `travel`, `reserve` or `safe`.
    pub(super) purpose: &'static str,
    /// It is what the values are of.
    pub(super) taken: bool,
    numerator: u32,
    denominator: u32,
    measuring_length: u32,
    range_mm: f64,
    reserve_mm: f64,
    resolution_mm: f64,
    zero_safe: bool,
    /// The same for people.
    #[serde(skip)]
    pub(super) cells: [String; 5],
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
    smallest_fraction: Option<PairView>,
    largest_measuring_length: Option<ValueView>,
}

#[derive(Serialize)]
struct PairView {
    numerator: ValueView,
    denominator: ValueView,
}

#[derive(Serialize)]
pub(super) struct ZeroView {
    safe: bool,
    shift_turns: f64,
    shift_steps: f64,
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

/// A number for programs, to nine decimals.
#[expect(clippy::disallowed_methods, reason = "decimals that were just printed")]
pub(super) fn number(ratio: Ratio) -> f64 {
    ratio.rounded(9, Rounding::Nearest).to_string().parse().unwrap_or(0.0)
}

fn signed(deviation: Deviation) -> f64 {
    match deviation {
        Deviation::None => 0.0,
        Deviation::Below(off) => -number(off),
        Deviation::Above(off) => number(off),
    }
}

impl ZeroView {
    pub(super) fn of(risk: ZeroRisk) -> Self {
        match risk {
            ZeroRisk::Safe => Self { safe: true, shift_turns: 0.0, shift_steps: 0.0 },
            ZeroRisk::Shift { turns, steps } => {
                Self { safe: false, shift_turns: number(turns), shift_steps: number(steps) }
            }
        }
    }
}

impl AxisView {
    fn new(advice: &Advice, shaft: Shaft) -> Self {
        let Axis { travel, reserve, .. } = advice.axis;
        Self {
            travel_mm: number(travel),
            reserve_mm: number(reserve),
            turns: advice.axis.turns().map(number),
            proposals: advice.proposals(shaft).map(|proposal| ProposalView::new(proposal, advice)).collect(),
        }
    }
}

impl ProposalView {
    fn new(proposal: Proposal, advice: &Advice) -> Self {
        let Proposal { purpose, rotary, range } = proposal;
        let scaling = rotary.scaling;
        let beyond = match range.deviation_from(advice.axis.travel) {
            Deviation::Above(beyond) => beyond,
            _ => Ratio::from(0),
        };
        let resolution = advice.axis.per_turn.over(scaling.steps_per_turn()).unwrap_or(Ratio::from(0));
        let zero_safe = scaling.zero_risk() == ZeroRisk::Safe;
        let short = |ratio: Ratio| ratio.rounded(3, Rounding::Nearest).to_string();
        Self {
            purpose: match purpose {
                Purpose::Travel => "travel",
                Purpose::Reserve => "reserve",
                Purpose::Safe => "safe",
            },
            taken: purpose == advice.taken.purpose,
            numerator: scaling.fraction.numerator(),
            denominator: scaling.fraction.denominator(),
            measuring_length: scaling.measuring_length(),
            range_mm: number(range),
            reserve_mm: number(beyond),
            resolution_mm: number(resolution),
            zero_safe,
            cells: [
                scaling.fraction.to_string(),
                short(range),
                short(beyond),
                cut(resolution, Rounding::Nearest).to_string(),
                if zero_safe { "safe" } else { "can be lost" }.to_owned(),
            ],
        }
    }
}

impl ValueView {
    pub(super) fn new(service: Service, value: u32) -> Self {
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

    pub(super) fn linear(length_mm: Ratio, resolution_mm: Ratio, model: Model, found: Linear) -> Self {
        let largest = found.scaling.measuring_length();
        Self {
            encoder: "linear",
            models: MODELS
                .into_iter()
                .filter(|model| model.sensor_kind() == SensorKind::Linear)
                .filter(|model| LinearScaling::new(largest, *model).is_ok())
                .map(Model::name)
                .collect(),
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
            notes: linear_notes(length_mm, resolution_mm, model, &found),
            axis: None,
            sequence: found.scaling.sequence().map(StepView::new).collect(),
        }
    }

    pub(super) fn rotary(asked: &Asked) -> Self {
        let Asked { found, shaft, .. } = *asked;
        let scaling = found.scaling;
        let fraction = scaling.fraction;
        let too_large = scaling.too_large(shaft);
        let models = asked.models();
        let gray = models.iter().any(|model| model.position_may_be_gray());
        Self {
            encoder: "rotary",
            notes: asked.notes(),
            axis: asked.advice.as_ref().map(|advice| AxisView::new(advice, shaft)),
            native: Some(shaft.steps_per_turn()),
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
            zero: Some(ZeroView::of(scaling.zero_risk())),
            gray_wrap_bits: gray.then(|| scaling.gray_wrap_bits()),
            sequence: match too_large {
                None => scaling.sequence().map(StepView::new).collect(),
                // Nobody shall type what will be refused.
                Some(_) => Vec::new(),
            },
            too_large: too_large.map(|instead| TooLargeView {
                smallest_fraction: instead.smallest_fraction.map(|fraction| PairView {
                    numerator: ValueView::numerator(fraction),
                    denominator: ValueView::denominator(fraction),
                }),
                largest_measuring_length: instead.largest_measuring_length.map(ValueView::length),
            }),
            models: models.into_iter().map(Model::name).collect(),
        }
    }
}
