//! A ring behind a bus, looked at poll by poll: what can be seen of a real ring, and written to it by whoever may.
//!
//! One thread has the bus: it polls, and carries out between two polls what the clones of a [`PolledRing`] ask for.
//! Nothing is written unless somebody asks for it.

#[cfg(test)]
mod tests;

use std::io;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use encoring_bus::watch::{Plan, Poll, Sight, Subject, Watch};
use encoring_bus::{Bus, EncoderMaster, Insight, Judgement, LeftBit, Link, MasterError, RingNews};
use encoring_host::{Outcome, Request, Services};
use encoring_words::{Duration, InWord, Instant, Model, OutWord};
use serde_json::Value;

use crate::answer::{ToldBack, told_back};
use crate::causes::{Caused, Causes};
use crate::events::{Events, Happened, Kept, RingEvent};
use crate::history::{Looks, Watched, WordHistory};
use crate::known::{KnownEncoder, KnownFile};
use crate::polled_view::{self, Beside, LinkView, PolledView};
use crate::shown::{AboutRing, ShownRing, ShownUnit};
use crate::station::RingStopped;
use crate::verbs::{Command, Encoders, Given, Permission, Refused, given};
use crate::view::LampsView;

/// How many requests may wait for the next poll to be over; whoever asks more waits too.
const REQUESTS_WAITING: usize = 64;

/// What is looked at, and how.
#[derive(Debug)]
pub struct PollOptions {
    /// The address of the bus, as it was named.
    pub bus: String,
    /// `true` if nothing of it is real.
    pub simulated: bool,
    /// The encoders, each with its judge.
    pub subjects: Vec<Subject>,
    /// What files say of them.
    pub files: Vec<KnownFile>,
    /// When the polls are made.
    pub plan: Plan,
    /// How long each step of a service may take.
    pub patience: Duration,
}

/// Who has a ring looked at.
pub trait Onlooker {
    /// What is known of an encoder whose insides can be seen.
    fn insight(&self, position: usize) -> Option<Insight>;

    /// The lamps of an encoder whose insides can be seen.
    fn lamps(&self, position: usize) -> Option<LampsView>;

    /// Whether it is to end.
    fn is_over(&self) -> bool;

    /// From now on a service may be under way at this position.
    fn serving(&self, position: usize, left: LeftBit);

    /// Told after every poll, with what has happened since the last call.
    ///
    /// # Errors
    /// If it could not be passed on; then nobody looks any more.
    fn happened(&mut self, events: &[RingEvent]) -> io::Result<()>;
}

/// A ring that is about to be looked at.
#[derive(Debug)]
pub struct Polled {
    ring: PolledRing,
    subjects: Vec<Subject>,
    plan: Plan,
    patience: Duration,
    watched: Watched,
    /// Of each encoder what is known of its parameters, in the order of the positions.
    known: Vec<KnownEncoder>,
    causes: Causes,
    events: Events,
    requests: Receiver<Asked>,
    /// That no connection can be made was told.
    failed: bool,
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolledEnd {
    /// Time on the bus in nanoseconds.
    pub time_ns: u64,
    /// Polls made.
    pub polls: u64,
    /// `false` if none has brought a word.
    pub answered: bool,
}

/// A ring that is looked at by polls. Clones are of the same ring.
#[derive(Clone, Debug)]
pub struct PolledRing(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    about: AboutRing,
    units: Vec<ShownUnit>,
    placed: Vec<(usize, Model)>,
    view: Mutex<PolledView>,
    history: WordHistory,
    events: Arc<Kept>,
    requests: SyncSender<Asked>,
}

/// Something that is asked of the bus.
#[derive(Debug)]
struct Asked {
    position: usize,
    what: Deed,
    done: SyncSender<Result<Given, Refused>>,
}

#[derive(Debug)]
enum Deed {
    WriteOut(OutWord),
    Serve(Request),
    Acknowledge,
}

impl Polled {
    /// A ring of which nothing was seen yet.
    #[must_use]
    pub fn new(options: PollOptions) -> Self {
        let PollOptions { bus, simulated, mut subjects, files, plan, patience } = options;
        subjects.sort_by_key(|subject| subject.position);
        let file_of = |position| files.iter().find(|file| file.position == position);
        let (requests, waiting) = sync_channel(REQUESTS_WAITING);
        let unit = |subject: &Subject| ShownUnit {
            position: subject.position,
            model: subject.judge.model(),
            sensor: subject.judge.sensor(),
            firmware: None,
            file: file_of(subject.position).cloned(),
        };
        let units: Vec<ShownUnit> = subjects.iter().map(unit).collect();
        let known = |subject: &Subject| {
            let values = file_of(subject.position).map_or(&[][..], |file| &file.values);
            KnownEncoder::new(subject.judge.model(), subject.judge.sensor(), values)
        };
        let known = subjects.iter().map(known).collect();
        let placed: Vec<_> = units.iter().map(|unit| (unit.position, unit.model)).collect();
        // The history counts from 0, whichever encoders are looked at.
        let places = placed.last().map_or(0, |(last, _)| last + 1);
        let (watched, events) = (Watched::new(places, Looks::Polls), Events::new());
        let about = AboutRing { bus: Some(bus), simulated, poll_ns: Some(plan.every.as_nanos()) };
        let inner = Inner {
            about,
            units,
            view: Mutex::new(PolledView::unseen(&placed, plan.every)),
            placed,
            history: watched.history().clone(),
            events: Arc::clone(events.kept()),
            requests,
        };
        Self {
            ring: PolledRing(Arc::new(inner)),
            subjects,
            plan,
            patience,
            watched,
            known,
            causes: Causes::default(),
            events,
            requests: waiting,
            failed: false,
        }
    }

