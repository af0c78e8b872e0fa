//! The services, bits 27..24 of a request [R21].

/// What a request does with the service's value, bit 30 [R18].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Access {
    /// Bit 30 = 0.
    Read,
    /// Bit 30 = 1.
    Write,
}

/// A service that at least one of the encoders knows, by the manuals' name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Service {
    /// 01: counting direction, on the CE-65-M also the code [R42, R44, R46].
    CountingDirection = 0x1,
    /// 02: measuring length in steps [R49, R53].
    MeasuringLength = 0x2,
    /// 03: measuring length in revolutions, numerator [R57].
    Numerator = 0x3,
    /// 04: preset value 1 [R66, R67].
    PresetValue1 = 0x4,
    /// 05: preset value 2 [R67].
    PresetValue2 = 0x5,
    /// 06: preset adjustment [R73].
    PresetAdjustment = 0x6,
    /// 08: data check; the LA-66 calls it "read error status" [R77, R78, C8].
    DataCheck = 0x8,
    /// 09: measuring length in revolutions, denominator [R58].
    Denominator = 0x9,
    /// 0D: SSI characteristic values [R113].
    SsiValues = 0xD,
}

/// Every service, by number.
pub const SERVICES: [Service; 9] = [
    Service::CountingDirection,
    Service::MeasuringLength,
    Service::Numerator,
    Service::PresetValue1,
    Service::PresetValue2,
    Service::PresetAdjustment,
    Service::DataCheck,
    Service::Denominator,
    Service::SsiValues,
];

impl Service {
    /// The service with this number; `None` where no manual has one.
    #[must_use]
    pub const fn from_number(number: u8) -> Option<Self> {
        Some(match number {
            0x1 => Self::CountingDirection,
            0x2 => Self::MeasuringLength,
            0x3 => Self::Numerator,
            0x4 => Self::PresetValue1,
            0x5 => Self::PresetValue2,
            0x6 => Self::PresetAdjustment,
            0x8 => Self::DataCheck,
            0x9 => Self::Denominator,
            0xD => Self::SsiValues,
            _ => return None,
        })
    }

    /// Its number, 1..=0Dh.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The manuals' name for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CountingDirection => "counting direction",
            Self::MeasuringLength => "measuring length in steps",
            Self::Numerator => "revolutions numerator",
            Self::PresetValue1 => "preset value 1",
            Self::PresetValue2 => "preset value 2",
            Self::PresetAdjustment => "preset adjustment",
            Self::DataCheck => "data check",
            Self::Denominator => "revolutions denominator",
            Self::SsiValues => "SSI characteristic values",
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::Model;
    use std::vec::Vec;

    #[test]
    fn each_model_knows_the_services_of_its_manual() {
        let numbers = |model| -> Vec<u8> {
            (0..16).filter(|n| Service::from_number(*n).is_some_and(|s| s.known_to(model))).collect()
        };
        assert_eq!(numbers(Model::La66), [0x1, 0x2, 0x4, 0x6, 0x8]);
        assert_eq!(numbers(Model::Ce100M), [0x1, 0x2, 0x3, 0x4, 0x5, 0x6, 0x8, 0x9]);
        assert_eq!(numbers(Model::Ce65M), [0x1, 0x2, 0x3, 0x6, 0x8, 0x9, 0xD]);
    }

    #[test]
    fn every_service_has_a_name_of_its_own() {
        let mut names = SERVICES.map(Service::name);
        assert_eq!(names[0], "counting direction");
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1] && !pair[0].is_empty()));
    }

    #[test]
    fn numbers_and_services_come_back() {
        for service in SERVICES {
            assert_eq!(Service::from_number(service.number()), Some(service));
        }
    }
}
