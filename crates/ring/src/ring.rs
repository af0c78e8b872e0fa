//! The ring: a master, its slaves and the segments between them, slot by slot.
//!
//! [`BitRing::cycle`] takes OUT words and the answers that the devices load at the start, and gives IN words. What a
//! segment suffers is what happens to its bits; how the slot went follows from what master and devices made of them.
//!
//! A device delays the line by some bits [A4]. The devices here pass bits on without delay, and all of it lies on the
//! way home, where the master allows for it: every line carries the same bits in the same order, only their clocks
//! are set differently. A test beside the chips with their delay shows that nothing else differs.
//!
//! A slot that is sound is taken as a whole: see `BitRing::sound_slot` for when that is.

use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::diagnostics::FaultPlace;
use crate::frame::{Outgoing, frame_bits, pause_telegrams};
use crate::ident::Ident;
use crate::master::{ConfigurationError, Ended, Master, Slot, State};
use crate::profile::{STATUS_BEFORE_FRAME, STATUS_BITS};
use crate::slave::{Condition, Lamps, Slave, Taken};
use crate::sound_slot::{SoundSlot, copy};
use crate::telegram::{Bits, statuses};

/// What the segments do to the bits that pass. Segment k leads into the device at position k; the one after the last
/// device leads home.
pub trait Lines {
    /// Some bits enter a segment, the first of them at `at`, counted in line bits since the ring was made; the same
    /// number leaves it.
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits;

    /// Promises that no segment changes anything from bit `from` on, up to and without bit `to`, and that nobody looks
    /// on. If the ring is sound as well, it takes these bits as a whole, and they do not pass here.
    fn quiet(&self, from: u64, to: u64) -> bool {
        let _ = (from, to);
        false
    }

    /// Some bits, the first of them at `at`, have gone around: so the devices are now. For whoever wants to look on.
    fn passed(&mut self, at: u64, count: u32, slaves: &[Slave]) {
        let _ = (at, count, slaves);
    }
}

/// Segments that change nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sound;

impl Lines for Sound {
    fn pass(&mut self, _: usize, _: u64, line: Bits) -> Bits {
        line
    }

    fn quiet(&self, _: u64, _: u64) -> bool {
        true
    }
}

/// Segments without their promise: every bit passes them.
#[derive(Debug)]
pub struct EveryBit<'a, L>(pub &'a mut L);

impl<L: Lines> Lines for EveryBit<'_, L> {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        self.0.pass(segment, at, line)
    }

    fn passed(&mut self, at: u64, count: u32, slaves: &[Slave]) {
        self.0.passed(at, count, slaves);
    }
}

impl<F: FnMut(usize, u64, Bits) -> Bits> Lines for F {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        self(segment, at, line)
    }
}

/// A ring whose slaves are kept in `S`: an array, or whatever else holds a slice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitRing<S> {
    master: Master,
    slaves: S,
    bit: Duration,
    /// Line bits since it was made.
    sent: u64,
    was_silent: bool,
    /// The end of the last slot, as it was told.
    ended: Instant,
}

/// How a data cycle went. Segment k leads into the device at position k; the one after the last device leads back
/// to the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Every check word was right.
    Good,
    /// The first bad check word was on this segment: devices before it have taken their data, the others keep
    /// their old, the master takes none.
    Bad {
        /// 0..=encoders.
        segment: usize,
    },
    /// From this segment on the line is silent. The loopback word never comes home, so no check phase follows and
    /// no device takes anything.
    Silent {
        /// 0..=encoders.
        segment: usize,
    },
}

/// What happened in one slot of the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotResult {
    /// What the slot was used for, and how it ended for the master.
    pub ended: Ended,
    /// What the devices took of it.
    pub verdict: Verdict,
    /// Where the master sees the ring at fault.
    pub place: Option<FaultPlace>,
}

impl<S: AsRef<[Slave]> + AsMut<[Slave]>> BitRing<S> {
    /// A ring of these slaves, its master ready, for bits of this length.
    #[must_use]
    pub fn new(slaves: S, bit: Duration) -> Self {
        Self { master: Master::new(bit), slaves, bit, sent: 0, was_silent: true, ended: Instant::ZERO }
    }

    /// Tells the master what the ring is, activates and starts it, and runs it until data cycles can begin. The line is
    /// as it is told to be; if it stays unfit for `slots` slots the ring is left in its search.
    ///
    /// # Errors
    /// [`ConfigurationError`] if the devices are too many or have no length.
    pub fn bring_up(&mut self, lines: &mut impl Lines, slots: usize) -> Result<(), ConfigurationError> {
        // So many identification words need no storage: the master looks at one after the other.
        let mut idents = [Ident(0); crate::profile::DEVICES_MAX];
        let slaves = self.slaves.as_ref();
        let devices = slaves.len();
        for (ident, slave) in idents.iter_mut().zip(slaves) {
            *ident = slave.identification();
        }
        let idents = idents.get(..devices).ok_or(ConfigurationError::Devices { devices })?;
        self.master.configure(idents)?;
        self.master.activate();
        let started = self.master.start();
        debug_assert!(started.is_ok(), "it was activated a moment ago");
        for _ in 0..slots {
            if self.master.state() == State::Run {
                break;
            }
            self.slot(0, lines);
        }
        Ok(())
    }

