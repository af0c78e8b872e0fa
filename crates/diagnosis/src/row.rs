//! What is kept of a row.

use encoring_words::InWord;
use encoring_words::word::{DATA_MAX, In};

use crate::sample::Sighting;

/// A row that is kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) line: u64,
    pub(crate) time_ns: i64,
    pub(crate) shown: Shown,
}

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    Position(i64),
    Reply(InWord),
    Foreign(u32),
    Nothing,
}

impl Shown {
    pub(crate) fn of(reading: Sighting) -> Self {
        match reading {
            Sighting::Word(word) => match InWord(word).decode() {
                In::Position { value, .. } => Self::Position(value.into()),
                In::Reply(reply) if !reply.reserve => Self::Reply(InWord(word)),
                In::Reply(_) | In::Foreign(_) => Self::Foreign(word),
            },
            Sighting::Bits24(bits) => Self::Position((bits & DATA_MAX).into()),
            Sighting::Bits16(half) => Self::Position(half.into()),
            Sighting::Steps(steps) => Self::Position(steps),
            Sighting::Nothing => Self::Nothing,
        }
    }
}
