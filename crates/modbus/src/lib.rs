//! The process image of a station as a Modbus TCP server.
//!
//! [`registers`] says which register holds what, [`pdu`] makes an answer of a request without any input or output,
//! [`server`] takes requests from connections. Nothing that a client sends can panic, allocate without bound or end
//! the server. The page for users is `docs/modbus.md`; why no library does this is decision 0004.

pub mod counters;
mod frame;
pub mod pdu;
#[cfg(test)]
mod plain;
pub mod registers;
pub mod server;

pub use counters::{Counters, Snapshot};
pub use registers::{UnknownWordOrder, WordOrder};
pub use server::{Options, serve};
