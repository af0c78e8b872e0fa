//! Values that more than one command takes.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use encoring_words::Model;
use encoring_words::model::{MODELS, UnknownModel};

/// One of the three models, by its name.
pub(crate) fn model() -> impl TypedValueParser<Value = Model> {
    PossibleValuesParser::new(MODELS.map(Model::name))
        .try_map(|name| -> Result<Model, UnknownModel> { name.parse() })
}

/// A length in millimetres with at most three decimals, as micrometres.
pub(crate) fn millimetres(text: &str) -> Result<u32, String> {
    if text.contains(',') {
        return Err(format!("write the decimals behind a point: {}", text.replace(',', ".")));
    }
    micrometres(text).ok_or_else(|| {
        "not a length in millimetres from 0.01 to 167772.15, with at most three decimals".to_owned()
    })
}

fn micrometres(text: &str) -> Option<u32> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(whole) || !digits(decimals) || decimals.len() > 3 {
        return None;
    }
    format!("{whole}{decimals:0<3}").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_is_read_exactly_or_refused() {
        for (text, um) in [("500", 500_000), ("0.01", 10), ("1.5", 1_500), ("7.125", 7_125), ("0", 0)] {
            assert_eq!(millimetres(text), Ok(um), "{text}");
        }
        for wrong in ["", ".", "5.", ".5", "1e3", "-1", "+1", "1.0005", "5000000000", "five"] {
            assert!(millimetres(wrong).unwrap_err().starts_with("not a length"), "{wrong}");
        }
        assert_eq!(millimetres("0,5").unwrap_err(), "write the decimals behind a point: 0.5");
    }
}
