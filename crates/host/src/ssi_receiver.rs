//! The receiver of an SSI: told the levels of Clock+ and Data+ whenever one of them changes, it hands out what was
//! transferred [R104..R120]. It is the mirror of the encoder's shift register, and as that a total function: whatever
//! levels come at whatever times, it neither waits nor fails.
//!
//! Calling order: [`SsiReceiver::levels`] at every change, [`SsiReceiver::time`] when some time has passed without one,
//! [`SsiReceiver::end`] when nothing more will be seen. Each gives the transfer that has ended by then; a transfer
//! ends when more than t_M has passed since its last falling clock edge.
//!
//! ```
//! use encoring_host::ssi_receiver::{SsiReceiver, TakenAt};
//! use encoring_words::parameter::SsiValues;
//! use encoring_words::ssi_frame::{Level, SsiFormat, SsiFrame};
//! use encoring_words::{Instant, Week};
//!
//! let format = SsiFormat::new(SsiValues::from_data(0x1F), Week::AK40);
//! let mut receiver = SsiReceiver::new(format, TakenAt::Falling);
//! receiver.levels(Instant(0), Level::High, Level::High);
//! let (frame, mut at) = (SsiFrame::new(0x27_0F, format), 100_000);
//! for pulse in 1..=33 {
//!     receiver.levels(Instant(at), Level::Low, frame.level(pulse - 1));
//!     receiver.levels(Instant(at + 500), Level::High, frame.level(pulse));
//!     at += 1_000;
//! }
//! let transfer = receiver.time(Instant(at + 20_000)).unwrap();
//! assert_eq!((transfer.clocks, transfer.field, transfer.position()), (33, 0x4E1F, Some(9_999)));
//! ```

mod verdict;

#[cfg(test)]
mod tests;

use core::fmt;

use encoring_words::ssi_frame::{Level, MONO_PERIOD, REPETITION_PULSES, SsiCheck, SsiFormat};
use encoring_words::{Duration, Instant};

pub use verdict::{SSI_FAULTS, SsiFault};

/// The clock edge at which the receiver takes the data [R109]. Data change shortly after a rising edge, so both edges
/// bring the same bits, the High of rest first, unless the cable is long: then the falling edge comes too early.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TakenAt {
    /// The level just before a rising edge.
    Rising,
    /// The level just before a falling edge.
    #[default]
    Falling,
}

/// What was transferred.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiTransfer {
    /// Its first falling clock edge; of a transfer that had begun before anything was seen, the first thing seen.
    pub began: Instant,
    /// Its last falling clock edge.
    pub ended: Instant,
    /// Its rising clock edges.
    pub clocks: u32,
    /// The bits that were received of the field, the last one lowest.
    pub field: u32,
    /// How many these are: with enough clocks all of the format's.
    pub received: u8,
    /// The shortest and the longest time between two falling edges; `None` if there was only one.
    pub periods: Option<(Duration, Duration)>,
    /// What is wrong with it.
    pub fault: Option<SsiFault>,
    format: SsiFormat,
}

impl SsiTransfer {
    /// The bits that were received of the field, as text: `0` and `1`, in the order in which they came.
    #[must_use]
    pub const fn bits(&self) -> FieldBits {
        FieldBits { field: self.field, count: self.received }
    }

    /// What the field says, whatever is wrong with the transfer; `None` if not all of its bits were received.
    #[must_use]
    pub const fn reading(&self) -> Option<u32> {
        if self.received == self.format.bits() { Some(self.format.position(self.field)) } else { None }
    }

    /// The position; `None` with a fault.
    #[must_use]
    pub const fn position(&self) -> Option<u32> {
        if self.fault.is_none() { self.reading() } else { None }
    }
}

/// Bits that came, displayed as `0` and `1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldBits {
    field: u32,
    count: u8,
}

impl fmt::Display for FieldBits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut digits = [b'0'; u32::BITS as usize];
        for (place, digit) in digits.iter_mut().rev().enumerate() {
            *digit |= (self.field >> place & 1) as u8;
        }
        let came = digits.len().saturating_sub(usize::from(self.count));
        f.pad(str::from_utf8(digits.get(came..).unwrap_or_default()).unwrap_or_default())
    }
}

