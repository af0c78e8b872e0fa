//! What shall become of a parameter: all of it, or parts of it by name.
//!
//! Counting direction and SSI values are bytes, each with a meaning of its own. Whoever changes one means that one,
//! so the others are read and written back as they are.

use core::fmt;

use crate::Model;
use crate::model::Takes;
use crate::number::{self, NumberError, TypedValue};
use crate::parameter::{Code, Parameter};
use crate::word::DATA_MAX;

/// A byte of a parameter that has a meaning of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterPart {
    /// Counting direction, byte 0 [R42].
    Direction,
    /// Counting direction, byte 1: the code of the position on the bus [R46].
    PositionCode,
    /// SSI values, byte 0: the number of data bits [R113].
    SsiBits,
    /// SSI values, byte 1: the code on the SSI [R113].
    SsiCode,
    /// SSI values, byte 2: whether the data come again [R113].
    SsiRepetition,
}

/// Every part.
pub const PARTS: [ParameterPart; 5] = [
    ParameterPart::Direction,
    ParameterPart::PositionCode,
    ParameterPart::SsiBits,
    ParameterPart::SsiCode,
    ParameterPart::SsiRepetition,
];

impl ParameterPart {
    /// The parameter that it is part of.
    #[must_use]
    pub const fn parameter(self) -> Parameter {
        match self {
            Self::Direction | Self::PositionCode => Parameter::CountingDirection,
            Self::SsiBits | Self::SsiCode | Self::SsiRepetition => Parameter::SsiValues,
        }
    }

    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Direction => "direction",
            Self::PositionCode => "position_code",
            Self::SsiBits => "ssi_bits",
            Self::SsiCode => "ssi_code",
            Self::SsiRepetition => "ssi_repetition",
        }
    }

    /// Its name within its parameter, as files have it.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Direction => "direction",
            Self::PositionCode | Self::SsiCode => "code",
            Self::SsiBits => "bits",
            Self::SsiRepetition => "repetition",
        }
    }

    const fn shift(self) -> u32 {
        match self {
            Self::Direction | Self::SsiBits => 0,
            Self::PositionCode | Self::SsiCode => 8,
            Self::SsiRepetition => 16,
        }
    }

    const fn mask(self) -> u32 {
        0xFF << self.shift()
    }

    /// The words of a byte of 0 and of a byte of 1; none for a number.
    #[must_use]
    pub const fn words(self) -> Option<[&'static str; 2]> {
        match self {
            Self::Direction => Some(["rising", "falling"]),
            Self::PositionCode | Self::SsiCode => Some([Code::Binary.name(), Code::Gray.name()]),
            Self::SsiRepetition => Some(["false", "true"]),
            Self::SsiBits => None,
        }
    }

    /// The parts of a parameter that a model gives a meaning.
    pub fn of(parameter: Parameter, model: Model) -> impl Iterator<Item = Self> + Clone {
        let known = model.lists(parameter.service()).map(|listed| listed.takes);
        PARTS.into_iter().filter(move |part| {
            let coded = matches!(known, Some(Takes::DirectionAndCode | Takes::SsiValues { .. }));
            part.parameter() == parameter && (coded || (known.is_some() && *part == Self::Direction))
        })
    }

    /// The part of a parameter that `bits=25`, or one of its words, speaks of, and what it says.
    fn written(parameter: Parameter, piece: &str) -> Option<(Self, &str)> {
        let mut parts = PARTS.into_iter().filter(|part| part.parameter() == parameter);
        if let Some((key, text)) = piece.split_once('=') {
            return parts.find(|part| part.key().eq_ignore_ascii_case(key.trim())).map(|part| (part, text));
        }
        let is = |word: &&str| word.eq_ignore_ascii_case(piece.trim());
        parts.find(|part| part.words().is_some_and(|words| words.iter().any(is))).map(|part| (part, piece))
    }

    /// What it is in the data of its parameter, as files and the command line have it.
    #[must_use]
    pub const fn shown(self, data: u32) -> PartShown {
        PartShown { part: self, byte: (data >> self.shift()) as u8 }
    }
}

/// A part with its byte: `falling`, `gray`, `25`, `true`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartShown {
    part: ParameterPart,
    byte: u8,
}

impl PartShown {
    /// Its bits in the data of its parameter.
    #[must_use]
    pub const fn data(self) -> u32 {
        (self.byte as u32) << self.part.shift()
    }

    /// The word that stands for the byte, if it has words.
    #[must_use]
    pub fn word(self) -> Option<&'static str> {
        self.part.words().and_then(|words| words.get(usize::from(self.byte)).copied())
    }
}

impl fmt::Display for PartShown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.word() {
            Some(word) => f.write_str(word),
            None => self.byte.fmt(f),
        }
    }
}

