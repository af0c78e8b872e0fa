//! The master's side of an encoder's 32 bits. It knows nothing of a device's insides, only the words.
//!
//! [`scaling`] finds the values that make an encoder count in the wanted steps over the wanted range, judges them as
//! the encoder will, and gives the words that program them. [`validity`] judges every position that the bus brings.
#![no_std]

pub mod scaling;
pub mod seen;
pub mod validity;

pub use seen::Seen;
