//! Exact numbers that people type, and how they are shown again.

use core::cmp::Ordering;
use core::fmt;
use core::str::FromStr;

/// A number of at least 0 as a fraction in its lowest terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ratio {
    numerator: u128,
    denominator: u128,
}

/// Why a text is no number that can be calculated with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecimalError {
    /// A comma where the decimal point belongs.
    #[error("a decimal comma; decimals stand behind a point")]
    Comma,
    /// Zero, or a sign in front.
    #[error("not above 0")]
    NotPositive,
    /// More digits than are calculated with.
    #[error("more than {WHOLE_DIGITS_MAX} digits before the point or {DECIMALS_MAX} behind it")]
    TooLong,
    /// A point that may be a decimal point or one between thousands, as in `1.000`.
    #[error("{whole}.000 can be {whole} or {whole}000: write the one that is meant")]
    Thousands {
        /// What stands before the point.
        whole: u16,
    },
    /// Anything else.
    #[error("not a number of digits with at most one point, like 12 or 0.01")]
    NotANumber,
    /// A fraction whose parts are not numbers.
    #[error("not a fraction of two numbers, like 7/2 or 50/3.33")]
    NotAFraction,
}

/// The most digits before the point.
const WHOLE_DIGITS_MAX: usize = 9;

/// The most digits behind the point: more than pocket calculators show, and than the makers' examples have.
const DECIMALS_MAX: usize = 15;

/// How a decimal that does not end is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Towards 0.
    Down,
    /// To the nearest, from the middle up.
    Nearest,
    /// Away from 0.
    Up,
}

/// A ratio as a decimal, without trailing zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounded {
    whole: u128,
    decimals: u64,
    places: usize,
    exact: bool,
}

/// How far, and to which side, something lies off what was wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deviation {
    /// Nothing.
    None,
    /// Below what was wanted, by so much.
    Below(Ratio),
    /// Above what was wanted, by so much.
    Above(Ratio),
}

const fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Ratio {
    /// The largest numerator and denominator of what is calculated with: a decimal has at most as many digits, and so
    /// has the quotient of two. Products with the limits of the encoder's values stay below 2^128.
    const LIMIT: u128 = 10_u128.pow((WHOLE_DIGITS_MAX + DECIMALS_MAX) as u32);

    /// The number, if the denominator is not 0.
    #[must_use]
    pub const fn new(numerator: u64, denominator: u64) -> Option<Self> {
        if denominator == 0 { None } else { Some(Self::of(numerator as u128, denominator as u128)) }
    }

    /// In lowest terms; a denominator of 0 is taken as 1, which no caller has.
    pub(super) const fn of(numerator: u128, denominator: u128) -> Self {
        match gcd(numerator, denominator) {
            0 => Self { numerator: 0, denominator: 1 },
            _ if denominator == 0 => Self { numerator, denominator: 1 },
            common => Self { numerator: numerator / common, denominator: denominator / common },
        }
    }

    pub(super) const fn whole(value: u128) -> Self {
        Self { numerator: value, denominator: 1 }
    }

    const fn bounded(self) -> Option<Self> {
        if self.numerator > Self::LIMIT || self.denominator > Self::LIMIT { None } else { Some(self) }
    }

    /// The numerator in lowest terms.
    #[must_use]
    pub const fn numerator(self) -> u128 {
        self.numerator
    }

    /// The denominator in lowest terms, at least 1.
    #[must_use]
    pub const fn denominator(self) -> u128 {
        self.denominator
    }

    /// `true` if nothing is behind the point.
    #[must_use]
    pub const fn is_whole(self) -> bool {
        self.denominator == 1
    }

    /// `true` for 0.
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.numerator == 0
    }

    /// This number divided by another; `None` for a division by 0, or if a part gets more than 24 digits.
    #[must_use]
    pub const fn over(self, divisor: Self) -> Option<Self> {
        if divisor.is_zero() { None } else { self.divided_by(divisor).bounded() }
    }

    /// The sum of this number and another; `None` if a part gets more than 24 digits.
    #[must_use]
    pub const fn plus(self, other: Self) -> Option<Self> {
        let (here, there, denominator) = self.beside(other);
        Self::of(here.saturating_add(there), denominator).bounded()
    }

    /// Both numerators over the denominator that the two numbers have in common.
    const fn beside(self, other: Self) -> (u128, u128, u128) {
        let common = gcd(self.denominator, other.denominator);
        let factor = other.denominator / common;
        (
            self.numerator.saturating_mul(factor),
            other.numerator.saturating_mul(self.denominator / common),
            self.denominator.saturating_mul(factor),
        )
    }

    /// This number multiplied by another; `None` if a part gets more than 24 digits.
    #[must_use]
    pub const fn times(self, factor: Self) -> Option<Self> {
        self.multiplied_by(factor).bounded()
    }

    /// Exact as long as the product stays below 2^128.
    pub(super) const fn multiplied_by(self, factor: Self) -> Self {
        let (across, along) =
            match (gcd(self.numerator, factor.denominator), gcd(factor.numerator, self.denominator)) {
                (0, _) | (_, 0) => return Self::whole(0),
                common => common,
            };
        Self {
            numerator: (self.numerator / across).saturating_mul(factor.numerator / along),
            denominator: (self.denominator / along).saturating_mul(factor.denominator / across),
        }
    }

    /// Exact as long as the quotient stays below 2^128; `divisor` is not 0.
    pub(super) const fn divided_by(self, divisor: Self) -> Self {
        let upside_down = Self::of(divisor.denominator, divisor.numerator);
        self.multiplied_by(upside_down)
    }

    /// Rounded down to a whole number.
    pub(super) const fn floor(self) -> u128 {
        self.numerator / self.denominator
    }

    /// The nearest whole number, from the middle up.
    pub(super) const fn nearest(self) -> u128 {
        let rest = self.numerator % self.denominator;
        self.floor() + (rest >= self.denominator - rest) as u128
    }

    /// How far this number lies off `wanted`.
    #[must_use]
    pub fn deviation_from(self, wanted: Self) -> Deviation {
        let (here, there, denominator) = self.beside(wanted);
        let off = Self::of(here.abs_diff(there), denominator);
        match here.cmp(&there) {
            Ordering::Equal => Deviation::None,
            Ordering::Less => Deviation::Below(off),
            Ordering::Greater => Deviation::Above(off),
        }
    }

    /// The number as a decimal with at most `places` places, 15 or fewer.
    #[must_use]
    pub const fn rounded(self, places: usize, rounding: Rounding) -> Rounded {
        let places = if places > DECIMALS_MAX { DECIMALS_MAX } else { places };
        let (mut whole, mut rest) = (self.floor(), self.numerator % self.denominator);
        let (mut decimals, mut power, mut place) = (0_u64, 1_u64, 0);
        while place < places {
            // Long division: `rest` is below the denominator, which is far below 2^128 / 10.
            rest = rest.saturating_mul(10);
            decimals = decimals * 10 + (rest / self.denominator) as u64;
            rest %= self.denominator;
            power *= 10;
            place += 1;
        }
        let exact = rest == 0;
        let up = match rounding {
            Rounding::Down => false,
            Rounding::Nearest => !exact && rest >= self.denominator - rest,
            Rounding::Up => !exact,
        };
        if up {
            decimals += 1;
            if decimals == power {
                decimals = 0;
                whole += 1;
            }
        }
        Rounded { whole, decimals, places, exact }
    }
}

impl Deviation {
    /// The same deviation in another unit, of which `factor` make one of this.
    #[must_use]
    pub const fn times(self, factor: Ratio) -> Self {
        match self {
            Self::None => Self::None,
            Self::Below(off) => Self::Below(off.multiplied_by(factor)),
            Self::Above(off) => Self::Above(off.multiplied_by(factor)),
        }
    }
}

impl From<u32> for Ratio {
    fn from(value: u32) -> Self {
        Self::whole(u128::from(value))
    }
}

impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ratio {
    /// By whole parts, then by the reciprocals of the rests: nothing is multiplied, so nothing overflows.
    fn cmp(&self, other: &Self) -> Ordering {
        let (mut a, mut b, mut c, mut d) =
            (self.numerator, self.denominator, other.numerator, other.denominator);
        loop {
            let (left, right) = (a / b, c / d);
            if left != right {
                return left.cmp(&right);
            }
            let (left, right) = (a % b, c % d);
            match (left, right) {
                (0, 0) => return Ordering::Equal,
                (0, _) => return Ordering::Less,
                (_, 0) => return Ordering::Greater,
                _ => (a, b, c, d) = (d, right, b, left),
            }
        }
    }
}

impl Rounded {
    /// `true` if nothing was cut off.
    #[must_use]
    pub const fn is_exact(self) -> bool {
        self.exact
    }

    /// `true` if it reads 0.
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.whole == 0 && self.decimals == 0
    }
}

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.whole)?;
        let (mut decimals, mut places) = (self.decimals, self.places);
        while decimals.is_multiple_of(10) && places > 0 {
            (decimals, places) = (decimals / 10, places - 1);
        }
        if places > 0 { write!(f, ".{decimals:0places$}") } else { Ok(()) }
    }
}

