//! What is compared: normal mode, first requests, pairs of requests. Each part is cut into chunks that any thread
//! can take.

use crate::couple::{Couple, Tally};
use crate::reading::{Book, Sensor, Service};

const WRITE: u32 = 0xC000_0000;
const READ: u32 = 0x8000_0000;
const DATA_CHECK: u32 = 0x8800_0000;
const UNKNOWN: u32 = 0x8F00_0000;

/// Something to prove of one encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Every word with service bit 0, to a new encoder.
    Normal,
    /// Every word with service bit 0, to a programmed encoder with an error pending.
    NormalProgrammed,
    /// Every word with service bit 1, as the first request of a new encoder.
    Requests,
    /// Those of them that lie at a boundary, and every `STRIDE`-th.
    DenseRequests,
    /// Every service, read and written, with boundary values, twice in a row, from every state of the error latch.
    /// Where no fault is latched, a second time with the supply off and on after them.
    Pairs,
}

impl Part {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal mode",
            Self::NormalProgrammed => "normal mode, programmed",
            Self::Requests => "first requests",
            Self::DenseRequests => "first requests, dense",
            Self::Pairs => "pairs of requests",
        }
    }

    /// How many chunks it has.
    pub(crate) fn chunks(self, book: &Book) -> u32 {
        match self {
            Self::Normal | Self::NormalProgrammed => (1 << 31) / NORMAL_CHUNK,
            Self::Requests => (1 << 31) / REQUEST_CHUNK,
            Self::DenseRequests => UPPER_BYTES * DENSE_CUTS,
            Self::Pairs => States::of(book).count() * pair_words(book).len() as u32,
        }
    }

    /// Compares one chunk; gives the number of words, requests or pairs in it.
    pub(crate) fn compare(self, book: &Book, chunk: u32, tally: &mut Tally) -> u64 {
        match self {
            Self::Normal => normal(Couple::new(book, place(book, chunk), tally), chunk, tally),
            Self::NormalProgrammed => {
                let mut couple = programmed(book, place(book, chunk), tally);
                couple.service(UNKNOWN, tally);
                normal(couple, chunk, tally)
            }
            Self::Requests => {
                let first = READ + chunk * REQUEST_CHUNK;
                requests(book, chunk, first..=first + (REQUEST_CHUNK - 1), tally)
            }
            Self::DenseRequests => {
                let (upper, cut) = (chunk / DENSE_CUTS, chunk % DENSE_CUTS);
                let words = dense_data(book, cut).map(|data| READ | upper << 24 | data);
                requests(book, chunk, words, tally)
            }
            Self::Pairs => pairs(book, chunk, tally),
        }
    }
}

/// Where shaft or magnet are while chunks are compared, in turn.
fn place(book: &Book, turn: u32) -> i64 {
    const SHAFT: [i64; 5] = [-12_345, 5, 8_000_000, -8_388_607, 4_095];
    const ROD: [i64; 5] = [123_456, 500_000, 1, 499_999, 250_007];
    let places = match book.sensor {
        Sensor::Shaft { .. } => SHAFT,
        Sensor::Rod { .. } => ROD,
    };
    places.into_iter().cycle().nth(turn as usize % 5).unwrap_or(0)
}

const NORMAL_CHUNK: u32 = 1 << 20;
const NORMAL_BLOCK: u32 = 1 << 12;

fn normal(mut couple: Couple<'_>, chunk: u32, tally: &mut Tally) -> u64 {
    let book = couple.book;
    let first = chunk * NORMAL_CHUNK;
    for block in 0..NORMAL_CHUNK / NORMAL_BLOCK {
        // A walk over the whole range of the sensor, twice as far on a shaft as it can tell apart without counting.
        let walk = i64::from(chunk) * 7_919 + i64::from(block) * 104_729;
        couple.sample(match book.sensor {
            Sensor::Shaft { .. } => walk % (1 << 26) - (1 << 25),
            Sensor::Rod { um } => walk % (um as i64 + 1),
        });
        let first = first + block * NORMAL_BLOCK;
        couple.step(first, tally);
        // What lies between two samples is not seen.
        couple.tell(place(book, block));
        couple.normal(first + 1..first + NORMAL_BLOCK, tally);
    }
    couple.wear(tally);
    couple.everything(tally);
    u64::from(NORMAL_CHUNK)
}

