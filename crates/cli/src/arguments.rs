//! Values that more than one command takes.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::sync::LazyLock;

use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser};
use clap::{Arg, Command};
use encoring_host::scaling::Ratio;
use encoring_ring::ENCODERS_MAX;
use encoring_words::change::{PARTS, ParameterPart};
use encoring_words::model::{MODELS, UnknownModel};
use encoring_words::number::{self, NumberError, NumberProblem, TypedValue};
use encoring_words::parameter::PARAMETERS;
use encoring_words::{Duration, Model, Parameter, Service};

pub(crate) mod bus;
pub(crate) mod fault;
mod groups;
pub(crate) mod positions;
pub(crate) mod range;
mod table;

pub(crate) use encoring_sim::span::read as span;
pub(crate) use groups::{Consent, Lasting, Output, Pace, State, TypeLabel, built_with};
pub(crate) use table::{TableArguments, tell_assumed, tell_doubts};

/// A ring position; whatever the bus, there are no more.
pub(crate) fn position(text: &str) -> Result<usize, String> {
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    let number = number::value(text).ok().filter(|_| digits);
    number
        .and_then(|value| usize::try_from(value.number).ok())
        .filter(|number| *number < ENCODERS_MAX)
        .ok_or_else(|| format!("{text:?} is no position; a ring has 0 to {}", ENCODERS_MAX - 1))
}

/// One of the three models, by its name or as its type label has it.
pub(crate) fn model() -> impl TypedValueParser<Value = Model> {
    ModelParser
}

#[derive(Clone, Copy)]
struct ModelParser;

impl TypedValueParser for ModelParser {
    type Value = Model;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        label: &OsStr,
    ) -> Result<Model, clap::Error> {
        StringValueParser::new().try_map(|label| model_name(&label)).parse_ref(command, argument, label)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(MODELS.map(|model| PossibleValue::new(model.name())).into_iter()))
    }
}

/// A model by its name.
pub(crate) fn model_name(text: &str) -> Result<Model, UnknownModel> {
    Model::from_str(text)
}

/// The steps per turn that any rotary encoder can have, as text.
static NATIVE: LazyLock<Vec<String>> = LazyLock::new(|| {
    let numbers: BTreeSet<u32> = MODELS.iter().flat_map(|model| model.steps_per_turn()).copied().collect();
    numbers.iter().map(u32::to_string).collect()
});

/// Steps per turn, as a rating plate has them.
pub(crate) fn native() -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(NATIVE.iter().map(String::as_str))
        .try_map(|steps| number::value(&steps).map(|value| value.number).map_err(|error| error.to_string()))
}

/// One parameter, or every one that the model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parameters {
    All,
    One(Parameter),
}

/// What a write changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Named {
    Parameter(Parameter),
    Part(ParameterPart),
}

impl Named {
    pub(crate) const fn parameter(self) -> Parameter {
        match self {
            Self::Parameter(parameter) => parameter,
            Self::Part(part) => part.parameter(),
        }
    }
}

/// A parameter, or a part of one by its name.
pub(crate) fn named(text: &str) -> Result<Named, String> {
    let name = text.to_ascii_lowercase().replace('-', "_");
    match PARTS.into_iter().find(|part| part.name() == name) {
        Some(part) => Ok(Named::Part(part)),
        None => parameter(text).map(Named::Parameter),
    }
}

/// A parameter by its name, with `-` or `_`, or by the number of its service.
fn parameter(text: &str) -> Result<Parameter, String> {
    let name = text.to_ascii_lowercase().replace('-', "_");
    let is_number = text.len() <= 2 && text.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = if is_number { service_number(text) } else { None };
    let named = |service: Service, names: [&str; 2]| {
        Some(service.number()) == number || names.contains(&name.as_str())
    };
    if named(Service::PresetAdjustment, ["preset", "preset_adjustment"]) {
        return Err("service 06 is write only, and no parameter: use `encoring preset VALUE`".to_owned());
    }
    if named(Service::DataCheck, ["check", "data_check"]) {
        return Err("service 08 is the data check, and no parameter: use `encoring check`".to_owned());
    }
    let found = PARAMETERS
        .into_iter()
        .find(|parameter| parameter.key() == name || Some(parameter.service().number()) == number);
    found.ok_or_else(|| {
        let names = PARAMETERS.map(|parameter| parameter.key().replace('_', "-"));
        let parts = PARTS.map(|part| part.name().replace('_', "-"));
        format!(
            "no parameter; there are {}, or 01, 02, 03, 04, 05, 09, 0D; and parts of them: {}",
            names.join(", "),
            parts.join(", ")
        )
    })
}

#[expect(clippy::disallowed_methods, reason = "two digits of a service, which are hexadecimal everywhere")]
fn service_number(text: &str) -> Option<u8> {
    u8::from_str_radix(text, 16).ok()
}

/// A parameter, or `all`.
pub(crate) fn parameters(text: &str) -> Result<Parameters, String> {
    if text == "all" {
        Ok(Parameters::All)
    } else {
        named(text).map(|named| Parameters::One(named.parameter()))
    }
}

/// A value of 24 bits, as people write it.
pub(crate) fn value(text: &str) -> Result<u32, String> {
    typed_value(text).map(|value| value.number)
}