    /// Runs one slot that ends at `now`: a data cycle, or what the master does in its place. `out`, `input` and
    /// `answers` have one word a device; words go to the first four bytes of a device, the high byte first.
    ///
    /// `answers` are the IN words that the devices loaded when the slot started, so a reply to the OUT word of this slot
    /// is seen by the master after the next one at the earliest. `None` is a device that has nothing to show since it was
    /// switched on, and leaves `input` as it is; so does a slot that did not end good.
    pub fn cycle(
        &mut self,
        now: Instant,
        out: &[OutWord],
        input: &mut [InWord],
        answers: &[Option<InWord>],
        lines: &mut impl Lines,
    ) -> SlotResult {
        for ((bytes, _), out) in self.master.both().zip(out) {
            copy(&out.0.to_be_bytes(), bytes);
        }
        for (slave, answer) in self.slaves.as_mut().iter_mut().zip(answers) {
            if let Some(answer) = answer {
                slave.load(&answer.0.to_be_bytes());
            }
        }
        let cycled = self.run(now, lines);
        if cycled.ended == Ended::Good {
            for ((_, bytes), (shown, answer)) in self.master.both().zip(input.iter_mut().zip(answers)) {
                if let (Some(_), Some(bytes)) = (answer, bytes.first_chunk()) {
                    *shown = InWord(u32::from_be_bytes(*bytes));
                }
            }
        }
        cycled
    }

    /// Runs one slot that ends at `now`, with the bytes that master and slaves hold.
    pub fn run(&mut self, now: Instant, lines: &mut impl Lines) -> SlotResult {
        self.ended = now;
        let due = now.as_nanos().checked_div(self.bit.as_nanos()).unwrap_or_default();
        let began = self.sent;
        let bits = due.saturating_sub(began);
        if let Some(slot) = self.sound_slot(bits, lines) {
            self.take(&slot);
            return SlotResult { ended: Ended::Good, verdict: Verdict::Good, place: self.master.place() };
        }
        let ended = self.slot(bits, lines);
        let verdict = self.verdict(ended, self.sent - began);
        SlotResult { ended, verdict, place: self.master.place() }
    }

    /// The coming slot of at least so many bits, if it is sound: nothing can happen to its bits and nobody looks at
    /// them, so that what they will do is known. That is so if the master sends data to as many devices as there are,
    /// every receiver is in step, every chip has the place and the length that the master's table gives it, only the
    /// last one turns the line back, and the segments promise to change nothing as long as the *slot* lasts: a hit in
    /// the pause can still spoil the frame before it.
    fn sound_slot(&self, bits: u64, lines: &impl Lines) -> Option<SoundSlot> {
        let slaves = self.slaves.as_ref();
        if self.was_silent || !self.master.is_sound(slaves.len()) {
            return None;
        }
        let mut all = 0;
        for (position, (slave, bytes)) in slaves.iter().zip(self.master.lengths()).enumerate() {
            let outgoing = if position + 1 == slaves.len() { Outgoing::Off } else { Outgoing::On };
            if !slave.is_sound(bytes, outgoing) {
                return None;
            }
            all += bytes;
        }
        let slot = SoundSlot::new(slaves.len(), all, bits);
        lines.quiet(self.sent, self.sent.saturating_add(slot.bits)).then_some(slot)
    }

    /// Takes a sound slot as a whole.
    fn take(&mut self, slot: &SoundSlot) {
        for (slave, (out, input)) in self.slaves.as_mut().iter_mut().zip(self.master.both()) {
            slave.take(slot, out, input);
        }
        self.master.take(slot);
        self.sent = self.sent.saturating_add(slot.bits);
    }

    /// One slot of at least so many bits, and at least what its frame needs to come home.
    fn slot(&mut self, bits: u64, lines: &mut impl Lines) -> Ended {
        let began = self.sent;
        match self.master.begin() {
            Slot::Silent => {
                let mut left = bits.max(64);
                while left > 0 {
                    let next = left.min(64);
                    self.pause(Bits::idle(next as u32), lines);
                    left -= next;
                }
                self.was_silent = true;
            }
            Slot::Frame => {
                if self.was_silent {
                    self.pause(statuses(u32::from(2 * STATUS_BEFORE_FRAME)), lines);
                    self.was_silent = false;
                }
                while let Some(telegram) = self.master.transmit() {
                    let home = self.pass(telegram, lines);
                    self.master.receive(home);
                }
                let mut left = pause_telegrams(bits, self.sent - began, self.slaves.as_ref().len());
                // The first ones close the frame and throw switches; what is behind a switch needs some of its own.
                let mut next = u64::from(STATUS_BEFORE_FRAME);
                while left > 0 {
                    self.pause(statuses(next as u32), lines);
                    left -= next;
                    next = left.min(12);
                }
            }
        }
        self.master.end(self.sent - began)
    }

