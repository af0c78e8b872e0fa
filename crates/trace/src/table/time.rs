//! Times as tables have them: numbers in a unit, dates, times of day.

use std::str::FromStr;

use jiff::civil::{self, DateTime};
use jiff::fmt::strtime::BrokenDownTime;
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp};

/// Numbers from here on are counted from 1970, in seconds: 2000-01-01.
const DATES_FROM_S: i128 = 946_684_800;
const DAY_NS: i128 = 24 * 3_600 * NS_PER_S;
const NS_PER_S: i128 = 1_000_000_000;
/// More digits are no time.
const DIGITS_MAX: usize = 30;

/// How the times of a column are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// A number of this unit.
    Unit(Unit),
    /// A date and a time with its offset from UTC.
    Zoned,
    /// A date and a time of the clock on the wall.
    Wall,
    /// The same with the day first.
    DayFirst,
    /// A time of day.
    OfDay,
    /// A span of time with its units, or with days.
    Span,
}

/// A unit of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    S,
    Ms,
    Us,
    Ns,
}

impl Unit {
    pub(super) fn named(name: &str) -> Option<Self> {
        match name.to_lowercase().as_str() {
            "s" | "sec" | "seconds" => Some(Self::S),
            "ms" | "msec" | "milliseconds" => Some(Self::Ms),
            // Micro sign, and the Greek letter, which looks the same.
            "us" | "\u{B5}s" | "\u{3BC}s" | "usec" | "microseconds" => Some(Self::Us),
            "ns" | "nsec" | "nanoseconds" => Some(Self::Ns),
            _ => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::S => "s",
            Self::Ms => "ms",
            Self::Us => "us",
            Self::Ns => "ns",
        }
    }

    const fn ns(self) -> u64 {
        10_u64.pow(self.power().unsigned_abs())
    }

    /// The power of ten of its nanoseconds.
    const fn power(self) -> i32 {
        match self {
            Self::S => 9,
            Self::Ms => 6,
            Self::Us => 3,
            Self::Ns => 0,
        }
    }
}

impl Scale {
    /// The scale of a time without a unit: a date or a time of day.
    pub(crate) fn of(cell: &str) -> Option<Self> {
        // A date alone, or what has a time of day or a mark.
        if !cell.contains([':', '#']) && ['-', '/'].iter().all(|mark| cell.matches(*mark).count() < 2) {
            return None;
        }
        let dates = [Self::Zoned, Self::Wall, Self::DayFirst, Self::OfDay, Self::Span];
        dates.into_iter().find(|scale| scale.ns(cell, Commas::Decimal).is_some())
    }

    /// Nanoseconds, from wherever this scale counts; `None` for what is no such time.
    pub(crate) fn ns(self, cell: &str, commas: Commas) -> Option<i128> {
        match self {
            Self::Unit(unit) => decimal(cell, commas, unit.power())
                .or_else(|| decimal(&ungrouped(cell)?, commas, unit.power())),
            Self::Zoned => either(cell, |text| Timestamp::from_str(text).ok()).map(Timestamp::as_nanosecond),
            Self::Wall => wall(either(cell, |text| DateTime::from_str(text).ok())?),
            Self::DayFirst => wall(either(cell, day_first)?),
            Self::OfDay => {
                let time = either(cell, |text| civil::Time::from_str(text).ok())?;
                // A date alone reads as midnight, and a number as an hour.
                cell.contains(':').then_some(())?;
                Some(time.duration_since(civil::Time::MIN).as_nanos())
            }
            Self::Span => span(cell),
        }
    }

    /// Nanoseconds of a whole number of a few digits, as most tables have them.
    pub(super) fn natural(self, cell: &[u8]) -> Option<u64> {
        let Self::Unit(unit) = self else { return None };
        // So few that nothing can overflow.
        if !matches!(cell.len(), 1..=9) {
            return None;
        }
        let (number, is_number) = cell.iter().fold((0, true), |(number, is_number), byte| {
            let digit = byte.wrapping_sub(b'0');
            (number * 10 + u64::from(digit), is_number & (digit < 10))
        });
        is_number.then(|| number * unit.ns())
    }

