//! One encoder on a bus, and the master that carries its services out.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use encoring_host::{LookFor, NextLook, Outcome, Request, Seen, Services, Session, SessionPhase, Timing};
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::bus::{Bus, BusError};

/// Why a service was not even begun.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MasterError {
    /// The bus cannot be read or written.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Another master's service is under way: its service bit is set [R30].
    #[error(
        "OUT holds {out}: another master's service is under way, or was left there; this request was not sent. Stop \
         the other master, or clear its service bit"
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
    /// The IN words do not come from the ring any more.
    #[error("the IN word is {age} old: the ring has stopped, or the encoder is not on it")]
    Stale {
        /// Its age.
        age: Duration,
    },
    /// The user wants to stop.
    #[error("interrupted")]
    Interrupted,
}

/// What a master tells of its work.
pub type Observe<'a> = Box<dyn FnMut(&Look) + 'a>;

/// One poll of a service under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// The phase of the handshake.
    pub phase: SessionPhase,
    /// The OUT word that was to be written.
    pub out: OutWord,
    /// The IN word that was seen, if one was.
    pub input: Option<InWord>,
}

/// Carries services out on one encoder of a bus. It reads before it writes, and writes only what it has to.
pub struct EncoderMaster<'a, B: ?Sized> {
    bus: &'a mut B,
    position: usize,
    session: Session,
    timing: Timing,
    /// What is known to stand on OUT because it was written here.
    written: Option<OutWord>,
    /// The last two words that were to be written.
    tried: [OutWord; 2],
    stop: Arc<AtomicBool>,
    /// It was set when nothing could be given up any more.
    stop_next: bool,
    last_error: Option<BusError>,
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
        let standing = bus.out(position)?;
        if standing.service_bit() {
            return Err(MasterError::OtherMaster { out: standing });
        }
        let settling = bus.settling();
        let timing =
            Timing { settle_polls: settling.cycles, settle: settling.time, patience, ..Timing::DIRECT };
        let session = Session::new(timing, standing);
        Ok(Self {
            bus,
            position,
            session,
            timing,
            written: None,
            tried: [OutWord(0); 2],
            stop,
            stop_next: false,
            last_error: None,
            observe: None,
        })
    }

    /// Tells `observe` every poll of every service.
    pub fn observe(&mut self, observe: impl FnMut(&Look) + 'a) {
        self.observe = Some(Box::new(observe));
    }

    /// The last trouble with the bus: what may be behind a time-out.
    #[must_use]
    pub const fn last_error(&self) -> Option<&BusError> {
        self.last_error.as_ref()
    }

    /// The bus.
    pub const fn bus(&mut self) -> &mut B {
        self.bus
    }

    fn interrupted(&mut self) -> bool {
        self.stop.swap(false, Ordering::Relaxed) | std::mem::take(&mut self.stop_next)
    }

    /// Refuses to work while somebody else does.
    fn alone(&mut self) -> Result<(), MasterError> {
        let out = self.patiently(|bus, position, _| Ok(bus.out(position)?))?;
        match self.written {
            // A gateway may have let its outputs fall.
            Some(ours) if out != ours && out != OutWord(0) => Err(MasterError::Overwritten { out, ours }),
            // After a failed write either of the last two words may stand there.
            None if out.service_bit() && !self.tried.contains(&out) => Err(MasterError::OtherMaster { out }),
            _ => Ok(()),
        }
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
            if let MasterError::Bus(error) = &problem {
                self.last_error = Some(error.clone());
            }
            asked += 1;
            let patient = self.bus.now().since(since) < patience || asked < self.timing.patience_polls;
            if !patient || matches!(problem, MasterError::Bus(BusError::NoEncoder { .. })) {
                return Err(problem);
            }
            if self.interrupted() {
                return Err(MasterError::Interrupted);
            }
            self.rest(self.timing.next_look(LookFor::Recovery));
        }
    }

    /// `true` if the service bit may stand on the bus although no service is under way: the word that takes it back
    /// could not be written.
    #[must_use]
    pub fn may_have_left_the_service_bit(&self) -> bool {
        self.written.is_none() && self.tried.iter().any(|out| out.service_bit())
    }

    /// Leaves a gateway in peace until the next look.
    fn rest(&mut self, next: NextLook) {
        if next.within > Duration::ZERO {
            self.bus.wait(next.within);
        }
    }

    /// One poll: writes `out` unless it stands there already.
    fn poll(&mut self, out: OutWord) -> Option<Seen> {
        let write = (self.written != Some(out)).then_some((self.position, out));
        if write.is_some() {
            let [_, last] = self.tried;
            self.tried = [last, out];
        }
        let mut input = [InWord(0)];
        match self.bus.cycle(write, self.position, &mut input) {
            Ok(cycle) => {
                self.written = Some(out);
                let [input] = input;
                Some(Seen { input, age: cycle.age })
            }
            Err(error) => {
                self.last_error = Some(error);
                if write.is_some() {
                    self.written = None;
                }
                None
            }
        }
    }
}

impl<B: Bus + ?Sized> Services for EncoderMaster<'_, B> {
    type Error = MasterError;

    fn serve(&mut self, request: Request) -> Result<Outcome, MasterError> {
        if self.interrupted() {
            return Err(MasterError::Interrupted);
        }
        self.last_error = None;
        self.alone()?;
        // Every service is driven to its end below, so none is under way here.
        let mut out = self.session.start(self.bus.now(), request).unwrap_or(request.rest());
        loop {
            let phase = self.session.phase();
            let seen = self.poll(out);
            if let Some(observe) = &mut self.observe {
                observe(&Look { phase, out, input: seen.map(|seen| seen.input) });
            }
            if self.interrupted() && !self.session.give_up(self.bus.now()) {
                self.stop_next = true;
            }
            let (next, outcome) = self.session.cycle(self.bus.now(), seen);
            out = next;
            if let Some(outcome) = outcome {
                return Ok(outcome);
            }
            self.rest(self.session.next_look());
        }
    }

    fn look(&mut self) -> Result<InWord, MasterError> {
        self.patiently(|bus, position, patience| {
            let mut input = [InWord(0)];
            let cycle = bus.cycle(None, position, &mut input)?;
            let [input] = input;
            if cycle.age >= patience {
                return Err(MasterError::Stale { age: cycle.age });
            }
            if input.service_bit() { Err(MasterError::InService { input }) } else { Ok(input) }
        })
    }

    fn now(&self) -> Instant {
        self.bus.now()
    }

    fn wait(&mut self, span: Duration) {
        self.bus.wait(span);
    }
}
