//! The world: encoders at their places on a ring, in virtual time, cycle by cycle.

use encoring_device::OFF_BELOW_MV;
use encoring_encoder::Terminals;
use encoring_ring::diagnostics::FaultPlace;
use encoring_ring::slave::{Condition, Lamps};
use encoring_ring::{BitRing, ENCODERS_MAX, ProcessImage, Slave, Taken, TooManyEncoders, Verdict};
use encoring_trace::{Input, Row};
use encoring_words::{Duration, InWord, Instant, OutWord};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::fault::{Fault, PER_MILLION};
use crate::memory::Eeprom;
use crate::motion::Motion;
use crate::node::Node;
use crate::scenario::{Change, Event, Happening, NewMotion, Scenario};
use crate::ssi::{Seen, SsiLine, SsiReader};
use crate::tap::Tap;
use crate::wire::{Trouble, Wire};

pub use place::Place;

mod place;

/// A ring of encoders and everything around them.
#[derive(Clone, Debug)]
pub struct World {
    now: Instant,
    cycle_time: Duration,
    wire: Wire,
    places: Vec<Place>,
    /// What each device loads at the start of the next cycle.
    answers: Vec<Option<InWord>>,
    events: Vec<Event>,
    next_event: usize,
    line: Option<Trouble>,
    faulty_per_million: u32,
    chance: Pcg64Mcg,
    recorded: Option<Vec<Row>>,
}

/// Where the ring is with an event.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// The cycle that it falls into is about to run.
    Ahead,
    /// That cycle has run, and all before it has happened.
    Due,
}

/// A cycle of the ring, as it went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cycled {
    /// When it ended.
    pub at: Instant,
    /// How it went.
    pub verdict: Verdict,
    /// Where the master sees the ring at fault.
    pub place: Option<FaultPlace>,
}

impl World {
    /// The world of a scenario, its encoders new.
    ///
    /// # Errors
    /// [`TooManyEncoders`] above 128.
    pub fn new(scenario: &Scenario) -> Result<Self, TooManyEncoders> {
        let encoders = scenario.devices.len();
        if encoders > ENCODERS_MAX {
            return Err(TooManyEncoders { encoders });
        }
        let places = (0..).zip(&scenario.devices).map(|(position, device)| {
            let mut place = Place::new(Node::new(device.unit), device.motion.clone());
            // Each has a stream of its own.
            place.ssi = SsiLine::new(scenario.seed.rotate_left(32) ^ position);
            place.ssi.hang(Instant::ZERO, device.ssi);
            place
        });
        let wire = Wire::new(encoders, &scenario.cycle_time, scenario.seed);
        Ok(Self {
            now: Instant::ZERO,
            cycle_time: scenario.cycle_time.of_encoders(encoders as u32).max(wire.ring().shortest()),
            wire,
            places: places.collect(),
            answers: vec![None; encoders],
            events: scenario.events.clone(),
            next_event: 0,
            line: None,
            faulty_per_million: scenario.faulty_per_million,
            chance: Pcg64Mcg::seed_from_u64(scenario.seed),
            recorded: None,
        })
    }

    /// Puts an encoder's memory of an earlier life in; before the first cycle.
    pub fn insert_memory(&mut self, position: usize, memory: Eeprom) {
        if let Some(place) = self.places.get_mut(position) {
            place.node = Node::with_memory(*place.node.unit(), memory);
            place.node.supply(self.now, place.around.supply_mv);
        }
    }

    /// Keeps every exchange from now on, to be taken with [`World::take_recorded`].
    pub fn record(&mut self) {
        self.recorded.get_or_insert_default();
    }

    /// Keeps nothing more that is recorded, neither exchanges nor a waveform's signals.
    pub fn end_recording(&mut self) {
        self.recorded = None;
        self.wire.end_tap();
        self.places.iter_mut().for_each(|place| place.ssi.keep_seen(None));
    }

