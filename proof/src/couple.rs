//! The device and the reading side by side: the same words to both, and every answer compared.

use crate::device::Device;
use crate::reading::{Book, Reading};

/// One answer that is not what the manuals say.
#[derive(Clone, Debug)]
pub(crate) struct Difference {
    pub(crate) model: &'static str,
    /// The encoder before the first of the words.
    pub(crate) state: String,
    /// The OUT words, the last of which was answered wrongly.
    pub(crate) words: Vec<u32>,
    pub(crate) expected: String,
    pub(crate) got: String,
}

/// How many differences are kept to be shown.
pub(crate) const SHOWN: usize = 10;

/// What has been compared.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) passed: u64,
    pub(crate) failed: u64,
    pub(crate) differences: Vec<Difference>,
}

impl Tally {
    pub(crate) fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.differences.extend(other.differences);
        self.differences.truncate(SHOWN);
    }

    #[cold]
    fn fail(&mut self, difference: impl FnOnce() -> Difference) {
        self.failed += 1;
        if self.differences.len() < SHOWN {
            self.differences.push(difference());
        }
    }
}

/// A device, and what the manuals say of it.
#[derive(Clone)]
pub(crate) struct Couple<'a> {
    pub(crate) book: &'a Book,
    device: Device,
    reading: Reading<'a>,
    start: Reading<'a>,
    /// The words since `mark` or `take_back`.
    words: Vec<u32>,
    pub(crate) state: String,
}

impl<'a> Couple<'a> {
    /// A new encoder that has seen one exchange with 0.
    pub(crate) fn new(book: &'a Book, place: i64, tally: &mut Tally) -> Self {
        let reading = Reading::new(book, place);
        let device = Device::new(book, place);
        let state = format!("new, at {place}");
        let mut couple = Self { book, device, reading, start: reading, words: Vec::new(), state };
        couple.step(0, tally);
        couple.mark();
        couple
    }

    /// One exchange.
    #[inline]
    pub(crate) fn step(&mut self, out: u32, tally: &mut Tally) {
        self.words.push(out);
        let expected = self.reading.exchange(out);
        let got = self.device.exchange(out);
        if expected == got {
            tally.passed += 1;
        } else {
            tally.fail(|| self.difference(format!("{expected:08X}"), format!("{got:08X}")));
        }
    }

    /// A request, the same reply while it stands although the rest of the word changes, and its end.
    #[inline]
    pub(crate) fn service(&mut self, request: u32, tally: &mut Tally) {
        self.step(request, tally);
        self.step(request ^ 0x7FFF_FFFF, tally);
        self.step(request & 0x7FFF_FFFF, tally);
    }

    /// Whether the memory was written by what has been done since the last time this was asked.
    #[inline]
    pub(crate) fn wear(&mut self, tally: &mut Tally) {
        let (expected, got) = (self.reading.memory_was_written(), self.device.memory_was_written());
        if expected == got {
            tally.passed += 1;
        } else {
            let told = |written| if written { "the memory written" } else { "the memory not written" };
            tally.fail(|| self.difference(told(expected).to_owned(), told(got).to_owned()));
        }
    }

    /// Many normal-mode words at one place; the answers must not depend on the words.
    pub(crate) fn normal(&mut self, words: std::ops::Range<u32>, tally: &mut Tally) {
        let mut same = 0;
        let expected = self.reading.exchange(words.start);
        for out in words {
            let got = self.device.exchange(out);
            if got == expected {
                same += 1;
            } else {
                self.words.push(out);
                tally.fail(|| self.difference(format!("{expected:08X}"), format!("{got:08X}")));
                self.words.pop();
            }
        }
        tally.passed += same;
    }

    /// Every parameter read, then the data check twice.
    pub(crate) fn everything(&mut self, tally: &mut Tally) {
        for number in 0..16 {
            self.service(0x8000_0000 | number << 24, tally);
        }
        for _ in 0..2 {
            self.service(0x8800_0000, tally);
        }
    }

    /// Shaft or magnet come here, and a sample is taken.
    pub(crate) fn sample(&mut self, place: i64) {
        self.device.sample(place);
        self.reading.sample(place);
    }

    /// Shaft or magnet come here, and no sample is taken.
    pub(crate) fn tell(&mut self, place: i64) {
        self.device.tell(place);
    }

    pub(crate) fn take_magnet_away(&mut self, away: bool) {
        self.device.take_magnet_away(away);
        self.reading.take_magnet_away(away);
    }

    pub(crate) fn break_memory(&mut self, unreadable: bool) {
        self.device.break_memory(unreadable);
        self.reading.break_memory(unreadable);
    }

    /// Off and on, with a service bit that still stands from before.
    pub(crate) fn power_cycle(&mut self, stale: u32, tally: &mut Tally) {
        self.device.power_cycle();
        self.reading.power_cycle();
        self.step(stale, tally);
        self.step(0, tally);
    }

    /// From here `take_back` starts over.
    pub(crate) fn mark(&mut self) {
        self.device.mark();
        let _ = self.reading.memory_was_written();
        self.start = self.reading;
        self.words.clear();
    }

    #[inline]
    pub(crate) fn take_back(&mut self) {
        self.device.take_back();
        self.reading = self.start;
        self.words.clear();
    }

    fn difference(&self, expected: String, got: String) -> Difference {
        let (model, state, words) = (self.book.name, self.state.clone(), self.words.clone());
        Difference { model, state, words, expected, got }
    }
}
