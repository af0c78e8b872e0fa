//! Which of several lines are the clock and the data of an SSI, by what they do.
//!
//! A clock rests High and comes in trains whose Low phases are shorter than the mono period. Data change once for a rising
//! clock edge at most, and go back to High by themselves when the mono period is over; how late they come after the edge
//! does not matter, so a long cable does not either.

#[cfg(test)]
mod tests;

use encoring_words::ssi_frame::MONO_PERIOD;
use encoring_words::{Duration, Instant};

/// Lines that are compared: those of the analysers in use.
pub const SSI_LINES_MAX: usize = 32;

/// Falling edges that a clock has at least: those of the shortest transfer.
const FALLS_MIN: u32 = 8;

/// One in so many edges may be a disturbance.
const DISTURBED: u32 = 20;

/// Between the mono period and its measured length so much may lie.
const MONO_SLACK: Duration = Duration::from_micros(2);

/// What a number of lines has done so far.
#[derive(Clone, Debug)]
pub struct SsiLines {
    lines: [Line; SSI_LINES_MAX],
    count: usize,
    high: u64,
    now: Option<Instant>,
    /// `[clock][data]`: edges of the data line without a rising edge of the clock line since the one before.
    unasked: [[u32; SSI_LINES_MAX]; SSI_LINES_MAX],
    /// `[data]`: bit `clock` is set when that line has risen since the last edge of the data line.
    risen: [u32; SSI_LINES_MAX],
}

#[derive(Clone, Copy, Debug, Default)]
struct Line {
    edges: u32,
    falls: u32,
    /// Phases shorter than the mono period.
    short_lows: u32,
    short_highs: u32,
    /// High phases longer than that, and Low ones.
    rests_high: u32,
    rests_low: u32,
    changed: Instant,
    fell: Option<Instant>,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinesFound {
    /// These two, and no others fit.
    Pair {
        /// The number of the clock line, from 0.
        clock: usize,
        /// The number of the data line.
        data: usize,
    },
    /// A clock, and data that never change: the only other line.
    StuckData {
        /// The number of the clock line.
        clock: usize,
        /// The number of the data line.
        data: usize,
    },
    /// No line has trains of pulses as a clock has.
    NoClock,
    /// A line has such pulses and rests Low: it is the other wire of the pair, or inverted.
    InvertedClock {
        /// The number of the line.
        clock: usize,
    },
    /// Several pairs fit.
    Several,
    /// A clock, and no line that follows it.
    NoData {
        /// The number of the clock line.
        clock: usize,
    },
}

impl SsiLines {
    /// So many lines, of which nothing is known yet; the first [`SSI_LINES_MAX`] are looked at.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self {
            lines: [Line::default(); SSI_LINES_MAX],
            count: count.min(SSI_LINES_MAX),
            high: 0,
            now: None,
            unasked: [[0; SSI_LINES_MAX]; SSI_LINES_MAX],
            risen: [u32::MAX; SSI_LINES_MAX],
        }
    }

    /// From `now` on line k is High if bit k is 1.
    pub fn levels(&mut self, now: Instant, high: u64) {
        let changed = self.high ^ high;
        self.high = high;
        if self.now.replace(now).is_none() {
            for line in &mut self.lines {
                line.changed = now;
            }
            return;
        }
        let of = |bits: u64, line: usize| bits >> line & 1 == 1;
        for (number, line) in self.lines.iter_mut().enumerate().take(self.count) {
            if of(changed, number) {
                line.edge(now, of(high, number));
            }
        }
        // A clock edge in the same moment counts as before the data's.
        let rising = (changed & high) as u32;
        for (data, risen) in self.risen.iter_mut().enumerate().take(self.count) {
            *risen |= rising & !(1 << data);
            if !of(changed, data) {
                continue;
            }
            for (clock, unasked) in self.unasked.iter_mut().enumerate().take(self.count) {
                let fell = self.lines.get(clock).and_then(|line| line.fell);
                let is_return =
                    of(high, data) && fell.is_some_and(|fell| now.since(fell) + MONO_SLACK > MONO_PERIOD);
                let is_asked = of(u64::from(*risen), clock);
                if let Some(count) = unasked.get_mut(data).filter(|_| !is_asked && !is_return) {
                    *count = count.saturating_add(1);
                }
            }
            *risen = 0;
        }
    }

    fn line(&self, number: usize) -> Line {
        self.lines.get(number).copied().unwrap_or_default()
    }

    /// What the lines are, as far as they were told.
    #[must_use]
    pub fn found(&self) -> LinesFound {
        let numbers = || 0..self.count;
        let is_clock = |number: &usize| self.line(*number).is_clock();
        let follows = |clock: usize, data: usize| {
            let line = self.line(data);
            let unasked = self.unasked.get(clock).and_then(|row| row.get(data)).copied().unwrap_or_default();
            data != clock && line.edges > 0 && unasked.saturating_mul(DISTURBED) <= line.edges
        };
        let pairs = || numbers().filter(is_clock).flat_map(|clock| numbers().map(move |data| (clock, data)));
        let mut fitting = pairs().filter(|(clock, data)| follows(*clock, *data));
        match (fitting.next(), fitting.next()) {
            (Some((clock, data)), None) => return LinesFound::Pair { clock, data },
            (Some(_), Some(_)) => return LinesFound::Several,
            (None, _) => {}
        }
        let Some(clock) = numbers().find(is_clock) else {
            let inverted = numbers().find(|number| self.line(*number).is_inverted_clock());
            return inverted.map_or(LinesFound::NoClock, |clock| LinesFound::InvertedClock { clock });
        };
        let mut others = numbers().filter(|number| *number != clock);
        match (others.next(), others.next()) {
            (Some(data), None) if self.line(data).edges == 0 => LinesFound::StuckData { clock, data },
            _ => LinesFound::NoData { clock },
        }
    }
}

impl Line {
    fn edge(&mut self, now: Instant, rises: bool) {
        let lasted = now.since(self.changed);
        let is_long = lasted > MONO_PERIOD;
        if rises {
            self.short_lows = self.short_lows.saturating_add(u32::from(!is_long));
            self.rests_low = self.rests_low.saturating_add(u32::from(is_long));
        } else {
            self.short_highs = self.short_highs.saturating_add(u32::from(!is_long));
            self.rests_high = self.rests_high.saturating_add(u32::from(is_long));
            self.falls = self.falls.saturating_add(1);
            self.fell = Some(now);
        }
        self.edges = self.edges.saturating_add(1);
        self.changed = now;
    }

    const fn is_clock(&self) -> bool {
        let lows = self.rests_low.saturating_add(self.short_lows);
        self.falls >= FALLS_MIN
            && self.rests_low.saturating_mul(DISTURBED) <= lows
            && !self.is_inverted_clock()
    }

    const fn is_inverted_clock(&self) -> bool {
        self.short_highs >= FALLS_MIN && self.rests_low > self.rests_high
    }
}
