//! What a master may ask of an encoder, and how it tells the answer from every other word.

use encoring_words::explain::{Deed, Legal};
use encoring_words::model::Takes;
use encoring_words::number::TypedValue;
use encoring_words::parameter::{OutOfRange, Parameter, within};
use encoring_words::word::{DATA_MAX, ERROR_BIT, In, Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, InWord, Model, OutWord, Service};

/// A service to be carried out, with its data. Only what can be right is a request: a value outside its range is
/// refused when it is made, long before anything is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    service: Service,
    access: Access,
    data: u32,
}

/// Why a request was not made. Nothing has been sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// The value lies outside its range.
    #[error("{}: {typed} is outside {}..{}", .service.name(), .typed.like(*.low), .typed.like(*.high))]
    Range {
        /// The service.
        service: Service,
        /// The value that decided, in the base that was typed.
        typed: TypedValue,
        /// The smallest legal value.
        low: u32,
        /// The largest legal value.
        high: u32,
    },
    /// The model refuses a preset adjustment to a value that it cannot show [R75].
    #[error("preset adjustment: {typed} is above the measuring length {}", .typed.like(*.length))]
    AboveLength {
        /// The value, in the base that was typed.
        typed: TypedValue,
        /// The measuring length in force.
        length: u32,
    },
    /// The model's manual does not list the service.
    #[error("a {model} has no service {:02X} ({})", .service.number(), .service.name())]
    Unknown {
        /// The service.
        service: Service,
        /// The model.
        model: Model,
    },
}

impl RequestError {
    const fn range(service: Service, typed: TypedValue, range: OutOfRange) -> Self {
        let OutOfRange { value, low, high } = range;
        Self::Range { service, typed: typed.like(value), low, high }
    }
}

impl Request {
    /// Reads a parameter.
    ///
    /// # Errors
    /// [`RequestError::Unknown`] if the model lacks it.
    pub const fn read(model: Model, parameter: Parameter) -> Result<Self, RequestError> {
        Self::known(model, Self { service: parameter.service(), access: Access::Read, data: 0 })
    }

    /// Programs a parameter. A numerator of 0 is refused as well: an encoder would store it, and show an error
    /// until it is corrected [C6]. Whether the measuring length allows a preset value is for the data check.
    ///
    /// # Errors
    /// [`RequestError`] if the model lacks it, or would refuse the value or show an error for it.
    pub fn write(
        model: Model,
        parameter: Parameter,
        value: impl Into<TypedValue>,
    ) -> Result<Self, RequestError> {
        let typed = value.into();
        let (service, value) = (parameter.service(), typed.number);
        let listed = model.lists(service).ok_or(RequestError::Unknown { service, model })?;
        let judged = match Legal::of(service, model) {
            Some(Legal::Whole { low, high }) => within(value, low, high),
            _ => within(value, 0, DATA_MAX).and_then(|value| listed.takes.normalise(value)),
        };
        match judged {
            Ok(_) => Ok(Self { service, access: Access::Write, data: value }),
            Err(range) => Err(RequestError::range(service, typed, range)),
        }
    }

    /// Makes the position equal to `value`. `length` is the active measuring length, above which some models refuse;
    /// others take any 24-bit value [R74, R75].
    ///
    /// # Errors
    /// [`RequestError`] above the limit, or if the model has no preset adjustment.
    pub fn preset(model: Model, value: impl Into<TypedValue>, length: u32) -> Result<Self, RequestError> {
        let typed = value.into();
        let service = Service::PresetAdjustment;
        let listed = model.lists(service).ok_or(RequestError::Unknown { service, model })?;
        match within(typed.number, 0, listed.takes.largest(length)) {
            Ok(data) => Ok(Self { service, access: Access::Write, data }),
            Err(_) if listed.takes == Takes::UpToMeasuringLength => {
                Err(RequestError::AboveLength { typed, length })
            }
            Err(range) => Err(RequestError::range(service, typed, range)),
        }
    }

    /// The data check; the LA-66 calls it "read error status" [R77, R78].
    #[must_use]
    pub const fn data_check() -> Self {
        Self { service: Service::DataCheck, access: Access::Read, data: 0 }
    }

    const fn known(model: Model, request: Self) -> Result<Self, RequestError> {
        let service = request.service;
        if service.known_to(model) { Ok(request) } else { Err(RequestError::Unknown { service, model }) }
    }

    /// The service.
    #[must_use]
    pub const fn service(self) -> Service {
        self.service
    }

    /// Read or write.
    #[must_use]
    pub const fn access(self) -> Access {
        self.access
    }

    /// What a write sends; 0 for a read.
    #[must_use]
    pub const fn data(self) -> u32 {
        self.data
    }

    /// `true` if carrying it out twice may do something else than once: a preset adjustment of a moving shaft.
    #[must_use]
    pub const fn moves_the_zero(self) -> bool {
        matches!(self.service, Service::PresetAdjustment)
    }

    /// Service and data with the service bit 0: what goes out first, and after the reply [R33, R38].
    #[must_use]
    pub fn rest(self) -> OutWord {
        OutWord::from(Out::Normal(self.word().0))
    }

    /// The same with the service bit.
    #[must_use]
    pub fn word(self) -> OutWord {
        OutWord::from(Out::Request(self.fields()))
    }

