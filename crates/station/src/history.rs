//! Each change of an encoder's words, as the ring saw it: nothing is too short to be found here later.
//!
//! A service takes a few cycles and whoever looks does so some twenty times a second. So each change of the OUT word
//! and of the upper byte of the IN word is kept with its time, for each encoder by itself. The data of the IN word are
//! no change: a shaft that turns would fill everything.
//!
//! Behind a bus only polls are seen. Then a change says how long before it the words were last looked at, and which
//! phases of the handshake lie between the two looks.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use encoring_bus::watch::HandshakePhase;
use encoring_words::{InWord, Instant, OutWord};
use serde::{Serialize, Serializer};

use crate::json;

/// How many changes are kept of each encoder; whoever asks too rarely misses the oldest, and is told how many.
pub const CHANGES_KEPT: usize = 8_192;

/// One of the five steps of a service [R31..R40].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ServiceStep {
    /// Service number and data stand on OUT, the service bit is 0 [R33, R34].
    Data = 1,
    /// The service bit of OUT has risen [R32].
    Requested = 2,
    /// The service bit of IN has risen: the encoder reports [R36].
    Acknowledged = 3,
    /// The service bit of OUT has fallen [R38].
    Released = 4,
    /// The service bit of IN has fallen: positions again [R39].
    Ended = 5,
}

impl ServiceStep {
    /// Its number in the manuals' figure, 1..=5.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// What it means that OUT became another word; `None` where no step does it.
    const fn of_out(was: OutWord, is: OutWord) -> Option<Self> {
        match (was.service_bit(), is.service_bit()) {
            (false, false) if was.0 != is.0 => Some(Self::Data),
            (false, true) => Some(Self::Requested),
            (true, false) => Some(Self::Released),
            _ => None,
        }
    }

    /// What it means that IN became another word.
    const fn of_input(was: InWord, is: InWord) -> Option<Self> {
        match (was.service_bit(), is.service_bit()) {
            (false, true) => Some(Self::Acknowledged),
            (true, false) => Some(Self::Ended),
            _ => None,
        }
    }
}

impl Serialize for ServiceStep {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(self.number())
    }
}

/// A cycle of the ring after which an encoder's words were others than before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct WordChange {
    /// Counted from 0 for each encoder, without a gap.
    pub number: u64,
    /// The end of that cycle, or of that poll: time on the ring, or on the bus, in nanoseconds.
    pub time_ns: u64,
    /// How long before that the words were last seen; 0 if never.
    pub within_ns: u64,
    /// The OUT word that the cycle carried.
    #[serde(serialize_with = "json::text")]
    pub out: OutWord,
    /// The IN word that it brought.
    #[serde(rename = "in", serialize_with = "json::text")]
    pub input: InWord,
    /// The step that the master has taken.
    pub out_step: Option<ServiceStep>,
    /// The step that the encoder has taken.
    pub in_step: Option<ServiceStep>,
    /// The phases of the handshake between this look and the one before that no look has seen, by the manuals' number
    /// of the step that begins them. Empty where every cycle is seen.
    pub unseen: &'static [u8],
}

/// The phases that lie between two that polls saw.
const fn between(was: HandshakePhase, is: HandshakePhase) -> &'static [u8] {
    use HandshakePhase::{Acknowledged, Ending, Normal, Requested};
    match (was, is) {
        (Normal, Acknowledged) => &[2],
        (Requested, Ending) => &[3],
        (Acknowledged, Normal) => &[4],
        (Ending, Requested) => &[1],
        (Normal, Ending) => &[2, 3],
        (Requested, Normal) => &[3, 4],
        (Acknowledged, Requested) => &[4, 1],
        (Ending, Acknowledged) => &[1, 2],
        _ => &[],
    }
}

/// The changes of an encoder from some number on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ChangesSince {
    /// How many of those asked for are no longer kept.
    pub missed: u64,
    /// The number of the next change to ask for.
    pub next: u64,
    /// The others, oldest first.
    pub changes: Vec<WordChange>,
}

