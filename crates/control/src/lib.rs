//! A simulated ring told what to do by JSON lines over TCP: one object a line in, one answer a line out, in order.
//!
//! [`verbs`] knows what can be asked and needs no socket, so that another face can offer the same; [`server`] reads
//! and writes the lines. Nothing here is authenticated: whoever reaches the port moves the world. Nothing here
//! opens a file either.

mod answer;
pub mod controlled;
pub mod server;
pub mod verbs;

pub use answer::answer;
pub use controlled::{Controlled, Gateway};
pub use server::{Options, serve};
pub use verbs::{Command, Given, ReadLine, Refused, parse};
