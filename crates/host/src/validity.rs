//! Whether a position may be used: no encoder tells of a speed too high, a track error or a transfer error, so every
//! position is judged here [R142].
//!
//! [`Validity`] takes what each poll of the bus brought and hands out a [`Position`], from which a number can only be
//! had if it is valid. What is judged, in this order:
//!
//! | What came | Becomes |
//! |---|---|
//! | bits that no encoder sets | [`Why::Foreign`] |
//! | bit 29, in a position or in a reply | [`Position::Faulty`], in that very poll [R143] |
//! | a reply | [`Position::InService`]: its data are no position [C43] |
//! | a position above S, after Gray code was undone | [`Why::Range`] |
//! | a place to which nothing could have moved since | [`Why::Speed`], [`Why::OffTheRod`], [`Why::Acceleration`] |
//! | a word older than the limit, or none for so long | [`Position::Stale`] |
//!
//! A shaft or magnet within its [`Limits`] is never called implausible, whenever the polls come and whatever the
//! refresh [C35]; what these limits exclude is found. With polls so far apart that half of the range can be travelled
//! between them, nothing is excluded and every position of the range is valid.
//!
//! After a jump the positions stay implausible until they come back to where they would be without it, or until
//! [`Validity::rebase`]: an encoder that has lost its zero goes on counting without any fault to be seen [C29].
//!
//! ```
//! use encoring_host::Seen;
//! use encoring_host::validity::{Expectation, Limits, Position, Validity};
//! use encoring_words::model::Sensor;
//! use encoring_words::{Duration, InWord, Instant, Model, ParameterSet};
//!
//! let sensor = Sensor::Rotary { steps_per_turn: 4096 };
//! let expectation = Expectation::new(Model::Ce65M, sensor, &ParameterSet::factory(Model::Ce65M, sensor))?;
//! let mut validity = Validity::new(expectation, Limits::of(Model::Ce65M, Duration::from_micros(500)));
//! let mut stops = 0;
//! let mut poll = |ms: u64, word: u32| {
//!     let seen = Seen { input: InWord(word), age: Duration::ZERO };
//!     validity.judge(Instant(ms * 1_000_000), Some(seen), &mut |_reason| stops += 1)
//! };
//! assert_eq!(poll(0, 0x0000_FFFF), Position::Valid(0xFFFF));
//! assert_eq!(poll(1, 0x0000_0000).valid(), None); // half of 010000h, half of 00FFFFh
//! assert_eq!(poll(2, 0x0001_0000), Position::Valid(0x1_0000));
//! assert_eq!(poll(3, 0x2001_0000), Position::Faulty(None));
//! assert_eq!(stops, 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod expectation;
mod track;

#[cfg(test)]
mod tests;

use encoring_words::parameter::Code;
use encoring_words::word::{In, ServiceFields, ServiceNumber};
use encoring_words::{Access, Duration, ErrorStatus, InWord, Instant, Service, gray};

pub use expectation::{Expectation, Limits, NoExpectation, Swiftest};
pub use track::Circle;

use crate::Seen;
use track::{EVER, Sample, Space, Track};

/// What a poll says of a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// The position, which nothing speaks against.
    Valid(u32),
    /// The newest word may be older than the limit, or no position has come yet.
    Stale {
        /// The last plausible position, if there was one since the beginning or the last rebase. It is history, not
        /// where the shaft is.
        last: Option<u32>,
        /// How old the newest word may be; before the first word, the time since the first poll.
        age: Duration,
    },
    /// Bit 29 is set [R141], with the error status if a data check has told it since.
    Faulty(Option<ErrorStatus>),
    /// The word is a reply.
    InService,
    /// The word cannot be true.
    Implausible(Why),
}

impl Position {
    /// The position, if it is valid.
    #[must_use]
    pub const fn valid(self) -> Option<u32> {
        match self {
            Self::Valid(position) => Some(position),
            Self::Stale { .. } | Self::Faulty(_) | Self::InService | Self::Implausible(_) => None,
        }
    }
}

