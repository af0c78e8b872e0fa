//! Values that more than one command takes.

use std::collections::BTreeSet;
use std::str::FromStr;
use std::sync::LazyLock;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use encoring_host::scaling::Ratio;
use encoring_ring::ENCODERS_MAX;
use encoring_words::model::{MODELS, UnknownModel};
use encoring_words::parameter::PARAMETERS;
use encoring_words::{Model, Parameter, Service};

pub(crate) mod bus;
pub(crate) mod fault;
mod groups;
pub(crate) mod positions;
pub(crate) mod range;
mod table;

pub(crate) use encoring_sim::span::read as span;
pub(crate) use groups::{Consent, Lasting, Output, Pace, State, TypeLabel, built_with};
pub(crate) use table::TableArguments;

/// A ring position; whatever the bus, there are no more.
pub(crate) fn position(text: &str) -> Result<usize, String> {
    let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let number = text.parse::<usize>().ok().filter(|_| digits);
    number
        .filter(|number| *number < ENCODERS_MAX)
        .ok_or_else(|| format!("{text:?} is no position; a ring has 0 to {}", ENCODERS_MAX - 1))
}

/// One of the three models, by its name.
pub(crate) fn model() -> impl TypedValueParser<Value = Model> {
    PossibleValuesParser::new(MODELS.map(Model::name))
        .try_map(|name| -> Result<Model, UnknownModel> { name.parse() })
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
    PossibleValuesParser::new(NATIVE.iter().map(String::as_str)).try_map(|steps| steps.parse::<u32>())
}

/// One parameter, or every one that the model has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parameters {
    All,
    One(Parameter),
}

/// A parameter by its name, with `-` or `_`, or by the number of its service.
pub(crate) fn parameter(text: &str) -> Result<Parameter, String> {
    let name = text.to_ascii_lowercase().replace('-', "_");
    let is_number = text.len() <= 2 && text.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = if is_number { u8::from_str_radix(text, 16).ok() } else { None };
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
        format!("no parameter; there are {}, or 01, 02, 03, 04, 05, 09, 0D", names.join(", "))
    })
}

/// A parameter, or `all`.
pub(crate) fn parameters(text: &str) -> Result<Parameters, String> {
    if text == "all" { Ok(Parameters::All) } else { parameter(text).map(Parameters::One) }
}

/// A value of 24 bits: decimal, or hexadecimal as `0x270F` or `270Fh`.
pub(crate) fn value(text: &str) -> Result<u32, String> {
    let hex = text.strip_prefix("0x").or_else(|| text.strip_suffix(['h', 'H']));
    let digits = |text: &str, radix| {
        let all = !text.is_empty() && text.chars().all(|digit| digit.is_digit(radix));
        if all { u32::from_str_radix(text, radix).ok() } else { None }
    };
    let found = match hex {
        Some(hex) => digits(hex, 16),
        None => digits(text, 10),
    };
    found
        .filter(|value| *value <= encoring_words::word::DATA_MAX)
        .ok_or_else(|| "not a number from 0 to 16777215; hexadecimal as 0x270F or 270Fh".to_owned())
}

/// A length in millimetres with at most two decimals [D40], as micrometres.
pub(crate) fn millimetres(text: &str) -> Result<u32, String> {
    let length = range::number(text)?;
    let hundredths = length.times(Ratio::from(100)).filter(|hundredths| hundredths.is_whole());
    hundredths.and_then(|hundredths| u32::try_from(hundredths.numerator() * 10).ok()).ok_or_else(|| {
        "not a length in millimetres from 0.01 to 167772.15, with at most two decimals".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_value_is_decimal_or_marked_as_hexadecimal() {
        for (text, found) in
            [("9999", 9_999), ("0x270F", 9_999), ("270fh", 9_999), ("0", 0), ("FFFFFFh", 0xFF_FFFF)]
        {
            assert_eq!(value(text), Ok(found), "{text}");
        }
        for wrong in ["", "h", "0x", "270F", "-1", "+1", "1.5", "16777216", "0x1000000", "99999999999"] {
            assert!(value(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_length_is_read_exactly_or_refused() {
        for (text, um) in [
            ("500", 500_000),
            ("0.01", 10),
            ("1.5", 1_500),
            ("7.12", 7_120),
            ("167772.15", 167_772_150),
            ("0", 0),
        ] {
            assert_eq!(millimetres(text), Ok(um), "{text}");
        }
        for wrong in ["", ".", "5.", ".5", "1e3", "-1", "+1", "1.005", "5000000000", "five"] {
            assert!(millimetres(wrong).unwrap_err().starts_with("not a length"), "{wrong}");
        }
        assert_eq!(millimetres("0,5").unwrap_err(), "write the decimals behind a point: 0.5");
    }
}
