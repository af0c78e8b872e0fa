//! Where a ring is to be found, as one line of text: bus addresses such as
//! `modbus-tcp://192.168.1.10:502?unit=1&in=holding:1000&order=low-first` or
//! `modbus-rtu:/dev/ttyUSB0?baud=19200&parity=even`.
//!
//! What is left out has its default, and is left out again when an address is printed; parsing what was printed gives
//! the same address. The page for users is `docs/bus.md`.

use std::fmt::{self, Display};
use std::net::Ipv6Addr;
use std::ops::RangeInclusive;
use std::str::FromStr;

use encoring_words::Duration;

use crate::place::{DATA, RegisterPlace, Table, WordOrder};

/// The port of Modbus TCP.
pub const PORT: u16 = 502;

/// Before the host of a gateway on the network.
const TCP: &str = "modbus-tcp://";
/// Before the device of a serial line.
const RTU: &str = "modbus-rtu:";

const TIMEOUT_MS: RangeInclusive<u32> = 10..=60_000;
const SETTLE_MS: RangeInclusive<u32> = 0..=60_000;
const BAUD: RangeInclusive<u32> = 300..=4_000_000;
/// 0 asks every unit of a serial line and is answered by none; from 248 on the numbers are reserved.
const RTU_UNITS: RangeInclusive<u32> = 1..=247;

/// A ring behind Modbus: the way there, and where its words stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// The way to the gateway.
    pub way: Way,
    /// Unit identifier.
    pub unit: u8,
    /// Which register holds what.
    pub layout: Layout,
    /// Which half of a word comes first.
    pub order: WordOrder,
    /// Within this every call ends.
    pub timeout: Duration,
    /// What the gateway's scan and the ring's cycle may take at most, together.
    pub settle: Duration,
}

/// The way to a gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Way {
    /// Modbus TCP.
    Tcp {
        /// A name or an address, an IPv6 address without its brackets.
        host: String,
        /// TCP port.
        port: u16,
    },
    /// Modbus RTU on a serial line, 8 data bits.
    Rtu {
        /// What the operating system calls it.
        device: String,
        /// Bits a second.
        baud: u32,
        /// Parity bit.
        parity: Parity,
        /// StopBits bits.
        stop: StopBits,
    },
}

/// The parity bit of a serial line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parity {
    /// There is none.
    None,
    /// The number of ones is even, which is what Modbus asks for.
    #[default]
    Even,
    /// The number of ones is odd.
    Odd,
}

/// How many stop bits a serial line has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StopBits {
    /// One.
    #[default]
    One,
    /// Two.
    Two,
}

/// Which register holds what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Two registers for each encoder, in the order of the ring positions.
    Plain {
        /// The first holding register of the OUT words.
        out: u16,
        /// Where the IN words begin.
        input: RegisterPlace,
    },
    /// As an Inline bus coupler shows its modules: a directory from register 1400 on, and the process data of all
    /// modules behind each other.
    Inline {
        /// Where the process data begin; the directory is in the same table.
        data: RegisterPlace,
    },
}

/// Why a text is no bus address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("bus address, column {column}: {problem}")]
pub struct AddressError {
    /// The first character of what is wrong, from 1.
    pub column: usize,
    /// What is wrong.
    pub problem: AddressProblem,
}

/// What can be wrong with a bus address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressProblem {
    /// It begins with no known way.
    #[error("{given:?} begins neither with {TCP} nor with {RTU}")]
    Way {
        /// The whole text.
        given: String,
    },
    /// No host, or none that can be one.
    #[error("host {given:?}; it must be a name, an IPv4 address, or an IPv6 address in brackets, as [::1]")]
    Host {
        /// What was given.
        given: String,
    },
    /// Not a port.
    #[error("port {given:?}; it must be 1 to 65535")]
    Port {
        /// What was given.
        given: String,
    },
    /// No device, or none that can be one.
    #[error("device {given:?}; it must be what the system calls the serial port, as /dev/ttyUSB0")]
    Device {
        /// What was given.
        given: String,
    },
    /// An option that this way or layout does not have.
    #[error("option {given:?}; there are {allowed}")]
    Unknown {
        /// What was given.
        given: String,
        /// Those that there are.
        allowed: String,
    },
    /// An option without a value.
    #[error("option {given:?} without a value; write {given}=..")]
    NoValue {
        /// The option.
        given: String,
    },
    /// An option that is there already.
    #[error("{key}= is given twice")]
    Twice {
        /// The option.
        key: &'static str,
    },
    /// A value that the option does not allow.
    #[error("{key}={given}; it must be {allowed}")]
    Value {
        /// The option.
        key: &'static str,
        /// What was given.
        given: String,
        /// What may be.
        allowed: String,
    },
    /// An option that means nothing in this layout.
    #[error("{key}= with layout=inline, where the OUT data follow the IN data; leave it out")]
    Misplaced {
        /// The option.
        key: &'static str,
    },
}

