//! `encoring calc`: what to program for a range, word by word.

mod explain;
mod text;
mod view;

use clap::{Args, Subcommand};
use encoring_host::scaling::Shaft;
use encoring_words::Model;
use encoring_words::model::{MODELS, SensorKind};

use crate::arguments::range::{LinearArguments, RotaryRange, linear_range, rotary_range, shaft};
use crate::arguments::{Output, TypeLabel};
use crate::calculation::scaled;
use crate::output::{Answer, Failure, bad_input};
use view::CalcView;

/// Calculate what to program for a range, and the words that do it
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  the words can be used as they are
  1  the encoder would refuse the values (2^14); the output names values that work
  2  wrong input

Examples:
  encoring calc rotary --steps-per-turn 1000 --turns 3.5
  encoring calc rotary --mm-per-turn 5 --resolution-mm 0.01 --turns 7/2
  encoring calc rotary --travel-mm 50000 --mm-per-turn 3330
  encoring calc linear --length-mm 500 --resolution-mm 0.01
  encoring calc explain --length 9999 --numerator 10 --denominator 1")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    encoder: Encoder,

    #[command(flatten)]
    output: Output,
}

#[derive(Subcommand, Debug)]
enum Encoder {
    Rotary(RotaryArguments),
    Linear(LinearArguments),
    Explain(explain::Arguments),
}

/// Compute the values of a shaft: services 02, 03 and 09 of a CE-100-M or CE-65-M
///
/// The default of --native is 4096 here. With --model the output leaves out what concerns the other model only.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  the words can be used as they are
  1  the encoder would refuse the values (2^14); the output names values that work
  2  wrong input

Examples:
  encoring calc rotary --steps-per-turn 1000 --turns 3.5
  encoring calc rotary --mm-per-turn 5 --resolution-mm 0.01 --turns 7/2
  encoring calc rotary --travel-mm 50000 --mm-per-turn 3330        # a linear axis: finds the turns
  encoring calc rotary --steps-per-turn 8192 --turns 2048 --native 8192 --model ce-65-m")]
struct RotaryArguments {
    #[command(flatten)]
    label: TypeLabel,

    #[command(flatten)]
    range: RotaryRange,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let output = arguments.output;
    let usable = match &arguments.encoder {
        Encoder::Rotary(rotary) => printed(output, &rotary_view(rotary)?)?,
        Encoder::Linear(linear) => printed(output, &linear_view(linear)?)?,
        Encoder::Explain(values) => {
            let view = explain::view(values)?;
            output.print(&view)?;
            view.usable()
        }
    };
    Ok(if usable { Answer::Yes } else { Answer::No })
}

fn printed(output: Output, view: &CalcView) -> Result<bool, Failure> {
    output.print(view)?;
    Ok(view.usable())
}

/// The shaft that a type label describes.
fn shaft_of(label: TypeLabel) -> Result<Shaft, Failure> {
    let TypeLabel { model, native } = label;
    if let Some(model) = model.filter(|model| model.sensor_kind() == SensorKind::Linear) {
        return Err(bad_input(format!(
            "--model {model} is a rod and has no shaft; use `encoring calc linear`"
        )));
    }
    let built = |model: &Model| native.is_none_or(|native| model.steps_per_turn().contains(&native));
    let Some(of) = model.or_else(|| scaled().find(built)) else {
        return Err(bad_input("--native: no encoder that can be scaled has these steps per turn"));
    };
    shaft(of, native)
}

fn rotary_view(arguments: &RotaryArguments) -> Result<CalcView, Failure> {
    let shaft = shaft_of(arguments.label)?;
    Ok(CalcView::rotary(&rotary_range(&arguments.range, shaft, arguments.label.model)?))
}

/// The model with a rod.
fn rod() -> Result<Model, Failure> {
    let found = MODELS.into_iter().find(|model| model.sensor_kind() == SensorKind::Linear);
    found.ok_or_else(|| bad_input("there is no encoder with a rod"))
}

fn linear_view(arguments: &LinearArguments) -> Result<CalcView, Failure> {
    let model = rod()?;
    let found = linear_range(arguments, model)?;
    Ok(CalcView::linear(arguments.length_mm, arguments.resolution_mm, model, found))
}
