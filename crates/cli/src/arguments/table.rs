//! What a person says about a table that another program wrote.

use clap::Args;
use encoring_trace::{Columns, TableLayout};
use encoring_words::Duration;
use encoring_words::number::Bare;

use super::span;

/// How to read a table of another program.
#[derive(Args, Debug)]
#[command(next_help_heading = "Tables of other programs")]
pub(crate) struct TableArguments {
    /// Which column is which, by names or without a header by numbers from 1: "time_s=Time [s],in=DB10.ENC"
    ///
    /// Columns: time (dates, or with a unit in its header), time_s, time_ms, time_us, time_ns, in, in_high, in_low, out,
    /// out_high, out_low, position, value, raw, supply_v, magnet, preset1_v, preset2_v, line, status, parameter. A name
    /// with `,` or `=` stands in double quotes.
    #[arg(long, value_name = "COLUMNS")]
    columns: Option<Columns>,
    /// Time from row to row, where the table has none [default: 1ms]
    #[arg(long, value_name = "TIME", value_parser = span)]
    period: Option<Duration>,
    /// Words without sign and base mark are decimal
    #[arg(long)]
    decimal: bool,
}

impl TableArguments {
    pub(crate) fn layout(&self) -> TableLayout {
        TableLayout {
            columns: self.columns.clone(),
            period_ns: self.period.map(Duration::as_nanos),
            bare: if self.decimal { Bare::Decimal } else { Bare::Hexadecimal },
        }
    }
}
