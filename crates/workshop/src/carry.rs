//! What of one model's parameters another model takes.

use encoring_words::model::SensorKind;
use encoring_words::parameter::{Code, CountingDirection};
use encoring_words::{Model, Parameter};

use crate::kept::KeptEncoder;

/// What can be carried over to another model, and what cannot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Carried {
    /// The values that the other model takes.
    pub values: Vec<(Parameter, u32)>,
    /// What cannot be carried over, and why: a sentence each.
    pub lost: Vec<String>,
}

/// The values of `kept` for an encoder of another model.
///
/// # Errors
/// Why nothing of it makes sense there.
pub fn carry(kept: &KeptEncoder, to: Model) -> Result<Carried, String> {
    let kind = |model: Model| match model.sensor_kind() {
        SensorKind::Rotary => "measures turns of a shaft",
        SensorKind::Linear => "measures the way along a rod",
    };
    let from = kept.model;
    if from.sensor_kind() != to.sensor_kind() {
        return Err(format!("a {from} {}, a {to} {}: its values make no sense there", kind(from), kind(to)));
    }
    let mut carried = Carried { values: Vec::new(), lost: Vec::new() };
    for (parameter, value) in &kept.values {
        let (parameter, value) = (*parameter, carried.without_code(*parameter, *value, to));
        let key = parameter.key();
        if !parameter.service().known_to(to) {
            carried
                .lost
                .push(format!("{key} = {value}: a {to} has no service {:02X}", parameter.service().number()));
        } else if let Err(refused) = parameter.normalise(to, value) {
            carried.lost.push(format!("{key} = {value}: a {to} takes {} to {}", refused.low, refused.high));
        } else {
            carried.values.push((parameter, value));
        }
    }
    Ok(carried)
}

impl Carried {
    /// A counting direction without the code of the position, where the model has no choice of code.
    fn without_code(&mut self, parameter: Parameter, value: u32, to: Model) -> u32 {
        let own = CountingDirection::from_data(value);
        if parameter != Parameter::CountingDirection || to.position_may_be_gray() || own.code == Code::Binary
        {
            return value;
        }
        self.lost.push(format!(
            "Gray code of the position: a {to} shows it in binary, so the PLC must not convert it any more"
        ));
        CountingDirection { code: Code::Binary, ..own }.data()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn kept(model: Model, values: &[(Parameter, u32)]) -> KeptEncoder {
        KeptEncoder { values: values.to_vec(), ..KeptEncoder::new(model) }
    }

    // [R72]
    #[test]
    fn what_the_other_model_lacks_is_listed_and_the_rest_is_carried() {
        let ce_65 = kept(
            Model::Ce65M,
            &[
                (Parameter::CountingDirection, 0x0101),
                (Parameter::MeasuringLength, 9_999),
                (Parameter::SsiValues, 25),
            ],
        );
        let carried = carry(&ce_65, Model::Ce100M).unwrap();
        assert_eq!(carried.values, [(Parameter::CountingDirection, 1), (Parameter::MeasuringLength, 9_999)]);
        assert_eq!(
            carried.lost,
            [
                "Gray code of the position: a ce-100-m shows it in binary, so the PLC must not convert it any more",
                "ssi_values = 25: a ce-100-m has no service 0D",
            ]
        );
        let ce_100 = kept(Model::Ce100M, &[(Parameter::PresetValue1, 7), (Parameter::Denominator, 3)]);
        let carried = carry(&ce_100, Model::Ce65M).unwrap();
        assert_eq!(carried.values, [(Parameter::Denominator, 3)]);
        assert_eq!(carried.lost, ["preset_value_1 = 7: a ce-65-m has no service 04"]);
        assert_eq!(carry(&ce_100, Model::Ce100M).unwrap().lost, [] as [&str; 0]);
    }

    #[test]
    fn a_rod_and_a_shaft_have_nothing_in_common() {
        let rod = kept(Model::La66, &[(Parameter::MeasuringLength, 9_999)]);
        let refused = carry(&rod, Model::Ce65M).unwrap_err();
        assert!(
            refused.contains("a la-66 measures the way along a rod, a ce-65-m measures turns"),
            "{refused}"
        );
    }
}
