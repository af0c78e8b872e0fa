//! Whether a movement exists that shows these positions: the arithmetic of speed and acceleration.
//!
//! # Units
//!
//! Times are nanoseconds. Lengths are whole numbers of a unit that divides both the steps that are shown and those of
//! the sensor: on a shaft 1/(Q*N) of a step, which makes a step of the sensor `D*(S+1)` and a turn `Q*D*(S+1)`; on a
//! rod 1/L of a step, L in micrometres, which makes a micrometre `S`.
//!
//! # What a word says
//!
//! The sample of a word was taken at some time from [`Sample::earliest`] to [`Sample::latest`], and not before that of
//! the word before [C35]. A position says where the shaft was up to the *blur*: the position's own step, and one of
//! the sensor because its steps and those of the position do not begin at the same places.
//!
//! # Speed
//!
//! For every place `y` within the blur of the present position let `t(y)` be the earliest time at which a shaft that
//! keeps the speed `v` can be there, after it has shown everything before. The next position is impossible if `t` lies
//! after [`Sample::latest`] for each of its places, on both ways round. From `x` the shaft can go on to `y`, so `t(y)`
//! is at most `t(x) + |y - x| / v`; the way up is therefore shortest from the highest place, the way down from the
//! lowest, and the times of these two are all that has to be kept. They are never later than the true ones: times are
//! rounded down to the nanosecond. What is too much in a speed adds up over the polls, so that one only a little too
//! high is found once it has made up for the age that a sample may have.
//!
//! If both ways round are possible, nothing is known of where the shaft has been in between, and what was kept is given
//! up but for the two times.
//!
//! # Acceleration
//!
//! With mean speeds `v1` from `i` to `j` and `v2` from `j` to `k`, `(v2 - v1) / (t_k - t_i)` is the second divided
//! difference of the movement and so at most half of the largest acceleration. `v1`, `v2` and the time become the
//! intervals that their samples allow; only if the condition fails for all of them the movement is impossible. `k` is
//! the new sample, `i` and `j` are all pairs of eight that are kept, each about twice as old as the one before:
//! a short `j..k` shows a jump, a long one what a short one hides behind the age of the samples.

use encoring_words::Duration;

use super::Why;

/// How many samples are kept.
const KEPT: usize = 8;

/// Before every time that a master can tell.
pub(super) const EVER: i128 = -(1 << 100);

const NANOS_PER_S: i128 = 1_000_000_000;

/// Positions that begin again behind the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Circle {
    /// How many there are; from 1.
    pub positions: i64,
}

impl Circle {
    /// Steps upwards from one position to another, 0 to one less than there are positions.
    #[must_use]
    pub const fn up(self, from: i64, to: i64) -> i64 {
        let steps = to.saturating_sub(from);
        match if steps < 0 { steps.saturating_add(self.positions) } else { steps } {
            up if up >= 0 && up < self.positions => up,
            _ if self.positions > 0 => steps.rem_euclid(self.positions),
            _ => 0,
        }
    }

    /// The shorter way from one position to another, in steps; upwards counts positive.
    #[must_use]
    pub const fn way(self, from: i64, to: i64) -> i64 {
        let up = self.up(from, to);
        if up > self.positions / 2 { up.saturating_sub(self.positions) } else { up }
    }

    /// The position so many steps further.
    #[must_use]
    pub const fn moved(self, from: i64, steps: i64) -> i64 {
        let positions = if self.positions < 1 { 1 } else { self.positions };
        from.saturating_add(steps).rem_euclid(positions)
    }
}

/// The positions, and how the place that they show may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Space {
    pub(super) circle: Circle,
    /// Units a step.
    pub(super) step: i128,
    /// Units that may lie between the lowest and the highest place of one position.
    pub(super) blur: i128,
    /// Units a second, above 0.
    pub(super) speed: Option<i128>,
    /// Units a second squared, above 0.
    pub(super) acceleration: Option<i128>,
    /// How many steps lie between the ends, if there are ends.
    pub(super) reach: Option<i64>,
}

/// A position, and when it may have been so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sample {
    pub(super) value: u32,
    pub(super) earliest: i128,
    pub(super) latest: i128,
}

/// A sample that is kept for the acceleration.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// Steps since the track began, not wrapped.
    place: i64,
    earliest: i128,
    latest: i128,
}

/// Everything that a plausible row of samples leaves to know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    value: u32,
    place: i64,
    lowest: i64,
    highest: i64,
    /// The earliest time at the lowest place of the position.
    bottom: i128,
    /// The earliest time at the highest.
    top: i128,
    /// The newest first.
    kept: [Option<Kept>; KEPT],
    /// How many have been kept.
    count: u32,
}

