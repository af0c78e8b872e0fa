//! A range of positions as a user says it, and the values that an encoder needs for it.

use std::str::FromStr;

use clap::{Args, Subcommand};
use encoring_host::RequestError;
use encoring_host::scaling::{
    Axis, DecimalError, LengthOutside, Linear, Ratio, ResolutionOutside, RotaryError, Rounding, Shaft, Turns,
    TurnsOutside, linear, rotary,
};
use encoring_words::change::ParameterChange;
use encoring_words::model::SensorKind;
use encoring_words::{Model, Parameter};

use crate::calculation::{Advice, Asked, Note, SCALING, linear_notes, usual_steps_per_turn};
use crate::output::ratio::{cut, show};
use crate::output::{Failure, bad_input};

/// What is to be programmed, as a range.
#[derive(Subcommand, Debug)]
pub(crate) enum Range {
    /// Program the range of a shaft, as `calc rotary` computes it
    #[command(after_help = "\
Exit codes: as of `encoring program`.

Examples:
  encoring program --bus sim --at 2 rotary --steps-per-turn 1000 --turns 3.5
  encoring program --bus sim --at 1 --dry-run rotary --mm-per-turn 3330 --travel-mm 50000")]
    Rotary(Box<RotaryRange>),
    /// Program the resolution of a rod, as `calc linear` computes it
    #[command(after_help = "\
Exit codes: as of `encoring program`.

Examples:
  encoring program --bus sim --at 0 linear --length-mm 500 --resolution-mm 0.1")]
    Linear(LinearArguments),
}

/// A range of a shaft
#[derive(Args, Debug)]
#[command(next_help_heading = "Range")]
pub(crate) struct RotaryRange {
    /// Steps in one turn of the shaft, a decimal or a fraction
    #[arg(long, value_name = "STEPS", value_parser = number, allow_hyphen_values = true,
          required_unless_present = "mm_per_turn", conflicts_with = "resolution_mm")]
    pub(crate) steps_per_turn: Option<Ratio>,

    /// In place of the steps: travel of the machine in one turn of the shaft, in mm
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    pub(crate) mm_per_turn: Option<Ratio>,

    /// Travel in one step, in mm; needs --mm-per-turn
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true,
          requires = "mm_per_turn")]
    pub(crate) resolution_mm: Option<Ratio>,

    /// Turns after which the position starts again at 0, such as 3.5, 7/2 or 50/3.33
    #[arg(long, value_name = "TURNS", value_parser = turns, allow_hyphen_values = true,
          required_unless_present = "travel_mm")]
    pub(crate) turns: Option<Turns>,

    /// In place of the turns: travel of a linear axis from end to end, in mm; needs --mm-per-turn
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true,
          requires = "mm_per_turn", conflicts_with = "turns")]
    pub(crate) travel_mm: Option<Ratio>,

    /// Range beyond the travel, in mm [default: 1/20 of the travel]
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true,
          requires = "travel_mm")]
    pub(crate) reserve_mm: Option<Ratio>,
}

/// Compute the value of a rod: service 02 of an LA-66
#[derive(Args, Debug)]
#[command(
    next_help_heading = "Range",
    after_help = "\
Exit codes:
  0  the words can be used as they are
  2  wrong input

Examples:
  encoring calc linear --length-mm 500 --resolution-mm 0.01
  encoring calc linear --length-mm 1500 --resolution-mm 0.1"
)]
pub(crate) struct LinearArguments {
    /// Length of the rod on the type label, in mm
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    pub(crate) length_mm: Ratio,

    /// Travel in one step, in mm
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    pub(crate) resolution_mm: Ratio,
}

/// A number above 0.
pub(crate) fn number(text: &str) -> Result<Ratio, String> {
    parse(text, "like 12 or 0.01, above 0")
}

/// A number of turns.
fn turns(text: &str) -> Result<Turns, String> {
    parse(text, "like 3.5, 7/2 or 50/3.33, above 0")
}

