//! What a technician keeps of an encoder.
//!
//! [`parameter_file`] holds its parameters as a file that people read and `encoring program` takes back. The preset
//! offset is not among them: no service reads it [R76].

pub mod parameter_file;

pub use parameter_file::{ParameterFile, ParameterFileError};
