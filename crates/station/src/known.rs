//! What is known of the parameters of an encoder that is only looked at: what a file says of it, and what its replies
//! have told, whoever asked for them.
//!
//! Nothing is known that was not seen. What may have changed without being seen is dropped.

#[cfg(test)]
mod tests;

use encoring_words::model::{Effect, Sensor, SensorKind};
use encoring_words::parameter::PARAMETERS;
use encoring_words::word::{In, READ_WRITE_BIT, SERVICE, ServiceFields, ServiceNumber};
use encoring_words::{
    Access, ErrorStatus, InWord, Instant, Model, OutWord, Parameter, ParameterSet, Service,
};
use serde::Serialize;

/// What a file says of the encoder at a position.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KnownFile {
    /// Its ring position.
    #[serde(skip)]
    pub position: usize,
    /// What the file is called.
    pub name: String,
    /// When its values were read; `None` in a file that somebody wrote.
    pub taken: Option<String>,
    /// Serial number of the encoder.
    pub serial: Option<String>,
    /// What else stands on it.
    pub label: Option<String>,
    /// The values, which the encoder is said to compute its position with.
    #[serde(skip)]
    pub values: Vec<(Parameter, u32)>,
}

/// How somebody knows a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum KnownFrom {
    /// A file says it.
    File,
    /// The reply to a service that read it.
    Read,
    /// The reply to a service that wrote it.
    Written,
    /// It was programmed when a data check found no error.
    Check,
    /// Somebody sees into the encoder.
    Inside,
}

/// A value that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct KnownValue {
    /// As the encoder returns it.
    pub value: u32,
    /// How it is known.
    pub from: KnownFrom,
    /// Since when, on the bus's clock; `None` for a file.
    pub time_ns: Option<u64>,
}

/// What is known of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct KnownParameter {
    /// Number of its service.
    pub service: u8,
    /// What a read returned, or a write left.
    pub programmed: Option<KnownValue>,
    /// What a good data check took.
    pub accepted: Option<KnownValue>,
    /// What the position is computed with.
    pub active: Option<KnownValue>,
}

/// What is known of the parameters of one encoder.
#[derive(Clone, Debug)]
pub(crate) struct KnownEncoder {
    model: Model,
    sensor: Option<Sensor>,
    parameters: Vec<(Parameter, KnownParameter)>,
    /// The reply that was taken last: it stands for many polls.
    last: Option<InWord>,
}

impl KnownEncoder {
    /// With what a file says.
    pub(crate) fn new(model: Model, sensor: Option<Sensor>, file: &[(Parameter, u32)]) -> Self {
        let known = PARAMETERS.into_iter().filter(|parameter| parameter.service().known_to(model));
        let said = |wanted| file.iter().find(|(parameter, _)| *parameter == wanted);
        let parameters = known.map(|parameter| {
            let active = said(parameter).map(|(_, value)| KnownValue {
                value: *value,
                from: KnownFrom::File,
                time_ns: None,
            });
            let service = parameter.service().number();
            (parameter, KnownParameter { service, programmed: None, accepted: None, active })
        });
        Self { model, sensor, parameters: parameters.collect(), last: None }
    }

    /// The parameters, in the order of the services.
    pub(crate) fn parameters(&self) -> Vec<KnownParameter> {
        self.parameters.iter().map(|(_, known)| *known).collect()
    }

    /// Takes what stood on both words. A reply counts beside the request that it replies to: what a gateway turns round
    /// may look like one.
    pub(crate) fn saw(&mut self, at: Instant, out: Option<OutWord>, input: InWord) {
        let In::Reply(reply) = input.decode() else {
            self.last = None;
            return;
        };
        let requests =
            |out: OutWord| [SERVICE, READ_WRITE_BIT].iter().all(|field| field.of(out.0) == field.of(input.0));
        if out.is_some_and(requests) && self.last.replace(input) != Some(input) {
            self.replied(at, reply);
        }
    }

