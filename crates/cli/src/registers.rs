//! The master's diagnostic registers in words, for `scan` and `decode --master`.

use std::fmt;

use encoring_ring::diagnostics::{DiagnosticParameter, names};
use serde::Serialize;

/// Status register and parameter register.
#[derive(Serialize)]
pub(crate) struct RegistersView {
    status_hex: String,
    status: Vec<&'static str>,
    parameter_hex: String,
    parameter: String,
}

impl RegistersView {
    pub(crate) fn new(status: u16, parameter: u16) -> Self {
        Self {
            status_hex: format!("{status:04X}"),
            status: names(status).collect(),
            parameter_hex: format!("{parameter:04X}"),
            parameter: DiagnosticParameter(parameter).to_string(),
        }
    }
}

impl fmt::Display for RegistersView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "status     {}  {}", self.status_hex, self.status.join(", "))?;
        writeln!(f, "parameter  {}  {}", self.parameter_hex, self.parameter)
    }
}
