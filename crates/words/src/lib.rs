//! What the three manuals define and every other crate speaks: the 32-bit words of the process image, the
//! services, the parameters, the error status, the codes, and the three encoders as data.
//!
//! Nothing here has state or behaviour over time. `encoder` is the device that speaks these words, `host` the
//! master's side, `ring` what carries them.
//!
//! ```
//! use encoring_words::number::{Bare, word};
//! use encoring_words::word::Out;
//! use encoring_words::{OutWord, Service, gray};
//!
//! // As a PLC monitor shows it: write the measuring length 9999.
//! let out = OutWord(word(["W#16#C200", "W#16#270F"], Bare::Hexadecimal)?.bits);
//! assert_eq!(out, OutWord(0xC200_270F));
//! let Out::Request(fields) = out.decode() else { panic!("the service bit is set") };
//! assert_eq!(Service::from_number(fields.service.number()), Some(Service::MeasuringLength));
//! assert_eq!(fields.data, 9_999);
//! assert_eq!(gray::decode(gray::encode(9_999)), 9_999);
//! # Ok::<(), encoring_words::number::NumberError<'_>>(())
//! ```
#![no_std]

pub mod change;
mod data;
pub mod explain;
pub mod gray;
pub mod model;
pub mod number;
pub mod parameter;
pub mod service;
pub mod sheet;
pub mod ssi_frame;
pub mod status;
pub mod time;
pub mod week;
pub mod word;

pub use model::Model;
pub use parameter::{Parameter, ParameterSet};
pub use service::{Access, Service};
pub use status::ErrorStatus;
pub use time::{Duration, Instant};
pub use week::Week;
pub use word::{InWord, OutWord, Written};
