//! A preset input: a voltage that must stand for a second [R66, R68..R71, C32, C40].

use encoring_words::sheet::PRESET_INPUT;
use encoring_words::{Duration, Instant};

/// Above this many millivolts the input is 1 [R71].
pub const HIGH_ABOVE_MV: u32 = PRESET_INPUT.high_above_mv;

/// Below this many millivolts the input is 0 [R71].
pub const LOW_BELOW_MV: u32 = PRESET_INPUT.low_below_mv;

/// Above this many millivolts the input gets more than it is made for; it still reads 1 [R71].
pub const OVERVOLTAGE_ABOVE_MV: u32 = PRESET_INPUT.max_mv;

/// How long the input must be energised [R69].
pub const ENERGISED_FOR: Duration = Duration::from_secs(1);

/// One preset input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetInput {
    level: bool,
    /// Not before the level has been 0: after an adjustment, and for an input that was 1 at power-up.
    spent: bool,
    since: Option<Instant>,
}

impl PresetInput {
    /// The state before the first exchange: level 0.
    pub const POWER_UP: Self = Self { level: false, spent: true, since: None };

    /// Looks at the input in an exchange; `true` if the encoder is to be adjusted now.
    pub fn exchange(&mut self, now: Instant, millivolts: u32, service_mode: bool) -> bool {
        if millivolts > HIGH_ABOVE_MV {
            self.level = true;
        } else if millivolts < LOW_BELOW_MV {
            self.level = false;
        }
        if !self.level {
            self.spent = false;
        }
        if !self.level || self.spent || service_mode {
            self.since = None;
            return false;
        }
        let since = *self.since.get_or_insert(now);
        if now.since(since) < ENERGISED_FOR {
            return false;
        }
        self.spent = true;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Instant {
        Instant(ms * 1_000_000)
    }

    fn ready() -> PresetInput {
        let mut input = PresetInput::POWER_UP;
        assert!(!input.exchange(at(0), 0, false));
        input
    }

    #[test]
    fn a_second_of_more_than_11_v_adjusts_once() {
        let mut input = ready();
        assert!(!input.exchange(at(10), 24_000, false));
        assert!(!input.exchange(at(1_009), 24_000, false));
        assert!(input.exchange(at(1_010), 24_000, false));
        assert!(!input.exchange(at(5_000), 24_000, false));
        assert!(!input.exchange(at(5_001), 9_500, false), "between the levels nothing changes");
        assert!(!input.exchange(at(5_002), 24_000, false));
        assert!(!input.exchange(at(9_000), 24_000, false));
        assert!(!input.exchange(at(9_001), 7_999, false));
        assert!(!input.exchange(at(9_002), 11_001, false));
        assert!(input.exchange(at(10_002), 8_000, false), "8 V keeps the level");
    }

    #[test]
    fn exactly_11_v_is_not_yet_1() {
        let mut input = ready();
        input.exchange(at(1), 11_000, false);
        assert!(!input.exchange(at(2_000), 11_000, false));
    }

    #[test]
    fn an_input_that_is_1_at_power_up_waits_for_a_0() {
        let mut input = PresetInput::POWER_UP;
        assert!(!input.exchange(at(0), 24_000, false));
        assert!(!input.exchange(at(2_000), 24_000, false));
        assert!(!input.exchange(at(2_001), 0, false));
        assert!(!input.exchange(at(2_002), 24_000, false));
        assert!(input.exchange(at(3_002), 24_000, false));
    }

    #[test]
    fn service_mode_starts_the_second_anew_but_does_not_re_arm() {
        let mut input = ready();
        input.exchange(at(0), 24_000, false);
        assert!(!input.exchange(at(990), 24_000, true));
        assert!(!input.exchange(at(1_000), 24_000, false));
        assert!(!input.exchange(at(1_999), 24_000, false));
        assert!(input.exchange(at(2_000), 24_000, false));
        assert!(!input.exchange(at(2_001), 24_000, true));
        assert!(!input.exchange(at(9_000), 24_000, false));
    }
}
