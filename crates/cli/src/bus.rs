//! The ring that a command works on: simulated in this process, or real behind a Modbus gateway.

use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_bus::{Behind, Bus, BusError, Cause, EncoderMaster, Link};
use encoring_encoder::Unit;
use encoring_modbus::address::DiagnosisPlaces;
use encoring_modbus::{Address, Client};
use encoring_sim::state::StateFolder;
use encoring_sim::{Scenario, World};
use encoring_station::{SharedWorld, Simulated, Speed};
use encoring_words::model::Sensor;
use encoring_words::{Duration, OutWord};
use serde::Serialize;

use crate::arguments::bus::{BusArguments, Encoder, Source, Target, patience};
use crate::arguments::{Output, TypeLabel, built_with};
use crate::interrupt::{Interrupt, service_bit_left};
use crate::memories::{can_be_written, not_saved};
use crate::output::{Answer, Failure, Format, bad_input, note};
use crate::told::{Failed, FailureView};

/// A ring, wherever it is.
pub(crate) type AnyBus = dyn Bus + Send;

/// A ring that is open, and what has to be done when it is closed.
pub(crate) struct Opened {
    pub(crate) bus: Box<AnyBus>,
    /// What is behind a simulated ring; `None` behind a gateway, where nobody can tell.
    pub(crate) world: Option<SharedWorld>,
    /// As it was named.
    pub(crate) address: String,
    /// Where the gateway shows what the ring's master says, as the address names it.
    pub(crate) diagnosis: DiagnosisPlaces,
    /// How long a lost answer takes; nothing on a simulated ring.
    timeout: Duration,
    memories: Option<StateFolder>,
    interrupt: Interrupt,
    /// The encoder and the word with the service bit that was not seen gone.
    left: Option<(usize, OutWord)>,
    /// Host and port, or the device; a simulated ring as it was named.
    place: String,
    /// See [`Opened::identity`].
    identity: Option<String>,
}

/// A report with what every report of a master says.
#[derive(Serialize)]
struct Reported<'a, V> {
    #[serde(flatten)]
    view: &'a V,
    service_bit_left: Option<String>,
}

/// What a command does with an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deed {
    Reads,
    Changes,
}

/// The scenario of a simulated ring; `None` if the address is that of another ring.
pub(crate) fn simulated_ring(address: &str) -> Result<Option<Scenario>, Failure> {
    match address.split_once(':') {
        None if address == "sim" => scenario(None).map(Some),
        Some(("sim", file)) => scenario(Some(file.as_ref())).map(Some),
        _ => Ok(None),
    }
}

/// The scenario of a file, or else the built-in one. What was assumed of its motions is told.
pub(crate) fn scenario(file: Option<&Path>) -> Result<Scenario, Failure> {
    let scenario = file.map_or_else(Scenario::built_in, Scenario::read).map_err(bad_input)?;
    scenario.notes.iter().for_each(|assumed| note(&format!("note: {assumed}")));
    Ok(scenario)
}

/// The address of a gateway.
#[expect(clippy::disallowed_methods, reason = "the address of a bus")]
pub(crate) fn gateway(address: &str) -> Result<Address, Failure> {
    let known = address.starts_with("modbus");
    let or = if known { "" } else { "; or sim, or sim:SCENARIO.toml" };
    address.parse().map_err(|error| bad_input(format!("--bus {address}: {error}{or}")))
}

impl BusArguments {
    /// Opens the ring. `speed` is that of a simulated one.
    pub(crate) fn open(&self, speed: Speed) -> Result<Opened, Failure> {
        let address = self.place.get()?;
        let interrupt = Interrupt::new()?;
        let address = address.to_owned();
        match simulated_ring(&address)? {
            Some(scenario) => {
                let (bus, memories) = self.simulated(&scenario, speed)?;
                let world = Some(bus.world().clone());
                let (place, timeout) = (address.clone(), Duration::ZERO);
                let folder = self.memories.state.as_ref();
                let identity = folder.and_then(|folder| folder.canonicalize().ok());
                let identity = identity.map(|folder| format!("sim in {}", folder.display()));
                Ok(Opened {
                    bus: Box::new(bus),
                    world,
                    address,
                    diagnosis: DiagnosisPlaces::default(),
                    timeout,
                    memories,
                    interrupt,
                    left: None,
                    place,
                    identity,
                })
            }
            None => {
                if self.memories.state.is_some() {
                    return Err(bad_input(
                        "--state is for simulated rings; a real encoder keeps its own memory",
                    ));
                }
                let gateway = gateway(&address)?;
                let (timeout, place) = (gateway.timeout, gateway.way.to_string());
                let identity = Some(format!("{place} unit {}", gateway.unit));
                let diagnosis = gateway.diagnosis;
                let (bus, world, memories) = (Box::new(Client::new(gateway)?), None, None);
                let left = None;
                Ok(Opened {
                    bus,
                    world,
                    address,
                    diagnosis,
                    timeout,
                    memories,
                    interrupt,
                    left,
                    place,
                    identity,
                })
            }
        }
    }

