//! The INTERBUS-S ring: the process image that a controller sees, the data cycle, and how long it takes.
//!
//! A master and its slaves send telegrams bit by bit, and a fault is what happens to a bit; what a device takes follows
//! from check words and end words. A slot in which nothing can happen to a bit is taken as a whole, and leaves behind
//! what its bits would have left.
//!
//! The ring knows no encoder: what hangs on it is so many bytes in each direction a device.
//!
//! ```
//! use encoring_ring::{CycleTime, ProcessImage};
//! use encoring_words::{Duration, OutWord, Written};
//!
//! // Three encoders at 500 kbit/s: (13 * (6 + 12) + 1.5 * 3) bits of 2 us, and 200 us of the master.
//! assert_eq!(CycleTime::default().of_encoders(3), Duration::from_micros(677));
//!
//! // A gateway that writes one register at a time writes half a word.
//! let mut image = ProcessImage::new(3)?;
//! image.write_out(2, Written::Low(0x270F));
//! image.write_out(2, Written::High(0xC200));
//! assert_eq!(image.out()[2], OutWord(0xC200_270F));
//! # Ok::<(), encoring_ring::TooManyEncoders>(())
//! ```
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
