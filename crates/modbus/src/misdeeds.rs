//! The faults that a server has at a moment, and what they do to a request and its answer.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use crate::gateway_fault::{FAULTS_MAX, GatewayFault, GatewayFaultError, GatewayMisdeed};

/// The faults that a server has. Clones are of the same.
#[derive(Clone, Debug, Default)]
pub struct GatewayFaults(Arc<Mutex<Faults>>);

#[derive(Debug, Default)]
struct Faults {
    /// Each with the time from which its own times count.
    all: Vec<(Instant, GatewayFault)>,
    requests: u64,
    /// Once it has died.
    dead: Option<Dead>,
}

/// What it died of, and since when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Dead {
    fault: GatewayFault,
    since: Instant,
}

impl Dead {
    fn is_over(self, now: Instant) -> bool {
        self.fault.lasting.is_some_and(|lasting| now.duration_since(self.since) >= lasting)
    }
}

impl Faults {
    /// Forgets what is over.
    fn tidy(&mut self, now: Instant) {
        self.all.retain(|(since, fault)| !is_over(*since, *fault, now));
        self.dead = self.dead.filter(|dead| !dead.is_over(now));
    }

    fn there(&self) -> Vec<GatewayFault> {
        self.dead.iter().map(|dead| dead.fault).chain(self.all.iter().map(|(_, fault)| *fault)).collect()
    }
}

/// How long it is dead counts from its death.
fn is_over(since: Instant, fault: GatewayFault, now: Instant) -> bool {
    let lasting = fault.lasting.filter(|_| fault.misdeed != GatewayMisdeed::Dead);
    lasting.is_some_and(|lasting| now.duration_since(since) >= fault.after + lasting)
}

/// What is wrong with one request and its answer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Misdeeds {
    number: u64,
    of: Vec<GatewayMisdeed>,
}

impl GatewayFaults {
    fn lock(&self) -> MutexGuard<'_, Faults> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds one; its times count from now.
    ///
    /// # Errors
    /// [`GatewayFaultError::TooMany`].
    pub fn add(&self, fault: GatewayFault) -> Result<(), GatewayFaultError> {
        let mut faults = self.lock();
        let now = Instant::now();
        faults.tidy(now);
        if faults.all.len() >= FAULTS_MAX {
            return Err(GatewayFaultError::TooMany);
        }
        faults.all.push((now, fault));
        Ok(())
    }

    /// Those that are not over, also those that have not begun.
    #[must_use]
    pub fn all(&self) -> Vec<GatewayFault> {
        let mut faults = self.lock();
        faults.tidy(Instant::now());
        faults.there()
    }

    /// Ends one, however often it is there.
    ///
    /// # Errors
    /// [`GatewayFaultError::NotThere`].
    pub fn end(&self, fault: GatewayFault) -> Result<(), GatewayFaultError> {
        let there = self.all();
        if !there.contains(&fault) {
            let names: Vec<_> = there.iter().map(GatewayFault::to_string).collect();
            let there =
                if names.is_empty() { "is none".to_owned() } else { format!("are {}", names.join(", ")) };
            return Err(GatewayFaultError::NotThere { fault, there });
        }
        let mut faults = self.lock();
        faults.all.retain(|(_, other)| *other != fault);
        faults.dead = faults.dead.filter(|dead| dead.fault != fault);
        Ok(())
    }

    /// Ends every fault.
    pub fn clear(&self) {
        let mut faults = self.lock();
        (faults.all, faults.dead) = (Vec::new(), None);
    }

    /// So many requests have come, over all connections.
    #[must_use]
    pub fn requests(&self) -> u64 {
        self.lock().requests
    }

    /// `true` while nothing is there.
    pub(crate) fn is_dead(&self) -> bool {
        self.lock().dead.is_some_and(|dead| !dead.is_over(Instant::now()))
    }

    /// Counts a request, and says what is wrong with it.
    pub(crate) fn request(&self) -> Misdeeds {
        let mut faults = self.lock();
        faults.requests += 1;
        let number = faults.requests;
        let now = Instant::now();
        let on = |(since, fault): &(Instant, GatewayFault)| {
            let begun = now.duration_since(*since) >= fault.after;
            let here = fault.request.is_none_or(|request| request == number);
            (begun && here && !is_over(*since, *fault, now)).then_some(fault.misdeed)
        };
        Misdeeds { number, of: faults.all.iter().filter_map(on).collect() }
    }

    /// It dies, and not a second time.
    pub(crate) fn die(&self) {
        let mut faults = self.lock();
        let Some(index) = faults.all.iter().position(|(_, fault)| fault.misdeed == GatewayMisdeed::Dead)
        else {
            return;
        };
        let (_, fault) = faults.all.remove(index);
        faults.dead = Some(Dead { fault, since: Instant::now() });
    }
}

