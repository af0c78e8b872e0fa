//! The number of turns as services 03 and 09 take it.

use core::fmt;
use core::str::FromStr;

use encoring_words::parameter::{OutOfRange, within};

use super::ratio::{self, DecimalError, Deviation, Ratio};
use super::shaft::Shaft;

/// Revolutions numerator and denominator, each within its range [R57, R58].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fraction {
    numerator: u32,
    denominator: u32,
}

impl Fraction {
    /// The fewest turns that can be programmed.
    #[must_use]
    pub const fn fewest(shaft: Shaft) -> Self {
        Self { numerator: shaft.numerator.0, denominator: shaft.denominator.1 }
    }

    /// The most turns that can be programmed.
    #[must_use]
    pub const fn most(shaft: Shaft) -> Self {
        Self { numerator: shaft.numerator.1, denominator: shaft.denominator.0 }
    }

    /// N/D, not reduced.
    ///
    /// # Errors
    /// [`OutOfRange`] for the numerator, else for the denominator.
    pub const fn new(numerator: u32, denominator: u32, shaft: Shaft) -> Result<Self, OutOfRange> {
        match within(numerator, shaft.numerator.0, shaft.numerator.1) {
            Ok(numerator) => match within(denominator, shaft.denominator.0, shaft.denominator.1) {
                Ok(denominator) => Ok(Self { numerator, denominator }),
                Err(refused) => Err(refused),
            },
            Err(refused) => Err(refused),
        }
    }

    fn checked(numerator: u128, denominator: u128, shaft: Shaft) -> Option<Self> {
        Self::new(u32::try_from(numerator).ok()?, u32::try_from(denominator).ok()?, shaft).ok()
    }

    /// N, the data of service 03.
    #[must_use]
    pub const fn numerator(self) -> u32 {
        self.numerator
    }

    /// D, the data of service 09.
    #[must_use]
    pub const fn denominator(self) -> u32 {
        self.denominator
    }

    /// The number of turns.
    #[must_use]
    pub const fn turns(self) -> Ratio {
        Ratio::of(self.numerator as u128, self.denominator as u128)
    }

    /// The fraction nearest to a number of turns. Among equally near ones that with the smallest denominator, and of
    /// two with the same the larger.
    fn nearest_to(turns: Ratio, shaft: Shaft) -> Self {
        let wanted = (turns.numerator(), turns.denominator());
        let mut best = Fraction::fewest(shaft);
        let mut best_off = None;
        let (least, most) = shaft.numerator;
        for denominator in shaft.denominator.0..=shaft.denominator.1 {
            let scaled = Ratio::of(wanted.0.saturating_mul(u128::from(denominator)), wanted.1);
            let numerator = scaled.nearest().clamp(least.into(), most.into()) as u32;
            let candidate = Self { numerator, denominator };
            // How far off, times the denominator of what is wanted.
            let off =
                (u128::from(numerator) * wanted.1).abs_diff(wanted.0.saturating_mul(u128::from(denominator)));
            let nearer = best_off.is_none_or(|(best_off, best_denominator): (u128, u32)| {
                off.saturating_mul(u128::from(best_denominator))
                    < best_off.saturating_mul(u128::from(denominator))
            });
            if nearer {
                (best, best_off) = (candidate, Some((off, denominator)));
            }
        }
        best
    }

    /// The smallest fraction of at least `turns`, with the smallest denominator it can be written with; `None` above
    /// [`Fraction::most`] [R158].
    #[must_use]
    pub fn at_least(turns: Ratio, shaft: Shaft) -> Option<Self> {
        let mut best: Option<Self> = None;
        for denominator in u128::from(shaft.denominator.0)..=u128::from(shaft.denominator.1) {
            let scaled = Ratio::of(turns.numerator().saturating_mul(denominator), turns.denominator());
            let numerator = scaled.numerator().div_ceil(scaled.denominator()).max(shaft.numerator.0.into());
            let Some(candidate) = Self::checked(numerator, denominator, shaft) else { continue };
            if best.is_none_or(|best| candidate.turns() < best.turns()) {
                best = Some(candidate);
            }
        }
        best
    }
}

impl fmt::Display for Fraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}

/// A number of turns as somebody wrote it, which decides how it is programmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    value: Ratio,
    written: Written,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Written {
    /// With so many decimals, from these digits.
    Decimal { digits: u128, places: u32 },
    /// As a fraction of whole numbers, not reduced.
    Fraction { numerator: u128, denominator: u128 },
    /// As a quotient of decimals.
    Quotient,
}

