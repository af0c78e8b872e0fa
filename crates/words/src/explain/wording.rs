//! The same for people: what a request does, why it is refused, what a value means.

use core::fmt;

use super::{ByteField, Legal};
use crate::model::{Effect, SensorKind};
use crate::parameter::{Code, CountingDirection, Direction, SsiValues};
use crate::service::{Access, Service};
use crate::ssi_frame::AK40_BITS;
use crate::word::{ServiceFields, ServiceNumber};
use crate::{ErrorStatus, Model, Parameter};

/// What a request asks for or a reply answers: `write measuring length in steps = 9999`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deed {
    service: ServiceNumber,
    access: Access,
    /// `None` where it has no meaning.
    data: Option<u32>,
}

impl Deed {
    /// What a request asks for; the data of a read have no meaning.
    #[must_use]
    pub const fn asked(request: ServiceFields) -> Self {
        let ServiceFields { service, access, data, .. } = request;
        let data = match access {
            Access::Read => None,
            Access::Write => Some(data),
        };
        Self { service, access, data }
    }

    /// What a reply answers.
    #[must_use]
    pub const fn answered(reply: ServiceFields) -> Self {
        Self { service: reply.service, access: reply.access, data: Some(reply.data) }
    }
}

impl fmt::Display for Deed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let access = access(self.access);
        let service = match self.service {
            ServiceNumber::Known(service) => service,
            ServiceNumber::Unknown(number) => {
                return write!(f, "{access} service {number:02X}, which no encoder has");
            }
        };
        let name = service.name();
        match (service, self.access, self.data) {
            (Service::DataCheck, Access::Read, _) => f.write_str(name),
            (Service::PresetAdjustment, Access::Write, Some(data)) => write!(f, "{name} to {data}"),
            (Service::DataCheck | Service::PresetAdjustment, ..) | (_, _, None) => {
                write!(f, "{access} {name}")
            }
            (Service::CountingDirection | Service::SsiValues, _, Some(data)) => {
                write!(f, "{access} {name} = {data:06X}h")
            }
            (_, _, Some(data)) => write!(f, "{access} {name} = {data}"),
        }
    }
}

/// `read` or `write`.
#[must_use]
pub const fn access(access: Access) -> &'static str {
    match access {
        Access::Read => "read",
        Access::Write => "write",
    }
}

/// What a model does with a request that it does not refuse, in a line or two.
#[must_use]
pub const fn effect(request: ServiceFields, model: Model) -> &'static [&'static str] {
    match (request.service, request.access, model.effect()) {
        (ServiceNumber::Known(Service::DataCheck), _, Effect::AtOnce) => {
            &["returns the error status and clears the error bit"]
        }
        (ServiceNumber::Known(Service::DataCheck), _, Effect::AtDataCheck) => &[
            "checks the programmed values and takes them over",
            "returns the error status and clears the error bit",
        ],
        (_, Access::Read, _) => &["returns the programmed value"],
        (ServiceNumber::Known(Service::PresetAdjustment), ..) | (_, _, Effect::AtOnce) => {
            &["takes effect at once"]
        }
        (_, _, Effect::AtDataCheck) => {
            &["takes effect with the data check (88000000) or with power off and on"]
        }
    }
}

/// Why a model refuses a request, and what would be right.
#[must_use]
pub const fn refusal(request: ServiceFields, model: Model) -> &'static str {
    match model.admits(request.service, request.access) {
        Ok(_) => "outside the range; the old value stays",
        Err(ErrorStatus::ONLY_READING) => "only reading allowed: set bit 2^30 (read-write bit) to 0",
        Err(ErrorStatus::ONLY_WRITING) => "only writing allowed: set bit 2^30 (read-write bit) to 1",
        Err(_) => "does not have this service: check the service number",
    }
}

/// What a counting direction means; `{:#}` says it at length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectionMeaning {
    /// The direction.
    pub direction: Direction,
    /// Whose.
    pub model: Model,
}

impl fmt::Display for DirectionMeaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.model.sensor_kind(), self.direction) {
            (SensorKind::Linear, Direction::Rising) => "increasing towards the end of the rod",
            (SensorKind::Linear, Direction::Falling) => "decreasing towards the end of the rod",
            (SensorKind::Rotary, Direction::Rising) => "rising clockwise",
            (SensorKind::Rotary, Direction::Falling) => "falling clockwise",
        })?;
        let seen = f.alternate() && self.model.sensor_kind() == SensorKind::Rotary;
        if seen { f.write_str(", looking at the shaft") } else { Ok(()) }
    }
}