    /// The ring, to be given away.
    #[must_use]
    pub const fn ring(&self) -> &PolledRing {
        &self.ring
    }

    /// Polls until it is over.
    ///
    /// # Errors
    /// That of the onlooker.
    pub fn run<B: Bus + ?Sized>(
        mut self,
        bus: &mut B,
        stop: &Arc<AtomicBool>,
        onlooker: &mut impl Onlooker,
    ) -> io::Result<PolledEnd> {
        let subjects = std::mem::take(&mut self.subjects);
        let mut watch = Watch::new(bus, subjects, self.plan, Arc::clone(stop));
        let mut told = 0;
        while let Some(poll) = watch.poll_with(|position| onlooker.insight(position)) {
            self.take(poll);
            self.learn(watch.latest(), watch.subjects(), onlooker);
            let beside = Beside {
                known: &self.known,
                causes: &self.causes,
                lamps: &|position| onlooker.lamps(position),
            };
            let link = self.ring.view().link.clone();
            let view = PolledView::of(&watch, link, self.plan.every, &beside);
            *self.ring.view() = view;
            while let Ok(asked) = self.requests.try_recv() {
                self.carry_out(asked, &mut watch, stop, onlooker);
            }
            let events = self.events.kept().since(told).unwrap_or_default();
            told = events.last().map_or(told, |last| last.number + 1);
            onlooker.happened(&events)?;
            if onlooker.is_over() {
                break;
            }
        }
        let rest = self.causes.rest(watch.subjects());
        self.tell_causes(watch.now(), rest);
        onlooker.happened(&self.events.kept().since(told).unwrap_or_default())?;
        let (time_ns, polls) = (watch.now().as_nanos(), watch.polls());
        Ok(PolledEnd { time_ns, polls, answered: !watch.is_unanswered() })
    }

    /// Takes what a poll has brought.
    fn take(&mut self, poll: &Poll) {
        for Sight { position, at, input, out, .. } in &poll.sights {
            if let (Some(out), Some(input)) = (out, input) {
                self.watched.saw(*at, *position, *out, *input);
            }
        }
        for event in &poll.link {
            self.linked(event.at, &event.what);
        }
        if let Some(news) = &poll.ring {
            self.events.push(poll.at, of_ring(news));
        }
        for sight in &poll.sights {
            if sight.stop.is_some() {
                let (position, verdict) = (sight.position, sight.verdict.word());
                self.events.push(sight.at, Happened::Doubted { position, verdict });
            }
        }
        for position in &poll.acknowledged {
            self.events.push(poll.at, Happened::Acknowledged { position: *position });
        }
        for (position, finding) in &poll.findings {
            let finding = polled_view::finding(*position, finding);
            self.events.push(poll.at, Happened::Finding(Box::new(finding)));
        }
    }

    /// Takes what the words of a poll tell of parameters and of jumps.
    fn learn(&mut self, poll: &Poll, subjects: &[Subject], onlooker: &impl Onlooker) {
        for (sight, known) in poll.sights.iter().zip(&mut self.known) {
            match (&sight.verdict, sight.input) {
                (Judgement::RingStopped(_) | Judgement::Stale { .. } | Judgement::NoAnswer(_), _)
                | (_, None) => {
                    known.lost();
                }
                (_, Some(input)) => known.saw(sight.at, sight.out, input),
            }
            if let Some(Insight { active, .. }) = onlooker.insight(sight.position) {
                known.inside(sight.at, &active);
            }
        }
        let told = self.causes.take(poll, subjects);
        self.tell_causes(poll.at, told);
    }

    fn tell_causes(&mut self, at: Instant, told: Vec<Caused>) {
        for Caused { position, found } in told {
            self.events.push(at, Happened::JumpCause { position, found: Box::new(found) });
        }
    }

