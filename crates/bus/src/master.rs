//! One encoder on a bus, and the master that carries its services out.

#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use encoring_host::{LookFor, NextLook, Outcome, Request, Seen, Services, Session, SessionPhase, Timing};
use encoring_words::word::Out;
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::bus::{Answered, Bus, BusError, Cause, rounded};
use crate::misread::{Misread, can_be_sent, turned};

/// So many words in a row that no encoder sends are not torn: the gateway makes them so.
const STRANGE: u32 = 3;

/// Why a service was not even begun.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MasterError {
    /// The bus cannot be read or written.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Another master's service is under way: its service bit is set [R30].
    #[error(
        "OUT holds {out}: another master's service is under way, or was left there; this request was not sent"
    )]
    OtherMaster {
        /// The OUT word that stands on the bus.
        out: OutWord,
    },
    /// Somebody else writes the OUT word.
    #[error(
        "OUT holds {out} instead of the {ours} written here: another master writes it; this request was not sent"
    )]
    Overwritten {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
    /// The encoder shows a reply that nobody here asked for.
    #[error("IN holds {input}: a service that was not asked for here is not ended; no position can be seen")]
    InService {
        /// The IN word.
        input: InWord,
    },
    /// IN shows what no encoder sends.
    #[error("IN holds {input}, which no encoder sends{}", .cure)]
    Misread {
        /// The IN word.
        input: InWord,
        /// How it is an encoder's, and what to change, if that can be told.
        cure: Cure,
    },
    /// The IN words do not come from the ring any more.
    #[error(
        "the IN word is {} old: the ring has stopped, or the encoder is not on it. Look at the lamps of master and \
         encoder, and at `encoring scan`", rounded(*.age)
    )]
    Stale {
        /// Its age.
        age: Duration,
    },
    /// The user wants to stop.
    #[error("interrupted")]
    Interrupted,
}

/// What may be behind a time-out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Behind {
    /// The last trouble with the bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// OUT was looked at when the time was over, and the gateway had not let the word through as it was.
    #[error(
        "OUT holds {out} instead of the {ours} written here: the gateway turns written words round, {} \
         (`order_out` in its address is for halves), and `encoring probe` looks for it", .way.name()
    )]
    Turned {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
        /// How the one is the other.
        way: Misread,
    },
    /// OUT was looked at when the time was over, and nothing stood there.
    #[error(
        "OUT holds {out} instead of the {ours} written here: the gateway has let its outputs fall, does not write what \
         it acknowledges, or shows other registers; `encoring probe` looks for them"
    )]
    NotThere {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
    /// OUT was looked at when the time was over, and another master had written it.
    #[error("OUT holds {out} instead of the {ours} written here: another master writes it")]
    OtherMaster {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
}

/// How a word that no encoder sends is one's, and what to change.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cure(String);

impl Cure {
    /// For a word on a bus.
    pub fn of<B: Bus + ?Sized>(bus: &B, input: InWord) -> Self {
        let Some(misread) = Misread::of(input) else { return Self::default() };
        Self::by(bus, misread, format_args!("{}, a position", misread.read(input)))
    }

    /// For a word that is this if it is read so.
    pub fn by<B: Bus + ?Sized>(bus: &B, misread: Misread, is: impl std::fmt::Display) -> Self {
        let read = format!("; with {} it is {is}", misread.name());
        Self(match bus.cure(misread) {
            Some(cure) => format!("{read}. What cures it: {cure}"),
            None => read,
        })
    }
}

impl std::fmt::Display for Cure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

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
        match turned(ours, out) {
            Some(way) => Some(Behind::Turned { out, ours, way }),
            None if out == OutWord(0) => Some(Behind::NotThere { out, ours }),
            // The gateway carries a word of ours out late.
            None if self.is_unanswered(out) => None,
            None => Some(Behind::OtherMaster { out, ours }),
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
            if !patient || matches!(problem, MasterError::Bus(BusError::NoEncoder { .. })) {
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
                let [input] = input;
                Some(Seen { input, age: cycle.age })
            }
            Err(error) => {
                if write.is_some() && matches!(error, BusError::NoAnswer { .. }) {
                    self.unanswered.retain(|(word, _)| *word != out);
                    self.unanswered.push((out, self.bus.now()));
                }
                self.met(error);
                if write.is_some() {
                    self.written = None;
                }
                None
            }
        }
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
        self.alone()?;
        if self.written.is_none() {
            self.readable()?;
        }
        // Every service is driven to its end below, so none is under way here.
        let mut out = self.session.start(self.bus.now(), request).unwrap_or(request.rest());
        let mut strange = 0_u32;
        loop {
            let phase = self.session.phase();
            let seen = self.poll(out);
            if let Some(observe) = &mut self.observe {
                observe(&Look { at: self.bus.now(), phase, out, input: seen.map(|seen| seen.input) });
            }
            if self.interrupted() && !self.session.give_up(self.bus.now()) {
                self.stop_next = true;
            }
            strange = match seen {
                Some(Seen { input, .. }) if !can_be_sent(input) => strange + 1,
                _ => 0,
            };
            if let (SessionPhase::Preparing(_), Some(Seen { input, .. }), STRANGE..) = (phase, seen, strange)
            {
                self.session.abandon();
                return Err(MasterError::Misread { input, cure: Cure::of(self.bus, input) });
            }
            let (next, outcome) = self.session.cycle(self.bus.now(), seen);
            out = next;
            if let Some(outcome) = outcome {
                if matches!(outcome, Outcome::TimedOut(_)) {
                    self.not_ours = self.not_ours_now();
                }
                return Ok(outcome);
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