const REQUEST_CHUNK: u32 = 1 << 18;

fn requests(book: &Book, turn: u32, words: impl IntoIterator<Item = u32>, tally: &mut Tally) -> u64 {
    let mut couple = Couple::new(book, place(book, turn), tally);
    let mut count = 0;
    for request in words {
        couple.take_back();
        couple.service(request, tally);
        couple.wear(tally);
        couple.service(DATA_CHECK, tally);
        couple.wear(tally);
        couple.service(READ | request & 0x0F00_0000, tally);
        count += 1;
    }
    count
}

/// Bits 30..24 of a word.
const UPPER_BYTES: u32 = 1 << 7;
/// Into so many chunks the data of one upper byte are cut.
const DENSE_CUTS: u32 = 8;
const STRIDE: u32 = 101;

/// The data of one of the cuts: everything around the limits of the manuals, and a stride through the rest.
fn dense_data(book: &Book, cut: u32) -> impl Iterator<Item = u32> {
    let (low, middle, high) = (0..0x1_0200, 0x1_0200..0xFF_FF00, 0xFF_FF00..0x100_0000);
    let stride = middle.clone().step_by(STRIDE as usize);
    let mut limits: Vec<u32> = (0..24).flat_map(|bit| around(1 << bit)).collect();
    limits.extend(book.services.iter().flat_map(limits_of));
    limits.retain(|data| middle.contains(data) && !(data - middle.start).is_multiple_of(STRIDE));
    limits.sort_unstable();
    limits.dedup();
    low.chain(stride).chain(high).chain(limits).skip(cut as usize).step_by(DENSE_CUTS as usize)
}

/// A value with its neighbours.
fn around(value: u32) -> impl Iterator<Item = u32> {
    (value.saturating_sub(1)..=value.saturating_add(1)).filter(|value| *value < 1 << 24)
}

/// The limits of a service and what lies beside them.
fn limits_of(service: &Service) -> Vec<u32> {
    match *service {
        Service::Parameter { low, high, factory, .. } => {
            [low, high, factory].into_iter().flat_map(around).collect()
        }
        _ => Vec::new(),
    }
}

/// Values that the programmed encoder of `programmed` makes into limits.
const MEASURING_LENGTH: u32 = 3_499;
const TURNS: (u32, u32) = (35, 10);

/// An encoder that somebody has programmed: 1000 steps a turn over 3.5 turns, falling, in Gray code where there is
/// one, with a preset from before.
fn programmed<'a>(book: &'a Book, place: i64, tally: &mut Tally) -> Couple<'a> {
    let mut couple = Couple::new(book, place, tally);
    let writes = [
        (6, 0x12_3456),
        (1, if matches!(book.services[1], Service::Parameter { high: 1, .. }) { 1 } else { 0x0101 }),
        (2, MEASURING_LENGTH),
        (3, TURNS.0),
        (9, TURNS.1),
        (4, 1_000),
        (5, MEASURING_LENGTH),
        (0xD, 0x00_011F),
    ];
    for (number, data) in writes {
        couple.service(WRITE | number << 24 | data, tally);
    }
    // What is unknown to this encoder has set the error bit; the check clears it.
    couple.service(DATA_CHECK, tally);
    couple.state = format!("programmed, at {place}");
    couple.mark();
    couple
}

/// Faults that can be latched: 2^0 by a memory that cannot be read, 2^1, 2^2, 2^3 and 2^7 by requests.
const FAULTS: [u32; 5] = [0x8200_0000, 0xC200_0000, 0xC800_0000, 0x8600_0000, UNKNOWN];
/// Every set of them.
const FAULT_SETS: u32 = 1 << FAULTS.len();

/// The states of the error latch that pairs begin with: new or programmed, then one of these, then every set of faults.
#[derive(Clone, Copy, Debug)]
enum Beginning {
    Plain,
    /// N = 0 has been written and put right: 2^13 is latched, and no value is wrong any more.
    NumeratorPutRight,
    /// N = 0 stands, and the check has found it.
    NumeratorZero,
    /// The magnet was away.
    MagnetBack,
    MagnetAway,
}

