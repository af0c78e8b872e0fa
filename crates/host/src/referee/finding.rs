//! What a referee says.

use super::rule::HandshakeRule;
use encoring_words::{Duration, InWord, Instant, OutWord};

/// What a finding says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ruling {
    /// The rule was broken.
    Broken,
    /// A right program could look the same.
    Suspected,
    /// Something to know.
    Note,
}

impl Ruling {
    /// Its name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Broken => "broken",
            Self::Suspected => "suspected",
            Self::Note => "note",
        }
    }
}

/// Breaks of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Which.
    pub rule: HandshakeRule,
    /// The surest verdict so far.
    pub verdict: Ruling,
    /// When it was broken first.
    pub first: Instant,
    /// And last.
    pub last: Instant,
    /// How often; of a row of writes or reads, how many were in it.
    pub count: u32,
    /// OUT at the first break.
    pub out: OutWord,
    /// IN then; `None` if it was not known.
    pub input: Option<InWord>,
}

/// Writes that a cell of the EEPROM is assumed to stand. No manual says.
pub const WRITES_ASSUMED: u64 = 100_000;

impl Finding {
    /// Days until [`WRITES_ASSUMED`] writes, if it goes on like this; `None` for other rules.
    #[must_use]
    pub fn days_to_wear(&self) -> Option<u64> {
        let pauses = u64::from(self.count.saturating_sub(1));
        let each = self.last.since(self.first).as_nanos().checked_div(pauses)?;
        let day = Duration::from_secs(86_400).as_nanos();
        let all = u128::from(each) * u128::from(WRITES_ASSUMED) / u128::from(day);
        matches!(self.rule, HandshakeRule::MemoryWear).then_some(u64::try_from(all).unwrap_or(u64::MAX))
    }
}

/// What was wrong with what was observed; none of it is judged as a break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Observations that lay before the one before.
    pub backwards: u32,
    /// Pauses between cycles that were far longer than usual.
    pub gaps: u32,
    /// Cycles whose OUT word nobody was seen to write.
    pub unseen_writes: u32,
    /// Writes of half a word of which the other half was not known.
    pub lone_halves: u32,
}
