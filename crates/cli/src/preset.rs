//! `encoring preset`: the position shall be this value, here and now.

use std::fmt;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::preset::{Preset, PresetReport};
use encoring_host::service::Failure as ServiceFailure;
use encoring_host::session::Fate;
use serde::Serialize;

use crate::arguments;
use crate::arguments::bus::{Encoder, Target};
use crate::arguments::{Consent, Output};
use crate::ask::confirmed;
use crate::bus::Opened;
use crate::output::{Answer, Failure, bad_input};
use crate::told::{FailureView, TargetView};

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
    #[command(flatten)]
    consent: Consent,
    #[command(flatten)]
    output: Output,
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
    let told = arguments.adjust(&mut opened, target);
    opened.close()?;
    let view = told?;
    arguments.output.print(&view)?;
    Ok(view.failure.map_or(Answer::Yes, |failure| failure.answer()))
}

impl Arguments {
    fn adjust(&self, opened: &mut Opened, target: Target) -> Result<PresetView, Failure> {
        let patience = self.encoder.patience;
        let preset =
            opened.serve(target, patience, |master| Preset::prepare(master, target.model, self.value))?;
        let shown = preset.before().ok_or_else(|| bad_input("the encoder shows no position"))?;
        let pending = if preset.error_pending() { " An error is pending: see `encoring check`." } else { "" };
        confirmed(
            self.consent,
            &format!(
                "{}: the position is {shown} now and shall be {}. The old zero cannot be read back.{pending}",
                TargetView::new(target),
                self.value
            ),
        )?;
        opened.serve(target, patience, |master| {
            let report = preset.adjust(master);
            let failed = report.result.as_ref().err();
            let failure = failed.map(|failed| FailureView::new(failed, target.model, master.last_error()));
            Ok(PresetView {
                target: TargetView::new(target),
                wanted: self.value,
                before: report.before,
                after: report.after,
                done: report.result.is_ok(),
                failure,
                text: self.text(&report),
            })
        })
    }

    /// What the report comes to.
    fn text(&self, report: &PresetReport<MasterError>) -> Vec<String> {
        let Err(failed) = &report.result else {
            return vec![if report.after == Some(self.value) {
                "done".to_owned()
            } else {
                format!(
                    "done: the encoder acknowledged it; the position is no longer {}, so the shaft or magnet moves",
                    self.value
                )
            }];
        };
        let mut text = vec!["not repeated: a second preset adjustment could set another zero".to_owned()];
        let fate = match failed {
            ServiceFailure::TimedOut { timed_out, .. } => timed_out.fate,
            ServiceFailure::GivenUp { given_up, .. } => given_up.fate,
            _ => Fate::NotSent,
        };
        if fate == Fate::Unknown {
            let seems = match (report.before, report.after) {
                (Some(before), Some(after)) if after == self.value && before != after => {
                    "the position is what was asked for, so it seems to be done"
                }
                (Some(before), Some(after)) if after == before => {
                    "the position has not changed, so it seems not to be done"
                }
                _ => "compare the position with a mark on the machine",
            };
            text.push(seems.to_owned());
        }
        text
    }
}
