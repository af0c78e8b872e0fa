//! What the three manuals define and every other crate speaks: the 32-bit words of the process image, the
//! services, the parameters, the error status, the codes, and the three encoders as data.
//!
//! Nothing here has state or behaviour over time. `encoder` is the device that speaks these words, `host` the
//! master's side, `ring` what carries them.
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
