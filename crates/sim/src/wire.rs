//! The ring of a world, at the level that was chosen.

use encoring_ring::bit_level::Sound;
use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::frame::frame_bits;
use encoring_ring::ident::ENCODER;
use encoring_ring::slave::{Condition, Jumper};
use encoring_ring::{BitRing, CycleTime, Ident, Master, ProcessImage, Slave, Taken, Verdict, WordRing};
use encoring_words::{Duration, InWord, Instant, OutWord};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::fault::{Fault, Segments};
use crate::scenario::Level;
use crate::tap::{Tap, Tapped};

/// Slots beyond one a device in which a sound ring is open at the latest: the first silence, and some to spare.
const SLOTS_TO_OPEN: usize = 1_000;

/// A ring at one of the two levels.
#[derive(Clone, Debug)]
pub enum Wire {
    /// All words of a cycle at once.
    Word(Box<WordRing>),
    /// Every bit on every segment.
    Bit(Box<BitWire>),
}

/// A ring at bit level with what happens to its segments.
#[derive(Clone, Debug)]
pub struct BitWire {
    ring: BitRing<Vec<Slave>>,
    segments: Segments,
    bit: Duration,
    trouble: Option<Trouble>,
    chance: Pcg64Mcg,
    /// Who looks on.
    pub(crate) tap: Option<Tap>,
}

/// A trouble of one segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Trouble {
    pub(crate) segment: usize,
    pub(crate) fault: Fault,
    pub(crate) since: Instant,
    pub(crate) lasting: Duration,
}

impl Wire {
    /// A ring of so many encoders. At bit level it has been opened when time begins.
    pub(crate) fn new(level: Level, encoders: usize, cycle_time: &CycleTime, seed: u64) -> Self {
        match level {
            Level::Word => Self::Word(Box::default()),
            Level::Bit => {
                let bit = cycle_time.bit;
                let slaves = (0..encoders).map(|_| Slave::new(ENCODER, bit)).collect();
                let mut ring = BitRing::new(slaves, bit);
                // So many encoders fit on a ring, or the world had been refused.
                let _ = ring.bring_up(&mut Sound, encoders + SLOTS_TO_OPEN);
                ring.begin_time();
                let segments = Segments::new(encoders, seed);
                let chance = Pcg64Mcg::seed_from_u64(!seed);
                Self::Bit(Box::new(BitWire { ring, segments, bit, trouble: None, chance, tap: None }))
            }
        }
    }

    /// The least time of a cycle. At bit level the telegrams, the delays of whole bits [A4] and the status telegrams
    /// before each frame [A5] must fit into it, however short the master's software time is.
    pub(crate) fn shortest_cycle(&self) -> Duration {
        match self {
            Self::Word(_) => Duration::ZERO,
            Self::Bit(wire) => wire.ring.shortest(),
        }
    }

    /// The OUT word that the device at `position` holds at `now`. The bit level knows the present only.
    #[must_use]
    pub fn out_word(&self, position: usize, now: Instant) -> OutWord {
        self.taken(position, now).shown()
    }

    /// What the chip at `position` holds at `now`, and how often it was reset. The bit level knows the present only.
    pub(crate) fn taken(&self, position: usize, now: Instant) -> Taken {
        match self {
            Self::Word(ring) => ring.taken(position, now),
            Self::Bit(wire) => wire.ring.taken(position),
        }
    }

    /// The lamp BA [R139].
    #[must_use]
    pub fn bus_active(&self, position: usize, now: Instant) -> bool {
        match self {
            Self::Word(ring) => ring.bus_active(position, now),
            Self::Bit(wire) => wire.ring.lamps(position).is_some_and(|lamps| lamps.ba),
        }
    }

    /// The lamp RC [R139].
    #[must_use]
    pub fn incoming_connected(&self, position: usize, now: Instant) -> bool {
        match self {
            Self::Word(ring) => ring.incoming_connected(position, now),
            Self::Bit(wire) => wire.ring.lamps(position).is_some_and(|lamps| lamps.rc),
        }
    }

    /// The lamp RD: the outgoing bus is switched off [R139]. At word level it is so in reset and at the last device.
    #[must_use]
    pub fn outgoing_off(&self, position: usize, now: Instant, encoders: usize) -> bool {
        match self {
            Self::Word(ring) => !ring.incoming_connected(position, now) || position + 1 == encoders,
            Self::Bit(wire) => wire.ring.lamps(position).is_some_and(|lamps| lamps.rd),
        }
    }

    /// The master; the word level has none.
    #[must_use]
    pub const fn master(&self) -> Option<&Master> {
        match self {
            Self::Word(_) => None,
            Self::Bit(wire) => Some(wire.ring.master()),
        }
    }

