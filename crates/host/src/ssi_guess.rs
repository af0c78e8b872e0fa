//! Which format the words of an SSI have, found from words of a shaft that moves.
//!
//! A format is struck off when words contradict it: a bit behind the field, a position of more than 24 bits, an even
//! number of ones. What is left is told apart by the motion: read in the wrong code a shaft jumps to and fro where in the
//! right one it moves smoothly, and read with too many bits it never stops between two positions. Without enough motion
//! several formats are left, and all of them are told.
//!
//! The words are those just before rising edges, which a delay of less than a clock period does not change.

use encoring_words::parameter::{Code, SsiValues};
use encoring_words::ssi_frame::{Level, MONO_PERIOD, REPETITION_PULSES, SsiCheck, SsiFormat};
use encoring_words::{Duration, Instant, Week};

/// Bits of a transfer that are kept.
const BITS_KEPT: u32 = 128;

/// Formats that are tried: 8 to 32 bits in both codes, AK-40, and repetition in both codes.
const FORMATS: usize = 2 * 25 + 1 + 2;

/// Data bits that a position has at most.
const POSITION_BITS: u32 = 24;

/// With so many clocks a repeated word is seen to be repeated.
const REPETITION_SEEN: u32 = REPETITION_PULSES as u32 + 1;

/// Fewer different words tell nothing of motion and parity.
const DIFFERENT_MIN: u32 = 20;

/// So many changes of speed by one step to and fro, and no bit behind the last one belongs to the position.
const ODD_MIN: u64 = 12;

/// By so many steps the speed of an even motion changes to and fro where it is seen in whole steps.
const WHOLE_STEPS: i64 = 2;

/// One word in so many may be disturbed.
const DISTURBED: u64 = 50;

/// A word as it was clocked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiWord {
    /// Its rising clock edges.
    pub clocks: u32,
    /// The level after each of them; the last one lowest, 128 at most.
    pub bits: u128,
    /// Data changed while the clock was Low, so that a receiver that takes them at the falling edge takes the bit before.
    pub is_late: bool,
}

impl SsiWord {
    /// The `number`-th bit, counted from 1.
    const fn bit(&self, number: u32) -> bool {
        match self.clocks.checked_sub(number) {
            Some(place) if place < u128::BITS => self.bits >> place & 1 == 1,
            _ => false,
        }
    }

    /// The first bits, as many as a field has.
    const fn field(&self, bits: u32) -> u32 {
        (self.bits >> self.clocks.saturating_sub(bits)) as u32 & u32::MAX >> (u32::BITS - bits)
    }

    /// Whether a bit after the first ones is High.
    const fn has_more_than(&self, bits: u32) -> bool {
        let behind = self.clocks.saturating_sub(bits);
        behind > 0 && self.bits & u128::MAX >> (u128::BITS - behind) != 0
    }
}

/// Takes the levels of clock and data and hands out the words, whatever their format. Words of more than 128 clocks are
/// left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct SsiWords {
    now: Instant,
    lines: Option<(Level, Level)>,
    train: Option<Train>,
}

#[derive(Clone, Copy, Debug)]
struct Train {
    word: SsiWord,
    /// Bits of it so far.
    taken: u32,
    fell: Instant,
}

impl Train {
    fn take(&mut self, data: Level) {
        if self.taken < self.word.clocks {
            self.taken = self.taken.saturating_add(1);
            self.word.bits = self.word.bits << 1 | u128::from(data.bit());
        }
    }
}

/// So long after the last falling edge the last bit is there, and data have not returned to High yet.
const SETTLED: Duration = Duration::from_micros(18);

impl SsiWords {
    /// From `now` on the lines show these levels; gives the word that has ended before.
    pub fn levels(&mut self, now: Instant, clock: Level, data: Level) -> Option<SsiWord> {
        let ended = self.time(now);
        let (clock_before, data_before) = self.lines.replace((clock, data))?;
        match (&mut self.train, clock_before, clock) {
            (Some(train), Level::High, Level::Low) => train.fell = now,
            (Some(train), Level::Low, Level::High) => {
                // What stood until this edge belongs to the edge before.
                train.take(data_before);
                train.word.clocks = train.word.clocks.saturating_add(1);
            }
            (Some(train), Level::Low, Level::Low) => train.word.is_late |= data_before != data,
            (None, Level::High, Level::Low) => {
                let word = SsiWord { clocks: 0, bits: 0, is_late: false };
                self.train = Some(Train { word, taken: 0, fell: now });
            }
            _ => {}
        }
        ended
    }

