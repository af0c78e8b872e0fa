//! What a person says about a table that another program wrote.

use std::io::Read;

use clap::Args;
use encoring_trace::{Columns, Reader, TableLayout};
use encoring_words::Duration;
use encoring_words::number::Bare;

use super::span;
use crate::output::{Failure, bad_input, note};

/// How to read a table of another program.
#[derive(Args, Debug)]
#[command(next_help_heading = "Tables of other programs")]
pub(crate) struct TableArguments {
    /// Which column is which, by name, or by number from 1 without a header: "time_s=Time [s],in=DB10.ENC"
    ///
    /// Columns: time (dates, or with a unit in its header), time_s, time_ms, time_us, time_ns, in, in_high, in_low, out,
    /// out_high, out_low, position, value, raw, supply_v, magnet, preset1_v, preset2_v, line, status, parameter. Put a name
    /// that contains `,` or `=` into double quotes.
    #[arg(long, value_name = "COLUMNS")]
    columns: Option<Columns>,
    /// Time from row to row, such as 10ms, if the table has no times [default: 1ms]
    #[arg(long, value_name = "TIME", value_parser = span)]
    period: Option<Duration>,
    /// Read words without sign and base mark as decimal
    #[arg(long)]
    decimal: bool,
}

impl TableArguments {
    /// What words without sign and base mark are.
    pub(crate) const fn bare(&self) -> Bare {
        if self.decimal { Bare::Decimal } else { Bare::Hexadecimal }
    }

    /// Whether nothing is said about a table.
    pub(crate) const fn says_nothing(&self) -> bool {
        self.columns.is_none() && self.period.is_none() && !self.decimal
    }

    /// Reads a trace, a recording, a log or a table up to its header, and says what was assumed.
    pub(crate) fn reader<R: Read>(&self, name: &str, source: R) -> Result<Reader<R>, Failure> {
        let reader =
            Reader::with(name, source, &self.layout()).map_err(|error| bad_input(error.to_string()))?;
        tell_assumed(&reader, name);
        Ok(reader)
    }

    /// All that is said.
    pub(crate) fn layout(&self) -> TableLayout {
        TableLayout {
            columns: self.columns.clone(),
            period_ns: self.period.map(Duration::as_nanos),
            bare: self.bare(),
            faults: None,
        }
    }
}

/// Says, before the first row, what was assumed of a table.
pub(crate) fn tell_assumed<R: Read>(reader: &Reader<R>, name: &str) {
    if let Some(assumed) = reader.assumed() {
        note(&format!("note: {name}: {assumed}"));
    }
}

/// Says, behind the last row, what may have been read wrongly or was left out.
pub(crate) fn tell_doubts<R: Read>(reader: &Reader<R>, name: &str) {
    if reader.may_be_decimal() {
        note(&format!(
            "note: no word of {name} has a letter, and all were read as hexadecimal; if they are decimal, give --decimal"
        ));
    }
    if let Some(line) = reader.piece() {
        note(&format!(
            "note: {name} line {line} has no line end: the recording was cut off there, and this row is left out"
        ));
    }
}