/// Receives one transfer after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiReceiver {
    format: SsiFormat,
    taken_at: TakenAt,
    /// Clocks of every transfer, if they are known.
    expected: Option<u32>,
    now: Instant,
    clock: Level,
    data: Level,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing was told yet.
    Untold,
    /// Told since then, and no falling edge yet: a transfer may have begun before.
    Unsure { since: Instant },
    /// Between transfers, the last one's last falling edge at that time.
    Rest { fell: Option<Instant> },
    /// Within one.
    Transfer(Running),
}

/// What is known of a transfer's beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Beginning {
    /// The line was at rest before.
    Seen,
    /// Nothing speaks against it, but the line was not seen long enough.
    Unsure,
    /// It had begun before anything was seen.
    Missed,
}

/// A transfer so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Running {
    beginning: Beginning,
    /// Since the last falling edge of the transfer before; `None` if there was none.
    pause: Option<Duration>,
    began: Instant,
    fell: Instant,
    falls: u32,
    clocks: u32,
    periods: Option<(Duration, Duration)>,
    /// The longest time from a falling edge to the next rising one.
    longest_low: Duration,
    /// When the last bit would be taken if no further edge came.
    due: Instant,
    /// The level at that time, once it has passed.
    settled: Option<Level>,
    taken: Taken,
}

/// The levels taken so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Taken {
    /// Before the first bit: High, unless something is wrong.
    rest: Option<Level>,
    /// Bits after it, of the field and after the field.
    bits: u32,
    field: u32,
    /// A bit was Low.
    low: bool,
    /// A bit that must be Low after the field was High.
    trailing_high: bool,
    /// A repeated bit was another one than the first time.
    unlike: bool,
}

impl SsiReceiver {
    /// A receiver that knows nothing of the line yet.
    #[must_use]
    pub const fn new(format: SsiFormat, taken_at: TakenAt) -> Self {
        let (clock, data) = (Level::High, Level::High);
        Self { format, taken_at, expected: None, now: Instant::ZERO, clock, data, phase: Phase::Untold }
    }

    /// The same where every transfer must have so many clocks. Without it any number is right that brings the field.
    #[must_use]
    pub const fn expecting(self, clocks: u32) -> Self {
        Self { expected: Some(clocks), ..self }
    }

    /// The levels from `now` on; gives the transfer that ended before. A time before the last one told counts as that.
    #[inline]
    pub fn levels(&mut self, now: Instant, clock: Level, data: Level) -> Option<SsiTransfer> {
        let ended = self.time(now);
        if self.phase == Phase::Untold {
            self.begin(clock);
        } else if clock != self.clock {
            self.edge(clock);
        }
        (self.clock, self.data) = (clock, data);
        ended
    }

    /// Time has come to `now` without a change; gives the transfer that has ended by then.
    #[inline]
    pub fn time(&mut self, now: Instant) -> Option<SsiTransfer> {
        self.now = self.now.max(now);
        let Phase::Transfer(running) = &mut self.phase else { return None };
        if self.now > running.due {
            running.settled.get_or_insert(self.data);
        }
        (self.now.since(running.fell) > MONO_PERIOD).then(|| self.finish(Ending::Seen)).flatten()
    }

    /// Nothing more is seen after `now`; gives the transfer that ended, or was cut off. The receiver knows nothing of
    /// the line afterwards.
    pub fn end(&mut self, now: Instant) -> Option<SsiTransfer> {
        let ended = self.time(now).or_else(|| self.finish(Ending::CutOff));
        self.phase = Phase::Untold;
        ended
    }

    /// The first levels that are seen.
    fn begin(&mut self, clock: Level) {
        self.phase = match clock {
            Level::High => Phase::Unsure { since: self.now },
            Level::Low => Phase::Transfer(Running::new(self.now, Beginning::Missed, None)),
        };
    }

    #[inline]
    fn edge(&mut self, clock: Level) {
        let (now, data, format) = (self.now, self.data, self.format);
        let takes = (clock == Level::Low) == (self.taken_at == TakenAt::Falling);
        match (&mut self.phase, clock) {
            (Phase::Untold | Phase::Unsure { .. } | Phase::Rest { .. }, Level::High) => {}
            (Phase::Untold, Level::Low) => self.begin_transfer(Beginning::Missed, None),
            (Phase::Unsure { since }, Level::Low) => {
                let beginning = match (now.since(*since) > MONO_PERIOD, data) {
                    (true, _) => Beginning::Seen,
                    (false, Level::High) => Beginning::Unsure,
                    (false, Level::Low) => Beginning::Missed,
                };
                self.begin_transfer(beginning, None);
            }
            (Phase::Rest { fell }, Level::Low) => {
                let pause = fell.map(|fell| now.since(fell));
                self.begin_transfer(Beginning::Seen, pause);
            }
            (Phase::Transfer(running), _) => {
                if takes {
                    running.take(data, format);
                }
                match clock {
                    Level::Low => running.fall(now),
                    Level::High => running.rise(now, self.taken_at),
                }
            }
        }
    }

