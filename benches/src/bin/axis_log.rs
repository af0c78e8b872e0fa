//! The log of an axis as CSV, for benches/diagnose: to and fro at changing speeds, a row a millisecond, now and then a wrong bit.

use std::io::{self, BufWriter, Write};

use clap::Parser;

/// Print the log of an axis.
#[derive(Parser)]
struct Arguments {
    /// Rows below the header.
    rows: u64,
}

/// Rows from one turn of the axis to the next.
const STROKE: u64 = 4_000;
const WRONG_EVERY: u64 = 250_007;

fn main() -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    writeln!(out, "time_us,in")?;
    for row in 0..Arguments::parse().rows {
        let passed = row % (2 * STROKE);
        let way = passed.min(2 * STROKE - passed);
        // Speed and back within a stroke: a parabola that begins and ends at rest.
        let half = way.min(STROKE - way);
        let place =
            if way * 2 <= STROKE { half * half / 100 } else { STROKE * STROKE / 200 - half * half / 100 };
        let wrong = if row % WRONG_EVERY == WRONG_EVERY - 1 { 1 << 21 } else { 0 };
        writeln!(out, "{},{:08X}", row * 1_000, (1_000_000 + place) ^ wrong)?;
    }
    out.flush()
}