impl Address {
    /// The address of a gateway with everything else at its default.
    #[must_use]
    pub fn new(way: Way) -> Self {
        let layout = Layout::Plain { out: 0, input: RegisterPlace { table: Table::Input, first: 0 } };
        Self {
            way,
            unit: 1,
            layout,
            order: WordOrder::default(),
            timeout: Duration::from_millis(1_000),
            settle: Duration::from_millis(20),
        }
    }

    /// A gateway on the network, with everything else at its default.
    #[must_use]
    pub fn tcp(host: impl Into<String>, port: u16) -> Self {
        Self::new(Way::Tcp { host: host.into(), port })
    }
}

/// A piece of an address and the column at which it begins.
#[derive(Clone, Copy)]
struct Piece<'a> {
    column: usize,
    text: &'a str,
}

impl<'a> Piece<'a> {
    fn error(self, problem: impl FnOnce(String) -> AddressProblem) -> AddressError {
        AddressError { column: self.column, problem: problem(self.text.to_owned()) }
    }

    /// What stands before and after the first `separator`.
    fn split(self, separator: char) -> (Self, Option<Self>) {
        match self.text.split_once(separator) {
            Some((before, after)) => {
                let column = self.column + before.chars().count() + 1;
                (Self { text: before, ..self }, Some(Self { column, text: after }))
            }
            None => (self, None),
        }
    }

    fn strip(self, prefix: &str) -> Option<Self> {
        let text = self.text.strip_prefix(prefix)?;
        Some(Self { column: self.column + prefix.chars().count(), text })
    }

    /// A number in decimal digits and nothing else.
    fn number(self, allowed: &RangeInclusive<u32>) -> Option<u32> {
        let digits = !self.text.is_empty() && self.text.bytes().all(|byte| byte.is_ascii_digit());
        self.text.parse().ok().filter(|number| digits && allowed.contains(number))
    }

    fn place(self) -> Option<RegisterPlace> {
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
struct Options<'a> {
    given: Vec<(&'static str, Piece<'a>)>,
}

impl<'a> Options<'a> {
    /// Takes apart what stands behind the question mark.
    fn parse(text: Option<Piece<'a>>, keys: &[&'static str]) -> Result<Self, AddressError> {
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

    fn find(&self, key: &str) -> Option<Piece<'a>> {
        self.given.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
    }

    /// The option's value, if it is given; an error if `read` makes nothing of it.
    fn value<T>(
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

    fn number(&self, key: &'static str, allowed: &RangeInclusive<u32>) -> Result<Option<u32>, AddressError> {
        let text = format!("{} to {}", allowed.start(), allowed.end());
        self.value(key, &text, |piece| piece.number(allowed))
    }
}

/// The options of both ways, in the order in which they are printed.
const COMMON: [&str; 7] = ["unit", "out", "in", "order", "layout", "timeout_ms", "settle_ms"];
/// Those of a serial line, before the others.
const SERIAL: [&str; 4] = ["baud", "parity", "stop", "data"];

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(given: &str) -> Result<Self, Self::Err> {
        let whole = Piece { column: 1, text: given };
        let (way, options) = whole.split('?');
        if let Some(host) = way.strip(TCP) {
            let options = Options::parse(options, &COMMON)?;
            return with_options(Self::new(tcp_way(host)?), &options, &(0..=255));
        }
        if let Some(device) = way.strip(RTU) {
            let keys: Vec<_> = SERIAL.into_iter().chain(COMMON).collect();
            let options = Options::parse(options, &keys)?;
            return with_options(Self::new(rtu_way(device, &options)?), &options, &RTU_UNITS);
        }
        Err(whole.error(|given| AddressProblem::Way { given }))
    }
}

fn tcp_way(text: Piece<'_>) -> Result<Way, AddressError> {
    let refused = || text.error(|given| AddressProblem::Host { given });
    let (host, port) = match text.strip("[") {
        Some(inner) => {
            let (address, after) = inner.split(']');
            let address: Ipv6Addr = address.text.parse().map_err(|_| refused())?;
            let port = match after {
                Some(Piece { text: "", .. }) => None,
                Some(after) => Some(after.strip(":").ok_or_else(refused)?),
                None => return Err(refused()),
            };
            (address.to_string(), port)
        }
        None => {
            let (host, port) = text.split(':');
            let letters = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
            if host.text.is_empty() || !host.text.chars().all(letters) {
                return Err(refused());
            }
            (host.text.to_owned(), port)
        }
    };
    let port = match port {
        Some(port) => port
            .number(&(1..=u32::from(u16::MAX)))
            .and_then(|port| u16::try_from(port).ok())
            .ok_or_else(|| port.error(|given| AddressProblem::Port { given }))?,
        None => PORT,
    };
    Ok(Way::Tcp { host, port })
}

