//! The rows of one encoder, as many as are looked at together.

use std::collections::BTreeMap;
use std::ops::Range;

use encoring_host::validity::Circle;
use encoring_words::parameter::{Code, Parameter};
use encoring_words::{Duration, Model, ParameterSet};

use crate::axis::Axis;
use crate::beyond;
use crate::cause::JumpCause;
use crate::curve::{Curve, LEAST, Point, threshold};
use crate::episode::{Conclusion, Episode};
use crate::given::Given;
use crate::motion::FARTHEST;
use crate::noise;
use crate::options::{KnownPlace, Options};
use crate::outside::Outside;
use crate::round;
use crate::row::{ReadAs, Row};
use crate::sample::{Sample, Sighting};
use crate::scan::{Beside, Find, scan};
use crate::services::{Done, Services, Session};
use crate::verdict::Judged;
use crate::ways::{self, Stretch};

/// Rows that are judged together.
pub(crate) const ROWS: usize = 8_192;
/// Rows behind those that are judged now, so that it is known how it goes on.
const AHEAD: usize = 1_024;
/// Rows before them.
const BEHIND: usize = 512;
/// Episodes of one cause that stand by themselves; further ones are counted in the last.
const APART: usize = 1_000;
/// Second differences that may be anything: those of jumps.
const OUTLIERS: usize = 31;
/// A longer pause than so many periods is a gap: nothing is known of it.
const GAP: i64 = 8;
/// Pauses that are remembered.
const PAUSES: usize = 256;
/// How far from a known place a position may be, in steps.
const KNOWN_NEAR: i64 = 8;
/// Numbers of positions that are remembered.
const CIRCLES: usize = 8;
/// Positions of which only the low half was kept.
const HALF: i64 = 1 << 16;

#[derive(Clone, Debug)]
pub(crate) struct Window {
    position: u8,
    model: Option<Model>,
    axis: Axis,
    given: Given,
    usual: ReadAs,
    /// S, N and D.
    told: Vec<i64>,
    /// Preset values.
    aims: Vec<i64>,
    rows: Vec<Row>,
    /// The rows before this one are judged.
    from: usize,
    /// How the last judged row was read.
    way: ReadAs,
    services: Services,
    /// The largest second differences so far.
    bends: Vec<i64>,
    most: i64,
    /// How often the end of the range was seen.
    rounds: usize,
    /// Every number of positions that was seen: each scaling has its own.
    circles: Vec<i64>,
    /// Places that were not compared yet, in order of time; and the last that was, with how far off it is.
    known: Vec<KnownPlace>,
    last_known: Option<(KnownPlace, i64)>,
    pauses: Vec<(i64, u64, i64)>,
    /// No more rows come.
    is_ending: bool,
    tally: Tally,
    episodes: Vec<Episode>,
    /// How many episodes of each cause there are, and the place of the last.
    counts: BTreeMap<JumpCause, (usize, usize)>,
}

/// What was seen, for the sentences at the end.
#[derive(Clone, Debug, Default)]
struct Tally {
    rows: u64,
    positions: u64,
    period_ns: i64,
    /// The largest tolerance.
    tolerance: i64,
    is_lost: bool,
    has_moved: bool,
}

impl Window {
    pub(crate) fn new(position: u8, options: &Options) -> Self {
        let active = options.active.map(|active| active.parameters);
        let of = |values: &[Parameter]| {
            let value =
                |active: ParameterSet| values.iter().map(|value| i64::from(active.value(*value))).collect();
            active.map_or_else(Vec::new, value)
        };
        let told = of(&[Parameter::MeasuringLength, Parameter::Numerator, Parameter::Denominator]);
        let aims = of(&[Parameter::PresetValue1, Parameter::PresetValue2]);
        let is_gray = active.is_some_and(|active| active.counting_direction().code == Code::Gray);
        let usual = if is_gray { ReadAs::Gray } else { ReadAs::Plain };
        let axis = Axis::new(options);
        Self {
            position,
            given: Given::new(&axis),
            axis,
            model: options.model.or(options.active.map(|active| active.model)),
            usual,
            told,
            aims,
            rows: Vec::new(),
            from: 0,
            way: usual,
            services: Services::default(),
            bends: Vec::new(),
            most: 0,
            rounds: 0,
            circles: Vec::new(),
            known: options.known.clone(),
            last_known: None,
            pauses: Vec::new(),
            is_ending: false,
            tally: Tally::default(),
            episodes: Vec::new(),
            counts: BTreeMap::new(),
        }
    }

