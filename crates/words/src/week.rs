//! When firmware was made: what it can do depends on it [R117].

use core::fmt;
use core::str::FromStr;

/// A calendar week, as firmware is dated [R117].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Week {
    year: u16,
    week: u8,
}

/// A text that is no week of the form `41/1997`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotAWeek;

impl fmt::Display for NotAWeek {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a firmware week is written WW/YYYY, from 1/1990 to 53/2099, like 41/1997")
    }
}

impl core::error::Error for NotAWeek {}

impl Week {
    /// The first firmware with the AK-40 format [R117, R118].
    pub const AK40: Self = Self { year: 1997, week: 41 };

    /// A week of a year.
    ///
    /// # Errors
    /// [`NotAWeek`] outside weeks 1..=53 and years 1990..=2099.
    pub const fn new(week: u8, year: u16) -> Result<Self, NotAWeek> {
        if week == 0 || week > 53 || year < 1990 || year > 2099 {
            Err(NotAWeek)
        } else {
            Ok(Self { year, week })
        }
    }

    /// `true` if firmware of this week sends the AK-40 format with 31 data bits [R117].
    #[must_use]
    pub const fn knows_ak40(self) -> bool {
        self.year > Self::AK40.year || self.year == Self::AK40.year && self.week >= Self::AK40.week
    }
}

impl fmt::Display for Week {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.week, self.year)
    }
}

impl FromStr for Week {
    type Err = NotAWeek;

    fn from_str(text: &str) -> Result<Self, NotAWeek> {
        let (week, year) = text.split_once('/').ok_or(NotAWeek)?;
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if !digits(week) || !digits(year) {
            return Err(NotAWeek);
        }
        Self::new(week.parse().map_err(|_| NotAWeek)?, year.parse().map_err(|_| NotAWeek)?)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn firmware_weeks_have_an_order() {
        assert_eq!("41/1997".parse(), Ok(Week::AK40));
        assert_eq!(Week::AK40.to_string(), "41/1997");
        assert_eq!(
            NotAWeek.to_string(),
            "a firmware week is written WW/YYYY, from 1/1990 to 53/2099, like 41/1997"
        );
        assert!("40/1997".parse::<Week>().unwrap() < Week::AK40);
        assert!("1/1998".parse::<Week>().unwrap() > Week::AK40);
        for wrong in ["", "41", "41/97", "0/1997", "54/1997", "41/2100", "+1/1997", "41/1997/1"] {
            assert_eq!(wrong.parse::<Week>(), Err(NotAWeek), "{wrong}");
        }
    }

    #[test]
    fn the_first_and_the_last_firmware_week_are_those_of_the_message() {
        for (week, year) in [(1, 1990), (53, 1990), (1, 2099), (53, 2099)] {
            assert_eq!(Week::new(week, year), Ok(Week { year, week }));
        }
        for (week, year) in [(0, 1990), (54, 1990), (53, 1989), (0, 2099), (54, 2099), (1, 2100)] {
            assert_eq!(Week::new(week, year), Err(NotAWeek), "{week}/{year}");
        }
    }
}
