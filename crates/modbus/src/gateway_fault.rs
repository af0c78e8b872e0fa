//! How the server misbehaves as gateways of the field do, so that masters can be tried against it.
//!
//! As a text: `KIND[=VALUE][#N][@TIME][+TIME]`, at request N (each), from TIME after the start (0) for TIME (for good).
//! [`FORMS`] lists the kinds.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

/// Every kind with what it does.
pub const FORMS: [(&str, &str); 12] = [
    ("silent", "no request is answered or carried out"),
    ("late=MS", "every answer comes MS milliseconds late"),
    ("busy", "exception 06, and nothing is carried out"),
    ("exception=NN", "exception NN (hexadecimal), and nothing is carried out"),
    ("drop", "requests are carried out and not answered"),
    ("dead", "from the first write of a service bit on: no answer, no connection"),
    ("close", "the connection is closed after each answer"),
    ("split", "each answer comes in two segments"),
    ("garbled", "one byte of each answer is changed"),
    ("swapped", "the halves of every 32-bit word are exchanged, read or written"),
    ("unit=N", "answers come from unit N"),
    ("transaction", "answers have a transaction number that is 1 too high"),
];
/// The same; it is apart because it is refused and not spoilt.
pub const MAX_FORM: (&str, &str) = ("max=N", "exception 03 to a read of more than N registers");

const HOUR: Duration = Duration::from_secs(3_600);
/// No answer is later than this.
const LATE_MAX: Duration = HOUR;
/// No fault begins or lasts longer.
const TIME_MAX: Duration = Duration::from_secs(366 * 24 * 3_600);
/// As many faults at one time.
pub(crate) const FAULTS_MAX: usize = 64;

/// What a gateway does wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatewayMisdeed {
    /// No request is answered or carried out.
    Silent,
    /// Answers come later.
    Late {
        /// By so much.
        by: Duration,
    },
    /// Every request is refused. 06 is `busy`.
    Exception(u8),
    /// No answer is sent.
    Drop,
    /// After the first write that sets a service bit nothing is there any more.
    Dead,
    /// The connection is closed behind each answer.
    Close,
    /// Answers come in two segments.
    Split,
    /// One byte of the PDU of each answer is changed.
    Garbled,
    /// The halves of words are exchanged.
    Swapped,
    /// Answers come from this unit.
    Unit(u8),
    /// Answers have the next transaction number.
    Transaction,
    /// Reads of more registers are refused with exception 03.
    Max(u16),
}

/// What a gateway does wrong, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatewayFault {
    /// What.
    pub misdeed: GatewayMisdeed,
    /// At this request only, counted from 1 over all connections.
    pub request: Option<u64>,
    /// From this time on.
    pub after: Duration,
    /// For so long; `None` for good.
    pub lasting: Option<Duration>,
}

/// Why a text is no fault of a gateway.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GatewayFaultError {
    /// There is no such kind.
    #[error("gateway fault {given:?}; there are {}; with #N behind it only at request N", kinds())]
    Kind {
        /// What was given.
        given: String,
    },
    /// A value that the kind does not allow.
    #[error("gateway fault {kind}: value {given:?}; it must be {allowed}")]
    Value {
        /// The kind.
        kind: &'static str,
        /// What was given.
        given: String,
        /// What may be.
        allowed: &'static str,
    },
    /// No number of a request.
    #[error("request #{given}; it must be a number from 1 on")]
    Request {
        /// What was given.
        given: String,
    },
    /// No time.
    #[error("time {given:?}; it must be like 5s, 200ms, 1m or 2h, up to a year")]
    Time {
        /// What was given.
        given: String,
    },
    /// There are as many as there may be.
    #[error("there are {FAULTS_MAX} gateway faults already")]
    TooMany,
    /// There is none to end.
    #[error("gateway fault {fault} is not there; there {}", .there)]
    NotThere {
        /// Which.
        fault: GatewayFault,
        /// Those that are, in words.
        there: String,
    },
}

fn kinds() -> String {
    let forms: Vec<_> = FORMS.iter().chain([&MAX_FORM]).map(|(form, _)| *form).collect();
    forms.join(", ")
}

impl FromStr for GatewayFault {
    type Err = GatewayFaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (rest, lasting) = match text.rsplit_once('+') {
            Some((rest, lasting)) => (rest, Some(time(lasting)?)),
            None => (text, None),
        };
        let (rest, after) = match rest.rsplit_once('@') {
            Some((rest, after)) => (rest, time(after)?),
            None => (rest, Duration::ZERO),
        };
        let (kind, request) = match rest.rsplit_once('#') {
            Some((kind, number)) => (kind, Some(request(number)?)),
            None => (rest, None),
        };
        Ok(Self { misdeed: kind.parse()?, request, after, lasting })
    }
}

