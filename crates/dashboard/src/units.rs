//! What does not change of each encoder: what its model is and can.

use encoring_station::known::KnownFile;
use encoring_station::shown::ShownUnit;
use encoring_words::model::{Allowed, Effect, Sensor, SensorKind};
use serde::Serialize;

/// An encoder as it was delivered.
#[derive(Serialize)]
struct UnitView {
    position: usize,
    model: &'static str,
    title: &'static str,
    /// `rotary` or `linear`.
    kind: &'static str,
    /// Of a shaft.
    steps_per_turn: Option<u32>,
    /// Of a rod.
    rod_um: Option<u32>,
    firmware: Option<String>,
    preset_inputs: usize,
    ssi: bool,
    /// Whether the position may be in Gray code, which service 01 chooses.
    gray: bool,
    /// Whether programmed values count at once, without a data check.
    at_once: bool,
    services: Vec<ServiceView>,
    connectors: Vec<ConnectorView>,
    /// The two pins that a plug must join so that the next device is found.
    jumper: Option<JumperView>,
    supply_mv: Option<(u32, u32)>,
    /// What a file says of it.
    file: Option<KnownFile>,
    /// Why positions jump, and what helps, as the manual has it.
    step_changes: Vec<StepChangeView>,
}

/// A cause of jumps.
#[derive(Serialize)]
struct StepChangeView {
    cause: &'static str,
    remedy: &'static str,
}

/// A connector, as its manual has it.
#[derive(Serialize)]
struct ConnectorView {
    name: &'static str,
    /// Signals by pin, from 1.
    pins: &'static [&'static str],
}

/// Where the jumper for the next device is.
#[derive(Serialize)]
struct JumperView {
    connector: &'static str,
    pins: (u8, u8),
}

/// A service that its manual lists.
#[derive(Serialize)]
struct ServiceView {
    number: u8,
    read: bool,
    write: bool,
    range: Option<(u32, u32)>,
}

impl UnitView {
    fn of(unit: ShownUnit) -> Self {
        let ShownUnit { position, model, sensor, firmware, file } = unit;
        let (steps_per_turn, rod_um) = match sensor {
            Some(Sensor::Rotary { steps_per_turn }) => (Some(steps_per_turn), None),
            Some(Sensor::Linear { rod_um }) => (None, Some(rod_um)),
            None => (None, None),
        };
        let sheet = model.data_sheet();
        let services = model.services().iter().map(|listed| ServiceView {
            number: listed.service.number(),
            read: listed.allowed != Allowed::Writing,
            write: listed.allowed != Allowed::Reading,
            range: encoring_words::Parameter::from_service(listed.service)
                .and_then(|parameter| parameter.range(model)),
        });
        Self {
            position,
            model: model.name(),
            title: model.title(),
            kind: match model.sensor_kind() {
                SensorKind::Rotary => "rotary",
                SensorKind::Linear => "linear",
            },
            steps_per_turn,
            rod_um,
            firmware,
            preset_inputs: model.preset_inputs().len(),
            ssi: model.has_ssi_output(),
            gray: model.position_may_be_gray(),
            at_once: model.effect() == Effect::AtOnce,
            services: services.collect(),
            connectors: sheet
                .connectors
                .iter()
                .map(|at| ConnectorView { name: at.name, pins: at.pins })
                .collect(),
            jumper: sheet
                .next_device_jumper
                .map(|(connector, from, to)| JumperView { connector, pins: (from, to) }),
            supply_mv: sheet.supply.map(|supply| supply.millivolts),
            file,
            step_changes: model
                .step_changes()
                .iter()
                .map(|step| StepChangeView { cause: step.cause, remedy: step.remedy })
                .collect(),
        }
    }
}

/// All of them, as JSON.
pub(crate) fn in_json(units: Vec<ShownUnit>) -> String {
    let views: Vec<UnitView> = units.into_iter().map(UnitView::of).collect();
    // Plain data with names for keys has no reason to fail.
    serde_json::to_string(&views).unwrap_or_default()
}
