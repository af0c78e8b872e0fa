//! Looks at encoders of a bus, poll after poll, and judges what they show. It never writes an OUT word.

#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use encoring_host::Seen;
use encoring_host::referee::{Finding, HandshakeRule, LineSeen, Observed, Vantage};
use encoring_host::validity::Stop;
use encoring_ring::diagnostics::Diagnosis;
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::bus::{Answered, Bus, BusError, Cause, LinkEvent};
use crate::history::{RingHistory, RingNews, ring_at};
use crate::judge::{Insight, Judge, Judgement};
use crate::master::Cure;
use crate::misread::{Misread, can_be_sent};
use crate::referees::Referees;

/// How long a wait may be before the stop mark is looked at.
const SLICE: Duration = Duration::from_millis(50);

/// For so long after a word that no encoder sends nothing is said of whoever writes OUT: the words that look like an
/// encoder's may be turned round too.
const DOUBTED_FOR: Duration = Duration::from_secs(10);

/// When the polls are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// From one poll to the next; zero: as often as the bus can.
    pub every: Duration,
    /// When to end, from the first poll on.
    pub lasting: Option<Duration>,
}

/// An encoder that is looked at.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its ring position.
    pub position: usize,
    /// Who judges its words.
    pub judge: Judge,
}

/// What a poll brought.
#[derive(Clone, Debug, Default)]
pub struct Poll {
    /// Counted from 0.
    pub number: u64,
    /// When it was to be made.
    pub due: Instant,
    /// When it was over.
    pub at: Instant,
    /// The encoders, in the order of their positions.
    pub sights: Vec<Sight>,
    /// What the ring's master says, as far as the bus shows it; read before the words.
    pub diagnosis: Diagnosis,
    /// What is new of the ring.
    pub ring: Option<RingNews>,
    /// The positions whose jump was acknowledged since the poll before.
    pub acknowledged: Vec<usize>,
    /// What happened to the link.
    pub link: Vec<LinkEvent>,
    /// What whoever writes OUT was found to do for the first time, by position; see [`TOLD_BY_POLLS`].
    pub findings: Vec<(u8, Finding)>,
}

/// The rules of the handshake that polls can judge: what they are about lasts for a second and more, or is counted. For the
/// others a program that keeps them would look the same.
pub const TOLD_BY_POLLS: [HandshakeRule; 4] = [
    HandshakeRule::NeverDropped,
    HandshakeRule::ErrorIgnored,
    HandshakeRule::MemoryWear,
    HandshakeRule::EqualWrites,
];

/// What a poll brought of one encoder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sight {
    /// Its ring position.
    pub position: usize,
    /// When its word came, or did not.
    pub at: Instant,
    /// The IN word.
    pub input: Option<InWord>,
    /// How old that may be.
    pub age: Option<Duration>,
    /// The OUT word as it stood a little later, so that both together are a phase of the handshake that was.
    pub out: Option<OutWord>,
    /// What the IN word is worth.
    pub verdict: Judgement,
    /// A reason to stop the machine that was not there before.
    pub stop: Option<Stop>,
}

/// The steps of the handshake that can be told apart from outside: by bit 31 of both words [R31..R40].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandshakePhase {
    /// OUT 0, IN 0: the position is shown.
    Normal,
    /// OUT 1, IN 0: the encoder has a request to carry out, or ignores one.
    Requested,
    /// OUT 1, IN 1: the reply is shown.
    Acknowledged,
    /// OUT 0, IN 1: the master has ended the request, the encoder not yet.
    Ending,
}

impl HandshakePhase {
    /// The phase that two words show.
    #[must_use]
    pub const fn of(out: OutWord, input: InWord) -> Self {
        match (out.service_bit(), input.service_bit()) {
            (false, false) => Self::Normal,
            (true, false) => Self::Requested,
            (true, true) => Self::Acknowledged,
            (false, true) => Self::Ending,
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Requested => "requested",
            Self::Acknowledged => "acknowledged",
            Self::Ending => "ending",
        }
    }

