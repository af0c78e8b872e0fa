//! How long a data cycle takes: `(13 * (6 + n) + 1.5 * m) * t_bit + t_sw + t_ph`.

use encoring_words::Duration;

use crate::profile::{BIT_500K, CABLE_NS_PER_M, ENCODER_BYTES, FRAME_BYTES, MASTER_SOFTWARE, TELEGRAM_BITS};

/// What the cycle time depends on beside the devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CycleTime {
    /// One line bit: 2 us at 500 kbit/s, 0.5 us at 2 Mbit/s.
    pub bit: Duration,
    /// The master's software time; 0.2 ms unless its manual says otherwise.
    pub software: Duration,
    /// Length of the remote bus cable in metres, up to 12 800.
    pub cable_m: u32,
}

impl Default for CycleTime {
    fn default() -> Self {
        Self { bit: BIT_500K, software: MASTER_SOFTWARE, cable_m: 0 }
    }
}

/// The most remote bus devices of a ring; the formula counts these.
pub const REMOTE_DEVICES_MAX: u32 = 254;

/// The longest remote bus in metres.
pub const CABLE_M_MAX: u32 = 12_800;

/// The terms of the formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// `13 * (6 + n)` bits: loopback word, data, check word and end word.
    pub telegrams: Duration,
    /// `1.5 * m` bits: what the devices delay.
    pub devices: Duration,
    /// The master's software time.
    pub software: Duration,
    /// What the cable delays.
    pub cable: Duration,
}

impl CycleTime {
    /// The terms of [`CycleTime::of`].
    #[must_use]
    pub const fn terms(&self, bytes: u32, devices: u32) -> Terms {
        let bit = self.bit.as_nanos();
        let telegram_bits = TELEGRAM_BITS * (FRAME_BYTES + bytes as u64);
        Terms {
            telegrams: Duration::from_nanos(telegram_bits.saturating_mul(bit)),
            devices: Duration::from_nanos((3 * devices as u64).saturating_mul(bit) / 2),
            software: self.software,
            cable: Duration::from_nanos(CABLE_NS_PER_M * self.cable_m as u64),
        }
    }

    /// The cycle of a ring with `devices` remote bus devices that hold `bytes` bytes of user data together.
    #[must_use]
    pub const fn of(&self, bytes: u32, devices: u32) -> Duration {
        // 1.5 bits a device, so the sum is kept in half bits.
        let half_bits = 2 * TELEGRAM_BITS * (FRAME_BYTES + bytes as u64) + 3 * devices as u64;
        let line = half_bits.saturating_mul(self.bit.as_nanos()) / 2;
        let cable = CABLE_NS_PER_M * self.cable_m as u64;
        Duration::from_nanos(line.saturating_add(self.software.as_nanos()).saturating_add(cable))
    }

    /// How long it takes at worst until the master has a position that shows a motion: the sensor was looked at just
    /// before (`refresh`), the sample just missed the cycle that was loaded (one cycle), and the next one carries it
    /// (one cycle).
    #[must_use]
    pub const fn worst_reaction(cycle: Duration, refresh: Duration) -> Duration {
        let cycles = cycle.as_nanos().saturating_mul(2);
        Duration::from_nanos(cycles.saturating_add(refresh.as_nanos()))
    }

    /// The cycle of a ring that holds nothing but `encoders` encoders.
    #[must_use]
    pub const fn of_encoders(&self, encoders: u32) -> Duration {
        self.of(encoders.saturating_mul(ENCODER_BYTES as u32), encoders)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::BIT_2M;

    #[test]
    fn the_worked_cycles() {
        let slow = CycleTime::default();
        assert_eq!(slow.of(4, 1), Duration::from_micros(463));
        assert_eq!(slow.of(8, 2), Duration::from_micros(570));
        assert_eq!(slow.of(12, 3), Duration::from_micros(677));
        assert_eq!(slow.of(40, 10), Duration::from_micros(1_426));
        assert_eq!(slow.of(512, 128), Duration::from_micros(14_052));
        assert_eq!(CycleTime { cable_m: 1_000, ..slow }.of(40, 10), Duration::from_micros(1_442));
        let fast = CycleTime { bit: BIT_2M, ..slow };
        assert_eq!(fast.of(4, 1), Duration::from_nanos(265_750));
        assert_eq!(slow.of_encoders(3), slow.of(12, 3));
    }

    #[test]
    fn the_terms_are_the_cycle() {
        for bit in [BIT_500K, BIT_2M] {
            let cycle = CycleTime { bit, cable_m: 1_234, ..CycleTime::default() };
            for (bytes, devices) in [(0, 0), (4, 1), (12, 3), (512, 128), (510, REMOTE_DEVICES_MAX)] {
                let Terms { telegrams, devices: delay, software, cable } = cycle.terms(bytes, devices);
                let sum = [telegrams, delay, software, cable].map(Duration::as_nanos).iter().sum();
                assert_eq!(cycle.of(bytes, devices), Duration::from_nanos(sum));
            }
        }
    }

    // [R7]
    #[test]
    fn thirteen_bits_a_byte_are_the_manuals_300_kbaud_net() {
        let line = CycleTime { software: Duration::ZERO, ..CycleTime::default() };
        assert_eq!(1_000_000_000 / line.bit.as_nanos(), 500_000, "bits a second, gross");
        // Net are 8 of the 13 bits of a byte, and no more in a whole cycle of the longest ring.
        let byte = line.of(513, 0).as_nanos() - line.of(512, 0).as_nanos();
        let net = [8 * 1_000_000 / byte, 8 * 512 * 1_000_000 / line.of_encoders(128).as_nanos()];
        assert_eq!(net, [307, 295], "kbit a second");
        assert_eq!(net.map(|kbit| (kbit + 50) / 100 * 100), [300, 300], "as the manuals round it");
    }
}
