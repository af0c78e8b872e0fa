//! The three encoders as data: one entry for each, from which everything that differs between them is looked up.
//!
//! Nothing else in the product asks which model it has before it: it asks for a property. A further model is a
//! further variant of [`Model`], its entry here, and its data sheet in [`crate::sheet`].

use core::fmt;
use core::str::FromStr;

use crate::ErrorStatus;
use crate::service::{Access, Service};
use crate::sheet::{self, DataSheet, Mechanics, StepChange};
use crate::time::Duration;
use crate::word::{DATA_MAX, ServiceNumber};

mod listed;
mod sensor;

pub use listed::{Allowed, Demand, Listed, Takes};
pub use sensor::{ROD_UM_MAX, ROD_UM_MIN, SENSOR_TURNS, Sensor, SensorError, SensorKind};

use listed::Factory;

/// One of the three encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Model {
    /// Linear absolute encoder LA-66: a rod with a magnet.
    La66,
    /// Rotary multi-turn encoder CE-100-M.
    Ce100M,
    /// Rotary multi-turn encoder CE-65-M with SSI output.
    Ce65M,
}

/// Every model.
pub const MODELS: [Model; 3] = [Model::La66, Model::Ce100M, Model::Ce65M];

/// What the manual of a model says; where it is silent, what this project chose.
struct Entry {
    name: &'static str,
    /// What a type label may leave out of the name.
    short: &'static str,
    title: &'static str,
    sensor: SensorKind,
    /// Of a shaft, the usual and smallest number first.
    steps_per_turn: &'static [u32],
    services: &'static [Listed],
    effect: Effect,
    status_mask: u16,
    /// The service of the value that each preset input adjusts to.
    preset_inputs: &'static [Service],
    /// For the limits of a movement, where its own manual gives none.
    assumed_mechanics: Option<Mechanics>,
    /// For steps that are none of the shaft, where its own manual has no table of them.
    assumed_step_changes: &'static [StepChange],
    sheet: &'static DataSheet,
}

static LA_66: Entry = Entry {
    name: "la-66",
    short: "la-66",
    title: "LA-66",
    sensor: SensorKind::Linear,
    steps_per_turn: &[],
    // [R42, R44, R49, R65..R67, R74, R77]
    services: &[
        Listed::value(Service::CountingDirection, Takes::number(0, 1), 0),
        Listed {
            factory: Factory::HundredthsOfAMillimetre,
            ..Listed::value(Service::MeasuringLength, Takes::number(1, DATA_MAX), 1)
        },
        Listed::value(Service::PresetValue1, Takes::number(0, DATA_MAX), 0),
        Listed::preset_adjustment(Takes::number(0, DATA_MAX)),
        Listed::DATA_CHECK,
    ],
    effect: Effect::AtOnce,
    status_mask: 0x0020,
    preset_inputs: &[Service::PresetValue1],
    assumed_mechanics: None,
    assumed_step_changes: &[],
    sheet: &sheet::LA_66,
};

static CE_100_M: Entry = Entry {
    name: "ce-100-m",
    short: "ce-100",
    title: "CE-100-M",
    sensor: SensorKind::Rotary,
    steps_per_turn: &[4096],
    // [R42, R53, R54, R57, R58, R67, R75, R78, R90]
    services: &[
        Listed::value(Service::CountingDirection, Takes::number(0, 1), 0),
        Listed::value(Service::MeasuringLength, Takes::number(0x10, DATA_MAX), DATA_MAX),
        Listed::value(Service::Numerator, NUMERATOR, SENSOR_TURNS),
        Listed::value(Service::PresetValue1, up_to_length(ErrorStatus::PRESET_1_RANGE), 0),
        Listed::value(Service::PresetValue2, up_to_length(ErrorStatus::PRESET_2_RANGE), 0),
        Listed::preset_adjustment(Takes::UpToMeasuringLength),
        Listed::DATA_CHECK,
        Listed::value(Service::Denominator, Takes::number(1, 0x63), 1),
    ],
    effect: Effect::AtDataCheck,
    status_mask: 0x638F,
    preset_inputs: &[Service::PresetValue1, Service::PresetValue2],
    assumed_mechanics: sheet::CE_65_M.mechanics,
    assumed_step_changes: sheet::CE_65_M.step_changes,
    sheet: &sheet::CE_100_M,
};

