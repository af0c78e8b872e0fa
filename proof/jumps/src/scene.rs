//! Where a jump happens: how the rows were taken, how the axis moves, what else the recording shows.

/// Radians of a turn, as the ratio of whole numbers that is a little too large.
const RADIANS: f64 = 710.0 / 113.0;

/// How a position stands in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    /// The whole IN word.
    Word,
    /// Its low 24 bits.
    Low24,
    /// Its low 16 bits.
    Low16,
    /// The position as a decimal number.
    Decimal,
}

/// What is known at the place of a jump. Lengths are steps that are shown, times seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene {
    /// From row to row.
    pub(crate) period: f64,
    /// How far the stamp of a row may lie from when it was taken.
    pub(crate) jitter: f64,
    /// The encoder's refresh [R8, R9].
    pub(crate) refresh: f64,
    /// How many positions there are until they begin again.
    pub(crate) positions: f64,
    /// At the place.
    pub(crate) speed: f64,
    /// What the axis can do at most: speed and acceleration.
    pub(crate) top_speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) column: Column,
    /// Services would be seen: OUT is in the rows.
    pub(crate) out_logged: bool,
    /// S, N and D are given with the recording.
    pub(crate) parameters_told: bool,
    /// The encoder has no preset inputs, and that is known [R72].
    pub(crate) no_preset_inputs: bool,
    /// Rows of steady motion before and after the place, the fewer of both.
    pub(crate) steady_rows: f64,
}

/// Steps a second, of a speed in revolutions a minute.
pub(crate) fn of_rpm(rpm: f64, steps_per_turn: f64) -> f64 {
    rpm / 60.0 * steps_per_turn
}

/// Steps a second squared, of an angular acceleration in rad/s^2.
pub(crate) fn of_rad(rad_s2: f64, steps_per_turn: f64) -> f64 {
    rad_s2 * steps_per_turn / RADIANS
}

impl Scene {
    /// Steps by which a row may lie off a smooth curve though nothing is wrong and nothing accelerates: rounding, the age
    /// of the sample, the stamp.
    pub(crate) fn noise(&self) -> f64 {
        2.0 + self.speed * (self.refresh + self.jitter)
    }

    /// Steps by which motion alone can leave the line through the rows before, from one row to the next.
    pub(crate) fn motion(&self) -> f64 {
        let accelerated = self.acceleration * self.period * self.period;
        accelerated.min(2.0 * self.top_speed * self.period) + self.noise()
    }

    /// Whether a jump of so many steps can be the motion of the axis. What the axis can do is learned from the same rows, so a
    /// jump must be three times as large as what motion can hide.
    pub(crate) fn hides(&self, jump: f64) -> bool {
        self.kept(jump) <= 3.0 * self.motion() || self.loses_count()
    }

    /// What the column keeps of a jump: of 16 bits nothing is left of a whole 65536.
    fn kept(&self, jump: f64) -> f64 {
        let jump = jump.abs();
        if self.column != Column::Low16 {
            return jump;
        }
        let part = jump % 65_536.0;
        part.min(65_536.0 - part)
    }

    /// Whether half of the positions can be passed from row to row: where the axis was in between is then unknown.
    pub(crate) fn loses_count(&self) -> bool {
        let positions =
            if self.column == Column::Low16 { self.positions.min(65_536.0) } else { self.positions };
        2.0 * (self.speed * self.period + self.motion()) >= positions
    }

    /// Steps a second by which the speed of one row and the next may differ, or seem to.
    pub(crate) fn speed_noise(&self) -> f64 {
        self.acceleration * self.period + self.noise() / (self.period * self.steady_rows.max(1.0))
    }

    /// The chance that a move from row to row passes one of the places that lie so many steps apart.
    pub(crate) fn passes(&self, apart: f64) -> f64 {
        (self.speed * self.period / apart).min(1.0)
    }

    /// The chance that the high half of the word is another in the row before or after: a word torn between them, or a flip
    /// of bit 16.
    pub(crate) fn carries(&self) -> f64 {
        self.passes(65_536.0 / 2.0)
    }
}
