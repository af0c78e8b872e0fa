//! An encoder behind its protocol chip: when it is on, when there is an exchange, and with which word.
//!
//! [`BusDevice`] is told the supply, what its chip holds and the time, and is lent its memory. It has no clock and moves
//! no shaft: it says of which moment it will show the shaft ([`BusDevice::looks_at`]), and the caller says where that was.
//!
//! Calling order: [`BusDevice::supply`] whenever the supply changes. At the end of a cycle that reached the device an
//! exchange, if [`BusDevice::exchanges_after_cycle`] says so; without cycles one at every
//! [`BusDevice::due_without_cycles`]. An exchange is [`BusDevice::looks_at`], then [`BusDevice::exchange`] with the word
//! of [`BusDevice::hears`].
//!
//! ```
//! use encoring_device::{BusDevice, Surroundings};
//! use encoring_encoder::{Magnet, Ram, Terminals, Unit, records};
//! use encoring_words::model::Sensor;
//! use encoring_words::{InWord, Instant, Model, OutWord};
//!
//! let unit = Unit::new(Model::Ce100M, Sensor::Rotary { steps_per_turn: 4096 })?;
//! let mut memory = Ram::blank();
//! records::format(&unit, &mut memory).map_err(|_| "the memory takes nothing")?;
//! let mut device = BusDevice::new(unit);
//! let terminals = Terminals { raw: 77, magnet: Magnet::Present, preset_mv: [0, 0] };
//! let on = Surroundings { terminals, supply_mv: 24_000 };
//! let shown = device.exchange(Instant(1_000_000), OutWord(0), &on, &mut memory);
//! assert_eq!(shown, Some(InWord::position(77, false)));
//! // Below 10.45 V it is off, and answers nothing [R121].
//! let dip = Surroundings { terminals, supply_mv: 5_000 };
//! assert_eq!(device.exchange(Instant(2_000_000), OutWord(0), &dip, &mut memory), None);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]

pub mod bus_device;
pub mod supply;

pub use bus_device::BusDevice;
pub use supply::{OFF_BELOW_MV, OVERVOLTAGE_ABOVE_MV, Surroundings};
