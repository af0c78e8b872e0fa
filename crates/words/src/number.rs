//! Numbers as people write them: what a PLC monitor, a spreadsheet or a type label shows, and what this product
//! prints.
//!
//! A *word* is 32 bits, whole or in pieces; a *value* is 24 bits of data. What can be read in two ways is refused
//! with both: nobody notices a wrong base in time. `docs/numbers.md` has the forms.
//!
//! Upper and lower case are one, spaces around are left out, and `_` may stand between digits.

mod error;
mod written;

use core::fmt;

pub(crate) use error::Excerpt;
pub use error::{NumberError, NumberProblem};
use written::{Mark, Written, digits, whole};

use crate::word::DATA_MAX;

/// What a number without sign and without base mark is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bare {
    /// Hexadecimal with all its digits, as words are printed.
    #[default]
    Hexadecimal,
    /// Decimal: the option `--decimal`.
    Decimal,
}

/// The base that a number was written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// `2#1100`.
    Binary,
    /// `9999`, `-1`, `L#-1`.
    Decimal,
    /// `0x270F`, `270Fh`, `16#270F`.
    Hexadecimal,
}

impl Base {
    pub(super) const fn radix(self) -> u32 {
        match self {
            Self::Binary => 2,
            Self::Decimal => 10,
            Self::Hexadecimal => 16,
        }
    }
}

/// How many bits a number has to fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// A quarter of a word.
    Byte,
    /// One of the two 16-bit words that a word has in the process image.
    Half,
    /// A value of 24 bits.
    Value,
    /// 32 bits.
    Word,
}

impl Size {
    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u32 {
        match self {
            Self::Byte => 8,
            Self::Half => 16,
            Self::Value => 24,
            Self::Word => 32,
        }
    }

    /// The hexadecimal digits that it has when none is left out.
    #[must_use]
    pub const fn digits(self) -> usize {
        self.bits() as usize / 4
    }

    /// The largest number in it.
    #[must_use]
    pub const fn largest(self) -> u32 {
        u32::MAX >> (u32::BITS - self.bits())
    }

    /// The smallest number in it, as a signed one; a value has no sign.
    #[must_use]
    pub const fn smallest(self) -> i64 {
        match self {
            Self::Value => 0,
            Self::Byte | Self::Half | Self::Word => -(1 << (self.bits() - 1)),
        }
    }
}

/// Bits that were read, and what should be said of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// The word, or the half.
    pub bits: u32,
    /// What the one who wrote it may not have meant.
    pub note: Option<Note>,
}

/// Digits without a letter, which were read as hexadecimal and may be meant as decimal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Note;

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "digits without a letter were read as hexadecimal; for decimal numbers there is --decimal",
        )
    }
}

/// A word of one or more arguments or of one cell: whole (`C200270F`, `0xC200270F`, `C200270Fh`, `16#C200270F`,
/// `DW#16#C200270F`, `2#1100...`, `-1040177393`, `L#-1040177393`), in two halves with the high one first
/// (`C200 270F`, `W#16#C200 W#16#270F`, `KH=C200 KH=270F`), or in four bytes (`C2 00 27 0F`).
///
/// # Errors
/// [`NumberError`] for what is no word, and for what has two meanings.
pub fn word<'a>(parts: impl IntoIterator<Item = &'a str>, bare: Bare) -> Result<Reading, NumberError<'a>> {
    let mut found = [""; 4];
    let mut count = 0;
    for piece in parts.into_iter().flat_map(str::split_whitespace) {
        if let Some(place) = found.get_mut(count) {
            *place = piece;
        }
        count += 1;
    }
    match found {
        [whole, ..] if count == 1 => pieces(&[whole], Size::Word, bare),
        [high, low, ..] if count == 2 => pieces(&[high, low], Size::Half, bare),
        bytes if count == 4 => pieces(&bytes, Size::Byte, bare),
        [first, ..] => {
            Err(NumberError { found: first, size: Size::Word, problem: NumberProblem::Pieces(count) })
        }
    }
}

/// A word as we print it: eight hexadecimal digits, of either case. The same as [`word`] of them, and faster; `None`
/// for all else, which may still be a word in another form.
#[must_use]
pub const fn eight_digits(digits: &[u8; 8]) -> Option<u32> {
    // All eight bytes at once. Of the bytes of digits, those of letters alone have this bit.
    const EACH: u64 = 0x0101_0101_0101_0101;
    let bytes = u64::from_be_bytes(*digits);
    let letters = bytes >> 6 & EACH;
    let upper = bytes & !(letters << 5);
    let values = upper.wrapping_sub(EACH * b'0' as u64).wrapping_sub(letters * (b'A' - b'9' - 1) as u64);
    // No byte is above 15, so none has borrowed from another; and from 10 on it was a letter.
    if values & (EACH * 0xF0) != 0 || (values + EACH * 6) >> 4 & EACH != letters {
        return None;
    }
    let pairs = (values | values >> 4) & 0x00FF_00FF_00FF_00FF;
    let halves = (pairs | pairs >> 8) & 0x0000_FFFF_0000_FFFF;
    Some((halves | halves >> 16) as u32)
}

/// One half of a word: `270F`, `0x270F`, `W#16#270F`, `KH=270F`, `-15872`.
///
/// # Errors
/// [`NumberError`] for what is no half of a word, and for what has two meanings.
pub fn half(text: &str, bare: Bare) -> Result<Reading, NumberError<'_>> {
    pieces(&[text.trim()], Size::Half, bare)
}

/// A register and what it holds, as the Modbus client mbpoll prints it: `[5]: 0xC200`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register<'a> {
    /// Its number.
    pub number: u32,
    content: &'a str,
}