/// One way from a position to the next.
#[derive(Clone, Copy)]
struct Way {
    steps: i64,
    bottom: i128,
    top: i128,
}

impl Space {
    /// The shorter distance of two positions, in steps.
    pub(super) fn distance(&self, from: u32, to: u32) -> i64 {
        self.circle.way(from.into(), to.into()).saturating_abs()
    }

    /// A position that moves as another does: on a rod it stays between the ends.
    pub(super) fn moved(&self, position: u32, from: u32, to: u32) -> u32 {
        let moved = match self.reach {
            None => self.circle.moved(position.into(), self.circle.up(from.into(), to.into())),
            Some(end) => i64::from(position).saturating_add(i64::from(to) - i64::from(from)).clamp(0, end),
        };
        u32::try_from(moved).unwrap_or(position)
    }

    pub(super) const fn without_acceleration(self) -> Self {
        Self { acceleration: None, ..self }
    }

    /// Whether something in the range is too far away to be reached in so many nanoseconds.
    pub(super) fn excludes(&self, nanos: i128) -> bool {
        let Some(speed) = self.speed else { return true };
        let reached = floor(speed.saturating_mul(nanos), NANOS_PER_S).unwrap_or(0).saturating_add(self.blur);
        reached.saturating_mul(2) < self.units(self.circle.positions)
    }

    fn units(&self, steps: i64) -> i128 {
        i128::from(steps).saturating_mul(self.step)
    }

    /// The least time for a distance, which is negative for places that overlap.
    fn time(&self, units: i128) -> i128 {
        match self.speed {
            Some(speed) => floor(units.saturating_mul(NANOS_PER_S), speed).unwrap_or(0),
            None => 0,
        }
    }

    /// The lowest and the highest mean speed between two samples, in units a second.
    fn speeds(&self, from: &Kept, to: &Kept) -> (i128, i128) {
        let units = self.units(to.place.wrapping_sub(from.place));
        let longest = to.latest.saturating_sub(from.earliest);
        let shortest = to.earliest.saturating_sub(from.latest);
        let highest = |units: i128| {
            let time = if units > 0 { shortest } else { longest };
            let scaled = units.saturating_mul(NANOS_PER_S);
            let found =
                if time > 0 { floor(scaled, time).map(|speed| speed.saturating_add(1)) } else { None };
            found.unwrap_or(i128::MAX).min(self.speed.unwrap_or(i128::MAX))
        };
        let lowest = highest(self.blur.saturating_sub(units)).saturating_neg();
        (lowest, highest(units.saturating_add(self.blur)))
    }

    /// `true` if no movement within the acceleration shows these three, one after the other; `after` are the speeds from
    /// `j` to `k`.
    fn too_sudden(&self, i: &Kept, j: &Kept, k: &Kept, after: (i128, i128)) -> bool {
        let Some(acceleration) = self.acceleration else { return false };
        let time = k.latest.saturating_sub(i.earliest);
        let Some(change) = floor(acceleration.saturating_mul(time), 2 * NANOS_PER_S) else { return false };
        let before = self.speeds(i, j);
        let rise = after.0.saturating_sub(before.1);
        let fall = before.0.saturating_sub(after.1);
        rise.max(fall) > change.saturating_add(1)
    }
}

/// Rounded down; `None` without a divisor.
fn floor(dividend: i128, divisor: i128) -> Option<i128> {
    if divisor <= 0 {
        return None;
    }
    // Most numbers are small, and dividing large ones takes many times as long.
    match (i64::try_from(dividend), i64::try_from(divisor)) {
        (Ok(dividend), Ok(divisor)) => dividend.checked_div_euclid(divisor).map(i128::from),
        _ => dividend.checked_div_euclid(divisor),
    }
}

impl Track {
    /// A track that begins with a sample, of which nothing is known but itself.
    pub(super) const fn begin(sample: &Sample) -> Self {
        let first = Kept { place: 0, earliest: sample.earliest, latest: sample.latest };
        Self {
            value: sample.value,
            place: 0,
            lowest: 0,
            highest: 0,
            bottom: sample.earliest,
            top: sample.earliest,
            kept: [Some(first), None, None, None, None, None, None, None],
            count: 1,
        }
    }

    /// The last position.
    pub(super) const fn value(&self) -> u32 {
        self.value
    }

    /// Whether all its samples lie at one place.
    pub(super) const fn has_stood(&self) -> bool {
        self.lowest == self.highest
    }

