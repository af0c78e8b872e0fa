//! From a request to its answer: what the functions do to a process image, and when they refuse.
//!
//! A PDU is a function code and what belongs to it, without the header of the transport. Checks run in the order of
//! the state diagrams of the Modbus application protocol V1.1b3: the function (exception 01), then the request
//! itself, its length included (03), then the addresses (02). Only after the last check is anything written.

use encoring_ring::ProcessImage;
use encoring_words::Written;

use crate::place::{Table, WordOrder};
use crate::registers::{RegisterMap, Registers};

/// The longest PDU, in bytes.
pub const PDU_MAX: usize = 253;
/// The most registers that functions 3, 4 and 23 read.
pub const READ_MAX: u16 = 125;
/// The most registers that function 16 writes.
pub const WRITE_MAX: u16 = 123;
/// The most registers that function 23 writes.
pub const READ_WRITE_MAX: u16 = 121;

const READ_HOLDING: u8 = 3;
const READ_INPUT: u8 = 4;
const WRITE_ONE: u8 = 6;
const WRITE_SEVERAL: u8 = 16;
const WRITE_AND_READ: u8 = 23;

/// Set in the function code of an answer that is an exception.
const REFUSED: u8 = 0x80;
/// Functions that only write answer with the first bytes of the request: code, address, and value or count.
const ECHO: usize = 5;

/// Why a request is refused; the numbers are those on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exception {
    /// The function is not one of 3, 4, 6, 16 and, in the plain layout, 23.
    IllegalFunction = 1,
    /// A register does not exist, or cannot be written.
    IllegalDataAddress = 2,
    /// A count is 0 or too large, or counts and length contradict each other.
    IllegalDataValue = 3,
}

/// One PDU, request or answer.
#[derive(Clone, Debug)]
pub struct Pdu {
    length: usize,
    bytes: [u8; PDU_MAX],
}

impl Pdu {
    /// The first [`PDU_MAX`] of these bytes.
    pub(crate) fn of(bytes: impl IntoIterator<Item = u8>) -> Self {
        let mut pdu = Self { length: 0, bytes: [0; PDU_MAX] };
        for (place, byte) in pdu.bytes.iter_mut().zip(bytes) {
            *place = byte;
            pdu.length += 1;
        }
        pdu
    }

    /// The bytes as they go over the wire.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    /// `true` if the answer is an exception.
    #[must_use]
    pub fn is_exception(&self) -> bool {
        self.as_bytes().first().is_some_and(|function| function & REFUSED != 0)
    }
}

/// The address of the first register and how many there are.
#[derive(Clone, Copy)]
struct Span {
    address: u16,
    count: u16,
}

/// A request that contradicts neither itself nor the limits. Whether its registers exist is not known yet.
struct Request<'a> {
    /// Where to, and the values as they came, high byte first.
    write: Option<(Span, &'a [u8])>,
    /// Where from, after the write.
    read: Option<(Table, Span)>,
}

/// Carries a request out and gives the answer. Registers that a request names are read and written in one piece, and
/// a request that is refused writes nothing. `wrote` is told the position of each OUT word, and what was written to it.
///
/// Without any byte there is no function code to answer with; the answer is then `80 01`.
#[must_use]
pub fn respond(
    request: &[u8],
    image: &mut ProcessImage,
    layout: RegisterMap,
    order: WordOrder,
    wrote: &mut dyn FnMut(usize, Written),
) -> Pdu {
    let function = request.first().copied().unwrap_or_default();
    let answer = Request::parse(request, layout)
        .and_then(|parsed| parsed.carry_out(request, image, layout, order, wrote));
    answer.unwrap_or_else(|exception| Pdu::of([function | REFUSED, exception as u8]))
}

