//! One ring made reachable: it is cycled in real time, its process image is held for whoever asks, and what
//! happens on it can be seen and changed.
//!
//! One thread cycles the ring. The image is locked once per cycle and once per request; no lock is ever held over
//! a wait.

pub mod events;
mod json;
pub mod keeper;
pub mod pace;
pub mod recording;
pub mod simulated;
pub mod station;
pub mod view;

pub use events::{Happened, RingEvent};
pub use keeper::Keeper;
pub use pace::Speed;
pub use recording::{Recorder, RecordingFile};
pub use simulated::{SharedWorld, Simulated};
pub use station::{Finished, Handle, Options, RingStopped, Station};
pub use view::View;
