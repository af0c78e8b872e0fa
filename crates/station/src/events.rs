//! What happened on the ring that somebody should know of.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration as Real;

use encoring_diagnosis::FoundView;
use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::{Master, Verdict};
use encoring_words::{Duration, Instant, OutWord};
use serde::{Serialize, Serializer};

use crate::finding::FindingView;
use crate::json;
use crate::polled_view::MasterSays;

/// How many events are kept; whoever asks too rarely misses the oldest, and sees it by their numbers.
pub const EVENTS_KEPT: usize = 256;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
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
        place: FaultPlace,
        /// The diagnostic parameter register.
        #[serde(rename = "parameter_hex", serialize_with = "json::hex")]
        parameter: u16,
    },
    /// Cycles were left out because the machine was too slow.
    CyclesDropped {
        /// How many since the last such event.
        cycles: u64,
    },
    /// Clients wrote more between two cycles than was kept: a recording of the bus lacks these writes.
    WritesLost {
        /// How many.
        writes: u64,
    },
    /// A program broke a rule of the handshake, the first time or more surely than before.
    Finding(Box<FindingView>),
    /// What an encoder remembers is not in its file; it is tried again.
    MemoryNotSaved {
        /// Its ring position.
        position: usize,
        /// Which file, and why.
        #[serde(rename = "text")]
        problem: String,
    },
    /// It is again.
    MemorySaved {
        /// Its ring position.
        position: usize,
    },
    /// There is a connection to the bus.
    LinkUp,
    /// It is gone.
    LinkDown {
        /// After how long, and why.
        #[serde(rename = "text")]
        problem: String,
    },
    /// It could not be made, the first time of several.
    LinkFailed {
        /// Why.
        #[serde(rename = "text")]
        problem: String,
    },
    /// The master says that the ring stands still.
    RingStands {
        /// What it says.
        #[serde(flatten)]
        says: MasterSays,
    },
    /// It has run again for a second.
    RingRuns {
        /// How often it was seen to stop.
        times: u32,
        /// What the master says.
        #[serde(flatten)]
        says: MasterSays,
    },
    /// The master says something else than before.
    MasterSays {
        /// What.
        #[serde(flatten)]
        says: MasterSays,
    },
    /// A data cycle was faulty, and the ring ran on.
    FaultyCycle {
        /// What the master says.
        #[serde(flatten)]
        says: MasterSays,
    },
    /// What the master says could not be read.
    MasterUnread,
    /// An encoder shows what stops a machine.
    Doubted {
        /// Its ring position.
        position: usize,
        /// What its word is worth.
        verdict: &'static str,
    },
    /// Why the position has jumped, a few polls behind the jump.
    JumpCause {
        /// The ring position of the encoder.
        position: usize,
        /// What was found.
        #[serde(flatten)]
        found: Box<FoundView>,
    },
    /// Somebody knows why a position has jumped: the next one is taken as it comes.
    Acknowledged {
        /// The ring position of the encoder.
        position: usize,
    },
    /// After a service from here the service bit was not seen gone.
    ServiceBitLeft {
        /// The ring position of the encoder.
        position: usize,
        /// The word that may still stand on OUT.
        #[serde(serialize_with = "json::text")]
        out: OutWord,
    },
    /// The recording broke off; what was written stays, and the ring goes on.
    RecordingEnded {
        /// Why.
        #[serde(rename = "text")]
        problem: String,
    },
}

impl Happened {
    /// `true` for what is lost outside the ring if nobody does anything.
    #[must_use]
    pub const fn is_trouble(&self) -> bool {
        matches!(
            self,
            Self::MemoryNotSaved { .. }
                | Self::RecordingEnded { .. }
                | Self::WritesLost { .. }
                | Self::ServiceBitLeft { .. }
        )
    }
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

fn at_fault<S: Serializer>(place: &FaultPlace, serializer: S) -> Result<S::Ok, S::Error> {
    let (fault, segment, position) = match *place {
        FaultPlace::Segment(segment) => ("bad", Some(segment), None),
        FaultPlace::Break(segment) => ("break", Some(segment), None),
        FaultPlace::Device(position) => ("other_device", None, Some(position)),
        FaultPlace::Nowhere => ("no_answer", None, None),
    };
    AtFault { fault, segment, position }.serialize(serializer)
}

impl fmt::Display for RingEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", Duration::from_nanos(self.time_ns))?;
        match &self.what {
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
            Happened::WritesLost { writes } => {
                write!(f, "{writes} writes of OUT words between two cycles were too many to be kept")
            }
            Happened::Finding(finding) => {
                write!(f, "position {}: {}", finding.position, finding.told())
            }
            Happened::MemoryNotSaved { position, problem } => {
                write!(f, "the memory of position {position} is not saved: {problem}")
            }
            Happened::RecordingEnded { problem } => write!(f, "the recording broke off: {problem}"),
            Happened::LinkUp => f.write_str("connected"),
            Happened::LinkDown { problem } | Happened::LinkFailed { problem } => f.write_str(problem),
            Happened::RingStands { says } => write!(f, "the ring stands still; {says}"),
            Happened::RingRuns { times, says } => {
                write!(f, "the ring runs again, it stood still {times} times; {says}")
            }
            Happened::MasterSays { says } => says.fmt(f),
            Happened::FaultyCycle { says } => write!(f, "a data cycle was faulty; {says}"),
            Happened::MasterUnread => f.write_str("what the ring's master says could not be read"),
            Happened::Doubted { position, verdict } => {
                write!(f, "position {position}: {}", verdict.replace('_', " "))
            }
            Happened::JumpCause { position, found } => write!(f, "position {position}: {found}"),
            Happened::Acknowledged { position } => {
                write!(
                    f,
                    "position {position}: the jump was acknowledged: the next position is taken as it comes"
                )
            }
            Happened::ServiceBitLeft { position, out } => write!(
                f,
                "position {position}: OUT may still hold {out}, with the service bit; `encoring release --at \
                 {position}` shows it and clears it"
            ),
            Happened::MemorySaved { position } => {
                write!(f, "the memory of position {position} is saved again")
            }
        }
    }
}

