//! The process image of a ring as a Modbus TCP server, and the client of a ring behind such a gateway.
//!
//! [`place`] is the ground: tables, registers, word order. [`registers`] says which register holds what in each layout,
//! [`pdu`] makes an answer of a request without any input or output, [`server`] takes requests from connections.
//! [`gateway_fault`] says how a gateway misbehaves, [`misdeeds`] does it. Nothing that a client sends can panic, allocate
//! without bound or end the server. The page for users is `docs/modbus.md`; why no library does this is decision 0004.
//!
//! [`client`] reaches a ring behind a gateway, over Modbus TCP or RTU, as [`address`] says where and how; [`inline`]
//! finds encoders among the modules of an Inline coupler, [`reconnect`] says when a lost connection is tried again.
//! Their page is `docs/bus.md`.
//!
//! ```
//! use encoring_modbus::{Address, RegisterMap, WordOrder, pdu};
//! use encoring_ring::ProcessImage;
//! use encoring_words::OutWord;
//!
//! // Function 16: two registers from 4 on, the OUT word of position 2.
//! let mut image = ProcessImage::new(3)?;
//! let request = [16, 0, 4, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F];
//! let answer = pdu::respond(&request, &mut image, RegisterMap::Plain, WordOrder::HighFirst, &mut |_, _| {});
//! assert_eq!(answer.as_bytes(), [16, 0, 4, 0, 2]);
//! assert_eq!(image.out()[2], OutWord(0xC200_270F));
//! // Where a ring behind a gateway is.
//! let address: Address = "modbus-tcp://192.168.1.10?order=low-first".parse()?;
//! assert_eq!(address.to_string(), "modbus-tcp://192.168.1.10:502?order=low-first");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod address;
pub mod client;
pub mod counters;
pub mod error;
mod frame;
pub mod gateway_fault;
pub mod inline;
pub mod misdeeds;
pub mod pdu;
pub mod place;
#[cfg(test)]
mod plain;
pub mod probe;
pub mod reconnect;
pub mod registers;
pub mod server;

pub use address::{Address, AddressError};
pub use client::Client;
pub use counters::{ServerCounts, Snapshot};
pub use error::{Garbled, ModbusError};
pub use gateway_fault::GatewayFault;
pub use misdeeds::GatewayFaults;
pub use place::{RegisterPlace, Table, UnknownWordOrder, WordOrder};
pub use reconnect::Reconnect;
pub use registers::{RegisterMap, UnknownLayout};
pub use server::{Options, serve};
