//! Why a number was refused.

use core::fmt;

use super::{Size, TypedValue};

/// A number that was refused: what stands there, what it should have been, and why not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberError<'a> {
    /// The piece at fault, without spaces around.
    pub found: &'a str,
    /// What was to be read.
    pub size: Size,
    /// What is wrong with it.
    pub problem: NumberProblem,
}

/// What is wrong with a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberProblem {
    /// A word has one piece, two or four.
    Pieces(usize),
    /// Something else than digits stands there, or nothing.
    NoNumber,
    /// Without sign and base mark fewer digits than there must be: zeros may be lost, or it is decimal.
    FewDigits {
        /// What it is in hexadecimal, if zeros were lost.
        hexadecimal: u32,
        /// What it is in decimal, if it is.
        decimal: Option<u32>,
    },
    /// Without sign and base mark more digits than a hexadecimal number has there.
    ManyDigits {
        /// What it is in decimal, if it fits.
        decimal: Option<u32>,
    },
    /// Hexadecimal without a base mark where decimal was said.
    Letters,
    /// Digits without a letter and without a mark beside a decimal number.
    BesideDecimal,
    /// The mark of another size.
    OtherSize {
        /// What the mark says.
        marked: Size,
    },
    /// A hexadecimal value without a base mark.
    NoMark {
        /// What it is, if it fits.
        hexadecimal: Option<u32>,
    },
    /// A value with a zero in front, as hexadecimal ones were printed.
    LeadingZero {
        /// What it is in decimal.
        decimal: u32,
        /// What it is in hexadecimal.
        hexadecimal: u32,
    },
    /// More than the size holds.
    Above {
        /// The largest number, in the base that was written.
        limit: TypedValue,
    },
    /// Less than the size holds.
    Below {
        /// The smallest number.
        limit: i64,
    },
}

impl core::error::Error for NumberError<'_> {}

impl fmt::Display for NumberError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { found, size, problem } = *self;
        match problem {
            NumberProblem::Pieces(count) => {
                return write!(f, "{count} numbers are no word: it is {}", Forms(Size::Word));
            }
            NumberProblem::NoNumber if found.is_empty() => {
                return write!(f, "nothing stands here; {size} is {}", Forms(size));
            }
            _ => {}
        }
        let found = Excerpt(found);
        let digits = size.digits();
        write!(f, "{found}: ")?;
        match problem {
            NumberProblem::Pieces(_) | NumberProblem::NoNumber => {
                write!(f, "not {size}; {size} is {}", Forms(size))
            }
            NumberProblem::FewDigits { hexadecimal, decimal } => {
                write!(f, "{size} has {digits} digits; zeros may be lost. ")?;
                let zeros = digits;
                match decimal {
                    Some(decimal) => write!(
                        f,
                        "Write {hexadecimal:0zeros$X} for {found}h, or give --decimal for {decimal}"
                    ),
                    None => write!(f, "Write {hexadecimal:0zeros$X} or 0x{hexadecimal:X}"),
                }
            }
            NumberProblem::ManyDigits { decimal: Some(decimal) } => {
                write!(
                    f,
                    "{size} has {digits} hexadecimal digits; for {decimal} in decimal there is --decimal"
                )
            }
            NumberProblem::ManyDigits { decimal: None } => {
                write!(f, "{size} has {digits} hexadecimal digits")
            }
            NumberProblem::Letters => {
                write!(f, "not decimal; beside --decimal hexadecimal is written 0x{found}")
            }
            NumberProblem::BesideDecimal => {
                write!(
                    f,
                    "{found}h, or {found} in decimal as the number beside it; write 0x{found}, or give --decimal"
                )
            }
            NumberProblem::OtherSize { marked } => write!(f, "marked as {marked}, and here stands {size}"),
            NumberProblem::NoMark { hexadecimal: Some(hexadecimal) } => {
                write!(f, "not decimal; if {found}h = {hexadecimal} is meant, write the h")
            }
            NumberProblem::NoMark { hexadecimal: None } => write!(f, "not {size}; {size} is {}", Forms(size)),
            NumberProblem::LeadingZero { decimal, hexadecimal } => {
                write!(f, "{decimal}, or {hexadecimal:X}h = {hexadecimal}; write one of them")
            }
            NumberProblem::Above { limit } => {
                // A mark may leave less room than what is read.
                let bits = u32::BITS - limit.number.leading_zeros();
                write!(f, "above {limit}, the largest number of {bits} bits")
            }
            NumberProblem::Below { limit: 0 } => write!(f, "below 0"),
            NumberProblem::Below { limit } => {
                write!(f, "below {limit}, the smallest number of {} bits", size.bits())
            }
        }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Byte => "a byte",
            Self::Half => "half a word",
            Self::Value => "a value",
            Self::Word => "a word",
        })
    }
}

/// How something of this size is written.
struct Forms(Size);

impl fmt::Display for Forms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            Size::Byte => "two hexadecimal digits, as C2",
            Size::Half => "four hexadecimal digits, as C200, 0xC200 or W#16#C200, or signed as -15872",
            Size::Value => "a number from 0 to 16777215; hexadecimal as 270Fh, 0x270F or 16#270F",
            Size::Word => {
                "eight hexadecimal digits, as C200270F, 0xC200270F or DW#16#C200270F, two halves as C200 270F, \
                 four bytes as C2 00 27 0F, or signed as -1040177393"
            }
        })
    }
}

/// The start of a text that somebody wrote, fit for a message.
pub(crate) struct Excerpt<'a>(pub(crate) &'a str);

impl Excerpt<'_> {
    const CHARS: usize = 40;
}

impl fmt::Display for Excerpt<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut letters = self.0.chars();
        for letter in letters.by_ref().take(Self::CHARS) {
            match letter {
                '\'' | '"' => write!(f, "{letter}")?,
                _ => write!(f, "{}", letter.escape_debug())?,
            }
        }
        if letters.next().is_some() { f.write_str("...") } else { Ok(()) }
    }
}
