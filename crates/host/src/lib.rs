//! The master's side of an encoder's 32 bits. It knows nothing of a device's insides, only the words.
//!
//! [`scaling`] finds the values that make an encoder count in the wanted steps over the wanted range, judges them as
//! the encoder will, and gives the words that program them. [`session`] carries one service out, poll by poll;
//! [`service`], [`program`] and [`preset`] are what a user means by it. [`validity`] judges every position that the
//! bus brings. [`axis`] joins both for the program of a controller. [`referee`] says which rule of the handshake
//! another program broke. [`ssi_receiver`] is the other end of the encoder's SSI.
//!
//! ```
//! use encoring_host::scaling::{Ratio, Shaft, Turns, rotary};
//! use encoring_words::Model;
//!
//! // The manuals' example: 1000 steps a turn over ten turns. The largest position is 9999 = 270Fh.
//! let (steps, turns): (Ratio, Turns) = ("1000".parse()?, "10".parse()?);
//! let found = rotary(steps, turns, Shaft::new(Model::Ce65M, 4096)?)?;
//! assert_eq!(found.scaling.measuring_length(), 9_999);
//! assert_eq!((found.scaling.fraction.numerator(), found.scaling.fraction.denominator()), (10, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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
