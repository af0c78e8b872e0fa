//! What every request can reach, and how much of it is read.

use std::sync::Arc;

use encoring_station::Controlled;
use tokio::sync::watch;
use tokio::time::Duration;

use crate::frames::Frames;

/// The longest body of a request: as long as a line of the control port.
pub(crate) const BODY_BYTES_MAX: usize = 64 * 1024;

/// What every request can reach.
#[derive(Clone)]
pub(crate) struct Shared {
    pub(crate) controlled: Controlled,
    pub(crate) frames: Arc<Frames>,
    pub(crate) hosts: Arc<[String]>,
    pub(crate) slow: Duration,
    pub(crate) stopped: watch::Receiver<()>,
}