    /// What has been told so far.
    pub(crate) fn told(&self) -> &[Episode] {
        &self.episodes
    }

    pub(crate) fn push(&mut self, sample: &Sample) {
        self.tally.rows += 1;
        let row = Row::new(sample);
        self.services.row(&row);
        self.rows.push(row);
        if self.rows.len() >= ROWS {
            self.judge(self.rows.len() - AHEAD);
        }
    }

    pub(crate) fn finish(mut self, conclusion: &mut Conclusion) {
        self.is_ending = true;
        self.judge(self.rows.len());
        self.tally.tell(&self, conclusion);
        conclusion.episodes.append(&mut self.episodes);
    }

    /// Judges the rows up to `until`.
    fn judge(&mut self, until: usize) {
        let range = self.from..until;
        let stretches = ways::stretches(&self.rows, self.axis.circle, self.usual, self.way);
        self.tell_ways(&stretches, &range);
        let mut points = self.points(&stretches, &range);
        self.way = way_of(&stretches, self.usual, until.saturating_sub(1));
        let period = noise::period(&points);
        self.tally.period_ns = period;
        for run in points.chunk_by_mut(|a, b| b.time_ns - a.time_ns <= GAP * period) {
            noise::even_times(run, period);
        }
        self.find_round(&points);
        self.given.look(&points, &self.rows, &range);
        let tolerance = self.tolerance(&points, &range);
        self.tally.look(&points, &self.axis, tolerance, self.most);
        let mut finds = Vec::new();
        for run in points.chunk_by(|a, b| b.time_ns - a.time_ns <= (GAP + 1) * period) {
            let rows = &self.rows;
            let curve = Curve {
                points: run,
                rows,
                circle: self.axis.circle,
                axis: &self.axis,
                period_ns: period,
                tolerance,
            };
            self.curve(&curve, &range, &stretches, &mut finds);
        }
        self.outside(&points, &range, &stretches, tolerance, &mut finds);
        self.sessions(&range, &mut finds);
        self.known(&points, &range, &mut finds);
        finds.sort_by_key(|(rows, _)| rows.start);
        let is_lost = is_lost(tolerance, &self.axis, self.most);
        for (rows, judged) in finds {
            let judged = if is_lost { judged.doubted() } else { judged };
            self.tell(rows, judged);
        }
        self.drain(until);
    }

    fn drain(&mut self, until: usize) {
        let kept = until.saturating_sub(BEHIND);
        self.rows.drain(..kept.min(self.rows.len()));
        self.from = until - kept;
    }

    fn points(&mut self, stretches: &[Stretch], range: &Range<usize>) -> Vec<Point> {
        let mut points = Vec::with_capacity(self.rows.len());
        let mut stretches = stretches.iter().peekable();
        for (index, row) in self.rows.iter().enumerate() {
            while stretches.next_if(|stretch| stretch.rows.end <= index).is_some() {}
            let here = stretches.peek().filter(|stretch| stretch.rows.contains(&index));
            let way = here.map_or(self.usual, |stretch| stretch.way);
            if let Some(value) = row.position(way) {
                // The same row again.
                let is_twice = points.last().is_some_and(|last: &Point| {
                    last.time_ns == row.time_ns && last.value == value && row.time_ns == 0
                });
                if !is_twice {
                    points.push(Point { row: index, time_ns: row.time_ns, value });
                }
            }
        }
        // Those behind the range come again with the next one.
        self.tally.positions += points.iter().filter(|point| range.contains(&point.row)).count() as u64;
        self.most = points.iter().map(|point| point.value).fold(self.most, i64::max);
        points
    }

