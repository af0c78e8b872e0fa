//! Where the positions begin again, if it shows.

use encoring_host::validity::Circle;

use crate::axis::Axis;
use crate::curve::Point;

/// Jumps that are looked at in one window.
const CANDIDATES: usize = 512;
/// Numbers of positions that are kept: each scaling has its own.
const ROUNDS: usize = 4;

/// Numbers of positions that are remembered.
const CIRCLES: usize = 8;
/// Beyond the end of the positions may lie one of so many.
const BEYOND: usize = 4;
/// Positions of which only the low half was kept.
const HALF: i64 = 1 << 16;
/// Positions of a word.
pub(crate) const WORD: i64 = 1 << 24;

/// How many positions there are, as jumps from one end to the other show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Round {
    positions: i64,
    /// How far off that may be.
    doubt: i64,
    /// How often it was seen.
    times: usize,
}

/// What was seen of the ends of the range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ends {
    /// The largest position.
    pub(crate) most: i64,
    /// How often the end was seen.
    pub(crate) times: usize,
    /// Every number of positions that was seen: each scaling has its own.
    pub(crate) circles: Vec<i64>,
    /// Where S is given: another end that was seen more than once, and how often.
    pub(crate) other: Option<(i64, usize)>,
}

impl Ends {
    /// Takes over what these points show, unless the number of positions is given.
    pub(crate) fn look(&mut self, points: &[Point], axis: &mut Axis) {
        let found = found(points, axis.circle);
        // Sixteen bits were kept: the positions begin again long before S.
        let half = found.iter().find(|round| round.positions == HALF && self.most < HALF);
        let most = self.most;
        let is_sure =
            |round: &&Round| round.times > 1 || round.positions > most && is_chosen(round.positions);
        let sure = half.or_else(|| found.iter().find(is_sure).filter(|_| !axis.is_circle_known));
        if let Some(round) = sure {
            axis.circle = Circle { positions: round.positions };
            self.times = self.times.max(round.times);
        }
        if axis.is_circle_known && half.is_none() {
            let is_other = |round: &&Round| {
                round.times > 1 && (round.positions - axis.circle.positions).abs() > round.doubt
            };
            let other = found.iter().find(is_other).map(|round| (round.positions, round.times));
            self.other = self.other.max(other);
        }
        self.doubt(points, axis);
        found.iter().filter(is_sure).for_each(|round| self.may_have(round.positions));
    }

    /// Positions may begin again after so many, at some time.
    pub(crate) fn may_have(&mut self, positions: i64) {
        if !self.circles.contains(&positions) && self.circles.len() < CIRCLES {
            self.circles.push(positions);
        }
    }

    /// Where many positions lie beyond what was taken for their end, it is not known.
    fn doubt(&mut self, points: &[Point], axis: &mut Axis) {
        let positions = axis.circle.positions;
        let beyond = points.iter().filter(|point| point.value >= positions).count();
        if !axis.is_circle_known && beyond * BEYOND > points.len() && self.most < WORD {
            axis.circle = Circle { positions: WORD };
            self.times = 0;
        }
    }
}

/// A jump that may lead from one end to the other.
#[derive(Clone, Copy)]
struct Candidate {
    positions: i64,
    doubt: i64,
    top: i64,
}

/// The numbers of positions that jumps agree on, the most frequent first; `circle` where it agrees too.
fn found(points: &[Point], circle: Circle) -> Vec<Round> {
    let mut candidates: Vec<Candidate> = points.windows(4).filter_map(candidate).take(CANDIDATES).collect();
    let mut rounds = Vec::new();
    while let Some(best) = candidates.iter().max_by_key(|one| agreeing(&candidates, one)) {
        let (group, others) = candidates.iter().copied().partition(|other| agrees(best, other));
        let group: Vec<Candidate> = group;
        let doubt = group.iter().map(|one| one.doubt).max().unwrap_or_default() * 2;
        rounds.push(Round { positions: agreed(&group, points, circle), doubt, times: group.len() });
        candidates = others;
        if rounds.len() == ROUNDS {
            break;
        }
    }
    rounds
}

