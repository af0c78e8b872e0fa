//! `encoring ssi guess`: which format a capture may have.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::ControlFlow;

use clap::Args;
use encoring_host::ssi_guess::{SsiFit, SsiGuess, SsiWord, SsiWords};
use encoring_words::Instant;
use encoring_words::ssi_frame::SsiCheck;
use serde::Serialize;

use super::captured::{CaptureArguments, Captured, Levels};
use super::format::FormatText;
use crate::arguments::Output;
use crate::output::reading::Beside;
use crate::output::{Answer, Failure, note};

/// Find the format of a capture: bits, code, parity, repetition, leading and trailing zeros, edge
///
/// The shaft must move. To tell the codes apart it must pass a boundary of several bits. To find the last bit its speed must
/// not be a whole number of steps a transfer. Otherwise the output lists the formats that fit.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  one format fits
  2  wrong input
  3  several formats fit, or none

Examples:
  encoring ssi guess capture.sr
  encoring ssi guess logic.csv --clock 'Channel 0' --data 'Channel 1'")]
pub(crate) struct Arguments {
    #[command(flatten)]
    capture: CaptureArguments,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct GuessView {
    words: u64,
    clocks: u32,
    moved: bool,
    edge: &'static str,
    may_be_longer: bool,
    fits: Vec<FitView>,
}

#[derive(Serialize)]
struct FitView {
    #[serde(skip)]
    text: String,
    bits: u8,
    code: &'static str,
    parity: Option<&'static str>,
    /// `null` where the clocks are too few to see it.
    repetition: Option<bool>,
    leading_zeros: u32,
    clocks_behind: u32,
}

impl FitView {
    fn new(fit: SsiFit, clocks: u32) -> Self {
        let SsiFit { format, leading_zeros, clocks_behind } = fit;
        let is_repeated = format.check() == SsiCheck::Repetition;
        let has_parity = format.check() == SsiCheck::OddParity;
        Self {
            text: FormatText(format).to_string(),
            bits: format.bits() - u8::from(has_parity),
            code: format.code().name(),
            parity: has_parity.then_some("odd"),
            repetition: (is_repeated || format.bits() != 24 || clocks > 26).then_some(is_repeated),
            leading_zeros,
            clocks_behind,
        }
    }
}

fn counted(count: u32, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

impl fmt::Display for FitView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, leading_zeros, clocks_behind, repetition, .. } = self;
        let (zeros, behind) = (counted(*leading_zeros, "bit"), counted(*clocks_behind, "clock"));
        let were = if *leading_zeros == 1 { "was" } else { "were" };
        write!(f, "{text}; the first {zeros} {were} always zero, {behind} behind the field")?;
        if repetition.is_none() { f.write_str("; repetition would show from 27 clocks on") } else { Ok(()) }
    }
}

impl fmt::Display for GuessView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} words of {}", self.words, counted(self.clocks, "clock"))?;
        match self.edge {
            "either" => writeln!(f, "edge: either; data change while the clock is High")?,
            _ => writeln!(f, "edge: rising; data come so late that the falling edge brings the bit before")?,
        }
        match self.fits.as_slice() {
            [] => writeln!(f, "no format of the CE-65-M fits")?,
            [fit] => writeln!(f, "{fit}")?,
            fits => {
                writeln!(f, "several fit:")?;
                fits.iter().try_for_each(|fit| writeln!(f, "  {fit}"))?;
            }
        }
        if self.may_be_longer {
            writeln!(
                f,
                "the last bit clocked belongs to the field: the field may have more bits than there were clocks. Capture \
                 with one clock more"
            )?;
        }
        if !self.moved {
            writeln!(f, "fewer than 20 different words: capture a shaft that moves")?;
        }
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let mut captured = arguments.capture.open(Beside::Nothing)?;
    let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
    words(&mut captured, |word| *counts.entry(word.clocks).or_default() += 1)?;
    let all: u64 = counts.values().sum();
    let Some((clocks, most)) = counts.into_iter().max_by_key(|(_, count)| *count) else {
        return Err(Failure::NoAnswer(
            "the capture has no complete word: capture longer, or name the lines with --clock and --data"
                .to_owned(),
        ));
    };
    if most < all {
        note(&format!(
            "note: {} of {all} words have another number of clocks than {clocks} and were left out",
            all - most
        ));
    }
    let mut guess = SsiGuess::new(clocks);
    words(&mut captured, |word| guess.word(word))?;
    let view = GuessView {
        words: guess.words(),
        clocks,
        moved: guess.has_moved(),
        edge: if guess.is_late() { "rising" } else { "either" },
        may_be_longer: guess.may_be_longer(),
        fits: guess.fits().map(|fit| FitView::new(fit, clocks)).collect(),
    };
    arguments.output.print(&view)?;
    Ok(if view.fits.len() == 1 && !view.may_be_longer { Answer::Yes } else { Answer::Unknown })
}

/// Every word of a capture.
fn words(captured: &mut Captured, mut each: impl FnMut(SsiWord)) -> Result<(), Failure> {
    let mut words = SsiWords::default();
    let end = captured.levels(|Levels { at, clock_and_data }| {
        match clock_and_data {
            Some((clock, data)) => {
                if let Some(word) = words.levels(at, clock, data) {
                    each(word);
                }
            }
            None => words = SsiWords::default(),
        }
        ControlFlow::Continue(())
    })?;
    if captured.is_interrupted() {
        let message = "interrupted: a guess needs the whole capture";
        return Err(Failure::NoAnswer(message.to_owned()));
    }
    if let Some(word) = words.time(Instant(end.time_ns)) {
        each(word);
    }
    Ok(())
}
