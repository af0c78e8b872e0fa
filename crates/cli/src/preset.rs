//! `encoring preset`: the position shall be this value, here and now.

use std::fmt;

use clap::Args;
use encoring_host::preset::Preset;
use encoring_host::service::Failure as ServiceFailure;
use encoring_host::session::Fate;
use serde::Serialize;

use crate::arguments;
use crate::ask::confirmed;
use crate::bus::Encoder;
use crate::output::{Answer, Failure, Format, bad_input, print};
use crate::told::{Failed, FailureView, TargetView};

/// Make the position a value, here and now (preset adjustment, service 06)
///
/// The old zero is gone afterwards, and nothing can read it back: write down what is shown at a mark first. A preset
/// adjustment that got no answer is never repeated.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes: 0 done; 1 refused, not confirmed, or another master is at work;
2 bad usage; 3 no answer: whether it was done may not be known.

Examples:
  encoring preset 0 --bus sim --at 2
  encoring preset 5000 --bus modbus-tcp://192.168.1.10 --at 0 --model la-66 --yes")]
pub(crate) struct Arguments {
    /// What the position shall be, in steps
    #[arg(value_parser = arguments::value)]
    value: u32,
    #[command(flatten)]
    encoder: Encoder,
    /// Do not ask
    #[arg(long)]
    yes: bool,
    /// Text for people, or one JSON object for programs (docs/json.md)
    #[arg(long, default_value = "text")]
    format: Format,
}

#[derive(Serialize)]
struct PresetView {
    #[serde(flatten)]
    target: TargetView,
    wanted: u32,
    /// In steps.
    before: Option<u32>,
    after: Option<u32>,
    done: bool,
    failure: Option<FailureView>,
    text: Vec<String>,
}

impl fmt::Display for PresetView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown =
            |position: Option<u32>| position.map_or_else(|| "not seen".to_owned(), |steps| steps.to_string());
        writeln!(f, "{}", self.target)?;
        writeln!(f, "position before: {}", shown(self.before))?;
        if let Some(failure) = &self.failure {
            writeln!(f, "{failure}")?;
        }
        writeln!(f, "position now:    {}", shown(self.after))?;
        self.text.iter().try_for_each(|line| writeln!(f, "{line}"))
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    arguments.encoder.ring.writing("preset")?;
    let (mut opened, target) = arguments.encoder.open()?;
    let model = target.model;
    let (value, patience) = (arguments.value, arguments.encoder.patience);
    let told = (|| -> Result<Result<PresetView, FailureView>, Failure> {
        let mut master = match opened.master(target.position, patience) {
            Ok(master) => master,
            Err(error) => return Ok(Err(FailureView::new(Failed::Bus(error), model, None))),
        };
        let preset = match Preset::prepare(&mut master, model, value) {
            Ok(preset) => preset,
            Err(failed) => return Ok(Err(FailureView::new(failed, model, master.last_error()))),
        };
        let Some(shown) = preset.before() else {
            return Err(bad_input("the encoder shows no position"));
        };
        let pending = if preset.error_pending() { " An error is pending: see `encoring check`." } else { "" };
        confirmed(
            arguments.yes,
            &format!(
                "{}: the position is {shown} now and shall be {value}. The old zero cannot be read back.{pending}",
                TargetView::new(target)
            ),
        )?;
        let report = preset.adjust(&mut master);
        let mut text = Vec::new();
        match report.result {
            Ok(()) if report.after == Some(value) => text.push("done".to_owned()),
            Ok(()) => text.push(format!(
                "done: the encoder acknowledged it; the position is no longer {value}, so the shaft or magnet moves"
            )),
            Err(failed) => {
                text.push("not repeated: a second preset adjustment could set another zero".to_owned());
                let unknown = match failed {
                    ServiceFailure::TimedOut { timed_out, .. } => timed_out.fate == Fate::Unknown,
                    ServiceFailure::GivenUp { given_up, .. } => given_up.fate == Fate::Unknown,
                    _ => false,
                };
                if unknown {
                    text.push(match (report.before, report.after) {
                        (Some(before), Some(after)) if after == value && before != value => {
                            "the position is what was asked for, so it seems to be done".to_owned()
                        }
                        (Some(before), Some(after)) if after == before => {
                            "the position has not changed, so it seems not to be done".to_owned()
                        }
                        _ => "compare the position with a mark on the machine".to_owned(),
                    });
                }
            }
        }
        Ok(Ok(PresetView {
            target: TargetView::new(target),
            wanted: value,
            before: report.before,
            after: report.after,
            done: report.result.is_ok(),
            failure: report.result.err().map(|failed| FailureView::new(failed, model, master.last_error())),
            text,
        }))
    })();
    opened.close()?;
    match told? {
        Ok(view) => {
            print(arguments.format, &view)?;
            Ok(view.failure.map_or(Answer::Yes, |failure| failure.answer()))
        }
        Err(failed) => Err(failed.into_failure()),
    }
}
