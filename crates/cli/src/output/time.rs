//! Time as people read it.

use encoring_words::Duration;

/// A span of time as people read it.
pub(crate) fn span(span: Duration) -> String {
    let us = span.as_nanos() / 1_000;
    match us {
        0..1_000_000 => format!("{}.{} ms", us / 1_000, us / 100 % 10),
        _ => format!("{}.{} s", us / 1_000_000, us / 100_000 % 10),
    }
}

/// A point of time as people read it: seconds.
pub(crate) fn seconds(time_ns: u64) -> String {
    format!("{}.{:03}", time_ns / 1_000_000_000, time_ns / 1_000_000 % 1_000)
}
