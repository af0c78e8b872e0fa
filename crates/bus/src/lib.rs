//! A ring as its master sees it, whatever stands between: the [`Bus`], the [`EncoderMaster`] of one encoder on it, the
//! [`Watch`] that looks at encoders and the [`Judge`] of what they show, and the process image that a ring and its
//! gateways share.
//!
//! Nothing here knows a protocol, and nothing here can simulate.

pub mod bus;
pub mod history;
pub mod image;
pub mod judge;
pub mod master;
pub mod misread;
pub mod release;
pub mod watch;

pub use bus::{Answered, Bus, BusError, Cause, ClientError, Cycle, Link, LinkEvent, Settling};
pub use history::RingNews;
pub use image::{ClientWrite, SharedImage};
pub use judge::{Blind, Insight, Judge, Judgement, Ring, Tolerance};
pub use master::{Behind, EncoderMaster, LeftBit, MasterError};
pub use watch::Watch;
