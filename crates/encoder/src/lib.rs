//! An encoder as a device: 32 bits in, 32 bits out, one call an exchange.
//!
//! [`Encoder`] is told the time, the state of its [`Terminals`] and the OUT word, and is lent its memory; it answers
//! with the IN word. It has no clock, no storage and no chance of its own, so the same calls give the same words.
//! It knows nothing of the ring that carries them. Supply is the caller's affair: an encoder that is off is no
//! `Encoder`.
//!
//! Calling order: [`records::format`] once for a new device, [`Encoder::power_up`], then [`Encoder::exchange`] and
//! [`Encoder::ssi_clock`] with times that never run backwards, at last [`Encoder::power_off`].
//!
//! ```
//! use encoring_encoder::{Encoder, Magnet, Ram, Terminals, Unit, records};
//! use encoring_words::model::Sensor;
//! use encoring_words::{InWord, Instant, Model, OutWord};
//!
//! let unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 })?;
//! let mut memory = Ram::blank();
//! records::format(&unit, &mut memory).map_err(|_| "the memory takes nothing")?;
//! let terminals = Terminals { raw: 9_999, magnet: Magnet::Present, preset_mv: [0, 0] };
//! let mut encoder = Encoder::power_up(&unit, Instant(0), &terminals, &mut memory);
//! let input = encoder.exchange(Instant(1_000_000), OutWord(0), &terminals, &mut memory);
//! assert_eq!(input, InWord::position(9_999, false));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]

pub mod encoder;
pub mod handshake;
pub mod memory;
pub mod parameters;
pub mod position;
pub mod preset_input;
pub mod records;
pub mod ssi_output;
pub mod unit;

pub use encoder::{Encoder, Magnet, Terminals};
pub use memory::Ram;
pub use unit::{ServiceTimes, StaleService, Unit, ZeroLoss};
