//! From steps, turns and millimetres to the values of services 02, 03 and 09, and to the words that program them.
//!
//! Everything is exact arithmetic in whole numbers: what does not come out even is said, never hidden.
//!
//! ```
//! use encoring_words::Model;
//! use encoring_host::scaling::{Ratio, Shaft, rotary};
//!
//! let steps_per_turn: Ratio = "1000".parse()?;
//! let shaft = Shaft::new(Model::Ce65M, 4096)?;
//! let found = rotary(steps_per_turn, "3.5".parse()?, shaft)?;
//! assert_eq!((found.scaling.measuring_length(), found.scaling.fraction.to_string().as_str()), (3499, "35/10"));
//! assert_eq!(found.scaling.too_large(shaft), None);
//! let words = found.scaling.sequence().map(|step| step.out.to_string());
//! assert_eq!(words.take(3).collect::<Vec<_>>(), ["42000DAB", "C2000DAB", "42000DAB"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axis;
mod fraction;
mod linear;
mod place;
mod ratio;
mod rotary;
mod sequence;
mod shaft;

pub use axis::{Axis, Proposal, Purpose};
pub use fraction::{Choice, Chosen, Fraction, Turns, TurnsOutside};
pub use linear::{Linear, LinearScaling, ResolutionOutside, linear};
pub use ratio::{DecimalError, Deviation, Ratio, Rounded, Rounding};
pub use rotary::{LengthOutside, Rotary, RotaryError, RotaryScaling, TooLarge, ZeroRisk, rotary};
pub use sequence::{Expected, HandshakeStep, HandshakeWord, preset_adjustment};
pub use shaft::Shaft;
