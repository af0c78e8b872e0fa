//! The text of an address in pieces that know their column.

use std::ops::RangeInclusive;

use super::{AddressError, AddressProblem};
use crate::place::{RegisterPlace, Table};

/// A piece of an address and the column at which it begins.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    pub(super) column: usize,
    pub(super) text: &'a str,
}

impl<'a> Piece<'a> {
    pub(super) fn error(self, problem: impl FnOnce(String) -> AddressProblem) -> AddressError {
        AddressError { column: self.column, problem: problem(self.text.to_owned()) }
    }

    /// What stands before and after the first `separator`.
    pub(super) fn split(self, separator: char) -> (Self, Option<Self>) {
        match self.text.split_once(separator) {
            Some((before, after)) => {
                let column = self.column + before.chars().count() + 1;
                (Self { text: before, ..self }, Some(Self { column, text: after }))
            }
            None => (self, None),
        }
    }

    pub(super) fn strip(self, prefix: &str) -> Option<Self> {
        let text = self.text.strip_prefix(prefix)?;
        Some(Self { column: self.column + prefix.chars().count(), text })
    }

    /// A number in decimal digits and nothing else.
    pub(super) fn number(self, allowed: &RangeInclusive<u32>) -> Option<u32> {
        let digits = !self.text.is_empty() && self.text.bytes().all(|byte| byte.is_ascii_digit());
        self.text.parse().ok().filter(|number| digits && allowed.contains(number))
    }

    /// What a number of five or six digits is in which 3 stands for input and 4 for holding registers, from 1.
    fn paper(self) -> Option<RegisterPlace> {
        let (table, number) = self.text.split_at_checked(1)?;
        let table = match table {
            "3" => Table::Input,
            "4" => Table::Holding,
            _ => return None,
        };
        let number = Self { text: number, ..self };
        let number = matches!(number.text.len(), 4 | 5).then(|| number.number(&(1..=65_536)))??;
        Some(RegisterPlace { table, first: u16::try_from(number - 1).ok()? })
    }

    pub(super) fn place(self) -> Option<RegisterPlace> {
        let (table, first) = self.split(':');
        let table = match table.text {
            "holding" => Table::Holding,
            "input" => Table::Input,
            _ => return None,
        };
        let first = first?.number(&(0..=u32::from(u16::MAX)))?;
        Some(RegisterPlace { table, first: u16::try_from(first).ok()? })
    }
}

/// The options, as far as they were given.
pub(super) struct Options<'a> {
    given: Vec<(&'static str, Piece<'a>)>,
}

impl<'a> Options<'a> {
    /// Takes apart what stands behind the question mark.
    pub(super) fn parse(text: Option<Piece<'a>>, keys: &[&'static str]) -> Result<Self, AddressError> {
        let mut given: Vec<(&'static str, Piece<'a>)> = Vec::new();
        let mut rest = text;
        while let Some(options) = rest {
            let (option, further) = options.split('&');
            rest = further;
            let (name, value) = option.split('=');
            let Some(key) = keys.iter().copied().find(|key| *key == name.text) else {
                return Err(name.error(|given| AddressProblem::Unknown { given, allowed: keys.join(", ") }));
            };
            let value = value.ok_or_else(|| name.error(|given| AddressProblem::NoValue { given }))?;
            if given.iter().any(|(earlier, _)| *earlier == key) {
                return Err(name.error(|_| AddressProblem::Twice { key }));
            }
            given.push((key, value));
        }
        Ok(Self { given })
    }

    pub(super) fn find(&self, key: &str) -> Option<Piece<'a>> {
        self.given.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
    }

    /// The option's value, if it is given; an error if `read` makes nothing of it.
    pub(super) fn value<T>(
        &self,
        key: &'static str,
        allowed: &str,
        read: impl FnOnce(Piece<'a>) -> Option<T>,
    ) -> Result<Option<T>, AddressError> {
        let Some(piece) = self.find(key) else { return Ok(None) };
        let refused =
            || piece.error(|given| AddressProblem::Value { key, given, allowed: allowed.to_owned() });
        read(piece).map(Some).ok_or_else(refused)
    }

    /// Registers, if they are given and `allowed`.
    pub(super) fn place(
        &self,
        key: &'static str,
        text: &str,
        allowed: impl FnOnce(&RegisterPlace) -> bool,
    ) -> Result<Option<RegisterPlace>, AddressError> {
        if let Some(piece) = self.find(key)
            && let Some(meant) = piece.paper()
        {
            return Err(piece.error(|given| AddressProblem::Notation { key, given, meant }));
        }
        self.value(key, text, |piece| piece.place().filter(allowed))
    }

    pub(super) fn number(
        &self,
        key: &'static str,
        allowed: &RangeInclusive<u32>,
    ) -> Result<Option<u32>, AddressError> {
        let text = format!("{} to {}", allowed.start(), allowed.end());
        self.value(key, &text, |piece| piece.number(allowed))
    }
}
