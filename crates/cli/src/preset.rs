//! `encoring preset`: the position shall be this value, here and now.

use clap::Args;
use encoring_words::number::TypedValue;

use crate::arguments;
use crate::arguments::bus::Encoder;
use crate::arguments::{Consent, Output};
use crate::bus::Deed;
use crate::dialog::Dialog;
use crate::output::{Answer, Failure};
use crate::presetting::{PresetView, Presetting};

/// Set the position to a value (preset adjustment, service 06)
///
/// The old zero is lost, and no service can read it back. Note the position at a mark of the machine first. The command
/// never repeats a preset adjustment that got no answer. It makes none while an error is pending, even with --yes: run
/// `encoring check` first.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  done: the position shows the value
  1  refused, not confirmed, an error is pending, or another master is at work
  2  wrong usage
  3  no answer, or the position does not show the value; the report says what is known

Examples:
  encoring preset 0 --bus sim --at 2
  encoring preset 5000 --bus modbus-tcp://192.168.1.10 --at 0 --model la-66 --yes")]
pub(crate) struct Arguments {
    /// The new position in steps, 0 to the measuring length: decimal, or hexadecimal as 270Fh
    #[arg(value_parser = arguments::typed_value, allow_negative_numbers = true)]
    value: TypedValue,
    #[command(flatten)]
    encoder: Encoder,
    #[command(flatten)]
    consent: Consent,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    arguments.encoder.ring.writing("preset")?;
    let (mut opened, target) = arguments.encoder.open_to_change()?;
    opened.announce(target, Deed::Changes);
    let dialog = Dialog::at_terminal(arguments.consent);
    let presetting = Presetting { value: arguments.value, mark: None, dialog: &dialog };
    let told = presetting.adjust(&mut opened, target).map_err(Failure::from);
    opened.report(arguments.output, told, PresetView::answer)
}
