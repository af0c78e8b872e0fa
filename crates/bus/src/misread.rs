//! Words that no encoder sends, and what would make an encoder's words of them.
//!
//! A gateway may exchange the halves of a word, or the bytes of each half. What comes then is nobody's: an upper byte that
//! is neither 00h or 20h with a position nor a reply's. That tells nothing of the encoder, and no machine needs stopping
//! for it.

use encoring_words::word::{In, Out, ServiceFields, ServiceNumber};
use encoring_words::{InWord, OutWord};

/// How a word is to be read so that it is an encoder's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misread {
    /// With its halves exchanged. Behind registers that begin one too early or too late the same shows.
    Halves,
    /// With the bytes of each half exchanged.
    Bytes,
    /// With all four bytes in the opposite order.
    HalvesAndBytes,
}

impl Misread {
    /// Every way, the most frequent first.
    pub const ALL: [Self; 3] = [Self::Halves, Self::Bytes, Self::HalvesAndBytes];

    /// What a word is that is nobody's as it stands: the way to read it as a position. `None` if it is an encoder's, or
    /// nobody's in every way.
    #[must_use]
    pub fn of(word: InWord) -> Option<Self> {
        if can_be_sent(word) {
            return None;
        }
        Self::ALL.into_iter().find(|way| matches!(way.read(word).decode(), In::Position { .. }))
    }

    /// The word, read so.
    #[must_use]
    pub const fn read(self, InWord(word): InWord) -> InWord {
        InWord(match self {
            Self::Halves => word.rotate_left(16),
            Self::Bytes => word.swap_bytes().rotate_left(16),
            Self::HalvesAndBytes => word.swap_bytes(),
        })
    }

    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Halves => "its halves exchanged",
            Self::Bytes => "the bytes of its halves exchanged",
            Self::HalvesAndBytes => "its four bytes in the opposite order",
        }
    }
}

/// How OUT holds what was written here, if the gateway has turned it round on its way. What asks for a service is
/// another master's, whatever it looks like.
#[must_use]
pub(crate) fn turned(written: OutWord, out: OutWord) -> Option<Misread> {
    if let Out::Request(ServiceFields {
        service: ServiceNumber::Known(_),
        error: false,
        reserve: false,
        ..
    }) = out.decode()
    {
        return None;
    }
    Misread::ALL.into_iter().find(|way| way.read(InWord(written.0)).0 == out.0)
}

/// Whether an encoder can send this.
#[must_use]
pub fn can_be_sent(word: InWord) -> bool {
    match word.decode() {
        In::Position { .. } => true,
        In::Reply(fields) => !fields.reserve,
        In::Foreign(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_that_a_gateway_has_turned_round_is_told_with_the_way() {
        let position = InWord(0x0001_1389);
        for way in Misread::ALL {
            // Each way is its own opposite.
            assert_eq!(way.read(way.read(position)), position);
        }
        assert_eq!(Misread::of(InWord(0x1389_0001)), Some(Misread::Halves));
        assert_eq!(Misread::of(InWord(0x0100_8913)), Some(Misread::Bytes));
        assert_eq!(Misread::of(InWord(0x8913_0100)), None, "a reply as well");
        assert_eq!(Misread::of(InWord(0x9913_0100)), Some(Misread::HalvesAndBytes));
    }

    #[test]
    fn what_an_encoder_sends_is_no_riddle() {
        for word in [0, 0x00FF_FFFF, 0x2000_1388, 0x8200_1388, 0xE200_270F] {
            assert_eq!(Misread::of(InWord(word)), None, "{word:08X}");
        }
    }
}
