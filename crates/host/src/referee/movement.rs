//! Whether the position moves: whether it takes values that it has not had just before.

use super::Instant;
use super::rule::MOVING;

/// A shaft at rest may tremble between so many values. They are compared for equality only, so that neither Gray code
/// nor the end of the range matters.
const TREMBLES: usize = 4;
/// No position: it has more than 24 bits.
const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
pub(super) struct Movement {
    values: [u32; TREMBLES],
    next: usize,
    moved: Option<Instant>,
}

impl Movement {
    pub(super) const NEW: Self = Self { values: [NONE; TREMBLES], next: 0, moved: None };

    /// A position in normal mode.
    pub(super) fn position(&mut self, at: Instant, value: u32) {
        if self.values.contains(&value) {
            return;
        }
        let Some(slot) = self.values.get_mut(self.next) else { return };
        if core::mem::replace(slot, value) != NONE {
            self.moved = Some(at);
        }
        self.next = (self.next + 1) % TREMBLES;
    }

    /// A service was carried out: the next position may be another without a movement.
    pub(super) fn interrupted(&mut self) {
        (self.values, self.next) = ([NONE; TREMBLES], 0);
    }

    /// Whether it has moved shortly before `at` or later.
    pub(super) fn moved_since(&self, at: Instant) -> bool {
        self.moved.is_some_and(|moved| at.since(moved) < MOVING)
    }
}