static CE_65_M: Entry = Entry {
    name: "ce-65-m",
    short: "ce-65",
    title: "CE-65-M",
    sensor: SensorKind::Rotary,
    steps_per_turn: &[4096, 8192],
    // [R46, R53, R54, R57, R58, R75, R78, R113, R115]
    services: &[
        Listed::value(Service::CountingDirection, Takes::DirectionAndCode, 0),
        Listed::value(Service::MeasuringLength, Takes::number(0x10, DATA_MAX), DATA_MAX),
        Listed::value(Service::Numerator, NUMERATOR, SENSOR_TURNS),
        Listed::preset_adjustment(Takes::UpToMeasuringLength),
        Listed::DATA_CHECK,
        Listed::value(Service::Denominator, Takes::number(1, 0x63), 1),
        Listed::value(Service::SsiValues, Takes::SsiValues { fewest_bits: 0x08, most_bits: 0x20 }, 24),
    ],
    effect: Effect::AtDataCheck,
    status_mask: 0x608F,
    preset_inputs: &[],
    assumed_mechanics: None,
    assumed_step_changes: &[],
    sheet: &sheet::CE_65_M,
};

/// 0 is stored, and an error as long as it stands [R57, R92, C6].
const NUMERATOR: Takes =
    Takes::Number { low: 0, high: 0xFFFF, demand: Demand::NotZero(ErrorStatus::NUMERATOR_ZERO) };

/// A preset that is compared with the measuring length only at the data check [R67, R70, R90].
const fn up_to_length(status: ErrorStatus) -> Takes {
    Takes::Number { low: 0, high: DATA_MAX, demand: Demand::UpToMeasuringLength(status) }
}

/// When a programmed value begins to count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// With the reply: every accepted value is valid, and the data check takes nothing over [R77, C8].
    AtOnce,
    /// With a data check or a power-up that finds all values good together [R79, R80].
    AtDataCheck,
}

