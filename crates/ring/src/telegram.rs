//! Telegrams: how a byte or a pause stands on the line, and how a receiver finds its place in them.
//!
//! A data telegram has 13 bits, a status telegram 5 [A2, A3]. Outside of a frame a receiver looks for each telegram
//! anew. Inside it counts: telegrams follow without a gap, so a bit that was hit costs the cycle and not the place.

use crate::profile::{
    CHECK_TELEGRAMS, DATA_CR, DATA_SL, DATA_TELEGRAM, FRAME_LOST_AFTER, STATUS_BEFORE_FRAME, STATUS_BITS,
    STATUS_TELEGRAM, TELEGRAM_BITS,
};

/// Which of the two cycles a telegram belongs to: its bit SL.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CycleKind {
    /// Data.
    #[default]
    Data,
    /// Identification.
    Id,
}

/// Which part of a frame a telegram belongs to: its bit CR, counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Loopback word and user data.
    Data,
    /// High byte of the check word.
    CheckHigh,
    /// Low byte of the check word.
    CheckLow,
    /// High byte of the end word.
    EndHigh,
    /// Low byte of the end word.
    EndLow,
}

/// The bits of a data telegram, the first one highest.
#[must_use]
pub const fn data_telegram(cycle: CycleKind, part: Part, byte: u8) -> u16 {
    header(cycle, part) | (byte as u16) << 1
}

/// A telegram without its byte.
const fn header(cycle: CycleKind, part: Part) -> u16 {
    let sl = match cycle {
        CycleKind::Data => 0,
        CycleKind::Id => DATA_SL,
    };
    let cr = match part {
        Part::Data => 0,
        _ => DATA_CR,
    };
    DATA_TELEGRAM | sl | cr
}

/// The byte of a data telegram.
#[must_use]
pub const fn byte_of(telegram: u16) -> u8 {
    (telegram >> 1) as u8
}

/// Bits of the status telegram behind a frame that close it: up to its FL bit, all but the stop bit.
pub(crate) const CLOSING_BITS: u32 = STATUS_BITS as u32 - 1;

/// Up to twelve status telegrams one after the other, the first bit highest.
#[must_use]
pub const fn statuses(count: u32) -> Bits {
    let mut bits = 0;
    let mut left = if count > 12 { 12 } else { count };
    let length = left * STATUS_BITS as u32;
    while left > 0 {
        bits = bits << STATUS_BITS | STATUS_TELEGRAM as u64;
        left -= 1;
    }
    Bits { bits, count: length }
}

/// A few line bits, the first one highest and the last one lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bits {
    /// The bits; those above `count` are 0.
    pub bits: u64,
    /// How many, up to 64.
    pub count: u32,
}

impl Bits {
    /// A data telegram.
    #[must_use]
    pub const fn telegram(telegram: u16) -> Self {
        Self { bits: telegram as u64, count: TELEGRAM_BITS as u32 }
    }

    /// A silent line.
    #[must_use]
    pub const fn idle(count: u32) -> Self {
        let count = if count > 64 { 64 } else { count };
        Self { bits: mask(count), count }
    }
}

/// So many ones, up to 64.
const fn mask(count: u32) -> u64 {
    match count {
        0 => 0,
        1..=63 => u64::MAX >> (64 - count),
        _ => u64::MAX,
    }
}

/// What one bit was, to whoever has to put the next one on his own line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// No telegram.
    Quiet,
    /// No telegram any more, where one was to be: the place in the frame or among the status telegrams is lost.
    Broken,
    /// Start bit, SL, CR or FL.
    Header,
    /// The FL bit with which a frame begins.
    Opens(CycleKind),
    /// The FL bit of the status telegram behind a frame, which says that the frame has no further telegram.
    Closes,
    /// One of the eight data bits, the first one is number 0.
    Data(Part, u8),
    /// The stop bit of a data telegram with this byte.
    Ends(Part, u8),
    /// The stop bit of a sound status telegram.
    Status,
}

/// A receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decoder {
    state: State,
    /// The bit of the telegram that comes next.
    index: u8,
    /// Header and data bits so far.
    bits: u16,
    /// Sound status telegrams in a row.
    statuses: u8,
    cycle: CycleKind,
    /// Telegrams of the check phase that have begun.
    check: u8,
    /// Telegrams in a row with a wrong header or stop bit.
    faulty: u8,
    /// The present telegram is one of them.
    wrong: bool,
    /// The frame has had one.
    bad: bool,
    /// How far the frame came.
    end: End,
}

/// How far a frame came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Not to its last telegram.
    Open,
    /// To its last telegram; now a status telegram must follow.
    Due,
    /// A status telegram followed: it had neither too few nor too many telegrams.
    Whole,
}

