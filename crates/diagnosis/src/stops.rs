//! Rows in which the master says that no data cycle reaches the encoder: what stands in them is no position.

use std::ops::Range;

use encoring_host::validity::Circle;
use encoring_ring::diagnostics::{Diagnosis, names};

use crate::cause::JumpCause;
use crate::evidence;
use crate::motion::way;
use crate::part::Part;
use crate::row::{ReadAs, Row};
use crate::sample::Sighting;
use crate::services::Services;
use crate::statements;
use crate::verdict::Judged;
use encoring_texts::{Hex, Said};

/// Rows of a stop.
#[derive(Clone, Copy, Debug)]
struct Stop {
    /// The lines of the first and the last row.
    lines: (u64, u64),
    rows: u64,
    said: Diagnosis,
    /// The position before.
    before: Option<i64>,
    /// What stands in all of its rows, if it is the same.
    stands: Option<i64>,
}

/// A stop that is over.
#[derive(Clone, Copy, Debug)]
struct Over {
    stop: Stop,
    /// The line behind it, and the position there.
    line: u64,
    after: i64,
}

/// The stops of an encoder's rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stops {
    open: Option<Stop>,
    /// Those that were not looked at yet.
    over: Vec<Over>,
    /// The last position before.
    last: Option<i64>,
    rows: u64,
    /// The line of the first row of all, and what the master said there.
    first: Option<(u64, Diagnosis)>,
}

impl Stops {
    /// Takes the next row.
    pub(crate) fn row(&mut self, row: &Row, usual: ReadAs) {
        if let Sighting::Unreached { said, stands } = row.reading {
            self.rows += 1;
            self.first.get_or_insert((row.line, said));
            let stop = self.open.get_or_insert(Stop {
                lines: (row.line, row.line),
                rows: 0,
                said,
                before: self.last,
                stands,
            });
            stop.lines.1 = row.line;
            stop.rows += 1;
            stop.stands = stop.stands.filter(|same| stands == Some(*same));
        } else if let Some(after) = row.position(usual) {
            let over = self.open.take().map(|stop| Over { stop, line: row.line, after });
            self.over.extend(over);
            self.last = Some(after);
        }
    }

    /// The jumps over stops that end in the range.
    pub(crate) fn finds(
        &mut self,
        part: &Part<'_>,
        services: &Services,
        finds: &mut Vec<(Range<usize>, Judged)>,
    ) {
        let until = part.rows.get(part.range.end).map_or(u64::MAX, |row| row.line);
        let ended = self.over.partition_point(|over| over.line < until);
        for over in self.over.drain(..ended) {
            let Some(judged) = over.judged(part.circle, part.tolerance, services) else { continue };
            let place = |line: u64| part.rows.partition_point(|row| row.line < line);
            let (first, behind) = (place(over.stop.lines.0), place(over.line));
            let is_kept = part.rows.get(first).is_some_and(|row| row.line == over.stop.lines.0);
            let rows = if is_kept { first..behind + 1 } else { behind..behind + 1 };
            finds.push((rows, judged));
        }
    }

    /// Which rows hold no position for that, and since when; `None` if there are none.
    pub(crate) fn limit(&self, position: u8, services: &Services) -> Option<Said> {
        let (line, said) = self.first?;
        Some(statements::not_reached(position, self.rows, services.place(line), words_of(said)))
    }
}

impl Over {
    /// The same word in every row, that of the position before, and another position behind them.
    fn judged(&self, circle: Circle, tolerance: i64, services: &Services) -> Option<Judged> {
        let Stop { lines, rows, said, before, stands } = self.stop;
        let before = before?;
        let jump = way(circle, before, self.after);
        // A cycle may have come between the row before and the stop.
        let is_held = way(circle, before, stands?).saturating_abs() <= tolerance;
        (is_held && jump.saturating_abs() > tolerance).then(|| {
            Judged::certain(
                JumpCause::Frozen,
                evidence::not_reached(services.place(lines.0), lines.1, rows, words_of(said)),
            )
            .since(evidence::over_stop(jump))
        })
    }
}

fn words_of(said: Diagnosis) -> Said {
    let status = said.status.unwrap_or_default();
    let names = names(status).collect::<Vec<_>>().join(", ");
    match said.parameter {
        Some(parameter) => evidence::master_names(Hex(status.into()), names, Hex(parameter.into())),
        None => evidence::master_says(Hex(status.into()), names),
    }
}

/// Whether a stop lies between two rows.
pub(crate) fn is_between(rows: &[Row], from: usize, to: usize) -> bool {
    let between = rows.get(from + 1..to).unwrap_or_default();
    between.iter().any(|row| matches!(row.reading, Sighting::Unreached { .. }))
}