    /// What it asks for, for people.
    #[must_use]
    pub const fn deed(self) -> Deed {
        Deed::asked(self.fields())
    }

    const fn fields(self) -> ServiceFields {
        ServiceFields {
            access: self.access,
            error: false,
            reserve: false,
            service: ServiceNumber::Known(self.service),
            data: self.data,
        }
    }

    /// The reply, if `input` is one to this request: its upper byte apart from the error bit [C12], and for a write its
    /// data as well.
    #[must_use]
    pub fn answered_by(self, input: InWord) -> Option<Reply> {
        let In::Reply(reply) = input.decode() else { return None };
        let differs = (input.0 & !ERROR_BIT.mask()) ^ self.word().0;
        let wanted = match (self.access, self.service) {
            (Access::Write, _) => differs == 0,
            // Bits 23..16 of an error status are always 0 [R78].
            (Access::Read, Service::DataCheck) => differs <= 0xFFFF,
            (Access::Read, _) => differs <= DATA_MAX,
        };
        wanted.then_some(Reply { data: reply.data, error: reply.error })
    }
}

/// What an encoder replied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply {
    /// Bits 23..0.
    pub data: u32,
    /// Bit 29: an error is pending, be it of this service or of an earlier one [C23].
    pub error: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_goes_out_without_and_with_the_service_bit() {
        let request = Request::write(Model::Ce65M, Parameter::MeasuringLength, 0x270F).unwrap();
        assert_eq!((request.rest(), request.word()), (OutWord(0x4200_270F), OutWord(0xC200_270F)));
        let read = Request::read(Model::Ce65M, Parameter::MeasuringLength).unwrap();
        assert_eq!((read.rest(), read.word()), (OutWord(0x0200_0000), OutWord(0x8200_0000)));
        assert_eq!(Request::data_check().word(), OutWord(0x8800_0000));
    }

    #[test]
    fn the_answer_is_told_from_other_replies_with_the_error_bit_apart() {
        let write = Request::write(Model::Ce65M, Parameter::MeasuringLength, 0x270F).unwrap();
        let good = Reply { data: 0x270F, error: false };
        assert_eq!(write.answered_by(InWord(0xC200_270F)), Some(good));
        assert_eq!(write.answered_by(InWord(0xE200_270F)), Some(Reply { error: true, ..good }));
        for other in [0x4200_270F, 0xC200_270E, 0x8200_270F, 0xC300_270F, 0xD200_270F, 0x0000_270F] {
            assert_eq!(write.answered_by(InWord(other)), None, "{other:08X}");
        }
        let read = Request::read(Model::Ce65M, Parameter::MeasuringLength).unwrap();
        assert_eq!(read.answered_by(InWord(0x82FF_FFFF)), Some(Reply { data: 0xFF_FFFF, error: false }));
        assert_eq!(read.answered_by(InWord(0xA200_0000)), Some(Reply { data: 0, error: true }));
        assert_eq!(read.answered_by(InWord(0xC2FF_FFFF)), None);
        let check = Request::data_check();
        assert_eq!(check.answered_by(InWord(0x8800_0080)), Some(Reply { data: 0x80, error: false }));
        assert_eq!(check.answered_by(InWord(0xA800_4000)), Some(Reply { data: 0x4000, error: true }));
        assert_eq!(check.answered_by(InWord(0x8801_0000)), None);
    }

    #[test]
    fn what_an_encoder_would_refuse_is_no_request() {
        use Parameter as P;
        let write = |model, parameter, value| Request::write(model, parameter, value).map(Request::data);
        for (model, parameter, low, high) in [
            (Model::La66, P::CountingDirection, 0, 1),
            (Model::La66, P::MeasuringLength, 1, DATA_MAX),
            (Model::Ce100M, P::MeasuringLength, 0x10, DATA_MAX),
            (Model::Ce100M, P::Numerator, 1, 0xFFFF),
            (Model::Ce100M, P::PresetValue2, 0, DATA_MAX),
            (Model::Ce65M, P::Denominator, 1, 0x63),
            (Model::Ce65M, P::CountingDirection, 0, DATA_MAX),
            (Model::Ce65M, P::SsiValues, 0x08, 0x20),
        ] {
            assert_eq!(write(model, parameter, low), Ok(low));
            assert_eq!(write(model, parameter, high), Ok(high));
            let service = parameter.service();
            let beyond = [low.checked_sub(1), Some(high + 1)];
            for value in beyond.into_iter().flatten() {
                let error = write(model, parameter, value).unwrap_err();
                assert!(matches!(error, RequestError::Range { service: s, .. } if s == service), "{error:?}");
            }
        }
        assert_eq!(
            write(Model::Ce65M, P::PresetValue1, 0),
            Err(RequestError::Unknown { service: Service::PresetValue1, model: Model::Ce65M })
        );
    }

    #[test]
    fn a_preset_lies_within_the_measuring_length_but_on_a_rod() {
        assert_eq!(Request::preset(Model::Ce100M, 9_999, 9_999).map(Request::word), Ok(OutWord(0xC600_270F)));
        assert!(Request::preset(Model::Ce100M, 10_000, 9_999).is_err());
        assert!(Request::preset(Model::La66, DATA_MAX, 5_000).is_ok());
        assert!(Request::preset(Model::La66, DATA_MAX + 1, 5_000).is_err());
    }
}
