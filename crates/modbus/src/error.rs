//! What a client of Modbus meets that no other bus knows.

use std::fmt;

use encoring_bus::{Answered, BusError};

/// Why a request to a gateway brought no registers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModbusError {
    /// What any bus can meet.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The gateway refused the request.
    #[error("the gateway refused function {function} at register {register}: exception {exception:02X}h, {}", meaning(*.exception))]
    Refused {
        /// Modbus function.
        function: u8,
        /// First register of the request.
        register: u16,
        /// Modbus exception code.
        exception: u8,
    },
    /// The gateway's answer is not one to the request.
    #[error("the answer to function {function} at register {register} is no answer: {got}")]
    Garbled {
        /// Modbus function.
        function: u8,
        /// First register of the request.
        register: u16,
        /// What is wrong with it.
        got: Garbled,
    },
}

/// What is wrong with an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Garbled {
    /// It has another number of registers.
    Registers {
        /// As many as it has.
        got: usize,
        /// As many as were asked for.
        wanted: usize,
    },
    /// It has another transaction number.
    Transaction {
        /// Its own.
        got: u16,
        /// The request's.
        wanted: u16,
    },
    /// It comes from another unit.
    Unit {
        /// Its own.
        got: u8,
        /// The one that was asked.
        wanted: u8,
    },
    /// It is another protocol's.
    Protocol {
        /// The number that stands there; Modbus has 0.
        got: u16,
    },
    /// It belongs to another function.
    Function {
        /// Its own.
        got: u8,
        /// The request's.
        wanted: u8,
    },
    /// It has another length than it says, or than such an answer has.
    Length {
        /// Bytes that came.
        got: usize,
        /// Bytes that should have.
        wanted: usize,
    },
    /// It confirms another write.
    Echo {
        /// The first register and the count that it names.
        got: (u16, u16),
        /// Those of the request.
        wanted: (u16, u16),
    },
    /// It is a frame of a serial line, without the header of Modbus TCP.
    SerialFrame,
    /// It is no frame, or none of such an answer.
    Foreign,
    /// It was no whole frame when the time was over.
    Unfinished {
        /// As many bytes as had come.
        bytes: usize,
    },
    /// It names a length of process data that is not defined.
    LengthCode {
        /// The code.
        code: u8,
    },
}

impl From<ModbusError> for BusError {
    fn from(error: ModbusError) -> Self {
        match error {
            ModbusError::Bus(error) => error,
            ModbusError::Refused { exception: 5 | 6 | 0x0B, .. } => Self::client(Answered::Busy, error),
            ModbusError::Refused { .. } => Self::client(Answered::Refused, error),
            ModbusError::Garbled { got: Garbled::Echo { got, wanted }, .. } if got != wanted => {
                Self::client(Answered::Misdirected, error)
            }
            ModbusError::Garbled { .. } => Self::client(Answered::Garbled, error),
        }
    }
}

/// What it means, and what can be done.
const fn meaning(exception: u8) -> &'static str {
    match exception {
        0x01 => "it does not know the function; `encoring probe` tells which registers can be read there",
        0x02 => {
            "there is no such register; in= and out= of the address name the registers, and `encoring probe` finds them"
        }
        0x03 => "the quantity or value is not allowed; max_registers= in the address asks for fewer at once",
        0x04 => "it failed; its own messages tell more",
        0x05 => "it needs more time; --patience waits longer",
        0x06 => "it is busy; other clients may ask it too often, and --patience waits longer",
        0x08 => "its memory is damaged",
        0x0A => {
            "it has no way to the unit; unit= of the address names it, and the gateway's settings the way"
        }
        0x0B => {
            "the unit behind it does not answer; it may be off, or be another one: unit= of the address names it"
        }
        _ => "a code that Modbus does not define",
    }
}

impl fmt::Display for Garbled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Registers { got, wanted } => write!(f, "{got} registers instead of {wanted}"),
            Self::Transaction { got, wanted } => write!(
                f,
                "transaction number {got} instead of {wanted}; if the gateway always answers so, add accept=transaction to its \
                 address"
            ),
            Self::Unit { got, wanted } => write!(
                f,
                "unit {got} instead of {wanted}; unit={got} asks that one, and if the gateway answers so whoever is \
                 asked, add accept=unit to its address"
            ),
            Self::Protocol { got } => write!(f, "protocol {got} instead of 0"),
            Self::Function { got, wanted } => write!(f, "function {got} instead of {wanted}"),
            Self::Length { got, wanted } => write!(f, "{got} bytes instead of {wanted}"),
            Self::Echo { got: (first, count), wanted: (wanted_first, wanted_count) } => write!(
                f,
                "it confirms {count} registers from {first} on instead of {wanted_count} from {wanted_first} on"
            ),
            Self::SerialFrame => f.write_str(
                "it is a frame of a serial line: the gateway passes Modbus RTU on, write modbus-rtu-tcp:// instead of \
                 modbus-tcp://",
            ),
            Self::Foreign => f.write_str("it does not belong to the request"),
            Self::Unfinished { bytes } => write!(f, "{bytes} bytes and no whole frame among them"),
            Self::LengthCode { code } => write!(f, "length code {code:02X}h is not defined"),
        }
    }
}
