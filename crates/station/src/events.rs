//! What happened on the ring that somebody should know of.

use std::collections::VecDeque;
use std::fmt;

use encoring_ring::Verdict;
use encoring_words::{Duration, Instant};
use serde::Serialize;

/// How many events are kept; whoever asks too rarely misses the oldest, and sees it by their numbers.
pub const EVENTS_KEPT: usize = 256;

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Event {
    /// Counted from 0 without a gap.
    pub number: u64,
    /// Time on the ring in nanoseconds.
    pub time_ns: u64,
    /// What.
    #[serde(flatten)]
    pub what: Happened,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Happened {
    /// Cycles are good throughout again.
    LineGood,
    /// Check words fail on a segment.
    LineBad {
        /// 0..=encoders.
        segment: usize,
    },
    /// The line is silent from a segment on.
    LineSilent {
        /// 0..=encoders.
        segment: usize,
    },
    /// Cycles were left out because the machine was too slow.
    CyclesDropped {
        /// How many since the last such event.
        cycles: u64,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", Duration::from_nanos(self.time_ns))?;
        match self.what {
            Happened::LineGood => f.write_str("the ring is whole again"),
            Happened::LineBad { segment } => write!(f, "bad check words on segment {segment}"),
            Happened::LineSilent { segment } => write!(f, "the ring is silent from segment {segment} on"),
            Happened::CyclesDropped { cycles } => {
                write!(f, "{cycles} cycles dropped, the machine was too slow")
            }
        }
    }
}

/// The last events of a ring.
#[derive(Clone, Debug)]
pub(crate) struct Events {
    kept: VecDeque<Event>,
    next: u64,
    line: Verdict,
    dropped: u64,
}

impl Events {
    pub(crate) fn new() -> Self {
        Self { kept: VecDeque::with_capacity(EVENTS_KEPT), next: 0, line: Verdict::Good, dropped: 0 }
    }

    /// Notes how a cycle went, if it went otherwise than the one before.
    pub(crate) fn cycled(&mut self, at: Instant, verdict: Verdict) {
        if verdict != self.line {
            self.line = verdict;
            self.push(
                at,
                match verdict {
                    Verdict::Good => Happened::LineGood,
                    Verdict::Bad { segment } => Happened::LineBad { segment },
                    Verdict::Silent { segment } => Happened::LineSilent { segment },
                },
            );
        }
    }

    /// Notes how many cycles have been dropped in all.
    pub(crate) fn dropped(&mut self, at: Instant, dropped: u64) {
        if dropped > self.dropped {
            self.push(at, Happened::CyclesDropped { cycles: dropped - self.dropped });
            self.dropped = dropped;
        }
    }

    /// The kept events from number `from` on.
    pub(crate) fn since(&self, from: u64) -> Vec<Event> {
        self.kept.iter().filter(|event| event.number >= from).copied().collect()
    }

    fn push(&mut self, at: Instant, what: Happened) {
        if self.kept.len() == EVENTS_KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(Event { number: self.next, time_ns: at.as_nanos(), what });
        self.next += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_changes_are_events_and_only_the_last_are_kept() {
        let mut events = Events::new();
        for _ in 0..3 {
            events.cycled(Instant(1), Verdict::Good);
        }
        assert_eq!(events.since(0), []);
        for k in 0..300 {
            events.cycled(Instant(k), Verdict::Silent { segment: k as usize });
        }
        assert_eq!(events.since(0).len(), EVENTS_KEPT);
        assert_eq!(events.since(298).iter().map(|event| event.number).collect::<Vec<_>>(), [298, 299]);
        events.dropped(Instant(400), 5);
        events.dropped(Instant(401), 5);
        events.dropped(Instant(402), 7);
        let told: Vec<String> = events.since(299).iter().map(Event::to_string).collect();
        assert_eq!(
            told,
            [
                "299 ns: the ring is silent from segment 299 on",
                "400 ns: 5 cycles dropped, the machine was too slow",
                "402 ns: 2 cycles dropped, the machine was too slow",
            ]
        );
    }
}