    fn begin_transfer(&mut self, beginning: Beginning, pause: Option<Duration>) {
        let mut running = Running::new(self.now, beginning, pause);
        if self.taken_at == TakenAt::Falling {
            running.take(self.data, self.format);
        }
        self.phase = Phase::Transfer(running);
    }

    /// Ends the transfer, if there is one of which something was seen.
    fn finish(&mut self, ending: Ending) -> Option<SsiTransfer> {
        let Phase::Transfer(mut running) = self.phase else { return None };
        self.phase = Phase::Rest { fell: Some(running.fell) };
        if running.beginning == Beginning::Missed && running.clocks == 0 {
            return None;
        }
        // No further edge takes the last bit. Before it was due the line may have been settling.
        if running.taken.bits < running.clocks
            && let Some(settled) = running.settled
        {
            running.take(settled, self.format);
        }
        Some(verdict::transfer(&running, self.format, self.expected, ending))
    }
}

/// How a transfer ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    /// The mono period passed.
    Seen,
    /// Nothing more was seen.
    CutOff,
}

impl Running {
    const fn new(began: Instant, beginning: Beginning, pause: Option<Duration>) -> Self {
        let taken = Taken { rest: None, bits: 0, field: 0, low: false, trailing_high: false, unlike: false };
        Self {
            beginning,
            pause,
            began,
            fell: began,
            falls: 1,
            clocks: 0,
            periods: None,
            longest_low: Duration::ZERO,
            due: Instant(u64::MAX),
            settled: None,
            taken,
        }
    }

    fn fall(&mut self, now: Instant) {
        let period = now.since(self.fell);
        let (shortest, longest) = self.periods.unwrap_or((period, period));
        self.periods = Some((shortest.min(period), longest.max(period)));
        self.fell = now;
        self.falls = self.falls.saturating_add(1);
    }

    fn rise(&mut self, now: Instant, taken_at: TakenAt) {
        let low = now.since(self.fell);
        // Where the clock went on like this, the next edge that takes would come then; before the first period is over
        // it is taken to be twice the Low phase. Data+ is High again after the mono period, which is no exact time: half
        // of what is left of it is waited for.
        let period = self.periods.map_or(low + low, |(_, longest)| longest);
        let after = match taken_at {
            TakenAt::Rising => period,
            TakenAt::Falling => Duration(period.as_nanos().saturating_sub(low.as_nanos())),
        };
        let left = MONO_PERIOD.as_nanos().saturating_sub(low.as_nanos());
        self.due = now + after.min(Duration(left / 2));
        self.settled = None;
        self.longest_low = self.longest_low.max(low);
        self.clocks = self.clocks.saturating_add(1);
    }

    /// Takes the level that stands for the pulse that has passed; before the first one it is that of rest.
    fn take(&mut self, level: Level, format: SsiFormat) {
        if self.clocks == 0 {
            self.taken.rest = Some(level);
        } else if self.taken.bits < self.clocks {
            self.taken.bit(level, format);
        }
    }
}

impl Taken {
    fn bit(&mut self, level: Level, format: SsiFormat) {
        let (index, bits) = (self.bits, u32::from(format.bits()));
        self.bits = index.saturating_add(1);
        self.low |= level == Level::Low;
        if index < bits {
            self.field = self.field << 1 | level.bit();
            return;
        }
        let repeated = match format.check() {
            SsiCheck::Repetition => index % u32::from(REPETITION_PULSES),
            SsiCheck::None | SsiCheck::OddParity => bits,
        };
        match bits.checked_sub(1).and_then(|last| last.checked_sub(repeated)) {
            Some(place) => self.unlike |= self.field >> place & 1 != level.bit(),
            None => self.trailing_high |= level == Level::High,
        }
    }
}