struct States {
    beginnings: &'static [Beginning],
}

impl States {
    fn of(book: &Book) -> Self {
        use Beginning::{MagnetAway, MagnetBack, NumeratorPutRight, NumeratorZero, Plain};
        let beginnings: &[Beginning] = match book.sensor {
            Sensor::Shaft { .. } => &[Plain, NumeratorPutRight, NumeratorZero],
            Sensor::Rod { .. } => &[Plain, MagnetBack, MagnetAway],
        };
        Self { beginnings }
    }

    fn count(&self) -> u32 {
        2 * self.beginnings.len() as u32 * FAULT_SETS
    }

    fn is_without_faults(state: u32) -> bool {
        state.is_multiple_of(FAULT_SETS)
    }

    fn build<'a>(&self, book: &'a Book, state: u32, tally: &mut Tally) -> Couple<'a> {
        let (faults, rest) = (state % FAULT_SETS, state / FAULT_SETS);
        let mut couple = match rest % 2 {
            0 => Couple::new(book, place(book, 0), tally),
            _ => programmed(book, place(book, 0), tally),
        };
        let beginning = self.beginnings.get(rest as usize / 2).copied().unwrap_or(Beginning::Plain);
        match beginning {
            Beginning::Plain => {}
            Beginning::NumeratorPutRight => {
                let numerator = if rest.is_multiple_of(2) { 4096 } else { TURNS.0 };
                couple.service(0xC300_0000, tally);
                couple.service(0xC300_0000 | numerator, tally);
            }
            Beginning::NumeratorZero => {
                couple.service(0xC300_0000, tally);
                couple.service(DATA_CHECK, tally);
            }
            Beginning::MagnetBack | Beginning::MagnetAway => {
                couple.take_magnet_away(true);
                couple.step(0, tally);
                couple.take_magnet_away(matches!(beginning, Beginning::MagnetAway));
                couple.step(0, tally);
            }
        }
        for (fault, request) in (0_u32..).zip(FAULTS).filter(|(fault, _)| faults >> fault & 1 == 1) {
            couple.break_memory(fault == 0);
            couple.service(request, tally);
            couple.break_memory(false);
        }
        couple.state = format!("{}, {beginning:?}, faults {faults:05b}", couple.state);
        couple.mark();
        couple
    }
}

/// Every service, read and written, with the values that matter to it.
fn pair_words(book: &Book) -> Vec<u32> {
    let mut words = Vec::new();
    for (number, service) in (0_u32..).zip(&book.services) {
        words.extend([0, 0xFF_FFFF].map(|data| READ | number << 24 | data));
        let mut data = vec![0, 1, 0x12_3456, 0xFF_FFFF];
        data.extend(limits_of(service));
        match service {
            Service::Unknown | Service::DataCheck => {}
            Service::PresetAdjustment(_) => data.extend(around(MEASURING_LENGTH)),
            Service::Parameter { .. } => {
                data.extend(around(MEASURING_LENGTH));
                data.extend([TURNS.0, TURNS.1, 0x0100, 0x0101, 0x1_0008, 0x1_0118, 0x0_FF1F]);
                // One step more than 3.5 turns of the sensor have, and than the factory's 4096.
                data.extend([0x37FF, 0x3800, 0x6FFF, 0x7000, 4095, 2047, 2048]);
            }
        }
        data.sort_unstable();
        data.dedup();
        words.extend(data.into_iter().map(|data| WRITE | number << 24 | data));
    }
    words
}

