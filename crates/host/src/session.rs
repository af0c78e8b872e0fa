//! The master's half of the handshake: one service at a time, from the request to the position again [R30..R41].
//!
//! A session is called once for every poll of the bus, with what the poll brought, and says what OUT shall be until
//! the next:
//!
//! ```text
//! resting -> preparing -> requesting -> ending -> resting        done
//!                |             |           |
//!                |             +-----------+--> clearing -> resting    timed out, or given up
//!                +--> resting                                    timed out: nothing was sent
//! ```
//!
//! - *Preparing*: service and data stand on OUT, the service bit is 0. It rises when they have stood there for the
//!   settling time and IN bit 31 was seen 0 meanwhile, so that a controller between here and the ring cannot tear
//!   the word [R33, R34, C15].
//! - *Requesting*: the service bit is 1. A reply counts if its upper byte, the error bit apart, and for a write its
//!   data are those of the request [C12].
//! - *Ending*: the service bit is 0 again, until IN bit 31 is.
//! - *Clearing*: after a time-out the service bit is taken back, and for as long again a late reply may show up: an
//!   encoder that has started a service finishes it [C42]. It counts if it was seen twice, between two words with
//!   IN bit 31 = 0.
//!
//! A late reply never answers the next request: as long as an earlier request may still be under way (at the start,
//! and after a time-out) a reply must stand for the settling time, while an encoder shows a withdrawn one in a single
//! cycle only.
//!
//! Eight or sixteen bits that happen to match are no reply: a position whose halves are exchanged runs through all of
//! them. So a reply comes directly after a word with IN bit 31 = 0, but for words that a gateway may have torn, and of
//! a read nothing is said to be carried out unless bit 31 was seen 0 again.
//!
//! A word that may have left the ring before the present word was on OUT does not show that the encoder is free, and a
//! reply that only looks as if it stood because the ring has stopped is none. Otherwise the age of a word does not matter:
//! what a bus shows later it has not seen earlier, so a reply after a position, or a position after a reply, is new.

use encoring_words::word::In;
use encoring_words::{Access, Duration, InWord, Instant, OutWord};

use crate::request::{Reply, Request};
use crate::seen::Seen;

/// So many different words with IN bit 31 may follow one another, the reply among them: it, and one that a gateway tore
/// before it and one behind it.
const STRANGERS_MAX: u32 = 4;

/// So many words in a row must have the same error bit once it has changed between two words.
const ALIKE: u32 = 3;

/// The longest pause between two looks for a reply.
const REPLY_POLL: Duration = Duration::from_millis(1);

/// The patience of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Polls for which a word must stand on OUT before the service bit follows: at least one cycle of the ring and
    /// one scan of whatever stands before it.
    pub settle_polls: u32,
    /// The time for which it must stand there; both must have passed.
    pub settle: Duration,
    /// How long an answer may take.
    pub patience: Duration,
    /// How many polls must have been made before the patience is at an end, whatever the time.
    pub patience_polls: u32,
}

impl Timing {
    /// For a ring of which every poll is a cycle. A second is 50 times the slowest service of the simulated encoders;
    /// no manual says how long a real one takes.
    pub const DIRECT: Self = Self {
        settle_polls: 1,
        settle: Duration::ZERO,
        patience: Duration::from_millis(1_000),
        patience_polls: 3,
    };

    /// When to look for something: a word that has to stand is looked at a few times while it does, a reply is waited
    /// for more closely.
    #[must_use]
    pub fn next_look(&self, why: LookFor) -> NextLook {
        let settle = self.settle.as_nanos();
        let within = Duration::from_nanos(match why {
            LookFor::Recovery => settle / 2,
            LookFor::Settling => settle / 4,
            LookFor::Reply => (settle / 10).min(REPLY_POLL.as_nanos()),
        });
        NextLook { within, why }
    }
}

/// What a session says of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It was acknowledged and ended.
    Done {
        /// What the encoder replied.
        reply: Reply,
        /// An error was pending before the request already, so the error bit of the reply need not be its own [C23].
        error_before: bool,
    },
    /// It was not, in time.
    TimedOut(TimedOut),
    /// It was given up on demand.
    GivenUp(GivenUp),
}