    fn find_round(&mut self, points: &[Point]) {
        let found = round::found(points, self.axis.circle);
        // Sixteen bits were kept: the positions begin again long before S.
        let half = found.iter().find(|round| round.positions == HALF && self.most < HALF);
        if self.axis.is_circle_known && half.is_none() {
            return;
        }
        let is_sure = |round: &&round::Round| {
            round.times > 1 || round.positions > self.most && is_chosen(round.positions)
        };
        let sure = half.or_else(|| found.iter().find(is_sure));
        if let Some(round) = sure {
            self.axis.circle = Circle { positions: round.positions };
            self.rounds = self.rounds.max(round.times);
        }
        for round in found.iter().filter(is_sure) {
            if !self.circles.contains(&round.positions) && self.circles.len() < CIRCLES {
                self.circles.push(round.positions);
            }
        }
    }

    /// What second differences motion makes.
    fn tolerance(&mut self, points: &[Point], range: &Range<usize>) -> i64 {
        let circle = self.axis.circle;
        let bend = |three: &[Point]| {
            let [a, b, c] = three else { return None };
            let (before, after) = (b.time_ns - a.time_ns, c.time_ns - b.time_ns);
            let way = crate::motion::scaled(circle.way(a.value, b.value), after, before);
            Some((c.row, (circle.way(b.value, c.value) - way).abs()))
        };
        let bends: Vec<(usize, i64)> = points.windows(3).filter_map(bend).collect();
        let own = threshold(bends.iter().map(|(_, bend)| *bend).collect(), OUTLIERS);
        self.bends.extend(bends.iter().filter(|(row, _)| range.contains(row)).map(|(_, bend)| *bend));
        self.bends.sort_unstable_by(|a, b| b.cmp(a));
        self.bends.truncate(OUTLIERS + 1);
        let all = self.bends.get(OUTLIERS).copied().unwrap_or_default().saturating_mul(3);
        own.max(all).clamp(LEAST, FARTHEST)
    }

    fn curve(
        &self,
        curve: &Curve<'_>,
        range: &Range<usize>,
        stretches: &[Stretch],
        finds: &mut Vec<(Range<usize>, Judged)>,
    ) {
        let first = curve.points.partition_point(|point| point.row < range.start);
        let end = curve.points.partition_point(|point| point.row < range.end);
        if first >= end {
            return;
        }
        let is_fast = self.tally.period_ns * 2 < self.axis.refresh_ns.max(1_000_000) * 7;
        let mut found = noise::stretches(curve, is_fast);
        let quiet: Vec<Range<usize>> = gaps(&found, curve.points.len());
        for part in quiet {
            let Some(points) = curve.points.get(part.clone()) else { continue };
            let part_curve = Curve { points, ..*curve };
            let row = points.first().map_or(0, |point| point.row);
            let beside = Beside {
                services: &self.services,
                model: self.model,
                way: way_of(stretches, self.usual, row),
                told: &self.told,
                aims: &self.aims,
                circles: &self.circles,
                most: self.most,
                is_circle_sure: self.axis.is_circle_known || self.rounds > 1,
            };
            let mut inner = Vec::new();
            scan(&part_curve, 0..points.len(), beside, &mut inner);
            found.extend(inner.into_iter().map(|find| Find {
                points: find.points.start + part.start..find.points.end + part.start,
                judged: find.judged,
            }));
        }
        let beyond = beyond::stretches(curve, &found);
        found.extend(beyond);
        for Find { points, judged } in found {
            let row = |at: usize| curve.points.get(at).map(|point| point.row);
            let (Some(from), Some(to)) = (row(points.start), row(points.end.saturating_sub(1))) else {
                continue;
            };
            // What began before this window was told with the one before, but for stretches that go on.
            let from = if judged.cause.lasts() { from.max(range.start) } else { from };
            if range.contains(&from) && from <= to {
                finds.push((from..to + 1, judged));
            }
        }
    }

