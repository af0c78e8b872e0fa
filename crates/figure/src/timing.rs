//! Levels and words over time.

use crate::axis::Axis;
use crate::svg::{Anchor, Stroke, Svg, Tenths};

/// What a line shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneLevel {
    /// Low.
    Low,
    /// High.
    High,
    /// Nothing that is known.
    Unknown,
}

impl From<bool> for LaneLevel {
    fn from(high: bool) -> Self {
        if high { Self::High } else { Self::Low }
    }
}

/// A word, and from when to when it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Word {
    pub(crate) from: u64,
    pub(crate) to: u64,
    pub(crate) text: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    Levels { first: LaneLevel, changes: Vec<(u64, LaneLevel)> },
    Words(Vec<Word>),
}

/// One line of a figure: levels, or words one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lane {
    pub(crate) name: String,
    pub(crate) content: Content,
}

impl Lane {
    /// A line of levels, and what it shows at first.
    #[must_use]
    pub fn levels(name: &str, first: LaneLevel) -> Self {
        Self { name: name.to_owned(), content: Content::Levels { first, changes: Vec::new() } }
    }

    /// A line of words, none at first.
    #[must_use]
    pub fn words(name: &str) -> Self {
        Self { name: name.to_owned(), content: Content::Words(Vec::new()) }
    }

    /// From `at` on a line of levels shows this. A time before the last change counts as that of the last change.
    pub fn change(&mut self, at: u64, shown: LaneLevel) {
        if let Content::Levels { first, changes } = &mut self.content {
            let (last, before) = changes.last().copied().unwrap_or((0, *first));
            if shown != before {
                changes.push((at.max(last), shown));
            }
        }
    }

    /// A word stands in a line of words from `from` to `to`.
    pub fn word(&mut self, from: u64, to: u64, text: impl Into<String>) {
        if let Content::Words(words) = &mut self.content {
            words.push(Word { from, to: to.max(from), text: text.into() });
        }
    }
}

/// A timing figure: lines over a span of time, with numbered marks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimingFigure {
    pub(crate) title: String,
    pub(crate) from: u64,
    pub(crate) to: u64,
    pub(crate) lanes: Vec<Lane>,
    marks: Vec<(u64, String)>,
    /// Pixels of the time axis.
    width: i64,
}

/// Pixels from one line to the next, and of the levels in it.
const LANE: i64 = 34;
const SWING: i64 = 18;
/// Pixels above the lines: the title, the marks.
const TITLE: i64 = 24;
const MARKS: i64 = 24;
/// Pixels of the axis and of each line of the legend.
const AXIS: i64 = 30;
const LEGEND: i64 = 22;
/// Pixels on the right, for the unit of time.
const RIGHT: i64 = 40;
/// Pixels of an edge from side to side.
const EDGE: i64 = 2;

impl TimingFigure {
    /// A figure of the time from `from` to `to`, in nanoseconds.
    #[must_use]
    pub fn new(title: &str, from: u64, to: u64) -> Self {
        let title = title.to_owned();
        Self { title, from, to: to.max(from), lanes: Vec::new(), marks: Vec::new(), width: 760 }
    }

    /// Makes the time axis so many pixels long, 100 at least.
    #[must_use]
    pub fn width(mut self, pixels: u32) -> Self {
        self.width = i64::from(pixels).max(100);
        self
    }

    /// Adds a line below those that are there.
    pub fn lane(&mut self, lane: Lane) {
        self.lanes.push(lane);
    }

    /// Marks a moment; marks are numbered from 1 in order of time, and explained below the figure.
    pub fn mark(&mut self, at: u64, text: impl Into<String>) {
        self.marks.push((at, text.into()));
        self.marks.sort_by_key(|(at, _)| *at);
    }

