//! The encoders as the corpus needs them, read from the manuals and from no code: sensor, scaling, words.

/// An encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Device {
    /// As a command line has it.
    pub(crate) model: &'static str,
    /// Steps of a turn; of a rod, micrometres.
    pub(crate) native: i64,
    pub(crate) kind: Kind,
    /// Refresh in microseconds [R8, R9].
    pub(crate) refresh_us: i64,
    pub(crate) preset_inputs: bool,
    /// The position on the bus may be in Gray code [R46].
    pub(crate) may_be_gray: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Shaft,
    Rod,
}

/// The encoders that are drawn from.
pub(crate) const DEVICES: [Device; 6] = [
    rotary("ce-65-m", 4_096, 500, false, true),
    rotary("ce-65-m", 8_192, 500, false, true),
    rotary("ce-100-m", 4_096, 1_000, true, false),
    rod(500),
    rod(1_500),
    rod(2_750),
];

const fn rotary(
    model: &'static str,
    native: i64,
    refresh_us: i64,
    preset_inputs: bool,
    may_be_gray: bool,
) -> Device {
    Device { model, native, kind: Kind::Shaft, refresh_us, preset_inputs, may_be_gray }
}

const fn rod(mm: i64) -> Device {
    let native = mm * 1_000;
    Device {
        model: "la-66",
        native,
        kind: Kind::Rod,
        refresh_us: 1_000,
        preset_inputs: true,
        may_be_gray: false,
    }
}

/// What is programmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Scaling {
    pub(crate) length: i64,
    pub(crate) numerator: i64,
    pub(crate) denominator: i64,
    pub(crate) falling: bool,
    /// Of the phase of a shaft; of a rod, of the value.
    pub(crate) offset: i64,
}

/// Positions of a rod go on beyond the length of it [C7].
const WORD: i64 = 1 << 24;

impl Scaling {
    /// How many positions there are.
    pub(crate) const fn positions(&self, device: &Device) -> i64 {
        match device.kind {
            Kind::Shaft => self.length + 1,
            Kind::Rod => WORD,
        }
    }

    /// The position, not yet taken back into its range, and how many there are.
    fn unwrapped(&self, device: &Device, place: i64) -> i128 {
        match device.kind {
            Kind::Shaft => {
                let place = if self.falling { -1 - place } else { place };
                let phase = i128::from(place) * i128::from(self.denominator) + i128::from(self.offset);
                let whole = i128::from(device.native) * i128::from(self.numerator);
                (phase * i128::from(self.length + 1)).div_euclid(whole)
            }
            Kind::Rod => {
                let place = place.clamp(0, device.native);
                let place = if self.falling { device.native - place } else { place };
                let scaled = i128::from(place) * i128::from(self.length) / i128::from(device.native);
                scaled + i128::from(self.offset)
            }
        }
    }

    /// The position at a place of the sensor.
    pub(crate) fn value(&self, device: &Device, place: i64) -> i64 {
        self.unwrapped(device, place).rem_euclid(i128::from(self.positions(device))) as i64
    }

    /// How often the positions have begun again.
    pub(crate) fn round(&self, device: &Device, place: i64) -> i64 {
        self.unwrapped(device, place).div_euclid(i128::from(self.positions(device))) as i64
    }

    /// Steps that are shown for each step of the sensor.
    pub(crate) fn shown(&self, device: &Device) -> f64 {
        match device.kind {
            Kind::Shaft => {
                (self.length + 1) as f64 * self.denominator as f64
                    / (device.native as f64 * self.numerator as f64)
            }
            Kind::Rod => self.length as f64 / device.native as f64,
        }
    }

    /// Moves the zero so that a place shows a value.
    pub(crate) fn preset(&mut self, device: &Device, place: i64, target: i64) {
        match device.kind {
            Kind::Shaft => {
                let whole = i128::from(device.native) * i128::from(self.numerator);
                let place = if self.falling { -1 - place } else { place };
                let phase =
                    (i128::from(target) * whole + i128::from(self.length)) / i128::from(self.length + 1);
                let offset = phase - i128::from(place) * i128::from(self.denominator);
                self.offset = offset.rem_euclid(whole) as i64;
            }
            Kind::Rod => {
                let without = Self { offset: 0, ..*self }.value(device, place);
                self.offset = (target - without).rem_euclid(WORD);
            }
        }
    }
}

/// A position in Gray code.
pub(crate) const fn to_gray(value: u32) -> u32 {
    value ^ value >> 1
}

/// The position of a Gray code of 24 bits.
pub(crate) fn from_gray(code: u32) -> u32 {
    (0..24).fold(0, |value, shift| value ^ code >> shift)
}