impl FromStr for Turns {
    type Err = DecimalError;

    /// A decimal like `3.5`, a fraction like `7/2`, or a quotient like `50/3.33`.
    fn from_str(text: &str) -> Result<Self, DecimalError> {
        let Some((above, below)) = text.split_once('/') else {
            let (digits, places) = ratio::positive(text)?;
            return Ok(Self {
                value: Ratio::of(digits, 10_u128.pow(places)),
                written: Written::Decimal { digits, places },
            });
        };
        let part = |text: &str| match ratio::positive(text) {
            Err(DecimalError::NotANumber) => Err(DecimalError::NotAFraction),
            read => read,
        };
        let ((numerator, above_places), (denominator, below_places)) = (part(above)?, part(below)?);
        let over = |digits, places| Ratio::of(digits, 10_u128.pow(places));
        let value = over(numerator, above_places).divided_by(over(denominator, below_places));
        let written =
            if text.contains('.') { Written::Quotient } else { Written::Fraction { numerator, denominator } };
        Ok(Self { value, written })
    }
}

impl From<Fraction> for Turns {
    fn from(fraction: Fraction) -> Self {
        Self {
            value: fraction.turns(),
            written: Written::Fraction {
                numerator: fraction.numerator.into(),
                denominator: fraction.denominator.into(),
            },
        }
    }
}

/// Why a fraction was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// It was given as this fraction.
    AsGiven,
    /// A whole number of turns: the denominator is 1 [R60].
    Whole,
    /// The manual's way: the denominator has the zeros of the decimal place [R61, C28].
    DecimalPlace,
    /// The number itself, in lowest terms because otherwise a part would be too large.
    Reduced,
    /// No fraction that can be programmed is the number; this one is nearest [C28].
    Nearest,
}

/// A fraction for a number of turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chosen {
    /// What to program.
    pub fraction: Fraction,
    /// Why this one.
    pub choice: Choice,
    /// How many turns were asked for.
    pub wanted: Ratio,
    /// How many turns the fraction lies off that; none unless it is the [`Choice::Nearest`].
    pub off: Deviation,
}

impl Chosen {
    /// How far the fraction lies off, in millionths of what was asked for.
    #[must_use]
    pub const fn off_ppm(self) -> Deviation {
        self.off.times(Ratio::whole(1_000_000).divided_by(self.wanted))
    }
}

/// A number of turns that no fraction comes near.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("turns must lie between {fewest} and {}, the nearest is {nearest}", .most.numerator)]
pub struct TurnsOutside {
    /// The fewest turns.
    pub fewest: Fraction,
    /// The most turns.
    pub most: Fraction,
    /// The end of the range that is nearer.
    pub nearest: Fraction,
}

impl Turns {
    /// The number.
    #[must_use]
    pub const fn value(self) -> Ratio {
        self.value
    }