fn rtu_way(device: Piece<'_>, options: &Options<'_>) -> Result<Way, AddressError> {
    if device.text.is_empty() || device.text.chars().any(char::is_control) {
        return Err(device.error(|given| AddressProblem::Device { given }));
    }
    let parity = options.value("parity", "none, even or odd", |piece| match piece.text {
        "none" => Some(Parity::None),
        "even" => Some(Parity::Even),
        "odd" => Some(Parity::Odd),
        _ => None,
    })?;
    let stop = options.value("stop", "1 or 2", |piece| match piece.text {
        "1" => Some(StopBits::One),
        "2" => Some(StopBits::Two),
        _ => None,
    })?;
    options.value("data", "8, as Modbus RTU has whole bytes", |piece| (piece.text == "8").then_some(()))?;
    Ok(Way::Rtu {
        device: device.text.to_owned(),
        baud: options.number("baud", &BAUD)?.unwrap_or(19_200),
        parity: parity.unwrap_or_default(),
        stop: stop.unwrap_or_default(),
    })
}

fn with_options(
    mut address: Address,
    options: &Options<'_>,
    units: &RangeInclusive<u32>,
) -> Result<Address, AddressError> {
    if let Some(unit) = options.number("unit", units)? {
        address.unit = u8::try_from(unit).unwrap_or(address.unit);
    }
    let out = options.value("out", "holding:N, N from 0 to 65534: OUT words are written", |piece| {
        piece.place().filter(|place| place.table == Table::Holding && place.first < u16::MAX)
    })?;
    let input = options.value("in", "holding:N or input:N, N from 0 to 65534", |piece| {
        piece.place().filter(|place| place.first < u16::MAX)
    })?;
    let inline = options.value("layout", "plain or inline", |piece| match piece.text {
        "plain" => Some(false),
        "inline" => Some(true),
        _ => None,
    })?;
    address.layout = match (inline, address.layout, options.find("out")) {
        (Some(true), _, Some(piece)) => return Err(piece.error(|_| AddressProblem::Misplaced { key: "out" })),
        (Some(true), ..) => Layout::Inline { data: input.unwrap_or(DATA) },
        (_, Layout::Plain { out: default_out, input: default_input }, _) => Layout::Plain {
            out: out.map_or(default_out, |place| place.first),
            input: input.unwrap_or(default_input),
        },
        (_, layout, _) => layout,
    };
    if let Some(order) = options.value("order", "high-first or low-first", |piece| piece.text.parse().ok())? {
        address.order = order;
    }
    if let Some(timeout) = options.number("timeout_ms", &TIMEOUT_MS)? {
        address.timeout = Duration::from_millis(timeout.into());
    }
    if let Some(settle) = options.number("settle_ms", &SETTLE_MS)? {
        address.settle = Duration::from_millis(settle.into());
    }
    Ok(address)
}

impl Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = Self::new(self.way.clone());
        let mut options = Vec::new();
        match &self.way {
            Way::Tcp { host, port } if host.contains(':') => write!(f, "{TCP}[{host}]:{port}")?,
            Way::Tcp { host, port } => write!(f, "{TCP}{host}:{port}")?,
            Way::Rtu { device, baud, parity, stop } => {
                write!(f, "{RTU}{device}")?;
                options.push(format!("baud={baud}"));
                options.push(format!("parity={parity}"));
                if *stop == StopBits::Two {
                    options.push("stop=2".to_owned());
                }
            }
        }
        if self.unit != plain.unit {
            options.push(format!("unit={}", self.unit));
        }
        match self.layout {
            layout if layout == plain.layout => {}
            Layout::Plain { out, input } => {
                options.push(format!("out=holding:{out}"));
                options.push(format!("in={input}"));
            }
            Layout::Inline { data } => {
                options.push("layout=inline".to_owned());
                if data != DATA {
                    options.push(format!("in={data}"));
                }
            }
        }
        if self.order != plain.order {
            options.push(format!("order={}", self.order));
        }
        if self.timeout != plain.timeout {
            options.push(format!("timeout_ms={}", self.timeout.as_nanos() / 1_000_000));
        }
        if self.settle != plain.settle {
            options.push(format!("settle_ms={}", self.settle.as_nanos() / 1_000_000));
        }
        for (index, option) in options.iter().enumerate() {
            let before = if index == 0 { '?' } else { '&' };
            write!(f, "{before}{option}")?;
        }
        Ok(())
    }
}

impl Display for Parity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::None => "none",
            Self::Even => "even",
            Self::Odd => "odd",
        })
    }
}

#[cfg(test)]
mod tests;