    /// Hands out the exchanges since the last call, in order of time, and forgets them.
    pub fn take_recorded(&mut self) -> impl Iterator<Item = Row> {
        let rows = self.recorded.as_mut();
        rows.into_iter().flat_map(|rows| {
            // Devices without cycles have several exchanges in one cycle time.
            rows.sort_by_key(|row| row.time_ns);
            rows.drain(..)
        })
    }

    /// The end of the last cycle.
    #[must_use]
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// The time of one cycle.
    #[must_use]
    pub const fn cycle_time(&self) -> Duration {
        self.cycle_time
    }

    /// The places, by position.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The ring: its master and its chips.
    #[must_use]
    pub const fn ring(&self) -> &BitRing<Vec<Slave>> {
        self.wire.ring()
    }

    /// Puts the master's diagnostic registers into a process image.
    pub fn diagnose(&self, image: &mut ProcessImage) {
        let master = self.ring().master();
        image.diagnose(master.status(), master.parameter(), master.counts().segments());
        for (position, place) in self.places.iter().enumerate() {
            image.show_ssi(position, place.ssi().map(SsiReader::shown).unwrap_or_default());
        }
    }

    /// Keeps every change of every SSI from now on, to be taken with [`World::take_ssi`].
    pub(crate) fn keep_ssi(&mut self) {
        self.places.iter_mut().for_each(|place| place.ssi.keep_seen(Some(Vec::new())));
    }

    /// Hands out the changes of the SSI at a position since the last call.
    pub(crate) fn take_ssi(&mut self, position: usize) -> impl Iterator<Item = Seen> {
        self.places.get_mut(position).into_iter().flat_map(|place| place.ssi.take_seen())
    }

    /// The lamps of the encoder at a position; `None` past the last one. The manual of the CE-65-M shows them [R139].
    #[must_use]
    pub fn lamps(&self, position: usize) -> Option<Lamps> {
        let u = self.places.get(position)?.is_supplied();
        let Lamps { ba, rc, rd, .. } = self.ring().lamps(position)?;
        Some(Lamps { u, ba: u && ba, rc: u && rc, rd: u && rd })
    }

    /// What the encoder at a position loads at the start of the next cycle.
    pub(crate) fn answer(&self, position: usize) -> Option<InWord> {
        self.answers.get(position).copied().flatten()
    }

    /// How long a line bit is.
    pub(crate) const fn line_bit(&self) -> Duration {
        self.wire.bit()
    }

    /// The time of the line bits so far.
    pub(crate) fn line_time(&self) -> Instant {
        self.wire.time()
    }

    /// Who looks on at the line from now on.
    pub(crate) fn set_tap(&mut self, tap: Tap) {
        self.wire.set_tap(tap);
    }

    /// Who looks on at the line.
    pub(crate) const fn tap_mut(&mut self) -> Option<&mut Tap> {
        self.wire.tap_mut()
    }

    /// Runs every bit from now on, also where none can matter. Nothing else differs.
    pub fn run_every_bit(&mut self) {
        self.wire.run_every_bit();
    }

    /// Has the master send nothing any more, until [`World::open_anew`].
    pub fn stop_ring(&mut self) {
        self.wire.stop();
    }

    /// Has the master open the ring anew with ID cycles, from the next slot on.
    pub fn open_anew(&mut self) {
        self.wire.open_anew();
    }

    /// Runs one data cycle. `out` and `input` have one word for each encoder; `input` is changed only by a cycle
    /// that was good throughout.
    pub fn cycle(&mut self, out: &[OutWord], input: &mut [InWord]) -> Cycled {
        let ends = self.now + self.cycle_time;
        self.look_ahead(ends);
        self.wire.set_conditions(self.places.iter().map(Place::condition));
        self.wire.set_trouble(self.line);
        let hit = self.draw_hit();
        let (verdict, place) = self.wire.cycle(ends, out, input, &self.answers, hit);
        let heard = match verdict {
            Verdict::Good | Verdict::Bad { .. } => self.places.len(),
            Verdict::Silent { segment } => segment,
        };
        while let Some(event) = self.events.get(self.next_event).filter(|event| event.at <= ends) {
            let event = event.clone();
            self.next_event += 1;
            // Devices without cycles may look at their surroundings several times before this changes them.
            for position in 0..self.places.len() {
                if !self.is_reached(position, heard) {
                    self.exchange_without_cycles(position, event.at);
                }
            }
            self.happen(&event, Stage::Due);
        }
        for position in 0..self.places.len() {
            if self.is_reached(position, heard) {
                self.exchange_after_cycle(position, ends);
            } else {
                self.exchange_without_cycles(position, ends);
            }
        }
        for position in 0..self.places.len() {
            self.run_ssi(position, ends);
        }
        for place in &mut self.places {
            place.dipped = false;
        }
        self.now = ends;
        Cycled { at: ends, verdict, place }
    }