/// Where a receiver stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// It waits for a 1.
    Lost,
    /// It waits for a start bit.
    Waiting,
    /// In a telegram outside of a frame.
    Loose,
    /// In a frame.
    Framed,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            state: State::Lost,
            index: 0,
            bits: 0,
            statuses: 0,
            cycle: CycleKind::Data,
            check: 0,
            faulty: 0,
            wrong: false,
            bad: false,
            end: End::Open,
        }
    }
}

impl Decoder {
    /// Takes one bit of the line.
    pub fn clock(&mut self, rx: bool) -> Step {
        match self.state {
            State::Lost => {
                if rx {
                    self.state = State::Waiting;
                }
                Step::Quiet
            }
            State::Waiting if rx => {
                // A gap: what comes after it is a new row of status telegrams.
                self.statuses = 0;
                if self.miss_end() { Step::Broken } else { Step::Quiet }
            }
            State::Waiting => {
                self.state = State::Loose;
                self.index = 1;
                self.bits = 0;
                Step::Header
            }
            State::Loose => self.loose(rx),
            State::Framed => self.framed(rx),
        }
    }

    fn loose(&mut self, rx: bool) -> Step {
        match self.index {
            1 | 2 => {
                self.bits = self.bits << 1 | u16::from(rx);
                self.index += 1;
                Step::Header
            }
            3 if !rx => {
                self.index = 4;
                if self.end == End::Due {
                    self.end = End::Whole;
                    return Step::Closes;
                }
                Step::Header
            }
            3 if self.statuses >= STATUS_BEFORE_FRAME => {
                let cycle = if self.bits & 2 == 0 { CycleKind::Data } else { CycleKind::Id };
                self.open(cycle);
                self.wrong = self.bits & 1 != 0;
                self.bits = 0;
                self.index = 4;
                Step::Opens(cycle)
            }
            4 if rx && self.bits == 0 => {
                self.statuses = self.statuses.saturating_add(1);
                self.state = State::Waiting;
                Step::Status
            }
            _ => {
                self.lose(rx);
                Step::Broken
            }
        }
    }

    fn open(&mut self, cycle: CycleKind) {
        self.state = State::Framed;
        self.statuses = 0;
        self.cycle = cycle;
        self.check = 0;
        self.faulty = 0;
        self.wrong = false;
        self.bad = false;
        self.end = End::Open;
    }

    fn lose(&mut self, rx: bool) {
        let _ = self.miss_end();
        self.state = if rx { State::Waiting } else { State::Lost };
        self.statuses = 0;
        self.index = 0;
    }

    /// What follows a frame is no status telegram; `true` if there was one that it should follow.
    fn miss_end(&mut self) -> bool {
        let was_due = self.end == End::Due;
        if was_due {
            self.end = End::Open;
            self.bad = true;
        }
        was_due
    }

    fn framed(&mut self, rx: bool) -> Step {
        let index = self.index;
        self.index += 1;
        match index {
            0 => {
                self.wrong = rx;
                self.bits = u16::from(rx);
                Step::Header
            }
            1 => {
                self.wrong |= rx != (self.cycle == CycleKind::Id);
                self.bits = self.bits << 1 | u16::from(rx);
                Step::Header
            }
            2 => {
                // A check phase that has begun goes on, whatever the bit says.
                if rx || self.check > 0 {
                    self.wrong |= !rx;
                    self.check += 1;
                }
                self.bits = self.bits << 1 | u16::from(rx);
                Step::Header
            }
            3 => {
                self.wrong |= !rx;
                self.bits = 0;
                Step::Header
            }
            4..=11 => {
                self.bits = self.bits << 1 | u16::from(rx);
                Step::Data(self.part(), index - 4)
            }
            _ => {
                self.wrong |= !rx;
                let part = self.part();
                self.end(rx);
                Step::Ends(part, self.bits as u8)
            }
        }
    }

    /// The end of a data telegram.
    fn end(&mut self, stop: bool) {
        self.index = 0;
        if self.wrong {
            self.bad = true;
            self.faulty = self.faulty.saturating_add(1);
        } else {
            self.faulty = 0;
        }
        self.wrong = false;
        if self.check >= CHECK_TELEGRAMS {
            self.lose(stop);
            if stop {
                self.end = End::Due;
            }
        } else if self.check == 0 && self.faulty >= FRAME_LOST_AFTER {
            self.lose(stop);
        }
    }

    const fn part(&self) -> Part {
        match self.check {
            0 => Part::Data,
            1 => Part::CheckHigh,
            2 => Part::CheckLow,
            3 => Part::EndHigh,
            _ => Part::EndLow,
        }
    }