/// What a session waited for in vain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedOut {
    /// What.
    pub waited_for: WaitedFor,
    /// How long.
    pub time: Duration,
    /// Polls in that time.
    pub polls: u32,
    /// Those of them that brought a word.
    pub answered: u32,
    /// The last word that was seen.
    pub last: Option<InWord>,
    /// What became of the request.
    pub fate: Fate,
}

/// What was given up, and how far it had come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GivenUp {
    /// What became of the request.
    pub fate: Fate,
}

/// What is known of a request that did not come to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It was never sent: the encoder is as it was.
    NotSent,
    /// It was sent and no reply was seen: the encoder may have carried it out or not.
    Unknown,
    /// It was carried out: its reply was seen, if late.
    CarriedOut(Reply),
}

/// The steps that can take too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitedFor {
    /// IN bit 31 = 0 before the request: the encoder shows a reply that nobody here asked for, or nothing at all.
    Normal,
    /// The reply.
    Acknowledgement,
    /// IN bit 31 = 0 after the reply.
    End,
}

impl WaitedFor {
    /// The step in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Normal => "IN bit 31 = 0 before the request",
            Self::Acknowledgement => "the acknowledgement",
            Self::End => "IN bit 31 = 0 after the acknowledgement",
        }
    }
}

impl core::fmt::Display for TimedOut {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "waited {} for {}; {} of {} polls brought a word",
            in_tenths(self.time),
            self.waited_for.name(),
            self.answered,
            self.polls
        )?;
        match self.last {
            Some(last) => write!(f, ", the last was {last}"),
            None => Ok(()),
        }
    }
}

/// A time as people say it: in tenths of seconds, below one in milliseconds.
fn in_tenths(span: Duration) -> Duration {
    let unit = if span < Duration::from_millis(1_000) { 1_000_000 } else { 100_000_000 };
    Duration::from_nanos(span.as_nanos() / unit * unit)
}

/// A service was to be started while another is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a service is under way")]
pub struct Busy;

/// One encoder's handshake, seen from the master.
#[derive(Clone, Copy, Debug)]
pub struct Session {
    timing: Timing,
    phase: SessionPhase,
    out: OutWord,
    /// An earlier request may still be under way in the encoder.
    doubtful: bool,
    /// Bit 29 of the last word seen before the request.
    error_before: bool,
    /// The same while words still come, and in how many of them in a row.
    error_seen: Option<(bool, u32)>,
    /// An earlier request was in doubt when the present one was taken back.
    doubtful_before: bool,
    /// Different words with IN bit 31 since one without it.
    strangers: u32,
    wait: Wait,
    /// The last poll brought nothing.
    failed: bool,
    last: Option<InWord>,
}

/// The phases of the handshake; the head of [`crate::session`] says what each waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionPhase {
    /// No service is under way.
    Resting,
    /// The request stands on OUT without its service bit.
    Preparing(Request),
    /// The request is out.
    Requesting {
        /// It.
        request: Request,
        /// A reply that has been seen and is not believed yet.
        shown: Option<ShownReply>,
    },
    /// The reply was seen, and the service bit is taken back.
    Ending {
        /// What was asked.
        request: Request,
        /// What came.
        reply: Reply,
    },
    /// The service bit is taken back without a reply.
    Clearing {
        /// Why.
        ended: WhyCleared,
        /// What was asked.
        request: Request,
        /// What is known of it by now.
        fate: Fate,
        /// A reply that has been seen and is not believed yet.
        shown: Option<ShownReply>,
    },
}

/// A reply, and since when it has been seen without a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShownReply {
    reply: Reply,
    since: Instant,
    polls: u32,
}

/// A word that a poll has brought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Noted {
    input: InWord,
    /// It may have left the ring as early as this.
    left: Instant,
}

/// Why a request is being cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyCleared {
    /// No reply came in time.
    TimedOut(TimedOut),
    /// It was given up.
    OnDemand,
}

/// When the encoder is to be looked at again, and why then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NextLook {
    /// After this time at the latest; sooner does no harm.
    pub within: Duration,
    /// What is looked for.
    pub why: LookFor,
}

/// What the next look is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LookFor {
    /// The last poll failed: whether the bus works again. A gateway has nothing new in every instant.
    Recovery,
    /// A word only has to stand on OUT: whether IN bit 31 is 0 meanwhile.
    Settling,
    /// A reply, or its end.
    Reply,
}

