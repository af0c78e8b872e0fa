//! Words that are no positions: replies, and words with bits that no encoder sets [R24, C13].

use encoring_words::InWord;
use encoring_words::gray;
use encoring_words::word::{DATA, ERROR_BIT, SERVICE};

use crate::cause::JumpCause;
use crate::row::ReadAs;
use crate::verdict::Judged;

/// A word that is no position, and where the position should be.
#[derive(Clone, Copy)]
pub(crate) struct Outside {
    pub(crate) word: u32,
    pub(crate) out: Option<u32>,
    pub(crate) should: Option<i64>,
    /// How near to that it must be.
    pub(crate) near: i64,
    pub(crate) way: ReadAs,
}

impl Outside {
    pub(crate) fn judged(&self) -> Judged {
        let word = InWord(self.word);
        if self.is_there(self.word.rotate_left(16)) || self.is_in_the_same_65536(self.word.rotate_left(16)) {
            return Judged::certain(
                JumpCause::HalvesExchanged,
                format!("with its halves exchanged IN {word} is where the rows around it lead"),
            );
        }
        let upper = self.word & !(DATA.mask() | ERROR_BIT.mask());
        if upper.count_ones() == 1 && self.is_there(self.word & DATA.mask()) {
            return Judged::certain(
                JumpCause::SingleBit,
                format!("IN {word} has bit {}, which no encoder sets in a position", upper.trailing_zeros()),
            );
        }
        if self.has_low_half() && !self.is_there(self.word & DATA.mask()) {
            return Judged::certain(
                JumpCause::TornWords,
                format!("the low half of IN {word} is that of a position, the high half is not"),
            );
        }
        if word.service_bit() {
            let judged = Judged::certain(
                JumpCause::ReplyAsPosition,
                format!("IN {word} has bit 31: it is a reply to service {:02X}", SERVICE.of(self.word)),
            );
            return match self.out {
                Some(out) if out >> 31 == 1 => judged.since(format!("OUT {out:08X} asks for it")),
                _ => judged,
            };
        }
        Judged::possible(JumpCause::Unclear, format!("IN {word} has bits that no encoder sets")).or(&[
            JumpCause::TornWords,
            JumpCause::Noise,
            JumpCause::OtherSource,
        ])
    }

    fn decoded(&self, bits: u32) -> i64 {
        i64::from(match self.way {
            ReadAs::Gray => gray::decode(bits),
            ReadAs::Binary => gray::encode(bits),
            ReadAs::Plain | ReadAs::Exchanged => bits,
        })
    }

    fn is_there(&self, word: u32) -> bool {
        let is_position = word & !(DATA.mask() | ERROR_BIT.mask()) == 0;
        is_position
            && self
                .should
                .is_some_and(|should| (self.decoded(word & DATA.mask()) - should).abs() <= self.near)
    }

    /// A position with the same high half as the rows around it. No reply has that as its low half but by chance.
    fn is_in_the_same_65536(&self, word: u32) -> bool {
        let is_position = word & !(DATA.mask() | ERROR_BIT.mask()) == 0;
        let high = |value: i64| value >> 16;
        is_position
            && self.should.is_some_and(|should| {
                high(should) > 0 && high(self.decoded(word & DATA.mask())) == high(should)
            })
    }

    /// The low half is on the curve, beside a high half of something else.
    fn has_low_half(&self) -> bool {
        let Some(should) = self.should.and_then(|should| u32::try_from(should).ok()) else { return false };
        let code = if self.way == ReadAs::Gray { gray::encode(should) } else { should };
        self.near < 256 && self.is_there(code & 0xFFFF_0000 | self.word & 0xFFFF)
    }
}
