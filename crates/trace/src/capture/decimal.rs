//! Numbers of captures, exactly.

/// A decimal number with so many decimal places as a whole number, rounded towards zero: `1.5e-5` with 9 places is 15000.
#[expect(clippy::disallowed_methods, reason = "the exponent of a decimal number")]
pub(super) fn scaled(text: &str, places: i32) -> Option<i64> {
    let (mantissa, exponent) = match text.find(['e', 'E']) {
        Some(at) => (text.get(..at)?, text.get(at + 1..)?.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (negative, digits) = match mantissa.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, mantissa.strip_prefix('+').unwrap_or(mantissa)),
    };
    let (whole, decimals) = digits.split_once('.').unwrap_or((digits, ""));
    let all = || whole.bytes().chain(decimals.bytes());
    if digits.len() > 64 || all().next().is_none() || !all().all(|digit| digit.is_ascii_digit()) {
        return None;
    }
    // How many of the digits stand before the unit.
    let kept = i32::try_from(whole.len()).ok()?.checked_add(exponent)?.checked_add(places)?;
    let mut value = 0_i64;
    let mut count = 0;
    for digit in all() {
        if count == kept.max(0) {
            break;
        }
        value = value.checked_mul(10)?.checked_add(i64::from(digit - b'0'))?;
        count += 1;
    }
    while value != 0 && count < kept {
        value = value.checked_mul(10)?;
        count += 1;
    }
    Some(if negative { -value } else { value })
}

/// A rate as people write it in hertz: `1 MHz`, `500kHz`, `24000000`; `None` for anything else, and for 0.
#[must_use]
pub fn hertz(text: &str) -> Option<u64> {
    let text = text.trim();
    let at = text.find(|sign: char| sign.is_alphabetic()).unwrap_or(text.len());
    let places = match text.get(at..)?.to_ascii_lowercase().as_str() {
        "" | "hz" => 0,
        "khz" | "k" => 3,
        "mhz" | "m" => 6,
        "ghz" | "g" => 9,
        _ => return None,
    };
    let hertz = scaled(text.get(..at)?.trim_end(), places)?;
    u64::try_from(hertz).ok().filter(|hertz| *hertz > 0)
}

const SECOND_NS: u64 = 1_000_000_000;

/// How often samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SampleRate {
    hertz: u64,
    /// Nanoseconds between two samples, rounded down.
    period_ns: u64,
    /// The period is so many whole nanoseconds.
    is_whole: bool,
}

impl SampleRate {
    /// So many samples a second, at least one.
    pub(super) const fn new(hertz: u64) -> Self {
        let hertz = if hertz == 0 { 1 } else { hertz };
        Self { hertz, period_ns: SECOND_NS / hertz, is_whole: SECOND_NS.is_multiple_of(hertz) }
    }

    pub(super) const fn hertz(self) -> u64 {
        self.hertz
    }

    pub(super) const fn period_ns(self) -> u64 {
        self.period_ns
    }

    /// The time of a sample in nanoseconds, rounded down; `None` beyond what 64 bits hold.
    pub(super) fn time_ns(self, number: u64) -> Option<u64> {
        // Most rates need no division, which takes longer than all else that a change costs.
        if self.is_whole {
            return number.checked_mul(self.period_ns);
        }
        u64::try_from(u128::from(number) * u128::from(SECOND_NS) / u128::from(self.hertz)).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact_or_refused() {
        for (text, places, value) in [
            ("0", 9, Some(0)),
            ("1.5", 9, Some(1_500_000_000)),
            ("0.000000001", 9, Some(1)),
            ("0.0000000019", 9, Some(1)),
            ("-0.25", 9, Some(-250_000_000)),
            ("1.5e-05", 9, Some(15_000)),
            ("2E3", 0, Some(2_000)),
            ("+3", 3, Some(3_000)),
            (".5", 1, Some(5)),
            ("12345", -2, Some(123)),
            ("0e999999999", 9, Some(0)),
            ("9223372037", 9, None),
            ("1e2147483647", 9, None),
            ("", 9, None),
            ("-", 9, None),
            (".", 9, None),
            ("1.2.3", 9, None),
            ("0x10", 9, None),
            ("nan", 9, None),
        ] {
            assert_eq!(scaled(text, places), value, "{text}");
        }
    }

    #[test]
    fn rates_have_units() {
        for (text, hz) in [
            ("1 MHz", Some(1_000_000)),
            ("500kHz", Some(500_000)),
            ("24000000", Some(24_000_000)),
            ("1.25 GHz", Some(1_250_000_000)),
            ("20 m", Some(20_000_000)),
            ("0", None),
            ("-1", None),
            ("1 MB", None),
            ("", None),
        ] {
            assert_eq!(hertz(text), hz, "{text}");
        }
    }

    #[test]
    fn times_of_samples_do_not_drift() {
        let time_ns = |number, hertz| SampleRate::new(hertz).time_ns(number);
        assert_eq!(time_ns(24_000_000, 24_000_000), Some(1_000_000_000));
        assert_eq!(time_ns(1, 24_000_000), Some(41));
        assert_eq!(time_ns(1, 2_000_000_000), Some(0));
        assert_eq!(time_ns(20_000_000_001, 20_000_000), Some(1_000_000_000_050));
        assert_eq!(time_ns(u64::MAX, 1), None);
        assert_eq!(time_ns(u64::MAX, 3), None);
    }
}
