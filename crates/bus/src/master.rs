//! One encoder on a bus, and the master that carries its services out.

mod failed;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use encoring_host::{LookFor, NextLook, Outcome, Request, Seen, Services, Session, SessionPhase, Timing};
use encoring_words::word::Out;
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::bus::{Answered, Bus, BusError, Cause};
use crate::misread::{can_be_sent, turned};

pub use failed::{Behind, Cure, MasterError};

/// So many words in a row that no encoder sends are not torn: the gateway makes them so.
const STRANGE: u32 = 3;

/// What a master tells of its work.
pub type Observe<'a> = Box<dyn FnMut(&Look) + 'a>;

/// One poll of a service under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// When it was over.
    pub at: Instant,
    /// The phase of the handshake.
    pub phase: SessionPhase,
    /// The OUT word that was to be written.
    pub out: OutWord,
    /// The IN word that was seen, if one was.
    pub input: Option<InWord>,
}

/// The word with the service bit that was written to a bus and has not been seen gone there. Clones show the same.
#[derive(Clone, Debug, Default)]
pub struct LeftBit(Arc<AtomicU32>);

impl LeftBit {
    /// It, or `None` if a read of OUT has shown it gone, or none was written.
    #[must_use]
    pub fn word(&self) -> Option<OutWord> {
        Some(OutWord(self.0.load(Ordering::Relaxed))).filter(|out| out.service_bit())
    }

    fn set(&self, out: OutWord) {
        self.0.store(out.0, Ordering::Relaxed);
    }
}

/// Whether the word that goes before a request was seen on OUT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Prepared {
    Not,
    /// OUT could not be read.
    Unread,
    /// Another word was, in so many looks in a row.
    Unlike {
        out: OutWord,
        looks: u32,
    },
    Seen,
}

/// Carries services out on one encoder of a bus. It reads before it writes, and writes only what it has to.
pub struct EncoderMaster<'a, B: ?Sized> {
    bus: &'a mut B,
    position: usize,
    session: Session,
    timing: Timing,
    /// What is known to stand on OUT because it was written here.
    written: Option<OutWord>,
    left: LeftBit,
    /// Words whose write got no answer, and since when: a gateway may still carry them out.
    unanswered: Vec<(OutWord, Instant)>,
    /// What OUT held when the present service began, if it was written here.
    found: Option<OutWord>,
    /// Whether the word that goes before the present request was seen on OUT.
    prepared: Prepared,
    /// So many writes in a row were confirmed as others.
    misdirected: u32,
    /// So many words in a row came that no encoder sends.
    strange: u32,
    /// The request that was to be written first, if it must not be written twice.
    once: Option<OutWord>,
    stop: Arc<AtomicBool>,
    /// How often the user wanted to stop.
    stops: u32,
    /// The user wanted to when nothing could be given up any more.
    stop_next: bool,
    last_error: Option<BusError>,
    /// What OUT told at the end of the last time-out, if it was not what was written here.
    not_ours: Option<Behind>,
    observe: Option<Observe<'a>>,
}

impl<'a, B: Bus + ?Sized> EncoderMaster<'a, B> {
    /// A master for the encoder at `position`. It gives up as soon as `stop` is set, and takes the mark back.
    ///
    /// # Errors
    /// [`MasterError`] if the encoder cannot be reached, or another master is at work.
    pub fn new(
        bus: &'a mut B,
        position: usize,
        patience: Duration,
        stop: Arc<AtomicBool>,
    ) -> Result<Self, MasterError> {
        let settling = bus.settling();
        let timing =
            Timing { settle_polls: settling.cycles, settle: settling.time, patience, ..Timing::DIRECT };
        let mut master = Self {
            bus,
            position,
            session: Session::new(timing, OutWord(0)),
            timing,
            written: None,
            left: LeftBit::default(),
            unanswered: Vec::new(),
            found: None,
            prepared: Prepared::Not,
            misdirected: 0,
            strange: 0,
            once: None,
            stop,
            stops: 0,
            stop_next: false,
            last_error: None,
            not_ours: None,
            observe: None,
        };
        let mut standing = master.read_out()?;
        for _ in 1..STRANGE {
            if !standing.service_bit() {
                break;
            }
            master.rest(timing.next_look(LookFor::Recovery));
            standing = master.read_out()?;
        }
        if standing.service_bit() {
            // Where IN is nobody's, OUT is not read as it is either.
            master.readable()?;
            return Err(MasterError::OtherMaster { out: standing });
        }
        master.session = Session::new(timing, standing);
        Ok(master)
    }

