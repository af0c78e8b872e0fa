//! The referee that looks on while our own master works.

use encoring_host::referee::ORDER;
use encoring_station::{RefereeView, Simulated};

/// What the referee says at the end; another one looks on from here. The handshake was kept, or it is told how not.
pub(crate) fn judged(ring: &mut Simulated) -> Result<RefereeView, String> {
    let judged = ring.judged().ok_or("nobody looked on")?;
    ring.look_on();
    match judged.findings.iter().find(|finding| ORDER.iter().any(|rule| rule.name() == finding.rule)) {
        None => Ok(judged),
        Some(finding) => Err(format!("{finding:?}")),
    }
}

/// There was something to judge, and nothing was found.
pub(crate) fn assert_blameless(ring: &mut Simulated) {
    let judged = judged(ring).unwrap();
    assert!(judged.services > 0 && judged.findings.is_empty(), "{judged:#?}");
}
