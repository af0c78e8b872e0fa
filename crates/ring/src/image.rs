//! The process image: what the controller writes to and reads from the devices of its ring [R3, R5].

use encoring_words::{InWord, OutWord, Written};

/// The most encoders on one ring: 4096 I/O points of the controller, 32 of them an encoder.
pub const ENCODERS_MAX: usize = 128;

/// A ring was to hold more encoders than its controller has I/O points for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{encoders} encoders on one ring; the limit is {ENCODERS_MAX}")]
pub struct TooManyEncoders {
    /// How many were asked for.
    pub encoders: usize,
}

/// One of the two 16-bit words of an encoder, by the manuals' relative word address [R5].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Relative word address "1": bits 31..16.
    High,
    /// Relative word address "2": bits 15..0.
    Low,
}

/// What a reader on the SSI of an encoder shows beside the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SsiShown {
    /// The bits of the field as they came, the last one lowest.
    pub field: u32,
    /// 0 where nothing was read yet, 1 for a good transfer; others say what is wrong with it.
    pub verdict: u16,
    /// Transfers, beginning again at 0 after 65535.
    pub count: u16,
}

/// The words of every encoder of a ring, by ring position, and what the master says of the ring.
///
/// The ring moves an encoder's 32 bits in one piece; a controller that writes the halves in two steps may have a
/// cycle run between them [C15], and nothing here hides that.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProcessImage {
    encoders: usize,
    out: [OutWord; ENCODERS_MAX],
    input: [InWord; ENCODERS_MAX],
    status: u16,
    parameter: u16,
    faults: [u16; ENCODERS_MAX + 1],
    ssi: [SsiShown; ENCODERS_MAX],
}

impl ProcessImage {
    /// An image of zeros for this many encoders.
    ///
    /// # Errors
    /// [`TooManyEncoders`] above [`ENCODERS_MAX`].
    pub const fn new(encoders: usize) -> Result<Self, TooManyEncoders> {
        if encoders > ENCODERS_MAX {
            return Err(TooManyEncoders { encoders });
        }
        Ok(Self {
            encoders,
            out: [OutWord(0); ENCODERS_MAX],
            input: [InWord(0); ENCODERS_MAX],
            status: 0,
            parameter: 0,
            faults: [0; ENCODERS_MAX + 1],
            ssi: [SsiShown { field: 0, verdict: 0, count: 0 }; ENCODERS_MAX],
        })
    }

    /// How many encoders the ring holds.
    #[must_use]
    pub const fn encoders(&self) -> usize {
        self.encoders
    }

    /// The OUT words, by position.
    #[must_use]
    pub fn out(&self) -> &[OutWord] {
        self.out.get(..self.encoders).unwrap_or_default()
    }

    /// The OUT words, to be changed.
    pub fn out_mut(&mut self) -> &mut [OutWord] {
        self.out.get_mut(..self.encoders).unwrap_or_default()
    }

    /// The IN words, by position.
    #[must_use]
    pub fn input(&self) -> &[InWord] {
        self.input.get(..self.encoders).unwrap_or_default()
    }

    /// The IN words, to be changed by whoever cycles the ring.
    pub fn input_mut(&mut self) -> &mut [InWord] {
        self.input.get_mut(..self.encoders).unwrap_or_default()
    }

    /// The OUT words and, to be changed by whoever cycles the ring, the IN words.
    pub fn both(&mut self) -> (&[OutWord], &mut [InWord]) {
        let (out, input) = (self.out.get(..self.encoders), self.input.get_mut(..self.encoders));
        (out.unwrap_or_default(), input.unwrap_or_default())
    }

    /// The diagnostic status register, see [`status`](crate::diagnostics::status); 0 before the first cycle.
    #[must_use]
    pub const fn status(&self) -> u16 {
        self.status
    }

    /// The diagnostic parameter register.
    #[must_use]
    pub const fn parameter(&self) -> u16 {
        self.parameter
    }

