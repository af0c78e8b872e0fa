//! The bare `csv` reader over a file, for benches/diagnose: counts its rows.

use std::path::PathBuf;

use clap::Parser;

/// Count the rows of a table.
#[derive(Parser)]
struct Arguments {
    /// The table.
    file: PathBuf,
}

fn main() -> Result<(), csv::Error> {
    let mut reader = csv::Reader::from_path(Arguments::parse().file)?;
    let mut record = csv::ByteRecord::new();
    let mut rows = 0_u64;
    while reader.read_byte_record(&mut record)? {
        rows += 1;
    }
    println!("{rows}");
    Ok(())
}
