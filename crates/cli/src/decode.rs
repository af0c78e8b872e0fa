//! `encoring decode`: what a word means.

use std::io::{self, BufRead, BufReader, Read, Write};

use clap::{Args, ValueEnum};
use encoring_words::Model;
use encoring_words::model::MODELS;

use crate::arguments::{self, Output};
use crate::output::{Answer, Failure, Format, bad_input};
use crate::word_view::{Shown, WordView};

/// Explain a 32-bit word of an encoder, bit by bit
#[derive(Args, Debug)]
#[command(after_help = "\
A word is 8 hex digits, or two arguments of 4 (high word, low word), or four
arguments of 2 (bytes). Without words, or with `-`, words are read from standard
input: one a line in the same three forms; blank lines and lines that begin with
# are skipped.

Examples:
  encoring decode C200270F
  encoring decode C2 00 27 0F --direction out --model ce-65-m
  encoring decode 8800 2080 --direction in    what is wrong, and what to do
  encoring decode --format json < words.txt")]
pub(crate) struct Arguments {
    /// The word, or `-` for standard input
    words: Vec<String>,

    /// Show only what it means from master to encoder (out) or from encoder to master (in)
    #[arg(long)]
    direction: Option<Direction>,

    /// Show only what this model makes of it
    #[arg(long, value_parser = arguments::model())]
    model: Option<Model>,

    #[command(flatten)]
    output: Output,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Direction {
    In,
    Out,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let model = arguments.model.map(|model| [model]);
    let shown = Shown {
        out: arguments.direction != Some(Direction::In),
        input: arguments.direction != Some(Direction::Out),
        models: model.as_ref().map_or(&MODELS, <[Model; 1]>::as_slice),
    };
    let mut printer =
        Printer { shown, format: arguments.output.format, sink: io::stdout().lock(), page: Vec::new() };
    match arguments.words.as_slice() {
        [] => from_lines(&mut printer)?,
        [dash] if dash == "-" => from_lines(&mut printer)?,
        words => printer.print(parse(words).map_err(bad_input)?)?,
    }
    printer.flush()?;
    Ok(Answer::Yes)
}

/// Prints words, a page of them at a time.
struct Printer<'a, W> {
    shown: Shown<'a>,
    format: Format,
    sink: W,
    page: Vec<u8>,
}

impl<W: Write> Printer<'_, W> {
    /// Beyond this many bytes a page is written.
    const PAGE: usize = 32 * 1024;

    fn print(&mut self, word: u32) -> Result<(), Failure> {
        let view = WordView::new(word, self.shown);
        match self.format {
            Format::Text => write!(self.page, "{view}")?,
            Format::Json => {
                serde_json::to_writer(&mut self.page, &view)?;
                self.page.push(b'\n');
            }
        }
        if self.page.len() > Self::PAGE { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Failure> {
        self.sink.write_all(&self.page)?;
        self.sink.flush()?;
        self.page.clear();
        Ok(())
    }
}

/// The most bytes of a line, so that memory is bounded whatever comes in.
const LINE_LIMIT: usize = 4096;

/// Explains the words of standard input, and what is there before waiting for more.
fn from_lines<W: Write>(printer: &mut Printer<'_, W>) -> Result<(), Failure> {
    let mut input = BufReader::new(io::stdin().lock());
    let mut line = Vec::new();
    let mut first = true;
    for number in 1_u64.. {
        if input.buffer().is_empty() {
            printer.flush()?;
        }
        let at = |problem: String| format!("standard input line {number}: {problem}");
        line.clear();
        // One more than the limit, and a line feed.
        let read = input.by_ref().take(LINE_LIMIT as u64 + 2).read_until(b'\n', &mut line);
        let read = read.map_err(|error| bad_input(at(format!("cannot read: {error}"))));
        let word = match read {
            Ok(0) => break,
            Ok(_) if line.trim_ascii_end().len() > LINE_LIMIT => {
                Err(bad_input(at(format!("longer than {LINE_LIMIT} bytes"))))
            }
            Ok(_) => word_of_line(&line).map_err(|problem| bad_input(at(problem))),
            Err(failure) => Err(failure),
        };
        match word {
            Ok(None) => {}
            Ok(Some(word)) => {
                if !first && printer.format == Format::Text {
                    printer.page.push(b'\n');
                }
                first = false;
                printer.print(word)?;
            }
            Err(failure) => {
                printer.flush()?;
                return Err(failure);
            }
        }
    }
    Ok(())
}

/// The word of a line; `None` for a blank line and a comment.
fn word_of_line(line: &[u8]) -> Result<Option<u32>, String> {
    if line.starts_with(b"#") {
        return Ok(None);
    }
    let line = String::from_utf8_lossy(line);
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    if words.is_empty() { Ok(None) } else { parse(&words).map(Some) }
}

/// A word in one of its three forms.
fn parse<S: AsRef<str>>(words: &[S]) -> Result<u32, String> {
    let digits = match words.len() {
        1 => 8,
        2 => 4,
        4 => 2,
        other => {
            return Err(format!(
                "{other} values are no word: it is 8 hex digits, or two values of 4, or four of 2"
            ));
        }
    };
    words.iter().try_fold(0, |word: u32, part| {
        let part = part.as_ref();
        match hex(part) {
            Some(value) if part.len() == digits => {
                Ok(word.checked_shl(4 * digits as u32).unwrap_or(0) | value)
            }
            _ => Err(refusal(part, words.len(), digits)),
        }
    })
}

/// Up to 8 hex digits and nothing else.
fn hex(text: &str) -> Option<u32> {
    let digits = text.bytes().all(|byte| byte.is_ascii_hexdigit());
    if digits { u32::from_str_radix(text, 16).ok() } else { None }
}

fn refusal(part: &str, values: usize, digits: usize) -> String {
    let of = match values {
        1 => "as a word; or give two values of 4 (high, low) or four of 2 (bytes)",
        2 => "as high and as low word",
        _ => "as each byte",
    };
    let lower = part.to_ascii_lowercase();
    let bare = lower.strip_prefix("0x").unwrap_or(&lower);
    let bare = bare.strip_suffix('h').unwrap_or(bare);
    let hint = if bare != lower && hex(bare).is_some() { "; leave out 0x and h" } else { "" };
    let excerpt: String = part.chars().take(40).collect();
    let more = if excerpt.len() < part.len() { "..." } else { "" };
    format!("{:?} is not {digits} hex digits {of}{hint}", excerpt + more)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_forms_are_one_word() {
        assert_eq!(parse(&["C200270F"]), Ok(0xC200_270F));
        assert_eq!(parse(&["c200", "270f"]), Ok(0xC200_270F));
        assert_eq!(parse(&["C2", "00", "27", "0F"]), Ok(0xC200_270F));
    }

    #[test]
    fn anything_else_is_refused_with_a_hint_where_there_is_one() {
        for wrong in ["0xC200270F", "C200270Fh", "0xC200270Fh"] {
            assert!(parse(&[wrong]).unwrap_err().ends_with("; leave out 0x and h"), "{wrong}");
        }
        for wrong in [
            "",
            "C200270",
            "C200270F0",
            "C200270G",
            "+200270F",
            "C200 270F",
            "\u{0661}\u{0661}\u{0661}\u{0661}",
        ] {
            assert!(parse(&[wrong]).is_err(), "{wrong}");
        }
        assert!(parse(&["C2", "00", "27"]).unwrap_err().starts_with("3 values are no word"));
        assert!(parse(&["C2", "00", "27", "0"]).is_err());
        assert!(parse(&["C2", "0027", "0F", "00"]).is_err());
    }
}
