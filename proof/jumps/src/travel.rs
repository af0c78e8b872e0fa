//! How the axis moves: legs of constant acceleration.

use crate::chance::Chance;

/// From a time on, until the next leg. Lengths are steps of the sensor, times seconds.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from: f64,
    place: f64,
    speed: f64,
    acceleration: f64,
}

/// A movement.
#[derive(Clone, Debug)]
pub(crate) struct Travel {
    legs: Vec<Leg>,
}

/// What an axis does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    /// How long it keeps a speed, at least and at most.
    pub(crate) holds: (f64, f64),
    /// The ends between which it moves, if there are ends.
    pub(crate) ends: Option<(f64, f64)>,
    pub(crate) manner: Manner,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Manner {
    Stands,
    /// One speed.
    Runs,
    /// From speed to speed, both ways, with rests.
    Changes,
    /// To and fro between two places.
    Strokes,
    /// To and fro as a sine.
    Swings,
    /// A stand, and vibration within what the axis can do.
    Vibrates,
}

impl Travel {
    /// A movement that lasts so long.
    pub(crate) fn new(axis: &Axis, lasting: f64, chance: &mut Chance) -> Self {
        let place = match axis.ends {
            Some((least, most)) => least + (most - least) * chance.real(0.1, 0.9),
            None => chance.real(-1.0e6, 1.0e6),
        };
        let mut travel = Self { legs: vec![Leg { from: 0.0, place, speed: 0.0, acceleration: 0.0 }] };
        let mut sign = if chance.percent(50) { 1.0 } else { -1.0 };
        match axis.manner {
            Manner::Stands => {}
            Manner::Vibrates => travel.vibrate(axis, lasting),
            Manner::Swings => travel.swing(axis, lasting),
            Manner::Runs if axis.ends.is_none() => travel.set_speed(0.0, sign * axis.speed),
            Manner::Runs | Manner::Changes | Manner::Strokes => {
                let mut now = 0.0;
                while now < lasting {
                    let target = match axis.manner {
                        Manner::Changes if chance.percent(15) => 0.0,
                        Manner::Changes => sign * axis.speed * chance.real(0.1, 1.0),
                        _ => sign * axis.speed,
                    };
                    let hold = chance.real(axis.holds.0, axis.holds.1);
                    now = travel.go(now, target, axis, hold);
                    let turns = axis.manner != Manner::Runs || axis.ends.is_some();
                    if turns && (axis.manner == Manner::Strokes || chance.percent(40)) {
                        sign = -sign;
                    }
                }
            }
        }
        travel
    }

    fn set_speed(&mut self, now: f64, speed: f64) {
        let place = self.place(now);
        self.legs.push(Leg { from: now, place, speed, acceleration: 0.0 });
    }

    /// Changes to a speed and keeps it so long, or until an end comes near; returns when that is over.
    fn go(&mut self, now: f64, target: f64, axis: &Axis, hold: f64) -> f64 {
        let (place, speed) = (self.place(now), self.speed(now));
        let takes = (target - speed).abs() / axis.acceleration;
        let acceleration = if target > speed { axis.acceleration } else { -axis.acceleration };
        self.legs.push(Leg { from: now, place, speed, acceleration });
        let held = now + takes;
        let place = self.place(held);
        let mut hold = hold;
        if let Some((least, most)) = axis.ends {
            let brake = target * target / axis.acceleration;
            let room = if target > 0.0 { most - brake - place } else { place - least - brake };
            if target != 0.0 {
                hold = hold.min((room / target.abs()).max(0.0));
            }
        }
        self.legs.push(Leg { from: held, place, speed: target, acceleration: 0.0 });
        let mut over = held + hold;
        if axis.ends.is_some() {
            let place = self.place(over);
            let brake = target.abs() / axis.acceleration;
            let acceleration = if target > 0.0 { -axis.acceleration } else { axis.acceleration };
            self.legs.push(Leg { from: over, place, speed: target, acceleration });
            over += brake;
            let place = self.place(over);
            self.legs.push(Leg { from: over, place, speed: 0.0, acceleration: 0.0 });
        }
        over.max(now + 1e-4)
    }

