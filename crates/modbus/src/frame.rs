//! Where a request begins and ends in a stream of bytes: the header of Modbus TCP, 7 bytes before each PDU.

use std::io;

use tokio_util::bytes::{Buf, BufMut, BytesMut};
use tokio_util::codec::{Decoder, Encoder};

use crate::pdu::{PDU_MAX, Pdu};

/// The only protocol that the header knows.
const MODBUS: u16 = 0;
/// The longest unit identifier and PDU together.
const LENGTH_MAX: u16 = PDU_MAX as u16 + 1;

/// A request or an answer with what its header says.
pub(crate) struct Frame {
    /// The client's number for the request, returned with the answer.
    pub(crate) transaction: u16,
    /// Any unit is answered: one ring is behind all of them.
    pub(crate) unit: u8,
    pub(crate) pdu: Pdu,
}

/// Why no further request can be found in a stream.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FrameError {
    #[error("protocol {got}; it must be {MODBUS}")]
    Protocol { got: u16 },
    /// A length of 1 is a unit without a function code, for which not even an exception can be written.
    #[error("length {got}; it must be 2 to {LENGTH_MAX}")]
    Length { got: u16 },
    #[error(transparent)]
    Line(#[from] io::Error),
}

/// Cuts a stream into frames. It keeps at most what one read brought; a header that is refused is refused before
/// its PDU has come.
#[derive(Debug)]
pub(crate) struct Codec;

impl Decoder for Codec {
    type Item = Frame;
    type Error = FrameError;

    fn decode(&mut self, stream: &mut BytesMut) -> Result<Option<Frame>, FrameError> {
        let Some((&[t1, t0, p1, p0, l1, l0], rest)) = stream.split_first_chunk() else { return Ok(None) };
        let protocol = u16::from_be_bytes([p1, p0]);
        if protocol != MODBUS {
            return Err(FrameError::Protocol { got: protocol });
        }
        let length = u16::from_be_bytes([l1, l0]);
        if !(2..=LENGTH_MAX).contains(&length) {
            return Err(FrameError::Length { got: length });
        }
        let Some([unit, pdu @ ..]) = rest.get(..usize::from(length)) else { return Ok(None) };
        let transaction = u16::from_be_bytes([t1, t0]);
        let frame = Frame { transaction, unit: *unit, pdu: Pdu::of(pdu.iter().copied()) };
        stream.advance(6 + usize::from(length));
        Ok(Some(frame))
    }
}

impl Encoder<Frame> for Codec {
    type Error = FrameError;

    fn encode(&mut self, frame: Frame, stream: &mut BytesMut) -> Result<(), FrameError> {
        let pdu = frame.pdu.as_bytes();
        stream.put_u16(frame.transaction);
        stream.put_u16(MODBUS);
        // A PDU holds at most 253 bytes.
        stream.put_u16(pdu.len() as u16 + 1);
        stream.put_u8(frame.unit);
        stream.put_slice(pdu);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Transaction, unit and PDU of every frame, and what came after the last.
    fn all(bytes: &[u8]) -> (Vec<(u16, u8, Vec<u8>)>, String) {
        let mut stream = BytesMut::from(bytes);
        let mut frames = Vec::new();
        loop {
            match Codec.decode(&mut stream) {
                Ok(Some(frame)) => {
                    frames.push((frame.transaction, frame.unit, frame.pdu.as_bytes().to_vec()));
                }
                Ok(None) => return (frames, format!("{} bytes", stream.len())),
                Err(error) => return (frames, error.to_string()),
            }
        }
    }

    #[test]
    fn frames_that_follow_each_other_are_told_apart() {
        let (frames, rest) =
            all(&[0x12, 0x34, 0, 0, 0, 2, 9, 0x03, 0x56, 0x78, 0, 0, 0, 3, 0, 0x41, 7, 1, 2]);
        assert_eq!(frames, [(0x1234, 9, vec![0x03]), (0x5678, 0, vec![0x41, 7])]);
        assert_eq!(rest, "2 bytes");
    }

    #[test]
    fn every_byte_may_come_alone() {
        let bytes = [0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 2];
        let mut stream = BytesMut::new();
        for (index, byte) in bytes.iter().enumerate() {
            stream.put_u8(*byte);
            let frame = Codec.decode(&mut stream).unwrap();
            assert_eq!(frame.is_some(), index + 1 == bytes.len(), "after {index}");
        }
        assert!(stream.is_empty());
    }

    #[test]
    fn another_protocol_is_refused_by_its_header_alone() {
        let (_, error) = all(&[0, 0, 1, 2, 0, 6]);
        assert_eq!(error, "protocol 258; it must be 0");
    }

    #[test]
    fn a_length_is_between_2_and_254() {
        for length in 0..=u16::MAX {
            let [high, low] = length.to_be_bytes();
            let mut bytes = vec![0, 0, 0, 0, high, low];
            bytes.resize(6 + usize::from(length.min(300)), 3);
            let (frames, rest) = all(&bytes);
            if (2..=254).contains(&length) {
                assert_eq!(rest, "0 bytes", "length {length}");
                assert_eq!(frames[0].2.len(), usize::from(length) - 1);
            } else {
                assert_eq!(frames, []);
                assert_eq!(rest, format!("length {length}; it must be 2 to 254"));
            }
        }
    }
}
