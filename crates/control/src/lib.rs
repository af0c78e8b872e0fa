//! A simulated ring told what to do by JSON lines over TCP: one object a line in, one answer a line out, in order.
//!
//! [`verbs`] knows what can be asked and needs no socket, so that another face can offer the same; [`server`] reads
//! and writes the lines. Nothing here is authenticated: whoever reaches the port moves the world. Nothing here
//! opens a file either.

pub mod server;
pub mod verbs;

pub use server::{Options, serve};
pub use verbs::{Command, Given, ReadLine, Refused, answer, parse};