    /// A sine of which the largest speed and acceleration are those of the axis, as far as its ends let it.
    fn swing(&mut self, axis: &Axis, lasting: f64) {
        let place = self.place(0.0);
        let mut speed = axis.speed;
        // Not above a few swings a second.
        let acceleration = axis.acceleration.min(speed / 0.03);
        if let Some((least, most)) = axis.ends {
            // Its width is twice the square of the speed by the acceleration.
            speed = speed.min(((most - place).min(place - least) * acceleration / 2.0).sqrt());
        }
        let mut speed_now = speed;
        let step = speed / acceleration / 16.0;
        let (mut now, mut place) = (0.0, place);
        let start = place;
        // The place against the middle is what the acceleration is set by.
        let stiffness = acceleration * acceleration / (speed * speed);
        while now < lasting {
            let middle = place + speed_now * step / 2.0;
            let leg = Leg { from: now, place, speed: speed_now, acceleration: -(middle - start) * stiffness };
            self.legs.push(leg);
            now += step;
            place = self.place(now);
            speed_now = self.speed(now);
        }
    }

    /// Up and down with the acceleration of the axis, 40 times a second.
    fn vibrate(&mut self, axis: &Axis, lasting: f64) {
        let quarter = 1.0 / 160.0;
        let mut now = lasting / 3.0;
        let mut sign = 1.0;
        self.legs.push(Leg {
            from: now,
            place: self.place(now),
            speed: 0.0,
            acceleration: axis.acceleration,
        });
        now += quarter;
        while now < lasting * 2.0 / 3.0 {
            sign = -sign;
            let (place, speed) = (self.place(now), self.speed(now));
            self.legs.push(Leg { from: now, place, speed, acceleration: sign * axis.acceleration });
            now += 2.0 * quarter;
        }
        self.legs.push(Leg { from: now, place: self.place(now), speed: 0.0, acceleration: 0.0 });
    }

    /// Another speed from a time on, for so long, and then the speed from before for good. `accelerations` are those to it and
    /// back.
    pub(crate) fn burst(&mut self, from: f64, speed: f64, lasting: f64, accelerations: (f64, f64)) {
        let (place, was) = (self.place(from), self.speed(from));
        self.legs.retain(|leg| leg.from < from);
        let sign = if speed > was { 1.0 } else { -1.0 };
        let way = (speed - was).abs();
        let up = sign * accelerations.0;
        self.legs.push(Leg { from, place, speed: was, acceleration: up });
        let reached = from + way / accelerations.0;
        self.legs.push(Leg { from: reached, place: self.place(reached), speed, acceleration: 0.0 });
        let over = reached + lasting;
        let down = -sign * accelerations.1;
        self.legs.push(Leg { from: over, place: self.place(over), speed, acceleration: down });
        let back = over + way / accelerations.1;
        self.legs.push(Leg { from: back, place: self.place(back), speed: was, acceleration: 0.0 });
    }

    fn leg(&self, at: f64) -> Option<&Leg> {
        let behind = self.legs.partition_point(|leg| leg.from <= at);
        self.legs.get(behind.saturating_sub(1))
    }

    pub(crate) fn place(&self, at: f64) -> f64 {
        self.leg(at).map_or(0.0, |leg| {
            let passed = at - leg.from;
            leg.place + leg.speed * passed + leg.acceleration * passed * passed / 2.0
        })
    }

    pub(crate) fn speed(&self, at: f64) -> f64 {
        self.leg(at).map_or(0.0, |leg| leg.speed + leg.acceleration * (at - leg.from))
    }

    /// The time around a moment in which the speed does not change.
    pub(crate) fn steady(&self, at: f64) -> (f64, f64) {
        let behind = self.legs.partition_point(|leg| leg.from <= at);
        let next = self.legs.get(behind).map_or(f64::MAX, |leg| leg.from);
        match self.legs.get(behind.saturating_sub(1)) {
            Some(leg) if leg.acceleration == 0.0 => (leg.from, next),
            _ => (at, at),
        }
    }
}
