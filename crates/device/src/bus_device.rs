//! The device: an encoder while there is supply, and the moments at which it exchanges words.

use embedded_storage::Storage;
use encoring_encoder::{Encoder, StaleService, Unit};
use encoring_ring::Taken;
use encoring_ring::profile::RESET_AFTER;
use encoring_words::ssi_frame::Level;
use encoring_words::word::Out;
use encoring_words::{InWord, Instant, OutWord};

use crate::supply::{OFF_BELOW_MV, OVERVOLTAGE_ABOVE_MV, Surroundings};

/// What the chip makes of a service bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ServiceBit {
    /// It hands it on.
    HandedOn,
    /// It stood when the bus came out of a reset, or may have: it is held back until a cycle has brought 0 [D43].
    HeldBack,
}

/// An encoder that is switched on and off, behind its protocol chip.
#[derive(Clone, Debug)]
pub struct BusDevice {
    unit: Unit,
    encoder: Option<Encoder>,
    /// Since when the supply has sufficed.
    supplied_since: Option<Instant>,
    /// Since it was switched on. The SSI may have switched it on before its first.
    last_exchange: Option<Instant>,
    overvoltage: bool,
    service_bit: ServiceBit,
    /// Of the chip, when the encoder heard it last.
    resets: u32,
}

impl BusDevice {
    /// A device without supply.
    #[must_use]
    pub const fn new(unit: Unit) -> Self {
        Self {
            unit,
            encoder: None,
            supplied_since: None,
            last_exchange: None,
            overvoltage: false,
            service_bit: ServiceBit::HandedOn,
            resets: 0,
        }
    }

    /// Tells the supply: any time below [`OFF_BELOW_MV`] is a power-off [R121]. When it is back the encoder is switched
    /// on with the next exchange.
    pub fn supply(&mut self, now: Instant, millivolts: u32, memory: &mut impl Storage) {
        self.overvoltage = millivolts > OVERVOLTAGE_ABOVE_MV;
        if millivolts >= OFF_BELOW_MV {
            self.supplied_since.get_or_insert(now);
        } else {
            self.supplied_since = None;
            self.last_exchange = None;
            if let Some(encoder) = self.encoder.take() {
                encoder.power_off(memory);
            }
        }
    }

    /// The supply failed in the middle of a write: there was no time for the turn count.
    pub fn cut(&mut self) {
        self.supplied_since = None;
        self.last_exchange = None;
        self.encoder = None;
    }

    /// Whether there is an exchange at the end of a cycle that reached the device, good or bad.
    ///
    /// A device that has taken none waits for its first: were it told 0 meanwhile, a service bit that stood all through
    /// a power dip would look like a new request.
    #[must_use]
    pub const fn exchanges_after_cycle(&self, taken: Taken) -> bool {
        self.last_exchange.is_some() || (taken.word.is_some() && self.supplied_since.is_some())
    }

    /// When the next exchange is due if no cycle comes: every refresh time, up to and with `until`. A device that was
    /// just switched on has no last word, and waits for the ring until its chip resets.
    #[must_use]
    pub fn due_without_cycles(&self, until: Instant) -> Option<Instant> {
        let since = self.supplied_since?;
        match self.last_exchange.map(|last| last + self.unit.model().refresh()) {
            Some(next) => (next <= until).then_some(next),
            // The first is due now, not for all the time before.
            None => (until.since(since) > RESET_AFTER).then_some(until),
        }
    }

    /// The moment whose shaft an exchange at `at` shows: the last refresh. At power-up it is `at` itself.
    #[must_use]
    pub fn looks_at(&self, at: Instant) -> Instant {
        self.encoder.as_ref().map_or(at, |encoder| encoder.refreshed_at(at))
    }

    /// The OUT word that the encoder hears in its next exchange: 0 while the chip is in reset.
    ///
    /// Afterwards a service bit that is 1 is held back until a cycle has brought 0, or a controller that stood in the
    /// middle of a service when the bus stopped would have it done twice; bits 30..0 pass [D43]. The first word after
    /// power-up passes whole: there the encoder does the same by itself [D1].
    pub fn hears(&mut self, taken: Taken) -> OutWord {
        let was_reset = self.last_exchange.is_some() && taken.resets != self.resets;
        self.resets = taken.resets;
        match taken.word {
            Some(out) if !out.service_bit() => self.service_bit = ServiceBit::HandedOn,
            Some(_) if self.last_exchange.is_none() => self.service_bit = ServiceBit::HandedOn,
            Some(_) if !was_reset => {}
            _ => self.service_bit = ServiceBit::HeldBack,
        }
        match (self.unit.stale_service, self.service_bit) {
            (StaleService::Ignored, ServiceBit::HeldBack) => OutWord::from(Out::Normal(taken.shown().0)),
            _ => taken.shown(),
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
        let encoder = self.switch(now, around, memory)?;
        let input = encoder.exchange(now, out, &around.terminals, memory);
        self.last_exchange = Some(now);
        Some(input)
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