    fn simulated(
        &self,
        scenario: &Scenario,
        speed: Speed,
    ) -> Result<(Simulated, Option<StateFolder>), Failure> {
        let mut world = World::new(scenario).map_err(bad_input)?;
        let memories = self.memories.open(&mut world)?;
        let mut bus = Simulated::new(world, speed);
        if cfg!(debug_assertions) {
            // In every test of a command.
            bus.look_on_strictly();
        }
        Ok((bus, memories))
    }
}

impl Encoder {
    /// The same for a command that changes something in the encoder, which has to be remembered.
    pub(crate) fn open_to_change(&self) -> Result<(Opened, Target), Failure> {
        let (opened, target) = self.open()?;
        if let Some(folder) = &opened.memories {
            can_be_written(folder)?;
        }
        Ok((opened, target))
    }

    /// Opens the ring, and says which encoder is meant.
    pub(crate) fn open(&self) -> Result<(Opened, Target), Failure> {
        let position =
            self.at.ok_or_else(|| bad_input("--at POSITION is missing; positions count from 0"))?;
        let opened = self.ring.open(Speed::Max)?;
        let patience = patience(self.patience, opened.timeout)?;
        let target = self.label.target(&opened, position, patience)?;
        Ok((opened, target))
    }
}

impl TypeLabel {
    /// The encoder at a position, as the ring knows it, or as this label says.
    pub(crate) fn target(
        self,
        opened: &Opened,
        position: usize,
        patience: Duration,
    ) -> Result<Target, Failure> {
        let Self { model, native: given } = self;
        let (model, native, source) = match opened.unit(position)? {
            Some(unit) => {
                let native = match unit.sensor() {
                    Sensor::Rotary { steps_per_turn } => Some(steps_per_turn),
                    Sensor::Linear { .. } => None,
                };
                if let Some(model) = model.filter(|model| *model != unit.model()) {
                    return Err(bad_input(format!(
                        "--model {model}: the encoder at position {position} is a {}",
                        unit.model()
                    )));
                }
                (unit.model(), given.or(native), Source::Ring)
            }
            None => {
                let model = model.ok_or_else(|| {
                    bad_input(
                        "--model MODEL is missing: no word of an encoder shows its model, so read it from the type label",
                    )
                })?;
                (model, given, Source::User)
            }
        };
        if let Some(native) = native {
            built_with(model, native)?;
        }
        Ok(Target { position, model, native, source, patience })
    }
}

impl Opened {
    /// What is simulated at a position; `None` behind a gateway, where nobody knows.
    pub(crate) fn unit(&self, position: usize) -> Result<Option<Unit>, Failure> {
        let Some(world) = &self.world else { return Ok(None) };
        world.with(|world| {
            let encoders = world.places().len();
            match world.places().get(position) {
                Some(place) => Ok(Some(*place.node().unit())),
                None => {
                    Err(bad_input(format!("--at {position}: {}", BusError::NoEncoder { position, encoders })))
                }
            }
        })
    }

    /// `true` if nothing here is real.
    pub(crate) const fn is_simulated(&self) -> bool {
        self.world.is_some()
    }

