//! A simulated ring in this process, as a [`Bus`].

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration as Real, Instant as Clock};

use encoring_bus::image::ClientWrite;
use encoring_bus::{Bus, BusError, Cycle, Insight, Settling};
use encoring_ring::Verdict;
use encoring_ring::diagnostics::Diagnosis;
use encoring_sim::World;
use encoring_sim::world::Cycled;
use encoring_words::{Duration, InWord, Instant, OutWord, Written};

use crate::bus_seen::BusSeen;
use crate::pace::Speed;
use crate::refereeing::{RefereeMode, RefereeView, Refereeing};
use crate::view::LampsView;

/// The longest sleep, so that whoever waits can be interrupted.
const SLICE: Real = Real::from_millis(20);

/// The only client of such a ring.
const MASTER: u32 = 1;

/// A handle on the world behind a simulated bus: it shows what no bus can. Clones lead to the same world.
#[derive(Clone, Debug)]
pub struct SharedWorld(Arc<Mutex<World>>);

impl SharedWorld {
    fn lock(&self) -> MutexGuard<'_, World> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks at the world or changes it, between two cycles of its ring. `access` must not use the bus: it waits for
    /// the end of this.
    pub fn with<R>(&self, access: impl FnOnce(&mut World) -> R) -> R {
        access(&mut self.lock())
    }

    /// What is active in the encoder at a position; `None` while it is off.
    #[must_use]
    pub fn insight(&self, position: usize) -> Option<Insight> {
        let world = self.lock();
        let node = world.places().get(position)?.node();
        Some(Insight { sensor: node.unit().sensor(), active: *node.encoder()?.active() })
    }

    /// The lamps of the encoder at a position.
    #[must_use]
    pub fn lamps(&self, position: usize) -> Option<LampsView> {
        LampsView::of(&self.lock(), position)
    }
}

/// A world whose ring is cycled by whoever uses the bus.
///
/// At [`Speed::Max`] every [`Bus::cycle`] is one cycle of the ring and [`Bus::wait`] takes no real time, so everything
/// that happens can be repeated. At any other speed the ring also runs on by itself between the calls, as a real one
/// does.
#[derive(Debug)]
pub struct Simulated {
    world: SharedWorld,
    ring: Ring,
    speed: Speed,
    started: Option<Clock>,
}

/// What the master of the ring holds.
#[derive(Debug)]
struct Ring {
    out: Vec<OutWord>,
    input: Vec<InWord>,
    /// End of the last cycle that was good throughout.
    last_good: Instant,
    onlooker: Option<Onlooker>,
}

/// Who looks on while a master works.
#[derive(Debug)]
struct Onlooker {
    refereeing: Refereeing,
    seen: BusSeen,
}

impl Onlooker {
    /// Takes a cycle that went out with `out` and left `input`.
    fn cycled(&mut self, began: Instant, cycled: &Cycled, out: &[OutWord], input: &[InWord]) {
        let Self { refereeing, seen } = self;
        seen.out.clear();
        seen.out.extend_from_slice(out);
        seen.input.clear();
        seen.input.extend_from_slice(input);
        seen.went(began, cycled.at, Some(cycled.verdict));
        refereeing.cycled(seen);
        seen.writes.clear();
        let broken = refereeing.breaks_the_order();
        debug_assert!(broken.is_none(), "our own master breaks the handshake: {broken:?}");
    }
}

impl Ring {
    fn run_one(&mut self, world: &mut World) {
        let began = world.now();
        let cycled = world.cycle(&self.out, &mut self.input);
        if cycled.verdict == Verdict::Good {
            self.last_good = cycled.at;
        }
        if let Some(onlooker) = &mut self.onlooker {
            onlooker.cycled(began, &cycled, &self.out, &self.input);
        }
    }

    fn write(&mut self, position: usize, out: OutWord) -> Result<(), BusError> {
        let position = self.place(position)?;
        if let Some(word) = self.out.get_mut(position) {
            *word = out;
        }
        if let Some(onlooker) = &mut self.onlooker {
            let write = ClientWrite { client: MASTER, position, written: Written::Both(out) };
            onlooker.seen.writes.push(write);
        }
        Ok(())
    }