/// The digits of a number without its point, and how many stood behind it; zeros at the end of the decimals are left
/// out.
pub(super) fn decimal(text: &str) -> Result<(u128, u32), DecimalError> {
    if text.contains(',') {
        return Err(DecimalError::Comma);
    }
    let (signed, digits) = match text.strip_prefix(['-', '+', '\u{2212}']) {
        Some(digits) => (true, digits),
        None => (false, text),
    };
    let (whole, decimals) = digits.split_once('.').unwrap_or((digits, "0"));
    let good = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    if !good(whole) || !good(decimals) {
        return Err(DecimalError::NotANumber);
    }
    if signed {
        return Err(DecimalError::NotPositive);
    }
    let number =
        |digits: &str| digits.bytes().fold(0, |value: u128, digit| value * 10 + u128::from(digit - b'0'));
    let whole = whole.trim_start_matches('0');
    if decimals == "000" && (1..=3).contains(&whole.len()) {
        return Err(DecimalError::Thousands { whole: number(whole) as u16 });
    }
    let decimals = decimals.trim_end_matches('0');
    if whole.len() > WHOLE_DIGITS_MAX || decimals.len() > DECIMALS_MAX {
        return Err(DecimalError::TooLong);
    }
    let places = decimals.len() as u32;
    Ok((number(whole) * 10_u128.pow(places) + number(decimals), places))
}

/// The same, above 0.
pub(super) fn positive(text: &str) -> Result<(u128, u32), DecimalError> {
    match decimal(text)? {
        (0, _) => Err(DecimalError::NotPositive),
        number => Ok(number),
    }
}

impl Ratio {
    /// A decimal of at least 0, as [`FromStr`] reads one above it.
    ///
    /// # Errors
    /// [`DecimalError`]: why the text is none.
    pub fn from_zero(text: &str) -> Result<Self, DecimalError> {
        let (digits, places) = decimal(text)?;
        Ok(Self::of(digits, 10_u128.pow(places)))
    }
}

impl FromStr for Ratio {
    type Err = DecimalError;

