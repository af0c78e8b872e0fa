//! The rows of one encoder, as many as are looked at together.

use std::ops::Range;

use encoring_host::validity::Circle;
use encoring_texts::{Decimal, Hex, Said};
use encoring_words::model::SensorKind;
use encoring_words::parameter::{Code, Parameter};
use encoring_words::{Model, ParameterSet};

use crate::axis::Axis;
use crate::beyond;
use crate::cause::{JumpCause, Likelihood};
use crate::curve::{Curve, Point};
use crate::episode::{Conclusion, Episode};
use crate::evidence;
use crate::given::Given;
use crate::ledger::Ledger;
use crate::motion::{scaled, way};
use crate::noise;
use crate::options::Options;
use crate::outside;
use crate::part::{Part, way_of};
use crate::places::Places;
use crate::quiet::{self, Pace, Quiet};
use crate::refresh::Refresh;
use crate::round::Ends;
use crate::row::{ReadAs, Row};
use crate::sample::Sample;
use crate::scan::{Beside, Find, scan};
use crate::services::{Done, Services, Session};
use crate::stops::{self, Stops};
use crate::tally::{Tally, Told, is_lost};
use crate::together::Place;
use crate::tolerance::{Bends, Usual};
use crate::verdict::Judged;
use crate::ways::{self, Stretch};

/// Rows that are judged together.
pub(crate) const ROWS: usize = 8_192;
/// Rows behind those that are judged now, so that it is known how it goes on.
const AHEAD: usize = 1_024;
/// Rows before them.
const BEHIND: usize = 512;
/// Rows before a service.
const AROUND: usize = 16;
/// A longer pause than so many periods is a gap: nothing is known of it.
const GAP: i64 = 8;