    /// The figure as a text in SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let names = self.lanes.iter().map(|lane| Tenths::of_text(&lane.name).0 / 10).max().unwrap_or(0);
        let axis = Axis { from: self.from, to: self.to, left: names + 24, width: self.width };
        let marks = if self.marks.is_empty() { 0 } else { MARKS };
        let top = TITLE + marks;
        let bottom = top + self.lanes.len() as i64 * LANE;
        let height = bottom + AXIS + self.marks.len() as i64 * LEGEND + 8;
        let texts = self.marks.iter().map(|(_, text)| text).chain([&self.title]);
        let longest = texts.map(|text| Tenths::of_text(text).0 / 10 + 40).max().unwrap_or(0);
        let width = (axis.left + self.width + RIGHT).max(longest);
        let mut svg = Svg::new(width, height, &self.title);
        svg.text(Tenths::pixels(8), Tenths::pixels(16), Anchor::Start, &self.title);
        self.draw_marks(&mut svg, &axis, bottom);
        for (lane, number) in self.lanes.iter().zip(0_i64..) {
            let base = Tenths::pixels(top + number * LANE + SWING + 8);
            svg.text(Tenths::pixels(8), base.plus(-5), Anchor::Start, &lane.name);
            match &lane.content {
                Content::Levels { first, changes } => draw_levels(&mut svg, &axis, base, *first, changes),
                Content::Words(words) => draw_words(&mut svg, &axis, base, words),
            }
        }
        axis.draw(&mut svg, Tenths::pixels(bottom + 6));
        svg.finish()
    }

    fn draw_marks(&self, svg: &mut Svg, axis: &Axis, bottom: i64) {
        for ((at, text), number) in self.marks.iter().zip(1..) {
            let x = axis.x(*at);
            let y = Tenths::pixels(TITLE + 10);
            svg.line(&[(x, y), (x, Tenths::pixels(bottom + 6))], Stroke::Dashed);
            svg.number(x, y, number);
            let y = Tenths::pixels(bottom + AXIS + LEGEND * number as i64 - 8);
            svg.number(Tenths::pixels(17), y.plus(-4), number);
            svg.text(Tenths::pixels(32), y, Anchor::Start, text);
        }
    }
}

/// Levels as a line that swings between low and high; where nothing is known, a grey box between both.
fn draw_levels(svg: &mut Svg, axis: &Axis, base: Tenths, first: LaneLevel, changes: &[(u64, LaneLevel)]) {
    let height = |shown| base.plus(if shown == LaneLevel::High { -SWING } else { 0 });
    let before = changes.iter().take_while(|(at, _)| *at <= axis.from).last();
    let mut shown = before.map_or(first, |(_, shown)| *shown);
    let mut begun = axis.x(axis.from);
    let mut points = vec![(begun, height(shown))];
    let inside = changes.iter().filter(|(at, _)| *at > axis.from && *at <= axis.to);
    let last = inside.clone().next_back().map_or(shown, |(_, shown)| *shown);
    for (at, next) in inside.copied().chain([(axis.to, last)]).map(|(at, next)| (axis.x(at), next)) {
        points.push((at, height(shown)));
        if shown == LaneLevel::Unknown || next == LaneLevel::Unknown {
            if shown == LaneLevel::Unknown {
                svg.shade((begun, base.plus(-SWING)), (at, base));
            } else {
                svg.line(&points, Stroke::Signal);
            }
            points.clear();
        } else {
            points.pop();
            points.extend([(at.plus(-EDGE / 2), height(shown)), (at.plus(EDGE / 2), height(next))]);
        }
        (shown, begun) = (next, at);
        if points.is_empty() {
            points.push((at, height(next)));
        }
    }
    svg.line(&points, Stroke::Signal);
}

/// Words as texts between two lines that cross where a word ends; a word that has no room is left out.
fn draw_words(svg: &mut Svg, axis: &Axis, base: Tenths, words: &[Word]) {
    let (high, middle) = (base.plus(-SWING), base.plus(-SWING / 2));
    for word in words.iter().filter(|word| word.to >= axis.from && word.from <= axis.to) {
        let (from, to) = (axis.x(word.from), axis.x(word.to));
        let slope = EDGE.min((to.0 - from.0) / 20);
        let (left, right) = (from.plus(slope), to.plus(-slope));
        let outline = [
            (from, middle),
            (left, high),
            (right, high),
            (to, middle),
            (right, base),
            (left, base),
            (from, middle),
        ];
        svg.line(&outline, Stroke::Thin);
        if Tenths::of_text(&word.text).0 <= to.0 - from.0 {
            let centre = Tenths(i64::midpoint(from.0, to.0));
            svg.text(centre, base.plus(-5), Anchor::Middle, &word.text);
        }
    }
}
