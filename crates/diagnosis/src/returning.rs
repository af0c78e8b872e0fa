//! Rows that leave the curve and come back to it.
//!
//! The order of the tests matters: a torn word differs from the true one as a flip of bit 16 does where the high half
//! changes, and exchanged halves or the data of a reply can happen to differ by one bit [R5, R25].

use encoring_texts::{Hex, Said};
use encoring_words::gray;

use crate::cause::JumpCause;
use crate::curve::Curve;
use crate::evidence;
use crate::motion::{scaled, way};
use crate::row::ReadAs;
use crate::services::Services;
use crate::verdict::Judged;

/// Rows that leave the curve: those of points `at..back`.
#[derive(Clone, Copy)]
pub(crate) struct Excursion<'a> {
    pub(crate) curve: Curve<'a>,
    pub(crate) services: &'a Services,
    pub(crate) way: ReadAs,
    /// Values that a reply may hold: S, N, D.
    pub(crate) told: &'a [i64],
    pub(crate) at: usize,
    pub(crate) back: usize,
}

/// A word as its halves stand.
const fn halves(word: i64) -> (i64, i64) {
    (word >> 16, word & 0xFFFF)
}

impl Excursion<'_> {
    /// Why they left; `None` if nothing is wrong with them.
    pub(crate) fn judged(&self) -> Option<Judged> {
        if self.repeats() {
            return None;
        }
        let found = self.torn().or_else(|| self.exchanged()).or_else(|| self.reply()).or_else(|| self.bit());
        Some(found.unwrap_or_else(|| self.unclear()))
    }

    /// The bits as they came, in the code of the bus.
    fn code(&self, value: i64) -> i64 {
        let Ok(bits) = u32::try_from(value) else { return value };
        match self.way {
            ReadAs::Gray => gray::encode(bits).into(),
            ReadAs::Binary => gray::decode(bits).into(),
            ReadAs::Plain | ReadAs::Exchanged => value,
        }
    }

    /// The position of bits of the bus.
    fn decoded(&self, bits: i64) -> i64 {
        let Ok(bits) = u32::try_from(bits) else { return bits };
        match self.way {
            ReadAs::Gray => gray::decode(bits).into(),
            ReadAs::Binary => gray::encode(bits).into(),
            ReadAs::Plain | ReadAs::Exchanged => bits.into(),
        }
    }

    fn places(&self) -> impl Iterator<Item = (usize, i64, i64)> + '_ {
        (self.at..self.back).filter_map(|place| {
            let should = self.curve.between(self.at - 1, self.back, place)?;
            Some((place, self.curve.value(place)?, should))
        })
    }

    /// How far the rows lie from where those around them lead, at most.
    pub(crate) fn farthest(&self) -> i64 {
        let off = |(_, value, should)| way(self.curve.circle, value, should).abs();
        self.places().map(off).max().unwrap_or_default()
    }

    /// Whether the rows only go on in the direction of the motion, as those of wrong times do.
    pub(crate) fn is_in_order(&self) -> bool {
        let steps =
            || (self.at..=self.back).filter_map(|at| self.curve.step(at)).map(|step| step.way.signum());
        !(steps().any(|sign| sign > 0) && steps().any(|sign| sign < 0))
    }

    fn is_near(&self, value: i64, should: i64) -> bool {
        way(self.curve.circle, value, should).abs() <= self.curve.near()
    }

    /// Up to three rows with the word of the row before: the encoder, the bus or the log was late by that.
    fn repeats(&self) -> bool {
        let before = self.curve.value(self.at - 1);
        self.back - self.at < 4 && (self.at..self.back).all(|place| self.curve.value(place) == before)
    }

    fn torn(&self) -> Option<Judged> {
        if self.curve.circle.positions <= 0x1_0000 {
            return None;
        }
        let bits = |place: usize| self.curve.value(place).map(|value| self.code(value));
        let (before, after) = (halves(bits(self.at - 1)?).0, halves(bits(self.back)?).0);
        if before == after {
            return None;
        }
        let other = |high: i64| if high == before { after } else { before };
        // One half is from the row before or behind.
        let step = self.curve.way(self.at - 1, self.back).map_or(0, |(way, _)| way.abs());
        let near = self.curve.near() + step;
        let is_near = |value: i64, should: i64| way(self.curve.circle, value, should).abs() <= near;
        let is_torn = self.places().all(|(_, value, should)| {
            let (high, low) = halves(self.code(value));
            (high == before || high == after) && is_near(self.decoded(other(high) << 16 | low), should)
        });
        if !is_torn {
            return None;
        }
        let (_, value, should) = self.places().next()?;
        let evidence = evidence::torn(hex(before), hex(after));
        let is_one_bit = (self.code(value) ^ self.code(should)) & 0xFFFF_0000;
        let torn = Judged::likely(JumpCause::TornWords, evidence);
        let could_flip = (before ^ after).count_ones() == 1 || is_one_bit.count_ones() == 1;
        Some(if could_flip { torn.or(&[JumpCause::SingleBit]) } else { torn })
    }

    /// Of exchanged halves 24 bits are left: the low byte, nothing, and the high half.
    fn exchanged(&self) -> Option<Judged> {
        let near = self.curve.near();
        let rows = self.back - self.at;
        let fits = |value: i64, should: i64| {
            let (high, low) = halves(self.code(value));
            let byte = (high - (self.code(should) & 0xFF)).rem_euclid(256);
            let is_low_byte = byte.min(256 - byte) <= near && near < 32;
            high < 256 && low == halves(self.code(should)).0 && (is_low_byte || rows > 2)
        };
        let all = rows > 0 && self.places().all(|(_, value, should)| should > 0xFFFF && fits(value, should));
        all.then(|| Judged::likely(JumpCause::HalvesExchanged, evidence::low_is_high()))
    }

    /// In 24 bits a reply shows only by its data: 0, S, N, D, what a request said; and by OUT.
    fn reply(&self) -> Option<Judged> {
        let (_, value, _) = self.places().next()?;
        let is_same = self.places().all(|(_, other, _)| other == value);
        let asked = (self.at..self.back)
            .any(|place| self.curve.row(place).and_then(|row| row.out).is_some_and(|out| out >> 31 == 1));
        let bits = self.code(value);
        if asked && is_same {
            return Some(Judged::certain(JumpCause::ReplyAsPosition, evidence::data_of_reply(hex(bits))));
        }
        // Of sixteen bits nothing can be said.
        if !is_same || self.curve.circle.positions == 0x1_0000 {
            return None;
        }
        let reply = |evidence: Said| Some(Judged::likely(JumpCause::ReplyAsPosition, evidence));
        if self.services.has_said(bits) || self.told.contains(&bits) {
            return reply(evidence::data_of_service(hex(bits)));
        }
        if bits == 0 {
            return reply(evidence::data_of_check()).map(|judged| judged.or(&[JumpCause::OtherSource]));
        }
        None
    }

    fn bit(&self) -> Option<Judged> {
        let near = self.curve.near();
        // The encoder's sample is old by up to a refresh time.
        let refresh_ns = self.curve.axis.refresh_ns;
        let late = match self.curve.way(self.at - 1, self.back) {
            Some((way, span_ns)) if self.curve.period_ns < 4 * refresh_ns => {
                scaled(way, refresh_ns, span_ns).abs()
            }
            _ => 0,
        };
        let mut bits = self.places().map(|(_, value, should)| {
            let code = self.code(value);
            (0..24_u32).find(|bit| {
                1_i64 << bit > 2 * near + late && self.is_near(self.decoded(code ^ 1 << bit), should)
            })
        });
        let bit = bits.next()??;
        if !bits.all(|other| other == Some(bit)) {
            return None;
        }
        let evidence = evidence::one_bit(bit);
        Some(if self.back - self.at > 3 {
            Judged::possible(JumpCause::Unclear, evidence).or(&[
                JumpCause::StuckBit,
                JumpCause::SingleBit,
                JumpCause::Mechanical,
            ])
        } else {
            Judged::likely(JumpCause::SingleBit, evidence)
        })
    }

    fn unclear(&self) -> Judged {
        let rows = self.back - self.at;
        let first = self.curve.value(self.at);
        let stands = rows > 1 && (self.at..self.back).all(|place| self.curve.value(place) == first);
        let evidence = evidence::away_and_back(rows);
        let unclear = Judged::possible(JumpCause::Unclear, evidence);
        if stands && first == self.curve.value(self.at - 1) {
            unclear.or(&[JumpCause::Frozen, JumpCause::OtherSource])
        } else if stands {
            unclear.or(&[JumpCause::ReplyAsPosition, JumpCause::OtherSource])
        } else if rows > 3 {
            unclear.or(&[JumpCause::OtherSource, JumpCause::Mechanical])
        } else {
            unclear.or(&[JumpCause::OtherSource, JumpCause::ReplyAsPosition, JumpCause::Mechanical])
        }
    }
}

/// A half or the data of a code, for people.
fn hex<const DIGITS: usize>(bits: i64) -> Hex<DIGITS> {
    Hex(u32::try_from(bits).unwrap_or(u32::MAX))
}
