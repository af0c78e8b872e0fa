//! Why a position jumped: the cause of each step change in a recording, what speaks for it, and what would tell it
//! from the other causes.
//!
//! The manual's table of disturbances has four causes for step changes and no way to tell them apart [R150..R153]. A
//! [`Detector`] takes the rows of a recording one by one, in bounded memory, and ends with a [`Conclusion`]: every
//! [`Episode`] with its [`JumpCause`] and how sure that is, what was judged, and what could not be.
//!
//! It never shows a guess as an answer: where two causes make the same rows it names both.
//!
//! ```
//! use encoring_diagnosis::{Detector, JumpCause, Options, Sample, Sighting};
//!
//! let mut detector = Detector::new(Options::default());
//! for k in 0..200_u32 {
//!     let word = if k == 100 { (1_000 + 10 * k) ^ 1 << 20 } else { 1_000 + 10 * k };
//!     detector.sample(Sample {
//!         line: u64::from(k) + 2,
//!         time_ns: u64::from(k) * 1_000_000,
//!         position: 0,
//!         out: None,
//!         reading: Sighting::Word(word),
//!     });
//! }
//! let conclusion = detector.finish();
//! assert_eq!(conclusion.episodes.len(), 1);
//! assert_eq!((conclusion.episodes[0].cause, conclusion.episodes[0].line), (JumpCause::SingleBit, 102));
//! ```

mod apart;
mod axis;
mod beyond;
mod cause;
mod company;
mod curve;
mod detector;
mod episode;
mod evidence;
mod found;
mod given;
mod labels;
mod ledger;
mod manual;
mod misread;
mod motion;
mod noise;
mod options;
mod outside;
mod page;
mod part;
mod picture;
mod places;
mod quiet;
mod recent;
mod recorded;
mod refresh;
mod report;
mod returning;
mod round;
mod row;
mod said;
mod sample;
mod scan;
mod services;
mod statements;
mod staying;
mod stops;
mod stuck;
mod tally;
#[cfg(test)]
mod tests;
mod together;
mod tolerance;
mod unread;
mod verdict;
mod ways;
mod window;

pub use cause::{CAUSES, JumpCause, Likelihood};
pub use detector::Detector;
pub use episode::{ALTERNATIVES_MAX, Conclusion, Episode};
pub use found::FoundView;
pub use options::{ActiveValues, Counted, KnownPlace, Options};
pub use page::{PagePart, page};
pub use picture::Picture;
pub use recent::Recent;
pub use recorded::{Diagnosed, RecordedSamples};
pub use report::{DiagnosisReport, ReportedEvent};
pub use said::{SaidOfEvent, SaidReport, sentences, unreadable_sentences};
pub use sample::{Sample, Sighting};
pub use unread::Unreadable;
