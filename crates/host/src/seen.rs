//! What the master sees of an encoder.

use encoring_words::{Duration, InWord};

/// An IN word, as a poll of the bus brought it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// The word.
    pub input: InWord,
    /// How old it may be, as far as the bus can tell.
    pub age: Duration,
}
