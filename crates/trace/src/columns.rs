//! The columns: their names, what their cells may hold, and how a row is read from and written to them.

use std::fmt;
use std::io::{self, Write};

use encoring_words::number::{self, Bare};

use crate::decimal::Decimal;
use crate::error::Problem;

/// One row: an exchange with one encoder, and its surroundings since that encoder's previous one.
///
/// The default is what stands for missing columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// The line of the file, from 1. Not written.
    pub line: u64,
    /// What happened.
    pub kind: RowKind,
    /// The encoder's ring position; none without the column.
    pub position: Option<u8>,
    /// Nanoseconds since the start.
    pub time_ns: u64,
    /// The OUT word; none if the row does not say: it stands as it did before.
    pub out: Option<u32>,
    /// The shaft in sensor steps, or the magnet in micrometres.
    pub raw: i64,
    /// Both preset inputs in millivolts.
    pub preset_mv: [u32; 2],
    /// The supply in millivolts.
    pub supply_mv: u32,
    /// Whether the magnet is on the rod.
    pub magnet: bool,
    /// The IN word; none if the row does not say.
    pub input: Option<Input>,
    /// A position as a number, which is no word.
    pub value: Option<i64>,
    /// What was seen of the line in this cycle.
    pub cycle: Option<CycleSeen>,
    /// The master's diagnostic status register.
    pub status: Option<u16>,
    /// The master's diagnostic parameter register.
    pub parameter: Option<u16>,
}

impl Default for Row {
    fn default() -> Self {
        Self {
            line: 0,
            kind: RowKind::Exchange,
            position: None,
            time_ns: 0,
            out: None,
            raw: 0,
            preset_mv: [0, 0],
            supply_mv: 24_000,
            magnet: true,
            input: None,
            value: None,
            cycle: None,
            status: None,
            parameter: None,
        }
    }
}

/// What a row tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowKind {
    /// An exchange.
    #[default]
    Exchange,
    /// An edge of the SSI clock that switched the encoder on, in a recording: it stands in a comment,
    /// `# ssi TIME,POSITION,RAW,SUPPLY`, which readers that know nothing of it pass over.
    SsiEdge,
}

/// What comes back from the encoder. Displayed as in a cell: 8 hex digits or `off`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// The IN word.
    Word(u32),
    /// The supply is too low: nothing comes back.
    Off,
}

impl Input {
    /// The IN word; `None` if nothing came back.
    #[must_use]
    pub const fn word(self) -> Option<u32> {
        match self {
            Self::Word(word) => Some(word),
            Self::Off => None,
        }
    }
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(word) => write!(f, "{word:08X}"),
            Self::Off => f.write_str("off"),
        }
    }
}

/// What was seen of the line in a cycle, as the column `line` says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleSeen {
    /// The data came whole.
    Good,
    /// Data came and was wrong.
    Bad,
    /// Nothing came.
    Silent,
}

impl CycleSeen {
    /// Its name in a cell.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Silent => "silent",
        }
    }

    fn named(cell: &[u8]) -> Option<Self> {
        let all = [Self::Good, Self::Bad, Self::Silent];
        all.into_iter().find(|cycle| cell.eq_ignore_ascii_case(cycle.name().as_bytes()))
    }
}

/// How far rows are apart without times.
pub(crate) const ROW_NS: u64 = 1_000_000;

const MOST_RAW: i64 = 1 << 62;
const MOST_MILLIVOLTS: u32 = 1_000_000;
const MOST_POSITION: u8 = 127;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    Time,
    Position,
    Out,
    Raw,
    Preset1,
    Preset2,
    Supply,
    Magnet,
    In,
    Verdict,
    Value,
    Line,
    Status,
    Parameter,
}

use Column::{
    In, Line, Magnet, Out, Parameter, Position, Preset1, Preset2, Raw, Status, Supply, Time, Value, Verdict,
};

impl Column {
    /// The order in which a recording is written.
    pub(crate) const RECORDING: [Self; 9] = [Time, Position, Out, Raw, Preset1, Preset2, Supply, Magnet, In];
    /// What is written of an edge of the SSI clock.
    pub(crate) const SSI_EDGE: [Self; 4] = [Time, Position, Raw, Supply];
    /// The order in which a trace of one encoder is written.
    pub(crate) const TRACE: [Self; 8] = [Time, Out, Raw, Preset1, Preset2, Supply, Magnet, In];

    /// Every column that is read, first those of a recording.
    pub(crate) const ALL: [Self; 14] = [
        Time, Position, Out, Raw, Preset1, Preset2, Supply, Magnet, In, Verdict, Value, Line, Status,
        Parameter,
    ];

    /// What is wrong with a file that ends before its header.
    pub(crate) fn no_header() -> Problem {
        Problem::NoHeader { columns: Self::ALL.map(Self::name).join(", ") }
    }

