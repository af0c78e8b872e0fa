//! The bytes that pass through a chip.

use crate::profile::DEVICE_BYTES_MAX;

/// A piece of the ring's shift register: what goes in comes out `length` bytes later.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Register {
    bytes: [u8; DEVICE_BYTES_MAX],
    length: u8,
    /// The oldest byte.
    at: u8,
}

impl Register {
    /// As it is between frames: nothing passes.
    pub(super) const EMPTY: Self = Self { bytes: [0; DEVICE_BYTES_MAX], length: 0, at: 0 };

    pub(super) fn load(&mut self, from: &[u8]) {
        debug_assert!(from.len() <= DEVICE_BYTES_MAX, "no length code gives {} bytes", from.len());
        *self = Self { length: from.len().min(DEVICE_BYTES_MAX) as u8, ..Self::EMPTY };
        for (byte, loaded) in self.bytes.iter_mut().zip(from) {
            *byte = *loaded;
        }
    }

    /// The byte that leaves next; `None` in a register without length.
    pub(super) fn oldest(&self) -> Option<u8> {
        if self.length == 0 { None } else { self.bytes.get(usize::from(self.at)).copied() }
    }

    pub(super) fn shift(&mut self, byte: u8) {
        if self.length == 0 {
            return;
        }
        if let Some(place) = self.bytes.get_mut(usize::from(self.at)) {
            *place = byte;
        }
        self.at += 1;
        if self.at >= self.length {
            self.at = 0;
        }
    }

    /// The bytes, the oldest first.
    pub(super) fn bytes(&self) -> impl Iterator<Item = u8> {
        let all = self.bytes.get(..usize::from(self.length)).unwrap_or_default();
        debug_assert!(usize::from(self.at) <= all.len(), "it begins anew at its end");
        let (young, old) = all.split_at_checked(usize::from(self.at)).unwrap_or((all, &[]));
        old.iter().chain(young).copied()
    }
}
