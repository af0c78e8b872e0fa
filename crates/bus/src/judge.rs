//! What an IN word is worth to somebody who only looks: [`encoring_host::validity`] with what is known of the encoder,
//! be it all, a part or nothing.

use std::num::NonZeroU32;

use encoring_host::Seen;
use encoring_host::validity::{Expectation, Limits, NoExpectation, Position, Recovery, Stop, Validity, Why};
use encoring_words::model::{ROD_UM_MAX, ROD_UM_MIN, Sensor, SensorKind};
use encoring_words::parameter::PARAMETERS;
use encoring_words::word::{In, ServiceFields, ServiceNumber};
use encoring_words::{Access, Duration, ErrorStatus, Instant, Model, Parameter, ParameterSet, Service};

use crate::bus::{Answered, BusError};

/// After so many positions that fit one another a jump is over: somebody who only looks cannot ask why it was.
const JUMP_OVER: NonZeroU32 = NonZeroU32::MIN.saturating_add(9);

/// What an IN word is worth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// A position that nothing speaks against.
    Valid(u32),
    /// The same, but not everything could be judged: see [`Judge::blind`].
    Unchecked(u32),
    /// The word is too old.
    Stale {
        /// How old it may be.
        age: Duration,
    },
    /// Bit 29 is set; the error status, if the reply to a data check was seen since.
    Faulty(Option<ErrorStatus>),
    /// A reply.
    InService,
    /// It cannot be true.
    Implausible(Why),
    /// The poll failed.
    NoAnswer(BusError),
}

impl Judgement {
    /// Every word that [`Judgement::word`] can be.
    pub const WORDS: [&'static str; 15] = [
        "valid",
        "unchecked",
        "stale",
        "faulty",
        "in_service",
        "implausible_bits",
        "implausible_range",
        "implausible_off_the_rod",
        "implausible_speed",
        "implausible_acceleration",
        "no_answer_in_time",
        "no_answer_no_connection",
        "no_answer_refused",
        "no_answer_garbled",
        "no_answer_no_encoder",
    ];

    /// One word for it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        Self::WORDS.get(self.number()).copied().unwrap_or_default()
    }

    /// Its place in [`Judgement::WORDS`].
    #[must_use]
    pub const fn number(&self) -> usize {
        match self {
            Self::Valid(_) => 0,
            Self::Unchecked(_) => 1,
            Self::Stale { .. } => 2,
            Self::Faulty(_) => 3,
            Self::InService => 4,
            Self::Implausible(Why::Foreign(_)) => 5,
            Self::Implausible(Why::Range { .. }) => 6,
            Self::Implausible(Why::OffTheRod { .. }) => 7,
            Self::Implausible(Why::Speed { .. }) => 8,
            Self::Implausible(Why::Acceleration { .. }) => 9,
            Self::NoAnswer(BusError::NoAnswer { .. }) => 10,
            Self::NoAnswer(BusError::NoConnection(_)) => 11,
            Self::NoAnswer(BusError::Client(client)) => match client.answered() {
                Answered::Refused | Answered::Busy => 12,
                Answered::Garbled => 13,
            },
            Self::NoAnswer(BusError::NoEncoder { .. } | BusError::NotAnEncoder { .. }) => 14,
        }
    }

    /// The position in steps, if there is one.
    #[must_use]
    pub const fn value(&self) -> Option<u32> {
        match self {
            Self::Valid(value) | Self::Unchecked(value) => Some(*value),
            _ => None,
        }
    }
}

/// What cannot be judged, for want of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Blind {
    /// Service 01 is not known, so a position may be in Gray code.
    Code,
    /// Service 02 is not known, so no position is too large.
    Range,
    /// Services 02, 03 and 09 are not known, so no jump is impossible.
    Motion,
    /// Parameters were written meanwhile.
    Changed,
}

impl Blind {
    /// In one word, for programs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Code => "code",
            Self::Range => "range",
            Self::Motion => "motion",
            Self::Changed => "changed",
        }
    }

    /// In words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Code => "the code (service 01) is not known: the position is taken as binary",
            Self::Range => "the measuring length (service 02) is not known: no position is too large",
            Self::Motion => "the scaling (services 02, 03, 09) is not known: no jump is noticed",
            Self::Changed => "parameters were written since: what was known of them no longer counts",
        }
    }
}

/// What somebody knows of an encoder who sees into it, as its simulation does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Insight {
    /// What it measures with.
    pub sensor: Sensor,
    /// What its position is computed with.
    pub active: ParameterSet,
}

/// Judges the words of one encoder.
#[derive(Clone, Debug)]
pub struct Judge {
    model: Model,
    stale_after: Duration,
    validity: Validity,
    measuring_length: Option<u32>,
    blind: Vec<Blind>,
    /// What was last learnt.
    active: Option<ParameterSet>,
}

impl Judge {
    /// With the active values of some parameters, or none, and the sensor if it is known. A word that may be older than
    /// `stale_after` is stale.
    ///
    /// # Errors
    /// [`NoExpectation`] if no encoder can have these values active.
    pub fn new(
        model: Model,
        sensor: Option<Sensor>,
        values: &[(Parameter, u32)],
        stale_after: Duration,
    ) -> Result<Self, NoExpectation> {
        let Known { expectation, limited, blind, measuring_length } = Known::new(model, sensor, values)?;
        let mut limits = Limits::of(model, Duration::ZERO);
        if limited {
            (limits.speed_rpm, limits.acceleration_rad_s2) = (None, None);
        }
        limits.stale_after = stale_after;
        limits.recovery = Recovery::After(JUMP_OVER);
        let validity = Validity::new(expectation, limits);
        Ok(Self { model, stale_after, validity, measuring_length, blind, active: None })
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.model
    }