    pub(crate) fn named(name: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name().as_bytes() == name)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Time => "time_us",
            Position => "position",
            Out => "out",
            Raw => "raw",
            Preset1 => "preset1_v",
            Preset2 => "preset2_v",
            Supply => "supply_v",
            Magnet => "magnet",
            In => "in",
            Verdict => "verdict",
            Value => "value",
            Line => "line",
            Status => "status",
            Parameter => "parameter",
        }
    }

    /// What a cell may hold, to follow "is not".
    pub(crate) fn allowed(self) -> &'static str {
        match self {
            Time => "a time from 0 to 18446744073709551.615 with at most three decimals",
            Position => "a whole number from 0 to 127",
            Out => "a word, such as C200270F, or empty",
            Raw => "a whole number from -4611686018427387904 to 4611686018427387904",
            Preset1 | Preset2 | Supply => "a voltage from 0 to 1000 with at most three decimals",
            Magnet => "0 or 1",
            In => "a word, such as C200270F, off or empty",
            Verdict => "text",
            Value => "a whole number or empty",
            Line => "good, bad, silent or empty",
            Status | Parameter => "a number from 0 to 65535 or FFFFh, or empty",
        }
    }

    /// Why a cell cannot be [read](Self::read).
    pub(crate) fn problem(self, cell: &[u8], style: Style) -> Problem {
        let word = self.is_word().then(|| str::from_utf8(cell).ok()).flatten();
        match word.and_then(|text| number::word([text], style.bare).err()) {
            Some(error) => Problem::Table(error.to_string()),
            None => Problem::value(cell, self.allowed()),
        }
    }

    pub(crate) fn is_word(self) -> bool {
        matches!(self, Out | In)
    }

    /// Whether decimals may stand in a cell.
    pub(crate) fn is_decimal(self) -> bool {
        matches!(self, Time | Preset1 | Preset2 | Supply)
    }

    /// Puts the cell into the row; none if the cell is not [allowed](Self::allowed).
    pub(crate) fn read(self, cell: &[u8], row: &mut Row, style: Style) -> Option<()> {
        match self {
            Time => row.time_ns = thousandths(cell)?,
            Position => row.position = Some(position(cell)?),
            Out if cell.is_empty() => row.out = None,
            Out => row.out = Some(word(cell, style)?),
            Raw => row.raw = whole(cell)?,
            Preset1 => row.preset_mv = [millivolts(cell)?, row.preset_mv[1]],
            Preset2 => row.preset_mv = [row.preset_mv[0], millivolts(cell)?],
            Supply => row.supply_mv = millivolts(cell)?,
            Magnet => {
                row.magnet = match cell {
                    b"0" => false,
                    b"1" => true,
                    _ => return None,
                }
            }
            In => {
                row.input = match cell {
                    b"" => None,
                    _ if cell.eq_ignore_ascii_case(b"off") => Some(Input::Off),
                    _ => Some(Input::Word(word(cell, style)?)),
                }
            }
            Verdict => {}
            Value | Line | Status | Parameter if cell.is_empty() => {}
            Value => row.value = Some(whole(cell)?),
            Line => row.cycle = Some(CycleSeen::named(cell)?),
            Status => row.status = Some(register(cell)?),
            Parameter => row.parameter = Some(register(cell)?),
        }
        Some(())
    }

    /// Appends the row's cell, or refuses the row if [`read`](Self::read) would refuse the cell.
    pub(crate) fn write(self, row: &Row, line: &mut Vec<u8>) -> io::Result<()> {
        match self {
            Time => write!(line, "{}", Decimal::microseconds(row.time_ns)),
            Position => match row.position {
                Some(position @ 0..=MOST_POSITION) => write!(line, "{position}"),
                Some(position) => Err(self.refusal(position)),
                None => Err(self.refusal("nothing")),
            },
            Out => row.out.map_or(Ok(()), |out| write!(line, "{out:08X}")),
            Raw if !(-MOST_RAW..=MOST_RAW).contains(&row.raw) => Err(self.refusal(row.raw)),
            Raw => write!(line, "{}", row.raw),
            Preset1 => self.write_volts(row.preset_mv[0], line),
            Preset2 => self.write_volts(row.preset_mv[1], line),
            Supply => self.write_volts(row.supply_mv, line),
            Magnet => write!(line, "{}", u8::from(row.magnet)),
            In => row.input.map_or(Ok(()), |input| write!(line, "{input}")),
            Verdict | Value | Line | Status | Parameter => Ok(()),
        }
    }

    fn write_volts(self, millivolts: u32, line: &mut Vec<u8>) -> io::Result<()> {
        let volts = Decimal::volts(millivolts);
        if millivolts > MOST_MILLIVOLTS { Err(self.refusal(volts)) } else { write!(line, "{volts}") }
    }

    fn refusal(self, value: impl fmt::Display) -> io::Error {
        let message = format!("column {}: {value} is not {}", self.name(), self.allowed());
        io::Error::new(io::ErrorKind::InvalidInput, message)
    }
}