    /// Words that are no positions.
    fn outside(
        &self,
        points: &[Point],
        range: &Range<usize>,
        stretches: &[Stretch],
        tolerance: i64,
        finds: &mut Vec<(Range<usize>, Judged)>,
    ) {
        let mut at = range.start;
        while at < range.end {
            let Some((row, word)) = self.outside_at(at, stretches) else {
                at += 1;
                continue;
            };
            let rows = (at..range.end).take_while(|other| {
                self.outside_at(*other, stretches).is_some_and(|(_, other)| other == word)
            });
            let rows = rows.count();
            let behind = points.partition_point(|point| point.row < at);
            let way = way_of(stretches, self.usual, at);
            let outside = Outside {
                word,
                out: row.out,
                should: self.should(points, behind, row.time_ns),
                near: (tolerance / 3).max(3),
                way,
            };
            finds.push((at..at + rows, outside.judged()));
            at += rows;
        }
    }

    /// What services did, where no jump was found for it.
    fn sessions(&mut self, range: &Range<usize>, finds: &mut Vec<(Range<usize>, Judged)>) {
        let until = match self.is_ending {
            true => i64::MAX,
            false => self.rows.get(range.end).map_or(i64::MAX, |row| row.time_ns),
        };
        for Session { done, lines } in self.services.sessions(until) {
            let (cause, what) = match done {
                Done::Preset(value) => (JumpCause::Preset, format!("service 06 with {value:06X}h")),
                Done::Scaling => (JumpCause::Rescaled, "service 02, 03 or 09 written".to_owned()),
                Done::Direction => (JumpCause::Direction, "service 01 written".to_owned()),
                Done::Check => continue,
            };
            let place = |line: u64| self.rows.partition_point(|row| row.line < line);
            let rows = place(lines.0)..place(lines.1) + 1;
            let near = rows.start.saturating_sub(4)..rows.end + 50;
            let is_found =
                finds.iter().any(|(found, judged)| judged.cause == cause && near.contains(&found.start));
            let is_told = self
                .episodes
                .iter()
                .rev()
                .take(64)
                .any(|known| known.cause == cause && known.to_line >= lines.0);
            if !is_found && !is_told && rows.end <= self.rows.len() {
                finds.push((rows, Judged::certain(cause, format!("{what} at line {}", lines.0))));
            }
        }
    }

    /// What places that somebody knows say: a place that fits before a gap and none behind it.
    fn known(&mut self, points: &[Point], range: &Range<usize>, finds: &mut Vec<(Range<usize>, Judged)>) {
        self.remember_pauses(points, range);
        while let Some(known) = self.known.first().copied() {
            let at = points.partition_point(|point| point.time_ns < known.time_ns.cast_signed());
            let Some(point) = points.get(at).or_else(|| points.last().filter(|_| self.is_ending)).copied()
            else {
                break;
            };
            if point.row >= range.end {
                break;
            }
            self.known.remove(0);
            let off = self.axis.circle.way(known.steps, point.value);
            let was = self.last_known.replace((known, off));
            let Some((before, was_off)) = was else { continue };
            let apart = self.axis.circle.way(was_off, off);
            if apart.abs() <= KNOWN_NEAR + self.most_step(points, at) {
                continue;
            }
            let evidence =
                format!("{} steps further from the known place than at the one before", apart.abs());
            let between = before.time_ns.cast_signed()..=known.time_ns.cast_signed();
            let pause = self
                .pauses
                .iter()
                .filter(|pause| between.contains(&pause.0))
                .max_by_key(|pause| pause.2)
                .copied();
            let (line, judged) = match pause {
                Some((_, line, span)) => (
                    line,
                    Judged::likely(JumpCause::ZeroLost, evidence)
                        .since(format!("between both lies a pause of {}", Duration(span.unsigned_abs()))),
                ),
                None => (
                    self.rows.get(point.row).map_or(0, |row| row.line),
                    Judged::possible(JumpCause::Unclear, evidence).or(&[
                        JumpCause::ZeroLost,
                        JumpCause::Mechanical,
                        JumpCause::Preset,
                    ]),
                ),
            };
            let row = self.rows.partition_point(|row| row.line < line);
            finds.push((row..row + 1, judged));
        }
    }

