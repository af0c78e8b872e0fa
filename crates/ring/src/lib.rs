//! The INTERBUS-S ring at word level: the process image that a controller sees, the data cycle that moves every
//! word at once, and how long a cycle takes.
//!
//! The ring knows no encoder: what hangs on it is two words in each direction a device. The bits on the line come
//! later under the same face; at this level a fault is only "this cycle, from this segment on, bad or silent".
#![no_std]

pub mod cycle_time;
pub mod image;
pub mod profile;
pub mod word_level;

pub use cycle_time::CycleTime;
pub use image::{ENCODERS_MAX, ProcessImage, TooManyEncoders};
pub use word_level::{Verdict, WordRing};
