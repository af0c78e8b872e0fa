//! `encoring decode`: what a word means.

mod lines;

use std::io::{self, IsTerminal, Write};

use clap::{Args, ValueEnum};
use encoring_words::model::MODELS;
use encoring_words::number::{self, Bare, Reading};
use encoring_words::{Model, OutWord};

use crate::arguments::{self, Output};
use crate::output::{Answer, Failure, Format, bad_input, note};
use crate::registers::RegistersView;
use crate::word_view::{Shown, WordView};

/// Explain a 32-bit word of an encoder, bit by bit
#[derive(Args, Debug)]
#[command(after_help = "\
Write a word as a PLC or a table shows it, in upper or lower case:
  C200270F, 0xC200270F, C200270Fh, 16#C200270F, DW#16#C200270F, 2#1100...
  a signed number: -1040177393, L#-1040177393
  two halves, high half first: C200 270F, W#16#C200 W#16#270F, KH=C200 KH=270F
  four bytes: C2 00 27 0F

Without WORDS, or with `-`, the command reads standard input: one word a line, or the
registers as mbpoll prints them ([5]: 0xC200). It skips lines that begin with #.

Exit codes:
  0  every word was explained
  2  a word cannot be read
  3  standard input holds no word

Examples:
  encoring decode C200270F
  encoring decode W#16#C200 W#16#270F --direction out --model ce-65-m
  encoring decode --decimal 3254789903
  encoring decode 8800 2080 --direction in    # an error status, with its remedy
  encoring decode --master 00E4 0380          # the diagnostic registers of the master
  encoring decode --format json < words.txt
  mbpoll -1 -t 3:hex -r 5 -c 2 192.168.1.10 | encoring decode -")]
pub(crate) struct Arguments {
    /// The word, or `-` for standard input
    #[arg(allow_negative_numbers = true)]
    words: Vec<String>,

    /// Read numbers without sign and base mark as decimal
    #[arg(long)]
    decimal: bool,

    /// Explain only one direction: out is master to encoder, in is encoder to master
    #[arg(long)]
    direction: Option<Direction>,

    /// Explain the word for this model only
    #[arg(long, value_parser = arguments::model())]
    model: Option<Model>,

    /// Explain the diagnostic status register and the diagnostic parameter register of the master
    #[arg(long, num_args = 2, value_names = ["STATUS", "PARAMETER"], allow_negative_numbers = true,
          conflicts_with_all = ["words", "direction", "model"])]
    master: Option<Vec<String>>,

    #[command(flatten)]
    output: Output,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Direction {
    In,
    Out,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let bare = if arguments.decimal { Bare::Decimal } else { Bare::Hexadecimal };
    if let Some([status, parameter]) = arguments.master.as_deref() {
        // Two registers are two halves of 32 bits.
        let both = number::word([status.as_str(), parameter], bare).map_err(bad_input)?;
        doubts([both].into_iter());
        let both = OutWord(both.bits);
        arguments.output.print(&RegistersView::new(both.high(), both.low()))?;
        return Ok(Answer::Yes);
    }
    let model = arguments.model.map(|model| [model]);
    let shown = Shown {
        out: arguments.direction != Some(Direction::In),
        input: arguments.direction != Some(Direction::Out),
        models: model.as_ref().map_or(&MODELS, <[Model; 1]>::as_slice),
    };
    let format = arguments.output.format;
    let mut printer = Printer { shown, format, sink: io::stdout().lock(), page: Vec::new(), any: false };
    let words: Vec<&str> = arguments.words.iter().map(String::as_str).collect();
    match words.as_slice() {
        [] | ["-"] => {
            if io::stdin().is_terminal() {
                note("words are read from this terminal, one a line; Ctrl-D ends");
            }
            let told = lines::decode(bare, &mut printer);
            printer.flush()?;
            told
        }
        words => {
            let reading = number::word(words.iter().copied(), bare).map_err(bad_input)?;
            doubts([reading].into_iter());
            printer.print(reading.bits)?;
            printer.flush()?;
            Ok(Answer::Yes)
        }
    }
}

/// Says once what somebody may not have meant.
fn doubts(mut readings: impl Iterator<Item = Reading>) {
    if let Some(doubt) = readings.find_map(|reading| reading.note) {
        note(&format!("note: {doubt}"));
    }
}

/// Prints words, a page of them at a time.
struct Printer<'a, W> {
    shown: Shown<'a>,
    format: Format,
    sink: W,
    page: Vec<u8>,
    any: bool,
}

impl<W: Write> Printer<'_, W> {
    /// Beyond this many bytes a page is written.
    const PAGE: usize = 32 * 1024;

    fn print(&mut self, word: u32) -> Result<(), Failure> {
        let view = WordView::new(word, self.shown);
        match self.format {
            Format::Text if self.any => write!(self.page, "\n{view}")?,
            Format::Text => write!(self.page, "{view}")?,
            Format::Json => {
                serde_json::to_writer(&mut self.page, &view)?;
                self.page.push(b'\n');
            }
        }
        self.any = true;
        if self.page.len() > Self::PAGE { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Failure> {
        self.sink.write_all(&self.page)?;
        self.sink.flush()?;
        self.page.clear();
        Ok(())
    }
}
