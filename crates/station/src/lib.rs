//! One ring made reachable: it is cycled in real time, its process image is held for whoever asks, and what
//! happens on it is told as views and events.
//!
//! The image is locked once per cycle and once per request; no lock is ever held over a wait.

pub mod image;

pub use image::SharedImage;
