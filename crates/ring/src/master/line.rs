//! The two ends of the ring at the master: the frame that goes out, and what comes home of it.

use crate::crc::Crc;
use crate::frame::EndWord;
use crate::profile::{
    CHECK_TELEGRAMS, DEVICE_DELAY_BITS, DEVICES_MAX, LOOPBACK, STILL_TELEGRAMS, TELEGRAM_BITS,
};
use crate::sound_slot::SoundSlot;
use crate::telegram::{Bits, CycleKind, Decoder, Part, Pause, Step, byte_of, data_telegram};

/// The longest data phase: the loopback word, and a word for each device of an ID cycle.
const PHASE_BYTES_MAX: usize = 2 + 2 * DEVICES_MAX;

/// How a frame came home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Home {
    Good,
    Bad(Option<usize>),
    Silent,
}

/// The frame that goes out. Between frames it is as at the beginning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sender {
    bytes: [u8; PHASE_BYTES_MAX],
    length: usize,
    next: usize,
    cycle: CycleKind,
    crc: Crc,
}

impl Sender {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; PHASE_BYTES_MAX], length: 0, next: 0, cycle: CycleKind::Data, crc: Crc::NEW }
    }

    /// A new frame, with its loopback word.
    pub(super) fn compose(&mut self, cycle: CycleKind) {
        self.cycle = cycle;
        self.word(LOOPBACK);
    }

    /// Bytes of the data phase.
    pub(super) const fn length(&self) -> usize {
        self.length
    }

    /// The frame is over.
    pub(super) fn clear(&mut self) {
        self.bytes.get_mut(..self.length).unwrap_or_default().fill(0);
        let Self { bytes: _, length, next, cycle, crc } = self;
        (*length, *next, *cycle, *crc) = (0, 0, CycleKind::Data, Crc::NEW);
    }

    /// The next telegram; `None` once the frame is whole, or broken off because nothing comes home.
    pub(super) fn next(&mut self, still: bool, devices: usize) -> Option<Bits> {
        let at = self.next;
        self.next += 1;
        if let Some(byte) = self.bytes.get(..self.length).and_then(|bytes| bytes.get(at)) {
            self.crc.push(*byte);
            return Some(Bits::telegram(data_telegram(self.cycle, Part::Data, *byte)));
        }
        // What has come home by now lags behind by the delay of the devices.
        let needs = STILL_TELEGRAMS * TELEGRAM_BITS as usize + DEVICE_DELAY_BITS as usize * devices;
        if still && self.length * TELEGRAM_BITS as usize >= needs {
            return None;
        }
        let (part, byte) = match at - self.length {
            0 => (Part::CheckHigh, (self.crc.word() >> 8) as u8),
            1 => (Part::CheckLow, self.crc.word() as u8),
            2 => (Part::EndHigh, 0),
            k if k < usize::from(CHECK_TELEGRAMS) => (Part::EndLow, 0),
            _ => return None,
        };
        Some(Bits::telegram(data_telegram(self.cycle, part, byte)))
    }

    pub(super) fn byte(&mut self, byte: u8) {
        debug_assert!(self.length < PHASE_BYTES_MAX, "a table holds no more than a ring can have");
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
    }

    pub(super) fn word(&mut self, word: u16) {
        for byte in word.to_be_bytes() {
            self.byte(byte);
        }
    }
}

/// What comes home. Between frames all but its decoder is as at the beginning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Receiver {
    decoder: Decoder,
    pub(super) bytes: [u8; PHASE_BYTES_MAX],
    count: usize,
    crc: Crc,
    check_word: u16,
    end_word: u16,
    /// How many frames began; after one that was lost another may seem to.
    opened: u8,
    /// The line stood still while the first telegrams should have come.
    still: bool,
    pieces: usize,
    /// The frame came to its end; what the pause behind it brings no longer counts.
    closed: Option<Closed>,
}

/// How a frame came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Closed {
    cycle: CycleKind,
    bad: bool,
}

impl Receiver {
    pub(super) fn new() -> Self {
        Self {
            decoder: Decoder::default(),
            bytes: [0; PHASE_BYTES_MAX],
            count: 0,
            crc: Crc::NEW,
            check_word: 0,
            end_word: 0,
            opened: 0,
            still: false,
            pieces: 0,
            closed: None,
        }
    }

