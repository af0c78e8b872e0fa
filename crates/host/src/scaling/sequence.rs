//! The words that program values, in the manuals' order: each parameter, then one data check [R79, R81].

use encoring_words::word::{ERROR_BIT, Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, InWord, OutWord, Service};

/// One OUT word, and what IN shows before the next may follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HandshakeWord {
    /// The service it belongs to.
    pub service: Service,
    /// Its place in the service's handshake.
    pub phase: HandshakeStep,
    /// What to write.
    pub out: OutWord,
    /// What to wait for.
    pub expected: Expected,
}

/// The three words of a handshake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandshakeStep {
    /// Service and data, the service bit still 0: both halves are in place before anything counts.
    Prepare,
    /// The same with the service bit, at least one cycle later.
    Request,
    /// The service bit taken back, after the reply has been read.
    End,
}

/// What IN shows when a step is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// Normal mode: 00 and the position.
    Position,
    /// This reply.
    Reply(InWord),
}

impl Expected {
    /// The same with the error bit, as it looks while an error is pending; `None` for a position. The reply to a data
    /// check then carries the error status as well.
    #[must_use]
    pub const fn with_error(self) -> Option<InWord> {
        match self {
            Self::Position => None,
            Self::Reply(InWord(word)) => Some(InWord(word | ERROR_BIT.mask())),
        }
    }
}

/// A service's three steps. `data` is what a write sends; a read sends 0 and expects 0.
pub(super) fn handshake(service: Service, access: Access, data: u32) -> [HandshakeWord; 3] {
    let fields =
        ServiceFields { access, error: false, reserve: false, service: ServiceNumber::Known(service), data };
    let request = OutWord::from(Out::Request(fields));
    let rest = OutWord::from(Out::Normal(request.0));
    let step = |phase, out, expected| HandshakeWord { service, phase, out, expected };
    [
        step(HandshakeStep::Prepare, rest, Expected::Position),
        step(HandshakeStep::Request, request, Expected::Reply(InWord(request.0))),
        step(HandshakeStep::End, rest, Expected::Position),
    ]
}

/// The three steps of the data check that ends every programming.
pub(super) fn data_check() -> [HandshakeWord; 3] {
    handshake(Service::DataCheck, Access::Read, 0)
}

/// The three steps of a preset adjustment to a value.
#[must_use]
pub fn preset_adjustment(value: u32) -> [HandshakeWord; 3] {
    handshake(Service::PresetAdjustment, Access::Write, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_goes_out_without_with_and_without_the_service_bit() {
        let [prepare, request, end] = handshake(Service::MeasuringLength, Access::Write, 0x270F);
        assert_eq!((prepare.out, prepare.expected), (OutWord(0x4200_270F), Expected::Position));
        assert_eq!(
            (request.out, request.expected),
            (OutWord(0xC200_270F), Expected::Reply(InWord(0xC200_270F)))
        );
        assert_eq!((end.out, end.expected), (OutWord(0x4200_270F), Expected::Position));
        assert_eq!(request.expected.with_error(), Some(InWord(0xE200_270F)));
        assert_eq!(end.expected.with_error(), None);
    }

    #[test]
    fn the_data_check_is_a_read_without_data() {
        let [prepare, request, end] = data_check();
        assert_eq!((prepare.out, end.out), (OutWord(0x0800_0000), OutWord(0x0800_0000)));
        assert_eq!(request.out, OutWord(0x8800_0000));
        assert_eq!(request.expected, Expected::Reply(InWord(0x8800_0000)));
    }
}