    /// Attempts that fail one after the other are told once.
    fn linked(&mut self, at: Instant, what: &Link) {
        let failed = std::mem::replace(&mut self.failed, matches!(what, Link::Failed { .. }));
        let link = LinkView::of(what);
        let text = what.to_string();
        match what {
            Link::Up { .. } => self.events.push(at, Happened::LinkUp),
            Link::Down { .. } => self.events.push(at, Happened::LinkDown { problem: text }),
            Link::Failed { .. } if failed => {}
            Link::Failed { .. } => self.events.push(at, Happened::LinkFailed { problem: text }),
        }
        self.ring.view().link = link;
    }

    fn carry_out<B: Bus + ?Sized>(
        &mut self,
        asked: Asked,
        watch: &mut Watch<'_, B>,
        stop: &Arc<AtomicBool>,
        onlooker: &impl Onlooker,
    ) {
        let Asked { position, what, done } = asked;
        let bus_failed = |error| Refused::Bus { position, problem: MasterError::Bus(error) };
        let result = match what {
            Deed::Acknowledge => {
                watch.acknowledge_at(position);
                Ok(Given::Done)
            }
            Deed::WriteOut(word) => {
                let written = watch.bus().cycle(Some((position, word)), position, &mut [InWord(0)]);
                written.map(|_| Given::Done).map_err(bus_failed)
            }
            Deed::Serve(request) => self
                .serve(position, request, watch.bus(), stop, onlooker)
                .map_err(|problem| Refused::Bus { position, problem })
                .and_then(|outcome| given(position, outcome)),
        };
        // Whoever asked may have gone; then there is nobody to tell.
        let _ = done.send(result);
    }

    fn serve<B: Bus + ?Sized>(
        &mut self,
        position: usize,
        request: Request,
        bus: &mut B,
        stop: &Arc<AtomicBool>,
        onlooker: &impl Onlooker,
    ) -> Result<Outcome, MasterError> {
        let Self { ring, watched, known, events, patience, .. } = self;
        let place = ring.0.placed.iter().position(|(place, _)| *place == position);
        let mut known = place.and_then(|place| known.get_mut(place));
        let mut master = EncoderMaster::new(bus, position, *patience, Arc::clone(stop))?;
        onlooker.serving(position, master.left());
        master.observe(|look| {
            if let Some(input) = look.input {
                watched.saw(look.at, position, look.out, input);
                if let Some(known) = &mut known {
                    known.saw(look.at, Some(look.out), input);
                }
            }
        });
        let served = master.serve(request);
        let left = master.withdraw();
        let at = master.bus().now();
        drop(master);
        if let Some(out) = left {
            events.push(at, Happened::ServiceBitLeft { position, out });
        }
        served
    }
}

const fn of_ring(news: &RingNews) -> Happened {
    match news {
        RingNews::Stopped(says) => Happened::RingStands { says: polled_view::says(*says) },
        RingNews::Runs { times, diagnosis, .. } => {
            Happened::RingRuns { times: *times, says: polled_view::says(*diagnosis) }
        }
        RingNews::Says(says) => Happened::MasterSays { says: polled_view::says(*says) },
        RingNews::FaultyCycle(says) => Happened::FaultyCycle { says: polled_view::says(*says) },
        RingNews::Unread(_) => Happened::MasterUnread,
    }
}

impl PolledRing {
    fn view(&self) -> MutexGuard<'_, PolledView> {
        self.0.view.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn obey(&self, command: &Command) -> Result<Given, Refused> {
        let (position, what) = match *command {
            Command::View => return Ok(Given::PolledView(Box::new(self.view().clone()))),
            Command::Help => return Ok(Given::Help),
            Command::Out { position, word } => (position, Deed::WriteOut(word)),
            Command::Serve { position, request } => (position, Deed::Serve(request)),
            Command::Acknowledge { position } => (position, Deed::Acknowledge),
            // They are said to simulated rings only, and were refused when they were read.
            _ => return Err(Refused::NoGateway),
        };
        let (done, answered) = sync_channel(1);
        self.0.requests.send(Asked { position, what, done }).map_err(|_| RingStopped)?;
        answered.recv().map_err(|_| RingStopped)?
    }
}

impl ShownRing for PolledRing {
    fn about(&self) -> AboutRing {
        self.0.about.clone()
    }

    fn units(&self) -> Vec<ShownUnit> {
        self.0.units.clone()
    }

    fn seen(&self) -> Result<Value, RingStopped> {
        self.happened(u64::MAX)?;
        // Plain data with names for keys has no reason to fail.
        Ok(serde_json::to_value(&*self.view()).unwrap_or_default())
    }

    fn history(&self) -> &WordHistory {
        &self.0.history
    }

    fn happened(&self, from: u64) -> Result<Vec<RingEvent>, RingStopped> {
        self.0.events.since(from).ok_or(RingStopped)
    }

    fn told(&self, line: &str, permission: Permission) -> ToldBack {
        told_back(line, Encoders::Polled(&self.0.placed), permission, |command| self.obey(&command))
    }
}
