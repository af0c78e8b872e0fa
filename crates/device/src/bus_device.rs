//! The device: an encoder while there is supply, and the moments at which it exchanges words.

use embedded_storage::Storage;
use encoring_encoder::{Encoder, Unit};
use encoring_ring::profile::RESET_AFTER;
use encoring_words::ssi_frame::Level;
use encoring_words::{InWord, Instant, OutWord};

use crate::supply::{OFF_BELOW_MV, OVERVOLTAGE_ABOVE_MV, Surroundings};

/// An encoder that is switched on and off, behind its protocol chip.
#[derive(Clone, Debug)]
pub struct BusDevice {
    unit: Unit,
    encoder: Option<Encoder>,
    /// Since when the supply has sufficed.
    supplied_since: Option<Instant>,
    last_exchange: Instant,
    overvoltage: bool,
}

impl BusDevice {
    /// A device without supply.
    #[must_use]
    pub const fn new(unit: Unit) -> Self {
        Self { unit, encoder: None, supplied_since: None, last_exchange: Instant::ZERO, overvoltage: false }
    }

    /// Tells the supply: any time below [`OFF_BELOW_MV`] is a power-off [R121]. When it is back the encoder is switched
    /// on with the next exchange.
    pub fn supply(&mut self, now: Instant, millivolts: u32, memory: &mut impl Storage) {
        self.overvoltage = millivolts > OVERVOLTAGE_ABOVE_MV;
        if millivolts >= OFF_BELOW_MV {
            self.supplied_since.get_or_insert(now);
        } else {
            self.supplied_since = None;
            if let Some(encoder) = self.encoder.take() {
                encoder.power_off(memory);
            }
        }
    }

    /// The supply failed in the middle of a write: there was no time for the turn count.
    pub fn cut(&mut self) {
        self.supplied_since = None;
        self.encoder = None;
    }

    /// Whether there is an exchange at the end of a cycle that reached the device, good or bad. `taken` is the word that
    /// its chip has taken since it was switched on.
    ///
    /// A device that has taken none waits for its first: were it told 0 meanwhile, a service bit that stood all through
    /// a power dip would look like a new request.
    #[must_use]
    pub const fn exchanges_after_cycle(&self, taken: Option<OutWord>) -> bool {
        self.encoder.is_some() || (taken.is_some() && self.supplied_since.is_some())
    }

    /// When the next exchange is due if no cycle comes: every refresh time, up to and with `until`. A device that was
    /// just switched on has no last word, and waits for the ring until its chip resets.
    #[must_use]
    pub fn due_without_cycles(&self, until: Instant) -> Option<Instant> {
        let next = self.last_exchange + self.unit.model().refresh();
        let since = self.supplied_since.filter(|_| next <= until)?;
        if self.encoder.is_some() {
            Some(next)
        } else {
            // The first is due now, not for all the time before.
            (until.since(since) > RESET_AFTER).then_some(until)
        }
    }

    /// The moment whose shaft an exchange at `at` shows: the last refresh. At power-up it is `at` itself.
    #[must_use]
    pub fn looks_at(&self, at: Instant) -> Instant {
        self.encoder.as_ref().map_or(at, |encoder| encoder.refreshed_at(at))
    }

    /// The OUT word that the encoder hears when its chip holds `taken`: 0 before the first.
    #[must_use]
    pub const fn hears(&self, taken: Option<OutWord>) -> OutWord {
        match taken {
            Some(out) => out,
            None => OutWord(0),
        }
    }

    /// One exchange; `None` while the supply is too low.
    pub fn exchange(
        &mut self,
        now: Instant,
        out: OutWord,
        around: &Surroundings,
        memory: &mut impl Storage,
    ) -> Option<InWord> {
        self.last_exchange = now;
        let encoder = self.switch(now, around, memory)?;
        Some(encoder.exchange(now, out, &around.terminals, memory))
    }

    /// An edge of the SSI clock; Low while the supply is too low [R103..R120].
    pub fn ssi_clock(
        &mut self,
        now: Instant,
        clock: Level,
        around: &Surroundings,
        memory: &mut impl Storage,
    ) -> Level {
        match self.switch(now, around, memory) {
            Some(encoder) => encoder.ssi_clock(now, clock, &around.terminals),
            None => Level::Low,
        }
    }

    /// Switches the encoder off or on, as the supply is.
    fn switch(
        &mut self,
        now: Instant,
        around: &Surroundings,
        memory: &mut impl Storage,
    ) -> Option<&mut Encoder> {
        self.supply(now, around.supply_mv, memory);
        self.supplied_since?;
        let power_up = || Encoder::power_up(&self.unit, now, &around.terminals, memory);
        Some(self.encoder.get_or_insert_with(power_up))
    }

    /// What it was built as.
    #[must_use]
    pub const fn unit(&self) -> &Unit {
        &self.unit
    }

    /// The encoder, while it is on.
    #[must_use]
    pub const fn encoder(&self) -> Option<&Encoder> {
        self.encoder.as_ref()
    }

    /// `true` while the supply told last is above [`OVERVOLTAGE_ABOVE_MV`]; the device stays on.
    #[must_use]
    pub const fn overvoltage(&self) -> bool {
        self.overvoltage
    }
}
