//! `encoring ssi encode`: what the line carries for a position.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use encoring_files::Existing;
use encoring_words::ssi_frame::{CLOCK_HZ_LIMIT, SsiFormat};
use serde::Serialize;

use super::drawing::Transfer;
use super::format::{FormatArguments, FormatText, rate};
use crate::arguments::{self, Output};
use crate::output::new_file::write_new_file;
use crate::output::{Answer, Failure, Format, bad_input, note, page};

/// The most clocks that are shown.
const CLOCKS_MAX: u32 = 1_024;
/// The longest delay.
const DELAY_MAX_NS: u32 = 100_000;
/// The most clocks of a figure.
const DRAWN_MAX: u32 = 128;

/// Show what the encoder sends for a position, clock by clock
#[derive(Args, Debug)]
#[command(after_help = "\
Data+ changes with each rising clock edge. A receiver that takes the level at the
falling edge, or just before the rising edge, sees the High of rest first. It gets one
bit less at the end: `rising` and `falling` show this, one bit for each edge. If --delay
is longer than the High phase of the clock, the falling edge is one bit late.

Exit codes:
  0  printed
  2  wrong usage
  3  the file of --svg could not be written

Examples:
  encoring ssi encode 9999 --bits 25
  encoring ssi encode 0x270F --bits 14 --code gray --clocks 20
  encoring ssi encode 9999 --bits 31 --svg ak40.svg
  encoring ssi encode 9999 --clock-rate 1MHz --delay 650
  encoring ssi encode 9999 --repetition --clocks 52 --format json")]
pub(crate) struct Arguments {
    /// The position in steps: decimal, or hexadecimal as 0x270F or 270Fh
    #[arg(required = true, value_name = "POSITION", value_parser = arguments::value)]
    positions: Vec<u32>,
    #[command(flatten)]
    format: FormatArguments,
    /// Number of clocks to show, 1 to 1024 [default: one more than the field has bits]
    #[arg(long, value_name = "K", value_parser = arguments::whole::<u32>(1..=CLOCKS_MAX))]
    clocks: Option<u32>,
    /// Clock rate, such as 500kHz or 1MHz
    #[arg(long, value_name = "RATE", default_value = "500kHz", value_parser = clock_rate)]
    clock_rate: u64,
    /// Delay from a rising edge to the data at the receiver in ns, 0 to 100000: the cable both ways, and the encoder
    #[arg(long, value_name = "NS", default_value_t = 0, value_parser = arguments::whole::<u64>(0..=DELAY_MAX_NS))]
    delay: u64,
    /// Draw the figure to this file
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Replace the file of --svg if it exists
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
    fn new(position: u32, arguments: &Arguments) -> Self {
        let format = arguments.format.format();
        let (transfer, clocks) = arguments.transfer(position);
        Self {
            field: transfer.field(),
            line: transfer.line(),
            rising: transfer.rising(),
            falling: transfer.falling(),
            heading: format!(
                "position {position} ({position:06X}h), {}, {clocks} clocks",
                FormatText(format)
            ),
            remark: cut(position, format),
            drawn: transfer.text(),
        }
    }
}

impl Arguments {
    /// How a position is sent, and in how many clocks.
    fn transfer(&self, position: u32) -> (Transfer, u32) {
        let format = self.format.format();
        let clocks = self.clocks.unwrap_or(usual_clocks(format));
        (Transfer::new(position, format, clocks, self.clock_rate, self.delay), clocks)
    }
}

/// A rate at which an SSI can be drawn.
fn clock_rate(text: &str) -> Result<u64, String> {
    let hz = rate(text)?;
    let (least, most) = CLOCK_HZ_LIMIT;
    let is_possible = (u64::from(least)..=u64::from(most)).contains(&hz);
    is_possible.then_some(hz).ok_or_else(|| format!("{text}: an SSI is clocked with {least} to {most} Hz"))
}

/// One more than the field has bits: data change with rising edges, and the first bit is there after the first one.
fn usual_clocks(format: SsiFormat) -> u32 {
    u32::from(format.bits()) + 1
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
        let view = EncodedView::new(*position, arguments);
        text.push_str(&page(arguments.output.format, &view)?);
    }
    io::stdout().lock().write_all(text.as_bytes())?;
    Ok(Answer::Yes)
}

fn draw(arguments: &Arguments, file: &Path) -> Result<(), Failure> {
    let Arguments { positions, format, clock_rate, overwrite, .. } = arguments;
    let [position] = positions[..] else {
        return Err(bad_input(format!("--svg: a figure is of one position, not of {}", positions.len())));
    };
    let (transfer, clocks) = arguments.transfer(position);
    if clocks > DRAWN_MAX {
        return Err(bad_input(format!("--svg: a figure has at most {DRAWN_MAX} clocks, not {clocks}")));
    }
    let (format, khz) = (FormatText(format.format()), clock_rate / 1_000);
    let title = format!("position {position} ({position:06X}h), {format}, {clocks} clocks of {khz} kHz");
    let svg = transfer.svg(&title);
    let existing = if *overwrite { Existing::Replaced } else { Existing::Kept };
    write_new_file("--svg", file, existing, |new| Ok(new.write_all(svg.as_bytes())?))
}