    /// The step of the manuals' five that it is in.
    #[must_use]
    pub const fn step(self) -> &'static str {
        match self {
            Self::Normal => "1",
            Self::Requested => "2",
            Self::Acknowledged => "3",
            Self::Ending => "4",
        }
    }
}

impl Sight {
    /// The phase of the handshake, if both words were seen.
    #[must_use]
    pub fn phase(&self) -> Option<HandshakePhase> {
        self.out.zip(self.input).map(|(out, input)| HandshakePhase::of(out, input))
    }

    /// The same as a referee takes it, if OUT was seen. Of a word that may be old nothing is judged.
    fn observed(&self) -> Option<Observed> {
        let line = match self.verdict {
            Judgement::RingStopped(_) => LineSeen::Silent,
            Judgement::Stale { .. } | Judgement::NoAnswer(_) => LineSeen::Bad,
            _ => LineSeen::Untold,
        };
        Some(Observed::Cycle { at: self.at, out: self.out?, input: self.input, line })
    }
}

/// Polls of a bus, one after the other.
#[derive(Debug)]
pub struct Watch<'a, B: ?Sized> {
    bus: &'a mut B,
    plan: Plan,
    stop: Arc<AtomicBool>,
    subjects: Vec<Subject>,
    /// First position and number of encoders that follow one another.
    runs: Vec<(usize, usize)>,
    input: Vec<InWord>,
    out_words: OutWords,
    began: Instant,
    due: Instant,
    polls: u64,
    answered: bool,
    history: RingHistory,
    acknowledged: Vec<usize>,
    referees: Referees,
    /// Of each encoder the last word that no encoder sends.
    nobodys: Vec<Option<(Instant, InWord)>>,
    /// The answer that brought no words last.
    useless: Option<BusError>,
    poll: Poll,
}

impl<'a, B: Bus + ?Sized> Watch<'a, B> {
    /// Polls of these encoders, until `stop` is set. A position is looked at once.
    #[must_use]
    pub fn new(bus: &'a mut B, mut subjects: Vec<Subject>, plan: Plan, stop: Arc<AtomicBool>) -> Self {
        subjects.sort_by_key(|subject| subject.position);
        subjects.dedup_by_key(|subject| subject.position);
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for Subject { position, .. } in &subjects {
            match runs.last_mut() {
                Some((first, count)) if *first + *count == *position => *count += 1,
                _ => runs.push((*position, 1)),
            }
        }
        let mut referees = Referees::new(Vantage::Log, None);
        for Subject { position, judge } in &subjects {
            // A ring has at most 128.
            if let Ok(position) = u8::try_from(*position) {
                referees.place(position, judge.model());
            }
        }
        let began = bus.now();
        Self {
            bus,
            plan,
            stop,
            input: vec![InWord(0); subjects.len()],
            nobodys: vec![None; subjects.len()],
            useless: None,
            subjects,
            runs,
            out_words: OutWords { is_readable: true, is_asked: true },
            began,
            due: began,
            polls: 0,
            answered: false,
            history: RingHistory::default(),
            acknowledged: Vec::new(),
            referees,
            poll: Poll::default(),
        }
    }

    /// The encoders.
    #[must_use]
    pub fn subjects(&self) -> &[Subject] {
        &self.subjects
    }

    /// How many were made.
    #[must_use]
    pub const fn polls(&self) -> u64 {
        self.polls
    }

    /// What the latest poll brought.
    #[must_use]
    pub const fn latest(&self) -> &Poll {
        &self.poll
    }

    /// `true` if polls were made and none has brought a word.
    #[must_use]
    pub const fn is_unanswered(&self) -> bool {
        self.polls > 0 && !self.answered
    }

    /// The time on the bus.
    #[must_use]
    pub fn now(&self) -> Instant {
        self.bus.now()
    }

    /// Somebody knows why positions have jumped: those that come next are taken as they are.
    pub fn acknowledge(&mut self) {
        for subject in &mut self.subjects {
            if subject.judge.acknowledge() {
                self.acknowledged.push(subject.position);
            }
        }
    }

