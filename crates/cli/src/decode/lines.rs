//! Words from standard input: one a line, or in registers as mbpoll prints them.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::iter;

use encoring_words::number::{self, Bare, Reading, Register};

use super::{Printer, doubts};
use crate::output::{Answer, Failure, bad_input, note};

/// The most bytes of a line, so that memory is bounded whatever comes in.
const LINE_LIMIT: usize = 4096;

/// Spreadsheets and Windows put this in front of UTF-8.
const BYTE_ORDER_MARK: char = '\u{FEFF}';

/// Explains the words of standard input, and what is there before waiting for more. Unknown if there is no word.
pub(super) fn decode<W: Write>(bare: Bare, printer: &mut Printer<'_, W>) -> Result<Answer, Failure> {
    let mut input = BufReader::new(io::stdin().lock());
    let mut lines = Lines { bare, high: None, program: false, doubted: false };
    let mut line = Vec::new();
    for number in 1_u64.. {
        if input.buffer().is_empty() {
            printer.flush()?;
        }
        let at = |problem: String| bad_input(format!("standard input line {number}: {problem}"));
        line.clear();
        // One more than the limit, and a line feed.
        let read = input.by_ref().take(LINE_LIMIT as u64 + 2).read_until(b'\n', &mut line);
        match read.map_err(|error| at(format!("cannot be read: {error}")))? {
            0 => {
                lines.end().map_err(at)?;
                return Ok(lines.told(printer.any));
            }
            _ if number == 1 && (line.starts_with(b"\xFF\xFE") || line.starts_with(b"\xFE\xFF")) => {
                return Err(at("the text is UTF-16; save it as UTF-8".to_owned()));
            }
            _ if line.trim_ascii_end().len() > LINE_LIMIT => {
                return Err(at(format!("longer than {LINE_LIMIT} bytes")));
            }
            _ => {}
        }
        let text = String::from_utf8_lossy(&line);
        if let Some(word) = lines.word(text.trim_start_matches(BYTE_ORDER_MARK)).map_err(at)? {
            printer.print(word)?;
        }
    }
    Ok(Answer::Yes)
}

/// What the lines have been so far.
struct Lines {
    bare: Bare,
    /// A register whose other half is to follow: its number and its line.
    high: Option<(u32, String)>,
    /// What mbpoll prints beside registers is left out.
    program: bool,
    doubted: bool,
}

impl Lines {
    /// The word that ends with a line, if one does.
    fn word(&mut self, line: &str) -> Result<Option<u32>, String> {
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') {
            return Ok(None);
        }
        if let Some(register) = Register::of(text) {
            return self.register(register, text);
        }
        self.program |= text.starts_with("mbpoll ") || text.starts_with("-- ");
        self.end()?;
        if self.program {
            return Ok(None);
        }
        let reading = number::word([text], self.bare).map_err(|error| error.to_string())?;
        self.doubt(reading);
        Ok(Some(reading.bits))
    }

    fn register(&mut self, low: Register<'_>, text: &str) -> Result<Option<u32>, String> {
        let Some((number, line)) = self.high.take() else {
            self.high = Some((low.number, text.to_owned()));
            return Ok(None);
        };
        match Register::of(&line) {
            Some(high) if number.checked_add(1) == Some(low.number) => {
                high.followed_by(low).map(Some).map_err(|error| error.to_string())
            }
            _ => Err(format!("register {} behind register {number}: a word is two in a row", low.number)),
        }
    }

    /// The answer at the end; without a word it says so.
    fn told(&self, any: bool) -> Answer {
        if any {
            return Answer::Yes;
        }
        note(if self.program {
            "no word is there: mbpoll has read no register; what it says of it is in its output"
        } else {
            "no word is there: standard input is empty, or all comments"
        });
        Answer::Unknown
    }

    /// A register alone is half a word.
    fn end(&mut self) -> Result<(), String> {
        match self.high.take() {
            None => Ok(()),
            Some((number, _)) => Err(format!("register {number} is half a word: the next one is missing")),
        }
    }

    fn doubt(&mut self, reading: Reading) {
        if reading.note.is_some() && !self.doubted {
            self.doubted = true;
            doubts(iter::once(reading));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(lines: &str) -> Result<Vec<u32>, String> {
        let mut reader = Lines { bare: Bare::Hexadecimal, high: None, program: false, doubted: false };
        let mut words = Vec::new();
        for line in lines.lines() {
            words.extend(reader.word(line)?);
        }
        reader.end().map(|()| words)
    }

    #[test]
    fn what_mbpoll_prints_beside_registers_is_left_out() {
        let printed = "mbpoll 1.4-11 - FieldTalk(tm) Modbus(R) Master Simulator\n\
                       Protocol configuration: Modbus TCP\n\
                       Slave configuration...: address = [1]\n\
                       \u{20}                       start reference = 5, count = 4\n\n\
                       -- Polling slave 1...\n[5]: \t0xC200\n[6]: \t0x270F\n[7]: \t0x8800\n[8]: \t0x0000\n\n\
                       -- Polling slave 1...\n[5]: \t49664 (-15872)\n[6]: \t9999\n";
        assert_eq!(words(printed), Ok(vec![0xC200_270F, 0x8800_0000, 0xC200_270F]));
    }

    #[test]
    fn a_word_needs_two_registers_in_a_row() {
        for (wrong, told) in [
            ("[5]: 0xC200", "register 5 is half a word"),
            ("[5]: 0xC200\n88000000", "register 5 is half a word"),
            ("[5]: 0xC200\n-- Polling slave 1...", "register 5 is half a word"),
            ("[5]: 0xC200\n[7]: 0x270F", "register 7 behind register 5: "),
            ("[6]: 0x270F\n[5]: 0xC200", "register 5 behind register 6: "),
            ("[5]: 0xC200\n[6]: read failed", "read failed: not half a word"),
        ] {
            assert!(words(wrong).unwrap_err().starts_with(told), "{wrong}: {:?}", words(wrong));
        }
        // Words and registers may stand in one text.
        assert_eq!(
            words("88000000\n[5]: 0xC200\n[6]: 0x270F\n-1"),
            Ok(vec![0x8800_0000, 0xC200_270F, u32::MAX])
        );
    }
}
