//! What a master finds on the ring of a scenario when it opens it device by device.

use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::ident::ENCODER;
use encoring_ring::master::State;
use encoring_ring::profile::BUS_ACTIVE_FOR;
use encoring_ring::{Ident, TooManyEncoders};
use encoring_words::{Duration, InWord, OutWord};

use crate::scenario::Scenario;
use crate::world::World;

/// What a device whose place is settled costs the master at the most, in slots: ID cycles that are repeated.
const SLOTS_A_DEVICE: u64 = 10;

/// What the master is silent for before it opens the ring, and some to spare.
const BEFORE_OPENING: Duration = Duration::from_millis(100);

/// Data cycles after the ring was opened: with them the lamps are as they stay.
const CYCLES_AFTER: usize = 3;

/// A ring that was opened as far as it goes.
#[derive(Clone, Debug)]
pub struct Scan {
    /// The ring as it is now.
    pub world: World,
    /// What was found, from the front.
    pub found: Vec<Ident>,
    /// Why it was not opened further; `None` if it is whole.
    pub place: Option<FaultPlace>,
    /// What a device showed that is another than the scenario has.
    pub other: Option<Ident>,
    /// The diagnostic status register.
    pub status: u16,
    /// The diagnostic parameter register.
    pub parameter: u16,
    /// How long the master took for it.
    pub took: Duration,
}

/// Opens the ring of a scenario with ID cycles, after what happens to it in its first cycle. The
/// master knows that every device is to be an encoder; it ends where it cannot go on, at the first attempt.
///
/// # Errors
/// [`TooManyEncoders`] above 128.
pub fn scan(scenario: &Scenario) -> Result<Scan, TooManyEncoders> {
    let mut world = World::new(scenario)?;
    let encoders = scenario.devices.len();
    let (out, mut input) = (vec![OutWord(0); encoders], vec![InWord(0); encoders]);
    world.cycle(&out, &mut input);
    // So long that no lamp shows what was before.
    world.stop_ring();
    let until = world.now() + BUS_ACTIVE_FOR + world.cycle_time();
    while world.now() <= until {
        world.cycle(&out, &mut input);
    }
    world.open_anew();
    let began = world.now();
    let slots = SLOTS_A_DEVICE * (encoders as u64 + 1);
    let latest = began + BEFORE_OPENING + Duration(world.cycle_time().as_nanos().saturating_mul(slots));
    let mut place = None;
    while world.now() < latest {
        place = world.cycle(&out, &mut input).place;
        if place.is_some() || world.ring().master().state() == State::Run {
            break;
        }
    }
    let took = world.now().since(began);
    // What ends the search is told before the master begins again.
    let master = world.ring().master();
    let (mut status, mut parameter, other) = (master.status(), master.parameter(), master.other());
    let found = (0..encoders).map_while(|position| master.found(position)).collect();
    if place.is_none() {
        for _ in 0..CYCLES_AFTER {
            place = world.cycle(&out, &mut input).place;
        }
        let master = world.ring().master();
        (status, parameter) = (master.status(), master.parameter());
    }
    Ok(Scan { world, found, place, other, status, parameter, took })
}

impl Scan {
    /// `true` if every device of the scenario was found, and the ring runs.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.place.is_none()
            && self.found.len() == self.world.places().len()
            && self.found.iter().all(|ident| *ident == ENCODER)
    }
}
