//! What can be read of an encoder. Only reads are sent.

use encoring_host::preset::{code, position};
use encoring_host::service::{Failure, Services, read};
use encoring_words::{InWord, Model, Parameter};

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
        Ok(Self { parameters, shown, positions })
    }

    /// The values, as they were read.
    pub fn values(&self) -> impl Iterator<Item = (Parameter, Option<u32>)> {
        self.parameters.iter().map(|read| (read.parameter, read.value))
    }

    /// The position of an encoder that stands still and has no error pending.
    ///
    /// # Errors
    /// Why no mark can be noted here.
    pub fn standing(&self) -> Result<u32, String> {
        if let Some(word) = self.shown.into_iter().find(|word| word.error_bit()) {
            return Err(format!(
                "IN shows {word}: an error is pending, so the position may be wrong; `encoring check` tells"
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
