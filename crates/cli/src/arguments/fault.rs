//! Faults beside what a scenario has.

use clap::Args;
use encoring_modbus::gateway_fault::{FORMS, MAX_FORM};
use encoring_sim::{Fault, Occurrence, Scenario};

use crate::output::{Failure, bad_input};

/// Faults beside those of the scenario.
#[derive(Args, Debug, Clone)]
pub(crate) struct Faults {
    /// Add a fault to a simulated ring (repeatable; `encoring sim --help` lists the kinds)
    #[arg(long = "fault", value_name = "FAULT")]
    pub(crate) faults: Vec<Occurrence>,
}

/// What can be written, as the help shows it.
pub(crate) fn help() -> String {
    let kinds = |are: fn(Fault) -> bool| -> String {
        let lines = Fault::kinds()
            .filter(|(fault, ..)| are(*fault))
            .map(|(_, form, meaning)| format!("\n    {form:<12} {meaning}"));
        lines.collect()
    };
    format!(
        "Faults: KIND[=VALUE][:PLACE][@TIME][+TIME]. @TIME is when it starts [default: 0], +TIME how\n\
         long it lasts [default: to the end].\n  \
         on segment PLACE (0 leads to the first encoder, the last one back to the master):{}\n  \
         at the encoder at position PLACE:{}\n  \
         on the SSI of the encoder at position PLACE:{}",
        kinds(Fault::is_of_line),
        kinds(|fault| !fault.is_of_line() && fault.on_ssi().is_none()),
        kinds(|fault| fault.on_ssi().is_some())
    )
}

/// The same for the faults of a gateway.
pub(crate) fn gateway_help() -> String {
    let kinds: String = FORMS
        .iter()
        .chain([&MAX_FORM])
        .map(|(form, meaning)| format!("\n    {form:<13} {meaning}"))
        .collect();
    format!(
        "\n\nGateway faults: KIND[=VALUE][#N][@TIME][+TIME], with the times of the faults above.\n\
         With #N only request N has the fault, counted from 1 over all connections:{kinds}"
    )
}

/// Adds faults to a scenario, in their order of time and behind what it has at the same time.
pub(crate) fn add(faults: &Faults, scenario: &mut Scenario) -> Result<(), Failure> {
    faults.faults.iter().try_for_each(|fault| {
        scenario.add(fault).map_err(|problem| bad_input(format!("--fault {fault}: {problem}")))
    })
}
