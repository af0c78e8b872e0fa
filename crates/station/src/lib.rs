//! One ring made reachable: it is cycled in real time, its process image is held for whoever asks, and what
//! happens on it can be seen and changed: by what is typed, or by [`verbs`] in JSON.
//!
//! One thread cycles the ring. The image is locked once per cycle and once per request; no lock is ever held over
//! a wait.
//!
//! ```
//! use std::sync::Arc;
//! use std::sync::atomic::AtomicBool;
//!
//! use encoring_bus::EncoderMaster;
//! use encoring_host::program::Program;
//! use encoring_sim::{Scenario, World};
//! use encoring_station::{Simulated, Speed};
//! use encoring_words::{Duration, Model, Parameter};
//!
//! // The built-in ring as a bus: another bus in its place, and nothing below changes.
//! let mut bus = Simulated::new(World::new(&Scenario::built_in()?)?, Speed::Max);
//! let stop = Arc::new(AtomicBool::new(false));
//! let mut encoder = EncoderMaster::new(&mut bus, 2, Duration::from_millis(2_000), stop)?;
//! let mut program = Program::new(Model::Ce65M, Some(4096));
//! program.set(Parameter::MeasuringLength, 9_999)?;
//! program.set(Parameter::Numerator, 10)?;
//! assert!(program.run(&mut encoder).result.is_ok());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod answer;
mod bus_seen;
pub mod causes;
pub mod controlled;
pub mod events;
pub mod finding;
pub mod history;
mod json;
pub mod keeper;
pub mod known;
pub mod named;
pub mod pace;
pub mod polled;
pub mod polled_view;
pub mod recording;
pub mod refereeing;
pub mod serving;
pub mod shown;
pub mod simulated;
pub mod station;
pub mod verbs;
pub mod view;

pub use controlled::{Controlled, Gateway};
pub use events::{Happened, RingEvent};
pub use finding::FindingView;
pub use history::{ChangesSince, ServiceStep, WordChange, WordHistory};
pub use keeper::Keeper;
pub use named::NamedEncoder;
pub use pace::Speed;
pub use polled::{Polled, PolledRing};
pub use recording::{Recorded, Recorder, RecordingFile};
pub use refereeing::{RefereeMode, RefereeView};
pub use serving::NotServed;
pub use shown::ShownRing;
pub use simulated::{SharedWorld, Simulated};
pub use station::{Finished, Handle, Options, RingStopped, Station};
pub use verbs::Permission;
pub use view::View;