/// Why a word cannot be true.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Why {
    /// Bits are set that no encoder sets: 30 or 28..24 of a position, 28 of a reply [R24, C13].
    #[error("IN {0} has bits that no encoder sets")]
    Foreign(InWord),
    /// The position lies above S.
    #[error("the position {value} is above the measuring length, {measuring_length}")]
    Range {
        /// The position.
        value: u32,
        /// S.
        measuring_length: u32,
    },
    /// The two positions lie further apart than the ends of the rod.
    #[error("the way from {from} to {to} leads off the rod, which has {measuring_length} steps")]
    OffTheRod {
        /// The last plausible position.
        from: u32,
        /// The position.
        to: u32,
        /// S.
        measuring_length: u32,
    },
    /// The permissible speed is too slow for this.
    #[error("nothing permissible moves from {from} to {to} within {}", coarse(*within))]
    Speed {
        /// The last plausible position.
        from: u32,
        /// The position.
        to: u32,
        /// The most time that there was.
        within: Duration,
    },
    /// The permissible acceleration is too low for this.
    #[error("the move from {from} to {to} is too sudden after what was before")]
    Acceleration {
        /// The last plausible position.
        from: u32,
        /// The position.
        to: u32,
    },
}

impl Why {
    /// `true` for a step of the position that is none of the shaft or the magnet [R150..R153].
    #[must_use]
    pub const fn is_step(self) -> bool {
        match self {
            Self::OffTheRod { .. } | Self::Speed { .. } | Self::Acceleration { .. } => true,
            Self::Foreign(_) | Self::Range { .. } => false,
        }
    }
}

/// Why the machine must be stopped [R143].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// Bit 29, with the error status if it is known.
    Error(Option<ErrorStatus>),
    /// A word that cannot be true.
    Implausible(Why),
    /// No word for too long.
    Stale {
        /// How old the newest may be.
        age: Duration,
    },
}

/// Judges the positions of one encoder, poll after poll.
///
/// Call [`Validity::judge`] once for each poll, in the order of the polls. Call [`Validity::rebase`] when the position
/// jumps for a good reason: after the reply to a preset adjustment (service 06), when a preset input has acted, when an
/// LA-66's magnet was put elsewhere, and when somebody has found out why the positions were implausible. Call
/// [`Validity::expect`] when other values have become active.
#[derive(Clone, Debug)]
pub struct Validity {
    expectation: Expectation,
    limits: Limits,
    space: Space,
    /// When the first poll was.
    began: Option<Instant>,
    now: Instant,
    /// When the last word came, and how old the newest may have been then.
    newest: Option<(Instant, Duration)>,
    word: Word,
    /// The last plausible position.
    last: Option<u32>,
    /// What a data check told of the pending error.
    status: Option<ErrorStatus>,
    track: Option<Track>,
    suspect: Option<Suspect>,
    /// The last two positions were close enough in time that some movement is impossible.
    excludes: bool,
    hold: Hold,
    told: Told,
}

/// What the last word was.
#[derive(Clone, Copy, Debug)]
enum Word {
    /// None since the beginning or a rebase.
    Nothing,
    Good(u32),
    Service,
    Error,
    Implausible(Why),
}

/// The positions after a jump.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    track: Track,
    /// Where they would be without the jump: the track before it, moved as they have moved since.
    unmoved: Track,
    /// The most time that the jump can have taken, in which something may have moved besides.
    gap: i128,
    why: Why,
    /// When its first sample was taken at the latest.
    first: i128,
    /// All its samples may be that one.
    single: bool,
}

/// Whether a position can be that of a magnet that was gone: held, and older than a refresh time.
#[derive(Clone, Copy, Debug)]
enum Hold {
    /// Something else than a position came last.
    Interrupted,
    /// Positions came; words given up to this time may show what was held.
    Until(i128),
}

/// What the user was told since the position was valid.
#[derive(Clone, Copy, Debug, Default)]
struct Told {
    error: bool,
    implausible: bool,
    stale: bool,
}

impl Validity {
    /// For an encoder of which nothing has been seen yet. The first position is taken as it comes.
    #[must_use]
    pub fn new(expectation: Expectation, limits: Limits) -> Self {
        Self {
            expectation,
            limits,
            space: expectation.space(&limits),
            began: None,
            now: Instant::ZERO,
            newest: None,
            word: Word::Nothing,
            last: None,
            status: None,
            track: None,
            suspect: None,
            excludes: true,
            hold: Hold::Interrupted,
            told: Told::default(),
        }
    }