    /// Tells `observe` every poll of every service.
    pub fn observe(&mut self, observe: impl FnMut(&Look) + 'a) {
        self.observe = Some(Box::new(observe));
    }

    /// What may be behind the last time-out: what OUT tells, else the last trouble with the bus.
    #[must_use]
    pub fn behind(&self) -> Option<Behind> {
        self.not_ours.clone().or_else(|| self.last_error.clone().map(Behind::Bus))
    }

    /// The bus.
    pub const fn bus(&mut self) -> &mut B {
        self.bus
    }

    /// Whether the user wants to stop, for the first time since this was asked.
    fn interrupted(&mut self) -> bool {
        let now = self.stop.swap(false, Ordering::Relaxed);
        self.stops += u32::from(now);
        now | std::mem::take(&mut self.stop_next)
    }

    /// Whether the user has wanted to stop twice: nothing is waited for any more.
    const fn in_a_hurry(&self) -> bool {
        self.stops > 1
    }

    /// Keeps an error, and gives what it comes to: that the next attempt to connect is not due yet hides no reason.
    fn met(&mut self, error: BusError) -> BusError {
        match (&self.last_error, &error) {
            (Some(reason), BusError::NoConnection(Cause::Waiting { .. })) => reason.clone(),
            _ => self.last_error.insert(error).clone(),
        }
    }

    /// Reads OUT, until it can be read. Whoever finds no service bit there has seen ours gone.
    fn read_out(&mut self) -> Result<OutWord, MasterError> {
        let out = self.patiently(|bus, position, _| Ok(bus.out(position)?))?;
        self.seen(out);
        Ok(out)
    }

    /// Notes that the service bit is gone, if OUT shows the word that took it back, or was let fall: another word may be
    /// one that the gateway has spoilt. A write that is older than the patience now does not come any more.
    fn seen(&mut self, out: OutWord) {
        let (now, patience) = (self.bus.now(), self.timing.patience);
        self.unanswered.retain(|(_, since)| now.since(*since) < patience);
        if let Some(left) = self.left.word()
            && (out == rest(left) || out == OutWord(0) || self.written == Some(out) && !out.service_bit())
        {
            self.left.set(OutWord(0));
        }
    }

    /// Refuses to work while somebody else does.
    fn alone(&mut self) -> Result<(), MasterError> {
        for _ in 1..STRANGE {
            match self.is_alone() {
                Err(MasterError::OtherMaster { .. } | MasterError::Overwritten { .. }) => {}
                told => return told,
            }
            // It may be a word that the gateway has spoilt.
            self.rest(self.timing.next_look(LookFor::Recovery));
        }
        self.is_alone()
    }

    fn is_alone(&mut self) -> Result<(), MasterError> {
        let left = self.left.word();
        let out = self.patiently(|bus, position, _| Ok(bus.out(position)?))?;
        let ours = self.is_ours(out);
        self.found = Some(out).filter(|_| self.written == Some(out));
        self.seen(out);
        if left == Some(out) || ours {
            // It came late, or spoilt, or the word that clears it was lost: the next word does.
            self.stands(out);
            return Ok(());
        }
        match self.written {
            // A gateway may have let its outputs fall.
            Some(ours) if out != ours && out != OutWord(0) => Err(MasterError::Overwritten { out, ours }),
            None if out.service_bit() => Err(MasterError::OtherMaster { out }),
            _ => Ok(()),
        }
    }

    /// A word of ours stands on OUT that was not the last one.
    fn stands(&mut self, out: OutWord) {
        self.written = None;
        if out.service_bit() {
            self.left.set(out);
        }
    }

    /// Takes a service bit of ours back that a gateway has set late.
    fn take_back_late(&mut self) {
        if self.unanswered.is_empty() {
            return;
        }
        if let Ok(out) = self.bus.out(self.position)
            && out.service_bit()
            && self.is_unanswered(out)
        {
            self.stands(out);
            // What it clears is read back before the next service, and by `withdraw`.
            let _ = self.bus.cycle(Some((self.position, rest(out))), self.position, &mut []);
        }
    }

    /// What OUT tells, if it is not what was written here last.
    fn not_ours_now(&mut self) -> Option<Behind> {
        let (ours, out) = (self.written?, self.bus.out(self.position).ok()?);
        if out == ours {
            return None;
        }
        // The gateway may carry a word of ours out late.
        Some(self.instead(out, ours))
            .filter(|behind| !matches!(behind, Behind::OtherMaster { .. }) || !self.is_unanswered(out))
    }

