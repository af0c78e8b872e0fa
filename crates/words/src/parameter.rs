//! The programmable values: their layouts, ranges and factory settings.

use crate::ErrorStatus;
pub use crate::data::{Code, CountingDirection, Direction, OutOfRange, SsiValues, within};
use crate::model::{Effect, Listed, Model, SENSOR_TURNS, Sensor, Takes};
use crate::service::Service;
use crate::word::DATA_MAX;

/// A value that services write and read, and that the EEPROM keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Parameter {
    /// Service 01.
    CountingDirection,
    /// Service 02.
    MeasuringLength,
    /// Service 03.
    Numerator,
    /// Service 04.
    PresetValue1,
    /// Service 05.
    PresetValue2,
    /// Service 09.
    Denominator,
    /// Service 0D.
    SsiValues,
}

/// Every parameter, in the order of the services.
pub const PARAMETERS: [Parameter; 7] = [
    Parameter::CountingDirection,
    Parameter::MeasuringLength,
    Parameter::Numerator,
    Parameter::PresetValue1,
    Parameter::PresetValue2,
    Parameter::Denominator,
    Parameter::SsiValues,
];

impl Parameter {
    /// The parameter behind a service; `None` for the two actions 06 and 08.
    #[must_use]
    pub const fn from_service(service: Service) -> Option<Self> {
        Some(match service {
            Service::CountingDirection => Self::CountingDirection,
            Service::MeasuringLength => Self::MeasuringLength,
            Service::Numerator => Self::Numerator,
            Service::PresetValue1 => Self::PresetValue1,
            Service::PresetValue2 => Self::PresetValue2,
            Service::Denominator => Self::Denominator,
            Service::SsiValues => Self::SsiValues,
            Service::PresetAdjustment | Service::DataCheck => return None,
        })
    }

    /// The service that writes and reads it.
    #[must_use]
    pub const fn service(self) -> Service {
        match self {
            Self::CountingDirection => Service::CountingDirection,
            Self::MeasuringLength => Service::MeasuringLength,
            Self::Numerator => Service::Numerator,
            Self::PresetValue1 => Service::PresetValue1,
            Self::PresetValue2 => Service::PresetValue2,
            Self::Denominator => Service::Denominator,
            Self::SsiValues => Service::SsiValues,
        }
    }

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::CountingDirection => "counting_direction",
            Self::MeasuringLength => "measuring_length",
            Self::Numerator => "numerator",
            Self::PresetValue1 => "preset_value_1",
            Self::PresetValue2 => "preset_value_2",
            Self::Denominator => "denominator",
            Self::SsiValues => "ssi_values",
        }
    }

    /// The range that the encoder accepts as a whole 24-bit value; `None` where the bytes are judged singly, and where
    /// the model lacks the service. The presets of the CE-100 are compared with the measuring length only at the data
    /// check, and a numerator of 0 is stored as well [C6].
    #[must_use]
    pub const fn range(self, model: Model) -> Option<(u32, u32)> {
        match model.lists(self.service()) {
            Some(Listed { takes: Takes::Number { low, high, .. }, .. }) => Some((*low, *high)),
            _ => None,
        }
    }

    /// The value as the encoder stores and returns it [R47, R114, R119, C11, C19]. Of a parameter that the model
    /// lacks, any.
    ///
    /// # Errors
    /// [`OutOfRange`] if it is refused; the old value then stays.
    pub const fn normalise(self, model: Model, data: u32) -> Result<u32, OutOfRange> {
        match model.lists(self.service()) {
            Some(listed) => listed.takes.normalise(data),
            None => within(data, 0, DATA_MAX),
        }
    }

    /// What stands in the sets of a model that lacks the service: all turns of the sensor, and 24 SSI bits.
    const fn where_lacking(self) -> u32 {
        match self {
            Self::Numerator => SENSOR_TURNS,
            Self::Denominator => 1,
            Self::SsiValues => 24,
            Self::MeasuringLength => DATA_MAX,
            Self::CountingDirection | Self::PresetValue1 | Self::PresetValue2 => 0,
        }
    }
}

/// One value for each parameter, normalised. A model that lacks a service keeps the factory value
/// there. The default is all zeros, which no encoder holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterSet([u32; PARAMETERS.len()]);

