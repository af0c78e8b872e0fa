//! What a row of a recording shows of an encoder.

use encoring_ring::diagnostics::{Diagnosis, status};
use encoring_trace::bus::{BusEvent, BusRow};
use encoring_trace::{CycleSeen, Input, Row};

/// One row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// The line of the file, from 1; where there is no file, a number that grows.
    pub line: u64,
    /// When, in nanoseconds.
    pub time_ns: u64,
    /// The ring position.
    pub position: u8,
    /// The OUT word, if the row has one.
    pub out: Option<u32>,
    /// What came from the encoder.
    pub reading: Sighting,
}

/// What came from an encoder, as far as the recording kept it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sighting {
    /// The whole IN word.
    Word(u32),
    /// Its lower 24 bits.
    Bits24(u32),
    /// Its low half.
    Bits16(u16),
    /// A position as a number.
    Steps(i64),
    /// Nothing: the encoder is off, or the cycle was bad.
    Nothing,
    /// Nothing, as the ring's master says that no data cycle reaches the encoder.
    Unreached {
        /// What the master says.
        said: Diagnosis,
        /// What stands in the row all the same, as a number.
        stands: Option<i64>,
    },
}

impl Sample {
    /// What a row of a recording shows; `None` if it says nothing of a position.
    #[must_use]
    pub fn of_row(row: &Row) -> Option<Self> {
        let position = row.position.unwrap_or_default();
        let said = Diagnosis { status: row.status, parameter: row.parameter };
        let reading = match (row.input, row.value) {
            (input, value) if said.reaches(position.into()) == Some(false) => {
                let word = input.and_then(Input::word).map(i64::from);
                Sighting::Unreached { said, stands: word.or(value) }
            }
            (None, None) => return None,
            _ if is_lost(row.cycle) || is_faulty(said) => Sighting::Nothing,
            (Some(Input::Off), _) => Sighting::Nothing,
            (Some(Input::Word(word)), _) => Sighting::Word(word),
            (None, Some(steps)) => Sighting::Steps(steps),
        };
        Some(Self { line: row.line, time_ns: row.time_ns, position, out: row.out, reading })
    }

    /// What a row of a bus recording shows; `None` for a write, which shows nothing of an encoder.
    #[must_use]
    pub fn of_bus(row: &BusRow) -> Option<Self> {
        let BusEvent::Cycle { out, input, line } = row.event else { return None };
        let reading = match input {
            Some(Input::Word(word)) if !is_lost(line) => Sighting::Word(word),
            _ => Sighting::Nothing,
        };
        Some(Self { line: row.line, time_ns: row.time_ns, position: row.position, out: Some(out), reading })
    }
}

/// Whether the words are those of an earlier cycle.
fn is_faulty(said: Diagnosis) -> bool {
    said.status.is_some_and(|word| word & status::DC_RESULT != 0)
}

/// Whether nothing that came in this cycle is to be believed.
const fn is_lost(cycle: Option<CycleSeen>) -> bool {
    matches!(cycle, Some(CycleSeen::Bad | CycleSeen::Silent))
}