    /// The same for the encoder at one position.
    pub fn acknowledge_at(&mut self, position: usize) {
        for subject in self.subjects.iter_mut().filter(|subject| subject.position == position) {
            if subject.judge.acknowledge() {
                self.acknowledged.push(position);
            }
        }
    }

    /// The bus, for whoever has something to do on it between two polls.
    pub const fn bus(&mut self) -> &mut B {
        self.bus
    }

    /// The last poll.
    #[must_use]
    pub const fn last(&self) -> &Poll {
        &self.poll
    }

    /// The referees of whoever writes OUT. Of what they find only [`TOLD_BY_POLLS`] is certain here.
    #[must_use]
    pub const fn referees(&self) -> &Referees {
        &self.referees
    }

    /// How the words of an encoder are turned round, as one within the last ten seconds shows that no encoder sends.
    #[must_use]
    pub fn misread(&self, position: usize) -> Option<Misread> {
        let place = self.subjects.iter().position(|subject| subject.position == position)?;
        let (at, word) = self.nobodys.get(place).copied().flatten()?;
        Misread::of(word).filter(|_| self.poll.at.since(at) < DOUBTED_FOR)
    }

    /// How words that no encoder sends are an encoder's, and what to change so that they are read in this way.
    #[must_use]
    pub fn cure(&self, way: Misread) -> Cure {
        Cure::by(self.bus, way, "an encoder's")
    }

    /// Waits for the next poll and makes it. `None` when it is to end.
    pub fn poll(&mut self) -> Option<&Poll> {
        self.poll_with(|_| None)
    }

    /// The same; what somebody who sees into the encoder at a position knows of it is asked when its word has come, and
    /// its judge is told.
    pub fn poll_with(&mut self, insight: impl FnMut(usize) -> Option<Insight>) -> Option<&Poll> {
        let end = self.plan.lasting.map(|lasting| self.began + lasting);
        self.wait(end.map_or(self.due, |end| end.min(self.due)));
        if self.stop.load(Ordering::Relaxed) || end.is_some_and(|end| self.due.max(self.bus.now()) >= end) {
            return None;
        }
        self.poll.due = self.due;
        // Polls that were missed are not made up for.
        let late = self.bus.now().since(self.due).as_nanos();
        let every = self.plan.every.as_nanos();
        self.due = match late.checked_div(every) {
            Some(missed) => self.due + Duration(every.saturating_mul(missed.saturating_add(1))),
            None => self.bus.now(),
        };
        self.poll.number = self.polls;
        self.polls += 1;
        self.look(insight);
        Some(&self.poll)
    }

    /// No poll follows: what whoever writes OUT has left standing, as a poll without words.
    pub fn end(&mut self) -> &Poll {
        self.referees.finish();
        self.poll = Poll { number: self.polls, at: self.bus.now(), ..Poll::default() };
        self.take_findings();
        &self.poll
    }

    fn wait(&mut self, until: Instant) {
        loop {
            let now = self.bus.now();
            // Also without anything to wait for: a ring at real speed must not run ahead of the clock.
            self.bus.wait(SLICE.min(until.since(now)));
            let stopped = self.stop.load(Ordering::Relaxed);
            if stopped || self.bus.now() >= until || self.bus.now() == now {
                return;
            }
        }
    }

    fn look(&mut self, insight: impl FnMut(usize) -> Option<Insight>) {
        self.poll.sights.clear();
        self.poll.link.clear();
        self.poll.acknowledged = std::mem::take(&mut self.acknowledged);
        let diagnosis = self.bus.diagnosis();
        let asked = self.bus.now();
        let words_came = self.look_at_encoders(&diagnosis, insight);
        self.answered |= words_came;
        // Where no word came either, the trouble is told already.
        let told = diagnosis.is_ok() || words_came;
        self.poll.ring = if told { self.history.take(asked, &diagnosis) } else { None };
        self.poll.diagnosis = diagnosis.unwrap_or_default();
        while let Some(event) = self.bus.link_event() {
            self.poll.link.push(event);
        }
        self.referee();
        self.poll.at = self.bus.now();
    }