impl ParameterSet {
    /// What a new encoder holds; no manual says, so it is this project's choice.
    #[must_use]
    pub const fn factory(model: Model, sensor: Sensor) -> Self {
        const fn value(model: Model, sensor: Sensor, parameter: Parameter) -> u32 {
            match model.lists(parameter.service()) {
                Some(listed) => listed.factory(sensor),
                None => parameter.where_lacking(),
            }
        }
        let [direction, length, numerator, preset_1, preset_2, denominator, ssi] = PARAMETERS;
        Self([
            value(model, sensor, direction),
            value(model, sensor, length),
            value(model, sensor, numerator),
            value(model, sensor, preset_1),
            value(model, sensor, preset_2),
            value(model, sensor, denominator),
            value(model, sensor, ssi),
        ])
    }

    /// The value of one parameter.
    #[must_use]
    pub const fn value(&self, parameter: Parameter) -> u32 {
        let [direction, length, numerator, preset_1, preset_2, denominator, ssi] = self.0;
        match parameter {
            Parameter::CountingDirection => direction,
            Parameter::MeasuringLength => length,
            Parameter::Numerator => numerator,
            Parameter::PresetValue1 => preset_1,
            Parameter::PresetValue2 => preset_2,
            Parameter::Denominator => denominator,
            Parameter::SsiValues => ssi,
        }
    }

    /// Replaces the value of one parameter; `value` must be normalised.
    pub fn set(&mut self, parameter: Parameter, value: u32) {
        if let Some(slot) = self.0.get_mut(parameter as usize) {
            *slot = value;
        }
    }

    /// Direction and bus code (01).
    #[must_use]
    pub const fn counting_direction(&self) -> CountingDirection {
        CountingDirection::from_data(self.value(Parameter::CountingDirection))
    }

    /// Measuring length in steps (02): the largest position of the range [C4].
    #[must_use]
    pub const fn measuring_length(&self) -> u32 {
        self.value(Parameter::MeasuringLength)
    }

    /// Revolutions numerator (03).
    #[must_use]
    pub const fn numerator(&self) -> u32 {
        self.value(Parameter::Numerator)
    }

    /// Revolutions denominator (09).
    #[must_use]
    pub const fn denominator(&self) -> u32 {
        self.value(Parameter::Denominator)
    }

    /// SSI characteristic values (0D).
    #[must_use]
    pub const fn ssi_values(&self) -> SsiValues {
        SsiValues::from_data(self.value(Parameter::SsiValues))
    }