    /// Faulty cycles that were located on each segment, 0..=encoders; a count that has reached 65535 stays there.
    #[must_use]
    pub fn faults(&self) -> &[u16] {
        self.faults.get(..=self.encoders).unwrap_or_default()
    }

    /// Replaces what the master says of the ring: status, parameter, and the faulty cycles of each segment.
    pub fn diagnose(&mut self, status: u16, parameter: u16, faults: impl IntoIterator<Item = u32>) {
        (self.status, self.parameter) = (status, parameter);
        let shown = self.faults.get_mut(..=self.encoders).unwrap_or_default();
        for (shown, counted) in shown.iter_mut().zip(faults) {
            *shown = u16::try_from(counted).unwrap_or(u16::MAX);
        }
    }

    /// What the readers on the SSIs show, by position.
    #[must_use]
    pub fn ssi(&self) -> &[SsiShown] {
        self.ssi.get(..self.encoders).unwrap_or_default()
    }

    /// Replaces what the reader on the SSI at a position shows. Past the last encoder nothing happens.
    pub fn show_ssi(&mut self, position: usize, shown: SsiShown) {
        if let Some(place) = self.ssi.get_mut(..self.encoders).and_then(|ssi| ssi.get_mut(position)) {
            *place = shown;
        }
    }

    /// One half of an OUT word; `None` past the last encoder.
    #[must_use]
    pub fn out_half(&self, position: usize, half: Half) -> Option<u16> {
        let word = self.out().get(position)?;
        Some(match half {
            Half::High => word.high(),
            Half::Low => word.low(),
        })
    }

    /// One half of an IN word; `None` past the last encoder.
    #[must_use]
    pub fn input_half(&self, position: usize, half: Half) -> Option<u16> {
        let word = self.input().get(position)?;
        Some(match half {
            Half::High => word.high(),
            Half::Low => word.low(),
        })
    }

    /// Writes an OUT word or a half of it. Past the last encoder nothing happens and `false` comes back.
    pub fn write_out(&mut self, position: usize, written: Written) -> bool {
        let Some(word) = self.out_mut().get_mut(position) else { return false };
        *word = word.after(written);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_encoder_has_two_words_each_way_and_the_next_one_follows() {
        let mut image = ProcessImage::new(3).unwrap();
        assert!(image.write_out(1, Written::High(0xC200)));
        assert!(image.write_out(1, Written::Low(0x270F)));
        assert_eq!(image.out(), [OutWord(0), OutWord(0xC200_270F), OutWord(0)]);
        assert_eq!(image.out_half(1, Half::High), Some(0xC200));
        assert_eq!(image.out_half(1, Half::Low), Some(0x270F));
    }

    #[test]
    fn past_the_last_encoder_there_is_nothing() {
        let mut image = ProcessImage::new(2).unwrap();
        assert!(!image.write_out(2, Written::High(1)));
        assert_eq!(image.out_half(2, Half::Low), None);
        assert_eq!(image.input_half(2, Half::Low), None);
        assert_eq!(ProcessImage::new(129), Err(TooManyEncoders { encoders: 129 }));
    }

    #[test]
    fn each_segment_has_its_count_and_one_that_is_too_large_stays_at_its_greatest() {
        let mut image = ProcessImage::new(2).unwrap();
        image.diagnose(0x10E0, 0x0380, [1, 0xFFFF, 0x1_0000, 7]);
        assert_eq!((image.status(), image.parameter()), (0x10E0, 0x0380));
        assert_eq!(image.faults(), [1, 0xFFFF, 0xFFFF]);
        let mut longest = ProcessImage::new(ENCODERS_MAX).unwrap();
        longest.diagnose(0, 0, core::iter::repeat_n(3, 1000));
        assert_eq!(longest.faults(), [3; ENCODERS_MAX + 1]);
    }

    #[test]
    fn half_a_word_leaves_the_other_half_torn_as_on_a_plc() {
        let mut image = ProcessImage::new(1).unwrap();
        image.out_mut()[0] = OutWord(0x0000_FFFF);
        image.write_out(0, Written::High(0xC200));
        assert_eq!(image.out()[0], OutWord(0xC200_FFFF));
    }
}
