//! What is kept of a row, and the ways to read it.

use encoring_texts::{Hex, Said};
use encoring_words::word::{DATA, DATA_MAX, ERROR_BIT, In, RESERVE_BIT, SERVICE_BIT};
use encoring_words::{InWord, gray};

use crate::evidence;
use crate::sample::{Sample, Sighting};

/// The latest time, nine years: sums of a few times never overflow.
const LATEST: i64 = 1 << 58;
/// The farthest position as a number.
const MOST_STEPS: i64 = 1 << 40;

/// A row that is kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) line: u64,
    pub(crate) time_ns: i64,
    pub(crate) reading: Sighting,
    pub(crate) out: Option<u32>,
}

/// How the bits of a row become a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReadAs {
    /// As they are.
    Plain,
    /// They are Gray code.
    Gray,
    /// They are what a reader of Gray code made of binary.
    Binary,
    /// The halves are exchanged.
    Exchanged,
}

/// Every way, the usual one first.
pub(crate) const WAYS: [ReadAs; 4] = [ReadAs::Plain, ReadAs::Gray, ReadAs::Binary, ReadAs::Exchanged];

impl Row {
    pub(crate) fn new(sample: &Sample) -> Self {
        let time_ns = i64::try_from(sample.time_ns).unwrap_or(LATEST).min(LATEST);
        let reading = match sample.reading {
            Sighting::Steps(steps) => Sighting::Steps(steps.clamp(-MOST_STEPS, MOST_STEPS)),
            other => other,
        };
        Self { line: sample.line, time_ns, reading, out: sample.out }
    }

    /// The bits that came, as a number.
    pub(crate) fn bits(&self) -> Option<i64> {
        match self.reading {
            Sighting::Word(word) => Some(word.into()),
            Sighting::Bits24(bits) => Some((bits & DATA_MAX).into()),
            Sighting::Bits16(half) => Some(half.into()),
            Sighting::Steps(steps) => Some(steps),
            Sighting::Nothing | Sighting::Unreached { .. } => None,
        }
    }

    /// The bits as they are written.
    pub(crate) fn shown(&self) -> Said {
        match self.reading {
            Sighting::Word(word) => evidence::in_word(Hex(word)),
            Sighting::Bits24(bits) => evidence::bits_24(Hex(bits)),
            Sighting::Bits16(half) => evidence::bits_16(Hex(half.into())),
            Sighting::Steps(steps) => evidence::steps(steps),
            Sighting::Nothing | Sighting::Unreached { .. } => evidence::nothing(),
        }
    }

    /// A reply, by bit 31.
    pub(crate) fn reply(&self) -> Option<InWord> {
        match self.reading {
            Sighting::Word(word) if word & SERVICE_BIT.mask() != 0 && word & RESERVE_BIT.mask() == 0 => {
                Some(InWord(word))
            }
            _ => None,
        }
    }

    /// The position, read in this way.
    pub(crate) fn position(&self, way: ReadAs) -> Option<i64> {
        let bits = match (self.reading, way) {
            (Sighting::Word(word), ReadAs::Exchanged) => word.rotate_left(16),
            (Sighting::Word(word), _) => word,
            (_, ReadAs::Plain) => return self.bits(),
            (_, ReadAs::Exchanged) => return None,
            _ => u32::try_from(self.bits()?).ok()?,
        };
        let In::Position { value, .. } = InWord(bits & !ERROR_BIT.mask()).decode() else { return None };
        Some(i64::from(match way {
            ReadAs::Plain | ReadAs::Exchanged => value,
            ReadAs::Gray => gray::decode(value),
            ReadAs::Binary => gray::encode(value),
        }))
    }

    /// What is left of exchanged halves in 24 bits: the low byte of the position, if the row can be such a one.
    pub(crate) fn low_byte_of_exchanged(&self) -> Option<i64> {
        let bits = u32::try_from(self.bits()?).ok()?;
        (bits & !DATA.mask() == 0 && bits & 0xFF00 == 0 && bits > 0xFFFF).then_some(i64::from(bits >> 16))
    }
}