    /// Judges what a poll brought; `None`: nothing. `stop` is called in this very poll if it is the first since a valid
    /// position with bit 29, with an implausible word, or without a word for too long; once for each of the three.
    ///
    /// A poll without a word leaves the verdict as it was, until it is stale. `now` is when the poll ended.
    pub fn judge(&mut self, now: Instant, seen: Option<Seen>, stop: &mut impl FnMut(Stop)) -> Position {
        self.now = self.now.max(now);
        let began = *self.began.get_or_insert(self.now);
        let before = self.newest.map(|(at, age)| age + self.now.since(at));
        let age = match seen {
            Some(seen) => {
                // A word is never older than the one before it.
                let age = before.map_or(seen.age, |before| before.min(seen.age));
                self.newest = Some((self.now, age));
                self.word = self.look(seen);
                age
            }
            None => {
                self.hold = Hold::Interrupted;
                before.unwrap_or(self.now.since(began))
            }
        };
        let stale = age > self.limits.stale_after;
        let position = match self.word {
            Word::Error => Position::Faulty(self.status),
            Word::Implausible(why) => Position::Implausible(why),
            Word::Nothing => Position::Stale { last: self.last, age },
            _ if stale => Position::Stale { last: self.last, age },
            Word::Service => Position::InService,
            Word::Good(position) => Position::Valid(position),
        };
        match position {
            Position::Valid(_) => self.told = Told::default(),
            Position::Faulty(status) => once(&mut self.told.error, stop, Stop::Error(status)),
            Position::Implausible(why) => once(&mut self.told.implausible, stop, Stop::Implausible(why)),
            Position::Stale { age, .. } if stale => once(&mut self.told.stale, stop, Stop::Stale { age }),
            Position::Stale { .. } | Position::InService => {}
        }
        position
    }

    /// `true` from a jump on until the positions are back, or until [`Validity::rebase`].
    #[must_use]
    pub const fn has_jumped(&self) -> bool {
        self.suspect.is_some()
    }

    /// `false` if half of the range or more could be travelled since the position before the last one: whatever came
    /// would have been plausible. Always `true` without a limit of the speed, where faster polls change nothing.
    #[must_use]
    pub const fn excludes_jumps(&self) -> bool {
        self.excludes
    }

    /// Takes the next position as it comes: the last one has nothing to do with it.
    pub fn rebase(&mut self) {
        (self.track, self.suspect, self.last, self.excludes) = (None, None, None, true);
        if let Word::Good(_) | Word::Implausible(_) = self.word {
            self.word = Word::Nothing;
        }
    }

    /// Other values have become active; also a rebase.
    pub fn expect(&mut self, expectation: Expectation) {
        self.expectation = expectation;
        self.space = expectation.space(&self.limits);
        self.rebase();
    }

    fn look(&mut self, seen: Seen) -> Word {
        let value = match seen.input.decode() {
            In::Position { value, error: false } => value,
            other => {
                self.hold = Hold::Interrupted;
                return match other {
                    In::Position { .. } => Word::Error,
                    In::Reply(reply) if !reply.reserve => self.reply(reply),
                    In::Reply(_) | In::Foreign(_) => Word::Implausible(Why::Foreign(seen.input)),
                };
            }
        };
        self.status = None;
        let value = match self.expectation.code {
            Code::Binary => value,
            Code::Gray => gray::decode(value),
        };
        let sample = self.sample(value, seen.age);
        if value > self.expectation.largest {
            let measuring_length = self.expectation.measuring_length;
            return Word::Implausible(Why::Range { value, measuring_length });
        }
        match self.moved(&sample) {
            Ok(()) => {
                self.last = Some(value);
                Word::Good(value)
            }
            Err(why) => Word::Implausible(why),
        }
    }

    fn reply(&mut self, reply: ServiceFields) -> Word {
        let data_check = reply.service == ServiceNumber::Known(Service::DataCheck);
        if data_check && reply.access == Access::Read && reply.error {
            self.status = Some(ErrorStatus::from_bits_truncate(reply.data as u16));
        } else if !reply.error {
            self.status = None;
        }
        if reply.error { Word::Error } else { Word::Service }
    }

