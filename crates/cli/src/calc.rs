//! `encoring calc`: what to program for a range, word by word.

mod text;
mod view;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum};
use encoring_host::scaling::{Native, Ratio, Rotary};
use encoring_words::Model;
use encoring_words::model::UnknownModel;

use crate::arguments::range::{LinearArguments, RotaryRange, linear_range, rotary_range};
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

fn linear_view(arguments: &LinearArguments) -> Result<CalcView, Failure> {
    let found = linear_range(arguments)?;
    Ok(CalcView::linear(arguments.length_mm, arguments.resolution_mm, found))
}
