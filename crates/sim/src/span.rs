//! A span of time as people write it.

use std::time::Duration as Real;

use encoring_words::Duration;

/// Reads a time: `90s`, `1h 30m`, `100ms`; a plain number is seconds.
///
/// # Errors
/// What is wrong with it; no time at all is none.
pub fn read(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| s.is_finite() && *s >= 0.0);
    let real = match seconds {
        Some(seconds) => Real::try_from_secs_f64(seconds).map_err(|cause| cause.to_string()),
        None => humantime::parse_duration(text)
            .map_err(|_| "no time; write 10 (seconds), 90s, 100ms or 1h30m".to_owned()),
    }?;
    match u64::try_from(real.as_nanos()) {
        Ok(0) => Err("a time is longer than 0".to_owned()),
        Ok(nanos) => Ok(Duration::from_nanos(nanos)),
        Err(_) => Err("longer than 584 years".to_owned()),
    }
}

/// Writes a time so that [`read`] reads the same: in the largest unit of which it is a whole number.
#[must_use]
pub fn written(span: Duration) -> String {
    let nanos = span.as_nanos();
    // Seconds have no sign, and as whole numbers up to 2^53 they are read exactly.
    for (unit, sign) in [(1_000_000_000, ""), (1_000_000, "ms"), (1_000, "us")] {
        if nanos.is_multiple_of(unit) {
            return format!("{}{sign}", nanos / unit);
        }
    }
    format!("{nanos}ns")
}
