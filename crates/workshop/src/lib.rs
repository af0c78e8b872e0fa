//! What a technician keeps of an encoder, and does with it.
//!
//! - [`parameter_file`]: its parameters as a file that people read and `encoring program` takes back; [`kept`] is what
//!   stands in it of one encoder, [`backup`] makes one, [`reading`] reads what goes into it.

pub mod backup;
pub mod kept;
pub mod parameter_file;
pub mod reading;
pub mod values;

pub use backup::{BackupKept, BackupOrigin, keep};
pub use kept::{KeptEncoder, MachineMark, NamedMark, Reference, ReferenceUnit, TakenFrom, UnitLabel};
pub use parameter_file::{ParameterFile, ParameterFileError};
