//! What the verbs can reach.

use std::sync::Arc;

use encoring_encoder::Unit;

use crate::station::Handle;

/// What the verbs can reach. Clones reach the same.
#[derive(Clone)]
pub struct Controlled {
    /// The ring.
    pub ring: Handle,
    /// Its encoders, by position.
    pub units: Arc<[Unit]>,
    /// The server that shows the ring to masters; `None` if there is none.
    pub gateway: Option<Arc<dyn Gateway>>,
}

/// A server that can be told to misbehave. What its faults are called is its own matter: they are passed on as text.
pub trait Gateway: Send + Sync {
    /// Begins a fault; its times count from now.
    ///
    /// # Errors
    /// What is wrong with the text, or why there can be no further fault.
    fn begin(&self, fault: &str) -> Result<(), String>;

    /// Ends a fault that was begun.
    ///
    /// # Errors
    /// If there is none of this text.
    fn end(&self, fault: &str) -> Result<(), String>;

    /// Ends every fault.
    fn end_all(&self);

    /// Those that are not over, in the order in which they were begun.
    fn faults(&self) -> Vec<String>;
}
