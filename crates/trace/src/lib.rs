//! Recordings of exchanges: what went to an encoder, what its shaft, inputs and supply did, and what it
//! answered, as CSV in and out; waveforms, out only; and captures of logic analysers, in and out.
//!
//! This crate knows columns, units and errors, and never the meaning of what it carries.
//!
//! A **trace** has a header, then one row an exchange, its columns in any order:
//!
//! | column | holds | allowed | if missing |
//! |---|---|---|---|
//! | `time_us` | [`Row::time_ns`] | microseconds, three decimals, never backwards | rows 1 ms apart from 0 |
//! | `position` | [`Row::position`] | 0 to 127 | none |
//! | `out` | [`Row::out`] | 8 hex digits or empty | none: as before, at first 0 |
//! | `raw` | [`Row::raw`] | -2^62 to 2^62 | 0 |
//! | `preset1_v`, `preset2_v` | [`Row::preset_mv`] | 0 to 1000 V, three decimals | 0 V |
//! | `supply_v` | [`Row::supply_mv`] | 0 to 1000 V, three decimals | 24 V |
//! | `magnet` | [`Row::magnet`] | 0 or 1 | 1 |
//! | `in` | [`Row::input`] | 8 hex digits, `off` or empty | none |
//! | `value` | [`Row::value`] | a whole number or empty | none |
//! | `line` | [`Row::cycle`] | `good`, `bad`, `silent` or empty | none |
//! | `status`, `parameter` | the registers of the same names | 0 to 65535, `0xFFFF`, or empty | none |
//! | `verdict` | nothing that is kept | anything | none |
//!
//! Decimals after the third must be zero. Blank lines and lines that begin with `#` are skipped but
//! counted: every line number is that of the file. A cell may stand in double quotes. A line has at most
//! 65536 bytes, so memory is bounded whatever a file holds.
//!
//! A **table** of another program has any separator, names, encoding and spelling of words and times. What its header
//! does not say, a [`TableLayout`] does; [`Reader::assumed`] tells what was assumed. `docs/tables.md` has the rules.
//!
//! A **recording** holds many encoders: its first line is `# encoring-trace 1`, and a line
//! `# device POSITION MODEL key=value ... memory=HEX` for each encoder comes before the header, which has
//! the column `position`.
//!
//! What was seen on a [`bus`], with every write, has columns of its own. A [`log`] is what was seen on a bus, for days; it is read as a trace is, with words as `0xC200270F`. A [`wave`] is
//! signals over time, for waveform viewers. A [`capture`] is what a logic analyser saw.
//!
//! ```
//! use encoring_trace::{Input, Reader, Writer};
//!
//! let file = "raw,out,in\n0,00000000,\n4096,00000000,00001000\n";
//! let mut writer = Writer::new(Vec::new())?;
//! for row in Reader::new("turn.csv", file.as_bytes())? {
//!     writer.write(&row?)?;
//! }
//! assert_eq!(
//!     String::from_utf8(writer.into_inner())?,
//!     "time_us,out,raw,preset1_v,preset2_v,supply_v,magnet,in\n\
//!      0,00000000,0,0.0,0.0,24.0,1,\n\
//!      1000,00000000,4096,0.0,0.0,24.0,1,00001000\n",
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bus;
pub mod capture;
mod columns;
mod csv;
mod decimal;
mod error;
mod header;
mod lines;
pub mod log;
mod table;
#[cfg(test)]
mod tests;
mod text;
pub mod wave;

pub use self::columns::{CycleSeen, Input, Row, RowKind};
pub use self::csv::{Reader, Writer};
pub use self::error::{Error, Problem};
pub use self::header::{DeviceLine, LoggedEncoder, Recording};
pub use self::log::Log;
pub use self::table::{Columns, TableLayout};