/// What a group of jumps agrees on.
fn agreed(group: &[Candidate], points: &[Point], circle: Circle) -> i64 {
    let mut positions: Vec<i64> = group.iter().map(|one| one.positions).collect();
    positions.sort_unstable();
    let middle = positions.get(positions.len() / 2).copied().unwrap_or_default();
    let doubt = group.iter().map(|one| one.doubt).min().unwrap_or_default();
    // What lies far beyond is another scaling, or wrong.
    let seen = points.iter().map(|point| point.value).filter(|value| *value <= middle.saturating_add(doubt));
    let top = group.iter().map(|one| one.top).chain(seen).max().unwrap_or_default();
    let (low, high) = ((middle - doubt).max(top + 1), (middle + doubt).max(top + 1));
    // No word holds more.
    if top < WORD && middle > WORD {
        return WORD;
    }
    let mut doubts: Vec<i64> = group.iter().map(|one| one.doubt).collect();
    doubts.sort_unstable();
    let usual = doubts.get(doubts.len() / 2).copied().unwrap_or_default();
    for known in [circle.positions, HALF, WORD] {
        if known > top && (known - middle).abs() <= 2 * usual {
            return known;
        }
    }
    roundest(low, if top < WORD { high.min(WORD) } else { high })
}

fn agrees(one: &Candidate, other: &Candidate) -> bool {
    (one.positions - other.positions).abs() <= one.doubt + other.doubt
}

fn agreeing(candidates: &[Candidate], one: &Candidate) -> usize {
    candidates.iter().filter(|other| agrees(one, other)).count()
}

/// Four points with a jump in the middle against the motion on both sides.
fn candidate(points: &[Point]) -> Option<Candidate> {
    let [a, b, c, d] = points else { return None };
    let (before, jump, after) = (b.value - a.value, c.value - b.value, d.value - c.value);
    let fast = before.abs().max(after.abs());
    let against = before.signum() == after.signum() && jump.signum() == -before.signum();
    let (top, bottom) = (b.value.max(c.value), b.value.min(c.value));
    let span = |from: &Point, to: &Point| (to.time_ns - from.time_ns).max(1);
    let scale = |way: i64, of: i64| crate::motion::scaled(way, span(b, c), of);
    let (was, is) = (scale(before, span(a, b)), scale(after, span(c, d)));
    let reach = was.abs().max(is.abs());
    let positions = jump.abs() + (was + is).abs() / 2;
    let is_wrap = against
        && before != 0
        && jump.abs() > 4 * fast
        && bottom >= 0
        && bottom <= reach + 2
        && (positions <= WORD + reach || top >= WORD);
    is_wrap.then(|| Candidate { positions, doubt: (was - is).abs() + 3, top })
}

/// The number in a range that people choose: with the most zeros at its end, in decimal or in binary.
fn roundest(low: i64, high: i64) -> i64 {
    let zeros = |number: i64| {
        let mut decimal = 0;
        let mut rest = number;
        while rest > 0 && rest % 10 == 0 {
            rest /= 10;
            decimal += 1;
        }
        (decimal * 10).max(i64::from(number.trailing_zeros()) * 3)
    };
    let mut best = low;
    // From the middle outwards, no further than is worth while.
    let middle = low + (high - low) / 2;
    for off in 0..=((high - low) / 2).min(4_096) {
        for number in [middle + off, middle - off] {
            if (low..=high).contains(&number) && (best == low && off == 0 || zeros(number) > zeros(best)) {
                best = number;
            }
        }
    }
    best
}

/// Whether people choose such a number of positions.
const fn is_chosen(positions: i64) -> bool {
    positions % 100 == 0 || positions % 64 == 0
}
