//! The supply of a device, and what else surrounds it.

use encoring_encoder::{Terminals, preset_input};
use encoring_words::Model;

/// Below this many millivolts the device is off: 11 V less 5 % ripple [R121].
pub const OFF_BELOW_MV: u32 = 10_450;

/// Above this many millivolts the supply is too high: 27 V and 5 % ripple [R121].
pub const OVERVOLTAGE_ABOVE_MV: u32 = 28_350;

/// What surrounds a device at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surroundings {
    /// Shaft or magnet, and the preset inputs.
    pub terminals: Terminals,
    /// The supply in millivolts.
    pub supply_mv: u32,
}

impl Surroundings {
    /// Whether the supply suffices.
    #[must_use]
    pub const fn is_supplied(&self) -> bool {
        self.supply_mv >= OFF_BELOW_MV
    }

    /// Whether a preset input of this model gets more than [`preset_input::OVERVOLTAGE_ABOVE_MV`]; it reads 1 all the
    /// same.
    #[must_use]
    pub fn preset_overvoltage(&self, model: Model) -> bool {
        let inputs = self.terminals.preset_mv.iter().take(model.preset_inputs().len());
        inputs.into_iter().any(|millivolts| *millivolts > preset_input::OVERVOLTAGE_ABOVE_MV)
    }
}

impl Default for Surroundings {
    fn default() -> Self {
        Self { terminals: Terminals::default(), supply_mv: 24_000 }
    }
}
