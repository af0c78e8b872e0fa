//! What a technician keeps of an encoder.
//!
//! [`backup`] keeps what it held before it is changed. [`parameter_file`] holds its parameters as a file that people read and `encoring program` takes back. The preset
//! offset is not among them: no service reads it [R76].

pub mod backup;
pub mod parameter_file;

pub use backup::{Kept, Taken, keep};
pub use parameter_file::{ParameterFile, ParameterFileError};