    /// What is to be said once where nobody can tell whether the ring runs.
    pub(crate) fn untold_ring(&self) -> Option<&'static str> {
        let told = self.is_simulated() || self.diagnosis.status.is_some();
        (!told).then_some(
            "this gateway does not tell whether the ring runs: a stopped ring, or an encoder without supply, looks like one at \
             rest; if it shows the master's diagnostic registers, name them in the address: \
             status=holding:N&parameter=holding:N",
        )
    }

    /// Says what a user must know before the first service.
    pub(crate) fn announce(&self, target: Target, deed: Deed) {
        if !self.is_simulated() {
            note(&format!(
                "note: the OUT word of position {} is needed for this: the PLC must not write it meanwhile",
                target.position
            ));
        } else if deed == Deed::Changes && self.memories.is_none() {
            note(&format!(
                "note: {} is a ring of this command alone, and forgets at its end; --state DIR keeps its memories, and \
                 `encoring sim` runs one that stays: --bus modbus-tcp://127.0.0.1:5020",
                self.address
            ));
        }
    }

    /// The command changes nothing: it may end while it waits for whoever reads its output.
    pub(crate) fn only_looks(&self) {
        self.interrupt.only_looks();
    }

    /// The mark that Ctrl-C sets.
    pub(crate) fn stop(&self) -> Arc<AtomicBool> {
        self.interrupt.stop()
    }

    /// The signals of this process.
    pub(crate) fn interruption(&self) -> Interrupt {
        self.interrupt.clone()
    }

    /// Whether the user has wanted to stop.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.is_interrupted()
    }

    /// The ring, written alike however its address is; none for a simulated one that forgets.
    pub(crate) fn identity(&self) -> Option<String> {
        self.identity.clone()
    }

    /// Host and port, or the device.
    pub(crate) fn place(&self) -> String {
        self.place.clone()
    }

    /// How long a lost answer takes.
    pub(crate) const fn timeout(&self) -> Duration {
        self.timeout
    }

    /// Lets a master work on an encoder; what it fails with becomes the command's failure.
    pub(crate) fn serve<T>(
        &mut self,
        target: Target,
        work: impl FnOnce(&mut EncoderMaster<'_, AnyBus>) -> Result<T, Failed>,
    ) -> Result<T, Failure> {
        let stop = self.stop();
        let place = self.place();
        let failure = |failed: &Failed, behind: Option<Behind>| {
            FailureView::new(failed, target, behind.as_ref()).at(&place).into_failure()
        };
        let mut master = EncoderMaster::new(&mut *self.bus, target.position, target.patience, stop)
            .map_err(|error| failure(&Failed::Bus(error), None))?;
        self.interrupt.serving(target.position, master.left());
        let worked = work(&mut master);
        self.left = master.withdraw().map(|out| (target.position, out));
        worked.map_err(|failed| failure(&failed, master.behind()))
    }

    /// Closes the ring and prints the report, with the service bit that was left if there is one; then the answer is not
    /// yes.
    pub(crate) fn report<V: Display + Serialize>(
        self,
        output: Output,
        told: Result<V, Failure>,
        answer: impl FnOnce(&V) -> Answer,
    ) -> Result<Answer, Failure> {
        let left = self.left;
        self.close_after(&told)?;
        if let Some((position, out)) = left {
            note(&service_bit_left(position, out));
        }
        let service_bit_left = left.map(|(_, out)| out.to_string());
        match (told, output.format) {
            (Ok(view), Format::Json) => {
                output.json(&Reported { view: &view, service_bit_left })?;
                Ok(after(left, answer(&view)))
            }
            (Ok(view), Format::Text) => {
                output.print(&view)?;
                Ok(after(left, answer(&view)))
            }
            (Err(failure), format) => {
                if let (Some((position, _)), Format::Json) = (left, format) {
                    output.json(&Left { position, service_bit_left })?;
                }
                Err(failure)
            }
        }
    }

    /// The same for a command that may have failed: then the failure says what the trouble was.
    pub(crate) fn close_after<T>(mut self, told: &Result<T, Failure>) -> Result<(), Failure> {
        if told.is_err() {
            while self.bus.link_event().is_some() {}
        }
        self.close()
    }

    /// Tells what happened to the link, and keeps the memories of simulated encoders.
    pub(crate) fn close(mut self) -> Result<(), Failure> {
        let events: Vec<_> = std::iter::from_fn(|| self.bus.link_event()).map(|event| event.what).collect();
        for trouble in troubles(&events) {
            note(&format!("note: {}: {trouble}", self.place));
        }
        if let Some(advice) = self.bus.advice() {
            note(&format!("note: {}: {advice}", self.place));
        }
        let (Some(world), Some(memories)) = (&self.world, &self.memories) else { return Ok(()) };
        if memories.is_read_only() {
            return Ok(());
        }
        world.with(|world| memories.save(world)).map_err(|error| not_saved(&error))
    }
}

/// What is left of an answer if a service bit was left.
fn after(left: Option<(usize, OutWord)>, answer: Answer) -> Answer {
    if left.is_some() && answer == Answer::Yes { Answer::Unknown } else { answer }
}

/// What is printed for programs where a command has nothing else to say.
#[derive(Serialize)]
struct Left {
    position: usize,
    service_bit_left: Option<String>,
}

/// What happened to a link, one line for each trouble: that it ended belongs to it, and the same is told once.
fn troubles(events: &[Link]) -> Vec<String> {
    let mut told: Vec<(String, u32)> = Vec::new();
    let mut events = events.iter().filter(|event| event.is_trouble()).peekable();
    while let Some(event) = events.next() {
        let text = match event {
            Link::Down { cause, .. } => format!("connection lost: {}", cause.reason()),
            Link::Failed { cause, .. } => BusError::NoConnection(Cause::System(*cause)).to_string(),
            Link::Up { .. } => event.to_string(),
        };
        events.next_if(|next| matches!(next, Link::Up { .. }));
        match told.iter_mut().find(|(earlier, _)| *earlier == text) {
            Some((_, times)) => *times += 1,
            None => told.push((text, 1)),
        }
    }
    told.into_iter()
        .map(|(text, times)| if times > 1 { format!("{text} ({times} times)") } else { text })
        .collect()
}
