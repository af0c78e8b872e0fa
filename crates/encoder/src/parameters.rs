//! The parameter sets: programmed, accepted, active [R79, R80, C7, C38, C39].
//!
//! Services write and read the programmed set, which the EEPROM keeps value by value. The accepted set is what the
//! last good data check took, and the EEPROM keeps it whole. The position is computed with the active set: the accepted
//! one, or where values take effect at once, as on the LA-66, the programmed one.

use embedded_storage::Storage;
use encoring_words::model::{Effect, Sensor};
use encoring_words::parameter::PARAMETERS;
use encoring_words::{ErrorStatus, Model, Parameter, ParameterSet};

use crate::records::{self, Data, NotStored, Record};
use crate::unit::Unit;

/// The working copies of the sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    model: Model,
    sensor: Sensor,
    programmed: ParameterSet,
    active: ParameterSet,
}

impl Parameters {
    /// What the memory gives at power-up, with the status bits of what it did not give. `None` beside the sets: the
    /// programmed set was not taken over, which sets bit 29 without a status bit [C39].
    pub(crate) fn power_up(unit: &Unit, memory: &mut impl Storage) -> (Self, ErrorStatus, TakenOver) {
        let (model, sensor) = (unit.model(), unit.sensor());
        let factory = ParameterSet::factory(model, sensor);
        let mut programmed = factory;
        let mut faults = ErrorStatus::empty();
        for parameter in PARAMETERS.into_iter().filter(|p| p.service().known_to(model)) {
            match read_programmed(model, parameter, memory) {
                Some(value) => programmed.set(parameter, value),
                None => faults |= ErrorStatus::READING_DATA,
            }
        }
        let complete = faults.is_empty();
        let mut parameters = Self { model, sensor, programmed, active: programmed };
        if model.effect() == Effect::AtOnce {
            return (parameters, faults, TakenOver::Yes);
        }
        let accepted = read_accepted(model, sensor, memory);
        if accepted.is_none() {
            faults |= ErrorStatus::READING_DATA;
        }
        if complete && parameters.validity().is_empty() {
            // R80: what was programmed without a data check counts from the next power-up on.
            if records::write(memory, Record::Accepted, &programmed).is_err() {
                faults |= ErrorStatus::WRITING_DATA;
                parameters.active = accepted.unwrap_or(programmed);
            }
            (parameters, faults, TakenOver::Yes)
        } else {
            parameters.active = accepted.unwrap_or(factory);
            (parameters, faults, TakenOver::No)
        }
    }

    /// The set that services write and read.
    #[must_use]
    pub const fn programmed(&self) -> &ParameterSet {
        &self.programmed
    }

    /// The set that the position is computed with.
    #[must_use]
    pub const fn active(&self) -> &ParameterSet {
        &self.active
    }

    /// The set that the last good data check took, as the memory has it; `None` if it is lost, or where values take
    /// effect at once and there is none.
    pub fn accepted(&self, memory: &mut impl Storage) -> Option<ParameterSet> {
        match self.model.effect() {
            Effect::AtOnce => None,
            Effect::AtDataCheck => read_accepted(self.model, self.sensor, memory),
        }
    }

    /// The validity bits of the programmed set, as the next data check will find them.
    #[must_use]
    pub fn validity(&self) -> ErrorStatus {
        self.programmed.validity(self.model, self.sensor)
    }

    /// Programs one value, already normalised.
    pub(crate) fn program(
        &mut self,
        parameter: Parameter,
        value: u32,
        memory: &mut impl Storage,
    ) -> Result<(), NotStored> {
        records::write(memory, Record::Programmed(parameter), &Data(value))?;
        self.programmed.set(parameter, value);
        if self.model.effect() == Effect::AtOnce {
            self.active = self.programmed;
        }
        Ok(())
    }

    /// Reads one programmed value from its record; `None` if that is lost.
    pub(crate) fn read(&self, parameter: Parameter, memory: &mut impl Storage) -> Option<u32> {
        read_programmed(self.model, parameter, memory)
    }

    /// Takes the whole programmed set over in one step; it must be valid. Where values take effect at once there
    /// is nothing to do.
    pub(crate) fn accept(&mut self, memory: &mut impl Storage) -> Result<(), NotStored> {
        if self.model.effect() == Effect::AtDataCheck {
            records::write(memory, Record::Accepted, &self.programmed)?;
            self.active = self.programmed;
        }
        Ok(())
    }
}

/// Whether power-up made the programmed set the active one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TakenOver {
    Yes,
    No,
}

fn is_normal(model: Model, parameter: Parameter, value: u32) -> bool {
    parameter.normalise(model, value) == Ok(value)
}

fn read_programmed(model: Model, parameter: Parameter, memory: &mut impl Storage) -> Option<u32> {
    let Data(value) = records::read(memory, Record::Programmed(parameter)).ok()?;
    is_normal(model, parameter, value).then_some(value)
}

fn read_accepted(model: Model, sensor: Sensor, memory: &mut impl Storage) -> Option<ParameterSet> {
    let set: ParameterSet = records::read(memory, Record::Accepted).ok()?;
    let mut known = PARAMETERS.into_iter().filter(|p| p.service().known_to(model));
    let normal = known.all(|parameter| is_normal(model, parameter, set.value(parameter)));
    (normal && set.validity(model, sensor).is_empty()).then_some(set)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ram;

    #[test]
    fn a_whole_record_with_a_value_that_no_service_would_store_is_lost() {
        let unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }).unwrap();
        for (parameter, value) in [
            (Parameter::Denominator, 0),
            (Parameter::MeasuringLength, 0xF),
            (Parameter::SsiValues, 0x02_00_18),
        ] {
            let mut memory = Ram::blank();
            records::format(&unit, &mut memory).unwrap();
            records::write(&mut memory, Record::Programmed(parameter), &Data(value)).unwrap();
            let (parameters, faults, taken_over) = Parameters::power_up(&unit, &mut memory);
            assert_eq!((faults, taken_over), (ErrorStatus::READING_DATA, TakenOver::No), "{parameter:?}");
            assert_eq!(*parameters.programmed(), ParameterSet::factory(unit.model(), unit.sensor()));
        }
    }

    #[test]
    fn an_accepted_set_that_no_data_check_would_accept_is_lost() {
        let unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }).unwrap();
        let mut memory = Ram::blank();
        records::format(&unit, &mut memory).unwrap();
        let mut set = ParameterSet::factory(unit.model(), unit.sensor());
        set.set(Parameter::Numerator, 1);
        records::write(&mut memory, Record::Accepted, &set).unwrap();
        records::write(&mut memory, Record::Programmed(Parameter::Numerator), &Data(0)).unwrap();
        let (parameters, faults, taken_over) = Parameters::power_up(&unit, &mut memory);
        assert_eq!((faults, taken_over), (ErrorStatus::READING_DATA, TakenOver::No));
        assert_eq!(*parameters.active(), ParameterSet::factory(unit.model(), unit.sensor()));
    }
}
