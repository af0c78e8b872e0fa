//! What an IN word is worth to somebody who only looks: [`encoring_host::validity`] with what is known of the encoder,
//! be it all, a part or nothing.

use std::num::NonZeroU32;

use encoring_host::Seen;
use encoring_host::validity::{Expectation, Limits, NoExpectation, Position, Stop, Validity, Why};
use encoring_ring::diagnostics::Diagnosis;
use encoring_words::model::{ROD_UM_MAX, ROD_UM_MIN, Sensor, SensorKind};
use encoring_words::parameter::PARAMETERS;
use encoring_words::word::{In, ServiceFields, ServiceNumber};
use encoring_words::{Access, Duration, ErrorStatus, Instant, Model, Parameter, ParameterSet, Service};

use crate::bus::{Answered, BusError};

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
    /// The master says that its ring stands still, or does not reach the encoder: whatever IN shows is history.
    RingStopped(Diagnosis),
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
    pub const WORDS: [&'static str; 16] = [
        "valid",
        "unchecked",
        "stale",
        "ring_stopped",
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

    /// `true` for a fault of the encoder or its ring; `None` if nothing is known of them: nothing came, or nothing new, or
    /// what no encoder sends.
    #[must_use]
    pub const fn is_fault(&self) -> Option<bool> {
        match self {
            Self::Valid(_) | Self::Unchecked(_) | Self::InService => Some(false),
            Self::Stale { .. } | Self::NoAnswer(_) | Self::Implausible(Why::Foreign(_)) => None,
            Self::RingStopped(_) | Self::Faulty(_) | Self::Implausible(_) => Some(true),
        }
    }

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
            Self::RingStopped(_) => 3,
            Self::Faulty(_) => 4,
            Self::InService => 5,
            Self::Implausible(Why::Foreign(_)) => 6,
            Self::Implausible(Why::Range { .. }) => 7,
            Self::Implausible(Why::OffTheRod { .. }) => 8,
            Self::Implausible(Why::Speed { .. }) => 9,
            Self::Implausible(Why::Acceleration { .. }) => 10,
            Self::NoAnswer(BusError::NoAnswer { .. }) => 11,
            Self::NoAnswer(BusError::NoConnection(_)) => 12,
            Self::NoAnswer(BusError::Client(client)) => match client.answered() {
                Answered::Refused | Answered::Busy => 13,
                Answered::Garbled | Answered::Misdirected => 14,
            },
            Self::NoAnswer(
                BusError::NoEncoder { .. } | BusError::NotShown { .. } | BusError::NotAnEncoder { .. },
            ) => 15,
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

/// What of the ring is known when an encoder's word is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ring {
    /// It runs, as far as the bus can tell.
    Runs,
    /// It stands still, or does not reach the encoder.
    Stands(Diagnosis),
    /// The bus shows what the master says, and it could not be read.
    Unread,
}

/// What is taken for sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// A word that may be older is stale.
    pub stale_after: Duration,
    /// What a shaft turns at most, in revolutions per minute; else what its data sheet allows.
    pub max_rpm: Option<NonZeroU32>,
    /// How fast a magnet moves at most, in mm/s; else without limit.
    pub max_mm_s: Option<NonZeroU32>,
}

impl Tolerance {
    /// With the speeds of the data sheets.
    #[must_use]
    pub const fn of_sheet(stale_after: Duration) -> Self {
        Self { stale_after, max_rpm: None, max_mm_s: None }
    }

    fn limits(&self, model: Model, motion_known: bool) -> Limits {
        let sheet = Limits::of(model, Duration::ZERO);
        let known = |limit: Option<NonZeroU32>| limit.filter(|_| motion_known);
        Limits {
            speed_rpm: known(self.max_rpm.or(sheet.speed_rpm)),
            acceleration_rad_s2: known(sheet.acceleration_rad_s2),
            speed_mm_s: known(self.max_mm_s),
            stale_after: self.stale_after,
            ..sheet
        }
    }
}

/// What cannot be judged: for want of parameters, or at this poll.
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
    /// Half of the range or more could be travelled since the poll before.
    Slow,
    /// Whether the ring runs could not be read.
    Ring,
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
            Self::Slow => "slow",
            Self::Ring => "ring",
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
            Self::Slow => {
                "half of the range or more can be travelled between two polls, so no jump is noticed: poll faster, or \
                 say with --max-rpm or --max-mm-s what the machine does at most"
            }
            Self::Ring => "the master's diagnosis could not be read: whether the ring runs is not known",
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
    sensor: Option<Sensor>,
    tolerance: Tolerance,
    validity: Validity,
    measuring_length: Option<u32>,
    /// What is not known for want of parameters, and behind that what the last poll could not judge.
    blind: Vec<Blind>,
    /// How many of them are for want of parameters.
    unknown: usize,
    /// What was last learnt.
    active: Option<ParameterSet>,
    /// All that its positions are computed with, if it is known.
    insight: Option<Insight>,
}