    /// Puts the diagnostic registers into a process image. The word level has no master: it says what one would.
    pub fn diagnose(&self, image: &mut ProcessImage) {
        match self {
            Self::Word(ring) => image.diagnose(ring.status(), ring.parameter(), ring.counts().segments()),
            Self::Bit(wire) => {
                let master = wire.ring.master();
                image.diagnose(master.status(), master.parameter(), master.counts().segments());
            }
        }
    }

    /// The ring at bit level, if it is one.
    #[must_use]
    pub const fn bits(&self) -> Option<&BitRing<Vec<Slave>>> {
        match self {
            Self::Word(_) => None,
            Self::Bit(wire) => Some(&wire.ring),
        }
    }

    /// The master opens the ring anew with ID cycles, as far as it can. The word level has nothing to open.
    pub(crate) fn open_anew(&mut self) {
        if let Self::Bit(wire) = self {
            let master = wire.ring.master_mut();
            master.activate();
            // It was activated a moment ago.
            let _ = master.start();
        }
    }

    /// The master sends nothing any more. The word level goes on.
    pub(crate) fn stop(&mut self) {
        if let Self::Bit(wire) = self {
            wire.ring.master_mut().alarm_stop();
        }
    }

    /// A device that lost its supply has forgotten what it took.
    pub(crate) fn power_off(&mut self, position: usize) {
        match self {
            Self::Word(ring) => ring.power_off(position),
            Self::Bit(wire) => wire.set_condition(position, Condition::Off),
        }
    }

    /// A chip whose reset input is held forgets too.
    pub(crate) fn hold(&mut self, position: usize) {
        match self {
            Self::Word(ring) => ring.hold(position),
            Self::Bit(wire) => wire.set_condition(position, Condition::Held),
        }
    }

    pub(crate) fn set_jumper(&mut self, position: usize, jumper: Jumper) {
        if let Self::Bit(wire) = self
            && let Some(slave) = wire.ring.slaves_mut().get_mut(position)
        {
            slave.set_jumper(jumper);
        }
    }

    pub(crate) fn set_ident(&mut self, position: usize, ident: Ident) {
        if let Self::Bit(wire) = self
            && let Some(slave) = wire.ring.slaves_mut().get_mut(position)
        {
            slave.set_ident(ident);
        }
    }
}

impl BitWire {
    /// How long a line bit is.
    pub(crate) const fn bit(&self) -> Duration {
        self.bit
    }

    /// The time of the line bits so far.
    pub(crate) fn time(&self) -> Instant {
        Instant(self.ring.sent().saturating_mul(self.bit.as_nanos()))
    }

    /// Says whether a device works in the coming slot.
    pub(crate) fn set_condition(&mut self, position: usize, condition: Condition) {
        if let Some(slave) = self.ring.slaves_mut().get_mut(position)
            && slave.condition() != condition
        {
            slave.set_condition(condition);
        }
    }

    /// Says what troubles a segment from now on.
    pub(crate) fn set_trouble(&mut self, trouble: Option<Trouble>) {
        if self.trouble == trouble {
            return;
        }
        self.trouble = trouble;
        self.segments.clear();
        let Some(Trouble { segment, fault, since, lasting }) = trouble else { return };
        let bits = |at: Instant| at.as_nanos().checked_div(self.bit.as_nanos()).unwrap_or_default();
        if let Some(injector) = self.segments.get_mut(segment) {
            injector.set(fault, bits(since), bits(since + lasting));
        }
    }

    /// Runs the slot that ends at `now`. `hit` is a segment on which one bit of the frame turns over.
    pub(crate) fn cycle(
        &mut self,
        now: Instant,
        out: &[OutWord],
        input: &mut [InWord],
        answers: &[Option<InWord>],
        hit: Option<usize>,
    ) -> (Verdict, Option<FaultPlace>) {
        let bad =
            self.trouble.filter(|trouble| trouble.fault.hits_each_frame()).map(|trouble| trouble.segment);
        let bytes = self.ring.slaves().iter().map(Slave::bytes).sum();
        for segment in bad.into_iter().chain(hit) {
            let at = self.ring.sent() + self.chance.random_range(0..frame_bits(bytes));
            if let Some(injector) = self.segments.get_mut(segment) {
                injector.flip(at);
            }
        }
        let (ring, segments) = (&mut self.ring, &mut self.segments);
        let cycled = match &mut self.tap {
            None => ring.cycle(now, out, input, answers, segments),
            Some(tap) => ring.cycle(now, out, input, answers, &mut Tapped { segments, tap }),
        };
        (cycled.verdict, cycled.place)
    }
}
