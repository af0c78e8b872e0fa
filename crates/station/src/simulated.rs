//! A simulated ring in this process, as a [`Bus`].

use std::time::{Duration as Real, Instant as Clock};

use encoring_bus::{Bus, BusError, Cycle, Inside, Settling};
use encoring_ring::Verdict;
use encoring_sim::World;
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::pace::Speed;

/// The longest sleep, so that whoever waits can be interrupted.
const SLICE: Real = Real::from_millis(20);

/// A world whose ring is cycled by whoever uses the bus.
///
/// At [`Speed::Max`] every [`Bus::cycle`] is one cycle of the ring and [`Bus::wait`] takes no real time, so everything
/// that happens can be repeated. At any other speed the ring also runs on by itself between the calls, as a real one
/// does.
#[derive(Debug)]
pub struct Simulated {
    world: World,
    out: Vec<OutWord>,
    input: Vec<InWord>,
    /// End of the last cycle that was good throughout.
    last_good: Instant,
    speed: Speed,
    started: Option<Clock>,
}

impl Simulated {
    /// A bus over `world`.
    #[must_use]
    pub fn new(world: World, speed: Speed) -> Self {
        let encoders = world.places().len();
        let (out, input) = (vec![OutWord(0); encoders], vec![InWord(0); encoders]);
        let last_good = world.now();
        let mut bus = Self { world, out, input, last_good, speed, started: None };
        // A device shows its position from the second cycle on.
        bus.run_one();
        bus.run_one();
        bus
    }

    /// The world as it is.
    #[must_use]
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// The world, to be changed between two calls.
    pub const fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    fn run_one(&mut self) {
        let cycled = self.world.cycle(&self.out, &mut self.input);
        if cycled.verdict == Verdict::Good {
            self.last_good = cycled.at;
        }
    }

    fn run_until(&mut self, until: Instant) {
        while self.world.now() + self.world.cycle_time() <= until {
            self.run_one();
        }
    }

    /// The time on the ring at which real time has arrived; `None` at [`Speed::Max`].
    #[expect(clippy::disallowed_methods, reason = "a ring at real speed follows the clock")]
    fn due(&mut self) -> Option<Instant> {
        let Speed::Millionths(millionths) = self.speed else { return None };
        let started = *self.started.get_or_insert_with(Clock::now);
        let elapsed = started.elapsed().as_nanos() * u128::from(millionths) / 1_000_000;
        Some(Instant(u64::try_from(elapsed).unwrap_or(u64::MAX)))
    }

    fn place(&self, position: usize) -> Result<usize, BusError> {
        let encoders = self.out.len();
        if position < encoders { Ok(position) } else { Err(BusError::NoEncoder { position, encoders }) }
    }
}

impl Bus for Simulated {
    fn now(&self) -> Instant {
        self.world.now()
    }

    fn out(&mut self, position: usize) -> Result<OutWord, BusError> {
        self.place(position)?;
        Ok(self.out.get(position).copied().unwrap_or_default())
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        if let Some(last) = input.len().checked_sub(1) {
            self.place(first.saturating_add(last))?;
        }
        if let Some((position, out)) = write {
            let position = self.place(position)?;
            if let Some(word) = self.out.get_mut(position) {
                *word = out;
            }
        }
        if let Some(due) = self.due() {
            self.run_until(due);
        }
        self.run_one();
        for (seen, shown) in input.iter_mut().zip(self.input.iter().skip(first)) {
            *seen = *shown;
        }
        // What a cycle brings was loaded when it began.
        let age = self.world.now().since(self.last_good) + self.world.cycle_time();
        Ok(Cycle { at: self.world.now(), age })
    }

    #[expect(clippy::disallowed_methods, reason = "a ring at real speed is waited for")]
    fn wait(&mut self, span: Duration) {
        let until = self.world.now() + span;
        if self.speed == Speed::Max {
            return self.run_until(until);
        }
        while let Some(due) = self.due().filter(|due| *due < until) {
            self.run_until(due);
            std::thread::sleep(SLICE.min(Real::from_nanos(until.since(due).as_nanos())));
        }
    }

    fn settling(&self) -> Settling {
        Settling { cycles: 1, time: Duration::ZERO }
    }

    fn inside(&self, position: usize) -> Option<Inside> {
        let node = self.world.places().get(position)?.node();
        Some(Inside {
            sensor: node.unit().sensor(),
            active: node.encoder().map(|encoder| *encoder.active()),
            lamps: self.world.lamps(position)?,
        })
    }
}