    /// Why OUT holds this instead of what was written here.
    fn instead(&self, out: OutWord, ours: OutWord) -> Behind {
        match turned(ours, out) {
            Some(way) => Behind::Turned { out, ours, way, cure: Cure::of_writes(self.bus, way) },
            None if out == OutWord(0) || Some(out) == self.found => Behind::NotThere { out, ours },
            None => Behind::OtherMaster { out, ours },
        }
    }

    /// Refuses to write where IN shows what no encoder sends: OUT would be written as wrongly as IN is read.
    fn readable(&mut self) -> Result<(), MasterError> {
        let mut strange = InWord(0);
        for _ in 0..STRANGE {
            let mut input = [InWord(0)];
            if let Err(error) = self.bus.cycle(None, self.position, &mut input) {
                // Whether anything comes at all the service finds out, which has the patience for it.
                self.met(error);
                return Ok(());
            }
            [strange] = input;
            if can_be_sent(strange) {
                return Ok(());
            }
            self.rest(self.timing.next_look(LookFor::Recovery));
        }
        Err(MasterError::Misread { input: strange, cure: Cure::of(self.bus, strange) })
    }

    /// The mark of a service bit that may stand on OUT because it was written here.
    #[must_use]
    pub fn left(&self) -> LeftBit {
        self.left.clone()
    }

    /// Reads OUT until the service bit that was written here is seen gone, and takes it back where it is not. A word whose
    /// write got no answer may come late, so OUT is watched for as long as the patience after it: whoever works next would
    /// take it for another master's. Ends when the patience does; then the bit may stand there, and must be told. To be
    /// called after the last service.
    pub fn withdraw(&mut self) -> Option<OutWord> {
        let since = self.bus.now();
        let mut strange = (OutWord(0), 0);
        while self.left.word().is_some() || !self.unanswered.is_empty() {
            match self.bus.out(self.position) {
                Ok(out) if self.left.word() == Some(out) || out.service_bit() && self.is_unanswered(out) => {
                    self.left.set(out);
                    // What it clears it reads back in the next round.
                    let _ = self.bus.cycle(Some((self.position, rest(out))), self.position, &mut []);
                }
                // Another service's is another master's, and it has taken ours away.
                Ok(out) if out.service_bit() => self.left.set(OutWord(0)),
                Ok(out) => {
                    self.seen(out);
                    // One look may be at a word that the gateway has spoilt; what stands is another master's.
                    strange = (out, if strange.0 == out { strange.1 + 1 } else { 1 });
                    if strange.1 == STRANGE {
                        self.left.set(OutWord(0));
                    }
                }
                Err(error) => self.last_error = Some(error),
            }
            if self.interrupted() || self.in_a_hurry() || self.is_over(since) {
                break;
            }
            self.rest(self.timing.next_look(LookFor::Recovery));
        }
        self.left.word().or(self.may_come_late())
    }

    /// Whether a gateway may carry out this word of ours late.
    fn is_unanswered(&self, out: OutWord) -> bool {
        self.unanswered.iter().any(|(word, _)| *word == out)
    }

    /// Whether this is a word of ours that a gateway has carried out late, or turned round.
    fn is_ours(&self, out: OutWord) -> bool {
        self.is_unanswered(out)
            || self.written.is_some_and(|written| written != out && turned(written, out).is_some())
    }

    /// The last word with the service bit that may still be carried out by a gateway that has not answered it.
    fn may_come_late(&self) -> Option<OutWord> {
        self.unanswered.iter().rev().map(|(out, _)| *out).find(|out| out.service_bit())
    }

    fn is_over(&self, since: Instant) -> bool {
        self.bus.now().since(since) >= self.timing.patience
    }

    /// Asks the bus for something until it is there, and gives up when the patience is at an end.
    fn patiently<T>(
        &mut self,
        ask: impl Fn(&mut B, usize, Duration) -> Result<T, MasterError>,
    ) -> Result<T, MasterError> {
        let since = self.bus.now();
        let mut asked = 0_u32;
        loop {
            let patience = self.timing.patience;
            let problem = match ask(self.bus, self.position, patience) {
                Ok(found) => return Ok(found),
                Err(problem) => problem,
            };
            let problem = match problem {
                MasterError::Bus(error) => MasterError::Bus(self.met(error)),
                problem => problem,
            };
            if let MasterError::InService { .. } = problem {
                self.take_back_late();
            }
            asked += 1;
            let time = self.bus.now().since(since) < patience;
            let patient = asked < self.timing.patience_polls || time && !is_refused(&problem);
            if !patient || matches!(&problem, MasterError::Bus(error) if error.is_no_encoder()) {
                return Err(problem);
            }
            if self.interrupted() || self.in_a_hurry() {
                return Err(MasterError::Interrupted);
            }
            self.rest(self.timing.next_look(LookFor::Recovery));
        }
    }

