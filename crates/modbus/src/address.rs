//! Where a ring is to be found, as one line of text: bus addresses such as
//! `modbus-tcp://192.168.1.10:502?unit=1&in=holding:1000&order=low-first`, `modbus-rtu:/dev/ttyUSB0?baud=19200&parity=even`
//! or `modbus-rtu-tcp://192.168.1.10:4001`.
//!
//! What is left out has its default, and is left out again when an address is printed; parsing what was printed gives
//! the same address. The page for users is `docs/bus.md`.

use std::fmt::{self, Display};
use std::net::Ipv6Addr;
use std::ops::RangeInclusive;
use std::str::FromStr;

use encoring_words::Duration;

use crate::pdu::READ_MAX;
use crate::place::{DATA, RegisterPlace, Table, WordOrder};

mod options;

use options::{Options, Piece};

/// The port of Modbus TCP.
pub const PORT: u16 = 502;

/// Before the host of a gateway on the network.
const TCP: &str = "modbus-tcp://";
/// Before the device of a serial line.
const RTU: &str = "modbus-rtu:";
/// Before the host of a server that passes frames on to a serial line as they are.
const RTU_TCP: &str = "modbus-rtu-tcp://";

pub(crate) const TIMEOUT_MS: RangeInclusive<u32> = 10..=60_000;
const SETTLE_MS: RangeInclusive<u32> = 0..=60_000;
const BAUD: RangeInclusive<u32> = 300..=4_000_000;
/// One word is two registers, and no word is read in two pieces.
const REGISTERS: RangeInclusive<u32> = 2..=READ_MAX as u32;
/// How long an answer may take, its bytes on a serial line apart.
const TIMEOUT_DEFAULT: Duration = Duration::from_millis(500);
/// The longest frame on a serial line, in bits: a byte has 11 with its start, parity and stop bits.
const FRAME_BITS: u64 = 256 * 11;
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
    /// Which half of an IN word comes first.
    pub order_in: WordOrder,
    /// Which half of an OUT word comes first.
    pub order_out: WordOrder,
    /// Within this every call ends.
    pub timeout: Duration,
    /// What the gateway's scan and the ring's cycle may take at most, together.
    pub settle: Duration,
    /// As many registers as the gateway gives in one answer, from 2 to 125.
    pub max_registers: u16,
    /// What may differ in an answer that is taken all the same.
    pub accept: Accept,
    /// Where the gateway shows the diagnosis of the ring's master, if it does.
    pub diagnosis: DiagnosisPlaces,
}

/// What may differ in an answer that is taken all the same. Nothing, unless somebody says so: it weakens a check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Accept {
    /// The transaction number.
    pub transaction: bool,
    /// The unit identifier.
    pub unit: bool,
}

/// Where a gateway shows the diagnosis of the ring's master, as far as it does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DiagnosisPlaces {
    /// The register with the diagnostic status.
    pub status: Option<RegisterPlace>,
    /// The register with the diagnostic parameter.
    pub parameter: Option<RegisterPlace>,
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
        /// Stop bits.
        stop: StopBits,
    },
    /// Frames of Modbus RTU over TCP, as servers of serial devices pass them on.
    RtuTcp {
        /// A name or an address, an IPv6 address without its brackets.
        host: String,
        /// TCP port.
        port: u16,
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
    #[error("{given:?} begins with none of {TCP}, {RTU} and {RTU_TCP}")]
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
    /// A register as it is numbered on paper.
    #[error("{key}={given}; that is {meant} here: addresses are those on the wire, from 0")]
    Notation {
        /// The option.
        key: &'static str,
        /// What was given.
        given: String,
        /// The same as an address has it.
        meant: RegisterPlace,
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
            timeout: way.timeout(),
            way,
            unit: 1,
            layout,
            order_in: WordOrder::default(),
            order_out: WordOrder::default(),
            settle: Duration::from_millis(20),
            max_registers: READ_MAX,
            accept: Accept::default(),
            diagnosis: DiagnosisPlaces::default(),
        }
    }

    /// A gateway on the network, with everything else at its default.
    #[must_use]
    pub fn tcp(host: impl Into<String>, port: u16) -> Self {
        Self::new(Way::Tcp { host: host.into(), port })
    }
}

impl Way {
    /// How long an answer may take unless it is said: over a serial line its bytes take their time too.
    fn timeout(&self) -> Duration {
        match self {
            Self::Tcp { .. } | Self::RtuTcp { .. } => TIMEOUT_DEFAULT,
            Self::Rtu { baud, .. } => {
                let frame = (FRAME_BITS * 1_000).div_ceil(u64::from(*baud).max(1));
                TIMEOUT_DEFAULT + Duration::from_millis(frame)
            }
        }
    }
}

/// Where a gateway is, as its user calls it: host and port, or the device.
impl Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp { host, port } | Self::RtuTcp { host, port } if host.contains(':') => {
                write!(f, "[{host}]:{port}")
            }
            Self::Tcp { host, port } | Self::RtuTcp { host, port } => write!(f, "{host}:{port}"),
            Self::Rtu { device, .. } => f.write_str(device),
        }
    }
}

