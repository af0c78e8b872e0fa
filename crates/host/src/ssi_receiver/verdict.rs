//! What is wrong with a transfer, if anything is.

use core::fmt;

use encoring_words::Duration;
use encoring_words::ssi_frame::{CLOCK_HZ_LIMIT, Level, SsiCheck, SsiFormat};

use super::{Beginning, Ending, Running, SsiTransfer};

/// Data bits that a position can have: those of the bus.
const POSITION_BITS: u8 = 24;

/// Half of the longest period: a Low phase beyond it belongs to a clock that is too slow, unless it is very uneven.
const LONGEST_HALF: Duration = Duration::from_nanos(500_000_000 / CLOCK_HZ_LIMIT.0 as u64);

/// A pause that is no pause, but the period of a clock that is too slow.
const NO_PAUSE: Duration = Duration::from_nanos(2_000_000_000 / CLOCK_HZ_LIMIT.0 as u64);

/// What is wrong with a transfer. If several things are, the first of these is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SsiFault {
    /// Its beginning or its end was not seen.
    Cut,
    /// Data+ was Low where it rests High: no supply, a broken wire, or the two wires of the pair exchanged.
    StuckLow,
    /// Data+ never went Low where it must: a broken wire, or no encoder.
    StuckHigh,
    /// The clock was slower than about 50 kHz, so that the transfer broke, or faster than about 1.1 MHz [R111, R112].
    ClockLimit,
    /// Too few clocks for the field, or other ones than expected.
    Clocks,
    /// The word was not the same again [R119].
    Repetition,
    /// The number of ones is even [R117].
    Parity,
    /// Data+ was High after the field [R110].
    TrailingHigh,
}

/// Every fault, in the order in which they are told.
pub const SSI_FAULTS: [SsiFault; 8] = [
    SsiFault::Cut,
    SsiFault::StuckLow,
    SsiFault::StuckHigh,
    SsiFault::ClockLimit,
    SsiFault::Clocks,
    SsiFault::Repetition,
    SsiFault::Parity,
    SsiFault::TrailingHigh,
];

impl SsiFault {
    /// Its name in output and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cut => "cut",
            Self::StuckLow => "stuck_low",
            Self::StuckHigh => "stuck_high",
            Self::ClockLimit => "clock_limit",
            Self::Clocks => "clocks",
            Self::Repetition => "repetition",
            Self::Parity => "parity",
            Self::TrailingHigh => "trailing_high",
        }
    }
}

impl fmt::Display for SsiFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A transfer that is over.
pub(super) fn transfer(
    running: &Running,
    format: SsiFormat,
    expected: Option<u32>,
    ending: Ending,
) -> SsiTransfer {
    let bits = format.bits();
    SsiTransfer {
        began: running.began,
        ended: running.fell,
        clocks: running.clocks,
        field: running.taken.field,
        received: u8::try_from(running.taken.bits).map_or(bits, |received| received.min(bits)),
        periods: running.periods,
        fault: fault(running, format, expected, ending),
        format,
    }
}

fn fault(running: &Running, format: SsiFormat, expected: Option<u32>, ending: Ending) -> Option<SsiFault> {
    let taken = &running.taken;
    let short = taken.bits < u32::from(format.bits());
    let unfinished = short || expected.is_some_and(|clocks| running.clocks < clocks);
    let whole = running.beginning == Beginning::Seen && ending == Ending::Seen;
    let odd = !short && !format.holds_parity(taken.field);
    let found = [
        (SsiFault::Cut, running.beginning == Beginning::Missed || unfinished && !whole),
        // Within a word that broke, Data+ may be Low before a clock for that.
        (SsiFault::StuckLow, taken.rest == Some(Level::Low) && !(short && goes_on(running))),
        (SsiFault::StuckHigh, !short && !taken.low && is_never_all_ones(running, format)),
        (SsiFault::ClockLimit, is_too_fast(running) || short && is_too_slow(running)),
        (SsiFault::Clocks, short || expected.is_some_and(|clocks| running.clocks != clocks)),
        (SsiFault::Repetition, taken.unlike),
        (SsiFault::Parity, odd),
        (SsiFault::TrailingHigh, taken.trailing_high),
    ];
    found.into_iter().find_map(|(fault, is_so)| is_so.then_some(fault))
}

/// `true` if no encoder sends only ones with so many clocks: a Low bit would have had to come after the field, or within
/// it. Where the field is all that was clocked, all ones may be a position.
const fn is_never_all_ones(running: &Running, format: SsiFormat) -> bool {
    let longer = running.taken.bits > format.bits() as u32;
    longer || format.bits() > POSITION_BITS || matches!(format.check(), SsiCheck::OddParity)
}

/// By the mean of all periods: single ones are only as exact as the times that were told.
fn is_too_fast(running: &Running) -> bool {
    let (_, highest_hz) = CLOCK_HZ_LIMIT;
    let periods = u128::from(running.falls.saturating_sub(1));
    let span = u128::from(running.fell.since(running.began).as_nanos());
    periods * 1_000_000_000 > span * u128::from(highest_hz)
}

/// Of a transfer that broke off.
fn is_too_slow(running: &Running) -> bool {
    running.longest_low > LONGEST_HALF || goes_on(running)
}

/// It follows the transfer before as a clock that is too slow follows the clock before.
fn goes_on(running: &Running) -> bool {
    running.pause.is_some_and(|pause| pause <= NO_PAUSE)
}