/// Why a part of a parameter was not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartError<'a> {
    /// Neither of its two words.
    Word {
        /// Which part.
        part: ParameterPart,
        /// What stands there.
        found: &'a str,
        /// The two.
        words: [&'static str; 2],
    },
    /// No number.
    Number(NumberError<'a>),
    /// Said before, in the same value.
    Twice {
        /// Which part.
        part: ParameterPart,
    },
    /// More than a byte.
    Above {
        /// What was written.
        found: TypedValue,
    },
}

impl core::error::Error for PartError<'_> {}

impl fmt::Display for PartError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word { part, found, words: [zero, one] } => {
                write!(f, "{}: {} is not {zero} or {one}", part.name(), number::Excerpt(found))
            }
            Self::Number(error) => error.fmt(f),
            Self::Twice { part } => write!(f, "{} is said twice; say it once", part.name()),
            Self::Above { found } => {
                write!(f, "{found} is above {}, the largest of a byte", found.like(0xFF))
            }
        }
    }
}

/// What shall become of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterChange {
    value: TypedValue,
    mask: u32,
}

impl From<TypedValue> for ParameterChange {
    fn from(value: TypedValue) -> Self {
        Self { value, mask: DATA_MAX }
    }
}

impl From<u32> for ParameterChange {
    fn from(number: u32) -> Self {
        TypedValue::from(number).into()
    }
}

