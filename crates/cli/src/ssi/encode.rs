//! `encoring ssi encode`: what the line carries for a position.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use encoring_files::Existing;
use encoring_words::ssi_frame::{Level, SsiFormat, SsiFrame};
use serde::Serialize;

use super::drawing::{HALF_PERIOD_NS, pulses};
use super::format::{FormatArguments, FormatText};
use crate::arguments::{self, Output};
use crate::output::new_file::write_new_file;
use crate::output::{Answer, Failure, Format, bad_input, note, page};

/// The most clocks that are shown.
const CLOCKS_MAX: u32 = 1_024;
/// The most clocks of a figure.
const DRAWN_MAX: u32 = 128;

/// Show what the encoder sends for a position, clock by clock
#[derive(Args, Debug)]
#[command(after_help = "\
Data+ changes with each rising clock edge. A receiver that takes the level at the
falling edges, or just before the rising ones, sees the High of rest first and one
bit less at the end: `rising` and `falling` show that, one bit an edge.

Examples:
  encoring ssi encode 9999 --bits 25
  encoring ssi encode 0x270F --bits 14 --code gray --clocks 20
  encoring ssi encode 9999 --bits 31 --svg ak40.svg
  encoring ssi encode 9999 --repetition --clocks 52 --format json")]
pub(crate) struct Arguments {
    /// The position: decimal, or hexadecimal as 0x270F or 270Fh
    #[arg(required = true, value_name = "POSITION", value_parser = arguments::value)]
    positions: Vec<u32>,
    #[command(flatten)]
    format: FormatArguments,
    /// Clocks to show [default: one more than the field has bits]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=i64::from(CLOCKS_MAX)))]
    clocks: Option<u32>,
    /// Draw the figure into this file
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Replace the file of --svg if it is there
    #[arg(long, requires = "svg")]
    overwrite: bool,
    #[command(flatten)]
    output: Output,
}

/// A position as it is sent.
#[derive(Serialize)]
struct EncodedView {
    field: String,
    line: String,
    rising: String,
    falling: String,
    #[serde(skip)]
    heading: String,
    #[serde(skip)]
    remark: Option<String>,
    #[serde(skip)]
    drawn: String,
}

impl EncodedView {
    fn new(position: u32, format: SsiFormat, clocks: Option<u32>) -> Self {
        let frame = SsiFrame::new(position, format);
        let clocks = clocks.unwrap_or(usual_clocks(format));
        let line = bits(&frame, clocks);
        // Whichever the edge: at an edge the receiver sees what the rising edge before it has put out; at the first one
        // the High of rest.
        let seen = std::iter::once('1').chain(line.chars()).take(line.len()).collect::<String>();
        let title = FormatText(format);
        Self {
            field: bits(&frame, u32::from(format.bits())),
            rising: seen.clone(),
            falling: seen,
            heading: format!("position {position} ({position:06X}h), {title}, {clocks} clocks"),
            remark: cut(position, format),
            drawn: pulses("", position, format, clocks).text(HALF_PERIOD_NS),
            line,
        }
    }
}

/// One more than the field has bits: data change with rising edges, and the first bit is there after the first one.
fn usual_clocks(format: SsiFormat) -> u32 {
    u32::from(format.bits()) + 1
}

/// The levels of the first clocks.
fn bits(frame: &SsiFrame, clocks: u32) -> String {
    (1..=clocks).map(|pulse| if frame.level(pulse) == Level::High { '1' } else { '0' }).collect()
}

/// What is missing of a position that needs more bits than there are.
fn cut(position: u32, format: SsiFormat) -> Option<String> {
    let needed = u32::BITS - position.leading_zeros();
    let cut = needed.checked_sub(u32::from(format.bits())).filter(|cut| *cut > 0)?;
    Some(format!("the position has {needed} bits; the upper {cut} are not sent, and no error tells it"))
}

impl fmt::Display for EncodedView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.heading)?;
        if let Some(remark) = &self.remark {
            writeln!(f, "{remark}")?;
        }
        let Self { field, line, rising, falling, .. } = self;
        writeln!(f, "\nfield    {field}\nline     {line}\nrising   {rising}\nfalling  {falling}\n")?;
        f.write_str(&self.drawn)
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    if let Some(remark) = arguments.format.without_effect() {
        note(&format!("note: {remark}"));
    }
    if let Some(file) = &arguments.svg {
        draw(arguments, file)?;
    }
    let mut text = String::new();
    for position in &arguments.positions {
        if !text.is_empty() && arguments.output.format == Format::Text {
            text.push('\n');
        }
        let view = EncodedView::new(*position, arguments.format.format(), arguments.clocks);
        text.push_str(&page(arguments.output.format, &view)?);
    }
    io::stdout().lock().write_all(text.as_bytes())?;
    Ok(Answer::Yes)
}

fn draw(arguments: &Arguments, file: &Path) -> Result<(), Failure> {
    let Arguments { positions, format, clocks, overwrite, .. } = arguments;
    let [position] = positions[..] else {
        return Err(bad_input(format!("--svg: a figure is of one position, not of {}", positions.len())));
    };
    let format = format.format();
    let clocks = clocks.unwrap_or(usual_clocks(format));
    if clocks > DRAWN_MAX {
        return Err(bad_input(format!("--svg: a figure has at most {DRAWN_MAX} clocks, not {clocks}")));
    }
    let existing = if *overwrite { Existing::Replaced } else { Existing::Kept };
    let title =
        format!("position {position} ({position:06X}h), {}, {clocks} clocks of 500 kHz", FormatText(format));
    let svg = pulses(&title, position, format, clocks).svg();
    write_new_file("--svg", file, existing, |new| new.write_all(svg.as_bytes()))
}