    /// Pauses of the recording: the time, the line behind it, and how long it was.
    fn remember_pauses(&mut self, points: &[Point], range: &Range<usize>) {
        for two in points.windows(2) {
            let [before, behind] = two else { continue };
            let span = behind.time_ns - before.time_ns;
            if range.contains(&behind.row) && span * 4 > self.tally.period_ns * 7 {
                let line = self.rows.get(behind.row).map_or(0, |row| row.line);
                self.pauses.push((behind.time_ns, line, span));
            }
        }
        // The longest stay.
        if self.pauses.len() > PAUSES {
            self.pauses.sort_unstable_by_key(|pause| core::cmp::Reverse(pause.2));
            self.pauses.truncate(PAUSES);
        }
    }

    /// Twice the steps from row to row at a point, on the side where there are fewer.
    fn most_step(&self, points: &[Point], at: usize) -> i64 {
        let around = points.get(at.saturating_sub(1)..(at + 2).min(points.len())).unwrap_or_default();
        let step = |two: &[Point]| match two {
            [a, b] => self.axis.circle.way(a.value, b.value).abs(),
            _ => 0,
        };
        around.windows(2).map(step).min().unwrap_or_default() * 2
    }

    fn outside_at(&self, at: usize, stretches: &[Stretch]) -> Option<(Row, u32)> {
        let row = self.rows.get(at)?;
        let Sighting::Word(word) = row.reading else { return None };
        row.position(way_of(stretches, self.usual, at)).is_none().then_some((*row, word))
    }

    /// Where a position would be between the point `behind` and the one before it.
    fn should(&self, points: &[Point], behind: usize, time_ns: i64) -> Option<i64> {
        let before = points.get(behind.checked_sub(1)?)?;
        let Some(after) = points.get(behind) else { return Some(before.value) };
        let way = self.axis.circle.way(before.value, after.value);
        let span = (time_ns - before.time_ns).max(0);
        let way = crate::motion::scaled(way, span, after.time_ns - before.time_ns);
        Some(self.axis.circle.moved(before.value, way))
    }

    fn tell_ways(&mut self, stretches: &[Stretch], range: &Range<usize>) {
        for Stretch { rows, way, tenths } in stretches {
            let rows = rows.start.max(range.start)..rows.end.min(range.end);
            if rows.is_empty() {
                continue;
            }
            let bits = |tenths: u32| format!("{}.{}", tenths / 10, tenths % 10);
            let evidence = format!(
                "second differences have {} bits as the rows are, and {} read so",
                bits(tenths.0),
                bits(tenths.1)
            );
            let cause = match way {
                ReadAs::Gray => JumpCause::GrayAsBinary,
                ReadAs::Binary | ReadAs::Plain => JumpCause::BinaryAsGray,
                ReadAs::Exchanged => JumpCause::HalvesExchanged,
            };
            self.tell(rows, Judged::likely(cause, evidence));
        }
    }

    fn tell(&mut self, rows: Range<usize>, judged: Judged) {
        let (Some(first), Some(last)) = (self.rows.get(rows.start), self.rows.get(rows.end - 1)) else {
            return;
        };
        let before = rows.start.checked_sub(1).and_then(|at| self.rows.get(at)).map_or(0, |row| row.line);
        let (line, to_line, count) = (first.line, last.line, rows.len() as u64);
        let (same, last) = self.counts.get(&judged.cause).copied().unwrap_or((0, usize::MAX));
        if let Some(known) = self.episodes.get_mut(last)
            && (same >= APART || judged.cause.lasts() && (known.to_line == before || known.to_line >= line))
        {
            known.count += count;
            known.to_line = known.to_line.max(to_line);
            return;
        }
        let apart = judged.apart();
        let Judged { cause, certainty, alternatives, mut evidence } = judged;
        if rows.len() < 4
            && let Some(before) = rows.start.checked_sub(1).and_then(|at| self.rows.get(at))
        {
            evidence.insert(0, format!("{} behind {}", first.shown(), before.shown()));
        }
        self.counts.insert(cause, (same + 1, self.episodes.len()));
        self.episodes.push(Episode {
            line,
            to_line,
            count,
            time_ns: first.time_ns.unsigned_abs(),
            position: self.position,
            cause,
            certainty,
            alternatives,
            apart,
            evidence,
        });
    }
}

