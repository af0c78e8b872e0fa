//! `encoring scan`: what is on the ring, as its master finds it.

use clap::Args;
use encoring_modbus::Client;
use encoring_modbus::address::Layout;
use encoring_modbus::place::DATA;
use encoring_ring::diagnostics::FaultPlace;
use encoring_sim::scan::scan;

use crate::arguments::Output;
use crate::arguments::bus::Address;
use crate::arguments::fault::{self, Faults};
use crate::bus::{gateway, simulated_ring};
use crate::interrupt::Interrupt;
use crate::output::{Answer, Failure, bad_input};

mod view;

use view::ScanView;

/// List the devices of a ring: identification, length, words, lamps, and where the ring ends
///
/// On a simulated ring it opens device by device with ID cycles, after what happens in the first cycle. An Inline coupler
/// is asked for its directory. A plain Modbus gateway has none. The command writes nothing to an encoder.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  the ring is as it is configured
  1  the ring ends early, or a device is another one
  2  wrong usage
  3  no answer, or the gateway has no directory

Examples:
  encoring scan --bus sim
  encoring scan --bus sim --fault jumper:1      # the ring ends behind position 1
  encoring scan --bus 'modbus-tcp://192.168.1.10?layout=inline' --format json")]
pub(crate) struct Arguments {
    #[command(flatten)]
    place: Address,
    #[command(flatten)]
    faults: Faults,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let address = arguments.place.get()?;
    if let Some(mut scenario) = simulated_ring(address)? {
        fault::add(&arguments.faults, &mut scenario)?;
        let found = scan(&scenario).map_err(bad_input)?;
        arguments.output.print(&ScanView::of_ring(address, &found))?;
        return Ok(match found.place {
            None if found.is_whole() => Answer::Yes,
            Some(FaultPlace::Nowhere) => Answer::Unknown,
            _ => Answer::No,
        });
    }
    if !arguments.faults.faults.is_empty() {
        return Err(bad_input("--fault works on a simulated ring only; leave it out"));
    }
    // Also where whoever started it has signals ignored, the second one ends it.
    let _interrupt = Interrupt::new()?;
    let mut client = Client::new(gateway(address)?)?;
    let place = client.address().way.to_string();
    let modules = client.modules().map_err(|error| Failure::NoAnswer(format!("{place}: {error}")))?;
    let Some((described, directory)) = modules else {
        let way = address.split_once('?').map_or(address, |(way, _)| way);
        return Err(Failure::NoAnswer(format!(
            "{address}: a gateway that shows plain registers does not tell what is on its ring; \
             `encoring probe {way}` looks for encoders in its registers, and an Inline coupler tells with \
             '{way}?layout=inline'"
        )));
    };
    let data = match client.address().layout {
        Layout::Inline { data } => data.first,
        Layout::Plain { .. } => DATA.first,
    };
    arguments.output.print(&ScanView::of_coupler(address, data, &described, &directory))?;
    Ok(Answer::Yes)
}
