//! What about an answer is not as its request wants it, told from the bytes of both.

use crate::address::Accept;
use crate::error::Garbled;

/// How frames stand on a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Framing {
    /// Behind a header with transaction, protocol, length and unit.
    Tcp,
    /// Behind the unit, with a checksum.
    Rtu,
}

/// Of the header of Modbus TCP: transaction, protocol and length, then the unit.
const UNIT: usize = 6;

/// The first difference that counts, for an answer that was refused.
pub(super) fn between(framing: Framing, sent: &[u8], got: &[u8]) -> Garbled {
    match framing {
        Framing::Tcp => over_tcp(sent, got),
        Framing::Rtu => match (sent, got) {
            ([wanted, ..], [unit, ..]) if unit != wanted => Garbled::Unit { got: *unit, wanted: *wanted },
            ([_, sent @ ..], [_, got @ ..]) => {
                pdu(sent, got.get(..got.len().saturating_sub(2)).unwrap_or(got))
            }
            _ => Garbled::Unfinished { bytes: got.len() },
        },
    }
}

fn over_tcp(sent: &[u8], got: &[u8]) -> Garbled {
    if is_serial(sent, got) {
        return Garbled::SerialFrame;
    }
    let (Some((header, sent)), Some((found, answer))) = (sent.split_first_chunk(), got.split_first_chunk())
    else {
        return Garbled::Unfinished { bytes: got.len() };
    };
    let [w1, w0, _, _, _, _, wanted] = *header;
    let [t1, t0, p1, p0, l1, l0, unit] = *found;
    let (protocol, length) = (u16::from_be_bytes([p1, p0]), u16::from_be_bytes([l1, l0]));
    let transactions = (u16::from_be_bytes([t1, t0]), u16::from_be_bytes([w1, w0]));
    match transactions {
        _ if protocol != 0 => Garbled::Protocol { got: protocol },
        (got, wanted) if got != wanted => Garbled::Transaction { got, wanted },
        _ if unit != wanted => Garbled::Unit { got: unit, wanted },
        _ if usize::from(length) != answer.len() + 1 => {
            Garbled::Length { got: got.len(), wanted: usize::from(length) + UNIT }
        }
        _ => pdu(sent, answer),
    }
}

/// The same for what follows the header.
fn pdu(sent: &[u8], got: &[u8]) -> Garbled {
    let ([wanted, sent @ ..], [function, got @ ..]) = (sent, got) else { return Garbled::Foreign };
    if function & 0x7F != *wanted {
        return Garbled::Function { got: *function, wanted: *wanted };
    }
    match (sent.first_chunk(), got.first_chunk()) {
        // A write returns register and count.
        (Some(sent), Some(echo)) if *function == 16 => {
            let [first, count] = halves(*sent);
            let [got_first, got_count] = halves(*echo);
            Garbled::Echo { got: (got_first, got_count), wanted: (first, count) }
        }
        _ => Garbled::Foreign,
    }
}

fn halves([a, b, c, d]: [u8; 4]) -> [u16; 2] {
    [u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d])]
}

/// Whether these bytes are a frame of a serial line that answers the request: unit, function, checksum.
fn is_serial(sent: &[u8], got: &[u8]) -> bool {
    let (Some(asked), Some((body, checksum))) = (sent.get(UNIT..=UNIT + 1), got.split_last_chunk()) else {
        return false;
    };
    let answered = body.first_chunk::<2>();
    answered.is_some_and(|[unit, function]| [*unit, function & 0x7F] == *asked)
        && crc(body).to_le_bytes() == *checksum
}

/// The checksum of a serial line.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xA001 } else { crc >> 1 })
    })
}

/// Takes what may differ in an answer from its request.
pub(super) fn adopt(sent: &[u8], got: &mut [u8], accept: Accept) {
    let fields = [(accept.transaction, 0..2), (accept.unit, UNIT..UNIT + 1)];
    for field in fields.into_iter().filter_map(|(accepted, field)| accepted.then_some(field)) {
        if let (Some(sent), Some(got)) = (sent.get(field.clone()), got.get_mut(field)) {
            got.copy_from_slice(sent);
        }
    }
}

/// Whether transaction, protocol and unit are those of the request.
pub(super) fn same_header(sent: &[u8], got: &[u8]) -> bool {
    let told = |frame: &[u8]| Some((frame.get(..4)?.to_vec(), *frame.get(UNIT)?));
    told(sent).is_some() && told(sent) == told(got)
}
