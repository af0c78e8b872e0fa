//! How somebody acknowledges jumps while encoders are looked at: a key of the live view, or a signal.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Jumps that were acknowledged, and how that is done.
pub(crate) struct Acknowledging {
    /// Somebody has acknowledged those that are marked.
    mark: Arc<AtomicBool>,
    /// What to do, as it is told with a jump.
    pub(crate) how: String,
}

impl Acknowledging {
    /// By SIGUSR1, where there are signals.
    pub(crate) fn by_signal() -> io::Result<Self> {
        let mark = Arc::default();
        #[cfg(unix)]
        signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&mark))?;
        let how = if cfg!(unix) {
            format!("`kill -USR1 {}` acknowledges it", std::process::id())
        } else {
            "only the live view of `encoring watch` can acknowledge it".to_owned()
        };
        Ok(Self { mark, how })
    }

    /// What is to be set when it is done.
    pub(crate) fn mark(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.mark)
    }

    /// Whether somebody has done it since this was asked last.
    pub(crate) fn take(&self) -> bool {
        self.mark.swap(false, Ordering::Relaxed)
    }
}