/// How long the present phase has lasted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Wait {
    since: Instant,
    polls: u32,
    answered: u32,
    /// Since when the phase's word is known to stand on OUT: the first poll that did not fail.
    stands: Option<Instant>,
}

impl Session {
    /// A session with an encoder of which nothing is known. `standing` is what its OUT word holds; it stays there,
    /// the service bit apart, until the first service.
    #[must_use]
    pub fn new(timing: Timing, standing: OutWord) -> Self {
        Self {
            timing,
            phase: SessionPhase::Resting,
            out: OutWord::from(encoring_words::word::Out::Normal(standing.0)),
            doubtful: true,
            error_before: false,
            error_seen: None,
            doubtful_before: false,
            strangers: 0,
            wait: Wait::default(),
            failed: false,
            last: None,
        }
    }

    /// `true` while no service is under way.
    #[must_use]
    pub const fn is_resting(&self) -> bool {
        matches!(self.phase, SessionPhase::Resting)
    }

    /// What OUT shall be until the next poll.
    #[must_use]
    pub const fn out(&self) -> OutWord {
        self.out
    }

    /// The phase of the handshake.
    #[must_use]
    pub const fn phase(&self) -> SessionPhase {
        self.phase
    }

    /// `true` while a request is out that must not be written a second time: see [`Request::moves_the_zero`].
    #[must_use]
    pub const fn is_unrepeatable(&self) -> bool {
        matches!(self.phase, SessionPhase::Requesting { request, .. } if request.moves_the_zero())
    }

    /// When to poll again.
    #[must_use]
    pub fn next_look(&self) -> NextLook {
        self.timing.next_look(match self.phase {
            _ if self.failed => LookFor::Recovery,
            SessionPhase::Preparing(_) => LookFor::Settling,
            _ => LookFor::Reply,
        })
    }

    /// Starts a service at `now`, and says what OUT shall be for the first poll.
    ///
    /// # Errors
    /// [`Busy`] if another one is under way.
    pub fn start(&mut self, now: Instant, request: Request) -> Result<OutWord, Busy> {
        if !self.is_resting() {
            return Err(Busy);
        }
        self.error_seen = None;
        self.enter(now, SessionPhase::Preparing(request), request.rest());
        Ok(self.out)
    }

    /// Gives the present service up: the service bit is taken back if it is set. The outcome follows from
    /// [`Session::cycle`]. `false` if there is nothing to give up: the service ends by itself, and soon.
    pub fn give_up(&mut self, now: Instant) -> bool {
        match self.phase {
            SessionPhase::Requesting { request, shown } => {
                self.clear(now, WhyCleared::OnDemand, request, shown);
            }
            // Nothing was sent; the next call says so.
            SessionPhase::Preparing(request) => {
                let (ended, fate) = (WhyCleared::OnDemand, Fate::NotSent);
                self.phase = SessionPhase::Clearing { ended, request, fate, shown: None };
            }
            SessionPhase::Resting | SessionPhase::Ending { .. } | SessionPhase::Clearing { .. } => {
                return false;
            }
        }
        true
    }

    /// The request was found not to stand on OUT any more, and must not be written a second time: it is taken back, and
    /// whether it was carried out only a late reply can tell.
    pub fn fell(&mut self, now: Instant) {
        if let SessionPhase::Requesting { request, shown } = self.phase {
            let timed_out = self.in_vain(now, WaitedFor::Acknowledgement, Fate::Unknown);
            self.clear(now, WhyCleared::TimedOut(timed_out), request, shown);
        }
    }

    /// Ends the present service at once, whatever may still come; `None` if there is none. The service bit may stand on
    /// OUT then.
    pub fn abandon(&mut self) -> Option<Outcome> {
        let fate = match self.phase {
            SessionPhase::Resting => return None,
            SessionPhase::Preparing(_) => Fate::NotSent,
            SessionPhase::Requesting { .. } | SessionPhase::Ending { .. } => Fate::Unknown,
            SessionPhase::Clearing { fate, .. } => fate,
        };
        self.doubtful = true;
        self.phase = SessionPhase::Resting;
        Some(Outcome::GivenUp(GivenUp { fate }))
    }