    /// Takes a whole data telegram, if that is what comes next and its header and stop bit are right: the same as its
    /// 13 bits through [`Decoder::clock`], in one step. Otherwise nothing happens.
    pub(crate) fn telegram(&mut self, telegram: u16) -> Option<(Part, bool)> {
        if self.data(telegram) {
            return Some((Part::Data, false));
        }
        let rest = telegram & !(0xFF << 1);
        let opens = match self.state {
            State::Framed if self.index == 0 => false,
            _ if self.is_ready() => true,
            _ => return None,
        };
        if opens {
            if rest & !DATA_SL != DATA_TELEGRAM {
                return None;
            }
            self.open(if rest & DATA_SL == 0 { CycleKind::Data } else { CycleKind::Id });
        } else {
            if rest != header(self.cycle, Part::CheckHigh) {
                return None;
            }
            self.check += 1;
        }
        let part = self.part();
        self.bits = u16::from(byte_of(telegram));
        self.end(true);
        Some((part, opens))
    }

    /// Takes one more telegram of the data phase, if that is what comes next and its header and stop bit are right.
    /// Otherwise nothing happens.
    pub(crate) fn data(&mut self, telegram: u16) -> bool {
        let is_next = self.state == State::Framed && self.index == 0 && self.check == 0;
        let is_data = is_next && telegram & !(0xFF << 1) == header(self.cycle, Part::Data);
        if is_data {
            self.bits = u16::from(byte_of(telegram));
            self.faulty = 0;
        }
        is_data
    }

    /// Takes a run of status telegrams or of silence, if that is what comes next: the same as each bit through
    /// [`Decoder::clock`]. Otherwise nothing happens.
    pub(crate) fn pause(&mut self, line: Bits) -> Option<Pause> {
        if self.state != State::Waiting {
            return None;
        }
        let due = self.end == End::Due;
        if line.bits == mask(line.count) && !due {
            if line.count > 0 {
                self.statuses = 0;
            }
            return Some(Pause::Silence);
        }
        let telegrams = line.count / STATUS_BITS as u32;
        if line != statuses(telegrams) || telegrams == 0 {
            return None;
        }
        self.statuses = self.statuses.saturating_add(telegrams as u8);
        self.bits = 0;
        self.index = STATUS_BITS as u8 - 1;
        if due {
            self.end = End::Whole;
        }
        Some(if due { Pause::Closing } else { Pause::Statuses })
    }

    /// The part of the frame that is passing, or that has just passed; `None` outside of a frame.
    #[must_use]
    pub fn passing(&self) -> Option<Part> {
        (self.is_framed() || self.end == End::Due).then(|| self.part())
    }

    /// The cycle of the present frame, or of the last one.
    #[must_use]
    pub const fn cycle(&self) -> CycleKind {
        self.cycle
    }

    /// A header or stop bit of the frame was wrong, up to now.
    #[must_use]
    pub const fn is_bad(&self) -> bool {
        self.bad || self.wrong
    }

    /// The frame had all its telegrams and no more.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.end == End::Whole
    }

    /// The next telegram may open a frame.
    pub(crate) fn is_ready(&self) -> bool {
        self.state == State::Waiting && self.statuses >= STATUS_BEFORE_FRAME
    }

    /// What a sound data frame and so many status telegrams behind it leave behind.
    pub(crate) fn after_data(statuses: u64) -> Self {
        Self {
            state: State::Waiting,
            index: STATUS_BITS as u8 - 1,
            bits: 0,
            statuses: u8::try_from(statuses).unwrap_or(u8::MAX),
            cycle: CycleKind::Data,
            check: CHECK_TELEGRAMS,
            faulty: 0,
            wrong: false,
            bad: false,
            end: End::Whole,
        }
    }

    /// In a frame, or after so many status telegrams in a row that one may begin.
    #[must_use]
    pub fn is_in_step(&self) -> bool {
        self.is_framed() || self.end == End::Due || self.statuses >= STATUS_BEFORE_FRAME
    }

    /// In a frame.
    #[must_use]
    pub fn is_framed(&self) -> bool {
        self.state == State::Framed
    }
}

/// What a run of bits outside of a frame was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pause {
    Silence,
    Statuses,
    /// Status telegrams, the first of which closed the frame.
    Closing,
}