/// The way in which a row is read.
fn way_of(stretches: &[Stretch], usual: ReadAs, row: usize) -> ReadAs {
    stretches.iter().find(|stretch| stretch.rows.contains(&row)).map_or(usual, |stretch| stretch.way)
}

/// Whether people choose such a number of positions.
const fn is_chosen(positions: i64) -> bool {
    positions % 100 == 0 || positions % 64 == 0
}

/// The parts between stretches.
fn gaps(found: &[Find], length: usize) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut from = 0;
    for find in found.iter().filter(|find| find.judged.cause == JumpCause::Noise) {
        parts.push(from..find.points.start.max(from));
        from = find.points.end;
    }
    parts.push(from.min(length)..length);
    parts
}

/// Whether half of the range can be passed from row to row, and so every place be reached.
fn is_lost(tolerance: i64, axis: &Axis, most: i64) -> bool {
    tolerance * 2 >= axis.circle.positions.min(most + 1).max(2)
}

impl Tally {
    /// What can be judged of these points.
    fn look(&mut self, points: &[Point], axis: &Axis, tolerance: i64, most: i64) {
        self.tolerance = self.tolerance.max(tolerance);
        self.is_lost |= points.len() > 2 && is_lost(tolerance, axis, most);
        self.has_moved |= points.windows(2).any(|two| matches!(two, [a, b] if a.value != b.value));
    }

    fn tell(&self, window: &Window, conclusion: &mut Conclusion) {
        let (position, axis) = (window.position, &window.axis);
        let period = Duration(self.period_ns.unsigned_abs());
        let told = &mut conclusion.judged;
        told.push(format!(
            "position {position}: {} rows, {} of them positions, {period} apart",
            self.rows, self.positions
        ));
        let limits = &mut conclusion.limits;
        if self.positions < 3 {
            limits.push(format!("position {position}: fewer than three positions: nothing can be judged"));
            return;
        }
        let jump = match axis.bend(self.period_ns + axis.refresh_ns) {
            Some(bend) if self.tolerance == LEAST => (bend / 4 * 3 + 2).max(LEAST),
            _ => self.tolerance,
        };
        if self.is_lost {
            limits.push(format!(
                "position {position}: at this period no jump can be judged: half of the positions can be passed from row to row"
            ));
        } else {
            limits.push(format!(
                "position {position}: at this period no jump of up to {jump} steps can be judged"
            ));
        }
        if let Some(contradiction) = window.given.contradiction() {
            limits.push(format!("position {position}: {contradiction}"));
        }
        if !self.has_moved {
            limits.push(format!(
                "position {position}: it never moved: code, order of the halves, scaling, direction and held bits do not show"
            ));
        }
        let positions = axis.circle.positions;
        told.push(match (axis.is_circle_known, window.rounds) {
            (true, _) => format!("position {position}: {positions} positions, as given"),
            (false, 0) => {
                format!("position {position}: S is at least {}: no end of the range was seen", window.most)
            }
            (false, times) => {
                format!("position {position}: about {positions} positions: their end was seen {times} times")
            }
        });
        if !axis.is_scale_known {
            limits.push(format!(
                "position {position}: N, D and the counting direction do not show in positions; speed and acceleration were judged \
                 as steps only: give --parameters"
            ));
        }
        if !window.services.shows_out() {
            limits.push(format!("position {position}: without OUT in every row presets and scalings are seen only by their replies"));
        }
    }
}