fn parse<T: FromStr<Err = DecimalError>>(text: &str, allowed: &str) -> Result<T, String> {
    T::from_str(text).map_err(|error| refusal(text, error, |pointed| T::from_str(pointed).err(), allowed))
}

/// Why a text is no decimal number. `read` reads what it would be with a point in place of the comma.
pub(crate) fn refusal(
    text: &str,
    error: DecimalError,
    read: impl Fn(&str) -> Option<DecimalError>,
    allowed: &str,
) -> String {
    let pointed: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let pointed = pointed.replace(',', ".");
    match (error, read(&pointed)) {
        (DecimalError::Comma, None) => format!("write the decimals behind a point: {pointed}"),
        (DecimalError::Comma, Some(error @ DecimalError::Thousands { .. }))
        | (error @ DecimalError::Thousands { .. }, _) => error.to_string(),
        (error, _) => format!("{error}; allowed is a number {allowed}"),
    }
}

/// The shaft of a model with these steps per turn, or with the usual ones.
pub(crate) fn shaft(model: Model, steps_per_turn: Option<u32>) -> Result<Shaft, Failure> {
    for service in SCALING {
        if !service.known_to(model) {
            return Err(bad_input(RequestError::Unknown { service, model }));
        }
    }
    let steps_per_turn = steps_per_turn.or(usual_steps_per_turn(Some(model))).unwrap_or_default();
    Shaft::new(model, steps_per_turn).map_err(|wrong| bad_input(format!("--native: {wrong}")))
}

pub(crate) fn rotary_range(
    range: &RotaryRange,
    shaft: Shaft,
    model: Option<Model>,
) -> Result<Asked, Failure> {
    let wanted = steps_per_turn(range)?;
    let axis = match (range.travel_mm, range.mm_per_turn) {
        (Some(travel), Some(per_turn)) => {
            let usual = Axis::new(travel, per_turn);
            Some(Axis { reserve: range.reserve_mm.unwrap_or(usual.reserve), ..usual })
        }
        _ => None,
    };
    let advice = axis.map(|axis| Advice::new(axis, wanted, shaft)).transpose().map_err(bad_input)?;
    let (steps_per_turn, turns) = match (&advice, wanted, range.turns) {
        (Some(advice), wanted, _) => (wanted.unwrap_or(advice.steps_per_turn()), advice.turns()),
        (None, Some(steps), Some(turns)) => (steps, turns),
        _ => return Err(bad_input("--mm-per-turn needs --resolution-mm, or --travel-mm for the finest")),
    };
    let found = rotary(steps_per_turn, turns, shaft).map_err(|error| match error {
        RotaryError::Turns(outside) => bad_input(turns_outside(turns, outside)),
        RotaryError::Length(outside) => {
            bad_input(length_outside(steps_per_turn, turns, range.mm_per_turn, outside))
        }
    })?;
    Ok(Asked { steps_per_turn, mm_per_turn: range.mm_per_turn, shaft, model, found, advice })
}

/// The steps per turn that a range asks for; `None` if as many as there can be.
fn steps_per_turn(range: &RotaryRange) -> Result<Option<Ratio>, Failure> {
    match (range.steps_per_turn, range.mm_per_turn, range.resolution_mm) {
        (Some(_), Some(_), _) if range.travel_mm.is_none() => Err(bad_input(
            "--steps-per-turn and --mm-per-turn are two ways to say the same: give one of them",
        )),
        (Some(steps), ..) => Ok(Some(steps)),
        (None, Some(mm), Some(resolution)) => match mm.over(resolution) {
            None => {
                Err(bad_input("--mm-per-turn and --resolution-mm have too many digits to be divided exactly"))
            }
            steps => Ok(steps),
        },
        _ => Ok(None),
    }
}

/// What shall be programmed.
#[derive(Default)]
pub(crate) struct Wanted {
    pub(crate) values: Vec<(Parameter, ParameterChange)>,
    /// What whoever programs it must know.
    pub(crate) warnings: Vec<Note>,
    /// The position that a preset shall make afterwards, if that is known before.
    pub(crate) zero: Option<u32>,
}