/// What a value of a parameter means, where it is more than a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Of service 01.
    Direction {
        /// The direction.
        direction: DirectionMeaning,
        /// The code of the position, where it can be chosen.
        code: Option<Code>,
    },
    /// Of service 0D.
    Ssi(SsiValues),
}

impl Meaning {
    /// The meaning of a value that a model stores; `None` if it is a number and no more.
    #[must_use]
    pub fn of(parameter: Parameter, model: Model, value: u32) -> Option<Self> {
        match parameter {
            Parameter::CountingDirection => {
                let CountingDirection { direction, code } = CountingDirection::from_data(value);
                let direction = DirectionMeaning { direction, model };
                Some(Self::Direction { direction, code: model.position_may_be_gray().then_some(code) })
            }
            Parameter::SsiValues => Some(Self::Ssi(SsiValues::from_data(value))),
            _ => None,
        }
    }
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let code_name = |code| match code {
            Code::Binary => "binary",
            Code::Gray => "Gray code",
        };
        match *self {
            Self::Direction { direction, code: None } => direction.fmt(f),
            Self::Direction { direction, code: Some(code) } => write!(f, "{direction}, {}", code_name(code)),
            Self::Ssi(SsiValues { repetition, code, bits }) => {
                write!(f, "{bits} bits, {}", code_name(code))?;
                f.write_str(if repetition { ", repeated" } else { "" })?;
                if bits == AK40_BITS { write!(f, ", {AK40}") } else { Ok(()) }
            }
        }
    }
}

/// What the number of data bits 31 stands for, and where [R117].
const AK40: &str = "the AK-40 format (firmware from week 41/1997)";

/// What one byte of the data of a service means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ByteMeaning {
    /// The service, 01 or 0D.
    pub service: Service,
    /// The byte.
    pub byte: ByteField,
    /// The data that hold it.
    pub data: u32,
    /// Whose.
    pub model: Model,
}

impl fmt::Display for ByteMeaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { service, byte, data, model } = *self;
        let SsiValues { repetition, bits, .. } = SsiValues::from_data(data);
        match (service, byte.byte) {
            (Service::CountingDirection, 0) => {
                let CountingDirection { direction, .. } = CountingDirection::from_data(data);
                write!(f, "{:#}", DirectionMeaning { direction, model })
            }
            (_, 1) => f.write_str(match Code::from_byte(byte.of(data)) {
                Code::Binary => "binary",
                Code::Gray => "Gray",
            }),
            (Service::SsiValues, 2) => f.write_str(if repetition { "with" } else { "without" }),
            (Service::SsiValues, 0) => match bits {
                bits if bits < byte.low || bits > byte.high => write!(f, "{bits}, outside"),
                24 => f.write_str("24"),
                bits if repetition => write!(f, "{bits}, but the repetition makes it 24"),
                AK40_BITS => write!(f, "31, {AK40}"),
                bits => bits.fmt(f),
            },
            _ => Ok(()),
        }
    }
}

/// The legal values of a service and what they mean; nothing for a service that takes none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Values {
    /// The service.
    pub service: Service,
    /// Whose.
    pub model: Model,
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { service, model } = *self;
        match Legal::of(service, model) {
            None => Ok(()),
            Some(Legal::Bytes(bytes)) => bytes.iter().enumerate().try_for_each(|(at, byte)| {
                f.write_str(if at == 0 { "" } else { "; " })?;
                self.byte(*byte, f)
            }),
            Some(Legal::Whole { .. }) if service == Service::CountingDirection => {
                let [rising, falling] = [Direction::Rising, Direction::Falling]
                    .map(|direction| DirectionMeaning { direction, model });
                write!(f, "0: {rising:#}; 1: {falling:#}")
            }
            Some(legal) => legal.fmt(f),
        }
    }
}

