//! What a technician keeps of an encoder.
//!
//! [`parameter_file`] holds its parameters as a file that people read and `encoring program` takes back; [`backup`]
//! makes one before they are changed. The preset offset is not among them: no service reads it [R76].

pub mod backup;
pub mod parameter_file;

pub use backup::{BackupKept, BackupOrigin, keep};
pub use parameter_file::{ParameterFile, ParameterFileError};
