//! What each model makes of a word: which data a service takes, how a request is answered, and which IN words no
//! encoder sends.
//!
//! This looks at one word alone. What depends on more, such as the measuring length in force, is a variant that
//! says so.

use core::fmt;

use crate::model::{Demand, Takes};
use crate::parameter::OutOfRange;
use crate::service::{Access, Service};
use crate::word::{DATA, ERROR_BIT, In, InWord, ServiceFields, ServiceNumber};
use crate::{ErrorStatus, Model, Parameter};

mod wording;

pub use wording::{ByteMeaning, Deed, DirectionMeaning, Meaning, Values, access, effect, refusal};

/// The data that a service takes, as its manual lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legal {
    /// Bits 23..0 are one value, from `low` to `high`.
    Whole {
        /// The smallest legal value.
        low: u32,
        /// The largest legal value.
        high: u32,
    },
    /// Bits 23..0 are one value, from 0 to the measuring length in steps [R67, R75].
    UpToMeasuringLength,
    /// Each byte is a value of its own, from byte 2 down to byte 0 [R46, R113].
    Bytes([ByteField; 3]),
}

/// One byte of the data of services 01 and 0D on the CE-65-M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ByteField {
    /// 2 for bits 23..16, 1 for bits 15..8, 0 for bits 7..0.
    pub byte: u8,
    /// The manual's name; `None` for a byte without meaning.
    pub name: Option<&'static str>,
    /// The smallest legal value.
    pub low: u8,
    /// The largest legal value.
    pub high: u8,
}

impl ByteField {
    /// The byte's value in the data of a word.
    #[must_use]
    pub const fn of(self, data: u32) -> u8 {
        let [_, byte_2, byte_1, byte_0] = data.to_be_bytes();
        match self.byte {
            2 => byte_2,
            1 => byte_1,
            _ => byte_0,
        }
    }
}

const fn any(byte: u8, name: Option<&'static str>) -> ByteField {
    ByteField { byte, name, low: 0, high: 0xFF }
}

const DIRECTION_BYTES: [ByteField; 3] =
    [any(2, None), any(1, Some("code")), any(0, Some("counting direction"))];

const fn ssi_bytes(fewest_bits: u8, most_bits: u8) -> [ByteField; 3] {
    let bits = ByteField { byte: 0, name: Some("number of data bits"), low: fewest_bits, high: most_bits };
    [any(2, Some("repetition")), any(1, Some("code")), bits]
}

impl Legal {
    /// The data that a service of a model takes; `None` if the model lacks it, and for the data check, whose data
    /// have no meaning in a request.
    #[must_use]
    pub const fn of(service: Service, model: Model) -> Option<Self> {
        let Some(listed) = model.lists(service) else { return None };
        Some(match listed.takes {
            Takes::Nothing => return None,
            // A numerator of 0 is stored all the same, see `Answer::Invalid`.
            Takes::Number { low: 0, high, demand: Demand::NotZero(_) } => Self::Whole { low: 1, high },
            Takes::Number { demand: Demand::UpToMeasuringLength(_), .. } | Takes::UpToMeasuringLength => {
                Self::UpToMeasuringLength
            }
            Takes::Number { low, high, .. } => Self::Whole { low, high },
            Takes::DirectionAndCode => Self::Bytes(DIRECTION_BYTES),
            Takes::SsiValues { fewest_bits, most_bits } => Self::Bytes(ssi_bytes(fewest_bits, most_bits)),
        })
    }
}

/// The range as people read it; nothing where each byte is a value of its own.
impl fmt::Display for Legal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole { low, high } => write!(f, "{low:X}h..{high:X}h ({low}..{high})"),
            Self::UpToMeasuringLength => f.write_str("0..measuring length in steps (service 02)"),
            Self::Bytes(_) => Ok(()),
        }
    }
}

