//! The words of a frame that are nobody's data: the end word and the control word of an ID cycle.

use crate::profile::{
    CONTROL_OUTGOING, CONTROL_RESET, DEVICE_DELAY_BITS, END_BAD, END_GOOD, FRAME_BYTES, POSITION_MASK,
    POSITION_SHIFT, STATUS_BEFORE_FRAME, STATUS_BITS, TELEGRAM_BITS,
};

/// Bits that check the position of an end word, above it [A9].
const CHECK_SHIFT: u32 = POSITION_SHIFT + 9;
const CHECK_MASK: u16 = 0x1F;

/// What an end word says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndWord {
    /// Every segment so far was good.
    Good,
    /// The first bad segment was the one that leads to this position.
    Bad {
        /// 0..512.
        position: u16,
    },
    /// None that a device sends: it was hit itself, or its segment turned bad too late to say more. The cycle was bad,
    /// the place is unknown.
    Unknown,
}

impl EndWord {
    /// From the 16 bits of the line.
    #[must_use]
    pub const fn decode(word: u16) -> Self {
        if word == END_GOOD {
            return Self::Good;
        }
        let position = word >> POSITION_SHIFT & POSITION_MASK;
        if word == bad(position) { Self::Bad { position } } else { Self::Unknown }
    }
}

/// The end word of a segment that was the first bad one [A9].
#[must_use]
pub const fn bad(position: u16) -> u16 {
    let position = position & POSITION_MASK;
    let check = !(position ^ position >> 5) & CHECK_MASK;
    END_BAD | check << CHECK_SHIFT | position << POSITION_SHIFT
}

/// What the master tells a device in an ID cycle [A10].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Control(pub u16);

impl Control {
    /// For the device at this position.
    #[must_use]
    pub const fn new(position: u16, outgoing: Outgoing) -> Self {
        let switch = match outgoing {
            Outgoing::On => CONTROL_OUTGOING,
            Outgoing::Off => 0,
        };
        Self((position & POSITION_MASK) << POSITION_SHIFT | switch)
    }

    /// The position told.
    #[must_use]
    pub const fn position(self) -> u16 {
        self.0 >> POSITION_SHIFT & POSITION_MASK
    }

    /// What the outgoing bus is to be.
    #[must_use]
    pub const fn outgoing(self) -> Outgoing {
        if self.0 & CONTROL_OUTGOING == 0 { Outgoing::Off } else { Outgoing::On }
    }

    /// Whether the device is to reset itself.
    #[must_use]
    pub const fn resets(self) -> bool {
        self.0 & CONTROL_RESET != 0
    }
}

/// The switch of a device that leads on to the next one, or back to the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outgoing {
    /// What it sends goes home to the master; the next device hears nothing.
    #[default]
    Off,
    /// What it sends goes to the next device.
    On,
}

/// Line bits of a frame with so many bytes of data.
#[must_use]
pub const fn frame_bits(bytes: usize) -> u64 {
    TELEGRAM_BITS * (FRAME_BYTES + bytes as u64)
}

/// Status telegrams that fill a slot of at least so many line bits after its first ones: as many as the frame needs to
/// come home and be closed, and as must stand before the next one.
#[must_use]
pub const fn pause_telegrams(slot: u64, sent: u64, devices: usize) -> u64 {
    let delay = DEVICE_DELAY_BITS as u64 * devices as u64;
    let least = delay + STATUS_BITS * 2 * STATUS_BEFORE_FRAME as u64;
    let left = slot.saturating_sub(sent);
    if left < least { least.div_ceil(STATUS_BITS) } else { left.div_ceil(STATUS_BITS) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{END_LATE, END_UNTOLD};

    #[test]
    fn an_end_word_tells_every_position_and_no_small_error_makes_one_out_of_a_good_one() {
        assert_eq!(EndWord::decode(0), EndWord::Good);
        for position in 0..512 {
            let word = bad(position);
            assert_eq!(EndWord::decode(word), EndWord::Bad { position });
            assert!(word.count_ones() >= 7, "{word:04X}");
            // Bit 15 and bit 0 are 21 line bits apart.
            assert_eq!(word & END_BAD, END_BAD);
        }
        let told = (1..=u16::MAX).filter(|word| EndWord::decode(*word) != EndWord::Unknown).count();
        assert_eq!(told, 512);
    }

    #[test]
    fn an_end_word_that_broke_off_names_no_place() {
        for position in 0..512 {
            assert_eq!(EndWord::decode(bad(position) & 0x00FF), EndWord::Unknown);
            assert_eq!(EndWord::decode(bad(position) & 0xFF00), EndWord::Unknown);
        }
        assert_eq!(EndWord::decode(u16::from(END_LATE)), EndWord::Unknown);
        assert_eq!(EndWord::decode(END_UNTOLD), EndWord::Unknown);
    }

    #[test]
    fn a_control_word_tells_place_and_switch() {
        for position in 0..512 {
            for outgoing in [Outgoing::Off, Outgoing::On] {
                let control = Control::new(position, outgoing);
                assert_eq!((control.position(), control.outgoing()), (position, outgoing));
                assert!(!control.resets());
            }
        }
        assert!(Control(0x8000).resets());
    }

    #[test]
    fn a_frame_of_three_encoders_has_234_bits() {
        assert_eq!(frame_bits(12), 234);
    }
}
