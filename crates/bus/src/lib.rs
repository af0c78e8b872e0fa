//! A ring as its master sees it, whatever stands between: the [`Bus`], the [`EncoderMaster`] of one encoder on it, the
//! [`Watch`] that looks at encoders and the [`Judge`] of what they show, and the process image that a ring and its
//! gateways share.
//!
//! Nothing here knows a protocol, and nothing here can simulate.
//!
//! ```
//! use encoring_bus::{Judge, Ring, Tolerance};
//! use encoring_host::Seen;
//! use encoring_words::{Duration, InWord, Instant, Model, Parameter};
//!
//! // 1000 steps a turn over ten turns: 10000 is no position of this encoder.
//! let active = [
//!     (Parameter::CountingDirection, 0),
//!     (Parameter::MeasuringLength, 9_999),
//!     (Parameter::Numerator, 10),
//!     (Parameter::Denominator, 1),
//! ];
//! let tolerance = Tolerance::of_sheet(Duration::from_millis(100));
//! let mut judge = Judge::new(Model::Ce65M, None, &active, tolerance)?;
//! let seen = |value| Ok(Seen { input: InWord::position(value, false), age: Duration::ZERO });
//! let (judgement, stop) = judge.judge(Instant(0), seen(10_000), Ring::Runs);
//! assert_eq!((judgement.word(), stop.is_some()), ("implausible_range", true));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bus;
pub mod history;
pub mod image;
pub mod judge;
pub mod master;
pub mod misread;
pub mod referees;
pub mod release;
pub mod watch;

pub use bus::{Answered, Bus, BusError, Cause, ClientError, Cycle, Link, LinkEvent, Settling};
pub use history::RingNews;
pub use image::{ClientWrite, SharedImage};
pub use judge::{Blind, Insight, Judge, Judgement, Ring, Tolerance};
pub use master::{Behind, Cure, EncoderMaster, LeftBit, MasterError};
pub use referees::Referees;
pub use watch::Watch;
