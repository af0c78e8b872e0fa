//! In which code and order of halves the rows are: the way of reading them that makes the smoothest curve.
//!
//! The cost of a row is the number of bits of its second difference, so that a jump costs little more than a rough curve.
//! Of all ways to read the rows one after the other, with a price for each change, the cheapest is taken.

use std::ops::Range;

use encoring_host::validity::Circle;

use crate::motion;
use crate::row::{ReadAs, Row, WAYS};

/// What a change from one way to another costs, in bits.
const CHANGE: u32 = 40;
/// What a row costs that cannot be read in this way.
const UNREADABLE: u32 = 25;
/// Rows that must be smoother by [`BETTER`] bits before another way is believed.
const ROWS: usize = 8;
const BETTER: u32 = 3;
/// Quarters of bits that each row must be smoother in the mean: where the other way has more than so many bits, and else.
const GAINED: u32 = 7;
const GAINED_OF_ROUGH: u32 = 10;
const ROUGH: u32 = 6;
/// Rows of which a sample is looked at first, and how far apart its places are.
const SAMPLED: usize = 96;
const APART: usize = 6;
/// Places that must be far smoother before all rows are looked at.
const DOUBTS: usize = 2;

/// A stretch of rows that are read in a way that is not the usual one.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    pub(crate) rows: Range<usize>,
    pub(crate) way: ReadAs,
    /// The halves are exchanged, and bits 31..24 were not kept: no position is left.
    pub(crate) is_cut: bool,
    /// Mean bits of second differences as the rows are, and in this way; in tenths.
    pub(crate) tenths: (u32, u32),
}

/// The last two values of a way, and the cost of the next.
#[derive(Clone, Copy, Default)]
struct Course {
    before: Option<(i64, i64)>,
    last: Option<i64>,
    unread: Option<i64>,
}

impl Course {
    /// Of a row that cannot be read: a reply that stands costs nothing more.
    fn unreadable(&mut self, row: &Row) -> u32 {
        let bits = row.bits();
        let is_same = self.unread == bits;
        self.unread = bits;
        if is_same { 0 } else { UNREADABLE }
    }

    fn cost(&mut self, circle: Circle, value: i64) -> u32 {
        self.unread = None;
        let cost = self.before.map_or(0, |(first, second)| {
            let bend = motion::way(circle, second, value).saturating_sub(motion::way(circle, first, second));
            bits(bend)
        });
        self.before = self.last.map(|last| (last, value));
        self.last = Some(value);
        cost
    }
}

fn bits(number: i64) -> u32 {
    u64::BITS - number.unsigned_abs().leading_zeros()
}

/// The costs of one row in every way.
fn costs(courses: &mut [Course; 4], circle: Circle, row: &Row) -> [u32; 4] {
    let mut costs = [0; 4];
    for ((course, cost), way) in courses.iter_mut().zip(&mut costs).zip(WAYS) {
        *cost = match (way, row.position(way)) {
            (ReadAs::Exchanged, None) => match row.low_byte_of_exchanged() {
                Some(low) => course.cost(Circle { positions: 256 }, low),
                None => course.unreadable(row),
            },
            (_, Some(position)) => course.cost(circle, position),
            (_, None) => course.unreadable(row),
        };
    }
    costs
}

/// The stretches of rows that are to be read in another way than the usual one.
pub(crate) fn stretches(rows: &[Row], circle: Circle, usual: ReadAs, first: ReadAs) -> Vec<Stretch> {
    if first == usual && !rows.chunks(SAMPLED).any(|rows| is_doubtful(rows, circle, usual)) {
        return Vec::new();
    }
    let (path, costs) = cheapest(rows, circle, usual, first);
    let mut found: Vec<Stretch> = Vec::new();
    let mut at = 0;
    for run in path.chunk_by(|a, b| a == b) {
        let range = at..at + run.len();
        at = range.end;
        let Some(way) = run.first().copied().filter(|way| *way != usual) else { continue };
        if let Some(stretch) = believed(&costs, range.clone(), way, usual) {
            let rows = rows.get(range).unwrap_or_default();
            let is_cut = way == ReadAs::Exchanged
                && rows.iter().all(|row| row.low_byte_of_exchanged().is_some() || row.bits() <= Some(0xFF));
            found.push(Stretch { is_cut, ..stretch });
        }
    }
    found
}

