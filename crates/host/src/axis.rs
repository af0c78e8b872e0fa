//! One encoder, as the program of a controller sees it: called once a cycle, it gives a judged position and carries
//! services out meanwhile.
//!
//! An [`JudgedAxis`] joins a [`Session`] and a [`Validity`]. In each cycle of the controller read IN, call [`JudgedAxis::cycle`], and
//! write the OUT word that it gives:
//!
//! ```
//! use encoring_host::axis::JudgedAxis;
//! use encoring_host::validity::{Expectation, Limits, Position};
//! use encoring_host::{Request, Seen, Timing};
//! use encoring_words::model::Sensor;
//! use encoring_words::{Duration, InWord, Instant, Model, OutWord, ParameterSet};
//!
//! let sensor = Sensor::Rotary { steps_per_turn: 4096 };
//! let expectation = Expectation::new(Model::Ce65M, sensor, &ParameterSet::factory(Model::Ce65M, sensor))?;
//! let limits = Limits::of(Model::Ce65M, Duration::from_millis(1));
//! let mut axis = JudgedAxis::new(Timing::DIRECT, OutWord(0), expectation, limits);
//!
//! let seen = Seen { input: InWord(0x0000_270F), age: Duration::ZERO };
//! let cycle = axis.cycle(Instant(0), Some(seen), &mut |stop| panic!("stop the machine: {stop:?}"));
//! assert_eq!((cycle.position, cycle.out), (Position::Valid(9999), OutWord(0)));
//!
//! axis.start(Instant(1_000_000), Request::preset(Model::Ce65M, 0, 9999)?)?;
//! assert_eq!(axis.out(), OutWord(0x4600_0000)); // number and data first; the service bit follows
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use encoring_words::{Instant, OutWord};

use crate::request::Request;
use crate::seen::Seen;
use crate::session::{Busy, Outcome, Session, SessionPhase, Timing};
use crate::validity::{Expectation, Limits, Position, Stop, Validity};

/// An encoder that is judged in every cycle of a controller, and served when it asks for that.
#[derive(Clone, Debug)]
pub struct JudgedAxis {
    session: Session,
    validity: Validity,
    /// What counts once the service under way is done.
    becomes: Option<Expectation>,
}

/// What a cycle came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisCycle {
    /// What OUT shall be until the next cycle.
    pub out: OutWord,
    /// The position, judged.
    pub position: Position,
    /// How the service ended, in the cycle in which it does.
    pub outcome: Option<Outcome>,
}

impl JudgedAxis {
    /// For an encoder of which nothing has been seen yet. `standing` is what its OUT word holds.
    #[must_use]
    pub fn new(timing: Timing, standing: OutWord, expectation: Expectation, limits: Limits) -> Self {
        let session = Session::new(timing, standing);
        Self { session, validity: Validity::new(expectation, limits), becomes: None }
    }

    /// Starts a service at `now`. From the next cycle on the position is [`Position::InService`] while IN is its reply.
    ///
    /// A preset adjustment moves the zero: while it is out, no position is compared with the one before it.
    ///
    /// # Errors
    /// [`Busy`] if another one is under way.
    pub fn start(&mut self, now: Instant, request: Request) -> Result<(), Busy> {
        self.session.start(now, request)?;
        self.becomes = None;
        Ok(())
    }

    /// Starts the data check that makes programmed values count [R83]. If it finds no error, the positions from then on
    /// are judged by `becomes`; if it is not known whether it was done, they are judged as before, until
    /// [`JudgedAxis::expect`].
    ///
    /// # Errors
    /// [`Busy`] if a service is under way.
    pub fn start_check(&mut self, now: Instant, becomes: Expectation) -> Result<(), Busy> {
        self.start(now, Request::data_check())?;
        self.becomes = Some(becomes);
        Ok(())
    }

    /// One cycle: `seen` is what the bus brought with the OUT word of before, `None` if it brought nothing. `stop` is called
    /// as [`Validity::judge`] says: let it stop the machine.
    pub fn cycle(&mut self, now: Instant, seen: Option<Seen>, stop: &mut impl FnMut(Stop)) -> AxisCycle {
        let moves_the_zero = self.moves_the_zero();
        let (out, outcome) = self.session.cycle(now, seen);
        if moves_the_zero {
            self.validity.rebase();
        }
        if let Some(outcome) = outcome {
            self.ended(outcome);
        }
        AxisCycle { out, position: self.validity.judge(now, seen, stop), outcome }
    }

    /// What OUT shall be until the next cycle.
    #[must_use]
    pub const fn out(&self) -> OutWord {
        self.session.out()
    }

    /// `true` while no service is under way.
    #[must_use]
    pub const fn is_resting(&self) -> bool {
        self.session.is_resting()
    }

    /// Gives the service up that is under way; its outcome comes from [`JudgedAxis::cycle`]. `false` if there is nothing to give
    /// up.
    pub fn give_up(&mut self, now: Instant) -> bool {
        self.session.give_up(now)
    }

    /// Takes the next position as it comes: somebody has found out why it jumped, or a preset input has acted.
    pub fn rebase(&mut self) {
        self.validity.rebase();
    }

    /// Other values have become active; also a rebase.
    pub fn expect(&mut self, expectation: Expectation) {
        self.validity.expect(expectation);
    }

    /// Whether a request is out that moves the zero.
    const fn moves_the_zero(&self) -> bool {
        match self.session.phase() {
            SessionPhase::Requesting { request, .. }
            | SessionPhase::Ending { request, .. }
            | SessionPhase::Clearing { request, .. } => request.moves_the_zero(),
            SessionPhase::Resting | SessionPhase::Preparing(_) => false,
        }
    }

    fn ended(&mut self, outcome: Outcome) {
        let becomes = self.becomes.take();
        if let (Some(becomes), Outcome::Done { reply, .. }) = (becomes, outcome)
            && !reply.error
        {
            self.validity.expect(becomes);
        }
    }
}
