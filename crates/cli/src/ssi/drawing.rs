//! A transfer, edge by edge, and as a timing figure.

use encoring_figure::{Lane, LaneLevel, TimingFigure};
use encoring_words::ssi_frame::{Level, MONO_PERIOD, SsiFormat, SsiFrame};

/// Pixels of a clock period.
const PERIOD_PIXELS: u64 = 26;

/// What is sent of a position, and how it is clocked.
#[derive(Clone, Copy)]
pub(super) struct Transfer {
    frame: SsiFrame,
    format: SsiFormat,
    clocks: u32,
    /// Half a clock period.
    half_ns: u64,
    /// From a rising edge to the data at the receiver.
    delay_ns: u64,
}

impl Transfer {
    pub(super) fn new(position: u32, format: SsiFormat, clocks: u32, hz: u64, delay_ns: u64) -> Self {
        let half_ns = 500_000_000 / hz.max(1);
        Self { frame: SsiFrame::new(position, format), format, clocks, half_ns, delay_ns }
    }

    /// The lines are at rest for half a period before the first falling edge.
    fn fall(&self, pulse: u32) -> u64 {
        (2 * u64::from(pulse) - 1) * self.half_ns
    }

    fn rise(&self, pulse: u32) -> u64 {
        2 * u64::from(pulse) * self.half_ns
    }

    /// When data go back to High.
    fn rest(&self) -> u64 {
        self.fall(self.clocks) + MONO_PERIOD.as_nanos() + self.delay_ns
    }

    fn bit(&self, pulse: u32) -> char {
        if self.frame.level(pulse) == Level::High { '1' } else { '0' }
    }

    /// The field.
    pub(super) fn field(&self) -> String {
        (1..=u32::from(self.format.bits())).map(|pulse| self.bit(pulse)).collect()
    }

    /// The level after each rising edge, once it is there.
    pub(super) fn line(&self) -> String {
        (1..=self.clocks).map(|pulse| self.bit(pulse)).collect()
    }

    /// What stands on the line just before a moment: the bit of the last rising edge that has come through by then, the
    /// High of rest before.
    fn taken(&self, at: u64) -> char {
        let passed = at.saturating_sub(self.delay_ns + 1) / (2 * self.half_ns);
        self.bit(u32::try_from(passed).unwrap_or(u32::MAX).min(self.clocks))
    }

    /// What a receiver takes at each rising edge.
    pub(super) fn rising(&self) -> String {
        (1..=self.clocks).map(|pulse| self.taken(self.rise(pulse))).collect()
    }

    /// What a receiver takes at each falling edge.
    pub(super) fn falling(&self) -> String {
        (1..=self.clocks).map(|pulse| self.taken(self.fall(pulse))).collect()
    }

    /// The lines over time, as a terminal shows them.
    pub(super) fn text(&self) -> String {
        self.figure("").text(self.half_ns)
    }

    /// The lines over time, what receivers take at both edges, and where to look.
    pub(super) fn svg(&self, title: &str) -> String {
        let mut figure = self.figure(title);
        type Edge = fn(&Transfer, u32) -> u64;
        let edges: [(&str, String, Edge); 2] =
            [("at falling", self.falling(), Self::fall), ("at rising", self.rising(), Self::rise)];
        for (name, taken, edge) in edges {
            let mut lane = Lane::words(name);
            for (bit, pulse) in taken.chars().zip(1..) {
                lane.word(edge(self, pulse), edge(self, pulse) + 2 * self.half_ns, bit);
            }
            figure.lane(lane);
        }
        figure.mark(
            self.fall(1),
            "the first falling edge latches the position; data stay High until the clock rises",
        );
        figure.mark(self.rise(1), "the first rising edge puts out the first bit of the field");
        if self.delay_ns > 0 {
            figure.mark(
                self.rise(1) + self.delay_ns,
                format!("{} ns later it is at the receiver", self.delay_ns),
            );
        }
        let bits = u32::from(self.format.bits());
        if bits <= self.clocks {
            figure.mark(self.rise(bits), "the last bit of the field");
        } else {
            let missing = bits - self.clocks;
            figure.mark(
                self.rise(self.clocks),
                format!("the last clock: {missing} bits of the field are not put out"),
            );
        }
        figure.mark(self.rest(), "20 us after the last falling edge: the transfer is over, data are High");
        figure.svg()
    }

    fn figure(&self, title: &str) -> TimingFigure {
        let until = self.rest() + 2 * self.half_ns;
        let width = until / (2 * self.half_ns) * PERIOD_PIXELS;
        let mut figure = TimingFigure::new(title, 0, until).width(u32::try_from(width).unwrap_or(u32::MAX));
        let mut clock = Lane::levels("clock", LaneLevel::High);
        let mut data = Lane::levels("data", LaneLevel::High);
        let mut bits = Lane::words("bit");
        for pulse in 1..=self.clocks {
            clock.change(self.fall(pulse), LaneLevel::Low);
            clock.change(self.rise(pulse), LaneLevel::High);
            let (from, bit) = (self.rise(pulse) + self.delay_ns, self.bit(pulse));
            data.change(from, (bit == '1').into());
            let end = if pulse == self.clocks { self.rest() } else { self.rise(pulse + 1) + self.delay_ns };
            bits.word(from, end, bit);
        }
        data.change(self.rest(), LaneLevel::High);
        for lane in [clock, data, bits] {
            figure.lane(lane);
        }
        figure
    }
}
