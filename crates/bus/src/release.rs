//! Takes a service bit back that somebody left on OUT, so that the encoder shows its position again.
//!
//! Whoever did it may only be slow: a controller that still works with the encoder must not have its service withdrawn. So
//! OUT and the upper byte of IN are watched for a time first, and OUT is read again just before it is written.

use std::sync::atomic::{AtomicBool, Ordering};

use encoring_words::word::Out;
use encoring_words::{Duration, InWord, OutWord};

use crate::bus::{Bus, BusError, rounded};
use crate::master::Cure;
use crate::misread::{Misread, can_be_sent, turned};

/// For so long nothing may change before a service bit counts as left.
pub const STANDS_FOR: Duration = Duration::from_millis(2_000);

/// So many looks in a row must show the same before anything is said of it: a gateway may spoil a word now and then.
const ALIKE: u32 = 3;

/// So often a word that was spoilt begins the watch anew.
const SPOILT_MAX: u32 = 3;

/// The error bit in the upper byte of IN.
const ERROR_BIT: u32 = 0x20;

/// Between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Both words of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// OUT.
    pub out: OutWord,
    /// IN.
    pub input: InWord,
}

impl Standing {
    /// What both masters would change: all of OUT, and of IN what tells a reply.
    const fn same(self, other: Self) -> bool {
        self.out.0 == other.out.0 && self.input.0 >> 24 == other.input.0 >> 24
    }
}

/// Why a service bit was not taken back.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReleaseError {
    /// The bus cannot be read or written.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// A master is at work.
    #[error(
        "OUT was {} and IN {}, now OUT is {} and IN {}: a master works with this encoder, or the gateway \
         spoils words", .was.out, .was.input, .now.out, .now.input
    )]
    InUse {
        /// What stood there first.
        was: Standing,
        /// What stands there now.
        now: Standing,
    },
    /// IN shows what no encoder sends, so OUT is not read as it is either.
    #[error("OUT holds {} and IN {}, which is no encoder's{cure}", .now.out, .now.input)]
    Misread {
        /// What stands there, as it is read.
        now: Standing,
        /// How it is an encoder's, and what to change, if that can be told.
        cure: Cure,
    },
    /// The word without the service bit was written, and OUT still has it.
    #[error(
        "OUT still holds {out} after {}: another master writes it, or the gateway does not let it be written",
        rounded(*.within)
    )]
    Stays {
        /// OUT.
        out: OutWord,
        /// How long that was tried.
        within: Duration,
    },
    /// The user wants to stop.
    #[error("interrupted")]
    Interrupted,
}

/// A service bit on one encoder's OUT, and how it is taken back.
#[derive(Debug)]
pub struct Release<'a, B: ?Sized> {
    bus: &'a mut B,
    position: usize,
    patience: Duration,
    stop: &'a AtomicBool,
    /// So many words were spoilt so far.
    spoilt: u32,
}

impl<'a, B: Bus + ?Sized> Release<'a, B> {
    /// For the encoder at `position`. A bus that cannot be read is asked again until `patience` is over.
    pub const fn new(bus: &'a mut B, position: usize, patience: Duration, stop: &'a AtomicBool) -> Self {
        Self { bus, position, patience, stop, spoilt: 0 }
    }

    /// Both words as they stand, seen several times alike. Writes nothing.
    ///
    /// # Errors
    /// [`ReleaseError::Bus`], [`ReleaseError::Interrupted`]; [`ReleaseError::InUse`] if they do not stand,
    /// [`ReleaseError::Misread`] if IN is nobody's.
    pub fn look(&mut self) -> Result<Standing, ReleaseError> {
        let since = self.bus.now();
        let (mut was, mut alike, mut unlike, mut strange) = (self.patiently()?, 1, 0, 0);
        loop {
            self.bus.wait(LOOK_EVERY);
            let now = self.patiently()?;
            strange = if self.is_misread(now) { strange + 1 } else { 0 };
            (alike, unlike) = if was.same(now) { (alike + 1, unlike) } else { (1, unlike + 1) };
            match (alike, strange) {
                (_, ALIKE..) => return Err(ReleaseError::Misread { now, cure: self.cure(now) }),
                (ALIKE.., 0) => return Ok(now),
                // A slow bus is not another master: that one has changed the words several times by now.
                _ if unlike >= ALIKE && self.bus.now().since(since) >= self.patience => {
                    return Err(ReleaseError::InUse { was, now });
                }
                _ => was = now,
            }
        }
    }

