//! `encoring calc`: what to program for a range, word by word.

mod text;
mod view;

use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum};
use encoring_host::scaling::{
    LengthOutside, Linear, Native, NumberError, Ratio, ResolutionOutside, Rotary, RotaryError, Rounding,
    Turns, TurnsOutside, linear, rotary,
};
use encoring_words::model::UnknownModel;
use encoring_words::{Model, Parameter};

use crate::output::{Answer, Failure, Format, bad_input, print};
use view::CalcView;

/// Calculate what to program for a range, and the words that do it
#[derive(Args, Debug)]
#[command(after_help = "\
Exit code 0: the words can be used as they are; 1: the encoder would refuse the
values (2^14), and what works instead is shown; 2: bad input.

Examples:
  encoring calc rotary --steps-per-turn 1000 --turns 3.5
  encoring calc rotary --mm-per-turn 5 --resolution-mm 0.01 --turns 7/2
  encoring calc linear --length-mm 500 --resolution-mm 0.01")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    encoder: Encoder,

    /// Text for people, or one JSON object for programs (docs/json.md)
    #[arg(long, default_value = "text", global = true)]
    format: Format,
}

#[derive(Subcommand, Debug)]
enum Encoder {
    Rotary(RotaryArguments),
    Linear(LinearArguments),
}

/// What is to be programmed, as a range.
#[derive(Subcommand, Debug)]
pub(crate) enum Range {
    /// For a shaft: the measuring length, numerator and denominator of this range, as `calc rotary` finds them
    Rotary(RotaryRange),
    /// For a rod: the measuring length of this resolution, as `calc linear` finds it
    Linear(LinearArguments),
}

/// For a shaft: services 02, 03 and 09 of a CE-100-M or CE-65-M
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  encoring calc rotary --steps-per-turn 1000 --turns 3.5
  encoring calc rotary --mm-per-turn 5 --resolution-mm 0.01 --turns 7/2
  encoring calc rotary --steps-per-turn 8192 --turns 2048 --native 8192 --model ce-65-m")]
struct RotaryArguments {
    #[command(flatten)]
    range: RotaryRange,

    /// Steps per turn on the rating plate
    #[arg(long, default_value = "4096")]
    native: NativeOption,

    /// Leave out what concerns only the other model
    #[arg(long, value_parser = rotary_model())]
    model: Option<Model>,
}

/// A range of a shaft
#[derive(Args, Debug)]
pub(crate) struct RotaryRange {
    /// Steps that one turn of the shaft shall count
    #[arg(long, value_name = "STEPS", value_parser = number, allow_hyphen_values = true,
          required_unless_present = "mm_per_turn", conflicts_with_all = ["mm_per_turn", "resolution_mm"])]
    steps_per_turn: Option<Ratio>,

    /// Instead of the steps: how far the machine moves in one turn of the shaft
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true,
          requires = "resolution_mm")]
    mm_per_turn: Option<Ratio>,

    /// With --mm-per-turn: what one step shall be
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true,
          requires = "mm_per_turn")]
    resolution_mm: Option<Ratio>,

    /// Turns until the position begins again at 0: a decimal or a fraction
    #[arg(long, value_name = "TURNS", value_parser = turns, allow_hyphen_values = true)]
    turns: Turns,
}

/// For a rod: service 02 of an LA-66
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  encoring calc linear --length-mm 500 --resolution-mm 0.01")]
pub(crate) struct LinearArguments {
    /// Length of the rod on the type label
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    length_mm: Ratio,

