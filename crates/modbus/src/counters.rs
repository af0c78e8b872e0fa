//! What a server has seen, for whoever wants to show it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts of a running server. They are independent of each other: a snapshot is no moment in time.
#[derive(Debug, Default)]
pub struct ServerCounts {
    pub(crate) requests: Counter,
    pub(crate) exceptions: Counter,
    pub(crate) closed_bad_frames: Counter,
    pub(crate) closed_idle: Counter,
    pub(crate) refused_connections: Counter,
    pub(crate) accept_errors: Counter,
    pub(crate) open_connections: Counter,
}

/// [`ServerCounts`] as plain numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// Requests that were carried out or answered with an exception.
    pub requests: u64,
    /// Those of them that were answered with an exception.
    pub exceptions: u64,
    /// Connections closed because what came was not Modbus.
    pub closed_bad_frames: u64,
    /// Connections closed because no whole request came in time, or an answer was not taken.
    pub closed_idle: u64,
    /// Connections closed at once because there were as many as allowed.
    pub refused_connections: u64,
    /// Connections that the operating system could not hand over.
    pub accept_errors: u64,
    /// Connections that are open.
    pub open_connections: u64,
}

impl ServerCounts {
    /// The numbers as they are.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            requests: self.requests.get(),
            exceptions: self.exceptions.get(),
            closed_bad_frames: self.closed_bad_frames.get(),
            closed_idle: self.closed_idle.get(),
            refused_connections: self.refused_connections.get(),
            accept_errors: self.accept_errors.get(),
            open_connections: self.open_connections.get(),
        }
    }
}

#[derive(Debug, Default)]
pub(crate) struct Counter(AtomicU64);

impl Counter {
    pub(crate) fn add_one(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts a connection as open until it is dropped, however its task ends.
pub(crate) struct Open(Arc<ServerCounts>);

impl Open {
    pub(crate) fn new(counters: Arc<ServerCounts>) -> Self {
        counters.open_connections.add_one();
        Self(counters)
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        self.0.open_connections.0.fetch_sub(1, Ordering::Relaxed);
    }
}
