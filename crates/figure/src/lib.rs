//! Figures: levels and words over time as a [`TimingFigure`], samples over time as a [`Plot`], any number of samples with
//! marks and close-ups as a [`Chart`].
//!
//! A figure is a text in SVG. It is black on white, tells everything by shape and number and nothing by colour, has no
//! script and no reference to anything outside, and holds every text escaped. For a terminal a timing figure is also
//! drawn with characters.
//!
//! This crate knows time, levels and names, and never the meaning of what it draws.
//!
//! ```
//! use encoring_figure::{Lane, LaneLevel, TimingFigure};
//!
//! let mut timing = TimingFigure::new("one pulse", 0, 4_000);
//! let mut clock = Lane::levels("clock", LaneLevel::High);
//! clock.change(1_000, LaneLevel::Low);
//! clock.change(2_000, LaneLevel::High);
//! timing.lane(clock);
//! timing.mark(1_000, "the clock falls");
//! assert_eq!(timing.text(500), "clock  ‾‾__‾‾‾‾\n");
//! assert!(timing.svg().starts_with("<svg "));
//! ```

mod axis;
mod chart;
mod envelope;
mod plot;
mod svg;
#[cfg(test)]
mod tests;
mod text;
mod timing;

pub use chart::{Chart, Closeup};
pub use envelope::Envelope;
pub use plot::{Plot, PlotSample};
pub use svg::Escaped;
pub use timing::{Lane, LaneLevel, TimingFigure};
