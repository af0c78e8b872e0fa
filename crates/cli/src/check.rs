//! `encoring check`: the data check, and what its status means.

use std::fmt;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::Services;
use encoring_host::preset::code;
use encoring_host::service::{Check, check};
use encoring_workshop::reading::read_each;
use encoring_workshop::values::parameters_of;
use serde::Serialize;

use crate::arguments::bus::{Encoder, Target};
use crate::arguments::{Consent, Output};
use crate::bus::Deed;
use crate::dialog::{CHECK_DOES, Dialog};
use crate::noted::{JournalFolder, Noted};
use crate::output::{Answer, Failure};
use crate::told::{Failed, Shown, StatusView, TargetView};

/// Run the data check (service 08): show the pending error, and end it if its cause is gone
///
/// The data check also makes values count that were programmed and never checked: the position may jump. On an LA-66
/// service 08 only returns the error status and clears it.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  no error
  1  an error is or was pending; not confirmed; or another master is at work
  2  wrong usage
  3  no answer

Examples:
  encoring check --bus sim --at 2 --yes
  encoring check --bus modbus-tcp://192.168.1.10 --at 2 --model ce-65-m")]
pub(crate) struct Arguments {
    #[command(flatten)]
    encoder: Encoder,
    #[command(flatten)]
    consent: Consent,
    #[command(flatten)]
    journal: JournalFolder,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct CheckView {
    #[serde(flatten)]
    target: TargetView,
    #[serde(flatten)]
    status: StatusView,
    before: Shown,
    after: Shown,
    #[serde(skip)]
    check: Check,
}

impl fmt::Display for CheckView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.target)?;
        writeln!(f, "{}", self.status)?;
        writeln!(
            f,
            "{}",
            match (self.check.is_good(), self.check.remains) {
                (true, _) if self.before.error_bit =>
                    "an error was pending and is over; the status does not tell which",
                (true, _) => "no error is or was pending",
                (false, false) => "this error was pending and is over",
                (false, true) => "this error remains until it is corrected",
            }
        )?;
        writeln!(f, "position before: {}", self.before)?;
        writeln!(f, "position now:    {}", self.after)
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    arguments.encoder.ring.writing("check")?;
    let (mut opened, target) = arguments.encoder.open_to_change()?;
    opened.announce(target, Deed::Changes);
    Dialog::at_terminal(arguments.consent)
        .confirmed(&format!("{}: {CHECK_DOES}", TargetView::new(target)))?;
    let noted = arguments.journal.of(&opened, target.position);
    let told = opened.serve(target, |master| look_and_check(master, target, noted.as_ref()));
    opened.report(arguments.output, told, |view| {
        let pending = view.before.error_bit || view.after.error_bit;
        if view.check.is_good() && !pending { Answer::Yes } else { Answer::No }
    })
}

fn look_and_check<S: Services<Error = MasterError>>(
    services: &mut S,
    target: Target,
    noted: Option<&Noted>,
) -> Result<CheckView, Failed> {
    let before = services.look().map_err(Failed::Bus)?;
    let check = check(services)?;
    let after = services.look().map_err(Failed::Bus)?;
    if let Some(noted) = noted.filter(|noted| check.is_good() && noted.is_open())
        && let Ok(values) = read_each(services, target.model, parameters_of(target.model))
    {
        noted.checked(|parameter| values.iter().find(|read| read.parameter == parameter)?.value);
    }
    // What the check said must not be lost to a read that fails.
    let code = code(services, target.model).ok();
    Ok(CheckView {
        target: TargetView::new(target),
        status: StatusView::after(before, check, target.model),
        before: Shown::new(before, code),
        after: Shown::new(after, code),
        check,
    })
}