    /// What a time of this scale is, to follow "is not".
    pub(super) fn allowed(self) -> String {
        match self {
            Self::Unit(unit) => format!("a time in {}", unit.name()),
            Self::Zoned => "a date and time with its zone, as 2026-11-27T10:00:00.001Z".to_owned(),
            Self::Wall => "a date and time, as 2026-11-27 10:00:00.001".to_owned(),
            Self::DayFirst => "a date and time, as 27.11.2026 10:00:00.001".to_owned(),
            Self::OfDay => "a time of day, as 10:00:00.001".to_owned(),
            Self::Span => "a span of time, as T#1s200ms".to_owned(),
        }
    }

    /// From where the times of a table count whose first one is this.
    pub(super) fn start(self, first_ns: i128) -> i128 {
        match self {
            Self::Unit(_) | Self::Span if (0..DATES_FROM_S * NS_PER_S).contains(&first_ns) => 0,
            _ => first_ns,
        }
    }

    /// How much later a time is that reads earlier: of a time of day, midnight has passed.
    pub(super) fn wrapped(self, ns: i128, previous_ns: i128) -> i128 {
        if self == Self::OfDay && previous_ns - ns > DAY_NS / 2 { DAY_NS } else { 0 }
    }
}

/// What a comma in a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Commas {
    /// It stands where others have a point.
    Decimal,
    /// It separates cells, so it is in no number.
    Separate,
}

/// IEC 61131-3 and STEP 7 write `DT#2026-11-27-10:00:00.001` and `TOD#10:00:00.001`.
fn unmarked(cell: &str) -> std::borrow::Cow<'_, str> {
    let Some((mark, rest)) = cell.split_once('#') else { return cell.into() };
    match mark.to_ascii_uppercase().as_str() {
        "TOD" | "LTOD" | "TIME_OF_DAY" => rest.into(),
        "DT" | "LDT" | "DTL" | "DATE_AND_TIME" => match rest.rsplit_once('-') {
            Some((date, time)) => format!("{date}T{time}").into(),
            None => rest.into(),
        },
        _ => cell.into(),
    }
}

/// Reads a date or a time as it stands, and otherwise as ISO 8601 has it.
fn either<T>(cell: &str, read: impl Fn(&str) -> Option<T>) -> Option<T> {
    let text = unmarked(cell);
    read(&text).or_else(|| read(&tidied(&text)))
}

/// A date and a time with two digits of the hour, dashes in a date that begins with the year, a point before the
/// milliseconds, and the zone close behind: `2026/11/27 9:00:00:001 +01:00`.
fn tidied(cell: &str) -> String {
    let zoned = cell.rsplit_once(' ').and_then(|(time, zone)| match zone {
        "UTC" | "Z" => Some((time, "Z")),
        _ => zone.starts_with(['+', '-']).then_some((time, zone)),
    });
    let (text, zone) = zoned.unwrap_or((cell, ""));
    let (date, time) = match text.split_once([' ', 'T']) {
        Some((date, time)) => (date, time),
        None => ("", text),
    };
    let date = if date.find('/') == Some(4) { date.replace('/', "-") } else { date.to_owned() };
    let hour = if time.find(':') == Some(1) { "0" } else { "" };
    let time = match time.rsplit_once(':') {
        Some((seconds, milliseconds)) if time.matches(':').count() == 3 => {
            format!("{seconds}.{milliseconds}")
        }
        _ => time.to_owned(),
    };
    let between = if date.is_empty() { "" } else { " " };
    format!("{date}{between}{hour}{time}{zone}")
}

/// `T#1s200ms` of IEC 61131-3, and `0 days 00:00:01.200` of pandas.
fn span(cell: &str) -> Option<i128> {
    if let Some((days, time)) = cell.split_once(" days ") {
        let time = Scale::OfDay.ns(time.strip_prefix('+').unwrap_or(time), Commas::Separate)?;
        return decimal(days, Commas::Separate, 0)?.checked_mul(DAY_NS)?.checked_add(time);
    }
    let (mark, rest) = cell.split_once('#')?;
    let is_span = ["T", "TIME", "LT", "LTIME"].iter().any(|known| mark.eq_ignore_ascii_case(known));
    let text = rest.replace('_', "").to_ascii_lowercase();
    SignedDuration::from_str(&text).ok().filter(|_| is_span).map(|span| span.as_nanos())
}