    /// Changes what surrounds an encoder, now.
    pub fn change(&mut self, position: usize, changes: &[Change]) {
        let at = self.now;
        for change in changes {
            self.apply(at, position, change);
        }
    }

    /// Troubles a segment of the ring, from now on.
    pub fn trouble(&mut self, segment: usize, fault: Fault, lasting: Duration) {
        self.line = Some(Trouble { segment, fault, since: self.now, lasting });
    }

    /// The segment that is troubled now, and what it suffers.
    #[must_use]
    pub fn line_trouble(&self) -> Option<(usize, Fault)> {
        let trouble = self.line.filter(|trouble| self.now.since(trouble.since) < trouble.lasting)?;
        Some((trouble.segment, trouble.fault))
    }

    /// Ends a trouble.
    pub const fn end_trouble(&mut self) {
        self.line = None;
    }

    fn apply(&mut self, at: Instant, position: usize, change: &Change) {
        self.run_ssi(position, at);
        let Some(place) = self.places.get_mut(position) else { return };
        match change {
            Change::Preset { input, millivolts } => {
                if let Some(preset) = place.around.terminals.preset_mv.get_mut(*input) {
                    *preset = *millivolts;
                }
            }
            Change::Magnet(magnet) => place.around.terminals.magnet = *magnet,
            Change::Motion(motion) => {
                let here = place.raw(at);
                let motion = match motion {
                    NewMotion::Motion(motion) => motion.clone(),
                    NewMotion::Stop => Motion::Hold { raw: here },
                    NewMotion::Onward(micro_per_s) => {
                        Motion::Speed { start: here, micro_per_s: *micro_per_s }
                    }
                };
                place.earlier = Some((std::mem::replace(&mut place.motion, motion), place.motion_since));
                place.motion_since = at;
            }
            Change::MemoryFault(kind, cell) => place.node.memory_mut().fail(*kind, *cell),
            Change::MemoryRepair => place.node.memory_mut().repair(),
            Change::Chip(chip) => {
                place.chip = *chip;
                if place.is_held() {
                    self.wire.set_condition(position, Condition::Held);
                }
            }
            Change::Jumper(jumper) => self.wire.set_jumper(position, *jumper),
            Change::Ident(ident) => self.wire.set_ident(position, *ident),
            Change::PowerCut(bytes) => place.node.memory_mut().cut_after(*bytes),
            Change::Ssi(settings) => place.ssi.hang(at, *settings),
            Change::SsiTrouble(trouble) => place.ssi.set_trouble(*trouble),
            Change::Supply(millivolts) => {
                let was_on = place.node.encoder().is_some();
                place.around.supply_mv = *millivolts;
                place.node.supply(at, *millivolts);
                if *millivolts < OFF_BELOW_MV {
                    place.dipped = true;
                    if was_on {
                        self.keep(position, at, OutWord(0), None);
                    }
                    self.lose(position);
                }
            }
        }
    }

    /// A device without supply: its chip forgets.
    fn lose(&mut self, position: usize) {
        self.wire.set_condition(position, Condition::Off);
        if let Some(answer) = self.answers.get_mut(position) {
            *answer = None;
        }
    }

    /// Looks for what will spoil the cycle that ends at `ends`, in all of its time: supplies that fail and lines that are
    /// troubled, however shortly.
    fn look_ahead(&mut self, ends: Instant) {
        self.line = self.line.filter(|trouble| trouble.since + trouble.lasting > self.now);
        let events = std::mem::take(&mut self.events);
        for event in events.iter().skip(self.next_event).take_while(|event| event.at <= ends) {
            self.happen(event, Stage::Ahead);
        }
        self.events = events;
    }

