//! The preset adjustment as a user means it: the position shall be this value, here and now [R73..R76].

use encoring_words::number::TypedValue;
use encoring_words::parameter::{Code, CountingDirection};
use encoring_words::word::In;
use encoring_words::{Duration, InWord, Instant, Model, Parameter, gray};

use crate::request::Request;
use crate::service::{Failure, Refusal, Services, answer, read_surely};

/// How long the shaft is watched before its zero is set.
const WATCHED: Duration = Duration::from_millis(100);

/// How much faster than it was seen the shaft may have become meanwhile.
const FASTER: u64 = 2;

/// Steps by which a position may be off without motion.
const JITTER: u64 = 2;

/// How a preset adjustment went. Whatever happened, nothing was repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetReport<E> {
    /// The position before, in steps; `None` if IN showed none.
    pub before: Option<u32>,
    /// The position afterwards; `None` if IN showed none.
    pub after: Option<u32>,
    /// What IN showed last; `None` if it could not be seen.
    pub shown: Option<InWord>,
    /// `Ok` if the encoder acknowledged it without an error.
    pub result: Result<Done, Failure<E>>,
}

/// What is known of a preset adjustment that was acknowledged without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Done {
    /// The position is the value, or no further from it than the shaft can have turned meanwhile.
    Confirmed,
    /// The position that followed does not show it.
    Acknowledged,
}

/// What must be known before the question is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    model: Model,
    request: Request,
    code: Code,
    /// How many positions there are until the first comes again.
    positions: u64,
    watched: Watched,
}

/// Two looks at a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Watched {
    /// What IN showed at the second.
    shown: InWord,
    at: Instant,
    position: Option<u32>,
    /// Steps from the one to the other.
    moved: Option<u64>,
    /// Between them.
    span: Duration,
}

impl Preset {
    /// Looks at the encoder: its measuring length, above which a rotary one refuses, its code, its position and its
    /// speed. Moves nothing.
    ///
    /// # Errors
    /// [`Failure`], also for a value that the encoder would refuse, while an error is pending, if the measuring length or
    /// the code cannot be read, and if the position shows that the programmed values do not count yet: the zero would be
    /// lost with the next data check or power-up.
    pub fn prepare<S: Services>(
        services: &mut S,
        model: Model,
        value: impl Into<TypedValue>,
    ) -> Result<Self, Failure<S::Error>> {
        sound(services)?;
        let length = read_surely(services, model, Parameter::MeasuringLength)?;
        let request = Request::preset(model, value, length).map_err(Failure::Request)?;
        let code = code(services, model)?;
        let largest = model.largest_position(length);
        let positions = 1 + u64::from(largest);
        let watched = Watched::of(services, code, positions)?;
        if let Some(position) = watched.position.filter(|position| *position > largest) {
            return Err(Failure::NotActive { position, largest });
        }
        Ok(Self { model, request, code, positions, watched })
    }

    /// The position shown when this was prepared.
    #[must_use]
    pub const fn before(&self) -> Option<u32> {
        self.watched.position
    }

    /// Steps a second that the position moved when this was prepared; `None` if none was seen.
    #[must_use]
    pub fn steps_per_s(&self) -> Option<u64> {
        let per_s = self.watched.moved?.saturating_mul(1_000_000_000);
        per_s.checked_div(self.watched.span.as_nanos())
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.model
    }

    /// Sets the zero, unless an error is pending. Whatever comes of it, nothing is repeated and no data check is run.
    pub fn adjust<S: Services>(self, services: &mut S) -> PresetReport<S::Error> {
        let watched = match Watched::of(services, self.code, self.positions) {
            Ok(watched) => watched,
            Err(failure) => {
                return PresetReport { before: None, after: None, shown: None, result: Err(failure) };
            }
        };
        let result = answer(services, self.request).and_then(|(reply, _)| {
            let refused = Refusal { request: self.request, check: None, repeated: false };
            if reply.error { Err(Failure::Refused(refused)) } else { Ok(()) }
        });
        let shown = services.look().ok();
        let after = shown.and_then(|shown| position(shown, self.code));
        let since = services.now().since(watched.at);
        let result = result.map(|()| {
            let off = after.map(|after| distance(after, self.request.data(), self.positions));
            match (off, watched.reach(since)) {
                (Some(off), Some(reach)) if off <= reach => Done::Confirmed,
                _ => Done::Acknowledged,
            }
        });
        PresetReport { before: watched.position, after, shown, result }
    }
}

impl Watched {
    fn of<S: Services>(services: &mut S, code: Code, positions: u64) -> Result<Self, Failure<S::Error>> {
        let first = position(sound(services)?, code);
        let since = services.now();
        services.wait(WATCHED);
        let shown = sound(services)?;
        let (at, second) = (services.now(), position(shown, code));
        let moved = first.zip(second).map(|(first, second)| distance(first, second, positions));
        Ok(Self { shown, at, position: second, moved, span: at.since(since) })
    }

    /// How far the shaft can have come in so long a time.
    fn reach(&self, time: Duration) -> Option<u64> {
        // Each of the two positions was one of whole steps.
        let fastest = u128::from(self.moved?.saturating_add(1).saturating_mul(FASTER));
        let way = (fastest * u128::from(time.as_nanos())).checked_div(self.span.as_nanos().into())?;
        Some(u64::try_from(way).unwrap_or(u64::MAX).saturating_add(JITTER))
    }
}

/// What IN shows, if no error is pending.
fn sound<S: Services>(services: &mut S) -> Result<InWord, Failure<S::Error>> {
    let shown = services.look().map_err(Failure::Bus)?;
    if shown.error_bit() { Err(Failure::ErrorPending { shown }) } else { Ok(shown) }
}

/// The shorter way around from one position to another.
fn distance(from: u32, to: u32, positions: u64) -> u64 {
    let way = u64::from(from.abs_diff(to));
    way.min(positions.saturating_sub(way))
}

/// The code of the position on the bus.
///
/// # Errors
/// [`Failure`].
pub fn code<S: Services>(services: &mut S, model: Model) -> Result<Code, Failure<S::Error>> {
    if !model.position_may_be_gray() {
        return Ok(Code::Binary);
    }
    let direction = read_surely(services, model, Parameter::CountingDirection)?;
    Ok(CountingDirection::from_data(direction).code)
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