    /// The validity bits of the set, as the data check and power-up look at them [R90, R92, R93, C31]. None where a
    /// value takes effect at once: there every accepted value is valid.
    #[must_use]
    pub fn validity(&self, model: Model, sensor: Sensor) -> ErrorStatus {
        let mut status = ErrorStatus::empty();
        if model.effect() == Effect::AtOnce {
            return status;
        }
        let length = self.measuring_length();
        for parameter in PARAMETERS {
            if let Some(listed) = model.lists(parameter.service()) {
                status |= listed.takes.invalid_beside(self.value(parameter), length);
            }
        }
        if let Sensor::Rotary { steps_per_turn } = sensor
            && self.numerator() != 0
        {
            let native = u64::from(steps_per_turn) * u64::from(self.numerator());
            if (u64::from(length) + 1) * u64::from(self.denominator()) > native {
                status |= ErrorStatus::LENGTH_TOO_LARGE;
            }
        }
        status
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const Q4096: Sensor = Sensor::Rotary { steps_per_turn: 4096 };
    const Q8192: Sensor = Sensor::Rotary { steps_per_turn: 8192 };

    fn set(length: u32, numerator: u32, denominator: u32) -> ParameterSet {
        let mut set = ParameterSet::factory(Model::Ce65M, Q4096);
        set.set(Parameter::MeasuringLength, length);
        set.set(Parameter::Numerator, numerator);
        set.set(Parameter::Denominator, denominator);
        set
    }

    #[test]
    fn more_steps_a_turn_than_the_rating_plate_is_2_to_14_and_equality_is_legal() {
        let judged = |sensor, (s, n, d)| set(s, n, d).validity(Model::Ce65M, sensor);
        for legal in [(0xFFF, 1, 1), (0x37FF, 35, 10), (0xFF_FFFF, 0x1000, 1)] {
            assert_eq!(judged(Q4096, legal), ErrorStatus::empty(), "{legal:?}");
        }
        for illegal in [(0x1000, 1, 1), (0x3800, 35, 10), (0xFF_FFFF, 0xFFF, 1)] {
            assert_eq!(judged(Q4096, illegal), ErrorStatus::LENGTH_TOO_LARGE, "{illegal:?}");
        }
        assert_eq!(judged(Q8192, (0xFF_FFFF, 0x800, 1)), ErrorStatus::empty());
        assert_eq!(judged(Q8192, (0xFF_FFFF, 0x7FF, 1)), ErrorStatus::LENGTH_TOO_LARGE);
    }

    #[test]
    fn every_parameter_has_a_name_of_its_own_in_files() {
        let keys = PARAMETERS.map(Parameter::key);
        assert_eq!(
            keys,
            [
                "counting_direction",
                "measuring_length",
                "numerator",
                "preset_value_1",
                "preset_value_2",
                "denominator",
                "ssi_values"
            ]
        );
    }

    #[test]
    fn a_numerator_of_zero_hides_2_to_14() {
        assert_eq!(set(0xFF_FFFF, 0, 99).validity(Model::Ce65M, Q4096), ErrorStatus::NUMERATOR_ZERO);
    }

    #[test]
    fn presets_above_the_measuring_length_are_an_error_on_the_ce_100_only() {
        let mut set = set(100, 1, 1);
        set.set(Parameter::PresetValue1, 101);
        set.set(Parameter::PresetValue2, 100);
        assert_eq!(set.validity(Model::Ce100M, Q4096), ErrorStatus::PRESET_1_RANGE);
        set.set(Parameter::PresetValue1, 100);
        set.set(Parameter::PresetValue2, 101);
        assert_eq!(set.validity(Model::Ce100M, Q4096), ErrorStatus::PRESET_2_RANGE);
        assert_eq!(set.validity(Model::Ce65M, Q4096), ErrorStatus::empty());
    }

    #[test]
    fn the_ranges_end_where_the_manuals_say() {
        use Parameter as P;
        let ends = [
            (P::CountingDirection, Model::La66, 0, 1),
            (P::CountingDirection, Model::Ce100M, 0, 1),
            (P::MeasuringLength, Model::La66, 1, DATA_MAX),
            (P::MeasuringLength, Model::Ce100M, 0x10, DATA_MAX),
            (P::MeasuringLength, Model::Ce65M, 0x10, DATA_MAX),
            (P::Numerator, Model::Ce65M, 0, 0xFFFF),
            (P::Denominator, Model::Ce100M, 1, 0x63),
            (P::PresetValue1, Model::La66, 0, DATA_MAX),
        ];
        for (parameter, model, low, high) in ends {
            assert_eq!(parameter.normalise(model, low), Ok(low));
            assert_eq!(parameter.normalise(model, high), Ok(high));
            if low > 0 {
                assert_eq!(
                    parameter.normalise(model, low - 1),
                    Err(OutOfRange { value: low - 1, low, high })
                );
            }
            if high < DATA_MAX {
                assert_eq!(
                    parameter.normalise(model, high + 1),
                    Err(OutOfRange { value: high + 1, low, high })
                );
            }
        }
    }

    #[test]
    fn the_ce_65_normalises_each_byte() {
        let direction = |data| Parameter::CountingDirection.normalise(Model::Ce65M, data);
        assert_eq!(direction(0xFF_80_FF), Ok(0x00_01_01));
        assert_eq!(direction(0xFF_00_00), Ok(0));
        let ssi = |data| Parameter::SsiValues.normalise(Model::Ce65M, data);
        assert_eq!(ssi(0xFF_FF_18), Ok(0x01_01_18));
        assert_eq!(ssi(0x00_80_1F), Ok(0x00_01_1F));
        assert_eq!(ssi(0x01_00_20), Ok(0x01_00_18));
        assert_eq!(ssi(0x01_00_21), Err(OutOfRange { value: 0x21, low: 8, high: 0x20 }));
        assert_eq!(ssi(0x00_00_07), Err(OutOfRange { value: 7, low: 8, high: 0x20 }));
    }

    #[test]
    fn a_rod_leaves_the_factory_with_a_hundredth_of_a_millimetre() {
        let steps = |rod_um| ParameterSet::factory(Model::La66, Sensor::Linear { rod_um }).measuring_length();
        assert_eq!(steps(500_000), 0xC350);
        assert_eq!(
            (steps(9), steps(u32::MAX)),
            (1, DATA_MAX),
            "no rod has less than one step or more than 24 bits"
        );
    }
}
