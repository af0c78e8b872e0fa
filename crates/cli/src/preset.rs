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

/// Make the position a value, here and now (preset adjustment, service 06)
///
/// The old zero is gone afterwards, and nothing can read it back: write down what is shown at a mark first. A preset
/// adjustment that got no answer is never repeated. While an error is pending none is made: `encoring check` comes
/// first, and --yes is no consent to that.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes: 0 done; 1 refused, an error is pending, the answer was no, or another
master is at work; 2 bad usage; 3 no answer, or the position does not show it:
whether it was done may not be known.

Examples:
  encoring preset 0 --bus sim --at 2
  encoring preset 5000 --bus modbus-tcp://192.168.1.10 --at 0 --model la-66 --yes")]
pub(crate) struct Arguments {
    /// What the position shall be, in steps
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
