//! The ring of a world: its master, its chips, and the segments with what happens to them.

use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::frame::frame_bits;
use encoring_ring::ident::ENCODER;
use encoring_ring::slave::{Condition, Jumper};
use encoring_ring::{BitRing, CycleTime, EveryBit, Ident, Slave, Sound, Verdict};
use encoring_words::{Duration, InWord, Instant, OutWord};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::fault::Fault;
use crate::injector::Segments;
use crate::tap::{Tap, Tapped};

/// Slots beyond one a device in which a sound ring is open at the latest: the first silence, and some to spare.
const SLOTS_TO_OPEN: usize = 1_000;

/// A ring with what happens to its segments.
#[derive(Clone, Debug)]
pub(crate) struct Wire {
    ring: BitRing<Vec<Slave>>,
    segments: Segments,
    bit: Duration,
    trouble: Option<Trouble>,
    chance: Pcg64Mcg,
    looks: Looks,
}

/// Who looks on at the bits.
#[derive(Clone, Debug)]
enum Looks {
    /// Nobody: they run only where one can matter.
    Nobody,
    /// A test, which wants every bit to run.
    Test,
    /// A recording.
    Tap(Box<Tap>),
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
    /// A ring of so many encoders, opened when time begins.
    pub(crate) fn new(encoders: usize, cycle_time: &CycleTime, seed: u64) -> Self {
        let bit = cycle_time.bit;
        let slaves = (0..encoders).map(|_| Slave::new(ENCODER, bit)).collect();
        let mut ring = BitRing::new(slaves, bit);
        // So many encoders fit on a ring, or the world had been refused.
        let _ = ring.bring_up(&mut Sound, encoders + SLOTS_TO_OPEN);
        ring.begin_time();
        let segments = Segments::new(encoders, seed);
        let chance = Pcg64Mcg::seed_from_u64(!seed);
        Self { ring, segments, bit, trouble: None, chance, looks: Looks::Nobody }
    }

    /// The ring itself.
    pub(crate) const fn ring(&self) -> &BitRing<Vec<Slave>> {
        &self.ring
    }

    /// The master opens the ring anew with ID cycles, as far as it can.
    pub(crate) fn open_anew(&mut self) {
        let master = self.ring.master_mut();
        master.activate();
        // It was activated a moment ago.
        let _ = master.start();
    }

    /// The master sends nothing any more.
    pub(crate) fn stop(&mut self) {
        self.ring.master_mut().alarm_stop();
    }

    pub(crate) fn set_jumper(&mut self, position: usize, jumper: Jumper) {
        if let Some(slave) = self.ring.slaves_mut().get_mut(position) {
            slave.set_jumper(jumper);
        }
    }

    pub(crate) fn set_ident(&mut self, position: usize, ident: Ident) {
        if let Some(slave) = self.ring.slaves_mut().get_mut(position) {
            slave.set_ident(ident);
        }
    }

    /// Every bit runs from now on.
    pub(crate) fn run_every_bit(&mut self) {
        if let Looks::Nobody = self.looks {
            self.looks = Looks::Test;
        }
    }

    /// Who looks on from now on.
    pub(crate) fn set_tap(&mut self, tap: Tap) {
        self.looks = Looks::Tap(Box::new(tap));
    }

    /// A recording is over.
    pub(crate) fn end_tap(&mut self) {
        if let Looks::Tap(_) = self.looks {
            self.looks = Looks::Nobody;
        }
    }

    pub(crate) const fn tap_mut(&mut self) -> Option<&mut Tap> {
        match &mut self.looks {
            Looks::Nobody | Looks::Test => None,
            Looks::Tap(tap) => Some(tap),
        }
    }

    /// How long a line bit is.
    pub(crate) const fn bit(&self) -> Duration {
        self.bit
    }

    /// The time of the line bits so far.
    pub(crate) fn time(&self) -> Instant {
        Instant(self.ring.sent().saturating_mul(self.bit.as_nanos()))
    }

    /// Says whether each device works in the coming slot.
    pub(crate) fn set_conditions(&mut self, conditions: impl Iterator<Item = Condition>) {
        for (slave, condition) in self.ring.slaves_mut().iter_mut().zip(conditions) {
            put_in(slave, condition);
        }
    }

    /// Says whether a device works from now on.
    pub(crate) fn set_condition(&mut self, position: usize, condition: Condition) {
        if let Some(slave) = self.ring.slaves_mut().get_mut(position) {
            put_in(slave, condition);
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
        for segment in bad.into_iter().chain(hit) {
            let bytes = self.ring.slaves().iter().map(Slave::bytes).sum();
            let at = self.ring.sent() + self.chance.random_range(0..frame_bits(bytes));
            if let Some(injector) = self.segments.get_mut(segment) {
                injector.flip(at);
            }
        }
        let (ring, segments) = (&mut self.ring, &mut self.segments);
        let cycled = match &mut self.looks {
            Looks::Nobody => ring.cycle(now, out, input, answers, segments),
            Looks::Test => ring.cycle(now, out, input, answers, &mut EveryBit(segments)),
            Looks::Tap(tap) => ring.cycle(now, out, input, answers, &mut Tapped { segments, tap }),
        };
        (cycled.verdict, cycled.place)
    }
}

/// A chip that is so already forgets nothing more.
fn put_in(slave: &mut Slave, condition: Condition) {
    if slave.condition() != condition {
        slave.set_condition(condition);
    }
}