    /// The words once more, for what they tell of whoever writes OUT.
    fn referee(&mut self) {
        for (sight, nobodys) in self.poll.sights.iter().zip(&mut self.nobodys) {
            if let Some(word) = sight.input.filter(|word| !can_be_sent(*word)) {
                *nobodys = Some((sight.at, word));
                // OUT was not read as it is either.
                continue;
            }
            let doubted = nobodys.is_some_and(|(at, _)| sight.at.since(at) < DOUBTED_FOR);
            let (Ok(position), Some(seen)) = (u8::try_from(sight.position), sight.observed()) else {
                continue;
            };
            let seen = match seen {
                Observed::Cycle { at, out, input, .. } if doubted => {
                    Observed::Cycle { at, out, input, line: LineSeen::Bad }
                }
                seen => seen,
            };
            self.referees.observe(position, seen);
        }
        self.poll.findings.clear();
        self.take_findings();
    }

    fn take_findings(&mut self) {
        let news = self.referees.take_news();
        self.poll.findings.extend(news.filter(|(_, finding)| TOLD_BY_POLLS.contains(&finding.rule)));
    }

    /// `true` if a word came.
    fn look_at_encoders(
        &mut self,
        diagnosis: &Result<Diagnosis, BusError>,
        mut insight: impl FnMut(usize) -> Option<Insight>,
    ) -> bool {
        let (mut subjects, mut words) = (self.subjects.iter_mut(), self.input.as_mut_slice());
        self.out_words.is_asked = self.out_words.is_readable;
        let mut words_came = false;
        for &(first, count) in &self.runs {
            let (run, rest) = std::mem::take(&mut words).split_at_mut_checked(count).unwrap_or_default();
            words = rest;
            let cycle = self.bus.cycle(None, first, run).map_err(|error| reason(&mut self.useless, error));
            if cycle.is_ok() {
                (words_came, self.useless) = (true, None);
            }
            let at = cycle.as_ref().map_or_else(|_| self.bus.now(), |cycle| cycle.at);
            // The run first: at its end no subject may be taken.
            for (word, subject) in run.iter().zip(subjects.by_ref()) {
                let position = subject.position;
                let seen = cycle.as_ref().map(|cycle| Seen { input: *word, age: cycle.age });
                let out = if seen.is_ok() { self.out_words.read(self.bus, position) } else { None };
                if let Some(insight) = insight(position) {
                    subject.judge.learn(insight);
                }
                let (input, age) = seen.as_ref().map(|seen| (seen.input, seen.age)).ok().unzip();
                let (verdict, stop) =
                    subject.judge.judge(at, seen.map_err(Clone::clone), ring_at(diagnosis, position));
                self.poll.sights.push(Sight { position, at, input, age, out, verdict, stop });
            }
        }
        words_came
    }
}

/// Why no word came: that the next attempt to connect is not due yet hides no answer that was none.
fn reason(useless: &mut Option<BusError>, error: BusError) -> BusError {
    match (&*useless, error) {
        (Some(reason), BusError::NoConnection(Cause::Waiting { .. })) => reason.clone(),
        (_, error) => {
            *useless = Some(error.clone()).filter(|error| matches!(error, BusError::Client(_)));
            error
        }
    }
}

/// Whether the OUT words can be read.
#[derive(Debug)]
struct OutWords {
    /// As far as is known.
    is_readable: bool,
    /// In this poll too.
    is_asked: bool,
}

impl OutWords {
    fn read<B: Bus + ?Sized>(&mut self, bus: &mut B, position: usize) -> Option<OutWord> {
        if !self.is_asked {
            return None;
        }
        match bus.out(position) {
            Ok(out) => Some(out),
            Err(error) => {
                // The rest would wait for nothing too.
                self.is_asked = false;
                let refused =
                    matches!(error, BusError::Client(client) if client.answered() == Answered::Refused);
                self.is_readable &= !refused;
                None
            }
        }
    }
}