    /// Time has come to `now`; gives the word that has ended by then.
    pub fn time(&mut self, now: Instant) -> Option<SsiWord> {
        self.now = self.now.max(now);
        let train = self.train.as_mut()?;
        let since = self.now.since(train.fell);
        if since > SETTLED
            && let Some((_, data)) = self.lines
        {
            train.take(data);
        }
        if since <= MONO_PERIOD {
            return None;
        }
        let word = train.word;
        self.train = None;
        Some(word).filter(|word| (1..=BITS_KEPT).contains(&word.clocks))
    }
}

/// A format that may be the right one, and how it fares.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    format: SsiFormat,
    contradicted: u64,
    last: Option<u32>,
    speed: Option<i64>,
    /// How rough the motion is that it makes of the words: of every change of speed the number of bits. Single jumps, as
    /// where a position begins again at 0, count little.
    roughness: u64,
    /// The last small change of speed, and how many before it were each against the one before.
    change: i64,
    to_and_fro: u32,
    /// Changes of speed by one step, each against the one before: as an even motion has them that is seen in whole steps.
    odd: u64,
    /// The largest position.
    most: u32,
}

/// A format that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiFit {
    /// The format.
    pub format: SsiFormat,
    /// Bits at the beginning of the field that were always zero.
    pub leading_zeros: u32,
    /// Clocks behind the field.
    pub clocks_behind: u32,
}

/// Finds the format of words of equally many clocks.
#[derive(Clone, Copy, Debug)]
pub struct SsiGuess {
    clocks: u32,
    candidates: [Candidate; FORMATS],
    words: u64,
    /// A bit for each of 256 kinds of words that there was: so many different ones there were at least.
    seen: [u64; 4],
    late: u64,
    /// The last bit that was clocked was High in some word.
    last_bit: bool,
}

impl SsiGuess {
    /// For words of so many clocks; others are left out.
    #[must_use]
    pub fn new(clocks: u32) -> Self {
        let mut formats = formats();
        let candidates = core::array::from_fn(|_| {
            let format = formats.next().unwrap_or(AK40);
            Candidate {
                format,
                contradicted: 0,
                last: None,
                speed: None,
                roughness: 0,
                change: 0,
                to_and_fro: 0,
                odd: 0,
                most: 0,
            }
        });
        Self { clocks, candidates, words: 0, seen: [0; 4], late: 0, last_bit: false }
    }

    /// Takes a word; words must come in order of time.
    pub fn word(&mut self, word: SsiWord) {
        if word.clocks != self.clocks {
            return;
        }
        self.words = self.words.saturating_add(1);
        let kind = kind(word.bits);
        if let Some(kinds) = self.seen.get_mut(usize::from(kind / 64)) {
            *kinds |= 1 << (kind % 64);
        }
        self.late = self.late.saturating_add(u64::from(word.is_late));
        self.last_bit |= word.bits & 1 == 1;
        for candidate in &mut self.candidates {
            candidate.word(&word);
        }
    }

    /// How many words were looked at.
    #[must_use]
    pub const fn words(&self) -> u64 {
        self.words
    }

    /// There were enough different words to judge them by the motion.
    #[must_use]
    pub fn has_moved(&self) -> bool {
        self.seen.iter().map(|kinds| kinds.count_ones()).sum::<u32>() >= DIFFERENT_MIN
    }

    /// Data change while the clock is Low, in more than single words: only the rising edge reads them.
    #[must_use]
    pub const fn is_late(&self) -> bool {
        self.late * DISTURBED > self.words
    }

    /// The field may be longer than the clocks were many: the last bit that was clocked belongs to it.
    #[must_use]
    pub const fn may_be_longer(&self) -> bool {
        self.last_bit && self.clocks < 32
    }