    /// After a poll of the bus: `seen` is what it brought, with the session's last word on OUT; `None` if it failed.
    /// Returns what OUT shall be for the next poll, and the outcome if the service came to its end.
    ///
    /// A gateway may have let its outputs fall while a poll failed. A request that moves the zero must then not be
    /// written again: read OUT back, and if the request does not stand there call [`Session::fell`].
    pub fn cycle(&mut self, now: Instant, seen: Option<Seen>) -> (OutWord, Option<Outcome>) {
        let noted = self.note(now, seen);
        let outcome = match self.phase {
            SessionPhase::Resting => None,
            SessionPhase::Preparing(request) => self.prepare(now, request, noted),
            SessionPhase::Requesting { request, shown } => self.request(now, request, shown, noted),
            SessionPhase::Ending { request, reply } => self.end(now, request, reply, noted),
            SessionPhase::Clearing { ended, request, fate, shown } => {
                self.clearing(now, ended, request, fate, shown, noted)
            }
        };
        (self.out, outcome)
    }

    /// Counts the poll.
    fn note(&mut self, now: Instant, seen: Option<Seen>) -> Option<Noted> {
        self.wait.polls = self.wait.polls.saturating_add(1);
        self.failed = seen.is_none();
        let Seen { input, age } = seen?;
        self.wait.answered = self.wait.answered.saturating_add(1);
        self.wait.stands.get_or_insert(now);
        self.strangers = match self.last {
            _ if !input.service_bit() => 0,
            Some(last) if last == input => self.strangers,
            _ => self.strangers.saturating_add(1),
        };
        self.last = Some(input);
        Some(Noted { input, left: Instant(now.as_nanos().saturating_sub(age.as_nanos())) })
    }

    fn prepare(&mut self, now: Instant, request: Request, noted: Option<Noted>) -> Option<Outcome> {
        let shown = noted.filter(|noted| matches!(noted.input.decode(), In::Position { .. }));
        // Also by a word from before: one alone, which a gateway may have spoilt, tells nothing.
        let told = shown.is_some_and(|shown| self.error_bit_stands(shown.input));
        if let Some(Noted { input: shown, left }) = shown
            && told
            && left >= self.wait.since
            && self.settled(now, self.wait.stands, self.wait.answered)
        {
            self.error_before = shown.error_bit();
            self.enter(now, SessionPhase::Requesting { request, shown: None }, request.word());
            return None;
        }
        let timed_out = self.timed_out(now, WaitedFor::Normal, Fate::NotSent)?;
        self.phase = SessionPhase::Resting;
        Some(Outcome::TimedOut(timed_out))
    }

    /// Whether the error bit is told by enough words. An encoder keeps it, so one that comes and goes is a gateway's.
    fn error_bit_stands(&mut self, shown: InWord) -> bool {
        let bit = shown.error_bit();
        let alike = match self.error_seen {
            None => ALIKE,
            Some((before, alike)) if before == bit => alike.saturating_add(1),
            Some(_) => 1,
        };
        self.error_seen = Some((bit, alike));
        alike >= ALIKE
    }

    fn request(
        &mut self,
        now: Instant,
        request: Request,
        shown: Option<ShownReply>,
        noted: Option<Noted>,
    ) -> Option<Outcome> {
        let shown = match noted {
            Some(noted) => self.seen_again(now, request, shown, noted),
            None => shown,
        };
        self.phase = SessionPhase::Requesting { request, shown };
        if let (Some(shown), Some(Noted { left, .. })) = (shown, noted)
            && self.stands(now, left, shown)
        {
            self.doubtful = false;
            self.enter(now, SessionPhase::Ending { request, reply: shown.reply }, request.rest());
        } else if self.is_out_of_patience(now) {
            self.fell(now);
        }
        None
    }

    /// The reply that a word is, if it is one, and how often it has been seen by now.
    fn seen_again(
        &self,
        now: Instant,
        request: Request,
        shown: Option<ShownReply>,
        noted: Noted,
    ) -> Option<ShownReply> {
        let reply = request.answered_by(noted.input).filter(|_| self.strangers <= STRANGERS_MAX)?;
        Some(match shown {
            Some(shown) if shown.reply == reply => {
                ShownReply { polls: shown.polls.saturating_add(1), ..shown }
            }
            _ => ShownReply { reply, since: now, polls: 0 },
        })
    }