/// How the words of a file are written.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Style {
    /// What a word without sign and base mark is.
    pub(crate) bare: Bare,
}

/// Whether words without letters may be decimal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Doubt {
    /// No word was seen that is not 0.
    Nothing,
    /// All words so far could be decimal.
    AllDigits,
    /// One could not.
    Settled,
}

impl Doubt {
    /// After one more word as it is written.
    pub(crate) fn after(self, cell: &[u8]) -> Self {
        match cell {
            _ if self == Self::Settled => self,
            [] => self,
            [b'0', rest @ ..] if rest.iter().all(|digit| *digit == b'0') => self,
            [b'1'..=b'9', rest @ ..] if rest.iter().all(u8::is_ascii_digit) => Self::AllDigits,
            _ => Self::Settled,
        }
    }
}

pub(crate) fn position(cell: &[u8]) -> Option<u8> {
    u8::try_from(natural(cell)?).ok().filter(|&position| position <= MOST_POSITION)
}

fn millivolts(cell: &[u8]) -> Option<u32> {
    // As we write nearly all: `0.0`, `24.0`.
    let (tens, ones, tenths) = match *cell {
        [ones, b'.', tenths] => (b'0', ones, tenths),
        [tens, ones, b'.', tenths] => (tens, ones, tenths),
        _ => return other_millivolts(cell),
    };
    let [tens, ones, tenths] = [tens, ones, tenths].map(|byte| byte.wrapping_sub(b'0'));
    let written = 10_000 * u32::from(tens) + 1_000 * u32::from(ones) + 100 * u32::from(tenths);
    (tens.max(ones).max(tenths) <= 9).then_some(written)
}

#[inline(never)]
fn other_millivolts(cell: &[u8]) -> Option<u32> {
    u32::try_from(thousandths(cell)?).ok().filter(|&millivolts| millivolts <= MOST_MILLIVOLTS)
}

/// A word: at once in the two forms in which we write it, and else in any that there is.
#[inline]
fn word(cell: &[u8], style: Style) -> Option<u32> {
    let ours = match cell.strip_prefix(b"0x") {
        Some(digits) => digits.try_into().ok(),
        None if style.bare == Bare::Decimal => None,
        None => cell.try_into().ok(),
    };
    ours.and_then(number::eight_digits)
        .or_else(|| Some(number::word([str::from_utf8(cell).ok()?], style.bare).ok()?.bits))
}

fn register(cell: &[u8]) -> Option<u16> {
    u16::try_from(number::value(str::from_utf8(cell).ok()?).ok()?.number).ok()
}

fn whole(cell: &[u8]) -> Option<i64> {
    let digits = cell.strip_prefix(b"-");
    let magnitude = i64::try_from(natural(digits.unwrap_or(cell))?).ok().filter(|&n| n <= MOST_RAW)?;
    Some(if digits.is_some() { -magnitude } else { magnitude })
}

/// A decimal in thousandths: digits around a point, or without one. Digits after the third must be zero,
/// since nothing is rounded.
#[inline]
fn thousandths(cell: &[u8]) -> Option<u64> {
    let (ones, rest) = digits(cell)?;
    let mut sum = ones.checked_mul(1000)?;
    match rest {
        [] => Some(sum),
        [b'.', decimals @ ..] if !decimals.is_empty() => {
            let (written, beyond) = decimals.split_at_checked(3).unwrap_or((decimals, &[]));
            for (&byte, worth) in written.iter().zip([100, 10, 1]) {
                sum = sum.checked_add(digit(byte)? * worth)?;
            }
            beyond.iter().all(|byte| *byte == b'0').then_some(sum)
        }
        _ => None,
    }
}

fn natural(cell: &[u8]) -> Option<u64> {
    digits(cell).filter(|(_, rest)| rest.is_empty()).map(|(number, _)| number)
}

/// The number at the start of a cell, of one digit or more, and what follows it.
#[inline]
fn digits(cell: &[u8]) -> Option<(u64, &[u8])> {
    let (mut number, mut count) = (0_u64, 0);
    for &byte in cell {
        let Some(digit) = digit(byte) else { break };
        // So few cannot overflow.
        number = if count < 19 { number * 10 + digit } else { number.checked_mul(10)?.checked_add(digit)? };
        count += 1;
    }
    cell.get(count..).filter(|_| count > 0).map(|rest| (number, rest))
}

fn digit(byte: u8) -> Option<u64> {
    byte.is_ascii_digit().then(|| u64::from(byte - b'0'))
}