/// Whether places among these rows are far smoother in another way.
fn is_doubtful(rows: &[Row], circle: Circle, usual: ReadAs) -> bool {
    let mut better = [0_usize; 4];
    for three in rows.windows(3).step_by(APART).filter(|three| is_rough(three, circle, usual)) {
        let mut courses = [Course::default(); 4];
        let mut last = [0; 4];
        three.iter().for_each(|row| last = costs(&mut courses, circle, row));
        let usual = last.get(place(usual)).copied().unwrap_or_default();
        for (count, cost) in better.iter_mut().zip(last) {
            *count += usize::from(cost + BETTER <= usual);
        }
    }
    better.iter().any(|count| *count >= DOUBTS)
}

/// Whether another way can be smoother by [`BETTER`] bits.
fn is_rough(three: &[Row], circle: Circle, usual: ReadAs) -> bool {
    let [Some(a), Some(b), Some(c)] = [0, 1, 2].map(|at| three.get(at)?.position(usual)) else { return true };
    bits(motion::way(circle, b, c).saturating_sub(motion::way(circle, a, b))) >= BETTER
}

fn place(way: ReadAs) -> usize {
    WAYS.iter().position(|known| *known == way).unwrap_or_default()
}

/// The way of every row on the cheapest path, and the costs.
fn cheapest(rows: &[Row], circle: Circle, usual: ReadAs, first: ReadAs) -> (Vec<ReadAs>, Vec<[u32; 4]>) {
    let mut courses = [Course::default(); 4];
    let price = |way: ReadAs| if way == first { 0 } else { CHANGE / 2 };
    let mut sums = WAYS.map(price);
    let mut from: Vec<[u8; 4]> = Vec::with_capacity(rows.len());
    let mut all = Vec::with_capacity(rows.len());
    for row in rows {
        let costs = costs(&mut courses, circle, row);
        all.push(costs);
        let (best, least) = (0_u8..).zip(sums).min_by_key(|(_, sum)| *sum).unwrap_or_default();
        let mut origins = [0_u8; 4];
        for (((sum, origin), cost), own) in sums.iter_mut().zip(&mut origins).zip(costs).zip(0_u8..) {
            let stays = *sum <= least.saturating_add(CHANGE);
            *origin = if stays { own } else { best };
            *sum = if stays { *sum } else { least + CHANGE };
            *sum = sum.saturating_add(cost);
        }
        let least = sums.iter().copied().min().unwrap_or_default();
        sums.iter_mut().for_each(|sum| *sum -= least);
        from.push(origins);
    }
    let mut at = (0..4).min_by_key(|at| (sums.get(*at).copied(), *at != place(usual))).unwrap_or_default();
    let mut path = vec![usual; rows.len()];
    for (way, origins) in path.iter_mut().zip(&from).rev() {
        *way = WAYS.get(at).copied().unwrap_or(usual);
        at = usize::from(origins.get(at).copied().unwrap_or_default());
    }
    (path, all)
}

/// A stretch whose rows are smoother by more than a bit each, eight of them by far.
fn believed(costs: &[[u32; 4]], range: Range<usize>, way: ReadAs, usual: ReadAs) -> Option<Stretch> {
    let rows = costs.get(range.clone())?;
    let cost = |row: &[u32; 4], way: ReadAs| row.get(place(way)).copied().unwrap_or_default();
    let far = rows.iter().filter(|row| cost(row, usual) >= cost(row, way) + BETTER).count();
    let sum = |way: ReadAs| rows.iter().map(|row| cost(row, way)).sum::<u32>();
    let (plain, other) = (sum(usual), sum(way));
    let tenths = |sum: u32| sum * 10 / u32::try_from(rows.len()).unwrap_or(u32::MAX).max(1);
    let count = u32::try_from(rows.len()).unwrap_or(u32::MAX);
    // A curve that stays rough is smoother by chance.
    let quarters = if other > count.saturating_mul(ROUGH) { GAINED_OF_ROUGH } else { GAINED };
    let gained = plain.saturating_sub(other).saturating_mul(4) >= count.saturating_mul(quarters);
    (far >= ROWS && (gained || other * 2 <= plain)).then(|| Stretch {
        rows: range,
        way,
        is_cut: false,
        tenths: (tenths(plain), tenths(other)),
    })
}
