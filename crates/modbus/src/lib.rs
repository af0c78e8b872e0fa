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