/// What is kept. Clones show the same. The default is of no encoder.
#[derive(Clone, Debug, Default)]
pub struct WordHistory(Arc<Mutex<Vec<Changes>>>);

/// Those of one encoder.
#[derive(Clone, Debug, Default)]
struct Changes {
    kept: VecDeque<WordChange>,
    next: u64,
}

impl Changes {
    fn push(&mut self, change: WordChange) {
        if self.kept.len() == CHANGES_KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(change);
        self.next += 1;
    }

    fn since(&self, from: u64, at_most: usize) -> ChangesSince {
        let oldest = self.next - self.kept.len() as u64;
        let missed = oldest.saturating_sub(from).min(oldest);
        let skipped = usize::try_from(from.saturating_sub(oldest)).unwrap_or(usize::MAX);
        let changes: Vec<WordChange> = self.kept.iter().skip(skipped).take(at_most).copied().collect();
        let next = changes.last().map_or(self.next, |last| last.number + 1);
        ChangesSince { missed, next, changes }
    }
}

impl WordHistory {
    pub(crate) fn new(encoders: usize) -> Self {
        Self(Arc::new(Mutex::new(vec![Changes::default(); encoders])))
    }

    fn encoders(&self) -> MutexGuard<'_, Vec<Changes>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The changes of the encoder at `position` from number `from` on, `at_most` so many; `None` past the last encoder.
    #[must_use]
    pub fn since(&self, position: usize, from: u64, at_most: usize) -> Option<ChangesSince> {
        Some(self.encoders().get(position)?.since(from, at_most))
    }

    /// How many changes there have been of each encoder, by position.
    #[must_use]
    pub fn counts(&self) -> Vec<u64> {
        self.encoders().iter().map(|changes| changes.next).collect()
    }
}

/// How often the words are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Looks {
    /// Every cycle of the ring.
    EveryCycle,
    /// Now and then.
    Polls,
}

/// What an encoder's words were, and when.
#[derive(Clone, Copy, Debug, Default)]
struct LastWords {
    at: Option<Instant>,
    out: OutWord,
    input: InWord,
}

/// Finds the changes of a ring.
#[derive(Debug)]
pub(crate) struct Watched {
    history: WordHistory,
    looks: Looks,
    last: Vec<LastWords>,
}

impl Watched {
    pub(crate) fn new(encoders: usize, looks: Looks) -> Self {
        Self { history: WordHistory::new(encoders), looks, last: vec![LastWords::default(); encoders] }
    }

    pub(crate) const fn history(&self) -> &WordHistory {
        &self.history
    }

    /// Takes the words of a cycle.
    pub(crate) fn cycled(&mut self, at: Instant, out: &[OutWord], input: &[InWord]) {
        for (position, (out, input)) in out.iter().copied().zip(input.iter().copied()).enumerate() {
            self.saw(at, position, out, input);
        }
    }

