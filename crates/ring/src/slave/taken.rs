//! What a chip holds of the OUT words, and what it held before.

use encoring_words::OutWord;

/// What a chip holds of the OUT words: what the device behind it is told at the end of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// The word taken last; `None` since the last reset.
    pub word: Option<OutWord>,
    /// How often the chip was reset so far: a reset between two looks would be missed otherwise.
    pub resets: u32,
}

impl Taken {
    /// The same chip, reset once more.
    #[must_use]
    pub const fn reset(self) -> Self {
        Self { word: None, resets: self.resets.wrapping_add(1) }
    }

    /// The word that the chip shows: 0 in reset.
    #[must_use]
    pub fn shown(self) -> OutWord {
        self.word.unwrap_or_default()
    }
}

/// What a chip holds, and what it held before the last change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Holding {
    now: Taken,
    before: Taken,
    /// The line bit with which the last change came.
    changed: u64,
}

impl Holding {
    /// It holds something else from line bit `at` on, or the same as before.
    pub(super) fn change(&mut self, to: Taken, at: u64) {
        if to != self.now {
            *self = Self { now: to, before: self.now, changed: at };
        }
    }

    pub(super) const fn now(&self) -> Taken {
        self.now
    }

    /// After so many line bits. What was before the last change but one is forgotten.
    pub(super) const fn after(&self, bits: u64) -> Taken {
        if bits < self.changed { self.before } else { self.now }
    }
}
