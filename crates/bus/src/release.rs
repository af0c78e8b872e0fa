//! Takes a service bit back that somebody left on OUT, so that the encoder shows its position again.
//!
//! Whoever did it may only be slow: a controller that still works with the encoder must not have its service withdrawn. So
//! OUT and the upper byte of IN are watched for a time first, and OUT is read again just before it is written.

use std::sync::atomic::{AtomicBool, Ordering};

use encoring_words::word::Out;
use encoring_words::{Duration, InWord, OutWord};

use crate::bus::{Bus, BusError, rounded};

/// For so long nothing may change before a service bit counts as left.
pub const STANDS_FOR: Duration = Duration::from_millis(2_000);

/// Between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Both words of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// OUT.
    pub out: OutWord,
    /// IN.
    pub input: InWord,
}

impl Standing {
    /// What both masters would change: all of OUT, and of IN what tells a reply.
    const fn same(self, other: Self) -> bool {
        self.out.0 == other.out.0 && self.input.0 >> 24 == other.input.0 >> 24
    }
}

/// Why a service bit was not taken back.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReleaseError {
    /// The bus cannot be read or written.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// A master is at work.
    #[error(
        "OUT was {} and IN {}, now OUT is {} and IN {}: a master works with this encoder, so its service bit was not \
         touched", .was.out, .was.input, .now.out, .now.input
    )]
    InUse {
        /// What stood there first.
        was: Standing,
        /// What stands there now.
        now: Standing,
    },
    /// The word without the service bit was written, and OUT still has it.
    #[error(
        "OUT still holds {out} after {}: another master writes it, or the gateway does not let it be written",
        rounded(*.within)
    )]
    Stays {
        /// OUT.
        out: OutWord,
        /// How long that was tried.
        within: Duration,
    },
    /// The user wants to stop.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// A service bit on one encoder's OUT, and how it is taken back.
#[derive(Debug)]
pub struct Release<'a, B: ?Sized> {
    bus: &'a mut B,
    position: usize,
    patience: Duration,
    stop: &'a AtomicBool,
}

impl<'a, B: Bus + ?Sized> Release<'a, B> {
    /// For the encoder at `position`. A bus that cannot be read is asked again until `patience` is over.
    pub const fn new(bus: &'a mut B, position: usize, patience: Duration, stop: &'a AtomicBool) -> Self {
        Self { bus, position, patience, stop }
    }

    /// Both words as they stand. Writes nothing.
    ///
    /// # Errors
    /// [`ReleaseError::Bus`], [`ReleaseError::Interrupted`].
    pub fn look(&mut self) -> Result<Standing, ReleaseError> {
        let since = self.bus.now();
        loop {
            let problem = match self.both() {
                Ok(standing) => return Ok(standing),
                Err(problem) => problem,
            };
            if self.stop.load(Ordering::Relaxed) {
                return Err(ReleaseError::Interrupted);
            }
            if self.bus.now().since(since) >= self.patience || matches!(problem, BusError::NoEncoder { .. }) {
                return Err(problem.into());
            }
            self.bus.wait(LOOK_EVERY);
        }
    }

    fn both(&mut self) -> Result<Standing, BusError> {
        let out = self.bus.out(self.position)?;
        let mut input = [InWord(0)];
        self.bus.cycle(None, self.position, &mut input)?;
        let [input] = input;
        Ok(Standing { out, input })
    }

    /// Watches both words for [`STANDS_FOR`]. Writes nothing.
    ///
    /// # Errors
    /// [`ReleaseError::InUse`] if one of them changed.
    pub fn watch(&mut self, was: Standing) -> Result<(), ReleaseError> {
        let since = self.bus.now();
        while self.bus.now().since(since) < STANDS_FOR {
            self.bus.wait(LOOK_EVERY);
            self.unchanged(was)?;
        }
        Ok(())
    }

    fn unchanged(&mut self, was: Standing) -> Result<(), ReleaseError> {
        let now = self.look()?;
        if was.same(now) { Ok(()) } else { Err(ReleaseError::InUse { was, now }) }
    }

    /// Takes the service bit back if nothing has changed up to now, and gives what stands there then. All other bits of
    /// OUT stay.
    ///
    /// # Errors
    /// [`ReleaseError`]; only [`ReleaseError::Stays`] and, if the bus failed after that, [`ReleaseError::Bus`] come
    /// after a write.
    pub fn clear(&mut self, was: Standing) -> Result<Standing, ReleaseError> {
        self.unchanged(was)?;
        let since = self.bus.now();
        loop {
            let cleared = OutWord::from(Out::Normal(was.out.0));
            // Whether it arrived OUT says.
            let _ = self.bus.cycle(Some((self.position, cleared)), self.position, &mut []);
            self.bus.wait(LOOK_EVERY);
            let now = self.look()?;
            if !now.out.service_bit() {
                return Ok(now);
            }
            if now.out != was.out {
                return Err(ReleaseError::InUse { was, now });
            }
            let within = self.bus.now().since(since);
            if within >= self.patience || self.stop.load(Ordering::Relaxed) {
                return Err(ReleaseError::Stays { out: now.out, within });
            }
        }
    }
}
