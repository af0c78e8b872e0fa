//! A master of the SSI: it moves the clock and looks at the data.

use encoring_words::Instant;
use encoring_words::ssi_frame::Level;

use super::bench::{Bench, US};

impl Bench {
    /// A falling clock edge now; gives Data+.
    pub fn fall(&mut self) -> Level {
        self.encoder.ssi_clock(Instant(self.now), Level::Low, &self.terminals)
    }

    /// A rising clock edge now; gives Data+.
    pub fn rise(&mut self) -> Level {
        self.encoder.ssi_clock(Instant(self.now), Level::High, &self.terminals)
    }

    /// Data+ now, without an edge.
    pub fn data(&self) -> Level {
        self.encoder.ssi_level(Instant(self.now)).0
    }

    /// One transfer of `clocks` pulses with the clock Low and High for `half` nanoseconds each. Gives Data+ as it
    /// stands just before every falling edge but the first, and at the end of the last High half: what a receiver
    /// on falling edges collects.
    pub fn ssi_transfer(&mut self, clocks: u32, half: u64) -> Vec<Level> {
        let mut bits = Vec::new();
        for _ in 0..clocks {
            self.fall();
            self.advance(half);
            self.rise();
            self.advance(half);
            bits.push(self.data());
        }
        bits
    }

    /// The bits of one transfer at 500 kHz as a number, the first received highest, and the pause after it.
    pub fn ssi_word(&mut self, clocks: u32) -> u64 {
        let word = number(&self.ssi_transfer(clocks, US));
        self.advance(100 * US);
        word
    }
}

/// Levels as a number, the first highest.
pub fn number(bits: &[Level]) -> u64 {
    assert!(bits.len() <= 64);
    bits.iter().fold(0, |word, bit| word << 1 | u64::from(*bit == Level::High))
}
