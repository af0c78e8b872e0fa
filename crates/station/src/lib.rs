//! One ring made reachable: it is cycled in real time, its process image is held for whoever asks, and what
//! happens on it can be seen and changed: by what is typed, or by [`verbs`] in JSON.
//!
//! One thread cycles the ring. The image is locked once per cycle and once per request; no lock is ever held over
//! a wait.

pub mod answer;
mod bus_seen;
pub mod controlled;
pub mod events;
pub mod history;
mod json;
pub mod keeper;
pub mod pace;
pub mod recording;
pub mod serving;
pub mod simulated;
pub mod station;
pub mod verbs;
pub mod view;

pub use controlled::{Controlled, Gateway};
pub use events::{Happened, RingEvent};
pub use history::{ChangesSince, ServiceStep, WordChange, WordHistory};
pub use keeper::Keeper;
pub use pace::Speed;
pub use recording::{Recorded, Recorder, RecordingFile};
pub use serving::NotServed;
pub use simulated::{SharedWorld, Simulated};
pub use station::{Finished, Handle, Options, RingStopped, Station};
pub use view::View;
