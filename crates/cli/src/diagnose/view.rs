//! What was found, on a terminal.

use std::fmt;

use encoring_diagnosis::DiagnosisReport;
use serde::Serialize;

use crate::output::wrap::wrapped;

/// The report with its long lines broken.
#[derive(Serialize)]
#[serde(transparent)]
pub(super) struct ReportView(pub(super) DiagnosisReport);

impl fmt::Display for ReportView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&wrapped(&self.0.to_string(), 2))
    }
}