/// Rows by which a second difference shows another way to read rows too late.
const EDGE: usize = 2;

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
    bends: Bends,
    ends: Ends,
    places: Places,
    stops: Stops,
    refresh: Refresh,
    /// No more rows come.
    is_ending: bool,
    tally: Tally,
    ledger: Ledger,
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
            services: Services::new(options.counted, active.as_ref()),
            bends: Bends::default(),
            ends: Ends::default(),
            places: Places::new(&options.known),
            stops: Stops::default(),
            refresh: Refresh::default(),
            is_ending: false,
            tally: Tally::default(),
            ledger: Ledger::new(position),
        }
    }

    /// What has been told so far.
    pub(crate) fn told(&self) -> &[Episode] {
        self.ledger.episodes()
    }

    pub(crate) fn push(&mut self, sample: &Sample) {
        self.tally.rows += 1;
        let row = Row::new(sample);
        self.services.row(&row);
        self.stops.row(&row, self.usual);
        self.rows.push(row);
        if self.rows.len() >= ROWS {
            self.judge(self.rows.len() - AHEAD);
        }
    }

    /// The latest row; `None` if it holds something else than a position.
    pub(crate) fn place(&self) -> Option<Place> {
        let row = self.rows.last()?;
        let value = row.position(self.usual);
        let is_none = row.bits().is_none();
        let (line, time_ns, circle) = (row.line, row.time_ns, self.axis.circle);
        (value.is_some() || is_none).then_some(Place { line, time_ns, value, circle })
    }

    /// What would tell a cause from others.
    pub(crate) fn apart(&self, judged: &Judged) -> Vec<Said> {
        judged.apart(&self.services)
    }

    pub(crate) fn finish(mut self, conclusion: &mut Conclusion) {
        self.is_ending = true;
        self.judge(self.rows.len());
        let Self { position, axis, ends, given, services, places, stops, refresh, .. } = &self;
        self.tally.tell(
            &Told { position: *position, axis, ends, given, services, places, stops, refresh },
            conclusion,
        );
        conclusion.episodes.append(&mut self.ledger.into_episodes());
    }

    /// Judges the rows up to `until`.
    fn judge(&mut self, until: usize) {
        let range = self.from..until;
        if self.is_quiet(&range) {
            self.drain(until);
            return;
        }
        let stretches = ways::stretches(&self.rows, self.axis.circle, self.usual, self.way);
        self.tell_ways(&stretches, &range);
        let mut points = self.points(&stretches, &range);
        self.way = way_of(&stretches, self.usual, until.saturating_sub(1));
        let period_ns = noise::period(&points);
        self.tally.period_ns = period_ns;
        for run in points.chunk_by_mut(|a, b| b.time_ns - a.time_ns <= GAP * period_ns) {
            noise::even_times(run, self.axis.circle, period_ns);
        }
        if let Some(line) = self.services.rescaled().filter(|_| self.axis.is_circle_known) {
            self.axis.forget();
            self.given.end(line);
        }
        self.ends.look(&points, &mut self.axis);
        // A rod's positions go on beyond its length [C7].
        if self.model.is_none_or(|model| model.sensor_kind() == SensorKind::Rotary) {
            self.services.lengths().iter().for_each(|length| self.ends.may_have(i64::from(*length) + 1));
        }
        self.given.look(&points, &self.rows, &range);
        let circle = self.axis.circle;
        let counted = |row: usize| range.contains(&row);
        self.refresh.look(&points, &range, circle, period_ns);
        let Usual { tolerance, late_ns } = self.bends.usual(&points, circle, GAP * period_ns, counted);
        self.tally.look(&points, &self.axis, tolerance, self.ends.most);
        let (rows, usual) = (&self.rows, self.usual);
        let part = Part {
            rows,
            range: &range,
            points: &points,
            circle,
            period_ns,
            tolerance,
            stretches: &stretches,
            usual,
        };
        let mut finds = Vec::new();
        let is_one = |a: &Point, b: &Point| {
            b.time_ns - a.time_ns <= (GAP + 1) * period_ns && !stops::is_between(rows, a.row, b.row)
        };
        for run in points.chunk_by(is_one) {
            let curve = Curve { points: run, rows, circle, axis: &self.axis, period_ns, tolerance, late_ns };
            self.curve(&curve, &part, &mut finds);
        }
        finds.retain(|(rows, judged)| !is_edge(&stretches, rows, judged));
        outside::finds(&part, &mut finds);
        self.places.look(&part, self.is_ending, &mut finds);
        self.stops.finds(&part, &self.services, &mut finds);
        self.sessions(&range, &stretches, Steady { points: &points, circle, tolerance }, &mut finds);
        finds.sort_by_key(|(rows, _)| rows.start);
        let is_lost = is_lost(tolerance, &self.axis, self.ends.most);
        // Where every place can be reached from row to row, only what the words themselves say is left.
        let is_said =
            |judged: &Judged| judged.certainty == Likelihood::Certain || judged.cause == JumpCause::Wrap;
        finds.retain(|(_, judged)| !is_lost || is_said(judged));
        for (rows, mut judged) in finds {
            if is_lost && judged.cause == JumpCause::Wrap {
                judged.certainty = Likelihood::Possible;
                judged.evidence = vec![evidence::shorter_way(circle.positions)];
            }
            self.ledger.tell(&self.rows, &self.services, rows, judged);
        }
        self.drain(until);
    }

    /// Whether nothing can have happened in these rows, or in those beside them; they are counted then.
    fn is_quiet(&mut self, range: &Range<usize>) -> bool {
        let is_usual = self.usual == ReadAs::Plain && self.way == ReadAs::Plain;
        if !is_usual || !self.places.are_told() || self.services.is_waiting() {
            return false;
        }
        let pace = Pace { fast_ns: self.fast_ns(), steps_per_s: self.axis.limit() };
        let Some(Quiet { period_ns, least, most, has_moved }) = quiet::of(&self.rows, pace) else {
            return false;
        };
        let is_within = self.given.has(&(least..most + 1));
        if is_within {
            self.ends.most = self.ends.most.max(most);
            self.tally.look_at_quiet(range.len() as u64, period_ns, has_moved);
        }
        is_within
    }

    /// Below this period rows may come faster than the encoder's samples.
    fn fast_ns(&self) -> i64 {
        self.axis.refresh_ns.max(1_000_000) * 7 / 2
    }

    fn drain(&mut self, until: usize) {
        // Rows of services that nothing was told of yet are still needed.
        let waiting = self.services.waiting_since();
        let needed = waiting.map_or(until, |line| self.rows.partition_point(|row| row.line < line));
        let kept = until
            .saturating_sub(BEHIND)
            .min(needed.saturating_sub(AROUND))
            .max(until.saturating_sub(ROWS / 2));
        self.rows.drain(..kept.min(self.rows.len()));
        self.from = until - kept;
    }

    fn points(&mut self, stretches: &[Stretch], range: &Range<usize>) -> Vec<Point> {
        let mut points = Vec::with_capacity(self.rows.len());
        let same = self.rows.windows(2).filter(|two| matches!(two, [a, b] if a.time_ns == b.time_ns)).count();
        // Where stamps are coarser than the rows, the same stamp says nothing.
        let are_fine = same * 8 < self.rows.len();
        let mut stretches = stretches.iter().peekable();
        for (index, row) in self.rows.iter().enumerate() {
            while stretches.next_if(|stretch| stretch.rows.end <= index).is_some() {}
            let here = stretches.peek().filter(|stretch| stretch.rows.contains(&index));
            let way = here.map_or(self.usual, |stretch| stretch.way);
            let value = row.position(way).filter(|_| here.is_none_or(|stretch| !stretch.is_cut));
            if let Some(value) = value {
                // The same row again.
                let is_twice = points
                    .last()
                    .is_some_and(|last: &Point| last.time_ns == row.time_ns && last.value == value);
                if !(is_twice && are_fine) {
                    points.push(Point { row: index, time_ns: row.time_ns, value, late_ns: 0 });
                }
            }
        }
        // Those behind the range come again with the next one.
        self.tally.positions += points.iter().filter(|point| range.contains(&point.row)).count() as u64;
        self.ends.most = points.iter().map(|point| point.value).fold(self.ends.most, i64::max);
        points
    }

    fn curve(&self, curve: &Curve<'_>, part: &Part<'_>, finds: &mut Vec<(Range<usize>, Judged)>) {
        let range = part.range;
        let first = curve.points.partition_point(|point| point.row < range.start);
        let end = curve.points.partition_point(|point| point.row < range.end);
        if first >= end {
            return;
        }
        let is_fast = self.tally.period_ns < self.fast_ns();
        let mut found = noise::stretches(curve, is_fast);
        let quiet: Vec<Range<usize>> = gaps(&found, curve.points.len());
        for quiet in quiet {
            let Some(points) = curve.points.get(quiet.clone()) else { continue };
            let quiet_curve = Curve { points, ..*curve };
            let row = points.first().map_or(0, |point| point.row);
            let beside = Beside {
                services: &self.services,
                model: self.model,
                way: part.way_of(row),
                told: &self.told,
                aims: &self.aims,
                circles: &self.ends.circles,
                most: self.ends.most,
                is_circle_sure: self.axis.is_circle_known || self.ends.times > 1,
            };
            let mut inner = Vec::new();
            scan(&quiet_curve, 0..points.len(), beside, &mut inner);
            found.extend(inner.into_iter().map(|find| Find {
                points: find.points.start + quiet.start..find.points.end + quiet.start,
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

    /// What services did, where no jump was found for it.
    fn sessions(
        &mut self,
        range: &Range<usize>,
        stretches: &[Stretch],
        steady: Steady<'_>,
        finds: &mut Vec<(Range<usize>, Judged)>,
    ) {
        let until = match self.is_ending {
            true => i64::MAX,
            false => self.rows.get(range.end).map_or(i64::MAX, |row| row.time_ns),
        };
        for Session { done, lines } in self.services.sessions(until) {
            let at = self.services.place(lines.0);
            let (cause, evidence) = match done {
                Done::Preset(value) => (JumpCause::Preset, evidence::preset_seen(Hex(value), at)),
                Done::Scaling => (JumpCause::Rescaled, evidence::scaling_seen(at)),
                Done::Direction => (JumpCause::Direction, evidence::direction_seen(at)),
                Done::Check => continue,
            };
            let place = |line: u64| self.rows.partition_point(|row| row.line < line);
            let rows = place(lines.0)..place(lines.1) + 1;
            // There bit 31 is one of the position.
            if way_of(stretches, self.usual, rows.start) == ReadAs::Exchanged {
                continue;
            }
            let near = rows.start.saturating_sub(4)..rows.end + 50;
            let is_found =
                finds.iter().any(|(found, judged)| judged.cause == cause && near.contains(&found.start));
            let has_jumped = finds.iter().any(|(found, judged)| {
                judged.cause != JumpCause::ReplyAsPosition && near.contains(&found.start)
            });
            // The same value once more changes nothing, and another one nothing before a data check [R79].
            let moves_all = matches!(done, Done::Scaling | Done::Direction);
            if moves_all && !has_jumped && steady.goes_on(&near) {
                continue;
            }
            if !is_found && !self.ledger.has_told(cause, lines.0) && rows.end <= self.rows.len() {
                finds.push((rows, Judged::certain(cause, evidence)));
            }
        }
    }

    fn tell_ways(&mut self, stretches: &[Stretch], range: &Range<usize>) {
        for Stretch { rows, way, tenths, .. } in stretches {
            let rows = rows.start.max(range.start)..rows.end.min(range.end);
            if rows.is_empty() {
                continue;
            }
            let [plain, read_so] = [tenths.0, tenths.1].map(|tenths| Decimal::Tenths(tenths.into()));
            let evidence = evidence::smoother(plain, read_so);
            let cause = match way {
                ReadAs::Gray => JumpCause::GrayAsBinary,
                ReadAs::Binary | ReadAs::Plain => JumpCause::BinaryAsGray,
                ReadAs::Exchanged => JumpCause::HalvesExchanged,
            };
            self.ledger.tell(&self.rows, &self.services, rows, Judged::likely(cause, evidence));
        }
    }
}

/// Points among which nothing may have happened.
#[derive(Clone, Copy)]
struct Steady<'a> {
    points: &'a [Point],
    circle: Circle,
    tolerance: i64,
}

impl Steady<'_> {
    /// Whether positions that another scaling or direction would have moved go on from before these rows to behind them.
    fn goes_on(&self, rows: &Range<usize>) -> bool {
        let place = |row: usize| self.points.partition_point(|point| point.row < row);
        let (before, behind) = (place(rows.start), place(rows.end));
        let four = |from: Option<usize>| {
            let from = from?;
            Some((*self.points.get(from)?, *self.points.get(from + 3)?))
        };
        let (Some((a, b)), Some((c, d))) = (four(before.checked_sub(4)), four(Some(behind))) else {
            return false;
        };
        let span = c.time_ns - b.time_ns;
        let over = |from: Point, to: Point| {
            scaled(way(self.circle, from.value, to.value), span, to.time_ns - from.time_ns)
        };
        let (was, is) = (over(a, b), over(c, d));
        let count = i64::try_from(behind - before).unwrap_or(i64::MAX).max(4);
        let may = self.tolerance.saturating_mul(count) / 2;
        let is_even = (was - is).abs() <= may.max(was.abs().max(is.abs()) / 4);
        let is_on_the_way =
            (way(self.circle, b.value, c.value) - (was + is) / 2).abs() <= may.max((was - is).abs());
        is_even && is_on_the_way && b.value > may.saturating_mul(4) + SMALL
    }
}

/// Positions up to this one are near those of every scaling.
const SMALL: i64 = 64;

/// Whether a find is the edge of rows that are read in another way, which shows a row or two too early or too late.
fn is_edge(stretches: &[Stretch], rows: &Range<usize>, judged: &Judged) -> bool {
    let is_near = |edge: usize| rows.start.abs_diff(edge) <= EDGE;
    let is_beside = |stretch: &Stretch| is_near(stretch.rows.start) || is_near(stretch.rows.end);
    judged.cause == JumpCause::Unclear && rows.len() <= EDGE && stretches.iter().any(is_beside)
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