    /// Every format that fits.
    pub fn fits(&self) -> impl Iterator<Item = SsiFit> + '_ {
        let fitting =
            self.possible().filter(|candidate| self.is_smooth(candidate) && !self.is_explained(candidate));
        fitting.map(|candidate| SsiFit {
            format: candidate.format,
            leading_zeros: candidate.leading_zeros(),
            clocks_behind: self.clocks.saturating_sub(u32::from(candidate.format.bits())),
        })
    }

    /// What no word contradicts, but for single ones that were disturbed.
    fn possible(&self) -> impl Iterator<Item = &Candidate> {
        self.candidates.iter().filter(|candidate| candidate.is_possible(self.clocks, self.words))
    }

    /// With as many bits the other code makes no much smoother motion.
    fn is_smooth(&self, candidate: &Candidate) -> bool {
        let alike = self.possible().filter(|other| other.format.bits() == candidate.format.bits());
        let least = alike.map(|other| other.roughness).min().unwrap_or(0);
        !self.has_moved() || candidate.roughness <= least.saturating_mul(3) / 2 + 40
    }

    /// Another format explains the words better: one with fewer bits behind which nothing ever comes, or one whose
    /// parity always holds.
    fn is_explained(&self, candidate: &Candidate) -> bool {
        let is_plain = candidate.format.check() == SsiCheck::None;
        is_plain
            && self.has_moved()
            && self.possible().any(|other| match other.format.check() {
                SsiCheck::None => {
                    other.format.bits() < candidate.format.bits()
                        && other.format.code() == candidate.format.code()
                        && other.odd >= ODD_MIN
                }
                SsiCheck::OddParity => {
                    candidate.format.bits() == other.format.bits()
                        && candidate.format.code() == other.format.code()
                        && self.is_smooth(other)
                }
                SsiCheck::Repetition => false,
            })
    }
}

impl Candidate {
    fn word(&mut self, word: &SsiWord) {
        let bits = u32::from(self.format.bits());
        if bits > word.clocks {
            return;
        }
        let field = word.field(bits);
        if self.is_contradicted(word, field) {
            self.contradicted = self.contradicted.saturating_add(1);
            return;
        }
        let position = self.format.position(field);
        self.most = self.most.max(position);
        let Some(last) = self.last.replace(position) else { return };
        let speed = i64::from(position) - i64::from(last);
        let Some(before) = self.speed.replace(speed) else { return };
        let change = speed - before;
        if change == 0 {
            return;
        }
        let bits = u64::BITS - change.unsigned_abs().leading_zeros();
        self.roughness = self.roughness.saturating_add(u64::from(bits));
        if change.abs() > WHOLE_STEPS {
            return;
        }
        let is_against = change.signum() != self.change.signum();
        self.to_and_fro = if is_against { self.to_and_fro.saturating_add(1) } else { 0 };
        self.odd = self.odd.saturating_add(u64::from(change % 2 != 0 && self.to_and_fro > 1));
        self.change = change;
    }

    /// Whether a word cannot be of this format.
    fn is_contradicted(&self, word: &SsiWord, field: u32) -> bool {
        let bits = u32::from(self.format.bits());
        let behind = match self.format.check() {
            SsiCheck::Repetition => (1..=word.clocks).any(|number| {
                let place = (number - 1) % u32::from(REPETITION_PULSES) + 1;
                word.bit(number) != (place <= bits && word.bit(place))
            }),
            SsiCheck::None | SsiCheck::OddParity => word.has_more_than(bits),
        };
        behind || !self.format.holds_parity(field) || self.format.position(field) >> POSITION_BITS != 0
    }

    fn is_possible(&self, clocks: u32, words: u64) -> bool {
        let bits = u32::from(self.format.bits());
        let is_seen = match self.format.check() {
            SsiCheck::None | SsiCheck::OddParity => true,
            SsiCheck::Repetition => clocks >= REPETITION_SEEN,
        };
        bits <= clocks && is_seen && self.contradicted.saturating_mul(DISTURBED) <= words
    }

    fn leading_zeros(&self) -> u32 {
        let bits = u32::from(self.format.bits()) - u32::from(self.format.check() == SsiCheck::OddParity);
        bits.saturating_sub(u32::BITS - self.most.leading_zeros())
    }
}

/// One of 256 numbers for a word, alike words far apart.
const fn kind(bits: u128) -> u8 {
    let folded = bits as u64 ^ (bits >> 64) as u64;
    (folded.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8
}

const AK40: SsiFormat =
    SsiFormat::new(SsiValues { repetition: false, code: Code::Binary, bits: 31 }, Week::AK40);

/// Every format there is: the old firmware has 31 plain bits.
fn formats() -> impl Iterator<Item = SsiFormat> {
    let old = Week::new(1, 1990).unwrap_or(Week::AK40);
    let values = move |repetition, code, bits| SsiFormat::new(SsiValues { repetition, code, bits }, old);
    let codes = [Code::Binary, Code::Gray];
    let plain = (8..=32).flat_map(move |bits| codes.into_iter().map(move |code| values(false, code, bits)));
    let repeated = codes.into_iter().map(move |code| values(true, code, 24));
    plain.chain([AK40]).chain(repeated)
}