/// What becomes of a request. A status is masked with what the model may show [R94, R95], so on the LA-66 it is
/// empty: the error bit is then all there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// It is carried out.
    Done,
    /// It is carried out up to the measuring length in force, and refused above it [R75, C30].
    RefusedAboveLength {
        /// What the next data check shows if it was refused.
        status: ErrorStatus,
    },
    /// It is carried out; the data check compares the value with the measuring length [R70, R90].
    CheckedAgainstLength {
        /// What the data check shows if the value is above it.
        status: ErrorStatus,
    },
    /// The value is stored, but the error bit is set at once [R92, C6].
    Invalid {
        /// What each data check shows until the value is corrected.
        status: ErrorStatus,
    },
    /// It is refused: the error bit is set, and nothing else happens [C6, C14].
    Refused {
        /// What the next data check shows.
        status: ErrorStatus,
    },
}

impl Answer {
    /// What a sound encoder of a model makes of a request.
    #[must_use]
    pub fn to(request: ServiceFields, model: Model) -> Self {
        let shown = |status: ErrorStatus| status & model.status_mask();
        let takes = match model.admits(request.service, request.access) {
            Ok(_) if request.access == Access::Read => return Self::Done,
            Ok(listed) => listed.takes,
            Err(status) => return Self::Refused { status: shown(status) },
        };
        let data = DATA.of(request.data);
        if takes.normalise(data).is_err() {
            return Self::Refused { status: shown(ErrorStatus::WRITING_DATA) };
        }
        match takes {
            Takes::UpToMeasuringLength => {
                Self::RefusedAboveLength { status: shown(ErrorStatus::WRITING_DATA) }
            }
            Takes::Number { demand: Demand::UpToMeasuringLength(status), .. } => {
                Self::CheckedAgainstLength { status: shown(status) }
            }
            _ => match takes.invalid(data) {
                fine if fine.is_empty() => Self::Done,
                status => Self::Invalid { status: shown(status) },
            },
        }
    }

    /// `true` if the reply carries the error bit, whatever else the encoder is set to.
    #[must_use]
    pub const fn sets_error_bit(self) -> bool {
        matches!(self, Self::Invalid { .. } | Self::Refused { .. })
    }
}

/// Why no encoder of a model sends an IN word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// The service bit is 0, yet bits beside the position and the error bit are set [R24].
    UpperBits {
        /// These bits, in their place.
        bits: u32,
    },
    /// Bit 28 is set [R20].
    Reserve,
    /// The request is one that sets the error bit, yet the error bit is 0 [R19].
    NoErrorBit,
    /// The read is refused, yet data are returned [C14].
    DataOfRefusedRead,
    /// Bits 23..16 of an error status are set [R77, R78].
    StatusByte,
    /// The error status has bits that are always 0 on this model [R94, R95].
    StatusBits {
        /// These bits.
        bits: u16,
    },
    /// The value that is read lies outside what is ever stored.
    Value(OutOfRange),
    /// A byte of the value that is read is stored as 0 or 1 only, or is never stored [R47, R114].
    Bytes {
        /// The data as an encoder would return them.
        stored: u32,
    },
}

impl Foreign {
    /// Looks for a reason why no encoder of a model sends the word; any reply may carry the error bit, because it
    /// stays set until the data check [R28].
    ///
    /// # Errors
    /// The first reason found.
    pub fn judge(word: InWord, model: Model) -> Result<(), Self> {
        let reply = match word.decode() {
            In::Position { .. } => return Ok(()),
            In::Foreign(word) => {
                return Err(Self::UpperBits { bits: word & !(DATA.mask() | ERROR_BIT.mask()) });
            }
            In::Reply(reply) => reply,
        };
        if reply.reserve {
            return Err(Self::Reserve);
        }
        let refused = Answer::to(reply, model).sets_error_bit();
        if refused && !reply.error {
            return Err(Self::NoErrorBit);
        }
        if reply.access == Access::Write {
            return Ok(());
        }
        if reply.data == 0 && reply.error {
            // A refused read, or a record of the EEPROM that cannot be read.
            return Ok(());
        }
        if refused {
            return Err(Self::DataOfRefusedRead);
        }
        match reply.service {
            ServiceNumber::Known(Service::DataCheck) => Self::judge_status(reply.data, model),
            ServiceNumber::Known(service) => match Parameter::from_service(service) {
                Some(parameter) => Self::judge_value(parameter, reply.data, model),
                None => Ok(()),
            },
            ServiceNumber::Unknown(_) => Ok(()),
        }
    }

