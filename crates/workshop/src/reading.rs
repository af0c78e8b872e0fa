//! What can be read of an encoder. Only reads are sent.

use encoring_host::preset::{code, position};
use encoring_host::service::{Failure, Services, read};
use encoring_words::{InWord, Model, Parameter, word};

use crate::values::parameters_of;

/// A parameter, and what came of reading it.
#[derive(Clone, Copy, Debug)]
pub struct ReadParameter<E> {
    /// Which.
    pub parameter: Parameter,
    /// Its value; `None` if it could not be told from the 0 of a record that cannot be read, or was refused.
    pub value: Option<u32>,
    /// Why the encoder refused it, if it did.
    pub refused: Option<Failure<E>>,
}

/// Everything that can be read of an encoder.
#[derive(Clone, Debug)]
pub struct Readings<E> {
    /// Which encoder.
    pub model: Model,
    /// Each parameter that the model has.
    pub parameters: Vec<ReadParameter<E>>,
    /// What IN showed before and after.
    pub shown: [InWord; 2],
    /// The same as positions, where they are some.
    pub positions: [Option<u32>; 2],
}

/// Reads parameters one after the other. One record that cannot be read leaves the others readable.
///
/// # Errors
/// [`Failure`] if the encoder does not answer.
pub fn read_each<S: Services>(
    services: &mut S,
    model: Model,
    parameters: impl IntoIterator<Item = Parameter>,
) -> Result<Vec<ReadParameter<S::Error>>, Failure<S::Error>> {
    let mut found = Vec::new();
    for parameter in parameters {
        let (value, refused) = match read(services, model, parameter) {
            Ok(value) => (value.sure(), None),
            Err(refused @ Failure::Refused(_)) => (None, Some(refused)),
            Err(failure) => return Err(failure),
        };
        found.push(ReadParameter { parameter, value, refused });
    }
    Ok(found)
}

impl<E> Readings<E> {
    /// Reads everything.
    ///
    /// # Errors
    /// [`Failure`] if the encoder does not answer.
    pub fn of<S: Services<Error = E>>(services: &mut S, model: Model) -> Result<Self, Failure<E>> {
        let before = services.look().map_err(Failure::Bus)?;
        let parameters = read_each(services, model, parameters_of(model))?;
        let code = code(services, model).ok();
        let shown = [before, services.look().map_err(Failure::Bus)?];
        let positions = shown.map(|word| position(word, code?));
        Ok(Self { model, parameters, shown, positions })
    }

    /// The values, as they were read.
    pub fn values(&self) -> impl Iterator<Item = (Parameter, Option<u32>)> {
        self.parameters.iter().map(|read| (read.parameter, read.value))
    }

    /// The largest position that the values allow, as far as they were read.
    fn largest_position(&self) -> u32 {
        let length = self.values().find(|(parameter, _)| *parameter == Parameter::MeasuringLength);
        self.model.largest_position(length.and_then(|(_, length)| length).unwrap_or(word::DATA_MAX))
    }

    /// The position of an encoder that stands still, has no error pending and does not show that its values do not count.
    ///
    /// # Errors
    /// Why no mark can be noted here.
    pub fn standing(&self) -> Result<u32, String> {
        if let Some(word) = self.shown.into_iter().find(|word| word.error_bit()) {
            return Err(format!(
                "IN shows {word}: an error is pending, so the position may be wrong; `encoring check` tells"
            ));
        }
        let largest = self.largest_position();
        if let Some(position) = self.positions.into_iter().flatten().find(|position| *position > largest) {
            return Err(format!(
                "the position {position} is above the measuring length {largest}: it is not computed with the programmed \
                 values yet; `encoring check` makes them count, and the zero has to be made anew then"
            ));
        }
        match self.positions {
            [Some(before), Some(after)] if before == after => Ok(after),
            [Some(before), Some(after)] => {
                Err(format!("the position was {before} and then {after}: stop the axis first"))
            }
            _ => Err(format!("IN shows {}, no position", self.shown[1])),
        }
    }
}