    /// The fraction to program for it: as given if that is legal, a decimal in the manual's way, reduced where that
    /// is needed, and the nearest where none is exact.
    ///
    /// # Errors
    /// [`TurnsOutside`] below [`Fraction::fewest`] and above [`Fraction::most`].
    pub fn choose(self, shaft: Shaft) -> Result<Chosen, TurnsOutside> {
        let turns = self.value;
        let (fewest, most) = (Fraction::fewest(shaft), Fraction::most(shaft));
        for (beyond, nearest) in [(turns < fewest.turns(), fewest), (turns > most.turns(), most)] {
            if beyond {
                return Err(TurnsOutside { fewest, most, nearest });
            }
        }
        let reduced = Fraction::checked(turns.numerator(), turns.denominator(), shaft);
        let exact = match self.written {
            Written::Fraction { numerator, denominator } => {
                Fraction::checked(numerator, denominator, shaft).map(|same| (same, Choice::AsGiven))
            }
            Written::Decimal { .. } | Written::Quotient if turns.is_whole() => {
                reduced.map(|whole| (whole, Choice::Whole))
            }
            Written::Decimal { digits, places } => {
                Fraction::checked(digits, 10_u128.pow(places), shaft).map(|same| (same, Choice::DecimalPlace))
            }
            Written::Quotient => None,
        };
        Ok(match exact.or(reduced.map(|reduced| (reduced, Choice::Reduced))) {
            Some((fraction, choice)) => Chosen { fraction, choice, wanted: turns, off: Deviation::None },
            None => {
                let fraction = Fraction::nearest_to(turns, shaft);
                let off = fraction.turns().deviation_from(turns);
                Chosen { fraction, choice: Choice::Nearest, wanted: turns, off }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use encoring_words::Model;
    use proptest::prelude::*;
    use std::string::{String, ToString};

    fn ce() -> Shaft {
        Shaft::new(Model::Ce100M, 4096).unwrap()
    }

    fn chosen(text: &str) -> (String, Choice) {
        let chosen = text.parse::<Turns>().unwrap().choose(ce()).unwrap();
        (chosen.fraction.to_string(), chosen.choice)
    }

    // [R61]
    #[test]
    fn a_decimal_becomes_tenths_as_the_manual_writes_it() {
        assert_eq!(chosen("3.5"), ("35/10".into(), Choice::DecimalPlace));
        assert_eq!(chosen("3.50"), ("35/10".into(), Choice::DecimalPlace));
        assert_eq!(chosen("0.5"), ("5/10".into(), Choice::DecimalPlace));
    }

    // [R60]
    #[test]
    fn a_whole_number_of_turns_has_the_denominator_1() {
        assert_eq!(chosen("10"), ("10/1".into(), Choice::Whole));
        assert_eq!(chosen("4.0"), ("4/1".into(), Choice::Whole));
        for turns in 1..=65_535 {
            assert_eq!(chosen(&turns.to_string()), (std::format!("{turns}/1"), Choice::Whole));
        }
        assert_eq!(chosen("1000/100"), ("10/1".into(), Choice::Reduced));
    }

    #[test]
    fn a_legal_fraction_stays_as_it_was_given() {
        for text in ["7/2", "35/10", "24/3", "4096/1", "1/99", "65535/99"] {
            assert_eq!(chosen(text), (text.into(), Choice::AsGiven));
        }
    }

    #[test]
    fn a_part_beyond_its_range_is_reduced_or_replaced_by_the_nearest_fraction() {
        assert_eq!(chosen("3.14"), ("157/50".into(), Choice::Reduced));
        assert_eq!(chosen("3.25"), ("13/4".into(), Choice::Reduced));
        assert_eq!(chosen("314/100"), ("157/50".into(), Choice::Reduced));
        assert_eq!(chosen("6553.6"), ("32768/5".into(), Choice::Reduced));
        assert_eq!(chosen("3.1416"), ("311/99".into(), Choice::Nearest));
        assert_eq!(chosen("7000.1"), ("63001/9".into(), Choice::Nearest));
        assert_eq!(chosen("65536/3"), ("43691/2".into(), Choice::Nearest));
        // 5000/333, whose denominator is too large.
        assert_eq!(chosen("50/3.33"), ("1006/67".into(), Choice::Nearest));
        assert_eq!(chosen("3.5/2"), ("7/4".into(), Choice::Reduced));
        assert_eq!(chosen("10/2.5"), ("4/1".into(), Choice::Whole));
        assert_eq!(chosen("3.43535355358774"), ("292/85".into(), Choice::Nearest));
        let turns: Turns = "3.1416".parse().unwrap();
        // 311/99 = 3.14141..: 311 * 10000 = 3110000, 31416 * 99 = 3110184.
        let chosen = turns.choose(ce()).unwrap();
        assert_eq!(chosen.off, Deviation::Below(Ratio::of(184, 990_000)));
        assert_eq!(chosen.off_ppm(), Deviation::Below(Ratio::of(184_000_000, 3_110_184)));
    }

    #[test]
    fn turns_beyond_both_ends_are_refused_with_the_nearest() {
        let refusal = |text: &str| text.parse::<Turns>().unwrap().choose(ce()).unwrap_err().to_string();
        let range = "turns must lie between 1/99 and 65535, the nearest is";
        assert_eq!(refusal("65535.1"), std::format!("{range} 65535/1"));
        assert_eq!(refusal("999999999/1"), std::format!("{range} 65535/1"));
        assert_eq!(refusal("0.01"), std::format!("{range} 1/99"));
        assert_eq!(refusal("1/100"), std::format!("{range} 1/99"));
    }

    #[test]
    fn what_is_no_number_of_turns_is_refused() {
        for (text, error) in [
            ("3,5", DecimalError::Comma),
            ("7/0", DecimalError::NotPositive),
            ("0/7", DecimalError::NotPositive),
            ("-7/2", DecimalError::NotPositive),
            ("7/", DecimalError::NotAFraction),
            ("/", DecimalError::NotAFraction),
            ("7/2/1", DecimalError::NotAFraction),
            ("3.5/2.", DecimalError::NotAFraction),
            ("1.000/2", DecimalError::Thousands { whole: 1 }),
            ("3,5/2", DecimalError::Comma),
            ("7 / 2", DecimalError::NotAFraction),
            ("7000000000/2", DecimalError::TooLong),
        ] {
            assert_eq!(text.parse::<Turns>(), Err(error), "{text}");
        }
    }

    /// The smallest distance that any legal fraction has, as a plain search over all of them.
    fn smallest_distance(turns: Ratio) -> Ratio {
        let mut smallest: Option<Ratio> = None;
        for denominator in 1..=99_u128 {
            let below = turns.numerator() * denominator / turns.denominator();
            for numerator in [below, below + 1] {
                let Some(fraction) = Fraction::checked(numerator, denominator, ce()) else { continue };
                let off = match fraction.turns().deviation_from(turns) {
                    Deviation::None => Ratio::whole(0),
                    Deviation::Below(off) | Deviation::Above(off) => off,
                };
                if smallest.is_none_or(|smallest| off < smallest) {
                    smallest = Some(off);
                }
            }
        }
        smallest.unwrap()
    }

    proptest! {
        #[test]
        fn no_other_legal_fraction_is_nearer(
            whole in prop_oneof![0..70_000_u32, 0..20_u32], decimals in 0..1_000_000_000_000_000_u64, places in 0..=15_usize,
        ) {
            let decimals = &std::format!("{decimals:015}")[..places];
            let Ok(turns) = std::format!("{whole}.{decimals}0").parse::<Turns>() else { return Ok(()) };
            let Ok(chosen) = turns.choose(ce()) else {
                prop_assert!(turns.value() < Ratio::of(1, 99) || turns.value() > Ratio::whole(65535));
                return Ok(());
            };
            let off = match chosen.off {
                Deviation::None => Ratio::whole(0),
                Deviation::Below(off) | Deviation::Above(off) => off,
            };
            prop_assert_eq!(off, smallest_distance(turns.value()));
            prop_assert_eq!(chosen.off, chosen.fraction.turns().deviation_from(turns.value()));
            prop_assert_eq!(chosen.choice == Choice::Nearest, chosen.off != Deviation::None);
        }

        #[test]
        fn a_fraction_is_programmed_exactly_whenever_its_lowest_terms_are_legal(n in 1..200_000_u32, d in 1..1_000_u32) {
            let Ok(chosen) = std::format!("{n}/{d}").parse::<Turns>().unwrap().choose(ce()) else { return Ok(()) };
            let lowest = Ratio::of(n.into(), d.into());
            let legal = lowest.numerator() <= 65535 && lowest.denominator() <= 99;
            prop_assert_eq!(chosen.choice != Choice::Nearest, legal);
            prop_assert_eq!(chosen.fraction.turns() == lowest, legal);
            if n <= 65535 && d <= 99 {
                prop_assert_eq!(chosen.fraction, Fraction::new(n, d, ce()).unwrap());
            }
        }

        #[test]
        fn the_smallest_fraction_above_has_no_smaller_one_above(n in 1..=0x100_0000_u64, q in 1..=8192_u64) {
            let turns = Ratio::new(n, q).unwrap();
            let Some(found) = Fraction::at_least(turns, ce()) else {
                prop_assert!(turns > Ratio::whole(65535));
                return Ok(());
            };
            prop_assert!(found.turns() >= turns);
            for denominator in 1..=99_u128 {
                // The largest fraction with this denominator that is smaller than the one found.
                let scaled = Ratio::of(u128::from(found.numerator()) * denominator, u128::from(found.denominator()));
                let numerator = (scaled.numerator() - 1) / scaled.denominator();
                if let Some(smaller) = Fraction::checked(numerator, denominator, ce()) {
                    prop_assert!(smaller.turns() < turns, "{smaller} is smaller than {found}");
                }
            }
        }

        #[test]
        fn any_text_is_a_number_of_turns_or_an_error(text in "[0-9./,+ -]{0,24}|.*") {
            if let Ok(turns) = text.parse::<Turns>() {
                let _ = turns.choose(ce());
            }
        }
    }
}