impl Values {
    fn byte(&self, byte: ByteField, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { service, model } = *self;
        let ByteField { byte: number, name, low, high } = byte;
        let Some(name) = name else { return write!(f, "byte {number}: without meaning") };
        let meaning = |value: u8| {
            let data = u32::from(value) << (8 * u32::from(number));
            ByteMeaning { service, byte, data, model }
        };
        write!(f, "byte {number}, {name}: ")?;
        match (low, high) {
            (0, 0xFF) => write!(f, "0 {}, 1h..FFh {}", meaning(0), meaning(1)),
            _ => write!(f, "{low:X}h..{high:X}h ({low}..{high}); {AK40_BITS:X}h: {}", meaning(AK40_BITS)),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    fn request(access: Access, service: ServiceNumber, data: u32) -> ServiceFields {
        ServiceFields { access, error: false, reserve: false, service, data }
    }

    #[test]
    fn a_deed_says_what_is_asked_and_what_is_answered() {
        let known = ServiceNumber::Known;
        let asked = |service, access| Deed::asked(request(access, service, 5_000)).to_string();
        assert_eq!(asked(known(Service::Numerator), Access::Write), "write revolutions numerator = 5000");
        assert_eq!(asked(known(Service::Numerator), Access::Read), "read revolutions numerator");
        assert_eq!(asked(known(Service::PresetAdjustment), Access::Write), "preset adjustment to 5000");
        assert_eq!(asked(known(Service::PresetAdjustment), Access::Read), "read preset adjustment");
        assert_eq!(asked(known(Service::DataCheck), Access::Read), "data check");
        assert_eq!(
            asked(known(Service::SsiValues), Access::Write),
            "write SSI characteristic values = 001388h"
        );
        assert_eq!(asked(ServiceNumber::Unknown(7), Access::Read), "read service 07, which no encoder has");
        let answered = Deed::answered(request(Access::Read, known(Service::Numerator), 10));
        assert_eq!(answered.to_string(), "read revolutions numerator = 10");
    }

    #[test]
    fn a_direction_means_what_the_sensor_makes_of_it() {
        let meaning =
            |model, value| Meaning::of(Parameter::CountingDirection, model, value).unwrap().to_string();
        assert_eq!(meaning(Model::La66, 0), "increasing towards the end of the rod");
        assert_eq!(meaning(Model::Ce100M, 1), "falling clockwise");
        assert_eq!(meaning(Model::Ce65M, 0x0100), "rising clockwise, Gray code");
        let seen = DirectionMeaning { direction: Direction::Rising, model: Model::Ce65M };
        assert_eq!(std::format!("{seen:#}"), "rising clockwise, looking at the shaft");
        assert_eq!(meaning(Model::Ce65M, 0), "rising clockwise, binary");
        let ssi = |value| Meaning::of(Parameter::SsiValues, Model::Ce65M, value).unwrap().to_string();
        assert_eq!(ssi(0x01_01_18), "24 bits, Gray code, repeated");
        assert_eq!(ssi(0x1F), "31 bits, binary, the AK-40 format (firmware from week 41/1997)");
        assert_eq!(Meaning::of(Parameter::Numerator, Model::Ce65M, 1), None);
    }

    #[test]
    fn the_values_of_a_service_stand_with_their_meaning() {
        let values = |service, model| Values { service, model }.to_string();
        assert_eq!(values(Service::MeasuringLength, Model::Ce65M), "10h..FFFFFFh (16..16777215)");
        assert_eq!(
            values(Service::CountingDirection, Model::La66),
            "0: increasing towards the end of the rod; 1: decreasing towards the end of the rod"
        );
        assert_eq!(
            values(Service::PresetAdjustment, Model::Ce65M),
            "0..measuring length in steps (service 02)"
        );
        assert_eq!(
            values(Service::CountingDirection, Model::Ce65M),
            "byte 2: without meaning; byte 1, code: 0 binary, 1h..FFh Gray; byte 0, counting direction: 0 rising \
             clockwise, looking at the shaft, 1h..FFh falling clockwise, looking at the shaft"
        );
        assert_eq!(
            values(Service::SsiValues, Model::Ce65M),
            "byte 2, repetition: 0 without, 1h..FFh with; byte 1, code: 0 binary, 1h..FFh Gray; byte 0, number of \
             data bits: 8h..20h (8..32); 1Fh: 31, the AK-40 format (firmware from week 41/1997)"
        );
        assert_eq!(values(Service::DataCheck, Model::Ce65M), "");
    }

    #[test]
    fn a_refusal_names_what_would_be_right() {
        let refused =
            |access, service, model| refusal(request(access, ServiceNumber::Known(service), 0), model);
        assert!(refused(Access::Write, Service::DataCheck, Model::Ce65M).ends_with("(read-write bit) to 0"));
        assert!(
            refused(Access::Read, Service::PresetAdjustment, Model::La66).ends_with("(read-write bit) to 1")
        );
        assert!(
            refused(Access::Read, Service::Numerator, Model::La66).starts_with("does not have this service")
        );
        assert!(refused(Access::Write, Service::Denominator, Model::Ce65M).starts_with("outside the range"));
    }
}