    /// Whether the words are not as the encoder and its master have them.
    fn is_misread(&self, now: Standing) -> bool {
        !can_be_sent(now.input) || turned_round(now).is_some()
    }

    fn cure(&self, now: Standing) -> Cure {
        match turned_round(now) {
            Some(way) => Cure::by(
                self.bus,
                way,
                format_args!("{}, the reply to {}", way.read(now.input), way.read(InWord(now.out.0))),
            ),
            None => Cure::of(self.bus, now.input),
        }
    }

    /// One look, however often it takes.
    fn patiently(&mut self) -> Result<Standing, ReleaseError> {
        let since = self.bus.now();
        loop {
            let problem = match self.both() {
                Ok(standing) => return Ok(standing),
                Err(problem) => problem,
            };
            if self.stop.load(Ordering::Relaxed) {
                return Err(ReleaseError::Interrupted);
            }
            if self.bus.now().since(since) >= self.patience || problem.is_no_encoder() {
                return Err(problem.into());
            }
            self.bus.wait(LOOK_EVERY);
        }
    }

    fn both(&mut self) -> Result<Standing, BusError> {
        let out = self.bus.out(self.position)?;
        let mut input = [InWord(0)];
        self.bus.cycle(None, self.position, &mut input)?;
        let [input] = input;
        Ok(Standing { out, input })
    }

    /// Watches both words until nothing has changed for [`STANDS_FOR`]. A word that was spoilt begins the time anew.
    /// Writes nothing.
    ///
    /// # Errors
    /// [`ReleaseError::InUse`] if one of them changed.
    pub fn watch(&mut self, was: Standing) -> Result<(), ReleaseError> {
        let mut since = self.bus.now();
        while self.bus.now().since(since) < STANDS_FOR {
            self.bus.wait(LOOK_EVERY);
            if self.stop.load(Ordering::Relaxed) {
                return Err(ReleaseError::Interrupted);
            }
            if !self.patiently()?.same(was) {
                self.only_spoilt(was)?;
                since = self.bus.now();
            }
        }
        Ok(())
    }

    /// Looks anew at words that seem to have changed.
    fn only_spoilt(&mut self, was: Standing) -> Result<(), ReleaseError> {
        self.spoilt += 1;
        let now = self.look()?;
        let same = was.same(now) && self.spoilt <= SPOILT_MAX;
        if same { Ok(()) } else { Err(ReleaseError::InUse { was, now }) }
    }

    /// Takes the service bit back if nothing has changed up to now, and gives what stands there then. All other bits of
    /// OUT stay.
    ///
    /// # Errors
    /// [`ReleaseError`]; only [`ReleaseError::Stays`] and, if the bus failed after that, [`ReleaseError::Bus`] come
    /// after a write.
    pub fn clear(&mut self, was: Standing) -> Result<Standing, ReleaseError> {
        while !self.patiently()?.same(was) {
            self.only_spoilt(was)?;
            self.watch(was)?;
        }
        let since = self.bus.now();
        let cleared = OutWord::from(Out::Normal(was.out.0));
        loop {
            // Whether it arrived OUT says.
            let _ = self.bus.cycle(Some((self.position, cleared)), self.position, &mut []);
            self.bus.wait(LOOK_EVERY);
            let now = self.look()?;
            // A gateway may also have let its outputs fall.
            if now.out == cleared || now.out == OutWord(0) {
                return Ok(now);
            }
            if now.out != was.out && turned(cleared, now.out).is_none() {
                return Err(ReleaseError::InUse { was, now });
            }
            let within = self.bus.now().since(since);
            if within >= self.patience || self.stop.load(Ordering::Relaxed) {
                return Err(ReleaseError::Stays { out: now.out, within });
            }
        }
    }
}

/// How to read both words so that OUT is a request and IN its reply: as they are read OUT has no service bit. Eight bits may
/// match by chance, the service in both does not.
fn turned_round(now: Standing) -> Option<Misread> {
    if now.out.service_bit() {
        return None;
    }
    Misread::ALL.into_iter().find(|way| {
        let (out, input) = (way.read(InWord(now.out.0)), way.read(now.input));
        out.service_bit() && can_be_sent(input) && out.0 >> 24 == input.0 >> 24 & !ERROR_BIT
    })
}
