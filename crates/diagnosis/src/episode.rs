//! What is found: the rows that one cause explains.

use encoring_texts::Said;

use crate::cause::{JumpCause, Likelihood};

/// The most alternatives that are told.
pub const ALTERNATIVES_MAX: usize = 3;

/// Rows that one cause explains: a jump, or a stretch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Episode {
    /// The line of its first row.
    pub line: u64,
    /// The line of its last row.
    pub to_line: u64,
    /// How many rows it is about.
    pub count: u64,
    /// When it began, in nanoseconds.
    pub time_ns: u64,
    /// The ring position.
    pub position: u8,
    /// The cause.
    pub cause: JumpCause,
    /// How sure that is.
    pub certainty: Likelihood,
    /// What else it may be, the likeliest first; at most [`ALTERNATIVES_MAX`].
    pub alternatives: Vec<JumpCause>,
    /// What would tell them apart; empty if nothing else is possible.
    pub apart: Vec<Said>,
    /// What speaks for it: words, differences, times.
    pub evidence: Vec<Said>,
}

/// What a whole recording says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Conclusion {
    /// What was found, in order of time.
    pub episodes: Vec<Episode>,
    /// Whether jumps of at least one encoder could be judged.
    pub is_judged: bool,
    /// What was judged.
    pub judged: Vec<Said>,
    /// What could not be judged, and why.
    pub limits: Vec<Said>,
}
