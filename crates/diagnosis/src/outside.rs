//! Words that are no positions: replies, and words with bits that no encoder sets [R24, C13].

use std::ops::Range;

use encoring_texts::Hex;
use encoring_words::InWord;
use encoring_words::gray;
use encoring_words::word::{DATA, ERROR_BIT, SERVICE};

use crate::cause::JumpCause;
use crate::evidence;
use crate::motion::{scaled, way};
use crate::part::Part;
use crate::row::{ReadAs, Row};
use crate::sample::Sighting;
use crate::verdict::Judged;

/// A word counts as a position at its place up to this distance from it: farther off replies are there by chance.
const NEAR_MOST: i64 = 1 << 12;

/// A word that is no position, and where the position should be.
#[derive(Clone, Copy)]
struct Outside {
    word: u32,
    out: Option<u32>,
    should: Option<i64>,
    /// How near to that it must be.
    near: i64,
    way: ReadAs,
}

/// The words of these rows that are no positions.
pub(crate) fn finds(part: &Part<'_>, finds: &mut Vec<(Range<usize>, Judged)>) {
    let mut at = part.range.start;
    while at < part.range.end {
        let Some((row, word)) = outside_at(part, at) else {
            at += 1;
            continue;
        };
        let is_same = |other: &usize| outside_at(part, *other).is_some_and(|(_, other)| other == word);
        let rows = (at..part.range.end).take_while(is_same).count();
        let outside = Outside {
            word,
            out: row.out,
            should: should(part, at, row.time_ns),
            near: (part.tolerance / 3).clamp(3, NEAR_MOST),
            way: part.way_of(at),
        };
        finds.push((at..at + rows, outside.judged()));
        at += rows;
    }
}

fn outside_at<'a>(part: &Part<'a>, at: usize) -> Option<(&'a Row, u32)> {
    let row = part.rows.get(at)?;
    let Sighting::Word(word) = row.reading else { return None };
    row.position(part.way_of(at)).is_none().then_some((row, word))
}

/// Where a position would be between the points beside a row.
fn should(part: &Part<'_>, row: usize, time_ns: i64) -> Option<i64> {
    let behind = part.points.partition_point(|point| point.row < row);
    let before = part.points.get(behind.checked_sub(1)?)?;
    let Some(after) = part.points.get(behind) else { return Some(before.value) };
    let span = (time_ns - before.time_ns).max(0);
    let way = scaled(way(part.circle, before.value, after.value), span, after.time_ns - before.time_ns);
    Some(part.circle.moved(before.value, way))
}

impl Outside {
    fn judged(&self) -> Judged {
        let (word, told) = (InWord(self.word), Hex(self.word));
        if let Some(asked) = self.asked() {
            return self.reply().since(evidence::asked(Hex(asked)));
        }
        if self.is_there(self.word.rotate_left(16)) || self.is_in_the_same_65536(self.word.rotate_left(16)) {
            return Judged::certain(JumpCause::HalvesExchanged, evidence::exchanged(told));
        }
        let upper = self.word & !(DATA.mask() | ERROR_BIT.mask());
        if upper.count_ones() == 1 && self.is_there(self.word & DATA.mask()) {
            return Judged::certain(
                JumpCause::SingleBit,
                evidence::foreign_bit(told, upper.trailing_zeros()),
            );
        }
        if self.has_low_half() && !self.is_there(self.word & DATA.mask()) {
            return Judged::certain(JumpCause::TornWords, evidence::half_of_position(told));
        }
        if word.service_bit() {
            return match self.out {
                Some(out) if out >> 31 == 1 => self.reply().since(evidence::asked(Hex(out))),
                _ => self.reply(),
            };
        }
        Judged::possible(JumpCause::Unclear, evidence::foreign_bits(told)).or(&[
            JumpCause::TornWords,
            JumpCause::Noise,
            JumpCause::OtherSource,
        ])
    }

    /// The OUT word beside it, if it asks for just this reply.
    fn asked(&self) -> Option<u32> {
        let request = |out: &u32| out >> 31 == 1 && SERVICE.of(*out) == SERVICE.of(self.word);
        self.out.filter(request).filter(|_| InWord(self.word).service_bit())
    }

    fn reply(&self) -> Judged {
        let service = Hex(SERVICE.of(self.word));
        Judged::certain(JumpCause::ReplyAsPosition, evidence::reply(Hex(self.word), service))
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
