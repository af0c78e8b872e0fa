//! Services as a user means them: read a value, run the data check, and understand a refusal.
//!
//! Everything here is straight-line code over [`Services`], whoever carries a single service out: a controller's
//! cycle, a bus client, a test.

use encoring_words::{Duration, ErrorStatus, InWord, Instant, Model, Parameter};

use crate::request::{Reply, Request, RequestError};
use crate::session::{Fate, GivenUp, Outcome, TimedOut};

/// Carries services out, one at a time, with a [`crate::Session`].
pub trait Services {
    /// Why the encoder cannot be reached.
    type Error;

    /// Carries a service out to its end.
    ///
    /// # Errors
    /// If it cannot even be begun: then nothing was sent.
    fn serve(&mut self, request: Request) -> Result<Outcome, Self::Error>;

    /// What IN shows now, in normal mode.
    ///
    /// # Errors
    /// If the encoder cannot be reached.
    fn look(&mut self) -> Result<InWord, Self::Error>;

    /// The time now.
    fn now(&self) -> Instant;

    /// Lets time pass without touching the encoder.
    fn wait(&mut self, span: Duration);
}

/// Why a service failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure<E> {
    /// It was never sent, because the encoder would refuse it.
    Request(RequestError),
    /// The encoder refused it.
    Refused(Refusal),
    /// The encoder did not answer in time.
    TimedOut {
        /// What was asked.
        request: Request,
        /// What was waited for, and what is known.
        timed_out: TimedOut,
    },
    /// It was given up on demand.
    GivenUp {
        /// What was asked.
        request: Request,
        /// What is known.
        given_up: GivenUp,
    },
    /// The encoder cannot be reached; nothing was sent.
    Bus(E),
    /// An error is pending, so that the encoder could not report one of this service; nothing was sent.
    ErrorPending {
        /// What IN showed.
        shown: InWord,
    },
    /// The position is one that the programmed values do not allow: it is computed with others, until a data check or a
    /// power-up makes these count [R79, R80]; nothing was sent.
    NotActive {
        /// The position, in steps.
        position: u32,
        /// The largest that the programmed values allow.
        largest: u32,
    },
    /// A parameter reads as 0 while an error is pending, and so does a record that cannot be read.
    Unreadable {
        /// Which.
        parameter: Parameter,
    },
}

impl<E> Failure<E> {
    /// `true` if the request was never sent.
    #[must_use]
    pub const fn is_not_sent(&self) -> bool {
        match self {
            Self::Request(_) | Self::Bus(_) | Self::ErrorPending { .. } | Self::NotActive { .. } => true,
            Self::TimedOut { timed_out: TimedOut { fate, .. }, .. }
            | Self::GivenUp { given_up: GivenUp { fate, .. }, .. } => matches!(fate, Fate::NotSent),
            Self::Refused(_) | Self::Unreadable { .. } => false,
        }
    }
}

/// A service that the encoder answered with the error bit, and what the data check said if one was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What was asked.
    pub request: Request,
    /// The data check that followed. A read and a preset adjustment are followed by none: it makes values count that
    /// were programmed and never checked, and nobody asked for that.
    pub check: Option<Check>,
    /// The service was repeated and failed again: the manual then wants the encoder replaced [R154].
    pub repeated: bool,
}

/// What a data check returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Check {
    /// The error status. Always empty on an LA-66, but for the magnet [R95].
    pub status: ErrorStatus,
    /// Bit 29 of the reply: the error remains until it is corrected [C23].
    pub remains: bool,
}

impl Check {
    /// `true` if there is and was no error.
    #[must_use]
    pub const fn is_good(self) -> bool {
        self.status.is_empty() && !self.remains
    }
}

/// A value that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadValue {
    /// Bits 23..0: what is programmed, which need not be what the position is computed with [C7].
    pub value: u32,
    /// An error was pending before, so this service could not report one of its own: a record of the EEPROM that
    /// cannot be read would show as 0.
    pub error_before: bool,
}

impl ReadValue {
    /// The value, unless it could be the 0 of a record that cannot be read.
    #[must_use]
    pub const fn sure(self) -> Option<u32> {
        if self.error_before && self.value == 0 { None } else { Some(self.value) }
    }
}

/// Carries `request` out, and makes a failure of every end but an answer.
pub(crate) fn answer<S: Services>(
    services: &mut S,
    request: Request,
) -> Result<(Reply, bool), Failure<S::Error>> {
    match services.serve(request).map_err(Failure::Bus)? {
        Outcome::Done { reply, error_before } => Ok((reply, error_before)),
        Outcome::TimedOut(timed_out) => Err(Failure::TimedOut { request, timed_out }),
        Outcome::GivenUp(given_up) => Err(Failure::GivenUp { request, given_up }),
    }
}

/// Runs the data check: it returns the error status, ends errors that are over, and makes programmed values count
/// [R79, R83].
///
/// # Errors
/// [`Failure`].
pub fn check<S: Services>(services: &mut S) -> Result<Check, Failure<S::Error>> {
    let (reply, _) = answer(services, Request::data_check())?;
    Ok(Check { status: ErrorStatus::from_bits_retain(reply.data as u16), remains: reply.error })
}

/// Writes a parameter. If the encoder refuses it, the data check is run; an EEPROM fault is worth one more try [R154].
pub(crate) fn write<S: Services>(services: &mut S, request: Request) -> Result<(), Failure<S::Error>> {
    let eeprom = ErrorStatus::READING_DATA | ErrorStatus::WRITING_DATA;
    let mut repeated = false;
    loop {
        let (reply, error_before) = answer(services, request)?;
        // At the second try the error of the first may still be pending.
        if !reply.error || (error_before && !repeated) {
            return Ok(());
        }
        let check = check(services)?;
        let fault = check.status.intersects(eeprom);
        if repeated && !fault {
            return Ok(());
        }
        if repeated || !fault {
            return Err(Failure::Refused(Refusal { request, check: Some(check), repeated }));
        }
        repeated = true;
    }
}

/// Reads a parameter, and does nothing else: a refused read is tried once more [R154], and no data check is run.
///
/// # Errors
/// [`Failure`].
pub fn read<S: Services>(
    services: &mut S,
    model: Model,
    parameter: Parameter,
) -> Result<ReadValue, Failure<S::Error>> {
    let request = Request::read(model, parameter).map_err(Failure::Request)?;
    let (reply, error_before) = answer(services, request)?;
    if error_before || !reply.error {
        return Ok(ReadValue { value: reply.data, error_before });
    }
    // From here on its own error is pending, so only the data can tell whether the second try was better.
    match answer(services, request)? {
        (Reply { data: 0, .. }, _) => Err(Failure::Refused(Refusal { request, check: None, repeated: true })),
        (Reply { data, .. }, _) => Ok(ReadValue { value: data, error_before: true }),
    }
}

/// Reads a parameter whose value must be known for certain.
///
/// # Errors
/// [`Failure`]; [`Failure::Unreadable`] if the 0 that was read may be a record that cannot be read.
pub fn read_surely<S: Services>(
    services: &mut S,
    model: Model,
    parameter: Parameter,
) -> Result<u32, Failure<S::Error>> {
    read(services, model, parameter)?.sure().ok_or(Failure::Unreadable { parameter })
}
