//! The SSI output of the CE-65-M, clock edge by clock edge [R106..R112, C18..C22].

use encoring_words::ssi_frame::{Level, MONO_PERIOD, SsiFrame};
use encoring_words::{Duration, Instant};

/// The shift register behind Data+.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiOutput {
    clock: Level,
    transfer: Option<Transfer>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Transfer {
    frame: SsiFrame,
    /// Rising edges so far, as [`SsiFrame::after`] counts them.
    pulse: u32,
    /// The last falling edge, from which the mono period runs [C22].
    fell: Instant,
}

impl SsiOutput {
    /// At rest: clock and data High.
    pub const POWER_UP: Self = Self { clock: Level::High, transfer: None };

    /// Takes the clock's level and gives the data's. `latch` makes the frame when a transfer begins.
    pub fn clock(&mut self, now: Instant, clock: Level, latch: impl FnOnce() -> SsiFrame) -> Level {
        if self.running(now).is_none() {
            self.transfer = None;
        }
        if clock != self.clock {
            self.clock = clock;
            match (&mut self.transfer, clock) {
                (Some(transfer), Level::Low) => transfer.fell = now,
                (Some(transfer), Level::High) => transfer.pulse = transfer.frame.after(transfer.pulse),
                (None, Level::Low) => self.transfer = Some(Transfer { frame: latch(), pulse: 0, fell: now }),
                (None, Level::High) => {}
            }
        }
        self.level(now).0
    }

    /// Data+ at `now`, and the moment at which it will change without an edge, if it will.
    #[must_use]
    pub fn level(&self, now: Instant) -> (Level, Option<Instant>) {
        let Some(transfer) = self.running(now) else { return (Level::High, None) };
        match transfer.frame.level(transfer.pulse) {
            Level::High => (Level::High, None),
            Level::Low => (Level::Low, Some(transfer.fell + MONO_PERIOD + Duration::from_nanos(1))),
        }
    }

    /// The transfer, unless more than the mono period has passed since its last falling edge.
    fn running(&self, now: Instant) -> Option<&Transfer> {
        self.transfer.as_ref().filter(|transfer| now.since(transfer.fell) <= MONO_PERIOD)
    }
}
