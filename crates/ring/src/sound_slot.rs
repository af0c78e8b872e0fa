//! A slot in which nothing happens to the bits: what of it is known before it begins.
//!
//! On sound lines, through chips that are in step, every check word is right because nothing touched it. Such a slot is
//! taken as a whole: the same words move, and everything is left as its bits would leave it.

use crate::frame::{frame_bits, pause_telegrams};
use crate::profile::STATUS_BITS;
use crate::telegram::Decoder;

/// A data frame and the status telegrams behind it, all of them as they were sent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoundSlot {
    /// Line bits of the frame.
    pub(crate) frame: u64,
    /// Line bits of the slot.
    pub(crate) bits: u64,
    /// Every receiver at its end.
    pub(crate) decoder: Decoder,
}

impl SoundSlot {
    /// For so many devices with so many bytes together, in at least so many line bits.
    pub(crate) fn new(devices: usize, bytes: usize, bits: u64) -> Self {
        let frame = frame_bits(bytes);
        let telegrams = pause_telegrams(bits, frame, devices);
        let bits = frame.saturating_add(telegrams.saturating_mul(STATUS_BITS));
        Self { frame, bits, decoder: Decoder::after_data(telegrams) }
    }
}

/// Copies as many bytes as both have. Most devices are encoders: one word costs no loop.
pub(crate) fn copy(from: &[u8], to: &mut [u8]) {
    let length = from.len().min(to.len());
    match (from.first_chunk::<4>(), to.first_chunk_mut::<4>()) {
        (Some(word), Some(place)) if length == word.len() => *place = *word,
        _ => to.iter_mut().zip(from).for_each(|(place, byte)| *place = *byte),
    }
}
