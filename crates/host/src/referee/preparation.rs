//! Whether a log with rows so far apart can show how a program prepares its requests: number and data before the bit [R33].

use super::{Duration, Instant, OutWord};

/// What the rows show of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prepared {
    /// It was there.
    Shown,
    /// It was not, and of this service it never was, or it always takes longer than from one row to the next.
    Missing,
    /// It was not, and it was at other times: a row may have missed it.
    Overlooked,
}

/// What a log has shown of the preparations so far, each bit a service and its direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Preparations {
    /// Since when a request stands prepared.
    since: Option<Instant>,
    /// The longest time that one was seen to stand.
    longest: Duration,
    shown: u32,
    missing: u32,
    /// One was missing that no row can have overlooked.
    proven: bool,
    overlooked: bool,
}

impl Preparations {
    pub(super) const NEW: Self =
        Self { since: None, longest: Duration::ZERO, shown: 0, missing: 0, proven: false, overlooked: false };

    /// Other number or data stand from `at` on, and the service bit is 0.
    pub(super) const fn begins(&mut self, at: Instant) {
        self.since = Some(at);
    }

    /// Something may have happened that was not seen.
    pub(super) const fn forget(&mut self) {
        self.since = None;
    }

    /// The service bit of `word` rises at `at`, `together` with number or data; the row before was at `before`.
    pub(super) fn rises(&mut self, word: OutWord, together: bool, before: Instant, at: Instant) -> Prepared {
        let service = 1 << (word.0 >> 24 & 0xF | word.0 >> 26 & 0x10);
        let since = self.since.take();
        if !together {
            if let Some(since) = since {
                self.longest = Duration(self.longest.0.max(before.since(since).0));
                self.shown |= service;
                self.overlooked |= self.missing & service != 0;
            }
            return Prepared::Shown;
        }
        // A program is taken to need the same time for each.
        let proven = self.longest > Duration::ZERO && self.longest >= at.since(before);
        self.overlooked |= self.shown & service != 0 && !proven;
        if self.overlooked && !proven {
            return Prepared::Overlooked;
        }
        self.missing |= service;
        self.proven |= proven;
        Prepared::Missing
    }

    /// Nothing is missing that rows cannot have overlooked.
    pub(super) const fn is_complete(&self) -> bool {
        !self.proven && (self.missing == 0 || self.overlooked)
    }

    /// A preparation was missing, and seen at other times.
    pub(super) const fn was_overlooked(&self) -> bool {
        self.overlooked
    }
}