    const fn judge_status(data: u32, model: Model) -> Result<(), Self> {
        let bits = data as u16 & !model.status_mask().bits();
        if data > 0xFFFF {
            Err(Self::StatusByte)
        } else if bits != 0 {
            Err(Self::StatusBits { bits })
        } else {
            Ok(())
        }
    }

    const fn judge_value(parameter: Parameter, data: u32, model: Model) -> Result<(), Self> {
        match parameter.normalise(model, data) {
            Ok(stored) if stored == data => Ok(()),
            Ok(stored) => Err(Self::Bytes { stored }),
            Err(range) => Err(Self::Value(range)),
        }
    }
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UpperBits { bits } => {
                f.write_str("with the service bit 0 these bits are always 0:")?;
                powers(*bits, f)
            }
            Self::Reserve => f.write_str("the reserve, bit 2^28, is always 0"),
            Self::NoErrorBit => f.write_str("this service sets the error bit, so it would be 1"),
            Self::DataOfRefusedRead => f.write_str("a refused read returns data 0"),
            Self::StatusByte => f.write_str("bits 2^23..2^16 of an error status are always 0"),
            Self::StatusBits { bits } => {
                f.write_str("these bits of its error status are always 0:")?;
                powers((*bits).into(), f)
            }
            Self::Value(range) => write!(f, "value {range}"),
            Self::Bytes { stored } => write!(f, "the value stored would read {stored:06X}h"),
        }
    }
}

