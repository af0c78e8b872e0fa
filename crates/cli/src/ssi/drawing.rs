//! A transfer as a timing figure.

use encoring_figure::{Lane, LaneLevel, TimingFigure};
use encoring_words::ssi_frame::{Level, MONO_PERIOD, SsiFormat, SsiFrame};

/// Half a clock period of the figure: 500 kHz.
pub(super) const HALF_PERIOD_NS: u64 = 1_000;

/// Pixels of a clock period.
const PERIOD_PIXELS: u32 = 26;

/// What is put out of a position during so many clocks. The figure begins with the lines at rest, half a period before the first
/// falling edge, and ends when they are at rest again.
pub(super) fn pulses(title: &str, position: u32, format: SsiFormat, clocks: u32) -> TimingFigure {
    let frame = SsiFrame::new(position, format);
    let fall = |pulse: u32| (2 * u64::from(pulse) - 1) * HALF_PERIOD_NS;
    let rise = |pulse: u32| 2 * u64::from(pulse) * HALF_PERIOD_NS;
    let rest = fall(clocks) + MONO_PERIOD.as_nanos();
    let until = rest + 2 * HALF_PERIOD_NS;
    let periods = u32::try_from(until / (2 * HALF_PERIOD_NS)).unwrap_or(u32::MAX);
    let mut figure = TimingFigure::new(title, 0, until).width(periods.saturating_mul(PERIOD_PIXELS));
    let mut clock = Lane::levels("clock", LaneLevel::High);
    let mut data = Lane::levels("data", LaneLevel::High);
    let mut bits = Lane::words("bit");
    for pulse in 1..=clocks {
        clock.change(fall(pulse), LaneLevel::Low);
        clock.change(rise(pulse), LaneLevel::High);
        let high = frame.level(pulse) == Level::High;
        data.change(rise(pulse), high.into());
        let end = if pulse == clocks { rest } else { rise(pulse + 1) };
        bits.word(rise(pulse), end, if high { "1" } else { "0" });
    }
    data.change(rest, LaneLevel::High);
    for lane in [clock, data, bits] {
        figure.lane(lane);
    }
    figure
        .mark(fall(1), "the first falling edge latches the position; data stays High until the clock rises");
    figure.mark(rise(1), "the first rising edge puts out the first bit of the field");
    figure.mark(rise(u32::from(format.bits())), "the last bit of the field");
    figure.mark(rest, "20 us after the last falling edge: the transfer is over, data is High");
    figure
}