/// The same with the base in which limits are told.
pub(crate) fn typed_value(text: &str) -> Result<TypedValue, String> {
    number::value(text).map_err(|error: NumberError<'_>| error.to_string())
}

/// A whole number of a range, as people write values.
pub(crate) fn whole<T>(range: RangeInclusive<u32>) -> impl TypedValueParser<Value = T>
where
    T: TryFrom<u32> + Clone + Send + Sync + 'static,
{
    move |text: &str| {
        let advice = |typed: TypedValue| {
            format!("give {} to {}", typed.like(*range.start()), typed.like(*range.end()))
        };
        let above = |typed: TypedValue| {
            format!("{} is above {}; {}", text.trim(), typed.like(*range.end()), advice(typed))
        };
        let typed = number::value(text).map_err(|error| match error.problem {
            NumberProblem::Above { limit } => above(limit),
            _ => format!("{error}; allowed is {} to {}", range.start(), range.end()),
        })?;
        if typed.number < *range.start() {
            return Err(format!("{typed} is below {}; {}", typed.like(*range.start()), advice(typed)));
        }
        let within = Some(typed.number).filter(|number| range.contains(number));
        within.and_then(|number| T::try_from(number).ok()).ok_or_else(|| above(typed))
    }
}

/// A length in millimetres with at most two decimals [D40], as micrometres.
pub(crate) fn millimetres(text: &str) -> Result<u32, String> {
    let length = range::number(text)?;
    let hundredths = length.times(Ratio::from(100)).filter(|hundredths| hundredths.is_whole());
    hundredths.and_then(|hundredths| u32::try_from(hundredths.numerator() * 10).ok()).ok_or_else(|| {
        "not a length in millimetres from 0.01 to 167772.15, with at most two decimals".to_owned()
    })
}

/// Nobody reads faster.
const EVERY_MIN: Duration = Duration::from_millis(10);

/// The time from one poll to the next.
pub(crate) fn every(text: &str) -> Result<Duration, String> {
    let every = span(text)?;
    if every < EVERY_MIN {
        Err("less than 10 ms; `encoring log` looks more often".to_owned())
    } else {
        Ok(every)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_outside_its_range_is_told_with_the_limit_in_the_base_that_was_typed() {
        let read = |text: &str| {
            let command = Command::new("a").arg(Arg::new("bits").value_parser(whole::<u8>(8..=32)));
            let matches = command.try_get_matches_from(["a", text]).map_err(|error| error.to_string())?;
            Ok(*matches.get_one::<u8>("bits").unwrap())
        };
        for (text, bits) in [("8", 8), ("32", 32), ("20h", 32), ("0x18", 24)] {
            assert_eq!(read(text), Ok(bits), "{text}");
        }
        for (text, problem) in [
            ("40", "40 is above 32; give 8 to 32"),
            ("2Fh", "2Fh is above 20h; give 8h to 20h"),
            ("99999999999", "99999999999 is above 32; give 8 to 32"),
            ("7", "7 is below 8; give 8 to 32"),
            ("000018", "000018: 18, or 18h = 24; write one of them; allowed is 8 to 32"),
        ] {
            let error: String = read(text).unwrap_err();
            assert!(error.contains(&format!("invalid value '{text}' for '[bits]': {problem}")), "{error}");
        }
    }

    #[test]
    fn a_parameter_has_a_name_and_a_number() {
        for text in ["measuring-length", "measuring_length", "Measuring-Length", "02", "2"] {
            assert_eq!(parameter(text), Ok(Parameter::MeasuringLength), "{text}");
        }
        assert_eq!(parameters("0d"), Ok(Parameters::One(Parameter::SsiValues)));
        assert_eq!(parameters("all"), Ok(Parameters::All));
        for (other, instead) in [
            ("06", "service 06 is write only, and no parameter: use `encoring preset VALUE`"),
            ("preset", "service 06 is write only, and no parameter: use `encoring preset VALUE`"),
            ("8", "service 08 is the data check, and no parameter: use `encoring check`"),
        ] {
            assert_eq!(parameter(other).unwrap_err(), instead);
            assert_eq!(parameters(other).unwrap_err(), instead);
        }
        for wrong in ["", "07", "length", "+2", "002"] {
            assert!(
                parameter(wrong).unwrap_err().starts_with("no parameter; there are counting-direction"),
                "{wrong}"
            );
        }
    }

    #[test]
    fn a_part_of_a_parameter_has_a_name() {
        assert_eq!(named("ssi-bits"), Ok(Named::Part(ParameterPart::SsiBits)));
        assert_eq!(named("Direction"), Ok(Named::Part(ParameterPart::Direction)));
        assert_eq!(named("0d"), Ok(Named::Parameter(Parameter::SsiValues)));
        assert_eq!(parameters("ssi_code"), Ok(Parameters::One(Parameter::SsiValues)));
    }

    #[test]
    fn a_length_is_read_exactly_or_refused() {
        for (text, um) in
            [("500", 500_000), ("0.01", 10), ("1.5", 1_500), ("7.12", 7_120), ("167772.15", 167_772_150)]
        {
            assert_eq!(millimetres(text), Ok(um), "{text}");
        }
        for wrong in ["", ".", "5.", "1e3", "-1", "+1", "0", "1.005", "5000000000", "five"] {
            assert!(millimetres(wrong).is_err(), "{wrong}");
        }
        assert_eq!(millimetres("0,5").unwrap_err(), "write the decimals behind a point: 0.5");
    }
}