/// ` 2^24 2^30`, from the highest bit down.
fn powers(bits: u32, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    (0..32).rev().filter(|bit| bits >> bit & 1 == 1).try_for_each(|bit| write!(f, " 2^{bit}"))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::model::MODELS;
    use crate::service::SERVICES;
    use crate::word::{DATA_MAX, Out, OutWord};
    use proptest::prelude::*;
    use std::string::ToString;

    fn answer(word: u32, model: Model) -> Answer {
        let Out::Request(request) = OutWord(word).decode() else { panic!("{word:08X} is a request") };
        Answer::to(request, model)
    }

    #[test]
    fn a_range_exists_exactly_for_the_services_that_take_data() {
        for model in MODELS {
            for service in SERVICES {
                let takes_data = service.known_to(model) && service != Service::DataCheck;
                assert_eq!(Legal::of(service, model).is_some(), takes_data, "{service:?} {model}");
            }
        }
    }

    #[test]
    fn the_ranges_are_those_of_the_manuals() {
        let whole = |low, high| Some(Legal::Whole { low, high });
        assert_eq!(Legal::of(Service::CountingDirection, Model::Ce100M), whole(0, 1));
        assert_eq!(Legal::of(Service::MeasuringLength, Model::La66), whole(1, DATA_MAX));
        assert_eq!(Legal::of(Service::MeasuringLength, Model::Ce65M), whole(0x10, DATA_MAX));
        assert_eq!(Legal::of(Service::Numerator, Model::Ce65M), whole(1, 0xFFFF));
        assert_eq!(Legal::of(Service::Denominator, Model::Ce65M), whole(1, 0x63));
        assert_eq!(Legal::of(Service::PresetValue1, Model::La66), whole(0, DATA_MAX));
        assert_eq!(Legal::of(Service::PresetValue1, Model::Ce100M), Some(Legal::UpToMeasuringLength));
        let Some(Legal::Bytes([_, _, bits])) = Legal::of(Service::SsiValues, Model::Ce65M) else {
            panic!("bytes");
        };
        assert_eq!((bits.low, bits.high, bits.of(0x01_02_18)), (0x08, 0x20, 0x18));
        assert_eq!(ssi_bytes(8, 32).map(|byte| byte.of(0x01_02_18)), [0x01, 0x02, 0x18]);
    }

    #[test]
    fn requests_are_answered_as_the_manuals_say() {
        use ErrorStatus as E;
        let ce = Model::Ce100M;
        assert_eq!(answer(0xC200_270F, ce), Answer::Done);
        assert_eq!(answer(0xC200_000F, ce), Answer::Refused { status: E::WRITING_DATA });
        assert_eq!(answer(0xC200_000F, Model::La66), Answer::Done);
        assert_eq!(answer(0xC200_0000, Model::La66), Answer::Refused { status: E::empty() });
        assert_eq!(answer(0xC300_0000, ce), Answer::Invalid { status: E::NUMERATOR_ZERO });
        assert_eq!(answer(0xC300_000A, ce), Answer::Done);
        assert_eq!(answer(0xC500_0001, ce), Answer::CheckedAgainstLength { status: E::PRESET_2_RANGE });
        assert_eq!(answer(0xC400_0001, ce), Answer::CheckedAgainstLength { status: E::PRESET_1_RANGE });
        assert_eq!(answer(0xC600_0001, ce), Answer::RefusedAboveLength { status: E::WRITING_DATA });
        assert_eq!(answer(0xC600_0001, Model::La66), Answer::Done);
        assert_eq!(answer(0x8600_0000, ce), Answer::Refused { status: E::ONLY_WRITING });
        assert_eq!(answer(0xC800_0000, ce), Answer::Refused { status: E::ONLY_READING });
        assert_eq!(answer(0x8700_0000, ce), Answer::Refused { status: E::UNKNOWN_COMMAND });
        assert_eq!(answer(0x8D00_0000, ce), Answer::Refused { status: E::UNKNOWN_COMMAND });
        assert_eq!(answer(0x8D00_0000, Model::Ce65M), Answer::Done);
    }

    #[test]
    fn words_that_no_encoder_sends_are_found_with_their_reason() {
        let why = |word, model| Foreign::judge(InWord(word), model).map_err(|foreign| foreign.to_string());
        let ce = Model::Ce65M;
        for good in
            [0x0000_270F, 0x2000_270F, 0x8200_270F, 0xA200_270F, 0xA200_0000, 0x8800_6080, 0xE700_0001]
        {
            assert_eq!(why(good, ce), Ok(()), "{good:08X}");
        }
        for (bad, reason) in [
            (0x4100_0000, "with the service bit 0 these bits are always 0: 2^30 2^24"),
            (0x6100_0001, "with the service bit 0 these bits are always 0: 2^30 2^24"),
            (0x9200_270F, "the reserve, bit 2^28, is always 0"),
            (0x8700_0000, "this service sets the error bit, so it would be 1"),
            (0xC200_000F, "this service sets the error bit, so it would be 1"),
            (0xA700_0001, "a refused read returns data 0"),
            (0x8801_0000, "bits 2^23..2^16 of an error status are always 0"),
            (
                0x8800_FFFF,
                "these bits of its error status are always 0: 2^15 2^12 2^11 2^10 2^9 2^8 2^6 2^5 2^4",
            ),
            (0x8800_0120, "these bits of its error status are always 0: 2^8 2^5"),
            (0x8200_000F, "value Fh is outside 10h..FFFFFFh"),
            (0x8101_FF00, "the value stored would read 000100h"),
        ] {
            assert_eq!(why(bad, ce), Err(reason.to_string()), "{bad:08X}");
        }
        assert_eq!(
            why(0x8800_0120, Model::La66).unwrap_err(),
            "these bits of its error status are always 0: 2^8"
        );
    }

    proptest! {
        #[test]
        fn any_word_is_judged_without_a_panic(word: u32) {
            for model in MODELS {
                let _ = Foreign::judge(InWord(word), model);
                if let Out::Request(request) = OutWord(word).decode() {
                    let _ = Answer::to(request, model);
                }
            }
        }
    }
}