    /// The measuring length in steps, if it is known.
    #[must_use]
    pub const fn measuring_length(&self) -> Option<u32> {
        self.measuring_length
    }

    /// What cannot be judged.
    #[must_use]
    pub fn blind(&self) -> &[Blind] {
        &self.blind
    }

    /// Judges what a poll brought, and whether it is a new reason to stop the machine.
    pub fn judge(&mut self, now: Instant, seen: Result<Seen, BusError>) -> (Judgement, Option<Stop>) {
        let mut stop = None;
        let input = seen.as_ref().ok().copied();
        let position = self.validity.judge(now, input, &mut |reason| stop = Some(reason));
        let verdict = match (seen, position) {
            (Err(error), _) => Judgement::NoAnswer(error),
            (_, Position::Valid(value)) if self.blind.is_empty() => Judgement::Valid(value),
            (_, Position::Valid(value)) => Judgement::Unchecked(value),
            (_, Position::Stale { age, .. }) => Judgement::Stale { age },
            (_, Position::Faulty(status)) => Judgement::Faulty(status),
            (_, Position::InService) => Judgement::InService,
            (_, Position::Implausible(why)) => Judgement::Implausible(why),
        };
        if let Some(Seen { input, .. }) = input
            && let In::Reply(reply) = input.decode()
        {
            self.follow(reply);
        }
        // What no encoder sends says nothing of the machine.
        (verdict, stop.filter(|stop| !matches!(stop, Stop::Implausible(Why::Foreign(_)))))
    }

    /// Takes over what is active in the encoder. Whoever tells it once tells every change of it.
    pub fn learn(&mut self, insight: Insight) {
        let Insight { sensor, active } = insight;
        if self.active == Some(active) {
            return;
        }
        let values = PARAMETERS.map(|parameter| (parameter, active.value(parameter)));
        if let Ok(new) = Self::new(self.model, Some(sensor), &values, self.stale_after) {
            *self = new;
        }
        self.active = Some(active);
    }

    /// A service of somebody else's was carried out: what it changes is known no longer.
    fn follow(&mut self, reply: ServiceFields) {
        let ServiceFields {
            access: Access::Write, error: false, service: ServiceNumber::Known(service), ..
        } = reply
        else {
            return;
        };
        match service {
            Service::PresetAdjustment => self.validity.rebase(),
            Service::CountingDirection
            | Service::MeasuringLength
            | Service::Numerator
            | Service::Denominator
                if self.active.is_none() && !self.blind.contains(&Blind::Changed) =>
            {
                if let Ok(mut new) = Self::new(self.model, None, &[], self.stale_after) {
                    new.blind.push(Blind::Changed);
                    *self = new;
                }
            }
            _ => {}
        }
    }
}

/// What follows from the parameters that are known.
struct Known {
    expectation: Expectation,
    /// Without limits of the movement.
    limited: bool,
    blind: Vec<Blind>,
    measuring_length: Option<u32>,
}

impl Known {
    fn new(model: Model, sensor: Option<Sensor>, values: &[(Parameter, u32)]) -> Result<Self, NoExpectation> {
        let value =
            |wanted| values.iter().find(|(parameter, _)| *parameter == wanted).map(|(_, value)| *value);
        let measuring_length = value(Parameter::MeasuringLength);
        let mut blind = Vec::new();
        if model.position_may_be_gray() && value(Parameter::CountingDirection).is_none() {
            blind.push(Blind::Code);
        }
        if measuring_length.is_none() {
            blind.push(Blind::Range);
        }
        let unknown =
            |parameter: Parameter| parameter.service().known_to(model) && value(parameter).is_none();
        if [Parameter::MeasuringLength, Parameter::Numerator, Parameter::Denominator].into_iter().any(unknown)
        {
            blind.push(Blind::Motion);
        }
        let limited = !blind.is_empty();
        let mut set = ParameterSet::factory(model, model.usual_sensor());
        for (parameter, value) in values {
            set.set(*parameter, *value);
        }
        if !blind.is_empty() {
            widen(&mut set, model, &blind);
        }
        let expect = |sensor| Expectation::new(model, sensor, &set);
        let expectation = match (sensor, model.sensor_kind()) {
            (Some(sensor), _) => expect(sensor),
            // The rod only matters with a limit of its speed, and there is none.
            (None, SensorKind::Linear) => expect(Sensor::Linear {
                rod_um: set.measuring_length().saturating_mul(10).clamp(ROD_UM_MIN, ROD_UM_MAX),
            }),
            // With fewer steps per turn a position is less exact, so less is called impossible.
            (None, SensorKind::Rotary) => {
                expect(model.usual_sensor()).or_else(|_| expect(model.finest_sensor()))
            }
        }?;
        Ok(Self { expectation, limited, blind, measuring_length })
    }
}

/// Makes the range as wide as the model can have it where it is not known.
fn widen(set: &mut ParameterSet, model: Model, blind: &[Blind]) {
    let unknown = |what| blind.contains(&what);
    // In Gray code every number may be in the range.
    if (unknown(Blind::Range) || unknown(Blind::Code))
        && let Some((_, longest)) = Parameter::MeasuringLength.range(model)
    {
        set.set(Parameter::MeasuringLength, longest);
    }
    // The most turns take every measuring length.
    if let Some((_, most)) = Parameter::Numerator.range(model) {
        set.set(Parameter::Numerator, most);
    }
    if let Some((least, _)) = Parameter::Denominator.range(model) {
        set.set(Parameter::Denominator, least);
    }
}
