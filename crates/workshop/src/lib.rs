//! What a technician keeps of an encoder, and does with it.
//!
//! - [`parameter_file`]: its parameters as a file that people read and `encoring program` takes back; [`kept`] is what
//!   stands in it of one encoder, [`mark`] a place of the machine, [`backup`] makes one, [`reading`] reads what goes into it.
//! - [`carry`]: what of one model's values another model takes.
//! - [`zero`]: what a preset adjustment can restore. The offset itself is in no file: no service reads it [R76].
//! - [`reconstruct`]: the parameters of an encoder that is dead, from words and from known positions.
//! - [`journal`]: what is being programmed, for whoever comes after a command that was killed.
//!
//! ```
//! use encoring_workshop::ParameterFile;
//! use encoring_words::Parameter;
//!
//! let text = "\
//! version = 1
//! model = \"ce-65-m\"
//!
//! [parameters]
//! measuring_length = \"270Fh\"
//! numerator = 10
//! ";
//! let file = ParameterFile::parse("axis-3.toml", text)?;
//! let encoder = file.at(None)?;
//! assert_eq!(encoder.value(Parameter::MeasuringLength), Some(9_999));
//! let wrong = ParameterFile::parse("axis-3.toml", "version = 1\nmodel = \"ce-66\"\n").unwrap_err();
//! assert_eq!((wrong.line, wrong.file.as_str()), (Some(2), "axis-3.toml"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod backup;
pub mod carry;
mod comments;
pub mod journal;
pub mod kept;
pub mod mark;
pub mod parameter_file;
pub mod reading;
pub mod reconstruct;
pub mod values;
pub mod zero;

pub use backup::{BackupKept, BackupOrigin, keep};
pub use kept::{KeptEncoder, TakenFrom, UnitLabel};
pub use mark::{MachineMark, NamedMark, Reference, ReferenceUnit};
pub use parameter_file::{ParameterFile, ParameterFileError};
