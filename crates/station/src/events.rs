//! What happened on the ring that somebody should know of.

use std::collections::VecDeque;
use std::fmt;

use encoring_ring::diagnostics::Place;
use encoring_ring::{Master, Verdict};
use encoring_words::{Duration, Instant};
use serde::{Serialize, Serializer};

/// How many events are kept; whoever asks too rarely misses the oldest, and sees it by their numbers.
pub const EVENTS_KEPT: usize = 256;

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct RingEvent {
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
    /// The master has stopped the bus and looks at it from the front; outputs are reset.
    SearchBegan,
    /// The master has found a place where the ring is at fault.
    SearchFound {
        /// Where.
        #[serde(flatten, serialize_with = "at_fault")]
        place: Place,
        /// The diagnostic parameter register.
        #[serde(rename = "parameter_hex", serialize_with = "hex")]
        parameter: u16,
    },
    /// Cycles were left out because the machine was too slow.
    CyclesDropped {
        /// How many since the last such event.
        cycles: u64,
    },
}

/// A place for programs: its kind, and the segment or position if it has one.
#[derive(Serialize)]
struct AtFault {
    fault: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    segment: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<usize>,
}

fn at_fault<S: Serializer>(place: &Place, serializer: S) -> Result<S::Ok, S::Error> {
    let (fault, segment, position) = match *place {
        Place::Segment(segment) => ("bad", Some(segment), None),
        Place::Break(segment) => ("break", Some(segment), None),
        Place::Device(position) => ("other_device", None, Some(position)),
        Place::Nowhere => ("no_answer", None, None),
    };
    AtFault { fault, segment, position }.serialize(serializer)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
fn hex<S: Serializer>(word: &u16, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{word:04X}"))
}

impl fmt::Display for RingEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", Duration::from_nanos(self.time_ns))?;
        match self.what {
            Happened::LineGood => f.write_str("the ring is whole again"),
            Happened::LineBad { segment } => write!(f, "bad check words on segment {segment}"),
            Happened::LineSilent { segment } => write!(f, "the ring is silent from segment {segment} on"),
            Happened::SearchBegan => f.write_str("the bus is stopped, the master looks for the fault"),
            Happened::SearchFound { place, parameter } => {
                write!(f, "the master found: {place} (parameter {parameter:04X})")
            }
            Happened::CyclesDropped { cycles } => {
                write!(f, "{cycles} cycles dropped, the machine was too slow")
            }
        }
    }
}

/// The last events of a ring.
#[derive(Clone, Debug)]
pub(crate) struct Events {
    kept: VecDeque<RingEvent>,
    next: u64,
    line: Verdict,
    /// The place that the present search has found, while there is one.
    search: Option<Option<Place>>,
    /// Data cycles that the master has counted.
    data_cycles: u64,
    dropped: u64,
}

impl Events {
    pub(crate) fn new() -> Self {
        Self {
            kept: VecDeque::with_capacity(EVENTS_KEPT),
            next: 0,
            line: Verdict::Good,
            search: None,
            data_cycles: 0,
            dropped: 0,
        }
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

    /// Notes a slot of a ring whose master knows more than how cycles go.
    pub(crate) fn slot(&mut self, at: Instant, verdict: Verdict, master: &Master) {
        let cycles = master.counts().cycles;
        let was_data = cycles != std::mem::replace(&mut self.data_cycles, cycles);
        if !master.is_searching() {
            self.search = None;
        }
        // What a slot brings that is none of data says nothing of the line.
        if was_data {
            self.cycled(at, verdict);
        }
        if !master.is_searching() {
            return;
        }
        let place = master.place();
        match self.search {
            None => {
                self.push(at, Happened::SearchBegan);
                self.search = Some(None);
            }
            Some(known) if place != known => {
                self.search = Some(place);
                if let Some(place) = place {
                    self.push(at, Happened::SearchFound { place, parameter: master.parameter() });
                }
            }
            Some(_) => {}
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
    pub(crate) fn since(&self, from: u64) -> Vec<RingEvent> {
        self.kept.iter().filter(|event| event.number >= from).copied().collect()
    }

    fn push(&mut self, at: Instant, what: Happened) {
        if self.kept.len() == EVENTS_KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(RingEvent { number: self.next, time_ns: at.as_nanos(), what });
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
        let told: Vec<String> = events.since(299).iter().map(RingEvent::to_string).collect();
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