    /// When the encoder may have taken the sample of a word that came now.
    fn sample(&mut self, value: u32, age: Duration) -> Sample {
        let nanos = |span: Duration| i128::from(span.as_nanos());
        let latest = i128::from(self.now.as_nanos());
        let given = latest - nanos(age) - nanos(self.limits.cycle);
        let refresh = nanos(self.limits.refresh);
        let until = match self.hold {
            Hold::Interrupted => latest + refresh,
            Hold::Until(until) => until,
        };
        self.hold = Hold::Until(until);
        let held = self.expectation.holds() && given <= until;
        Sample { value, earliest: if held { EVER } else { given - refresh }, latest }
    }

    /// Whether the place can have moved to where it is shown now.
    fn moved(&mut self, sample: &Sample) -> Result<(), Why> {
        let Some(track) = &self.track else {
            self.track = Some(Track::begin(sample));
            return Ok(());
        };
        let refresh = self.limits.refresh;
        let Some(suspect) = &mut self.suspect else {
            self.excludes = self.space.excludes(track.time_to(sample));
            return match track.follow(&self.space, sample, refresh) {
                Ok(track) => {
                    self.track = Some(track);
                    Ok(())
                }
                Err(why) => {
                    self.suspect = Some(Suspect::new(track, sample, why));
                    Err(why)
                }
            };
        };
        self.excludes = self.space.excludes(suspect.unmoved.time_to(sample));
        let back = match suspect.may_be_back(track, &self.space, sample, refresh) {
            Ok(()) => track.follow(&self.space, sample, refresh),
            Err(why) => Err(why),
        };
        let onwards = suspect.track.follow(&self.space, sample, refresh);
        let distance = |track: &Track| self.space.distance(track.value(), sample.value);
        // A place to which both lead is no proof of a return, unless the jump was a single sample.
        let returned =
            onwards.is_err() || suspect.single && distance(&suspect.unmoved) < distance(&suspect.track);
        match (back, onwards) {
            (Ok(track), _) if returned => {
                (self.track, self.suspect) = (Some(track), None);
                Ok(())
            }
            (_, Ok(track)) => Err(suspect.go_on(&self.space, &track, sample)),
            (Ok(_), Err(why)) | (Err(why), Err(_)) => {
                self.suspect = Some(Suspect::new(&suspect.unmoved, sample, why));
                Err(why)
            }
        }
    }
}

impl Suspect {
    fn new(before: &Track, sample: &Sample, why: Why) -> Self {
        let gap = before.time_to(sample);
        let track = Track::begin(sample);
        Self { track, unmoved: *before, gap, why, first: sample.latest, single: true }
    }

    /// Whether a sample may be where the positions would be without the jump, or why not.
    ///
    /// A shaft that moved, and words that have stood still since the jump: they show nothing of its movement, so it may
    /// be wherever the limits allow, while these still exclude a good part of the range.
    fn may_be_back(
        &self,
        before: &Track,
        space: &Space,
        sample: &Sample,
        refresh: Duration,
    ) -> Result<(), Why> {
        let stuck = before.moves() && self.track.has_stood();
        if stuck && space.excludes(before.time_to(sample)) {
            return Ok(());
        }
        self.unmoved.follow(&space.without_acceleration(), sample, refresh).map(drop)
    }

    fn go_on(&mut self, space: &Space, track: &Track, sample: &Sample) -> Why {
        let value = space.moved(self.unmoved.value(), self.track.value(), sample.value);
        let earliest = sample.earliest.saturating_sub(self.gap);
        self.unmoved = Track::begin(&Sample { value, earliest, ..*sample });
        self.track = *track;
        self.single &= sample.earliest <= self.first;
        self.why
    }
}

/// A time in three digits, rounded up.
fn coarse(span: Duration) -> Duration {
    let (ns, mut unit) = (span.as_nanos(), 1);
    while ns / unit >= 1_000 {
        unit *= 10;
    }
    Duration(ns.div_ceil(unit).saturating_mul(unit))
}

fn once(told: &mut bool, stop: &mut impl FnMut(Stop), why: Stop) {
    if !*told {
        *told = true;
        stop(why);
    }
}