/// The last events of a ring, for whoever asks or waits for them.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    list: Mutex<List>,
    /// Told of every event, and of the end.
    more: Condvar,
}

#[derive(Debug, Default)]
struct List {
    events: VecDeque<RingEvent>,
    next: u64,
    ended: bool,
}

impl List {
    fn since(&self, from: u64) -> Vec<RingEvent> {
        self.events.iter().filter(|event| event.number >= from).cloned().collect()
    }
}

impl Kept {
    fn list(&self) -> MutexGuard<'_, List> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The kept events from number `from` on; `None` when the ring has stopped.
    pub(crate) fn since(&self, from: u64) -> Option<Vec<RingEvent>> {
        let list = self.list();
        (!list.ended).then(|| list.since(from))
    }

    /// The same, but waits until there is one; empty if there was none within the time.
    pub(crate) fn wait(&self, from: u64, within: Real) -> Option<Vec<RingEvent>> {
        let none_yet = |list: &mut List| list.next <= from && !list.ended;
        let waited = self.more.wait_timeout_while(self.list(), within, none_yet);
        let (list, _) = waited.unwrap_or_else(PoisonError::into_inner);
        (!list.ended).then(|| list.since(from))
    }

    fn push(&self, at: Instant, what: Happened) {
        let mut list = self.list();
        if list.events.len() == EVENTS_KEPT {
            list.events.pop_front();
        }
        let number = list.next;
        list.events.push_back(RingEvent { number, time_ns: at.as_nanos(), what });
        list.next += 1;
        self.more.notify_all();
    }

    fn end(&self) {
        self.list().ended = true;
        self.more.notify_all();
    }
}

/// Makes events of what a ring does. When it is dropped the ring has stopped.
#[derive(Debug)]
pub(crate) struct Events {
    kept: Arc<Kept>,
    line: Verdict,
    /// The place that the present search has found, while there is one.
    search: Option<Option<FaultPlace>>,
    dropped: u64,
}

impl Drop for Events {
    fn drop(&mut self) {
        self.kept.end();
    }
}

impl Events {
    pub(crate) fn new() -> Self {
        Self { kept: Arc::default(), line: Verdict::Good, search: None, dropped: 0 }
    }

    /// Notes how a data cycle went, if it went otherwise than the one before.
    fn cycled(&mut self, at: Instant, verdict: Verdict) {
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

    /// Notes a slot of the ring, with how its data cycle went if it was one.
    pub(crate) fn slot(&mut self, at: Instant, data: Option<Verdict>, master: &Master) {
        if !master.is_searching() {
            self.search = None;
        }
        // What a slot brings that is none of data says nothing of the line.
        if let Some(verdict) = data {
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

    /// Where they are kept.
    pub(crate) const fn kept(&self) -> &Arc<Kept> {
        &self.kept
    }

    /// The kept events.
    pub(crate) fn all(&self) -> Vec<RingEvent> {
        self.kept.list().since(0)
    }

    /// Notes what has happened.
    pub(crate) fn push(&self, at: Instant, what: Happened) {
        self.kept.push(at, what);
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
        assert_eq!(events.all(), []);
        for k in 0..300 {
            events.cycled(Instant(k), Verdict::Silent { segment: k as usize });
        }
        assert_eq!(events.all().len(), EVENTS_KEPT);
        assert_eq!(
            events.kept().since(298).unwrap().iter().map(|event| event.number).collect::<Vec<_>>(),
            [298, 299]
        );
        events.dropped(Instant(400), 5);
        events.dropped(Instant(401), 5);
        events.dropped(Instant(402), 7);
        let told: Vec<String> = events.kept().since(299).unwrap().iter().map(RingEvent::to_string).collect();
        assert_eq!(
            told,
            [
                "299 ns: the ring is silent from segment 299 on",
                "400 ns: 5 cycles dropped, the machine was too slow",
                "402 ns: 2 cycles dropped, the machine was too slow",
            ]
        );
    }

    #[test]
    fn an_event_is_waited_for_until_it_comes_or_the_ring_stops() {
        let mut events = Events::new();
        let kept = Arc::clone(events.kept());
        assert_eq!(kept.wait(0, Real::ZERO), Some(vec![]));
        let long = Real::from_secs(600);
        let waiting = std::thread::spawn({
            let kept = Arc::clone(&kept);
            move || [kept.wait(0, long), kept.wait(1, long)]
        });
        events.dropped(Instant(400), 5);
        let number = |events: Vec<RingEvent>| events.iter().map(|event| event.number).collect::<Vec<_>>();
        assert_eq!(kept.wait(0, long).map(number), Some(vec![0]));
        drop(events);
        let [first, after] = waiting.join().unwrap();
        // It may have begun to wait only when the ring had stopped.
        assert!(first.is_none_or(|events| number(events) == [0]));
        assert_eq!((after, kept.since(0)), (None, None));
    }
}
