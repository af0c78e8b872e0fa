//! Worlds in virtual time: encoders with memories that can fail, on a ring, moved by a scenario.
//!
//! Nothing here reads a clock, starts a thread or opens a socket, and all chance comes from the scenario's seed:
//! the same scenario and the same OUT words give the same words, to the bit.
//!
//! ```
//! use std::path::Path;
//!
//! use encoring_ring::Verdict;
//! use encoring_sim::{Scenario, World};
//! use encoring_words::{InWord, OutWord};
//!
//! let ring = r#"
//!     version = 1
//!     [[device]]
//!     position = 0
//!     model = "ce-65-m"
//!     motion = { kind = "hold", raw = 9_999 }
//! "#;
//! let mut world = World::new(&Scenario::parse("example", ring, Path::new(""))?)?;
//! let mut input = [InWord(0)];
//! // An encoder shows its position from the second cycle on.
//! world.cycle(&[OutWord(0)], &mut input);
//! let cycled = world.cycle(&[OutWord(0)], &mut input);
//! assert_eq!((cycled.verdict, input), (Verdict::Good, [InWord(9_999)]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod device_line;
pub mod fault;
mod gaps;
pub mod injector;
pub mod memory;
pub mod motion;
pub mod node;
pub mod replay;
pub mod scan;
pub mod scenario;
pub mod span;
pub mod ssi;
pub mod ssi_bench;
pub mod state;
mod tap;
pub mod waveform;
mod wire;
pub mod world;

pub use encoring_device::Surroundings;
pub use fault::Fault;
pub use memory::{CellFault, Eeprom};
pub use node::Node;
pub use scenario::{Occurrence, Scenario, ScenarioError};
pub use waveform::{Shown, Waveform};
pub use world::{Cycled, World};
