//! The process image, shared between the thread that cycles the ring and everyone who reads or writes it.

use std::sync::{Arc, Mutex, PoisonError};

use encoring_ring::ProcessImage;

/// A handle on the process image; clones lead to the same one.
#[derive(Clone, Debug)]
pub struct SharedImage(Arc<Mutex<ProcessImage>>);

impl SharedImage {
    /// Shares `image`.
    #[must_use]
    pub fn new(image: ProcessImage) -> Self {
        Self(Arc::new(Mutex::new(image)))
    }

    /// Looks at the image or changes it in one piece: no cycle of the ring runs meanwhile, so words that are
    /// written together are seen together.
    pub fn with<R>(&self, access: impl FnOnce(&mut ProcessImage) -> R) -> R {
        access(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
