//! A ring as its master reaches it, whatever stands between: [`Bus`].
//!
//! A simulated ring is one, a Modbus gateway in front of a real ring another. Whoever programs encoders knows only
//! this trait.

use std::error::Error;
use std::fmt;
use std::io;
use std::sync::Arc;

use encoring_ring::diagnostics::Diagnosis;
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::misread::Misread;

/// A ring on which words can be read and written. Positions are ring positions from 0.
///
/// Calls block until they are done or have failed, never for longer than the bus's own time-out says. An error ends
/// the call, not the bus: the next call tries again.
pub trait Bus {
    /// The time, since an origin of the bus's own.
    fn now(&self) -> Instant;

    /// The OUT word of the encoder at `position` as the bus holds it, whoever wrote it.
    ///
    /// # Errors
    /// [`BusError`].
    fn out(&mut self, position: usize) -> Result<OutWord, BusError>;

    /// Writes an OUT word, if one is given, and then reads the IN words of the encoders from `first` on, as many as
    /// `input` has places. Both halves of the OUT word go out together, and no other encoder's OUT word is touched.
    ///
    /// The IN words need not be an answer to the OUT word yet: see [`Bus::settling`].
    ///
    /// # Errors
    /// [`BusError`]; the OUT word may then have arrived all the same.
    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError>;

    /// Lets time pass in which nothing is read or written; returns early if the bus has something to do.
    fn wait(&mut self, span: Duration);

    /// What has to pass before words written separately are sure to stand on the ring together.
    fn settling(&self) -> Settling;

    /// What to change in the bus's address so that words are read in another way; `None` if nothing does that.
    fn cure(&self, misread: Misread) -> Option<String> {
        let _ = misread;
        None
    }

    /// The same for words that are written.
    fn cure_of_writes(&self, misread: Misread) -> Option<String> {
        let _ = misread;
        None
    }

    /// What the ring's master says of it now, as far as this bus shows that. Its status tells of every word that is read
    /// afterwards that it came from a ring that ran.
    ///
    /// # Errors
    /// [`BusError`]: the bus shows it, and it could not be read.
    fn diagnosis(&mut self) -> Result<Diagnosis, BusError> {
        Ok(Diagnosis::default())
    }

    /// What may be wrong with a peer that was there and has never answered, or whose answers come too late for the bus's
    /// time-out, and what to change; `None` if there is nothing to say.
    fn advice(&self) -> Option<String> {
        None
    }

    /// Hands out what happened to the link since the last call; `None` once everything was told.
    fn link_event(&mut self) -> Option<LinkEvent> {
        None
    }
}

/// What a call of [`Bus::cycle`] came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cycle {
    /// When the IN words were there.
    pub at: Instant,
    /// How long before that they may have left the ring, as far as the bus can tell.
    pub age: Duration,
}

/// At least one cycle of the ring and one scan of whatever stands before it [R34]. Two polls of a gateway can fall
/// into one cycle of the ring, so both limits must be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settling {
    /// Calls of [`Bus::cycle`].
    pub cycles: u32,
    /// Time.
    pub time: Duration,
}

/// Why a ring could not be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// The caller asked for an encoder that the ring does not have.
    #[error("no encoder at position {position}: the ring has {encoders}, counted from 0")]
    NoEncoder {
        /// The position that was asked for.
        position: usize,
        /// How many there are.
        encoders: usize,
    },
    /// The caller asked for an encoder that the peer does not show; its ring may have it.
    #[error(
        "no encoder at position {position}: the gateway shows {encoders}, counted from 0. If the ring has more, they begin \
         elsewhere: in=input:N (or holding:N) and out=holding:N in the address say where, and `encoring probe` looks for it"
    )]
    NotShown {
        /// The position that was asked for.
        position: usize,
        /// How many it shows.
        encoders: usize,
    },
    /// There is no connection.
    #[error("no connection: {0}")]
    NoConnection(Cause),
    /// The peer did not answer in time.
    #[error("no answer within {within}")]
    NoAnswer {
        /// The bus's time-out.
        within: Duration,
    },
    /// The peer describes a ring on which the encoder cannot be found.
    #[error(
        "the module at position {position} has ident code {ident} and {words} words, an encoder has 51 and 2"
    )]
    NotAnEncoder {
        /// The position that was asked for.
        position: usize,
        /// Ident code of the module there.
        ident: u8,
        /// Its length in words.
        words: u8,
    },
    /// What only the client's protocol knows.
    #[error(transparent)]
    Client(#[from] ClientError),
}

/// An answer that brings no words, as the client of a protocol tells it.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{error}")]
pub struct ClientError {
    answered: Answered,
    error: Arc<dyn Error + Send + Sync>,
}

/// What kind of answer it is: the client decides it, as only it knows its protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answered {
    /// The peer has understood, and refuses. It will refuse the same again.
    Refused,
    /// The peer has understood, and cannot now. It may be able to later.
    Busy,
    /// The peer has understood, and confirms another write than it was asked for.
    Misdirected,
    /// What came is no answer to the request. The next may be.
    Garbled,
}