impl ParameterChange {
    /// One part, as people write it.
    ///
    /// # Errors
    /// [`PartError`].
    pub fn part(part: ParameterPart, text: &str) -> Result<Self, PartError<'_>> {
        let found = text.trim();
        let value = match part.words() {
            Some(words) => {
                let place = words.iter().position(|word| word.eq_ignore_ascii_case(found));
                let place = place.ok_or(PartError::Word { part, found, words })?;
                TypedValue::from(place as u32)
            }
            None => number::value(found).map_err(PartError::Number)?,
        };
        if value.number > 0xFF {
            return Err(PartError::Above { found: value });
        }
        Ok(Self { value: value.like(value.number << part.shift()), mask: part.mask() })
    }

    /// What shall become of a parameter: a value, or parts with their names or words: `falling`, `code=gray, bits=25`.
    ///
    /// # Errors
    /// [`PartError`].
    pub fn read(parameter: Parameter, text: &str) -> Result<Self, PartError<'_>> {
        if !text.split(',').all(|piece| ParameterPart::written(parameter, piece).is_some()) {
            return number::value(text).map(Self::from).map_err(PartError::Number);
        }
        let none = Self { value: TypedValue::from(0), mask: 0 };
        let mut parts = text.split(',').filter_map(|piece| ParameterPart::written(parameter, piece));
        parts.try_fold(none, |all, (part, text)| match all.changes(part) {
            true => Err(PartError::Twice { part }),
            false => Ok(all.and(Self::part(part, text)?)),
        })
    }

    /// This and another part of the same parameter.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self { value: other.of(self.value.number), mask: self.mask | other.mask }
    }

    /// All of it, if it names every part that the model has.
    #[must_use]
    pub fn completed(self, parameter: Parameter, model: Model) -> Self {
        let parts = ParameterPart::of(parameter, model).fold(0, |mask, part| mask | part.mask());
        if parts != 0 && self.mask & parts == parts { Self { mask: DATA_MAX, ..self } } else { self }
    }

    /// A part that it names and that the model gives no meaning.
    #[must_use]
    pub fn unknown_part(self, parameter: Parameter, model: Model) -> Option<ParameterPart> {
        let named = |part: &ParameterPart| part.parameter() == parameter && self.changes(*part);
        let known = |part: &ParameterPart| ParameterPart::of(parameter, model).any(|known| known == *part);
        PARTS.into_iter().find(|part| !self.is_whole() && named(part) && !known(part))
    }

    /// `true` if it says what shall become of a part.
    #[must_use]
    pub const fn changes(self, part: ParameterPart) -> bool {
        self.mask & part.mask() == part.mask()
    }

    /// `true` if nothing of the old value stays.
    #[must_use]
    pub const fn is_whole(self) -> bool {
        self.mask == DATA_MAX
    }

    /// The new data beside the old ones, in the base that was typed.
    #[must_use]
    pub const fn of(self, before: u32) -> TypedValue {
        self.value.like(before & !self.mask & DATA_MAX | self.value.number)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::ToString;

    use super::*;
    use crate::model::MODELS;
    use crate::parameter::PARAMETERS;

    #[test]
    fn a_part_changes_its_byte_and_no_other() {
        let changed = |part, text, before| ParameterChange::part(part, text).unwrap().of(before).number;
        assert_eq!(changed(ParameterPart::SsiBits, "25", 0x01_01_18), 0x01_01_19);
        assert_eq!(changed(ParameterPart::SsiBits, "19h", 0x01_01_18), 0x01_01_19);
        assert_eq!(changed(ParameterPart::SsiCode, "Gray", 0x18), 0x01_18);
        assert_eq!(changed(ParameterPart::SsiCode, "binary", 0x01_01_18), 0x01_00_18);
        assert_eq!(changed(ParameterPart::SsiRepetition, "true", 0x01_18), 0x01_01_18);
        assert_eq!(changed(ParameterPart::Direction, " falling ", 0x01_00), 0x01_01);
        assert_eq!(changed(ParameterPart::PositionCode, "GRAY", 0x01), 0x01_01);
    }

    #[test]
    fn a_parameter_is_written_as_a_value_or_by_its_parts() {
        let read =
            |parameter, text, before| ParameterChange::read(parameter, text).unwrap().of(before).number;
        let (direction, ssi) = (Parameter::CountingDirection, Parameter::SsiValues);
        assert_eq!(read(direction, "falling", 0x01_00), 0x01_01);
        assert_eq!(read(direction, "Falling, code = Gray", 0), 0x01_01);
        assert_eq!(read(direction, "257", 0), 0x01_01);
        assert_eq!(read(direction, "000101h", 0), 0x01_01);
        assert_eq!(read(ssi, "bits=25,code=gray,repetition=false", 0x01_00_18), 0x01_19);
        assert_eq!(read(ssi, "gray", 0x18), 0x01_18);
        assert_eq!(read(ssi, "KH=0118", 0), 0x01_18);
        assert_eq!(read(Parameter::Numerator, "270Fh", 0), 9_999);
        assert!(ParameterChange::read(ssi, "257").unwrap().is_whole());
        for (parameter, wrong) in [
            (ssi, "falling"),
            (ssi, "bits=25,9"),
            (ssi, "bits=25,code=gray,bits=26"),
            (direction, "falling,direction=falling"),
            (ssi, ""),
            (direction, "bits=25"),
            (Parameter::Numerator, "gray"),
        ] {
            ParameterChange::read(parameter, wrong).unwrap_err();
        }
    }

    #[test]
    fn a_part_that_a_model_lacks_is_named() {
        let of = |text, model| {
            let change = ParameterChange::read(Parameter::CountingDirection, text).unwrap();
            change.unknown_part(Parameter::CountingDirection, model)
        };
        assert_eq!(of("falling,code=gray", Model::Ce100M), Some(ParameterPart::PositionCode));
        assert_eq!(of("gray", Model::La66), Some(ParameterPart::PositionCode));
        assert_eq!(of("gray", Model::Ce65M), None);
        assert_eq!(of("falling", Model::La66), None);
        assert_eq!(of("257", Model::La66), None, "a number names no part");
    }

    #[test]
    fn what_is_no_part_is_refused_with_its_words() {
        for (part, text, told) in [
            (ParameterPart::SsiCode, "grey", "ssi_code: grey is not binary or gray"),
            (ParameterPart::Direction, "1", "direction: 1 is not rising or falling"),
            (ParameterPart::SsiBits, "018", "018: 18, or 18h = 24; write one of them"),
            (ParameterPart::SsiBits, "256", "256 is above 255, the largest of a byte"),
            (ParameterPart::SsiBits, "0x100", "100h is above FFh, the largest of a byte"),
        ] {
            assert_eq!(ParameterChange::part(part, text).unwrap_err().to_string(), told);
        }
    }

    #[test]
    fn all_parts_of_a_model_are_the_whole_parameter() {
        for model in MODELS {
            for parameter in PARAMETERS {
                let parts = ParameterPart::of(parameter, model);
                let data = if parameter == Parameter::SsiValues { 0x01_01_18 } else { 0x01_01 };
                let named = |part: ParameterPart| {
                    ParameterChange::part(part, part.words().map_or("24", |[_, one]| one)).unwrap()
                };
                let Some(all) = parts.clone().map(named).reduce(ParameterChange::and) else { continue };
                let all = all.completed(parameter, model);
                assert!(all.is_whole(), "{model} {parameter:?}");
                assert!(parts.clone().all(|part| part.shown(all.of(0).number) == part.shown(data)));
                let alone = parts.clone().next().map(named).unwrap().completed(parameter, model).is_whole();
                assert_eq!(alone, parts.count() == 1, "{model} {parameter:?}");
            }
        }
        let names = |parameter, model| {
            ParameterPart::of(parameter, model).map(ParameterPart::key).collect::<std::vec::Vec<_>>()
        };
        assert_eq!(names(Parameter::CountingDirection, Model::Ce65M), ["direction", "code"]);
        assert_eq!(names(Parameter::CountingDirection, Model::La66), ["direction"]);
        assert_eq!(names(Parameter::SsiValues, Model::Ce65M), ["bits", "code", "repetition"]);
        assert!(names(Parameter::SsiValues, Model::La66).is_empty());
        assert!(names(Parameter::Numerator, Model::Ce65M).is_empty());
    }
}