    /// Takes the words of the encoder at a position.
    pub(crate) fn saw(&mut self, at: Instant, position: usize, out: OutWord, input: InWord) {
        let Some(last) = self.last.get_mut(position) else { return };
        let was = std::mem::replace(last, LastWords { at: Some(at), out, input });
        // The first poll finds whatever stands there.
        let is_found = self.looks == Looks::Polls && was.at.is_none();
        if is_found || was.out == out && was.input.0 >> 24 == input.0 >> 24 {
            return;
        }
        let phases = (HandshakePhase::of(was.out, was.input), HandshakePhase::of(out, input));
        if let Some(changes) = self.history.encoders().get_mut(position) {
            changes.push(WordChange {
                number: changes.next,
                time_ns: at.as_nanos(),
                within_ns: was.at.map_or(0, |was| at.since(was).as_nanos()),
                out,
                input,
                out_step: ServiceStep::of_out(was.out, out),
                in_step: ServiceStep::of_input(was.input, input),
                unseen: match self.looks {
                    Looks::EveryCycle => &[],
                    Looks::Polls => between(phases.0, phases.1),
                },
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The steps that are seen when an encoder's words run through these.
    fn steps(words: &[(u32, u32)]) -> Vec<(Option<u8>, Option<u8>)> {
        let mut watched = Watched::new(1, Looks::EveryCycle);
        for (k, (out, input)) in words.iter().enumerate() {
            watched.cycled(Instant(k as u64), &[OutWord(*out)], &[InWord(*input)]);
        }
        let number = |step: Option<ServiceStep>| step.map(ServiceStep::number);
        let seen = watched.history().since(0, 0, usize::MAX).unwrap();
        seen.changes.iter().map(|change| (number(change.out_step), number(change.in_step))).collect()
    }

    #[test]
    fn a_service_has_five_steps_and_a_turning_shaft_none() {
        // [R31..R40]
        let service = [
            (0, 1_000),
            (0x4200_270F, 1_001),
            (0xC200_270F, 1_002),
            (0xC200_270F, 0xC200_270F),
            (0x4200_270F, 0xC200_270F),
            (0x4200_270F, 1_005),
            (0x4200_270F, 1_006),
        ];
        assert_eq!(
            steps(&service),
            [(Some(1), None), (Some(2), None), (None, Some(3)), (Some(4), None), (None, Some(5))]
        );
    }

    #[test]
    fn what_changes_in_service_is_a_change_without_a_step() {
        assert_eq!(steps(&[(0xC200_0001, 0), (0xC200_0002, 0)]), [(Some(2), None), (None, None)]);
        assert_eq!(steps(&[(0, 0), (0, 0x2000_0000)]), [(None, None)], "the error bit");
        assert_eq!(steps(&[(0x8800_0000, 0), (0, 0x8800_0000)]), [(Some(2), None), (Some(4), Some(3))]);
    }

    #[test]
    fn the_oldest_changes_go_first_and_how_many_are_missing_is_told() {
        let mut watched = Watched::new(2, Looks::EveryCycle);
        for k in 0..CHANGES_KEPT as u64 + 10 {
            watched.cycled(Instant(k), &[OutWord(0), OutWord(k as u32 + 1)], &[InWord(0); 2]);
        }
        let history = watched.history();
        assert_eq!(history.counts(), [0, 8_202]);
        let all = history.since(1, 0, usize::MAX).unwrap();
        assert_eq!((all.missed, all.next, all.changes.len()), (10, 8_202, CHANGES_KEPT));
        assert_eq!(all.changes[0].number, 10);
        let some = history.since(1, 4, 3).unwrap();
        assert_eq!((some.missed, some.next, some.changes[2].number), (6, 13, 12));
        let rest = history.since(1, 8_200, 100).unwrap();
        assert_eq!((rest.missed, rest.next, rest.changes.len()), (0, 8_202, 2));
        for beyond in [8_202, u64::MAX] {
            assert_eq!(history.since(1, beyond, 100).unwrap().changes, []);
        }
        assert_eq!(history.since(0, 0, 100).unwrap(), ChangesSince::default());
        assert_eq!(history.since(2, 0, 100), None);
    }

    #[test]
    fn polls_say_which_phases_no_poll_has_seen_and_since_when() {
        let mut watched = Watched::new(1, Looks::Polls);
        for (ms, out, input) in [
            (0, 0x0200_0000, 5),
            (10, 0x8200_0000, 5),
            (20, 0x8200_0000, 0x8200_270F),
            // Released and ended between two polls; then a whole service that nobody saw, and one half seen.
            (35, 0x0200_0000, 6),
            (45, 0x0200_0000, 7),
            (55, 0x8800_0000, 0x8800_0000),
        ] {
            watched.saw(Instant(ms * 1_000_000), 0, OutWord(out), InWord(input));
        }
        let seen = watched.history().since(0, 0, 9).unwrap().changes;
        let unseen: Vec<_> =
            seen.iter().map(|change| (change.within_ns / 1_000_000, change.unseen)).collect();
        assert_eq!(unseen, [(10, &[][..]), (10, &[]), (15, &[4]), (10, &[2])]);
        let steps: Vec<_> = seen.iter().map(|change| (change.out_step, change.in_step)).collect();
        assert_eq!(steps[2], (Some(ServiceStep::Released), Some(ServiceStep::Ended)));
    }
}
