//! A reader on the SSI of an encoder: it clocks at its period beside the bus, and keeps what it read last.
//!
//! The reader drives Clock+ in virtual time, the encoder answers edge by edge, and `host::ssi_receiver` takes what
//! comes back. What troubles the line between them stands between the two.

mod settings;

use std::collections::VecDeque;

use encoring_host::ssi_receiver::{SsiReceiver, SsiTransfer};
use encoring_ring::image::SsiShown;
use encoring_words::ssi_frame::{Level, MONO_PERIOD, SsiFormat};
use encoring_words::{Duration, Instant};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::fault::{PER_MILLION, SsiTrouble};

pub use settings::{PlacedReader, READER_CLOCKS_MAX, READER_HZ, SsiCard, SsiSettings};

/// The encoder at the other end of the line.
pub(crate) trait Clocked {
    /// Takes the level of Clock+.
    fn ssi_clock(&mut self, at: Instant, clock: Level);

    /// Data+, and when it changes without an edge.
    fn ssi_level(&self, at: Instant) -> (Level, Option<Instant>);

    /// How the bits are laid out.
    fn ssi_format(&self) -> SsiFormat;
}

/// What a reader read last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiRead {
    /// When the transfer was over.
    pub at: Instant,
    /// What it brought. Of a transfer that broke, the last piece.
    pub transfer: SsiTransfer,
}

/// A level that changed, as the reader drives and sees them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) at: Instant,
    pub(crate) clock: Level,
    pub(crate) data: Level,
}

/// The line from an encoder's SSI, and what hangs on its other end.
#[derive(Clone, Debug)]
pub(crate) struct SsiLine {
    reader: Option<Box<SsiReader>>,
    trouble: Option<SsiTrouble>,
    chance: Pcg64Mcg,
    /// What changed since it was taken last, if somebody looks on.
    seen: Option<Vec<Seen>>,
}

/// A reader at work.
#[derive(Clone, Debug)]
pub struct SsiReader {
    settings: SsiSettings,
    /// When the present transfer began, or the next one will.
    begins: Instant,
    /// Clock edges of it so far.
    edges: u32,
    receiver: Option<SsiReceiver>,
    clock: Level,
    /// Data+ at the encoder.
    sent: Level,
    /// When the encoder will let Data+ go High without an edge.
    released: Option<Instant>,
    /// Data+ on its way: when each level arrives.
    coming: VecDeque<(Instant, Level)>,
    /// Data+ as it arrived last.
    arrived: Level,
    pulse: Pulse,
    piece: Option<SsiTransfer>,
    read: Option<SsiRead>,
    count: u64,
}

/// What chance does to the present clock pulse.
#[derive(Clone, Copy, Debug, Default)]
struct Pulse {
    lost: bool,
    flipped: bool,
}

/// What happens next at a reader.
#[derive(Clone, Copy)]
enum Next {
    Released,
    Arrives(Level),
    Edge(Level),
    Over,
}

impl SsiLine {
    pub(crate) fn new(seed: u64) -> Self {
        Self { reader: None, trouble: None, chance: Pcg64Mcg::seed_from_u64(seed), seen: None }
    }

    pub(crate) fn reader(&self) -> Option<&SsiReader> {
        self.reader.as_deref()
    }

    /// From `now` on another reader hangs on it, or none. What the one before has read stays with a change of settings.
    pub(crate) fn hang(&mut self, now: Instant, settings: Option<SsiSettings>) {
        let before = self.reader.take();
        self.reader = settings.map(|settings| Box::new(SsiReader::new(settings, now, before.as_deref())));
        self.look(now);
    }

    pub(crate) const fn set_trouble(&mut self, trouble: Option<SsiTrouble>) {
        self.trouble = trouble;
    }

    /// Keeps what changes from now on, or nothing more.
    pub(crate) fn keep_seen(&mut self, kept: Option<Vec<Seen>>) {
        self.seen = kept;
    }