impl Judge {
    /// With the active values of some parameters, or none, and the sensor if it is known. Without a rod's length no speed
    /// of its magnet can be judged, and the tolerance's is left aside.
    ///
    /// # Errors
    /// [`NoExpectation`] if no encoder can have these values active.
    pub fn new(
        model: Model,
        sensor: Option<Sensor>,
        values: &[(Parameter, u32)],
        tolerance: Tolerance,
    ) -> Result<Self, NoExpectation> {
        let Known { expectation, blind, measuring_length, insight } = Known::new(model, sensor, values)?;
        let length_known = sensor.is_some() || model.sensor_kind() == SensorKind::Rotary;
        let motion_known = blind.is_empty() && length_known;
        let validity = Validity::new(expectation, tolerance.limits(model, motion_known));
        let unknown = blind.len();
        Ok(Self {
            model,
            sensor,
            tolerance,
            validity,
            measuring_length,
            blind,
            unknown,
            active: None,
            insight,
        })
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.model
    }

    /// What the encoder measures with, if that is known.
    #[must_use]
    pub const fn sensor(&self) -> Option<Sensor> {
        self.sensor
    }

    /// The measuring length in steps, if it is known.
    #[must_use]
    pub const fn measuring_length(&self) -> Option<u32> {
        self.measuring_length
    }

    /// All that its positions are computed with, if it is known.
    #[must_use]
    pub const fn insight(&self) -> Option<Insight> {
        self.insight
    }

    /// What is taken for sound.
    #[must_use]
    pub const fn tolerance(&self) -> Tolerance {
        self.tolerance
    }

    /// What cannot be judged.
    #[must_use]
    pub fn blind(&self) -> &[Blind] {
        &self.blind
    }

    /// Judges what a poll brought, and whether it is a new reason to stop the machine. That the ring stands still is none
    /// of an encoder's.
    pub fn judge(
        &mut self,
        now: Instant,
        seen: Result<Seen, BusError>,
        ring: Ring,
    ) -> (Judgement, Option<Stop>) {
        self.blind.truncate(self.unknown);
        match (ring, seen) {
            (Ring::Stands(diagnosis), Ok(_)) => {
                // Nothing came from the encoder, whatever stands there.
                self.validity.judge(now, None, &mut |_| ());
                (Judgement::RingStopped(diagnosis), None)
            }
            (Ring::Unread, seen) => {
                self.blind.push(Blind::Ring);
                self.judge_word(now, seen)
            }
            (_, seen) => self.judge_word(now, seen),
        }
    }

    /// A person knows why the positions have jumped: the next one is taken as it comes. `true` if they had.
    pub fn acknowledge(&mut self) -> bool {
        let jumped = self.validity.has_jumped();
        if jumped {
            self.validity.rebase();
        }
        jumped
    }

    fn judge_word(&mut self, now: Instant, seen: Result<Seen, BusError>) -> (Judgement, Option<Stop>) {
        let mut stop = None;
        let input = seen.as_ref().ok().copied();
        let position = self.validity.judge(now, input, &mut |reason| stop = Some(reason));
        if !self.validity.excludes_jumps() {
            self.blind.push(Blind::Slow);
        }
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
        if let Ok(new) = Self::new(self.model, Some(sensor), &values, self.tolerance) {
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
                if let Ok(mut new) = Self::new(self.model, None, &[], self.tolerance) {
                    new.blind.push(Blind::Changed);
                    new.unknown = new.blind.len();
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
    blind: Vec<Blind>,
    measuring_length: Option<u32>,
    insight: Option<Insight>,
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
            // Of a rod whose length is not known no speed can be judged: it is left aside.
            (None, SensorKind::Linear) => expect(Sensor::Linear {
                rod_um: set.measuring_length().saturating_mul(10).clamp(ROD_UM_MIN, ROD_UM_MAX),
            }),
            // With fewer steps per turn a position is less exact, so less is called impossible.
            (None, SensorKind::Rotary) => {
                expect(model.usual_sensor()).or_else(|_| expect(model.finest_sensor()))
            }
        }?;
        let insight = sensor.filter(|_| blind.is_empty()).map(|sensor| Insight { sensor, active: set });
        Ok(Self { expectation, blind, measuring_length, insight })
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
