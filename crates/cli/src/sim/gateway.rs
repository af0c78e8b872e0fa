//! How the Modbus server misbehaves: by the scenario, the command line and the control port.

use std::path::Path;
use std::sync::Arc;

use encoring_modbus::GatewayFaults;
use encoring_modbus::gateway_fault::{GatewayFault, GatewayFaultError};
use encoring_sim::Scenario;
use encoring_sim::scenario::GatewayFaultText;
use encoring_station::Gateway;

use crate::output::{Failure, bad_input};

/// The faults of the gateway, of the scenario and of the command line.
#[expect(clippy::disallowed_methods, reason = "a fault of a gateway")]
pub(super) fn faults(
    scenario: &Scenario,
    file: Option<&Path>,
    given: &[GatewayFault],
) -> Result<GatewayFaults, Failure> {
    let faults = GatewayFaults::default();
    for GatewayFaultText { line, fault } in &scenario.gateway_faults {
        let file = file.unwrap_or(Path::new("the built-in scenario")).display();
        let refused = |error| bad_input(format!("{file}, line {line}: {error}"));
        faults.add(fault.parse().map_err(refused)?).map_err(refused)?;
    }
    for fault in given {
        faults.add(*fault).map_err(|error| bad_input(format!("--gateway-fault {fault}: {error}")))?;
    }
    Ok(faults)
}

/// The same faults for the control port, which knows them as text.
pub(super) fn told(faults: GatewayFaults) -> Arc<dyn Gateway> {
    Arc::new(Told(faults))
}

struct Told(GatewayFaults);

#[expect(clippy::disallowed_methods, reason = "a fault of a gateway")]
impl Gateway for Told {
    fn begin(&self, fault: &str) -> Result<(), String> {
        let begin = |fault: &str| self.0.add(fault.parse()?);
        begin(fault).map_err(|error: GatewayFaultError| error.to_string())
    }

    fn end(&self, fault: &str) -> Result<(), String> {
        let end = |fault: &str| self.0.end(fault.parse()?);
        end(fault).map_err(|error: GatewayFaultError| error.to_string())
    }

    fn end_all(&self) {
        self.0.clear();
    }

    fn faults(&self) -> Vec<String> {
        self.0.all().iter().map(GatewayFault::to_string).collect()
    }
}
