//! Where the positions begin again, if it shows.

use encoring_host::validity::Circle;

use crate::curve::Point;

/// Jumps that are looked at in one window.
const CANDIDATES: usize = 512;
/// Numbers of positions that are kept: each scaling has its own.
const ROUNDS: usize = 4;

/// Positions of a word.
const WORD: i64 = 1 << 24;

/// How many positions there are, as jumps from one end to the other show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Round {
    pub(crate) positions: i64,
    /// How often it was seen.
    pub(crate) times: usize,
}

/// A jump that may lead from one end to the other.
#[derive(Clone, Copy)]
struct Candidate {
    positions: i64,
    doubt: i64,
    top: i64,
}

/// The numbers of positions that jumps agree on, the most frequent first; `circle` where it agrees too.
pub(crate) fn found(points: &[Point], circle: Circle) -> Vec<Round> {
    let mut candidates: Vec<Candidate> = points.windows(4).filter_map(candidate).take(CANDIDATES).collect();
    let mut rounds = Vec::new();
    while let Some(best) = candidates.iter().max_by_key(|one| agreeing(&candidates, one)) {
        let (group, others) = candidates.iter().copied().partition(|other| agrees(best, other));
        let group: Vec<Candidate> = group;
        rounds.push(Round { positions: agreed(&group, circle), times: group.len() });
        candidates = others;
        if rounds.len() == ROUNDS {
            break;
        }
    }
    rounds
}

/// What a group of jumps agrees on.
fn agreed(group: &[Candidate], circle: Circle) -> i64 {
    let mut positions: Vec<i64> = group.iter().map(|one| one.positions).collect();
    positions.sort_unstable();
    let middle = positions.get(positions.len() / 2).copied().unwrap_or_default();
    let top = group.iter().map(|one| one.top).max().unwrap_or_default();
    let doubt = group.iter().map(|one| one.doubt).min().unwrap_or_default();
    let (low, high) = ((middle - doubt).max(top + 1), (middle + doubt).max(top + 1));
    for known in [circle.positions, 1 << 16] {
        if known > top && (known - middle).abs() <= 2 * doubt {
            return known;
        }
    }
    roundest(low, high)
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