/// The values of a range for an encoder of a model. `steps_per_turn` are the most that it can have.
pub(crate) fn wanted(range: &Range, model: Model, steps_per_turn: Option<u32>) -> Result<Wanted, Failure> {
    let rod = model.sensor_kind() == SensorKind::Linear;
    let (values, notes) = match range {
        Range::Rotary(_) if rod => {
            return Err(bad_input(format!("rotary: a {model} is a rod, no shaft; its range is `linear`")));
        }
        Range::Linear(_) if !rod => {
            return Err(bad_input(format!("linear: a {model} is a shaft, no rod; its range is `rotary`")));
        }
        Range::Rotary(range) => {
            let shaft = shaft(model, steps_per_turn)?;
            let asked = rotary_range(range, shaft, Some(model))?;
            let scaling = asked.found.scaling;
            let values = vec![
                (Parameter::MeasuringLength, scaling.measuring_length().into()),
                (Parameter::Numerator, scaling.fraction.numerator().into()),
                (Parameter::Denominator, scaling.fraction.denominator().into()),
            ];
            (values, asked.notes())
        }
        Range::Linear(arguments) => {
            let found = linear_range(arguments, model)?;
            let values = vec![(Parameter::MeasuringLength, found.scaling.measuring_length().into())];
            (values, linear_notes(arguments.length_mm, arguments.resolution_mm, model, &found))
        }
    };
    Ok(Wanted { values, warnings: notes.into_iter().filter(Note::warns).collect(), zero: None })
}

fn turns_outside(given: Turns, outside: TurnsOutside) -> String {
    let nearest = match outside.nearest {
        fraction if fraction.denominator() == 1 => fraction.numerator().to_string(),
        fraction => fraction.to_string(),
    };
    let given = show(given.value());
    let (fewest, most) = (outside.fewest, outside.most.numerator());
    format!("{given} turns are outside {fewest}..{most}; nearest that works: --turns {nearest}")
}

fn length_outside(
    steps_per_turn: Ratio,
    turns: Turns,
    mm_per_turn: Option<Ratio>,
    outside: LengthOutside,
) -> String {
    let (low, high) = (outside.low, outside.high);
    let more = outside.nearest > steps_per_turn;
    let (inside, outwards) =
        if more { (Rounding::Up, Rounding::Down) } else { (Rounding::Down, Rounding::Up) };
    let steps = format!("--steps-per-turn {}", cut(outside.nearest, inside));
    let resolution = mm_per_turn.and_then(|mm| mm.over(outside.nearest));
    let resolution = resolution.map(|resolution| cut(resolution, outwards));
    let mut nearest = match resolution {
        Some(resolution) if !resolution.is_zero() => format!("--resolution-mm {resolution}"),
        _ => steps,
    };
    if let Some(turns) = outside.nearest_turns {
        nearest.push_str(&format!(", or --turns {}", turns.numerator()));
    }
    format!(
        "{} steps per turn over {} turns are {} positions; allowed are {}..{} \
         (measuring length {low:X}h..{high:X}h); nearest that works: {nearest}",
        show(steps_per_turn),
        show(turns.value()),
        show(outside.positions),
        low + 1,
        high + 1,
    )
}

pub(crate) fn linear_range(arguments: &LinearArguments, model: Model) -> Result<Linear, Failure> {
    let (length, resolution) = (arguments.length_mm, arguments.resolution_mm);
    linear(length, resolution, model).map_err(|ResolutionOutside { low, high, steps, nearest }| {
        bad_input(format!(
            "{} mm in steps of {} mm are {} steps; allowed are {low}..{high} ({high:X}h); nearest that works: \
             --resolution-mm {}",
            show(length),
            show(resolution),
            show(steps),
            cut(nearest, Rounding::Up),
        ))
    })
}
