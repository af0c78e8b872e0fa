//! The master's side of an encoder's 32 bits. It knows nothing of a device's insides, only the words.
//!
//! [`scaling`] finds the values that make an encoder count in the wanted steps over the wanted range, judges them as
//! the encoder will, and gives the words that program them. [`session`] carries one service out, poll by poll;
//! [`service`], [`program`] and [`preset`] are what a user means by it. [`validity`] judges every position that the
//! bus brings. [`axis`] joins both for the program of a controller. [`referee`] says which rule of the handshake
//! another program broke. [`ssi_receiver`] is the other end of the encoder's SSI.
#![no_std]

pub mod axis;
pub mod preset;
pub mod program;
pub mod referee;
pub mod request;
pub mod scaling;
pub mod seen;
pub mod service;
pub mod session;
pub mod ssi_guess;
pub mod ssi_lines;
pub mod ssi_receiver;
pub mod ssi_timings;
pub mod validity;

pub use axis::{AxisCycle, JudgedAxis};
pub use request::{Reply, Request, RequestError};
pub use seen::Seen;
pub use service::Services;
pub use session::{LookFor, NextLook, Outcome, Session, SessionPhase, Timing};