    /// A decimal above 0, with at most 9 digits before the point and 15 behind it.
    fn from_str(text: &str) -> Result<Self, DecimalError> {
        let (digits, places) = positive(text)?;
        Ok(Self::of(digits, 10_u128.pow(places)))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::string::{String, ToString};

    fn ratio(text: &str) -> Ratio {
        text.parse().unwrap()
    }

    #[test]
    fn a_decimal_is_read_exactly_or_refused() {
        for (text, numerator, denominator) in [
            ("500", 500, 1),
            ("0.01", 1, 100),
            ("3.50", 7, 2),
            ("007", 7, 1),
            ("000000000000.5", 1, 2),
            ("1.0000000000000", 1, 1),
            ("999999999.999999999", 999_999_999_999_999_999, 1_000_000_000),
            ("3.43535355358774", 343_535_355_358_774, 100_000_000_000_000),
            ("1.0000", 1, 1),
            ("1.0", 1, 1),
            ("1000.000", 1_000, 1),
            ("1.500", 3, 2),
        ] {
            assert_eq!(ratio(text), Ratio::new(numerator, denominator).unwrap(), "{text}");
        }
        for (text, error) in [
            ("3,5", DecimalError::Comma),
            ("3, 5", DecimalError::Comma),
            ("0", DecimalError::NotPositive),
            ("0.00", DecimalError::NotPositive),
            ("-1", DecimalError::NotPositive),
            ("+1", DecimalError::NotPositive),
            ("\u{2212}1", DecimalError::NotPositive),
            ("1000000000", DecimalError::TooLong),
            ("0.0000000000000001", DecimalError::TooLong),
            ("1.000", DecimalError::Thousands { whole: 1 }),
            ("999.000", DecimalError::Thousands { whole: 999 }),
            ("0.000", DecimalError::NotPositive),
            ("", DecimalError::NotANumber),
            ("-", DecimalError::NotANumber),
            (".", DecimalError::NotANumber),
            ("5.", DecimalError::NotANumber),
            (".5", DecimalError::NotANumber),
            ("1.2.3", DecimalError::NotANumber),
            ("1e3", DecimalError::NotANumber),
            ("NaN", DecimalError::NotANumber),
            ("1 000", DecimalError::NotANumber),
            ("5mm", DecimalError::NotANumber),
            ("\u{0665}", DecimalError::NotANumber),
        ] {
            assert_eq!(text.parse::<Ratio>(), Err(error), "{text}");
        }
    }

    #[test]
    fn decimals_are_cut_to_the_side_that_was_asked_for() {
        let third = |rounding| Ratio::of(2, 3).rounded(4, rounding).to_string();
        assert_eq!(third(Rounding::Down), "0.6666");
        assert_eq!(third(Rounding::Nearest), "0.6667");
        assert_eq!(third(Rounding::Up), "0.6667");
        assert_eq!(Ratio::of(1, 3).rounded(4, Rounding::Up).to_string(), "0.3334");
        assert_eq!(Ratio::of(99_999, 10_000).rounded(3, Rounding::Nearest).to_string(), "10");
        assert_eq!(Ratio::of(1, 400).rounded(2, Rounding::Down).to_string(), "0");
        assert_eq!(ratio("0.050").rounded(9, Rounding::Up).to_string(), "0.05");
        assert!(ratio("0.05").rounded(2, Rounding::Up).is_exact());
        assert!(!ratio("0.05").rounded(1, Rounding::Nearest).is_exact());
    }

    #[test]
    fn nothing_divides_by_zero() {
        assert_eq!(Ratio::new(1, 0), None);
        assert_eq!(Ratio::new(0, 7), Some(Ratio::whole(0)));
        assert_eq!(ratio("1").over(Ratio::whole(0)), None);
        assert_eq!(Ratio::new(u64::MAX, u64::MAX), Some(Ratio::whole(1)));
        assert_eq!(ratio("999999999").times(ratio("99999999.5")).map(Ratio::is_whole), Some(false));
        let largest = Ratio::whole(Ratio::LIMIT);
        assert_eq!((largest.times(ratio("2")), largest.plus(ratio("1"))), (None, None));
        assert_eq!(Ratio::from_zero("0.00"), Ok(Ratio::whole(0)));
        assert_eq!(Ratio::from_zero("-1"), Err(DecimalError::NotPositive));
    }

    #[test]
    fn a_point_that_may_stand_between_thousands_is_refused_with_both_meanings() {
        let refusal = "1.000".parse::<Ratio>().unwrap_err().to_string();
        assert_eq!(refusal, "1.000 can be 1 or 1000: write the one that is meant");
    }

    proptest! {
        #[test]
        fn a_decimal_shows_as_it_was_typed(whole in 0_u32..1_000_000_000, decimals in 1_u32..1_000_000_000) {
            let typed = std::format!("{whole}.{decimals:09}");
            let shown = ratio(&typed).rounded(9, Rounding::Nearest);
            prop_assert!(shown.is_exact());
            prop_assert_eq!(shown.to_string(), typed.trim_end_matches('0'));
        }

        #[test]
        fn two_decimals_can_be_divided_and_added(
            a in 1..1_000_000_000_000_000_000_000_000_u128, p in 0..=15_u32, b in 1..1_000_000_000_000_000_000_000_000_u128, q in 0..=15_u32,
        ) {
            // At most nine digits before the point.
            let of = |digits: u128, places: u32| Ratio::of((digits % 10_u128.pow(9 + places)).max(1), 10_u128.pow(places));
            let (left, right) = (of(a, p), of(b, q));
            let quotient = left.over(right).unwrap();
            prop_assert_eq!(quotient.times(right), Some(left));
            if let Some(sum) = left.plus(right) {
                prop_assert_eq!(sum.deviation_from(left), Deviation::Above(right));
            }
        }

        #[test]
        fn the_order_is_that_of_the_products(a: u64, b in 1..=u64::MAX, c: u64, d in 1..=u64::MAX) {
            let left = Ratio::of(a.into(), b.into());
            let right = Ratio::of(c.into(), d.into());
            let products = (u128::from(a) * u128::from(d)).cmp(&(u128::from(c) * u128::from(b)));
            prop_assert_eq!(left.cmp(&right), products);
        }

        #[test]
        fn any_text_is_a_number_or_an_error(text: String) {
            let _ = text.parse::<Ratio>();
        }

        #[test]
        fn a_quotient_times_its_divisor_is_the_dividend(
            a in 1..1_000_000_000_u64, b in 1..1_000_000_000_u64, c in 1..1_000_000_000_u64, d in 1..1_000_000_000_u64,
        ) {
            let (left, right) = (Ratio::new(a, b).unwrap(), Ratio::new(c, d).unwrap());
            let quotient = left.over(right).unwrap();
            prop_assert_eq!(quotient.times(right), Some(left));
        }
    }
}