    /// Whether the samples that are kept lie at different places.
    pub(super) fn moves(&self) -> bool {
        self.kept.iter().flatten().any(|kept| kept.place != self.place)
    }

    /// The most time that there can have been from its last sample to another.
    pub(super) fn time_to(&self, sample: &Sample) -> i128 {
        sample.latest.saturating_sub(self.bottom.min(self.top))
    }

    /// The track with one more sample, or why no movement shows both.
    pub(super) fn follow(&self, space: &Space, sample: &Sample, refresh: Duration) -> Result<Self, Why> {
        let up = space.circle.up(self.value.into(), sample.value.into());
        // The other way round; the whole round if the position is the same.
        let down = up.saturating_sub(space.circle.positions);
        let ways = [self.way(space, sample, up), self.way(space, sample, down)];
        let [up, down] = ways.map(|way| way.filter(|way| way.bottom.min(way.top) <= sample.latest));
        match (up, down) {
            (None, None) => {
                let within = Duration(
                    u64::try_from(sample.latest.saturating_sub(self.bottom.min(self.top)))
                        .unwrap_or(u64::MAX),
                );
                let (from, to) = (self.value, sample.value);
                Err(match (ways, space.reach) {
                    ([None, None], Some(end)) => Why::OffTheRod { from, to, measuring_length: end as u32 },
                    _ => Why::Speed { from, to, within },
                })
            }
            (Some(up), Some(down)) => {
                // Both ways are possible: where it has been since is not known.
                let (bottom, top) = (up.bottom.min(down.bottom), up.top.min(down.top));
                Ok(Self { bottom, top, ..Self::begin(&Sample { earliest: bottom.min(top), ..*sample }) })
            }
            (Some(way), None) | (None, Some(way)) => self.along(space, sample, refresh, way),
        }
    }

    /// The times of one way; `None` if it leads beyond an end.
    fn way(&self, space: &Space, sample: &Sample, steps: i64) -> Option<Way> {
        let place = self.place.wrapping_add(steps);
        let reach = self.highest.max(place).saturating_sub(self.lowest.min(place));
        if space.reach.is_some_and(|end| reach > end) {
            return None;
        }
        let units = space.units(steps);
        let earliest = sample.earliest.max(self.bottom.min(self.top));
        let after = |from: i128, units: i128| from.saturating_add(space.time(units)).max(earliest);
        let (bottom, top) = match steps {
            0 => (self.bottom.max(earliest), self.top.max(earliest)),
            1.. => (after(self.top, units.saturating_sub(space.blur)), after(self.top, units)),
            _ => {
                let units = units.saturating_neg();
                (after(self.bottom, units), after(self.bottom, units.saturating_sub(space.blur)))
            }
        };
        Some(Way { steps, bottom, top })
    }

    /// The track along the only way, if its acceleration allows that.
    fn along(&self, space: &Space, sample: &Sample, refresh: Duration, way: Way) -> Result<Self, Why> {
        let place = self.place.wrapping_add(way.steps);
        let new = Kept { place, earliest: way.bottom.min(way.top), latest: sample.latest };
        let mut later = self.kept.iter().flatten();
        while let Some(j) = later.next() {
            let after = space.speeds(j, &new);
            if later.clone().any(|i| space.too_sudden(i, j, &new, after)) {
                return Err(Why::Acceleration { from: self.value, to: sample.value });
            }
        }
        let mut track = Self {
            value: sample.value,
            place,
            lowest: self.lowest.min(place),
            highest: self.highest.max(place),
            bottom: way.bottom,
            top: way.top,
            ..*self
        };
        track.keep(new, refresh);
        Ok(track)
    }

    /// Keeps a sample as the newest. It takes the place of the one before if that is no refresh time younger than the
    /// second. Otherwise, of 2^k new ones, one moves the samples up to the k-th place on, as the bits of a counter
    /// change: the k-th is then 2^k - 1 to 2^(k+1) - 2 samples older than the newest.
    fn keep(&mut self, new: Kept, refresh: Duration) {
        let [newest, second, ..] = self.kept;
        let apart = match (newest, second) {
            (Some(newest), Some(second)) => newest.earliest.saturating_sub(second.earliest),
            _ => i128::MAX,
        };
        if apart >= i128::from(refresh.as_nanos()) {
            self.count = self.count.wrapping_add(1);
            let last = self.count.trailing_zeros() as usize;
            if let Some(moved) = self.kept.get_mut(..=last.min(KEPT - 1)) {
                moved.rotate_right(1);
            }
        }
        if let Some(place) = self.kept.first_mut() {
            *place = Some(new);
        }
    }
}
