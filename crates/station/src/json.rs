//! How values that know nothing of `serde` stand in JSON: words in hex, as everywhere else.

use std::fmt::Display;

use encoring_encoder::handshake::Handshake;
use encoring_ring::Verdict;
use encoring_words::ErrorStatus;
use serde::{Serialize, Serializer};

/// As it is printed.
pub(crate) fn text<S: Serializer>(value: &impl Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// As it is printed, or `null`.
pub(crate) fn maybe_text<S: Serializer>(
    value: &Option<impl Display>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => text(value, serializer),
        None => serializer.serialize_none(),
    }
}

/// Four hex digits.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
pub(crate) fn hex<S: Serializer>(word: &u16, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{word:04X}"))
}

/// Four hex digits, or `null`.
pub(crate) fn maybe_hex<S: Serializer>(word: &Option<u16>, serializer: S) -> Result<S::Ok, S::Error> {
    match word {
        Some(word) => hex(word, serializer),
        None => serializer.serialize_none(),
    }
}

/// Four hex digits.
pub(crate) fn status<S: Serializer>(status: &ErrorStatus, serializer: S) -> Result<S::Ok, S::Error> {
    hex(&status.bits(), serializer)
}

/// The same, or `null`.
pub(crate) fn status_if_on<S: Serializer>(
    status: &Option<ErrorStatus>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match status {
        Some(bits) => self::status(bits, serializer),
        None => serializer.serialize_none(),
    }
}

/// `normal`, `busy`, `acknowledged`, or `ignoring` a stale service bit; `off` without one.
pub(crate) fn handshake<S: Serializer>(
    handshake: &Option<Handshake>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match handshake {
        None => "off",
        Some(Handshake::Normal) => "normal",
        Some(Handshake::Ignoring) => "ignoring",
        Some(Handshake::Busy { .. }) => "busy",
        Some(Handshake::Acknowledged { .. }) => "acknowledged",
    })
}

/// How a cycle went, and the segment at fault.
#[derive(Serialize)]
struct Line {
    line: &'static str,
    segment: Option<usize>,
}

/// As the keys `line` (`good`, `bad` or `silent`) and `segment`.
pub(crate) fn line<S: Serializer>(verdict: &Verdict, serializer: S) -> Result<S::Ok, S::Error> {
    let (line, segment) = match *verdict {
        Verdict::Good => ("good", None),
        Verdict::Bad { segment } => ("bad", Some(segment)),
        Verdict::Silent { segment } => ("silent", Some(segment)),
    };
    Line { line, segment }.serialize(serializer)
}