    /// What IN shows, once it can be seen.
    fn look_once(&mut self) -> Result<InWord, MasterError> {
        self.patiently(|bus, position, patience| {
            let mut input = [InWord(0)];
            let cycle = bus.cycle(None, position, &mut input)?;
            let [input] = input;
            if cycle.age >= patience {
                return Err(MasterError::Stale { age: cycle.age });
            }
            match input {
                input if !can_be_sent(input) => {
                    Err(MasterError::Misread { input, cure: Cure::of(bus, input) })
                }
                input if input.service_bit() => Err(MasterError::InService { input }),
                input => Ok(input),
            }
        })
    }

    /// Leaves a gateway in peace until the next look.
    fn rest(&mut self, next: NextLook) {
        if next.within > Duration::ZERO {
            self.bus.wait(next.within);
        }
    }

    /// One poll: writes `out` unless it stands there already.
    fn poll(&mut self, out: OutWord) -> Option<Seen> {
        if self.written != Some(out) && self.once == Some(out) {
            return self.read_back(out);
        }
        let write = (self.written != Some(out)).then_some((self.position, out));
        if write.is_some() && out.service_bit() {
            self.left.set(out);
            self.once = self.session.is_unrepeatable().then_some(out);
        }
        let mut input = [InWord(0)];
        match self.bus.cycle(write, self.position, &mut input) {
            Ok(cycle) => {
                self.written = Some(out);
                self.misdirected = 0;
                let [input] = input;
                Some(Seen { input, age: cycle.age })
            }
            Err(error) => {
                if write.is_some() && matches!(error, BusError::NoAnswer { .. }) {
                    self.unanswered.retain(|(word, _)| *word != out);
                    self.unanswered.push((out, self.bus.now()));
                }
                if write.is_some() {
                    self.written = None;
                    self.misdirected += u32::from(error.is_answered(Answered::Misdirected));
                }
                self.met(error);
                None
            }
        }
    }

    /// What a poll has brought, if OUT holds the word that goes before a request. The service bit follows only then: where
    /// OUT is not written as it is read nobody knows what the encoder would get.
    fn prepared(&mut self, word: OutWord, seen: Option<Seen>) -> Option<Seen> {
        if seen.is_none() || self.prepared == Prepared::Seen {
            return seen;
        }
        match self.bus.out(self.position) {
            Ok(out) if out == word => {
                self.prepared = Prepared::Seen;
                return seen;
            }
            Ok(out) => self.look_again(out, word),
            Err(error) => {
                self.met(error);
                if self.prepared == Prepared::Not {
                    self.prepared = Prepared::Unread;
                }
            }
        }
        None
    }

    /// Another word than the one that goes before a request. A gateway may show it late, or have spoilt or lost one write.
    fn look_again(&mut self, out: OutWord, word: OutWord) {
        let looks = match self.prepared {
            Prepared::Unlike { out: before, looks } if before == out => looks.saturating_add(1),
            _ => 1,
        };
        self.prepared = Prepared::Unlike { out, looks };
        let others = matches!(self.instead(out, word), Behind::OtherMaster { .. });
        let ours = self.is_unanswered(out) || !others;
        // Less and less often: a gateway that loses every write need not be written to a hundred times.
        if ours && looks > 1 && looks.is_power_of_two() {
            self.stands(out);
        }
    }

    /// Why nothing can come of a request that was not sent yet: IN shows what no encoder sends, or the gateway confirms
    /// other writes than it was asked for.
    fn hopeless(&mut self, word: OutWord, seen: Option<Seen>) -> Option<MasterError> {
        let strange = seen.map(|seen| seen.input).filter(|input| !can_be_sent(*input));
        self.strange = strange.map_or(0, |_| self.strange.saturating_add(1));
        match (strange, &self.last_error) {
            (Some(input), _) if self.strange >= STRANGE => {
                Some(MasterError::Misread { input, cure: Cure::of(self.bus, input) })
            }
            (None, Some(error)) if self.misdirected >= STRANGE => {
                Some(MasterError::NotPrepared { word, behind: Behind::Bus(error.clone()) })
            }
            _ => None,
        }
    }

