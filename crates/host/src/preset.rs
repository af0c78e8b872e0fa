//! The preset adjustment as a user means it: the position shall be this value, here and now [R73..R76].

use encoring_words::parameter::{Code, CountingDirection};
use encoring_words::word::In;
use encoring_words::{InWord, Model, Parameter, gray};

use crate::request::Request;
use crate::service::{Failure, Services, carry_out, read};

/// How a preset adjustment went. Whatever happened, nothing was repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetReport<E> {
    /// The position before, in steps; `None` if IN showed none.
    pub before: Option<u32>,
    /// The position afterwards; `None` if IN showed none.
    pub after: Option<u32>,
    /// `Ok` if the encoder acknowledged it without an error.
    pub result: Result<(), Failure<E>>,
}

/// What must be known before the question is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    model: Model,
    request: Request,
    code: Code,
    before: InWord,
}

impl Preset {
    /// Looks at the encoder: its measuring length, above which some refuse, its code, and its position. Moves
    /// nothing.
    ///
    /// # Errors
    /// [`Failure`], also for a value that the encoder would refuse.
    pub fn prepare<S: Services>(
        services: &mut S,
        model: Model,
        value: u32,
    ) -> Result<Self, Failure<S::Error>> {
        let length = read(services, model, Parameter::MeasuringLength)?.value;
        let request = Request::preset(model, value, length).map_err(Failure::Request)?;
        let code = code(services, model)?;
        let before = services.look().map_err(Failure::Bus)?;
        Ok(Self { model, request, code, before })
    }

    /// The position shown when this was prepared.
    #[must_use]
    pub fn before(&self) -> Option<u32> {
        position(self.before, self.code)
    }

    /// `true` if an error was pending when this was prepared.
    #[must_use]
    pub const fn error_pending(&self) -> bool {
        self.before.error_bit()
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.model
    }

    /// Sets the zero. A refusal runs the data check; after a time-out nothing is repeated, and the position says what
    /// can be known.
    pub fn adjust<S: Services>(self, services: &mut S) -> PresetReport<S::Error> {
        let before = services.look().ok().and_then(|shown| position(shown, self.code));
        let result = carry_out(services, self.request).map(|_| ());
        let after = services.look().ok().and_then(|shown| position(shown, self.code));
        PresetReport { before, after, result }
    }
}

/// The code of the position on the bus.
///
/// # Errors
/// [`Failure`].
pub fn code<S: Services>(services: &mut S, model: Model) -> Result<Code, Failure<S::Error>> {
    if !model.position_may_be_gray() {
        return Ok(Code::Binary);
    }
    let direction = read(services, model, Parameter::CountingDirection)?;
    Ok(CountingDirection::from_data(direction.value).code)
}

/// The position that a word in this code shows, in steps.
#[must_use]
pub fn position(shown: InWord, code: Code) -> Option<u32> {
    match (shown.decode(), code) {
        (In::Position { value, .. }, Code::Binary) => Some(value),
        (In::Position { value, .. }, Code::Gray) => Some(gray::decode(value)),
        _ => None,
    }
}
