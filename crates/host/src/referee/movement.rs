//! Whether the position moves: whether it takes values that it has not had just before.

use super::Instant;
use super::rule::MOVING;

/// A shaft at rest may tremble between so many values. They are compared for equality only, so that neither Gray code
/// nor the end of the range matters.
const TREMBLES: usize = 4;

#[derive(Clone, Copy, Debug)]
pub(super) struct Movement {
    values: [Option<u32>; TREMBLES],
    next: usize,
    moved: Option<Instant>,
}

impl Movement {
    pub(super) const NEW: Self = Self { values: [None; TREMBLES], next: 0, moved: None };

    /// A position in normal mode.
    pub(super) fn position(&mut self, at: Instant, value: u32) {
        if self.values.contains(&Some(value)) {
            return;
        }
        let Some(slot) = self.values.get_mut(self.next) else { return };
        if slot.replace(value).is_some() {
            self.moved = Some(at);
        }
        self.next = (self.next + 1) % TREMBLES;
    }

    /// A service was carried out: the next position may be another without a movement.
    pub(super) fn interrupted(&mut self) {
        (self.values, self.next) = ([None; TREMBLES], 0);
    }

    /// Whether it has moved shortly before `at` or later.
    pub(super) fn moved_since(&self, at: Instant) -> bool {
        self.moved.is_some_and(|moved| at.since(moved) < MOVING)
    }
}
