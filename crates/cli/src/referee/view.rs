//! What stands below the findings.

use std::fmt;

use encoring_bus::Referees;
use serde::Serialize;

/// What was seen, and what could not be judged.
#[derive(Serialize)]
pub(super) struct EndView {
    not_judged: Vec<&'static str>,
    seen_from: &'static str,
    #[serde(skip)]
    services: u64,
}

impl EndView {
    pub(super) fn new(referees: &Referees) -> Self {
        let not_judged = referees.not_judged().iter().map(|rule| rule.name()).collect();
        Self { not_judged, seen_from: referees.vantage().letter(), services: referees.services() }
    }
}

impl fmt::Display for EndView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { not_judged, seen_from, services } = self;
        match services {
            0 => writeln!(f, "no service was seen")?,
            1 => writeln!(f, "1 service was seen")?,
            services => writeln!(f, "{services} services were seen")?,
        }
        let names = if not_judged.is_empty() { "none".to_owned() } else { not_judged.join(", ") };
        write!(f, "not judged from here ({seen_from}): {names}")
    }
}
