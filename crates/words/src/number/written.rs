//! Marks and digits of one number.

use super::{Base, NumberProblem, Size};

/// What stands before or behind the digits of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    /// Nothing.
    None,
    /// A sign, or a type whose numbers are decimal; the digits may have a sign.
    Decimal(Option<Size>),
    /// A base, and in front of it perhaps a type.
    Base(Base, Option<Size>),
}

impl Mark {
    pub(super) fn is_decimal(self) -> bool {
        matches!(self, Self::Decimal(_))
    }
}

/// The marks that stand in front, in lower case: of programming languages, of IEC 61131-3, S7 and S5. None begins
/// another.
const MARKS: [(&str, Mark); 18] = [
    ("0x", Mark::Base(Base::Hexadecimal, None)),
    ("16#", Mark::Base(Base::Hexadecimal, None)),
    ("2#", Mark::Base(Base::Binary, None)),
    ("dw#16#", Mark::Base(Base::Hexadecimal, Some(Size::Word))),
    ("dword#16#", Mark::Base(Base::Hexadecimal, Some(Size::Word))),
    ("dh=", Mark::Base(Base::Hexadecimal, Some(Size::Word))),
    ("w#16#", Mark::Base(Base::Hexadecimal, Some(Size::Half))),
    ("word#16#", Mark::Base(Base::Hexadecimal, Some(Size::Half))),
    ("kh=", Mark::Base(Base::Hexadecimal, Some(Size::Half))),
    ("b#16#", Mark::Base(Base::Hexadecimal, Some(Size::Byte))),
    ("byte#16#", Mark::Base(Base::Hexadecimal, Some(Size::Byte))),
    ("l#", Mark::Decimal(Some(Size::Word))),
    ("dint#", Mark::Decimal(Some(Size::Word))),
    ("udint#", Mark::Decimal(Some(Size::Word))),
    ("int#", Mark::Decimal(Some(Size::Half))),
    ("uint#", Mark::Decimal(Some(Size::Half))),
    ("kf=", Mark::Decimal(Some(Size::Half))),
    ("dword#2#", Mark::Base(Base::Binary, Some(Size::Word))),
];

/// A number, its mark taken off.
#[derive(Clone, Copy, Debug)]
pub(super) struct Written<'a> {
    pub(super) mark: Mark,
    /// The rest: digits, perhaps behind a sign if the mark is a decimal one.
    rest: &'a str,
}

impl<'a> Written<'a> {
    /// Looks for the mark of a number without spaces around.
    pub(super) fn of(text: &'a str) -> Self {
        if text.starts_with(['+', '-']) {
            return Self { mark: Mark::Decimal(None), rest: text };
        }
        for (name, mark) in MARKS {
            if let Some((front, rest)) = text.split_at_checked(name.len())
                && front.eq_ignore_ascii_case(name)
            {
                return Self { mark, rest };
            }
        }
        match text.strip_suffix(['h', 'H']) {
            Some(rest) => Self { mark: Mark::Base(Base::Hexadecimal, None), rest },
            None => Self { mark: Mark::None, rest: text },
        }
    }

    pub(super) const fn base(self) -> Base {
        match self.mark {
            Mark::Base(base, _) => base,
            Mark::None | Mark::Decimal(_) => Base::Decimal,
        }
    }

    const fn size(self) -> Option<Size> {
        match self.mark {
            Mark::Base(_, size) | Mark::Decimal(size) => size,
            Mark::None => None,
        }
    }
}

/// A marked number as bits of this size. A word or a piece of one must not have the mark of another size: half a
/// word is none. A value only has to fit, its mark too.
pub(super) fn whole(written: Written<'_>, size: Size) -> Result<u32, NumberProblem> {
    let (base, rest) = (written.base(), written.rest);
    let (negative, rest) = match (written.mark, rest.strip_prefix('-')) {
        (Mark::Decimal(_), Some(rest)) => (true, rest),
        (Mark::Decimal(_), None) => (false, rest.strip_prefix('+').unwrap_or(rest)),
        _ => (false, rest),
    };
    let Some(found) = digits(rest, base) else { return Err(NumberProblem::NoNumber) };
    match written.size() {
        Some(marked) if size != Size::Value && marked != size => {
            return Err(NumberProblem::OtherSize { marked });
        }
        Some(marked) if !negative => {
            marked.of(found.number, base)?;
        }
        _ => {}
    }
    if !negative {
        return size.of(found.number, base);
    }
    match i64::try_from(found.number).map(|number| -number) {
        // Two's complement: the bits of the size are kept.
        Ok(number) if number >= size.smallest() => Ok(number as u32 & size.largest()),
        _ => Err(NumberProblem::Below { limit: size.smallest() }),
    }
}

/// Digits of a base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Digits {
    /// What they are; the largest of 64 bits stands for all above it.
    pub(super) number: u64,
    /// How many there are, without `_`.
    pub(super) count: usize,
}

/// Reads digits with single `_` between them; `None` for anything else and for nothing.
pub(super) fn digits(text: &str, base: Base) -> Option<Digits> {
    let mut found = Digits { number: 0, count: 0 };
    let mut behind_digit = false;
    for letter in text.chars() {
        behind_digit = match letter {
            '_' if behind_digit => false,
            _ => {
                let digit = letter.to_digit(base.radix())?;
                found.number = found.number.saturating_mul(base.radix().into()).saturating_add(digit.into());
                found.count += 1;
                true
            }
        };
    }
    behind_digit.then_some(found)
}