impl BusError {
    /// Whether the peer has answered, and so.
    #[must_use]
    pub fn is_answered(&self, so: Answered) -> bool {
        matches!(self, Self::Client(client) if client.answered() == so)
    }

    /// Whether an encoder was asked for that is not there.
    #[must_use]
    pub const fn is_no_encoder(&self) -> bool {
        matches!(self, Self::NoEncoder { .. } | Self::NotShown { .. })
    }

    /// What a client of a protocol met, and what it means for whoever asked.
    pub fn client(answered: Answered, error: impl Error + Send + Sync + 'static) -> Self {
        Self::Client(ClientError { answered, error: Arc::new(error) })
    }
}

impl ClientError {
    /// What kind of answer it is.
    #[must_use]
    pub const fn answered(&self) -> Answered {
        self.answered
    }

    /// The client's own error, for whoever knows that client.
    #[must_use]
    pub fn error(&self) -> &(dyn Error + Send + Sync + 'static) {
        self.error.as_ref()
    }
}

/// Two of them are the same if they say the same.
impl PartialEq for ClientError {
    fn eq(&self, other: &Self) -> bool {
        self.answered == other.answered && self.error.to_string() == other.error.to_string()
    }
}

impl Eq for ClientError {}

/// Why there is no connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The operating system says so.
    System(io::ErrorKind),
    /// The last attempt failed not long ago, and the next is not due yet.
    Waiting {
        /// What the last attempt met.
        last: io::ErrorKind,
        /// Until the next.
        next: Duration,
    },
}

impl BusError {
    /// The same for whoever has said already that the connection is gone.
    #[must_use]
    pub fn reason(&self) -> String {
        match self {
            Self::NoConnection(cause) => cause.to_string(),
            error => error.to_string(),
        }
    }
}

/// Something that happened to a bus's link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkEvent {
    /// When.
    pub at: Instant,
    /// What.
    pub what: Link,
}

/// What can happen to a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// It is there.
    Up {
        /// How long it was not; zero the first time.
        down_for: Duration,
    },
    /// It is gone.
    Down {
        /// How long it was there.
        up_for: Duration,
        /// Why.
        cause: BusError,
    },
    /// It could not be made.
    Failed {
        /// Why.
        cause: io::ErrorKind,
        /// Until the next attempt.
        next: Duration,
    },
}

impl Link {
    /// `true` for what somebody should know of: anything but the first connection.
    #[must_use]
    pub fn is_trouble(&self) -> bool {
        !matches!(self, Self::Up { down_for: Duration::ZERO })
    }
}

/// What a system's error means on a plant's network.
const fn plain(kind: io::ErrorKind) -> &'static str {
    match kind {
        io::ErrorKind::ConnectionRefused => "connection refused: nothing listens at that port",
        io::ErrorKind::ConnectionReset | io::ErrorKind::ConnectionAborted | io::ErrorKind::BrokenPipe => {
            "the other side has closed the connection"
        }
        io::ErrorKind::UnexpectedEof => "the other side has closed the connection in the middle of an answer",
        io::ErrorKind::TimedOut => "nobody answers at that address",
        io::ErrorKind::HostUnreachable | io::ErrorKind::NetworkUnreachable => {
            "there is no way to that address"
        }
        io::ErrorKind::PermissionDenied => "this user may not open it",
        io::ErrorKind::NotFound => "there is no such device, or another program has it open",
        io::ErrorKind::NotConnected => "it was not made",
        io::ErrorKind::InvalidData => "what answers there is no gateway",
        io::ErrorKind::InvalidInput => "the device does not know these settings",
        io::ErrorKind::Unsupported => "it is no serial line",
        _ => "the name is not known, or there is no way to it",
    }
}

impl Cause {
    /// The same without the time until the next attempt.
    #[must_use]
    pub const fn settled(self) -> Self {
        match self {
            Self::System(kind) | Self::Waiting { last: kind, .. } => Self::System(kind),
        }
    }
}

/// A time as people say it: below a second in whole milliseconds, else in tenths of seconds.
pub(crate) fn rounded(span: Duration) -> Duration {
    let unit = if span < Duration::from_millis(1_000) { 1_000_000 } else { 100_000_000 };
    Duration::from_nanos((span.as_nanos() / unit).max(1) * unit)
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(kind) => f.write_str(plain(*kind)),
            Self::Waiting { last, next } => {
                write!(f, "{}; the next attempt is in {}", plain(*last), rounded(*next))
            }
        }
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Up { down_for: Duration::ZERO } => f.write_str("connected"),
            Self::Up { down_for } => write!(f, "connected again after {}", rounded(*down_for)),
            Self::Down { up_for, cause } => {
                write!(f, "connection lost after {}: {}", rounded(*up_for), cause.reason())
            }
            Self::Failed { cause, next } => {
                write!(f, "no connection: {}; next attempt in {}", plain(*cause), rounded(*next))
            }
        }
    }
}