/// A number without the marks between its thousands that are nothing else: apostrophes and narrow spaces.
fn ungrouped(cell: &str) -> Option<String> {
    let is_mark = |letter| matches!(letter, '\'' | '\u{2019}' | '\u{A0}' | '\u{202F}' | '\u{2009}');
    let whole = cell.find(['.', ',']).unwrap_or(cell.len());
    let (whole, decimals) = cell.split_at_checked(whole)?;
    let groups: Vec<_> = whole.split(is_mark).collect();
    let (_, behind) = groups.split_first().filter(|(_, behind)| !behind.is_empty())?;
    behind.iter().all(|group| group.len() == 3).then(|| format!("{}{decimals}", groups.concat()))
}

/// What the marks in the numbers of a column are, where a comma separates no cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Marks {
    /// A number had decimals, so a mark in another is that of decimals.
    has_decimals: bool,
}

impl Marks {
    /// Whether one more number is one of thousands or one with decimals, as `1.000` and `12,500` are behind others without
    /// a mark.
    pub(super) fn in_doubt(&mut self, cell: &str, has_others: bool) -> bool {
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let Some((before, behind)) = cell.split_once(['.', ',']) else { return false };
        let may_be_thousands = matches!(before.len(), 1..=3)
            && !before.starts_with('0')
            && behind.len() == 3
            && digits(before)
            && digits(behind);
        let in_doubt = has_others && !self.has_decimals && may_be_thousands;
        self.has_decimals |= !in_doubt;
        in_doubt
    }
}

fn wall(time: DateTime) -> Option<i128> {
    // Without a zone a clock is taken to go on evenly.
    TimeZone::UTC.to_timestamp(time).ok().map(Timestamp::as_nanosecond)
}

fn day_first(cell: &str) -> Option<DateTime> {
    let cell = cell.replace(',', ".");
    let forms = ["%d.%m.%Y %H:%M:%S%.f", "%d.%m.%y %H:%M:%S%.f", "%d.%m.%YT%H:%M:%S%.f", "%d.%m.%Y %H:%M"];
    forms.into_iter().find_map(|form| BrokenDownTime::parse(form, &cell).ok()?.to_datetime().ok())
}

/// A decimal number times a power of ten, rounded to a whole one: programs that count in binary fractions write
/// 0.001 as 0.0010000000000000002.
pub(super) fn decimal(cell: &str, commas: Commas, power: i32) -> Option<i128> {
    let (sign, text) = match cell.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, cell.strip_prefix('+').unwrap_or(cell)),
    };
    let mut mantissa = 0_i128;
    let (mut digits, mut decimals, mut point) = (0, 0, false);
    let mut rest = text.as_bytes();
    let mut exponent = 0;
    while let [byte, behind @ ..] = rest {
        rest = behind;
        match byte {
            b'0'..=b'9' => {
                digits += 1;
                decimals += i32::from(point);
                mantissa = mantissa * 10 + i128::from(byte - b'0');
                if digits > DIGITS_MAX {
                    return None;
                }
            }
            b'.' if !point => point = true,
            b',' if !point && commas == Commas::Decimal => point = true,
            b'e' | b'E' if digits > 0 => {
                exponent = small(rest)?;
                break;
            }
            _ => return None,
        }
    }
    let power = power + exponent - decimals;
    let scaled = match 10_i128.checked_pow(power.unsigned_abs()) {
        Some(factor) if power >= 0 => mantissa.checked_mul(factor)?,
        Some(factor) => (mantissa + factor / 2) / factor,
        None if power < 0 || mantissa == 0 => 0,
        None => return None,
    };
    (digits > 0).then_some(sign * scaled)
}

/// A whole number of at most three digits.
fn small(text: &[u8]) -> Option<i32> {
    let (sign, digits) = match text {
        [b'-', rest @ ..] => (-1, rest),
        [b'+', rest @ ..] | rest => (1, rest),
    };
    if !(1..=3).contains(&digits.len()) {
        return None;
    }
    let number = digits
        .iter()
        .try_fold(0, |number, byte| byte.is_ascii_digit().then(|| number * 10 + i32::from(byte - b'0')))?;
    Some(sign * number)
}