    /// What one step shall be
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    resolution_mm: Ratio,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NativeOption {
    #[value(name = "4096")]
    Q4096,
    /// An option of the CE-65-M
    #[value(name = "8192")]
    Q8192,
}

fn rotary_model() -> impl TypedValueParser<Value = Model> {
    PossibleValuesParser::new([Model::Ce100M, Model::Ce65M].map(Model::name))
        .try_map(|name| -> Result<Model, UnknownModel> { name.parse() })
}

/// A number above 0.
fn number(text: &str) -> Result<Ratio, String> {
    parse(text, "like 12 or 0.01, above 0")
}

/// A number of turns.
fn turns(text: &str) -> Result<Turns, String> {
    parse(text, "like 3.5 or 7/2, from 1/99 to 65535")
}

fn parse<T: FromStr<Err = NumberError>>(text: &str, allowed: &str) -> Result<T, String> {
    text.parse().map_err(|error| {
        let pointed: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let pointed = pointed.replacen(',', ".", 1);
        match error {
            NumberError::Comma if pointed.parse::<T>().is_ok() => {
                format!("write the decimals behind a point: {pointed}")
            }
            error => format!("{error}; allowed is a number {allowed}"),
        }
    })
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let view = match &arguments.encoder {
        Encoder::Rotary(rotary) => rotary_view(rotary)?,
        Encoder::Linear(linear) => linear_view(linear)?,
    };
    print(arguments.format, &view)?;
    Ok(if view.usable() { Answer::Yes } else { Answer::No })
}

/// A rotary calculation with what was asked for.
struct Asked {
    steps_per_turn: Ratio,
    /// If the steps were given as millimetres.
    mm_per_turn: Option<Ratio>,
    native: Native,
    model: Option<Model>,
    found: Rotary,
}

fn rotary_view(arguments: &RotaryArguments) -> Result<CalcView, Failure> {
    let native = match arguments.native {
        NativeOption::Q4096 => Native::Q4096,
        NativeOption::Q8192 => Native::Q8192,
    };
    if native == Native::Q8192 && arguments.model == Some(Model::Ce100M) {
        return Err(bad_input("--native 8192 is an option of the ce-65-m; a ce-100-m has --native 4096"));
    }
    let (steps_per_turn, found) = rotary_range(&arguments.range, native)?;
    Ok(CalcView::rotary(&Asked {
        steps_per_turn,
        mm_per_turn: arguments.range.mm_per_turn,
        native,
        model: arguments.model,
        found,
    }))
}

fn rotary_range(range: &RotaryRange, native: Native) -> Result<(Ratio, Rotary), Failure> {
    let steps_per_turn = match (range.steps_per_turn, range.mm_per_turn, range.resolution_mm) {
        (Some(steps), ..) => Some(steps),
        (None, Some(mm), Some(resolution)) => mm.over(resolution),
        // The arguments exclude each other and need each other.
        _ => None,
    };
    let Some(steps_per_turn) = steps_per_turn else {
        return Err(bad_input(
            "--mm-per-turn and --resolution-mm have too many digits to be divided exactly",
        ));
    };
    let found = rotary(steps_per_turn, range.turns, native).map_err(|error| match error {
        RotaryError::Turns(outside) => bad_input(turns_outside(range.turns, outside)),
        RotaryError::Length(outside) => {
            bad_input(length_outside(steps_per_turn, range.turns, range.mm_per_turn, outside))
        }
    })?;
    Ok((steps_per_turn, found))
}

/// The values of a range.
pub(crate) fn values(range: &Range, steps_per_turn: u32) -> Result<Vec<(Parameter, u32)>, Failure> {
    match range {
        Range::Rotary(range) => {
            let native = if steps_per_turn == 8192 { Native::Q8192 } else { Native::Q4096 };
            let (_, found) = rotary_range(range, native)?;
            Ok(vec![
                (Parameter::MeasuringLength, found.scaling.measuring_length()),
                (Parameter::Numerator, found.scaling.fraction.numerator()),
                (Parameter::Denominator, found.scaling.fraction.denominator()),
            ])
        }
        Range::Linear(arguments) => {
            let found = linear_range(arguments)?;
            Ok(vec![(Parameter::MeasuringLength, found.scaling.measuring_length())])
        }
    }
}

fn turns_outside(given: Turns, outside: TurnsOutside) -> String {
    let nearest = match outside.nearest {
        fraction if fraction.denominator() == 1 => fraction.numerator().to_string(),
        fraction => fraction.to_string(),
    };
    let given = view::show(given.value());
    format!("{given} turns are outside 1/99..65535; nearest that works: --turns {nearest}")
}

fn length_outside(
    steps_per_turn: Ratio,
    turns: Turns,
    mm_per_turn: Option<Ratio>,
    outside: LengthOutside,
) -> String {
    let more = outside.nearest > steps_per_turn;
    let (inside, outwards) =
        if more { (Rounding::Up, Rounding::Down) } else { (Rounding::Down, Rounding::Up) };
    let steps = format!("--steps-per-turn {}", view::cut(outside.nearest, inside));
    let resolution = mm_per_turn.and_then(|mm| mm.over(outside.nearest));
    let resolution = resolution.map(|resolution| view::cut(resolution, outwards));
    let mut nearest = match resolution {
        Some(resolution) if !resolution.is_zero() => format!("--resolution-mm {resolution}"),
        _ => steps,
    };
    if let Some(turns) = outside.nearest_turns {
        nearest.push_str(&format!(", or --turns {}", turns.numerator()));
    }
    format!(
        "{} steps per turn over {} turns are {} positions; allowed are 17..16777216 \
         (measuring length 10h..FFFFFFh); nearest that works: {nearest}",
        view::show(steps_per_turn),
        view::show(turns.value()),
        view::show(outside.positions),
    )
}

fn linear_view(arguments: &LinearArguments) -> Result<CalcView, Failure> {
    let found = linear_range(arguments)?;
    Ok(CalcView::linear(arguments.length_mm, arguments.resolution_mm, found))
}

fn linear_range(arguments: &LinearArguments) -> Result<Linear, Failure> {
    let (length, resolution) = (arguments.length_mm, arguments.resolution_mm);
    linear(length, resolution).map_err(|ResolutionOutside { steps, nearest }| {
        bad_input(format!(
            "{} mm in steps of {} mm are {} steps; allowed are 1..16777215 (FFFFFFh); nearest that works: \
             --resolution-mm {}",
            view::show(length),
            view::show(resolution),
            view::show(steps),
            view::cut(nearest, Rounding::Up),
        ))
    })
}