#[cfg(test)]
#[expect(clippy::unusual_byte_groupings, reason = "telegrams are written in their parts")]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// The bits of pieces, in order.
    fn line(pieces: &[Bits]) -> Vec<bool> {
        let bits = |piece: &Bits| {
            let Bits { bits, count } = *piece;
            (0..count).rev().map(move |k| bits >> k & 1 != 0)
        };
        pieces.iter().flat_map(bits).collect()
    }

    fn frame(cycle: CycleKind, bytes: &[u8]) -> Vec<Bits> {
        let mut pieces = Vec::from([Bits::idle(3), statuses(3)]);
        pieces.extend(bytes.iter().map(|byte| Bits::telegram(data_telegram(cycle, Part::Data, *byte))));
        for (part, byte) in [(Part::CheckHigh, 1), (Part::CheckLow, 2), (Part::EndHigh, 3), (Part::EndLow, 4)]
        {
            pieces.push(Bits::telegram(data_telegram(cycle, part, byte)));
        }
        pieces.push(statuses(4));
        pieces
    }

    fn ends(decoder: &mut Decoder, line: &[bool]) -> Vec<(Part, u8)> {
        let steps = line.iter().map(|bit| decoder.clock(*bit));
        steps
            .filter_map(|step| if let Step::Ends(part, byte) = step { Some((part, byte)) } else { None })
            .collect()
    }

    // [R7]
    #[test]
    fn a_byte_stands_between_start_and_stop_with_its_highest_bit_first() {
        assert_eq!(data_telegram(CycleKind::Data, Part::Data, 0xA1), 0b0001_1010_0001_1);
        assert_eq!(data_telegram(CycleKind::Id, Part::Data, 0), 0b0101_0000_0000_1);
        assert_eq!(data_telegram(CycleKind::Data, Part::EndLow, 0), 0b0011_0000_0000_1);
        for byte in 0..=255 {
            assert_eq!(byte_of(data_telegram(CycleKind::Id, Part::CheckHigh, byte)), byte);
        }
        assert_eq!(statuses(2), Bits { bits: 0b00001_00001, count: 10 });
    }

    #[test]
    fn a_frame_is_read_byte_by_byte() {
        for cycle in [CycleKind::Data, CycleKind::Id] {
            let mut decoder = Decoder::default();
            let line = line(&frame(cycle, &[0xE3, 0xA5, 0, 0xFF]));
            let mut expected = Vec::from([0xE3, 0xA5, 0, 0xFF].map(|byte| (Part::Data, byte)));
            expected.extend([
                (Part::CheckHigh, 1),
                (Part::CheckLow, 2),
                (Part::EndHigh, 3),
                (Part::EndLow, 4),
            ]);
            assert_eq!(ends(&mut decoder, &line), expected);
            assert!(decoder.is_whole() && !decoder.is_bad() && !decoder.is_framed());
            assert_eq!(decoder.cycle(), cycle);
        }
    }

    #[test]
    fn every_wrong_bit_of_a_header_or_a_stop_is_noticed_and_the_place_is_kept() {
        let pieces = frame(CycleKind::Data, &[0xE3, 0xA5, 0, 0xFF]);
        let sound = line(&pieces);
        let begin = 3 + 15;
        for telegram in 1..8 {
            for bit in [0, 1, 2, 3, 12] {
                let mut line = sound.clone();
                line[begin + 13 * telegram + bit] ^= true;
                let mut decoder = Decoder::default();
                let read = ends(&mut decoder, &line);
                assert!(decoder.is_bad(), "telegram {telegram} bit {bit}");
                assert!(!decoder.is_framed());
                // A missing first CR makes the frame one telegram longer, an early one makes it shorter.
                if bit != 2 {
                    assert_eq!(read.len(), 8, "telegram {telegram} bit {bit}");
                }
            }
        }
    }

    #[test]
    fn a_frame_that_breaks_off_is_left_within_four_telegrams() {
        for rest in [Bits::idle(40), statuses(12), Bits { bits: 0, count: 64 }] {
            let mut pieces = frame(CycleKind::Data, &[1, 2, 3, 4]);
            pieces.truncate(4);
            pieces.extend([rest; 2]);
            let mut decoder = Decoder::default();
            ends(&mut decoder, &line(&pieces));
            assert!(!decoder.is_framed() && decoder.is_bad() && !decoder.is_whole());
        }
    }

    #[test]
    fn a_frame_begins_only_after_status_telegrams() {
        let telegram = Bits::telegram(data_telegram(CycleKind::Data, Part::Data, 0));
        for (count, begins) in [(0, false), (1, false), (2, true)] {
            let mut decoder = Decoder::default();
            let steps: Vec<Step> = line(&[Bits::idle(2), statuses(count), telegram])
                .iter()
                .map(|bit| decoder.clock(*bit))
                .collect();
            assert_eq!(steps.contains(&Step::Opens(CycleKind::Data)), begins, "{count}");
        }
    }
}
