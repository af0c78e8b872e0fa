//! The values of a file: which parameter, and what it may hold.

use encoring_host::request::{Request, RequestError};
use encoring_words::change::{ParameterChange, ParameterPart};
use encoring_words::number::TypedValue;
use encoring_words::parameter::{PARAMETERS, Parameter, ParameterSet};
use encoring_words::{Model, number, word};

/// A value that the encoder takes, or parts of one.
pub(crate) fn legal_change(
    model: Model,
    name: &str,
    value: &toml::Value,
) -> Result<(Parameter, ParameterChange), String> {
    let Some(parameter) = parameters_of(model).find(|parameter| parameter.key() == name) else {
        let names: Vec<_> = parameters_of(model).map(Parameter::key).collect();
        return Err(format!("{name:?} is no parameter of a {model}; it has {}", names.join(", ")));
    };
    let change = match value {
        toml::Value::Table(parts) => parts_of(model, parameter, parts)?,
        toml::Value::String(text) => {
            ParameterChange::read(parameter, text).map_err(|error| format!("{name} = {value}: {error}"))?
        }
        other => match other.as_integer().and_then(|number| u32::try_from(number).ok()) {
            Some(number) if number <= word::DATA_MAX => TypedValue::from(number).into(),
            _ => {
                let limit = word::DATA_MAX;
                return Err(format!("{name} = {other}; it must be a whole number from 0 to {limit}"));
            }
        },
    };
    // The parts that stay are legal, whatever they are.
    let others = ParameterSet::factory(model, model.usual_sensor()).value(parameter);
    let typed = change.of(others);
    // What an encoder stores may stand in a file, also what it shows an error for; the limits are those of a request.
    if parameter.normalise(model, typed.number).is_ok() {
        return Ok((parameter, change.completed(parameter, model)));
    }
    match Request::write(model, parameter, typed) {
        Ok(_) => Ok((parameter, change.completed(parameter, model))),
        Err(RequestError::Range { typed: decided, low, high, .. }) => {
            // Of service 0D only a part decides.
            let part = if decided == typed { String::new() } else { format!(" has {decided} bits") };
            let (low, high) = (typed.like(low), typed.like(high));
            Err(format!("{name} = {typed}{part}; allowed are {low} to {high}"))
        }
        Err(refused) => Err(format!("{name} = {typed}: {refused}")),
    }
}

/// A value of 24 bits as people write it.
pub(crate) fn number_of(text: &str) -> Result<u32, String> {
    number::value(text).map(|value| value.number).map_err(|wrong| wrong.to_string())
}

/// A parameter by the names of its parts.
fn parts_of(model: Model, parameter: Parameter, parts: &toml::Table) -> Result<ParameterChange, String> {
    let name = parameter.key();
    let known: Vec<_> = ParameterPart::of(parameter, model).collect();
    let mut changes = parts.iter().map(|(key, value)| {
        let part = known.iter().find(|part| part.key() == key).ok_or_else(|| {
            let keys: Vec<_> = known.iter().map(|part| part.key()).collect();
            match keys.as_slice() {
                [] => format!("{name} = {{ {key} = .. }}; it is a number and has no parts"),
                keys => format!("{name} = {{ {key} = .. }}; its parts are: {}", keys.join(", ")),
            }
        })?;
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        ParameterChange::part(*part, &text)
            .map_err(|error| format!("{name} = {{ {key} = {value} }}: {error}"))
    });
    let nothing = || Err(format!("{name} = {{}}; it must be a number, or name its parts"));
    let first = changes.next().unwrap_or_else(nothing)?;
    changes.try_fold(first, |all, change| Ok(all.and(change?)))
}

/// A value as a file holds it: by the names of its parts if they say all of it, else as a number.
pub(crate) fn written(model: Model, parameter: Parameter, value: u32) -> String {
    let named: Vec<_> = ParameterPart::of(parameter, model).map(|part| (part, part.shown(value))).collect();
    let said = named.iter().fold(0, |said, (_, shown)| said | shown.data());
    let worded = named.iter().all(|(part, shown)| part.words().is_none() || shown.word().is_some());
    if named.is_empty() || said != value || !worded {
        return value.to_string();
    }
    let texts = named.iter().map(|(part, shown)| {
        let text = match shown.word() {
            // TOML has these two itself.
            Some(word @ ("true" | "false")) => word.to_owned(),
            Some(word) => format!("{word:?}"),
            None => shown.to_string(),
        };
        format!("{} = {text}", part.key())
    });
    format!("{{ {} }}", texts.collect::<Vec<_>>().join(", "))
}

/// The parameters that a model has, in the order of the services.
pub fn parameters_of(model: Model) -> impl Iterator<Item = Parameter> {
    PARAMETERS.into_iter().filter(move |parameter| parameter.service().known_to(model))
}