    fn pause(&mut self, line: Bits, lines: &mut impl Lines) {
        let home = self.pass(line, lines);
        self.master.receive_pause(home);
    }

    /// Sends some bits around; what comes home.
    fn pass(&mut self, sent: Bits, lines: &mut impl Lines) -> Bits {
        let idle = Bits::idle(sent.count);
        let slaves = self.slaves.as_mut();
        let last = slaves.len();
        let mut line = sent;
        let mut home = None;
        for (segment, slave) in slaves.iter_mut().enumerate() {
            // A switch that is thrown now is thrown behind these bits.
            let outgoing = slave.outgoing();
            line = slave.regenerate(lines.pass(segment, self.sent, line));
            // A device without supply turns nothing back.
            if outgoing == Outgoing::Off && slave.condition() == Condition::Running {
                home.get_or_insert(line);
                line = idle;
            }
        }
        let home = if last == 0 { sent } else { home.unwrap_or(idle) };
        let home = lines.pass(last, self.sent, home);
        lines.passed(self.sent, sent.count, slaves);
        self.sent = self.sent.saturating_add(u64::from(sent.count));
        home
    }

    fn verdict(&self, ended: Ended, bits: u64) -> Verdict {
        let slaves = self.slaves.as_ref();
        let leading = |is: &dyn Fn(&Slave) -> bool| slaves.iter().take_while(|slave| is(slave)).count();
        let heard = leading(&|slave| slave.condition() == Condition::Running && slave.ages().0 < bits);
        let took = leading(&|slave| slave.ages().1.is_some_and(|age| age < bits));
        match ended {
            Ended::Good if took == slaves.len() => Verdict::Good,
            Ended::Good | Ended::Faulty if took > 0 => Verdict::Bad { segment: took },
            _ if heard < slaves.len() => Verdict::Silent { segment: heard },
            _ => Verdict::Bad { segment: 0 },
        }
    }

    /// The master.
    #[must_use]
    pub const fn master(&self) -> &Master {
        &self.master
    }

    /// The master, to be told what to do.
    pub const fn master_mut(&mut self) -> &mut Master {
        &mut self.master
    }

    /// The slaves, by position.
    #[must_use]
    pub fn slaves(&self) -> &[Slave] {
        self.slaves.as_ref()
    }

    /// The slaves, to be changed.
    pub fn slaves_mut(&mut self) -> &mut [Slave] {
        self.slaves.as_mut()
    }

    /// The least time of a slot in which a data cycle of the whole ring fits.
    #[must_use]
    pub fn shortest(&self) -> Duration {
        let slaves = self.slaves.as_ref();
        let bytes = slaves.iter().map(Slave::bytes).sum();
        let bits = frame_bits(bytes) + STATUS_BITS * pause_telegrams(0, 0, slaves.len());
        Duration::from_nanos(bits.saturating_mul(self.bit.as_nanos()))
    }

    /// Line bits since the ring was made.
    #[must_use]
    pub const fn sent(&self) -> u64 {
        self.sent
    }

    /// Time begins now: the bits so far count as sent before it.
    pub const fn begin_time(&mut self) {
        self.sent = 0;
        self.ended = Instant::ZERO;
    }

    /// The OUT word that the device at a position holds: the last one taken, 0 before the first and in reset.
    #[must_use]
    pub fn out_word(&self, position: usize) -> OutWord {
        self.taken(position).shown()
    }

    /// What the chip at a position holds, and how often it was reset.
    #[must_use]
    pub fn taken(&self, position: usize) -> Taken {
        self.slaves().get(position).map(Slave::taken).unwrap_or_default()
    }

    /// The same at `at`, a time in the last slot. What the chip held before its last change but one is forgotten.
    #[must_use]
    pub fn taken_at(&self, position: usize, at: Instant) -> Taken {
        // A bit that has only begun is not there yet.
        let bits = self.ended.since(at).as_nanos().div_ceil(self.bit.as_nanos().max(1));
        self.slaves().get(position).map(|slave| slave.taken_before(bits)).unwrap_or_default()
    }

    /// The lamps of the device at a position; `None` past the last one.
    #[must_use]
    pub fn lamps(&self, position: usize) -> Option<Lamps> {
        self.slaves().get(position).map(Slave::lamps)
    }
}
