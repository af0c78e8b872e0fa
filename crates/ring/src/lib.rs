//! The INTERBUS-S ring: the process image that a controller sees, the data cycle, and how long it takes.
//!
//! A master and its slaves send telegrams bit by bit, and a fault is what happens to a bit; what a device takes follows
//! from check words and end words. A slot in which nothing can happen to a bit is taken as a whole, and leaves behind
//! what its bits would have left.
//!
//! The ring knows no encoder: what hangs on it is so many bytes in each direction a device.
#![no_std]

pub mod crc;
pub mod cycle_time;
pub mod diagnostics;
pub mod frame;
pub mod ident;
pub mod image;
pub mod master;
pub mod profile;
pub mod ring;
pub mod slave;
mod sound_slot;
pub mod telegram;

pub use cycle_time::CycleTime;
pub use ident::Ident;
pub use image::{ENCODERS_MAX, ProcessImage, TooManyEncoders};
pub use master::Master;
pub use ring::{BitRing, EveryBit, Lines, Sound, Verdict};
pub use slave::{Slave, Taken};