fn pairs(book: &Book, chunk: u32, tally: &mut Tally) -> u64 {
    let words = pair_words(book);
    let (state, first) = (chunk / words.len() as u32, chunk as usize % words.len());
    let mut couple = States::of(book).build(book, state, tally);
    let first = words.get(first).copied().unwrap_or(DATA_CHECK);
    for second in &words {
        couple.take_back();
        couple.service(first, tally);
        couple.service(*second, tally);
        couple.wear(tally);
        couple.service(DATA_CHECK, tally);
        couple.wear(tally);
        couple.service(DATA_CHECK, tally);
        couple.service(READ | first & 0x0F00_0000, tally);
        couple.service(READ | second & 0x0F00_0000, tally);
    }
    if States::is_without_faults(state) {
        // Nothing of the error latch survives without supply: once is enough.
        for second in &words {
            couple.take_back();
            couple.service(first, tally);
            couple.service(*second, tally);
            couple.power_cycle(*second, tally);
            couple.service(DATA_CHECK, tally);
            couple.service(READ | first & 0x0F00_0000, tally);
            couple.service(READ | second & 0x0F00_0000, tally);
        }
    }
    words.len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::{BOOKS, Effect, Layout, Limit};

    /// A small sample of every part.
    fn sample(book: &Book) -> Tally {
        let mut tally = Tally::default();
        for upper in 0..UPPER_BYTES {
            let data = [0, 1, 2, 0xF, 0x10, 0x20, 0x21, 0x63, 0x64, 0x118, 0x1_0000, 0x12_3456, 0xFF_FFFF];
            requests(book, upper, data.map(|data| READ | upper << 24 | data), &mut tally);
        }
        let chunks = Part::Pairs.chunks(book);
        for chunk in (0..chunks).step_by(chunks as usize / 60) {
            pairs(book, chunk, &mut tally);
        }
        let mut couple = programmed(book, place(book, 1), &mut tally);
        couple.sample(place(book, 4));
        couple.step(0x7FFF_FFFF, &mut tally);
        couple.normal(0..4_096, &mut tally);
        couple.everything(&mut tally);
        tally
    }

    #[test]
    fn the_device_does_what_the_manuals_say() {
        for book in &BOOKS {
            let tally = sample(book);
            assert_eq!(tally.failed, 0, "{:#?}", tally.differences);
            assert!(tally.passed > 10_000, "{}: {}", book.name, tally.passed);
        }
    }

    #[test]
    fn a_wrong_reading_is_seen() {
        type Slip = (&'static str, usize, fn(&mut Book));
        let slips: [Slip; 13] = [
            ("a status bit too many", 0, |book| book.status_mask |= 1 << 1),
            ("a lower limit", 0, |book| change(book, 2, |low, _, _| *low -= 1)),
            ("a length of rod", 0, |book| book.sensor = Sensor::Rod { um: 500_010 }),
            ("when a value is used", 0, |book| book.effect = Effect::AfterDataCheck),
            ("a status bit too few", 1, |book| book.status_mask ^= 1 << 8),
            ("an upper limit", 1, |book| change(book, 9, |_, high, _| *high += 1)),
            ("an upper limit of preset values", 1, |book| change(book, 4, |_, high, _| *high -= 1)),
            ("a lower limit", 2, |book| change(book, 2, |low, _, _| *low += 1)),
            ("an upper limit of SSI bits", 2, |book| change(book, 0xD, |_, high, _| *high += 1)),
            ("a layout", 2, |book| change(book, 0xD, |_, _, layout| *layout = Layout::Plain)),
            ("a service that is none", 3, |book| book.services[0xB] = Service::DataCheck),
            ("a preset beyond the measuring length", 3, |book| {
                book.services[6] = Service::PresetAdjustment(Limit::To(0xFF_FFFF));
            }),
            ("steps per turn", 3, |book| book.sensor = Sensor::Shaft { steps_per_turn: 4096 }),
        ];
        for (slip, book, make) in slips {
            let mut wrong = BOOKS[book];
            make(&mut wrong);
            assert!(sample(&wrong).failed > 0, "{slip} of {} was not seen", wrong.name);
        }
    }

    #[test]
    fn a_difference_is_told_with_its_words() {
        let wrong = Book { status_mask: 0, ..BOOKS[1] };
        let mut tally = Tally::default();
        requests(&wrong, 0, [0x8000_0000], &mut tally);
        let told = tally.differences.first().unwrap();
        assert_eq!(told.model, "ce-100-m");
        assert_eq!(told.words, [0x8000_0000, 0xFFFF_FFFF, 0, 0x8800_0000]);
        assert_eq!((told.expected.as_str(), told.got.as_str()), ("88000000", "88000080"));
    }

    fn change(book: &mut Book, number: usize, change: impl FnOnce(&mut u32, &mut u32, &mut Layout)) {
        match &mut book.services[number] {
            Service::Parameter { low, high, layout, .. } => change(low, high, layout),
            other => panic!("service {number} is {other:?}"),
        }
    }
}
