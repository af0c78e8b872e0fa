//! What happens to a ring, from what its master says at each poll.

#[cfg(test)]
#[allow(clippy::panic, reason = "a test may panic")]
mod tests;

use std::fmt;

use encoring_ring::diagnostics::{Diagnosis, status};
use encoring_words::{Duration, Instant};

use crate::bus::BusError;
use crate::judge::Ring;

/// Single faulty data cycles are told once in this time.
const FAULTY_AGAIN_AFTER: Duration = Duration::from_secs(10);

/// A ring that stands still again sooner is in the same trouble: a loose contact stops it many times a second.
const CALM: Duration = Duration::from_secs(1);

/// What the master says of one trouble is told up to so many times.
const SAID_MAX: usize = 8;

/// What changes with services of a controller, or from one data cycle to the next.
const FLEETING: u16 = status::SS_INFO | status::DC_RESULT | status::RESULT | status::SY_RESULT;

/// What the master of a ring says on which all is well.
const SOUND: Diagnosis =
    Diagnosis { status: Some(status::READY | status::ACTIVE | status::RUN), parameter: Some(0) };

/// Something that happened to a ring.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RingNews {
    /// It stands still.
    Stopped(Diagnosis),
    /// It has run again for a second.
    Runs {
        /// How often it was seen to stop.
        times: u32,
        /// How long it was seen standing, in all.
        stood_for: Duration,
        /// What its master says.
        diagnosis: Diagnosis,
    },
    /// Its master says something else than before.
    Says(Diagnosis),
    /// A data cycle was faulty, and the ring ran on.
    FaultyCycle(Diagnosis),
    /// What the master says could not be read.
    Unread(BusError),
}

/// What was told of a ring so far.
#[derive(Clone, Debug, Default)]
pub struct RingHistory {
    /// What the master last said, fleeting bits aside.
    said: Option<Diagnosis>,
    trouble: Option<Trouble>,
    faulty: Option<Instant>,
    unread: Option<BusError>,
}

/// A ring that stands still, or did so a moment ago.
#[derive(Clone, Debug)]
struct Trouble {
    /// What it did last, and since when.
    stands: bool,
    since: Instant,
    times: u32,
    /// How long it stood before that.
    stood_for: Duration,
    /// What the master said of it, fleeting bits aside.
    said: Vec<Diagnosis>,
}

impl Trouble {
    fn new(at: Instant, said: Diagnosis) -> Self {
        Self { stands: true, since: at, times: 1, stood_for: Duration::ZERO, said: vec![said] }
    }

    /// `true` if the master says of it what it has not said yet.
    fn stands(&mut self, at: Instant, says: Diagnosis) -> bool {
        if !self.stands {
            (self.stands, self.since) = (true, at);
            self.times = self.times.saturating_add(1);
        }
        let new = self.said.len() < SAID_MAX && !self.said.contains(&says);
        if new {
            self.said.push(says);
        }
        new
    }

    /// `true` if it is over.
    fn runs(&mut self, at: Instant) -> bool {
        if self.stands {
            self.stood_for = self.stood_for + at.since(self.since);
            (self.stands, self.since) = (false, at);
        }
        at.since(self.since) >= CALM
    }
}

impl RingHistory {
    /// Takes what a poll brought, and says what is new.
    pub fn take(&mut self, at: Instant, told: &Result<Diagnosis, BusError>) -> Option<RingNews> {
        let diagnosis = match told {
            Ok(diagnosis) if *diagnosis == Diagnosis::default() => return None,
            Ok(diagnosis) => *diagnosis,
            Err(error) => return self.failed(error),
        };
        let read_again = self.unread.take().is_some();
        let lasting = Diagnosis { status: diagnosis.status.map(|status| status & !FLEETING), ..diagnosis };
        // A ring on which all is well is nothing new.
        let before =
            self.said.replace(lasting).unwrap_or(if diagnosis.status.is_some() { SOUND } else { lasting });
        match (&mut self.trouble, diagnosis.reaches(0)) {
            (None, Some(false)) => {
                self.trouble = Some(Trouble::new(at, lasting));
                Some(RingNews::Stopped(diagnosis))
            }
            (Some(trouble), Some(false)) => {
                (trouble.stands(at, lasting) || read_again).then_some(RingNews::Says(diagnosis))
            }
            (Some(trouble), Some(true)) => {
                let over = trouble.runs(at);
                let Trouble { times, stood_for, .. } = *trouble;
                if over {
                    self.trouble = None;
                }
                over.then_some(RingNews::Runs { times, stood_for, diagnosis })
            }
            _ if read_again || differs(before, lasting) => Some(RingNews::Says(diagnosis)),
            _ => self.faulty_cycle(at, diagnosis),
        }
    }

    fn failed(&mut self, error: &BusError) -> Option<RingNews> {
        let told = self.unread.as_ref() == Some(error);
        self.unread = Some(error.clone());
        (!told).then(|| RingNews::Unread(error.clone()))
    }

    fn faulty_cycle(&mut self, at: Instant, diagnosis: Diagnosis) -> Option<RingNews> {
        let is_faulty = diagnosis.status.is_some_and(|word| word & status::DC_RESULT != 0);
        if !is_faulty || diagnosis.reaches(0) != Some(true) {
            return None;
        }
        let told = self.faulty.is_some_and(|last| at.since(last) < FAULTY_AGAIN_AFTER);
        if !told {
            self.faulty = Some(at);
        }
        (!told).then_some(RingNews::FaultyCycle(diagnosis))
    }
}

/// Registers that are not shown differ from nothing.
fn differs(before: Diagnosis, now: Diagnosis) -> bool {
    before.status.zip(now.status).is_some_and(|(before, now)| before != now)
        || before.parameter.zip(now.parameter).is_some_and(|(before, now)| before != now)
}

/// What an encoder's judge is to know of the ring.
#[must_use]
pub fn ring_at(told: &Result<Diagnosis, BusError>, position: usize) -> Ring {
    match told {
        Ok(diagnosis) if diagnosis.reaches(position) == Some(false) => Ring::Stands(*diagnosis),
        Ok(_) => Ring::Runs,
        Err(_) => Ring::Unread,
    }
}

impl RingNews {
    /// What the master said with it.
    #[must_use]
    pub const fn diagnosis(&self) -> Option<Diagnosis> {
        match self {
            Self::Stopped(diagnosis)
            | Self::Runs { diagnosis, .. }
            | Self::Says(diagnosis)
            | Self::FaultyCycle(diagnosis) => Some(*diagnosis),
            Self::Unread(_) => None,
        }
    }
}

impl fmt::Display for RingNews {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped(diagnosis) | Self::Says(diagnosis) => diagnosis.fmt(f),
            Self::Runs { times: 1, stood_for, diagnosis } => {
                write!(f, "the ring stood still for {}; now {diagnosis}", readable(*stood_for))
            }
            Self::Runs { times, stood_for, diagnosis } => {
                let stood_for = readable(*stood_for);
                write!(f, "the ring stood still {times} times, for {stood_for} in all; now {diagnosis}")
            }
            Self::FaultyCycle(diagnosis) => write!(f, "a data cycle was faulty; {diagnosis}"),
            Self::Unread(error) => {
                write!(
                    f,
                    "what the ring's master says was not read: {error}; whether the ring runs is not known"
                )
            }
        }
    }
}

/// As people read it.
fn readable(span: Duration) -> String {
    match span.as_nanos() / 1_000_000 {
        ms @ 0..1_000 => format!("{ms} ms"),
        ms => format!("{}.{} s", ms / 1_000, ms / 100 % 10),
    }
}
