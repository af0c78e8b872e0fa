//! The position as the specification writes it, in numbers that cannot overflow.

/// The active values of a rotary encoder.
#[derive(Clone, Copy, Debug)]
pub struct Rotary {
    pub q: i128,
    pub s: i128,
    pub n: i128,
    pub d: i128,
    pub falling: bool,
}

impl Rotary {
    /// `floor(((E' * D + offset) mod (Q * N)) * (S + 1) / (Q * N))`.
    pub fn value(&self, raw: i64, offset: i128) -> u32 {
        let range = self.range();
        let value = self.phase(raw, offset) * (self.s + 1) / range;
        u32::try_from(value).unwrap()
    }

    /// Q * N.
    pub fn range(&self) -> i128 {
        self.q * self.n
    }

    fn phase(&self, raw: i64, offset: i128) -> i128 {
        let e = i128::from(raw);
        let e = if self.falling { -1 - e } else { e };
        (e * self.d + offset).rem_euclid(self.range())
    }

    /// The offset that a preset to `value` at `raw` leaves: the smallest phase whose value it is.
    pub fn preset(&self, raw: i64, value: u32) -> i128 {
        let (range, value) = (self.range(), i128::from(value));
        let mut wanted = value * range / (self.s + 1);
        while wanted * (self.s + 1) / range < value {
            wanted += 1;
        }
        (wanted - self.phase(raw, 0)).rem_euclid(range)
    }

    /// Service words that program these values, then a data check.
    pub fn writes(&self) -> [u32; 4] {
        let data = |value: i128| u32::try_from(value).unwrap();
        [
            0xC100_0000 | u32::from(self.falling),
            0xC200_0000 | data(self.s),
            0xC300_0000 | data(self.n),
            0xC900_0000 | data(self.d),
        ]
    }
}

/// `floor(x' * S / L)` before the offset.
pub fn rod_steps(raw: i64, rod_um: i64, s: i64, decreasing: bool) -> i64 {
    let x = if decreasing { rod_um - raw } else { raw };
    x * s / rod_um
}
