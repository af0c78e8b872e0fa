//! The values of a file: which parameter, and what it may hold.

use encoring_words::parameter::{PARAMETERS, Parameter};
use encoring_words::{Model, number, word};

/// A value that the encoder takes.
pub(crate) fn legal_value(model: Model, name: &str, value: &toml::Value) -> Result<(Parameter, u32), String> {
    let (parameter, value) = value_of(model, name, value)?;
    match parameter.normalise(model, value) {
        Ok(_) => Ok((parameter, value)),
        Err(refused) => {
            // Of service 0D only a part decides.
            let part =
                if refused.value == value { String::new() } else { format!(" has {} bits", refused.value) };
            Err(format!("{name} = {value}{part}; allowed are {} to {}", refused.low, refused.high))
        }
    }
}

fn value_of(model: Model, name: &str, value: &toml::Value) -> Result<(Parameter, u32), String> {
    let Some(parameter) = parameters_of(model).find(|parameter| parameter.key() == name) else {
        let names: Vec<_> = parameters_of(model).map(Parameter::key).collect();
        return Err(format!("{name:?} is no parameter of a {model}; it has {}", names.join(", ")));
    };
    let number = value.as_integer().and_then(|value| u32::try_from(value).ok());
    match number.filter(|value| *value <= word::DATA_MAX) {
        Some(number) => Ok((parameter, number)),
        None => Err(format!("{name} = {value}; it must be a whole number from 0 to {}", word::DATA_MAX)),
    }
}

/// A value of 24 bits as people write it.
pub(crate) fn number_of(text: &str) -> Result<u32, String> {
    number::value(text).map(|value| value.number).map_err(|wrong| wrong.to_string())
}

/// The parameters that a model has, in the order of the services.
pub fn parameters_of(model: Model) -> impl Iterator<Item = Parameter> {
    PARAMETERS.into_iter().filter(move |parameter| parameter.service().known_to(model))
}