impl FromStr for GatewayMisdeed {
    type Err = GatewayFaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (kind, value) = match text.split_once('=') {
            Some((kind, value)) => (kind, Some(value)),
            None => (text, None),
        };
        let wrong = |kind, allowed| GatewayFaultError::Value {
            kind,
            given: value.unwrap_or_default().to_owned(),
            allowed,
        };
        let of = value.unwrap_or_default();
        match (kind, value) {
            ("silent", None) => Ok(Self::Silent),
            ("late", _) => late(of).ok_or_else(|| wrong("late", "milliseconds up to an hour")),
            ("busy", None) => Ok(Self::Exception(6)),
            ("exception", _) => u8::from_str_radix(of, 16)
                .ok()
                .filter(|code| *code > 0 && of.len() <= 2)
                .map(Self::Exception)
                .ok_or_else(|| wrong("exception", "01 to FF")),
            ("drop", None) => Ok(Self::Drop),
            ("dead", None) => Ok(Self::Dead),
            ("close", None) => Ok(Self::Close),
            ("split", None) => Ok(Self::Split),
            ("garbled", None) => Ok(Self::Garbled),
            ("swapped", None) => Ok(Self::Swapped),
            ("unit", _) => of.parse().map(Self::Unit).map_err(|_| wrong("unit", "0 to 255")),
            ("transaction", None) => Ok(Self::Transaction),
            ("max", _) => of
                .parse()
                .ok()
                .filter(|registers| (1..=125).contains(registers))
                .map(Self::Max)
                .ok_or_else(|| wrong("max", "1 to 125")),
            _ => Err(GatewayFaultError::Kind { given: text.to_owned() }),
        }
    }
}

fn late(text: &str) -> Option<GatewayMisdeed> {
    let by = Duration::from_millis(text.parse().ok()?);
    (by <= LATE_MAX).then_some(GatewayMisdeed::Late { by })
}

fn request(text: &str) -> Result<u64, GatewayFaultError> {
    let number = text.parse().ok().filter(|number| *number > 0);
    number.ok_or_else(|| GatewayFaultError::Request { given: text.to_owned() })
}

fn time(text: &str) -> Result<Duration, GatewayFaultError> {
    let refused = || GatewayFaultError::Time { given: text.to_owned() };
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at_checked(digits).ok_or_else(refused)?;
    let number: u64 = number.parse().map_err(|_| refused())?;
    let millis = match unit {
        "ms" => 1,
        "" | "s" => 1_000,
        "m" => 60_000,
        "h" => 3_600_000,
        _ => return Err(refused()),
    };
    let time = number.checked_mul(millis).map(Duration::from_millis);
    time.filter(|time| *time <= TIME_MAX).ok_or_else(refused)
}

impl fmt::Display for GatewayMisdeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => f.write_str("silent"),
            Self::Late { by } => write!(f, "late={}", by.as_millis()),
            Self::Exception(6) => f.write_str("busy"),
            Self::Exception(code) => write!(f, "exception={code:02X}"),
            Self::Drop => f.write_str("drop"),
            Self::Dead => f.write_str("dead"),
            Self::Close => f.write_str("close"),
            Self::Split => f.write_str("split"),
            Self::Garbled => f.write_str("garbled"),
            Self::Swapped => f.write_str("swapped"),
            Self::Unit(unit) => write!(f, "unit={unit}"),
            Self::Transaction => f.write_str("transaction"),
            Self::Max(registers) => write!(f, "max={registers}"),
        }
    }
}

impl fmt::Display for GatewayFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.misdeed)?;
        if let Some(request) = self.request {
            write!(f, "#{request}")?;
        }
        if self.after > Duration::ZERO {
            write!(f, "@{}ms", self.after.as_millis())?;
        }
        self.lasting.map_or(Ok(()), |lasting| write!(f, "+{}ms", lasting.as_millis()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_that_is_printed_is_read_again() {
        for text in [
            "silent",
            "late=2500",
            "late=2500#17",
            "exception=0B#3+5000ms",
            "close#1@2000ms",
            "busy",
            "exception=0B",
            "drop",
            "dead",
            "close",
            "split",
            "garbled",
            "swapped",
            "unit=0",
            "transaction",
            "max=16",
            "dead+5000ms",
            "busy@1000ms+200ms",
            "silent@60000ms",
        ] {
            assert_eq!(text.parse::<GatewayFault>().unwrap().to_string(), text);
        }
        let fault: GatewayFault = "late=5@2m+1h".parse().unwrap();
        assert_eq!((fault.after, fault.lasting), (Duration::from_secs(120), Some(HOUR)));
        for (form, _) in FORMS.iter().chain([&MAX_FORM]) {
            let text = form.replace("MS", "7").replace("=NN", "=0B").replace("=N", "=7");
            for text in [format!("{text}#5"), text] {
                text.parse::<GatewayFault>().unwrap_or_else(|error| panic!("{text}: {error}"));
            }
        }
    }

    #[test]
    fn what_is_none_is_refused_with_what_there_is() {
        for text in [
            "",
            "slow",
            "late",
            "late=x",
            "late=1#0",
            "late#1=5",
            "drop#",
            "drop#x",
            "drop#18446744073709551616",
            "exception=100",
            "exception=0",
            "unit=256",
            "max=0",
            "max=126",
            "busy=1",
            "silent@",
            "silent@x",
            "silent+1d",
            "silent+99999999999999999999h",
        ] {
            text.parse::<GatewayFault>().unwrap_err();
        }
        let error = "slow".parse::<GatewayFault>().unwrap_err().to_string();
        assert!(error.contains("late=MS,") && error.contains("#N") && error.contains("max=N"), "{error}");
    }
}
