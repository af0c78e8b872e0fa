//! What is said to a peer whose line is not even read.

use encoring_station::answer::refusal;
use serde::de::IgnoredAny;

/// The longest line that is read, in bytes without its end.
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// Why a line was not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unread {
    /// Bytes that are no text.
    #[error("the line is not UTF-8")]
    NotUtf8,
    /// A line without an end.
    #[error("the line is longer than {LINE_BYTES_MAX} bytes; the connection is closed")]
    TooLong,
    /// A browser.
    #[error("this is no HTTP server; the connection is closed")]
    Http,
    /// A first line that is no JSON object: another program that did not mean this port.
    #[error(
        "the first line is not a JSON object, which looks like {{\"verb\":\"help\"}}; the connection is closed"
    )]
    Stranger,
    /// Too many at once.
    #[error("{connections} connections are open, which is the limit; the connection is closed")]
    Full {
        /// The limit.
        connections: usize,
    },
}

impl Unread {
    /// The answer.
    pub(crate) fn answer(self) -> String {
        refusal(&self.to_string())
    }
}

/// Whether a line is a JSON object, of whatever keys.
pub(crate) fn is_object(text: &str) -> bool {
    text.trim_start().starts_with('{') && serde_json::from_str::<IgnoredAny>(text).is_ok()
}