impl Misdeeds {
    pub(crate) fn has(&self, misdeed: GatewayMisdeed) -> bool {
        self.of.contains(&misdeed)
    }

    /// The exception that is answered instead of carrying a request out.
    pub(crate) fn exception(&self, request: &[u8]) -> Option<u8> {
        self.of.iter().find_map(|misdeed| match (misdeed, request) {
            (GatewayMisdeed::Exception(code), _) => Some(*code),
            (GatewayMisdeed::Max(max), [3 | 4, _, _, high, low, ..])
                if u16::from_be_bytes([*high, *low]) > *max =>
            {
                Some(3)
            }
            _ => None,
        })
    }

    /// How late the answer is.
    pub(crate) fn late(&self) -> Duration {
        let late = self.of.iter().filter_map(|misdeed| match misdeed {
            GatewayMisdeed::Late { by } => Some(*by),
            _ => None,
        });
        late.max().unwrap_or_default()
    }

    /// The unit that answers.
    pub(crate) fn unit(&self) -> Option<u8> {
        self.of.iter().find_map(|misdeed| match misdeed {
            GatewayMisdeed::Unit(unit) => Some(*unit),
            _ => None,
        })
    }

    /// The request as it gets through.
    pub(crate) fn through(&self, request: &[u8]) -> Vec<u8> {
        let mut request = request.to_vec();
        let written = match request.first() {
            Some(16) => request.get_mut(6..),
            Some(23) => request.get_mut(10..),
            _ => None,
        };
        if self.has(GatewayMisdeed::Swapped) {
            exchange_halves(written.unwrap_or_default());
        }
        request
    }

    /// The answer as it comes back.
    pub(crate) fn back(&self, answer: &[u8]) -> Vec<u8> {
        let mut answer = answer.to_vec();
        if self.has(GatewayMisdeed::Swapped) && matches!(answer.first(), Some(3 | 4 | 23)) {
            exchange_halves(answer.get_mut(2..).unwrap_or_default());
        }
        if self.has(GatewayMisdeed::Garbled) {
            let index = (self.number % answer.len().max(1) as u64) as usize;
            if let Some(byte) = answer.get_mut(index) {
                *byte ^= 0x55;
            }
        }
        answer
    }
}

/// What is no whole word stays.
fn exchange_halves(registers: &mut [u8]) {
    for word in registers.as_chunks_mut::<4>().0 {
        word.rotate_left(2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> GatewayFault {
        text.parse().unwrap()
    }

    #[tokio::test(start_paused = true)]
    async fn faults_are_there_until_they_are_over_or_ended() {
        let faults = GatewayFaults::default();
        for text in ["late=5#2", "silent@1s+1s", "dead+3s"] {
            faults.add(fault(text)).unwrap();
        }
        assert_eq!(faults.all(), ["late=5#2", "silent@1s+1s", "dead+3s"].map(fault));
        assert!(!faults.request().has(GatewayMisdeed::Silent), "it has not begun");
        tokio::time::advance(Duration::from_secs(1)).await;
        assert!(faults.request().has(GatewayMisdeed::Silent));
        tokio::time::advance(Duration::from_secs(1)).await;
        assert!(!faults.request().has(GatewayMisdeed::Silent), "it is over");
        assert_eq!(faults.all(), ["late=5#2", "dead+3s"].map(fault));
        faults.die();
        // Only what it is dead of is told, and for how long counts from its death.
        assert_eq!((faults.is_dead(), faults.all()), (true, ["dead+3s", "late=5#2"].map(fault).to_vec()));
        tokio::time::advance(Duration::from_secs(3)).await;
        assert_eq!((faults.is_dead(), faults.all()), (false, vec![fault("late=5#2")]));
        let error = faults.end(fault("close")).unwrap_err().to_string();
        assert_eq!(error, "gateway fault close is not there; there are late=5#2");
        faults.end(fault("late=5#2")).unwrap();
        assert_eq!(faults.all(), []);
        faults.add(fault("dead")).unwrap();
        faults.die();
        tokio::time::advance(Duration::from_secs(999_999)).await;
        assert!(faults.is_dead());
        faults.end(fault("dead")).unwrap();
        assert!(!faults.is_dead());
    }

    #[tokio::test(start_paused = true)]
    async fn there_is_room_again_when_faults_are_over() {
        let faults = GatewayFaults::default();
        for _ in 0..FAULTS_MAX {
            faults.add(fault("close+1s")).unwrap();
        }
        assert_eq!(faults.add(fault("close")), Err(GatewayFaultError::TooMany));
        tokio::time::advance(Duration::from_secs(1)).await;
        faults.add(fault("close")).unwrap();
        faults.clear();
        assert_eq!(faults.all(), []);
    }
}
