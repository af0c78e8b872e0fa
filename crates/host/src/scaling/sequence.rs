//! The words that program values, in the manuals' order: each parameter, then one data check [R79, R81].

use encoring_words::word::{DATA, ERROR_BIT, In, Out, ServiceFields, ServiceNumber};
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

/// What an IN word says of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// Done, and all is well.
    Good,
    /// Done, but the error bit is set. The data of a data check's reply is then the error status.
    Error,
    /// Not done yet, or not the answer to this step.
    Other,
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

    /// What `input` says of the step.
    #[must_use]
    pub fn judge(self, input: InWord) -> Judged {
        let (error, done) = match (self, input.decode()) {
            (Self::Position, In::Position { error, .. }) => (error, true),
            (Self::Reply(InWord(wanted)), In::Reply(seen)) => {
                let differs = (input.0 & !ERROR_BIT.mask()) ^ wanted;
                // An error that is over shows once as status alone, without the error bit.
                let status = seen.service == ServiceNumber::Known(Service::DataCheck)
                    && differs != 0
                    && differs & !DATA.mask() == 0;
                (seen.error || status, differs == 0 || status)
            }
            _ => (false, false),
        };
        match (done, error) {
            (true, false) => Judged::Good,
            (true, true) => Judged::Error,
            (false, _) => Judged::Other,
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

    #[test]
    fn every_answer_is_told_apart() {
        let [prepare, write, _] = handshake(Service::MeasuringLength, Access::Write, 0x270F);
        for (word, judged) in [
            (0xC200_270F, Judged::Good),
            (0xE200_270F, Judged::Error),
            (0xC200_270E, Judged::Other),
            (0x8200_270F, Judged::Other),
            (0xC300_270F, Judged::Other),
            (0xD200_270F, Judged::Other),
            (0x0000_270F, Judged::Other),
        ] {
            assert_eq!(write.expected.judge(InWord(word)), judged, "{word:08X}");
        }
        for (word, judged) in [
            (0x0000_1234, Judged::Good),
            (0x2000_1234, Judged::Error),
            (0xC200_270F, Judged::Other),
            (0x4000_1234, Judged::Other),
        ] {
            assert_eq!(prepare.expected.judge(InWord(word)), judged, "{word:08X}");
        }
        let [_, check, _] = data_check();
        for (word, judged) in [
            (0x8800_0000, Judged::Good),
            (0x8800_0080, Judged::Error),
            (0xA800_4000, Judged::Error),
            (0xA800_0000, Judged::Error),
            (0xC800_0000, Judged::Other),
        ] {
            assert_eq!(check.expected.judge(InWord(word)), judged, "{word:08X}");
        }
    }
}
