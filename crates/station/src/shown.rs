//! A ring that a face shows and that verbs are said to, whatever it is.

use encoring_words::Model;
use encoring_words::model::Sensor;
use serde::Serialize;
use serde_json::Value;

use crate::answer::{ToldBack, answer_within};
use crate::controlled::Controlled;
use crate::events::RingEvent;
use crate::history::WordHistory;
use crate::known::KnownFile;
use crate::station::RingStopped;
use crate::verbs::Permission;

/// A ring that a face shows and that verbs are said to: simulated in this process, or behind a bus.
pub trait ShownRing: Send + Sync {
    /// Which ring it is.
    fn about(&self) -> AboutRing;

    /// Its encoders, in the order of their positions.
    fn units(&self) -> Vec<ShownUnit>;

    /// The ring at this moment, as JSON. May wait for up to a cycle.
    ///
    /// # Errors
    /// [`RingStopped`] if nobody looks at the ring any more.
    fn seen(&self) -> Result<Value, RingStopped>;

    /// Each change of the words of each encoder.
    fn history(&self) -> &WordHistory;

    /// The events from number `from` on, as far as they are kept.
    ///
    /// # Errors
    /// [`RingStopped`] if nobody looks at the ring any more.
    fn happened(&self, from: u64) -> Result<Vec<RingEvent>, RingStopped>;

    /// Reads one line, does what it asks if it is permitted, and gives the answer. Waits for the ring.
    fn told(&self, line: &str, permission: Permission) -> ToldBack;
}

/// Which ring it is that is shown.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AboutRing {
    /// The address of the bus; `None` for a ring that is simulated in this process.
    pub bus: Option<String>,
    /// `true` if nothing of it is real.
    pub simulated: bool,
    /// Time from poll to poll; `None` where every cycle is seen.
    pub poll_ns: Option<u64>,
}

/// What is known of an encoder before anything of it was seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownUnit {
    /// Its ring position.
    pub position: usize,
    /// Its model.
    pub model: Model,
    /// What it measures with, if that is known.
    pub sensor: Option<Sensor>,
    /// Week of its firmware, if that is known.
    pub firmware: Option<String>,
    /// The file that says something of it.
    pub file: Option<KnownFile>,
}

impl ShownRing for Controlled {
    fn about(&self) -> AboutRing {
        AboutRing { bus: None, simulated: true, poll_ns: None }
    }

    fn units(&self) -> Vec<ShownUnit> {
        let units = self.units.iter().enumerate().map(|(position, unit)| ShownUnit {
            position,
            model: unit.model(),
            sensor: Some(unit.sensor()),
            firmware: Some(unit.firmware.to_string()),
            file: None,
        });
        units.collect()
    }

    fn seen(&self) -> Result<Value, RingStopped> {
        // Plain data with names for keys has no reason to fail.
        Ok(serde_json::to_value(self.ring.view()?).unwrap_or_default())
    }

    fn history(&self) -> &WordHistory {
        self.ring.history()
    }

    fn happened(&self, from: u64) -> Result<Vec<RingEvent>, RingStopped> {
        self.ring.events(from)
    }

    fn told(&self, line: &str, permission: Permission) -> ToldBack {
        answer_within(line, self, permission)
    }
}
