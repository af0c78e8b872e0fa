//! A simulated ring told what to do by JSON lines over TCP: one object a line in, one answer a line out, in order.
//!
//! What can be asked is [`encoring_station::verbs`]; [`server`] reads and writes the lines. Nothing here is
//! authenticated: whoever reaches the port moves the world. Nothing here opens a file either.

pub mod server;
pub mod unread;

pub use server::{Options, serve};