impl<'a> Request<'a> {
    fn parse(request: &'a [u8], layout: RegisterMap) -> Result<Self, Exception> {
        match *request {
            [WRITE_AND_READ, ..] if layout == RegisterMap::Inline => Err(Exception::IllegalFunction),
            [READ_HOLDING, a1, a0, c1, c0] => {
                let span = Span::new([a1, a0], [c1, c0], READ_MAX)?;
                Ok(Self { write: None, read: Some((Table::Holding, span)) })
            }
            [READ_INPUT, a1, a0, c1, c0] => {
                let span = Span::new([a1, a0], [c1, c0], READ_MAX)?;
                Ok(Self { write: None, read: Some((Table::Input, span)) })
            }
            [WRITE_ONE, a1, a0, ref value @ ..] => {
                let span = Span { address: u16::from_be_bytes([a1, a0]), count: 1 };
                Ok(Self { write: Some((span, span.values(2, value)?)), read: None })
            }
            [WRITE_SEVERAL, a1, a0, c1, c0, bytes, ref values @ ..] => {
                let span = Span::new([a1, a0], [c1, c0], WRITE_MAX)?;
                Ok(Self { write: Some((span, span.values(bytes, values)?)), read: None })
            }
            [WRITE_AND_READ, ra1, ra0, rc1, rc0, wa1, wa0, wc1, wc0, bytes, ref values @ ..] => {
                let read = Span::new([ra1, ra0], [rc1, rc0], READ_MAX)?;
                let span = Span::new([wa1, wa0], [wc1, wc0], READ_WRITE_MAX)?;
                let write = Some((span, span.values(bytes, values)?));
                Ok(Self { write, read: Some((Table::Holding, read)) })
            }
            // Too short, or a read that is too long.
            [READ_HOLDING | READ_INPUT | WRITE_ONE | WRITE_SEVERAL | WRITE_AND_READ, ..] => {
                Err(Exception::IllegalDataValue)
            }
            _ => Err(Exception::IllegalFunction),
        }
    }

    fn carry_out(
        self,
        request: &[u8],
        image: &mut ProcessImage,
        layout: RegisterMap,
        order: WordOrder,
        wrote: &mut dyn FnMut(usize, Written),
    ) -> Result<Pdu, Exception> {
        // Everything that can be refused is looked at before anything is written.
        let encoders = image.encoders();
        let find = |table, span: Span| Registers::find(layout, table, span.address, span.count, encoders);
        let write = match self.write {
            Some((span, values)) => {
                let registers = find(Table::Holding, span).filter(Registers::writable);
                Some((registers.ok_or(Exception::IllegalDataAddress)?, values))
            }
            None => None,
        };
        let read = match self.read {
            Some((table, span)) => {
                Some((find(table, span).ok_or(Exception::IllegalDataAddress)?, span.count))
            }
            None => None,
        };

        if let Some((registers, values)) = write {
            let (values, _) = values.as_chunks();
            registers.write(image, order, values.iter().copied().map(u16::from_be_bytes), wrote);
        }
        Ok(match read {
            Some((registers, count)) => {
                let [_, bytes] = (2 * count).to_be_bytes();
                let head = request.first().copied().into_iter().chain([bytes]);
                Pdu::of(head.chain(registers.read(image, order).flat_map(u16::to_be_bytes)))
            }
            None => Pdu::of(request.iter().copied().take(ECHO)),
        })
    }
}

impl Span {
    /// A count within 1 and `most`.
    fn new(address: [u8; 2], count: [u8; 2], most: u16) -> Result<Self, Exception> {
        let span = Self { address: u16::from_be_bytes(address), count: u16::from_be_bytes(count) };
        if (1..=most).contains(&span.count) { Ok(span) } else { Err(Exception::IllegalDataValue) }
    }

    /// The bytes that were announced, and came, and are two for each register.
    fn values(self, announced: u8, values: &[u8]) -> Result<&[u8], Exception> {
        let wanted = 2 * usize::from(self.count);
        let agree = usize::from(announced) == wanted && values.len() == wanted;
        if agree { Ok(values) } else { Err(Exception::IllegalDataValue) }
    }
}

#[cfg(test)]
mod tests;