    /// What changed since the last call.
    pub(crate) fn take_seen(&mut self) -> impl Iterator<Item = Seen> {
        self.seen.iter_mut().flat_map(|seen| seen.drain(..))
    }

    /// `true` if nothing happens on it by itself.
    pub(crate) const fn is_idle(&self) -> bool {
        self.reader.is_none()
    }

    /// Does all up to and with `until`.
    pub(crate) fn run(&mut self, until: Instant, encoder: &mut impl Clocked) {
        while let Some((at, next)) =
            self.reader.as_deref().map(SsiReader::next).filter(|(at, _)| *at <= until)
        {
            self.step(at, next, encoder);
            self.look(at);
        }
    }

    fn step(&mut self, at: Instant, next: Next, encoder: &mut impl Clocked) {
        let Some(reader) = self.reader.as_deref_mut() else { return };
        let delay = Duration(self.trouble.map_or(0, SsiTrouble::data_delay_ns));
        match next {
            Next::Released => {
                reader.released = None;
                reader.sent = Level::High;
                reader.coming.push_back((at + delay, Level::High));
            }
            Next::Arrives(level) => {
                reader.coming.pop_front();
                reader.arrived = level;
                reader.tell(at, self.trouble);
            }
            Next::Edge(clock) => {
                let extra = reader.draw(clock, self.trouble, &mut self.chance);
                reader.clock_edge(at, clock, encoder, self.trouble);
                if extra {
                    encoder.ssi_clock(at, Level::Low);
                    encoder.ssi_clock(at, Level::High);
                }
                reader.answer(at, delay, encoder);
            }
            Next::Over => reader.finish(at),
        }
    }

    /// Keeps the levels as they are from `at` on, if somebody looks on.
    fn look(&mut self, at: Instant) {
        let Some(seen) = &mut self.seen else { return };
        let levels = self.reader.as_deref().map(|reader| (reader.clock, reader.sees(self.trouble)));
        let (clock, data) = levels.unwrap_or((Level::High, Level::High));
        seen.push(Seen { at, clock, data });
    }
}

impl SsiReader {
    fn new(settings: SsiSettings, now: Instant, before: Option<&Self>) -> Self {
        Self {
            settings,
            begins: now + settings.every(),
            edges: 0,
            receiver: None,
            clock: Level::High,
            sent: before.map_or(Level::High, |before| before.sent),
            released: before.and_then(|before| before.released),
            coming: before.map(|before| before.coming.clone()).unwrap_or_default(),
            arrived: before.map_or(Level::High, |before| before.arrived),
            pulse: Pulse::default(),
            piece: None,
            read: before.and_then(|before| before.read),
            count: before.map_or(0, |before| before.count),
        }
    }

    /// How it reads.
    #[must_use]
    pub const fn settings(&self) -> SsiSettings {
        self.settings
    }

    /// What it read last; `None` before its first transfer is over.
    #[must_use]
    pub const fn read(&self) -> Option<&SsiRead> {
        self.read.as_ref()
    }

    /// How many transfers are over.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// What it shows beside the bus: verdict 0 before its first transfer, 1 without a fault, and from 2 on the faults in
    /// the order of [`SsiFault`](encoring_host::ssi_receiver::SsiFault).
    #[must_use]
    pub fn shown(&self) -> SsiShown {
        let Some(SsiRead { transfer, .. }) = self.read else { return SsiShown::default() };
        let verdict = transfer.fault.map_or(1, |fault| 2 + fault as u16);
        SsiShown { field: transfer.field, verdict, count: self.count as u16 }
    }