    fn run_until(&mut self, world: &mut World, until: Instant) {
        while world.now() + world.cycle_time() <= until {
            self.run_one(world);
        }
    }

    fn place(&self, position: usize) -> Result<usize, BusError> {
        let encoders = self.out.len();
        if position < encoders { Ok(position) } else { Err(BusError::NoEncoder { position, encoders }) }
    }
}

impl Simulated {
    /// A bus over `world`.
    #[must_use]
    pub fn new(mut world: World, speed: Speed) -> Self {
        let encoders = world.places().len();
        let (out, input) = (vec![OutWord(0); encoders], vec![InWord(0); encoders]);
        let mut ring = Ring { out, input, last_good: world.now(), onlooker: None };
        // A device shows its position from the second cycle on.
        ring.run_one(&mut world);
        ring.run_one(&mut world);
        Self { world: SharedWorld(Arc::new(Mutex::new(world))), ring, speed, started: None }
    }

    /// The handle on the world behind it, to be cloned before the bus is given away.
    #[must_use]
    pub const fn world(&self) -> &SharedWorld {
        &self.world
    }

    /// From the next cycle on a referee looks at what the master does, as in `sim --referee on`.
    pub fn look_on(&mut self) {
        self.looked_on(RefereeMode::On);
    }

    /// The same, and a build with debug assertions panics when the master breaks the order of the handshake: for tests of what
    /// works on a ring. Before it there is nothing, so a service bit that stands already is not judged.
    pub fn look_on_strictly(&mut self) {
        self.looked_on(RefereeMode::Strict);
    }

    fn looked_on(&mut self, mode: RefereeMode) {
        let refereeing = Refereeing::new(&self.world.lock(), mode);
        self.ring.onlooker = refereeing.map(|refereeing| Onlooker { refereeing, seen: BusSeen::default() });
    }

    /// What the referee says at the end, and nobody looks on any more; `None` if nobody did.
    pub fn judged(&mut self) -> Option<RefereeView> {
        let mut onlooker = self.ring.onlooker.take()?;
        onlooker.refereeing.finish();
        Some(onlooker.refereeing.view())
    }

    /// The time on the ring at which real time has arrived; `None` at [`Speed::Max`].
    #[expect(clippy::disallowed_methods, reason = "a ring at real speed follows the clock")]
    fn due(&mut self) -> Option<Instant> {
        let Speed::Millionths(millionths) = self.speed else { return None };
        let started = *self.started.get_or_insert_with(Clock::now);
        let elapsed = started.elapsed().as_nanos() * u128::from(millionths) / 1_000_000;
        Some(Instant(u64::try_from(elapsed).unwrap_or(u64::MAX)))
    }

    fn run_until(&mut self, until: Instant) {
        self.ring.run_until(&mut self.world.lock(), until);
    }
}

impl Bus for Simulated {
    fn now(&self) -> Instant {
        self.world.lock().now()
    }

    fn out(&mut self, position: usize) -> Result<OutWord, BusError> {
        self.ring.place(position)?;
        Ok(self.ring.out.get(position).copied().unwrap_or_default())
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        if let Some(last) = input.len().checked_sub(1) {
            self.ring.place(first.saturating_add(last))?;
        }
        if let Some((position, out)) = write {
            self.ring.write(position, out)?;
        }
        let due = self.due();
        let world = &mut *self.world.lock();
        if let Some(due) = due {
            self.ring.run_until(world, due);
        }
        self.ring.run_one(world);
        for (seen, shown) in input.iter_mut().zip(self.ring.input.iter().skip(first)) {
            *seen = *shown;
        }
        // What a cycle brings was loaded when it began.
        let age = world.now().since(self.ring.last_good) + world.cycle_time();
        Ok(Cycle { at: world.now(), age })
    }

    #[expect(clippy::disallowed_methods, reason = "a ring at real speed is waited for")]
    fn wait(&mut self, span: Duration) {
        let until = self.now() + span;
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

    fn diagnosis(&mut self) -> Result<Diagnosis, BusError> {
        let due = self.due();
        let world = &mut *self.world.lock();
        if let Some(due) = due {
            self.ring.run_until(world, due);
        }
        let master = world.ring().master();
        Ok(Diagnosis { status: Some(master.status()), parameter: Some(master.parameter()) })
    }
}
