//! A recording played into a device, and the IN words compared.

use std::fmt;

use encoring_device::Surroundings;
use encoring_encoder::{Magnet, Terminals};
use encoring_trace::{Input, Row, RowKind};
use encoring_words::ssi_frame::Level;
use encoring_words::{Instant, OutWord};

use crate::node::Node;

/// A row whose IN word is not what the device gave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Line of the file; the header is line 1.
    pub line: u64,
    /// The OUT word of the row.
    pub out: u32,
    /// What the row says.
    pub expected: Input,
    /// What the device said.
    pub got: Input,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, out, expected, got } = self;
        write!(f, "line {line}: out {out:08X} expected {expected} got {got}")
    }
}

/// Plays one row and gives what the device answered; an edge of the SSI clock has no answer on the bus. A row that does
/// not say the OUT word plays 0.
pub fn play(node: &mut Node, row: &Row) -> Option<Input> {
    let magnet = if row.magnet { Magnet::Present } else { Magnet::Missing };
    let terminals = Terminals { raw: row.raw, magnet, preset_mv: row.preset_mv };
    let around = Surroundings { terminals, supply_mv: row.supply_mv };
    let now = Instant(row.time_ns);
    match row.kind {
        RowKind::Exchange => {
            let input = node.step(now, OutWord(row.out.unwrap_or(0)), &around);
            Some(input.map_or(Input::Off, |input| Input::Word(input.0)))
        }
        RowKind::SsiEdge => {
            // The clock is High at rest, so no transfer begins; the encoder has learnt the time.
            node.ssi_clock(now, Level::High, &around);
            None
        }
    }
}

/// Compares a row's IN word with the answer; where one of them is missing there is no difference.
#[must_use]
pub fn compare(row: &Row, got: Option<Input>) -> Option<Difference> {
    let got = got?;
    let expected = row.input.filter(|expected| *expected != got)?;
    Some(Difference { line: row.line, out: row.out.unwrap_or(0), expected, got })
}

#[cfg(test)]
mod tests {
    use super::*;
    use encoring_encoder::{ServiceTimes, Unit};
    use encoring_trace::Reader;
    use encoring_words::Model;
    use encoring_words::model::Sensor;
    use std::fs::File;

    fn differences(file: &str, model: Model, sensor: Sensor) -> (usize, Vec<String>) {
        let path = format!("{}/../../vectors/{file}.csv", env!("CARGO_MANIFEST_DIR"));
        let mut unit = Unit::new(model, sensor).unwrap();
        unit.service_times = ServiceTimes::ZERO;
        let mut node = Node::new(unit);
        let rows = Reader::new(file, File::open(path).unwrap()).unwrap().map(Result::unwrap);
        let mut count = 0;
        let found = rows.filter_map(|row| {
            count += 1;
            let got = play(&mut node, &row);
            compare(&row, got).map(|difference| difference.to_string())
        });
        let found = found.collect();
        (count, found)
    }

    const Q4096: Sensor = Sensor::Rotary { steps_per_turn: 4096 };
    const Q8192: Sensor = Sensor::Rotary { steps_per_turn: 8192 };
    const ROD: Sensor = Sensor::Linear { rod_um: 500_000 };

    #[test]
    fn the_golden_traces_replay_without_a_difference() {
        for (file, model, sensor, rows) in [
            ("la-66", Model::La66, ROD, 4000),
            ("ce-100-m", Model::Ce100M, Q4096, 4000),
            ("ce-65-m", Model::Ce65M, Q4096, 4000),
            ("ce-65-m-8192", Model::Ce65M, Q8192, 4000),
            ("ce-100-m-travel", Model::Ce100M, Q4096, 1513),
            ("ce-65-m-travel", Model::Ce65M, Q4096, 1517),
        ] {
            let (count, found) = differences(file, model, sensor);
            assert_eq!(count, rows, "{file}");
            assert_eq!(found, Vec::<String>::new(), "{file}");
        }
    }

    #[test]
    fn a_trace_played_into_another_model_differs() {
        assert!(!differences("ce-100-m", Model::Ce65M, Q4096).1.is_empty());
        assert!(!differences("ce-65-m-8192", Model::Ce65M, Q4096).1.is_empty());
    }
}