    /// Whether a reply may be believed. A bus that does not show every cycle could have torn it, so there it must be
    /// seen twice; in doubt it must stand for the settling time.
    fn stands(&self, now: Instant, left: Instant, shown: ShownReply) -> bool {
        if self.doubtful {
            return shown.polls > 0
                && left >= shown.since
                && self.settled(now, Some(shown.since), shown.polls);
        }
        shown.polls > 0 || self.timing.settle == Duration::ZERO
    }

    fn end(&mut self, now: Instant, request: Request, reply: Reply, noted: Option<Noted>) -> Option<Outcome> {
        if noted.is_some_and(|noted| !noted.input.service_bit()) {
            self.phase = SessionPhase::Resting;
            return Some(Outcome::Done { reply, error_before: self.error_before });
        }
        // A write's reply has all of its bits; the few of a read can be those of something else.
        let fate = match request.access() {
            Access::Write => Fate::CarriedOut(reply),
            Access::Read => Fate::Unknown,
        };
        let timed_out = self.timed_out(now, WaitedFor::End, fate)?;
        self.doubtful = true;
        self.phase = SessionPhase::Resting;
        Some(Outcome::TimedOut(timed_out))
    }

    /// Waits for a late reply for as long as for the reply, whatever IN shows meanwhile.
    fn clearing(
        &mut self,
        now: Instant,
        ended: WhyCleared,
        request: Request,
        fate: Fate,
        shown: Option<ShownReply>,
        noted: Option<Noted>,
    ) -> Option<Outcome> {
        let fate = match (shown, noted) {
            (Some(shown), Some(Noted { input, left }))
                if !input.service_bit() && self.was_late(left, shown) =>
            {
                Fate::CarriedOut(shown.reply)
            }
            _ => fate,
        };
        if fate == Fate::Unknown && !self.is_out_of_patience(now) {
            let shown = match noted {
                Some(noted) => self.seen_again(now, request, shown, noted),
                None => shown,
            };
            self.phase = SessionPhase::Clearing { ended, request, fate, shown };
            return None;
        }
        self.phase = SessionPhase::Resting;
        Some(match ended {
            WhyCleared::OnDemand => Outcome::GivenUp(GivenUp { fate }),
            WhyCleared::TimedOut(timed_out) => Outcome::TimedOut(TimedOut { fate, ..timed_out }),
        })
    }

    /// Whether a reply that is over was one to this request: seen twice, and if it could be an earlier one's for as long
    /// as that cannot be seen.
    fn was_late(&self, left: Instant, shown: ShownReply) -> bool {
        let polls = shown.polls > 0;
        polls && (!self.doubtful_before || self.settled(left, Some(shown.since), shown.polls))
    }

    fn clear(&mut self, now: Instant, ended: WhyCleared, request: Request, shown: Option<ShownReply>) {
        self.doubtful_before = core::mem::replace(&mut self.doubtful, true);
        let fate = Fate::Unknown;
        self.enter(now, SessionPhase::Clearing { ended, request, fate, shown }, request.rest());
    }

    fn enter(&mut self, now: Instant, phase: SessionPhase, out: OutWord) {
        self.phase = phase;
        self.out = out;
        self.wait = Wait { since: now, ..Wait::default() };
    }

    fn settled(&self, now: Instant, since: Option<Instant>, polls: u32) -> bool {
        let stood = since.map_or(Duration::ZERO, |since| now.since(since));
        polls >= self.timing.settle_polls && since.is_some() && stood >= self.timing.settle
    }

    fn is_out_of_patience(&self, now: Instant) -> bool {
        now.since(self.wait.since) >= self.timing.patience && self.wait.polls >= self.timing.patience_polls
    }

    fn timed_out(&self, now: Instant, waited_for: WaitedFor, fate: Fate) -> Option<TimedOut> {
        self.is_out_of_patience(now).then(|| self.in_vain(now, waited_for, fate))
    }

    /// What was waited for since the present phase began.
    fn in_vain(&self, now: Instant, waited_for: WaitedFor, fate: Fate) -> TimedOut {
        let Wait { since, polls, answered, .. } = self.wait;
        TimedOut { waited_for, time: now.since(since), polls, answered, last: self.last, fate }
    }

    /// What the encoder shows in normal mode, as it was seen last: `None` while it shows a reply, or nothing was seen.
    #[must_use]
    pub fn position(&self) -> Option<In> {
        self.last.map(InWord::decode).filter(|shown| matches!(shown, In::Position { .. }))
    }
}

#[cfg(test)]
mod tests;