impl Model {
    const fn entry(self) -> &'static Entry {
        match self {
            Self::La66 => &LA_66,
            Self::Ce100M => &CE_100_M,
            Self::Ce65M => &CE_65_M,
        }
    }

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.entry().name
    }

    /// Its name in the manuals.
    #[must_use]
    pub const fn title(self) -> &'static str {
        self.entry().title
    }

    /// What it measures with.
    #[must_use]
    pub const fn sensor_kind(self) -> SensorKind {
        self.entry().sensor
    }

    /// The steps per turn that it can be built with, the usual and smallest number first; none for a rod [R99, R100].
    #[must_use]
    pub const fn steps_per_turn(self) -> &'static [u32] {
        self.entry().steps_per_turn
    }

    /// The services that its manual lists, by number.
    #[must_use]
    pub const fn services(self) -> &'static [Listed] {
        self.entry().services
    }

    /// What its manual says of a service; `None` if it does not list it [R65, R72, R89].
    #[must_use]
    pub const fn lists(self, service: Service) -> Option<&'static Listed> {
        let mut services = self.services();
        while let [listed, others @ ..] = services {
            if listed.service as u8 == service as u8 {
                return Some(listed);
            }
            services = others;
        }
        None
    }

    /// What its manual says of a service that is requested.
    ///
    /// # Errors
    /// The status bit of a request that it refuses whatever its data are [R87..R89].
    pub const fn admits(
        self,
        service: ServiceNumber,
        access: Access,
    ) -> Result<&'static Listed, ErrorStatus> {
        let ServiceNumber::Known(service) = service else { return Err(ErrorStatus::UNKNOWN_COMMAND) };
        match (self.lists(service), access) {
            (None, _) => Err(ErrorStatus::UNKNOWN_COMMAND),
            (Some(Listed { allowed: Allowed::Reading, .. }), Access::Write) => Err(ErrorStatus::ONLY_READING),
            (Some(Listed { allowed: Allowed::Writing, .. }), Access::Read) => Err(ErrorStatus::ONLY_WRITING),
            (Some(listed), _) => Ok(listed),
        }
    }

    /// When a programmed value begins to count.
    #[must_use]
    pub const fn effect(self) -> Effect {
        self.entry().effect
    }

    /// The status bits that it may show [R94, R95].
    #[must_use]
    pub const fn status_mask(self) -> ErrorStatus {
        ErrorStatus::from_bits_truncate(self.entry().status_mask)
    }

    /// `true` if its status tells a request that it refused, and a record that it could not read or write.
    #[must_use]
    pub const fn tells_refusals(self) -> bool {
        let faults = ErrorStatus::READING_DATA.union(ErrorStatus::WRITING_DATA);
        self.status_mask().contains(faults.union(ErrorStatus::UNKNOWN_COMMAND))
    }

    /// How often the position is refreshed [R8, R9]. Where the manual is silent, 1 ms is this project's choice.
    #[must_use]
    pub const fn refresh(self) -> Duration {
        match self.data_sheet().refresh {
            Some(stated) => stated,
            None => Duration::from_millis(1),
        }
    }

    /// Its preset inputs: the service of the value that each adjusts to [R66, R68, R72].
    #[must_use]
    pub const fn preset_inputs(self) -> &'static [Service] {
        self.entry().preset_inputs
    }

    /// `true` if service 01 can program the position on the bus to Gray code [R46].
    #[must_use]
    pub const fn position_may_be_gray(self) -> bool {
        matches!(self.lists(Service::CountingDirection), Some(Listed { takes: Takes::DirectionAndCode, .. }))
    }

    /// `true` if it shows its position on an SSI as well [R103].
    #[must_use]
    pub const fn has_ssi_output(self) -> bool {
        self.data_sheet().ssi.is_some()
    }

    /// The largest position while `length` is the active measuring length: that, but on a rod, where a preset can
    /// put any 24-bit value [R74].
    #[must_use]
    pub const fn largest_position(self, length: u32) -> u32 {
        match self.sensor_kind() {
            SensorKind::Rotary => length,
            SensorKind::Linear => DATA_MAX,
        }
    }

    /// Mechanical limits: its own, or where its manual gives none those that are assumed of it; `None` without both.
    #[must_use]
    pub const fn mechanics(self) -> Option<Mechanics> {
        match self.data_sheet().mechanics {
            Some(stated) => Some(stated),
            None => self.entry().assumed_mechanics,
        }
    }

    /// Causes of steps that are none of the shaft: those of its own manual, or where that has none those that are
    /// assumed of it; none without both [R150..R153].
    #[must_use]
    pub const fn step_changes(self) -> &'static [StepChange] {
        match self.data_sheet().step_changes {
            [] => self.entry().assumed_step_changes,
            stated => stated,
        }
    }

    /// Its data sheet.
    #[must_use]
    pub const fn data_sheet(self) -> &'static DataSheet {
        self.entry().sheet
    }

    /// What is simulated where nobody says what the encoder is built with: the usual steps per turn, or a rod of
    /// 500 mm, which is this project's choice.
    #[must_use]
    pub const fn usual_sensor(self) -> Sensor {
        match self.steps_per_turn() {
            [usual, ..] => Sensor::Rotary { steps_per_turn: *usual },
            [] => Sensor::Linear { rod_um: 500_000 },
        }
    }

    /// The same with the most steps per turn.
    #[must_use]
    pub const fn finest_sensor(self) -> Sensor {
        match self.steps_per_turn() {
            [.., finest] => Sensor::Rotary { steps_per_turn: *finest },
            [] => self.usual_sensor(),
        }
    }

    /// The sensor that somebody describes by its steps per turn or by the length of its rod; the usual one if by
    /// neither.
    ///
    /// # Errors
    /// [`SensorError`] if the model is not built like that.
    pub const fn sensor(
        self,
        steps_per_turn: Option<u32>,
        rod_um: Option<u32>,
    ) -> Result<Sensor, SensorError> {
        match (steps_per_turn, rod_um) {
            (None, None) => Ok(self.usual_sensor()),
            (Some(steps_per_turn), None) => self.built_with(Sensor::Rotary { steps_per_turn }),
            (None, Some(rod_um)) => self.built_with(Sensor::Linear { rod_um }),
            (Some(_), Some(_)) => Err(SensorError::OtherKind { model: self }),
        }
    }

    /// `sensor`, if the model can be built with it.
    ///
    /// # Errors
    /// [`SensorError`] if it cannot.
    pub const fn built_with(self, sensor: Sensor) -> Result<Sensor, SensorError> {
        match (self.sensor_kind(), sensor) {
            (SensorKind::Rotary, Sensor::Rotary { steps_per_turn }) => {
                let mut options = self.steps_per_turn();
                while let [option, others @ ..] = options {
                    if *option == steps_per_turn {
                        return Ok(sensor);
                    }
                    options = others;
                }
                Err(SensorError::StepsPerTurn { model: self, steps_per_turn })
            }
            (SensorKind::Linear, Sensor::Linear { rod_um: ROD_UM_MIN..=ROD_UM_MAX }) => Ok(sensor),
            (SensorKind::Linear, Sensor::Linear { rod_um }) => Err(SensorError::RodLength { rod_um }),
            _ => Err(SensorError::OtherKind { model: self }),
        }
    }
}

impl Service {
    /// `true` if this model's manual lists the service [R65, R72, R89].
    #[must_use]
    pub const fn known_to(self, model: Model) -> bool {
        model.lists(self).is_some()
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is not a model's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownModel;

impl fmt::Display for UnknownModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the models are {}", Series(&MODELS, "and"))
    }
}

impl core::error::Error for UnknownModel {}

impl FromStr for Model {
    type Err = UnknownModel;

    /// As a type label or a person writes it: `ce-65-m`, `CE-65-M`, `CE 65 M`, `CE65M`, `CE65`.
    fn from_str(label: &str) -> Result<Self, UnknownModel> {
        let named = |name| letters(name).eq(letters(label));
        let found = MODELS.into_iter().find(|model| named(model.entry().name) || named(model.entry().short));
        found.ok_or(UnknownModel)
    }
}

