//! An encoder behind its protocol chip: when it is on, when there is an exchange, and with which word.
//!
//! [`BusDevice`] is told the supply, what its chip holds and the time, and is lent its memory. It has no clock and moves
//! no shaft: it says of which moment it will show the shaft ([`BusDevice::looks_at`]), and the caller says where that was.
//!
//! Calling order: [`BusDevice::supply`] whenever the supply changes. At the end of a cycle that reached the device an
//! exchange, if [`BusDevice::exchanges_after_cycle`] says so; without cycles one at every
//! [`BusDevice::due_without_cycles`]. An exchange is [`BusDevice::looks_at`], then [`BusDevice::exchange`] with the word
//! of [`BusDevice::hears`].
#![no_std]

pub mod bus_device;
pub mod supply;

pub use bus_device::BusDevice;
pub use supply::{OFF_BELOW_MV, OVERVOLTAGE_ABOVE_MV, Surroundings};