    /// Looks what is behind a time-out.
    fn ended(
        &mut self,
        phase: SessionPhase,
        word: OutWord,
        outcome: Outcome,
    ) -> Result<Outcome, MasterError> {
        if let Outcome::TimedOut(_) = outcome {
            if let (SessionPhase::Preparing(_), Some(error)) = (phase, self.not_prepared(word)) {
                return Err(error);
            }
            self.not_ours = self.not_ours_now();
        }
        Ok(outcome)
    }

    /// What stood on OUT instead of this word for as long as the patience, or why OUT could not be read.
    fn not_prepared(&self, word: OutWord) -> Option<MasterError> {
        let behind = match self.prepared {
            Prepared::Unlike { out, looks: STRANGE.. } => self.instead(out, word),
            Prepared::Unread => Behind::Bus(self.last_error.clone()?),
            Prepared::Unlike { .. } | Prepared::Not | Prepared::Seen => return None,
        };
        Some(match behind {
            Behind::OtherMaster { out, ours } => MasterError::Overwritten { out, ours },
            behind => MasterError::NotPrepared { word, behind },
        })
    }

    /// Looks whether a request stands on OUT that must not be written a second time: written again to a gateway that has
    /// meanwhile let its outputs fall, the service bit would rise twice.
    fn read_back(&mut self, out: OutWord) -> Option<Seen> {
        let busy = self.last_error.as_ref().is_some_and(|error| error.is_answered(Answered::Busy));
        match self.bus.out(self.position) {
            Ok(standing) if standing == out => self.written = Some(out),
            // Refused for the moment, and OUT shows that it was: the first time is still to come.
            Ok(standing) if busy && standing == rest(out) => self.once = None,
            Ok(_) => self.session.fell(self.bus.now()),
            Err(error) => self.last_error = Some(error),
        }
        None
    }
}

/// Whether asking more often than a few times is of no use.
fn is_refused(problem: &MasterError) -> bool {
    match problem {
        MasterError::Bus(error) => error.is_answered(Answered::Refused),
        // A word that is torn now and then is another one soon.
        problem => matches!(problem, MasterError::Misread { .. }),
    }
}

/// The same word without the service bit.
fn rest(out: OutWord) -> OutWord {
    OutWord::from(Out::Normal(out.0))
}

impl<B: Bus + ?Sized> Services for EncoderMaster<'_, B> {
    type Error = MasterError;

    fn serve(&mut self, request: Request) -> Result<Outcome, MasterError> {
        if self.interrupted() || self.in_a_hurry() {
            return Err(MasterError::Interrupted);
        }
        (self.last_error, self.once) = (None, None);
        (self.prepared, self.misdirected, self.strange) = (Prepared::Not, 0, 0);
        self.alone()?;
        if self.written.is_none() {
            self.readable()?;
        }
        // Every service is driven to its end below, so none is under way here.
        let mut out = self.session.start(self.bus.now(), request).unwrap_or(request.rest());
        loop {
            let phase = self.session.phase();
            let mut seen = self.poll(out);
            let at = self.bus.now();
            if let Some(observe) = &mut self.observe {
                observe(&Look { at, phase, out, input: seen.map(|seen| seen.input) });
            }
            if self.interrupted() && !self.session.give_up(at) {
                self.stop_next = true;
            }
            if let SessionPhase::Preparing(_) = self.session.phase() {
                if let Some(error) = self.hopeless(out, seen) {
                    self.session.abandon();
                    return Err(error);
                }
                seen = self.prepared(out, seen);
            }
            let (next, outcome) = self.session.cycle(at, seen);
            out = next;
            if let Some(outcome) = outcome {
                return self.ended(phase, request.rest(), outcome);
            }
            if self.in_a_hurry()
                && let Some(outcome) = self.session.abandon()
            {
                return Ok(outcome);
            }
            self.rest(self.session.next_look());
        }
    }

    fn look(&mut self) -> Result<InWord, MasterError> {
        let mut input = self.look_once()?;
        // An encoder keeps its error bit; what has it once may be a word that the gateway has spoilt.
        for _ in 1..STRANGE {
            if !input.error_bit() {
                break;
            }
            self.rest(self.timing.next_look(LookFor::Recovery));
            input = self.look_once()?;
        }
        Ok(input)
    }

    fn now(&self) -> Instant {
        self.bus.now()
    }

    fn wait(&mut self, span: Duration) {
        self.bus.wait(span);
    }
}
