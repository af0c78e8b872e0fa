//! How an SSI is clocked, seen from its lines: periods, pauses, and how long the data take to go back to High.

use encoring_words::ssi_frame::Level;
use encoring_words::{Duration, Instant};

use crate::ssi_receiver::SsiTransfer;

/// The shortest and the longest of something, and how often it was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    /// The shortest.
    pub shortest: Duration,
    /// The longest.
    pub longest: Duration,
    /// How many there were.
    pub count: u64,
}

impl Spread {
    fn with(spread: Option<Self>, next: Duration) -> Self {
        let Self { shortest, longest, count } =
            spread.unwrap_or(Self { shortest: next, longest: next, count: 0 });
        Self { shortest: shortest.min(next), longest: longest.max(next), count: count.saturating_add(1) }
    }
}

/// The timing of an SSI so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SsiTimings {
    /// From one falling clock edge to the next within a transfer: the shortest and the longest of each transfer.
    pub period: Option<Spread>,
    /// From the last falling clock edge of a transfer to the first of the next.
    pub pause: Option<Spread>,
    /// From the last falling clock edge to the data's return to High: t_M, and what cable and encoder add.
    pub mono: Option<Spread>,
    clock: Option<Level>,
    data: Option<Level>,
    fell: Option<Instant>,
    ended: Option<Instant>,
    /// Time within transfers, and periods in it.
    clocked: Duration,
    periods: u64,
}

impl SsiTimings {
    /// From `now` on the lines show these levels.
    #[inline]
    pub fn levels(&mut self, now: Instant, clock: Level, data: Level) {
        let clock_before = self.clock.replace(clock);
        if clock_before == Some(Level::High) && clock == Level::Low {
            self.fell = Some(now);
        }
        let data_before = self.data.replace(data);
        // Within a train data change with clock edges; without one they only go back to rest.
        let returns = data_before == Some(Level::Low) && data == Level::High && clock_before == Some(clock);
        if let Some(fell) = self.fell.filter(|_| returns) {
            let since = now.since(fell);
            if is_mono(since) {
                self.mono = Some(Spread::with(self.mono, since));
            }
        }
    }

    /// A transfer has ended.
    pub fn transfer(&mut self, transfer: &SsiTransfer) {
        if let Some(ended) = self.ended.replace(transfer.ended) {
            self.pause = Some(Spread::with(self.pause, transfer.began.since(ended)));
        }
        let Some((shortest, longest)) = transfer.periods else { return };
        self.period = Some(Spread::with(Some(Spread::with(self.period, shortest)), longest));
        self.clocked = self.clocked + transfer.ended.since(transfer.began);
        self.periods = self.periods.saturating_add(u64::from(transfer.clocks.saturating_sub(1)));
    }

    /// The mean clock rate within transfers in hertz, rounded.
    #[must_use]
    pub fn clock_hz(&self) -> Option<u64> {
        let clocked = self.clocked.as_nanos();
        let periods = u128::from(self.periods) * 1_000_000_000 + u128::from(clocked / 2);
        u64::try_from(periods.checked_div(u128::from(clocked))?).ok()
    }
}

/// Shorter is a late bit of the train, longer something else.
fn is_mono(since: Duration) -> bool {
    (Duration::from_micros(10)..Duration::from_micros(100)).contains(&since)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ssi_receiver::{SsiReceiver, TakenAt};
    use encoring_words::Week;
    use encoring_words::parameter::SsiValues;
    use encoring_words::ssi_frame::{SsiFormat, SsiFrame};

    #[test]
    fn periods_pauses_and_the_mono_period_are_those_that_were_drawn() {
        let format = SsiFormat::new(SsiValues::from_data(0x18), Week::AK40);
        let mut receiver = SsiReceiver::new(format, TakenAt::Falling);
        let mut timings = SsiTimings::default();
        let mut tell = |at: u64, clock: Level, data: Level| {
            if let Some(transfer) = receiver.levels(Instant(at), clock, data) {
                timings.transfer(&transfer);
            }
            timings.levels(Instant(at), clock, data);
        };
        let frame = SsiFrame::new(0x27_0F, format);
        tell(0, Level::High, Level::High);
        for (start, half) in [(100_000, 1_000), (200_000, 1_250)] {
            for pulse in 1..=25 {
                let at = start + 2 * half * u64::from(pulse - 1);
                tell(at, Level::Low, frame.level(pulse - 1));
                tell(at + half, Level::High, frame.level(pulse));
            }
            tell(start + 48 * half + 20_500, Level::High, Level::High);
        }
        tell(400_000, Level::High, Level::High);
        let spread = |shortest, longest, count| {
            Some(Spread { shortest: Duration(shortest), longest: Duration(longest), count })
        };
        assert_eq!(timings.period, spread(2_000, 2_500, 4));
        assert_eq!(timings.pause, spread(52_000, 52_000, 1));
        assert_eq!(timings.mono, spread(20_500, 20_500, 2));
        assert_eq!(timings.clock_hz(), Some(444_444));
    }
}