    /// No word came, or an old one. Who was without a supply meanwhile has made the programmed values active.
    pub(crate) fn lost(&mut self) {
        self.last = None;
        for (_, known) in &mut self.parameters {
            let programmed = known.programmed;
            let stays =
                |kept: &KnownValue| programmed.is_none_or(|programmed| programmed.value == kept.value);
            known.accepted = known.accepted.filter(stays);
            known.active = known.active.filter(stays);
        }
    }

    /// Somebody sees what is active.
    pub(crate) fn inside(&mut self, at: Instant, active: &ParameterSet) {
        for (parameter, known) in &mut self.parameters {
            let value = active.value(*parameter);
            if known.active.is_none_or(|active| (active.value, active.from) != (value, KnownFrom::Inside)) {
                known.active = Some(KnownValue::at(at, value, KnownFrom::Inside));
            }
        }
    }

    /// What a data check would find in the programmed values; `None` if too little is known of them. Faults of the memory
    /// and of the magnet are not in it.
    pub(crate) fn data_check(&self) -> Option<ErrorStatus> {
        if self.model.effect() == Effect::AtOnce {
            return Some(ErrorStatus::empty());
        }
        let mut set = ParameterSet::factory(self.model, self.model.usual_sensor());
        for (parameter, known) in &self.parameters {
            set.set(*parameter, known.programmed?.value);
        }
        // Where the sensor is not known, what all of them would find.
        let mut found = self.sensors().into_iter().map(|sensor| set.validity(self.model, sensor));
        let first = found.next()?;
        found.all(|other| other == first).then_some(first)
    }

    fn sensors(&self) -> Vec<Sensor> {
        match (self.sensor, self.model.sensor_kind()) {
            (Some(sensor), _) => vec![sensor],
            (None, SensorKind::Linear) => vec![self.model.usual_sensor()],
            (None, SensorKind::Rotary) => {
                let plates = self.model.steps_per_turn().iter();
                plates.map(|steps_per_turn| Sensor::Rotary { steps_per_turn: *steps_per_turn }).collect()
            }
        }
    }

    fn replied(&mut self, at: Instant, reply: ServiceFields) {
        let ServiceNumber::Known(service) = reply.service else { return };
        match (service, Parameter::from_service(service)) {
            (Service::DataCheck, _) if !reply.error => self.taken_over(at),
            (_, Some(parameter)) => self.programmed(at, parameter, reply),
            _ => {}
        }
    }

    fn programmed(&mut self, at: Instant, parameter: Parameter, reply: ServiceFields) {
        let ServiceFields { access, error, data, .. } = reply;
        let value = match access {
            // A record that cannot be read shows as 0.
            Access::Read if error && data == 0 => return,
            Access::Read => Some(KnownValue::at(at, data, KnownFrom::Read)),
            // The error may be an older one: whether it was written nobody knows.
            Access::Write if error => None,
            Access::Write => {
                let stored = parameter.normalise(self.model, data).ok();
                stored.map(|value| KnownValue::at(at, value, KnownFrom::Written))
            }
        };
        let at_once = self.model.effect() == Effect::AtOnce;
        let wanted = self.parameters.iter_mut().filter(|(other, _)| *other == parameter);
        for (_, known) in wanted {
            known.programmed = value;
            if at_once {
                known.active = value;
            }
        }
    }

    /// A data check found no error: the programmed values count. Where they are not known, nothing speaks against a file.
    fn taken_over(&mut self, at: Instant) {
        if self.model.effect() == Effect::AtOnce {
            return;
        }
        for (_, known) in &mut self.parameters {
            let taken =
                known.programmed.map(|programmed| KnownValue::at(at, programmed.value, KnownFrom::Check));
            known.accepted = taken;
            known.active = taken.or(known.active.filter(|active| active.from == KnownFrom::File));
        }
    }
}

impl KnownValue {
    const fn at(at: Instant, value: u32, from: KnownFrom) -> Self {
        Self { value, from, time_ns: Some(at.as_nanos()) }
    }
}
