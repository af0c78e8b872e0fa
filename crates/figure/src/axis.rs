//! A span of time as a line with ticks.

use crate::svg::{Anchor, Stroke, Svg, Tenths};

/// Ticks that an axis has at most, and pixels that each of them needs.
const TICKS_MAX: u64 = 12;
const TICK: u64 = 60;

/// Where a time stands from left to right. Times are nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) from: u64,
    pub(crate) to: u64,
    /// Where it begins, and how long it is, in pixels.
    pub(crate) left: i64,
    pub(crate) width: i64,
}

impl Axis {
    /// The place of a time; one outside stands at the nearer end.
    pub(crate) fn x(&self, time: u64) -> Tenths {
        let span = u128::from(self.to.saturating_sub(self.from).max(1));
        let passed = u128::from(time.clamp(self.from, self.to.max(self.from)) - self.from);
        let tenths = passed * (self.width.unsigned_abs() as u128 * 10) / span;
        Tenths(self.left * 10 + tenths as i64)
    }

    /// Nanoseconds from tick to tick: 1, 2 or 5 times a power of ten.
    fn step(&self) -> u64 {
        let span = self.to.saturating_sub(self.from);
        let ticks_max = (self.width.unsigned_abs() / TICK).clamp(1, TICKS_MAX);
        let mut power = 1_u64;
        loop {
            for factor in [1, 2, 5] {
                let step = power.saturating_mul(factor);
                if span / step <= ticks_max {
                    return step;
                }
            }
            power = power.saturating_mul(10);
        }
    }

    /// Draws the axis, its ticks and their times, counted from the beginning of the figure.
    pub(crate) fn draw(&self, svg: &mut Svg, y: Tenths) {
        svg.line(&[(self.x(self.from), y), (self.x(self.to), y)], Stroke::Thin);
        let step = self.step();
        let unit = Unit::of(step);
        let mut passed = 0;
        while let Some(time) = self.from.checked_add(passed).filter(|time| *time <= self.to) {
            let x = self.x(time);
            svg.line(&[(x, y), (x, y.plus(4))], Stroke::Thin);
            svg.text(x, y.plus(16), Anchor::Middle, &unit.number(passed));
            let Some(next) = passed.checked_add(step) else { break };
            passed = next;
        }
        svg.text(Tenths::pixels(self.left + self.width + 14), y.plus(4), Anchor::Start, unit.name);
    }
}

/// In what times are written.
struct Unit {
    name: &'static str,
    ns: u64,
}

impl Unit {
    /// The largest in which a step is a whole number.
    fn of(step: u64) -> Self {
        let units = [("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000)];
        let found = units.into_iter().find(|(_, ns)| step >= *ns);
        let (name, ns) = found.unwrap_or(("ns", 1));
        Self { name, ns }
    }

    fn number(&self, time: u64) -> String {
        (time / self.ns).to_string()
    }
}