    /// What an event does: to the cycle that it falls into, before that runs, and at its time.
    fn happen(&mut self, event: &Event, stage: Stage) {
        match (&event.what, stage) {
            (Happening::Line { segment, fault, lasting }, Stage::Ahead) => {
                let (segment, fault, lasting) = (*segment, *fault, *lasting);
                self.line = Some(Trouble { segment, fault, since: event.at, lasting });
            }
            // The line knows its time to the bit, and has had it.
            (Happening::Line { .. }, Stage::Due) => {}
            (Happening::Device { position, changes }, Stage::Ahead) => {
                let fails = |change: &Change| matches!(change, Change::Supply(mv) if *mv < OFF_BELOW_MV);
                if let Some(place) = self.places.get_mut(*position).filter(|_| changes.iter().any(fails)) {
                    place.dipped = true;
                }
            }
            (Happening::Device { position, changes }, Stage::Due) => {
                for change in changes {
                    self.apply(event.at, *position, change);
                }
            }
        }
    }

    /// The segment on which chance alone hits the coming cycle. It is drawn for every cycle, so that one fault does not
    /// shift those after it.
    fn draw_hit(&mut self) -> Option<usize> {
        let draw = self.chance.random_range(0..PER_MILLION);
        let segment = self.chance.random_range(0..=self.places.len());
        (draw < self.faulty_per_million).then_some(segment)
    }

    /// Whether a cycle that `heard` devices heard reached the one at a position.
    fn is_reached(&self, position: usize, heard: usize) -> bool {
        position < heard && !self.places.get(position).is_some_and(Place::is_held)
    }

    /// The exchange at the end of a cycle that reached the device, good or bad.
    fn exchange_after_cycle(&mut self, position: usize, ends: Instant) {
        let taken = self.ring().taken(position);
        if self.places.get(position).is_some_and(|place| place.node.device().exchanges_after_cycle(taken)) {
            self.exchange(position, ends, taken);
        }
    }

    /// The exchanges of a device that no cycle reaches, the last word of its chip standing or forgotten.
    fn exchange_without_cycles(&mut self, position: usize, until: Instant) {
        while let Some(at) =
            self.places.get(position).and_then(|place| place.node.device().due_without_cycles(until))
        {
            self.exchange(position, at, self.ring().taken_at(position, at));
        }
    }

    fn exchange(&mut self, position: usize, at: Instant, taken: Taken) {
        self.run_ssi(position, at);
        let Some(place) = self.places.get_mut(position) else { return };
        let (out, input) = place.exchange(at, taken);
        if input.is_none() {
            self.lose(position);
        } else if let Some(answer) = self.answers.get_mut(position) {
            *answer = input;
        }
        self.keep(position, at, out, input);
    }

    /// Clocks the SSI at a position up to and with `until`.
    fn run_ssi(&mut self, position: usize, until: Instant) {
        let Some(place) = self.places.get_mut(position).filter(|place| !place.ssi.is_idle()) else { return };
        place.run_ssi(until);
        let switched_on = place.switched_on.take();
        let Some((row, rows)) = switched_on.zip(self.recorded.as_mut()) else { return };
        rows.push(Row { position: Some(position as u8), ..row });
    }

    fn keep(&mut self, position: usize, at: Instant, out: OutWord, input: Option<InWord>) {
        let (Some(rows), Some(place)) = (&mut self.recorded, self.places.get(position)) else { return };
        let Terminals { raw, magnet, preset_mv } = place.around.terminals;
        rows.push(Row {
            line: 0,
            position: Some(position as u8),
            time_ns: at.as_nanos(),
            out: Some(out.0),
            raw,
            preset_mv,
            supply_mv: place.around.supply_mv,
            magnet: magnet == encoring_encoder::Magnet::Present,
            input: Some(input.map_or(Input::Off, |input| Input::Word(input.0))),
            ..Row::default()
        });
    }
}
