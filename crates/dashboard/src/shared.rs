//! What every request can reach, and how much of it is read.

use std::net::IpAddr;
use std::sync::Arc;

use encoring_station::{Permission, ShownRing};
use tokio::sync::{Semaphore, watch};
use tokio::time::Duration;

use crate::access::Access;
use crate::frames::Frames;

/// The longest body of a request: as long as a line of the control port.
pub(crate) const BODY_BYTES_MAX: usize = 64 * 1024;

/// What every request can reach.
#[derive(Clone)]
pub(crate) struct Shared {
    pub(crate) ring: Arc<dyn ShownRing>,
    /// What a page may do.
    pub(crate) permission: Permission,
    pub(crate) access: Arc<Access>,
    pub(crate) frames: Arc<Frames>,
    pub(crate) hosts: Arc<[String]>,
    /// One recording at a time.
    pub(crate) diagnosing: Arc<Semaphore>,
    pub(crate) slow: Duration,
    pub(crate) stopped: watch::Receiver<()>,
}

/// Both ends of the connection that a request came over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    /// Who asks.
    pub(crate) peer: IpAddr,
    /// Under which address of this machine.
    pub(crate) here: IpAddr,
}