/// What tells one label from another.
fn letters(label: &str) -> impl Iterator<Item = char> {
    let joins = |letter: &char| letter.is_whitespace() || matches!(letter, '-' | '_');
    label.chars().filter(move |letter| !joins(letter)).map(|letter| letter.to_ascii_lowercase())
}

/// Things in a sentence, with a word before the last: `a, b and c`.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a, T>(pub &'a [T], pub &'static str);

impl<T: fmt::Display> fmt::Display for Series<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(things, word) = self;
        match things {
            [] => Ok(()),
            [only] => only.fmt(f),
            [first, others @ .., last] => {
                write!(f, "{first}")?;
                others.iter().try_for_each(|thing| write!(f, ", {thing}"))?;
                write!(f, " {word} {last}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // [R2]
    #[test]
    fn all_three_look_alike_on_the_ring() {
        for model in MODELS {
            assert_eq!((model.data_sheet().ident_code, model.data_sheet().words), (0x33, 2));
        }
    }

    #[test]
    fn titles_and_preset_inputs_are_those_of_the_manuals() {
        assert_eq!(MODELS.map(Model::title), ["LA-66", "CE-100-M", "CE-65-M"]);
        assert_eq!(MODELS.map(|model| model.preset_inputs().len()), [1, 2, 0]);
        assert_eq!(MODELS.map(Model::has_ssi_output), [false, false, true]);
        assert_eq!(MODELS.map(Model::position_may_be_gray), [false, false, true]);
        assert_eq!(Model::Ce65M.data_sheet().temperature.unwrap().storage, (-30, 80));
    }

    #[test]
    fn names_come_back() {
        extern crate std;
        use std::string::ToString;
        for model in MODELS {
            assert_eq!(model.to_string().parse(), Ok(model));
        }
    }

    #[test]
    fn a_model_is_read_as_type_labels_have_it() {
        for (model, labels) in [
            (Model::La66, ["la-66", "LA-66", "LA 66", "LA66", "la_66", " LA-66 "].as_slice()),
            (Model::Ce100M, &["CE-100-M", "CE 100 M", "CE100M", "CE100", "ce-100", "CE-100M"]),
            (Model::Ce65M, &["CE-65-M", "CE 65 M", "CE65M", "CE65", "ce-65", "CE 65-M", "ce_65_m"]),
        ] {
            for label in labels {
                assert_eq!(label.parse(), Ok(model), "{label}");
            }
        }
        for wrong in ["", "-", "ce", "ce-66", "la-66-m", "ce-65-s", "65", "ce-58-m", "CE\u{2212}65"] {
            assert_eq!(wrong.parse::<Model>(), Err(UnknownModel), "{wrong}");
        }
    }

    #[test]
    fn services_and_steps_per_turn_rise() {
        for model in MODELS {
            let steps_per_turn = model.steps_per_turn();
            assert!(steps_per_turn.is_sorted_by(|a, b| a < b) && !steps_per_turn.contains(&0), "{model}");
            assert!(model.preset_inputs().iter().all(|value| value.known_to(model)), "{model}");
            let numbers = model.services().iter().map(|listed| listed.service.number());
            assert!(numbers.is_sorted_by(|a, b| a < b), "{model}");
        }
    }

    #[test]
    fn every_status_that_a_value_can_get_lies_in_the_mask() {
        for model in MODELS {
            for listed in model.services() {
                let status = listed.takes.invalid_beside(0, 0) | listed.takes.invalid_beside(DATA_MAX, 0);
                assert!(model.status_mask().contains(status), "{model} {:?}", listed.service);
            }
        }
    }

    #[test]
    fn the_refresh_and_the_mechanics_are_stated_or_assumed() {
        assert_eq!(MODELS.map(|model| model.refresh().as_nanos()), [1_000_000, 1_000_000, 500_000]);
        assert_eq!(MODELS.map(|model| model.data_sheet().refresh.is_some()), [false, true, true]);
        assert_eq!(
            MODELS.map(|model| model.mechanics().map(|limits| limits.speed_rpm)),
            [None, Some(6000), Some(6000)]
        );
        assert_eq!(MODELS.map(|model| model.data_sheet().mechanics.is_some()), [false, false, true]);
    }

    #[test]
    fn things_stand_in_a_sentence() {
        extern crate std;
        use std::string::ToString;
        let series = |things| Series(things, "or").to_string();
        assert_eq!([&[][..], &[1], &[1, 2], &[1, 2, 3]].map(series), ["", "1", "1 or 2", "1, 2 or 3"]);
        assert_eq!(UnknownModel.to_string(), "the models are la-66, ce-100-m and ce-65-m");
    }
}
