//! The three encoders as data.

use core::fmt;
use core::str::FromStr;

use crate::sheet::{self, DataSheet};
use crate::time::Duration;

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

/// What measures: the part of an encoder that differs from one delivery to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// A shaft, with its steps per turn.
    Rotary {
        /// 4096, or 8192 with the option of the CE-65-M [R100].
        steps_per_turn: u32,
    },
    /// A rod, with the measuring length of its type label.
    Linear {
        /// In micrometres.
        rod_um: u32,
    },
}

/// Turns that a shaft's sensor tells apart without counting [R100].
pub const SENSOR_TURNS: u32 = 4096;

/// The longest rod whose factory resolution of 0.01 mm still fits 24 bits, in micrometres.
pub const ROD_UM_MAX: u32 = 167_772_150;

/// The shortest rod with at least one step, in micrometres.
pub const ROD_UM_MIN: u32 = 10;

/// A name that is not a model's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the models are la-66, ce-100-m and ce-65-m")]
pub struct UnknownModel;

impl Model {
    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::La66 => "la-66",
            Self::Ce100M => "ce-100-m",
            Self::Ce65M => "ce-65-m",
        }
    }

    /// Its name in the manuals.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::La66 => "LA-66",
            Self::Ce100M => "CE-100-M",
            Self::Ce65M => "CE-65-M",
        }
    }

    /// How often the position is refreshed: 1 ms, on the CE-65-M 0.5 ms [R8, R9]. The LA-66's manual is silent;
    /// 1 ms is this project's choice.
    #[must_use]
    pub const fn refresh(self) -> Duration {
        match self {
            Self::La66 | Self::Ce100M => Duration::from_micros(1_000),
            Self::Ce65M => Duration::from_micros(500),
        }
    }

    /// How many preset inputs it has [R66, R68, R72].
    #[must_use]
    pub const fn preset_inputs(self) -> usize {
        match self {
            Self::La66 => 1,
            Self::Ce100M => 2,
            Self::Ce65M => 0,
        }
    }

    /// The status bits that it may show [R94, R95].
    #[must_use]
    pub const fn status_mask(self) -> crate::ErrorStatus {
        crate::ErrorStatus::from_bits_truncate(match self {
            Self::La66 => 0x0020,
            Self::Ce100M => 0x638F,
            Self::Ce65M => 0x608F,
        })
    }

    /// Its data sheet.
    #[must_use]
    pub const fn data_sheet(self) -> &'static DataSheet {
        match self {
            Self::La66 => &sheet::LA_66,
            Self::Ce100M => &sheet::CE_100_M,
            Self::Ce65M => &sheet::CE_65_M,
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Model {
    type Err = UnknownModel;

    fn from_str(name: &str) -> Result<Self, UnknownModel> {
        MODELS.into_iter().find(|model| model.name() == name).ok_or(UnknownModel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_three_look_alike_on_the_ring() {
        for model in MODELS {
            assert_eq!((model.data_sheet().ident_code, model.data_sheet().words), (0x33, 2));
        }
    }

    #[test]
    fn the_la_66_sheet_is_empty_where_its_manual_is() {
        let sheet = Model::La66.data_sheet();
        assert_eq!(
            *sheet,
            DataSheet { document: sheet.document, ident_code: 51, words: 2, gray: false, ..sheet::LA_66 }
        );
        assert!(sheet.supply.is_none() && sheet.kilobaud.is_none() && sheet.refresh.is_none());
        assert!(sheet.connectors.is_empty() && sheet.lamps.is_empty() && sheet.ssi.is_none());
        assert!(sheet.preset_input.is_none() && sheet.temperature.is_none() && sheet.mechanics.is_none());
    }

    #[test]
    fn the_pins_that_matter_stand_where_the_manuals_put_them() {
        let pin = |model: Model, connector: &str, pin: usize| {
            let connectors = model.data_sheet().connectors;
            let found = connectors.iter().find(|c| c.name.starts_with(connector)).unwrap();
            found.pins[pin - 1]
        };
        assert_eq!(pin(Model::Ce65M, "X1", 6), "opto input, negative SSI clock");
        assert_eq!(pin(Model::Ce65M, "X2", 1), "opto input, positive SSI clock");
        assert_eq!(pin(Model::Ce65M, "X3", 6), "RBST inverted");
        assert_eq!(pin(Model::Ce100M, "REMOTE OUT", 9), "RBST (a further participant follows)");
        assert_eq!(pin(Model::Ce100M, "supply", 5), "preset 1");
        assert_eq!(pin(Model::Ce100M, "supply", 14), "US supply");
    }

    #[test]
    fn figures_that_follow_from_the_sheet() {
        let sheet = Model::Ce65M.data_sheet();
        let mechanics = sheet.mechanics.unwrap();
        // 6000 rpm at 4096 steps: 204.8 steps in one refresh of 0.5 ms [R124].
        let steps_per_s = u64::from(mechanics.speed_rpm) / 60 * 4096;
        assert_eq!(steps_per_s, 409_600);
        assert_eq!(steps_per_s * sheet.refresh.unwrap().as_nanos() / 100_000_000, 2_048);
        assert_eq!(mechanics.bearing_life_revolutions / (3_000 * 60), 216_666);
        let supply = sheet.supply.unwrap();
        let (low_ma, high_ma) = supply.milliamperes.unwrap();
        assert_eq!(supply.millivolts.0 * u32::from(low_ma), 3_850_000);
        assert_eq!(supply.millivolts.1 * u32::from(high_ma), 4_050_000);
    }

    #[test]
    fn titles_and_preset_inputs_are_those_of_the_manuals() {
        assert_eq!(MODELS.map(Model::title), ["LA-66", "CE-100-M", "CE-65-M"]);
        assert_eq!(MODELS.map(Model::preset_inputs), [1, 2, 0]);
        assert_eq!(Model::Ce65M.data_sheet().temperature.unwrap().storage, (-30, 80));
    }

    #[test]
    fn names_come_back() {
        extern crate std;
        use std::string::ToString;
        for model in MODELS {
            assert_eq!(model.to_string().parse(), Ok(model));
        }
        assert_eq!("ce-65".parse::<Model>(), Err(UnknownModel));
    }
}