/// The options of every way, in the order in which they are printed.
const COMMON: [&str; 13] = [
    "unit",
    "out",
    "in",
    "order",
    "order_in",
    "order_out",
    "layout",
    "max_registers",
    "status",
    "parameter",
    "accept",
    "timeout_ms",
    "settle_ms",
];
/// Those of a serial line, before the others.
const SERIAL: [&str; 4] = ["baud", "parity", "stop", "data"];

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(given: &str) -> Result<Self, Self::Err> {
        let whole = Piece { column: 1, text: given };
        let (way, options) = whole.split('?');
        if let Some(host) = way.strip(TCP) {
            let options = Options::parse(options, &COMMON)?;
            let (host, port) = host_and_port(host)?;
            return with_options(Self::new(Way::Tcp { host, port }), &options, &(0..=255));
        }
        if let Some(host) = way.strip(RTU_TCP) {
            let options = Options::parse(options, &COMMON)?;
            let (host, port) = host_and_port(host)?;
            return with_options(Self::new(Way::RtuTcp { host, port }), &options, &RTU_UNITS);
        }
        if let Some(device) = way.strip(RTU) {
            let keys: Vec<_> = SERIAL.into_iter().chain(COMMON).collect();
            let options = Options::parse(options, &keys)?;
            return with_options(Self::new(rtu_way(device, &options)?), &options, &RTU_UNITS);
        }
        Err(whole.error(|given| AddressProblem::Way { given }))
    }
}

fn host_and_port(text: Piece<'_>) -> Result<(String, u16), AddressError> {
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
    Ok((host, port))
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
    let out = options.place("out", "holding:N, N from 0 to 65534: OUT words are written", |place| {
        place.table == Table::Holding && place.first < u16::MAX
    })?;
    let input =
        options.place("in", "holding:N or input:N, N from 0 to 65534", |place| place.first < u16::MAX)?;
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
    let order =
        |key| options.value(key, "high-first or low-first", |piece| piece.text.parse::<WordOrder>().ok());
    let both = order("order")?.unwrap_or_default();
    address.order_in = order("order_in")?.unwrap_or(both);
    address.order_out = order("order_out")?.unwrap_or(both);
    if let Some(registers) = options.number("max_registers", &REGISTERS)? {
        address.max_registers = u16::try_from(registers).unwrap_or(READ_MAX);
    }
    address.diagnosis = DiagnosisPlaces {
        status: options.place("status", "holding:N or input:N", |_| true)?,
        parameter: options.place("parameter", "holding:N or input:N", |_| true)?,
    };
    let accept = options.value("accept", "transaction, unit, or both with a comma", accepted)?;
    address.accept = accept.unwrap_or_default();
    if let Some(timeout) = options.number("timeout_ms", &TIMEOUT_MS)? {
        address.timeout = Duration::from_millis(timeout.into());
    }
    if let Some(settle) = options.number("settle_ms", &SETTLE_MS)? {
        address.settle = Duration::from_millis(settle.into());
    }
    Ok(address)
}

fn accepted(piece: Piece<'_>) -> Option<Accept> {
    let mut accept = Accept::default();
    for name in piece.text.split(',') {
        let accepted = match name {
            "transaction" => &mut accept.transaction,
            "unit" => &mut accept.unit,
            _ => return None,
        };
        if std::mem::replace(accepted, true) {
            return None;
        }
    }
    Some(accept)
}

impl Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = Self::new(self.way.clone());
        let mut options = Vec::new();
        let scheme = match &self.way {
            Way::Tcp { .. } => TCP,
            Way::RtuTcp { .. } => RTU_TCP,
            Way::Rtu { .. } => RTU,
        };
        write!(f, "{scheme}{}", self.way)?;
        if let Way::Rtu { baud, parity, stop, .. } = &self.way {
            options.push(format!("baud={baud}"));
            options.push(format!("parity={parity}"));
            if *stop == StopBits::Two {
                options.push("stop=2".to_owned());
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
        if self.order_in == self.order_out && self.order_in != plain.order_in {
            options.push(format!("order={}", self.order_in));
        } else if self.order_in != self.order_out {
            options.push(format!("order_in={}", self.order_in));
            options.push(format!("order_out={}", self.order_out));
        }
        if self.max_registers != plain.max_registers {
            options.push(format!("max_registers={}", self.max_registers));
        }
        for (key, place) in [("status", self.diagnosis.status), ("parameter", self.diagnosis.parameter)] {
            options.extend(place.map(|place| format!("{key}={place}")));
        }
        if self.accept != plain.accept {
            options.push(format!("accept={}", self.accept));
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

impl Display for Accept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.transaction, self.unit) {
            (true, true) => "transaction,unit",
            (true, false) => "transaction",
            (false, true) => "unit",
            (false, false) => "",
        })
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