    /// What comes next, and when.
    fn next(&self) -> (Instant, Next) {
        let (period, clocks) = (self.settings.period(), self.settings.clocks());
        let fall = |pulse: u32| self.begins + Duration(u64::from(pulse) * period);
        let pulse = self.edges / 2;
        let own = if pulse >= clocks {
            let over = fall(clocks.saturating_sub(1)) + MONO_PERIOD + Duration(1);
            (over, Next::Over)
        } else if self.edges.is_multiple_of(2) {
            (fall(pulse), Next::Edge(Level::Low))
        } else {
            (fall(pulse) + Duration(period / 2), Next::Edge(Level::High))
        };
        // At one moment the encoder comes first, then the cable, then the reader.
        let released = self.released.map(|at| (at, Next::Released));
        let arrives = self.coming.front().map(|(at, level)| (*at, Next::Arrives(*level)));
        let soonest = [arrives, released].into_iter().flatten();
        soonest.fold(own, |soonest, other| if other.0 <= soonest.0 { other } else { soonest })
    }

    /// What becomes of the pulse that this edge begins or is in; `true` if another one follows.
    fn draw(&mut self, clock: Level, trouble: Option<SsiTrouble>, chance: &mut Pcg64Mcg) -> bool {
        let mut hit = |per_million: u32| chance.random_range(0..PER_MILLION) < per_million;
        match (clock, trouble) {
            (Level::Low, Some(SsiTrouble::Lost(per_million))) => self.pulse.lost = hit(per_million),
            (Level::Low, _) => self.pulse.lost = false,
            (Level::High, Some(SsiTrouble::Flips(per_million))) => self.pulse.flipped = hit(per_million),
            (Level::High, Some(SsiTrouble::Added(per_million))) => return hit(per_million),
            (Level::High, _) => self.pulse.flipped = false,
        }
        false
    }

    /// Drives an edge: the receiver takes what has arrived by then, and the encoder hears it.
    fn clock_edge(
        &mut self,
        at: Instant,
        clock: Level,
        encoder: &mut impl Clocked,
        trouble: Option<SsiTrouble>,
    ) {
        if self.edges == 0 {
            // The encoder latches word and format together.
            if !self.pulse.lost {
                encoder.ssi_clock(at, clock);
            }
            let format = self.settings.card().reads(encoder.ssi_format());
            let receiver = SsiReceiver::new(format, self.settings.taken_at());
            self.receiver = Some(receiver.expecting(self.settings.clocks()));
            self.clock = Level::High;
            self.tell(Instant::ZERO, trouble);
        } else if !self.pulse.lost {
            encoder.ssi_clock(at, clock);
        }
        self.edges += 1;
        self.clock = clock;
        self.tell(at, trouble);
    }

    /// What the encoder puts out from `at` on.
    fn answer(&mut self, at: Instant, delay: Duration, encoder: &impl Clocked) {
        let (level, released) = encoder.ssi_level(at);
        self.released = released;
        if level != self.sent {
            self.sent = level;
            self.coming.push_back((at + delay, level));
        }
    }

    /// The levels as the reader has them from `at` on.
    fn tell(&mut self, at: Instant, trouble: Option<SsiTrouble>) {
        let (clock, data) = (self.clock, self.sees(trouble));
        let piece = self.receiver.as_mut().and_then(|receiver| receiver.levels(at, clock, data));
        self.piece = piece.or(self.piece);
    }

    /// Data+ as the reader sees it.
    const fn sees(&self, trouble: Option<SsiTrouble>) -> Level {
        match (trouble, self.arrived, self.pulse.flipped) {
            (Some(SsiTrouble::Low), ..) => Level::Low,
            (Some(SsiTrouble::High), ..) => Level::High,
            (_, Level::Low, true) | (_, Level::High, false) => Level::High,
            (_, Level::Low, false) | (_, Level::High, true) => Level::Low,
        }
    }

    /// A transfer is over.
    fn finish(&mut self, at: Instant) {
        let last = self.receiver.as_mut().and_then(|receiver| receiver.time(at));
        if let Some(transfer) = last.or(self.piece.take()) {
            self.read = Some(SsiRead { at, transfer });
            self.count = self.count.saturating_add(1);
        }
        self.pulse = Pulse::default();
        self.edges = 0;
        self.begins = self.begins + self.settings.every();
    }
}