    /// The line stood still while the first telegrams should have come.
    pub(super) const fn is_still(&self) -> bool {
        self.still
    }

    /// The slot is over.
    pub(super) fn clear(&mut self) {
        let used = self.count.min(PHASE_BYTES_MAX);
        self.bytes.get_mut(..used).unwrap_or_default().fill(0);
        self.count = 0;
        self.crc = Crc::NEW;
        self.check_word = 0;
        self.end_word = 0;
        self.opened = 0;
        self.still = false;
        self.pieces = 0;
        self.closed = None;
    }

    /// The next telegram may open a frame.
    pub(super) fn is_ready(&self) -> bool {
        self.decoder.is_ready()
    }

    /// What a sound slot leaves behind.
    pub(super) const fn take(&mut self, slot: &SoundSlot) {
        self.decoder = slot.decoder;
    }

    pub(super) fn receive(&mut self, line: Bits) {
        if self.pieces < STILL_TELEGRAMS {
            let all = u64::MAX >> (64 - line.count.clamp(1, 64));
            self.still = (self.pieces == 0 || self.still) && (line.bits == 0 || line.bits == all);
        }
        self.pieces += 1;
        if line.count == TELEGRAM_BITS as u32
            && let Some((part, opens)) = self.decoder.telegram(line.bits as u16)
        {
            if opens {
                self.opens();
            }
            self.end(part, byte_of(line.bits as u16));
            return;
        }
        self.pause(line);
    }

    pub(super) fn pause(&mut self, line: Bits) {
        match self.decoder.pause(line) {
            Some(Pause::Closing) => return self.close(),
            Some(_) => return,
            None => {}
        }
        for k in (0..line.count.min(64)).rev() {
            match self.decoder.clock(line.bits >> k & 1 != 0) {
                Step::Opens(_) => self.opens(),
                Step::Ends(part, byte) => self.end(part, byte),
                Step::Closes => self.close(),
                _ => {}
            }
        }
    }

    pub(super) fn opens(&mut self) {
        if self.closed.is_none() {
            self.opened = self.opened.saturating_add(1);
        }
    }

    pub(super) fn close(&mut self) {
        let closed = Closed { cycle: self.decoder.cycle(), bad: self.decoder.is_bad() };
        self.closed.get_or_insert(closed);
    }

    pub(super) fn end(&mut self, part: Part, byte: u8) {
        if self.closed.is_some() {
            return;
        }
        match part {
            Part::Data => {
                self.crc.push(byte);
                if let Some(place) = self.bytes.get_mut(self.count) {
                    *place = byte;
                }
                self.count += 1;
            }
            Part::CheckHigh | Part::CheckLow => self.check_word = self.check_word << 8 | u16::from(byte),
            Part::EndHigh | Part::EndLow => self.end_word = self.end_word << 8 | u16::from(byte),
        }
    }

    /// Judges the frame. `last` is the number of the segment that leads home.
    pub(super) fn judge(&self, cycle: CycleKind, length: usize, last: usize) -> Home {
        if self.still {
            return Home::Silent;
        }
        let Some(Closed { cycle: came, bad }) = self.closed else { return Home::Bad(None) };
        let segment_bad = bad || self.crc.word() != self.check_word;
        match EndWord::decode(self.end_word) {
            // A frame of another length was lost on the way and found again in the wrong place, or its check phase
            // was; what such a one tells is not looked at.
            _ if self.opened != 1 || came != cycle || self.count != length => Home::Bad(None),
            EndWord::Bad { position } if usize::from(position) < last => {
                Home::Bad(Some(usize::from(position)))
            }
            EndWord::Good if segment_bad => Home::Bad(Some(last)),
            EndWord::Good => Home::Good,
            _ => Home::Bad(None),
        }
    }

    /// A word by its number.
    pub(super) fn word(&self, index: usize) -> Option<u16> {
        self.word_at(2 * index)
    }

    /// The word that begins at a byte.
    pub(super) fn word_at(&self, at: usize) -> Option<u16> {
        let bytes = self.bytes.get(..self.count)?.get(at..at + 2)?;
        Some(u16::from_be_bytes(bytes.try_into().ok()?))
    }
}
