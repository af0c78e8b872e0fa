//! Marks: places of a machine that can be found again, and what a scale shows there.

use std::fmt;
use std::str::FromStr;

/// A place on the machine that can be found again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MachineMark {
    /// What it is called.
    pub name: String,
    /// The position that the encoder showed there, in steps.
    pub shown: u32,
    /// What a scale shows there.
    pub reference: Option<Reference>,
}

/// What a scale of the machine shows, in millionths of its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reference {
    /// The number, in millionths.
    pub millionths: i64,
    /// What the last digit that was written stands for, in millionths.
    pub digit: u32,
    /// Its unit.
    pub scale: ReferenceUnit,
}

/// What a scale counts in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceUnit {
    /// Millimetres of the machine's way.
    Millimetres,
    /// Degrees of the encoder's shaft.
    Degrees,
}

impl ReferenceUnit {
    /// Every scale.
    pub const ALL: [Self; 2] = [Self::Millimetres, Self::Degrees];

    /// The unit as people write it.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Millimetres => "mm",
            Self::Degrees => "deg",
        }
    }

    pub(crate) const fn key(self) -> &'static str {
        match self {
            Self::Millimetres => "reference_mm",
            Self::Degrees => "reference_deg",
        }
    }
}

impl Reference {
    /// 0 mm.
    pub(crate) const ZERO: Self = Self { millionths: 0, digit: 1_000_000, scale: ReferenceUnit::Millimetres };

    /// A number with at most nine digits before and six behind the point, and a sign if it has one.
    ///
    /// # Errors
    /// Why it is none.
    #[expect(clippy::disallowed_methods, reason = "what a scale of the machine shows, with decimals")]
    pub fn read(number: &str, scale: ReferenceUnit) -> Result<Self, String> {
        if number.contains(',') {
            return Err(format!(
                "{number:?}: write the decimals behind a point: {}",
                number.replacen(',', ".", 1)
            ));
        }
        let (sign, digits) = match number.strip_prefix('-') {
            Some(digits) => (-1, digits),
            None => (1, number.strip_prefix('+').unwrap_or(number)),
        };
        let (whole, decimals) = digits.split_once('.').unwrap_or((digits, ""));
        let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        let point = digits.contains('.');
        if whole.is_empty() || !are_digits(whole) || !are_digits(decimals) || point && decimals.is_empty() {
            return Err(format!("{number:?} is no number like 0, -12.5 or 180"));
        }
        if whole.len() > 9 || decimals.len() > 6 {
            return Err(format!("{number:?} has more than 9 digits before or 6 behind the point"));
        }
        let magnitude: i64 =
            format!("{whole}{decimals:0<6}").parse().map_err(|_| format!("{number:?} is no number"))?;
        let digit = 10_u32.pow(6_u32.saturating_sub(decimals.len() as u32));
        Ok(Self { millionths: sign * magnitude, digit, scale })
    }

    /// The number alone.
    pub(crate) fn number(self) -> String {
        let sign = if self.millionths < 0 { "-" } else { "" };
        let (whole, rest) =
            (self.millionths.unsigned_abs() / 1_000_000, self.millionths.unsigned_abs() % 1_000_000);
        let places = 6_usize.saturating_sub(self.digit.max(1).ilog10() as usize);
        let decimals = format!("{rest:06}");
        match decimals.get(..places) {
            Some("") | None => format!("{sign}{whole}"),
            Some(decimals) => format!("{sign}{whole}.{decimals}"),
        }
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.number(), self.scale.unit())
    }
}

impl FromStr for Reference {
    type Err = String;

    /// A number with its unit, as `12.5 mm` or `-90 deg`. What can be a number of thousands is refused: `1.000 mm`.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let of = |scale: ReferenceUnit, unit: &str| Some((without_unit(text, unit)?, scale));
        let found = ReferenceUnit::ALL
            .into_iter()
            .find_map(|scale| of(scale, scale.unit()))
            .or_else(|| of(ReferenceUnit::Degrees, "°"));
        let (number, scale) = found.ok_or_else(|| {
            format!("{text:?} does not end in mm or deg; write one of them behind the number")
        })?;
        let read = Self::read(number, scale)?;
        match number.strip_suffix(".000").filter(|whole| may_be_thousands(whole)) {
            Some(whole) => Err(format!(
                "{number} can be {whole} or {whole}000: write the one that is meant, with {} behind it",
                scale.unit()
            )),
            None => Ok(read),
        }
    }
}

/// What stands before a unit, in upper or lower case.
fn without_unit<'a>(text: &'a str, unit: &str) -> Option<&'a str> {
    let (number, end) = text.split_at_checked(text.len().checked_sub(unit.len())?)?;
    end.eq_ignore_ascii_case(unit).then(|| number.trim_end())
}

/// One to three digits, the first of them no zero, can stand before a mark between thousands.
fn may_be_thousands(whole: &str) -> bool {
    let digits = whole.strip_prefix(['-', '+']).unwrap_or(whole);
    (1..=3).contains(&digits.len()) && !digits.starts_with('0')
}

/// A mark as it is typed: its name, and what the scale shows there if there is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedMark {
    /// What it is called.
    pub name: String,
    /// What a scale shows there.
    pub reference: Option<Reference>,
}

impl FromStr for NamedMark {
    type Err = String;

    /// `stop left`, or `stop left=0 mm`.
    #[expect(clippy::disallowed_methods, reason = "what a scale of the machine shows, with its unit")]
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, reference) = match text.rsplit_once('=') {
            Some((name, reference)) => (name, Some(reference.parse()?)),
            None => (text, None),
        };
        let name = name.trim();
        if name.is_empty() || name.contains(['\n', '\r']) {
            return Err(format!("{text:?}: a mark has a name on one line, as \"stop left=0 mm\""));
        }
        Ok(Self { name: name.to_owned(), reference })
    }
}

impl fmt::Display for MachineMark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.name)?;
        match self.reference {
            Some(reference) => write!(f, " ({reference})"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_in_upper_and_lower_case_and_thousands_are_refused_with_both_meanings() {
        let read = |text: &str| text.parse::<Reference>();
        for (text, told) in [
            ("5 MM", "5 mm"),
            ("5mm", "5 mm"),
            ("-12.5 Mm", "-12.5 mm"),
            ("90 DEG", "90 deg"),
            ("90°", "90 deg"),
            ("1.250 mm", "1.250 mm"),
            ("1.00 mm", "1.00 mm"),
            ("0.000 mm", "0.000 mm"),
            ("1000.000 mm", "1000.000 mm"),
        ] {
            assert_eq!(read(text).unwrap().to_string(), told, "{text}");
        }
        for (text, told) in [
            ("1.000 mm", "1.000 can be 1 or 1000: write"),
            ("-250.000 deg", "-250.000 can be -250 or -250000: write"),
            ("5 m", "does not end in mm or deg"),
            ("mm", "\"\" is no number like"),
            ("°", "\"\" is no number like"),
        ] {
            let refused = read(text).unwrap_err();
            assert!(refused.contains(told), "{text}: {refused}");
        }
    }
}
