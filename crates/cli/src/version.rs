//! What `encoring --version` says, which tells one build from another in a report of a fault.

/// The version, the commit, the machine that it was built for, and what is built in. No part can be left out of a build,
/// so there are no features to name.
pub(crate) const LONG: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\ncommit ",
    env!("ENCORING_COMMIT"),
    "\nbuilt for ",
    env!("ENCORING_TARGET"),
    "\nfeatures: all (no part can be left out)"
);