impl<'a> Register<'a> {
    /// Reads a line; `None` if it is none of a register.
    #[must_use]
    pub fn of(line: &'a str) -> Option<Self> {
        let (number, content) = line.trim().strip_prefix('[')?.split_once("]:")?;
        let number = u32::try_from(digits(number, Base::Decimal)?.number).ok()?;
        // What is negative as a signed number follows in brackets: `49664 (-15872)`.
        let content = content.split('(').next().unwrap_or_default().trim();
        Some(Self { number, content })
    }

    /// The word of this register and the next one.
    ///
    /// # Errors
    /// [`NumberError`] for what is no half of a word. mbpoll marks hexadecimal, so a number without a mark is decimal.
    pub fn followed_by(self, low: Self) -> Result<u32, NumberError<'a>> {
        let half = |register: Self| half(register.content, Bare::Decimal);
        Ok(half(self)?.bits << Size::Half.bits() | half(low)?.bits)
    }
}

/// A number of 24 bits as it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TypedValue {
    /// The number.
    pub number: u32,
    /// The base in which limits are told.
    pub base: Base,
}

/// A value: decimal, or marked as hexadecimal or binary. A leading zero without a mark is how hexadecimal values
/// were printed, and refused where that is another number.
///
/// # Errors
/// [`NumberError`] for what is no value, and for what has two meanings.
pub fn value(text: &str) -> Result<TypedValue, NumberError<'_>> {
    let text = text.trim();
    let size = Size::Value;
    let refused = |problem| NumberError { found: text, size, problem };
    let written = Written::of(text);
    if written.mark != Mark::None {
        let number = whole(written, size).map_err(refused)?;
        return Ok(TypedValue { number, base: written.base() });
    }
    let Some(hexadecimal) = digits(text, Base::Hexadecimal) else {
        return Err(refused(NumberProblem::NoNumber));
    };
    let hexadecimal = (hexadecimal.number <= u64::from(DATA_MAX)).then_some(hexadecimal.number as u32);
    let Some(decimal) = digits(text, Base::Decimal) else {
        return Err(refused(NumberProblem::NoMark { hexadecimal }));
    };
    let number = size.of(decimal.number, Base::Decimal).map_err(refused)?;
    match hexadecimal {
        Some(hexadecimal) if text.starts_with('0') && hexadecimal != number => {
            Err(refused(NumberProblem::LeadingZero { decimal: number, hexadecimal }))
        }
        _ => Ok(TypedValue { number, base: Base::Decimal }),
    }
}

impl From<u32> for TypedValue {
    /// A number that nobody typed.
    fn from(number: u32) -> Self {
        Self { number, base: Base::Decimal }
    }
}

impl TypedValue {
    /// Another number in this one's base.
    #[must_use]
    pub const fn like(self, number: u32) -> Self {
        Self { number, base: self.base }
    }
}

impl fmt::Display for TypedValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.base {
            Base::Binary => write!(f, "2#{:b}", self.number),
            Base::Decimal => write!(f, "{}", self.number),
            Base::Hexadecimal => write!(f, "{:X}h", self.number),
        }
    }
}

impl Size {
    /// A number of a base, if there is room for it.
    const fn of(self, number: u64, base: Base) -> Result<u32, NumberProblem> {
        if number > self.largest() as u64 {
            Err(NumberProblem::Above { limit: TypedValue { number: self.largest(), base } })
        } else {
            Ok(number as u32)
        }
    }
}

/// The pieces of a word, each of this size, the highest first.
fn pieces<'a>(pieces: &[&'a str], size: Size, bare: Bare) -> Result<Reading, NumberError<'a>> {
    let marks = || pieces.iter().map(|piece| Written::of(piece).mark);
    let (mut bits, mut letter, mut doubt) = (0_u32, false, false);
    for found in pieces {
        let refused = |problem| NumberError { found, size, problem };
        let written = Written::of(found);
        let number = if written.mark != Mark::None {
            whole(written, size).map_err(refused)?
        } else if bare == Bare::Decimal {
            bare_decimal(found, size).map_err(refused)?
        } else {
            let number = bare_hexadecimal(found, size).map_err(refused)?;
            let decimal = digits(found, Base::Decimal).map(|decimal| decimal.number);
            if decimal.is_some() && marks().any(Mark::is_decimal) {
                return Err(refused(NumberProblem::BesideDecimal));
            }
            letter |= decimal.is_none();
            doubt |= decimal.is_some_and(|decimal| decimal != u64::from(number));
            number
        };
        bits = bits.unbounded_shl(size.bits()) | number;
    }
    Ok(Reading { bits, note: (doubt && !letter).then_some(Note) })
}

fn bare_decimal(text: &str, size: Size) -> Result<u32, NumberProblem> {
    match (digits(text, Base::Decimal), digits(text, Base::Hexadecimal)) {
        (Some(decimal), _) => size.of(decimal.number, Base::Decimal),
        (None, Some(_)) => Err(NumberProblem::Letters),
        (None, None) => Err(NumberProblem::NoNumber),
    }
}

fn bare_hexadecimal(text: &str, size: Size) -> Result<u32, NumberProblem> {
    let Some(hexadecimal) = digits(text, Base::Hexadecimal) else { return Err(NumberProblem::NoNumber) };
    let decimal = || {
        let decimal = digits(text, Base::Decimal)?.number;
        (decimal <= u64::from(size.largest())).then_some(decimal as u32)
    };
    if hexadecimal.count > size.digits() {
        Err(NumberProblem::ManyDigits { decimal: decimal() })
    } else if hexadecimal.count < size.digits() {
        Err(NumberProblem::FewDigits { hexadecimal: hexadecimal.number as u32, decimal: decimal() })
    } else {
        Ok(hexadecimal.number as u32)
    }
}

#[cfg(test)]
mod tests;
