//! A time as people write it.

use std::time::Duration as Real;

use encoring_words::Duration;

/// A time as people write it; a plain number is seconds.
pub(crate) fn span(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| s.is_finite() && *s >= 0.0);
    let real = match seconds {
        Some(seconds) => Real::try_from_secs_f64(seconds).map_err(|cause| cause.to_string()),
        None => humantime::parse_duration(text).map_err(|cause| cause.to_string()),
    }?;
    match u64::try_from(real.as_nanos()) {
        Ok(0) => Err("no time at all".to_owned()),
        Ok(nanos) => Ok(Duration::from_nanos(nanos)),
        Err(_) => Err("longer than 584 years".to_owned()),
    }
}
