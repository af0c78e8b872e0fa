//! What a technician keeps of an encoder, and does with it.
//!
//! - [`parameter_file`]: its parameters as a file that people read and `encoring program` takes back; [`kept`] is what
//!   stands in it of one encoder, [`backup`] makes one, [`reading`] reads what goes into it.
//! - [`carry`]: what of one model's values another model takes.
//! - [`zero`]: what a preset adjustment can restore. The offset itself is in no file: no service reads it [R76].
//! - [`reconstruct`]: the parameters of an encoder that is dead, from words and from known positions.
//! - [`journal`]: what is being programmed, for whoever comes after a command that was killed.

pub mod backup;
pub mod carry;
pub mod journal;
pub mod kept;
pub mod parameter_file;
pub mod reading;
pub mod reconstruct;
pub mod values;
pub mod zero;

pub use backup::{BackupKept, BackupOrigin, keep};
pub use kept::{KeptEncoder, MachineMark, NamedMark, Reference, ReferenceUnit, TakenFrom, UnitLabel};
pub use parameter_file::{ParameterFile, ParameterFileError};
