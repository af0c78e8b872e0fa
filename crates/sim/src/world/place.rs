//! One place of a ring: a device, its shaft, what surrounds it, and the line from its SSI.

use encoring_device::Surroundings;
use encoring_encoder::{Encoder, Terminals};
use encoring_ring::Taken;
use encoring_ring::slave::Condition;
use encoring_trace::{Row, RowKind};
use encoring_words::ssi_frame::{Level, SsiFormat};
use encoring_words::{InWord, Instant, OutWord, ParameterSet};

use crate::motion::Motion;
use crate::node::Node;
use crate::scenario::Chip;
use crate::ssi::{Clocked, SsiLine, SsiReader};

/// One place of the ring.
#[derive(Clone, Debug)]
pub struct Place {
    pub(super) node: Node,
    pub(super) motion: Motion,
    pub(super) motion_since: Instant,
    /// The motion before, for samples that lie before the present one began.
    pub(super) earlier: Option<(Motion, Instant)>,
    pub(super) around: Surroundings,
    /// The supply fails in the present cycle, or did since the last one, even if it is back.
    pub(super) dipped: bool,
    pub(super) chip: Chip,
    /// The moment of the sample that was told last, and where the shaft was: a motion that is changed afterwards does
    /// not change it.
    pub(super) looked: Option<(Instant, i64)>,
    pub(super) ssi: SsiLine,
    /// That the SSI switched the encoder on, until it is recorded: a replay has to do so, too.
    pub(super) switched_on: Option<Row>,
}

impl Place {
    /// A device with its supply, its shaft moving from the beginning of time.
    pub(super) fn new(mut node: Node, motion: Motion) -> Self {
        let around = Surroundings::default();
        node.supply(Instant::ZERO, around.supply_mv);
        Self {
            node,
            motion,
            motion_since: Instant::ZERO,
            earlier: None,
            around,
            dipped: false,
            chip: Chip::Running,
            looked: None,
            ssi: SsiLine::new(0),
            switched_on: None,
        }
    }

    /// An exchange of its encoder: the word that it hears, and its answer. `None` without supply.
    pub(super) fn exchange(&mut self, at: Instant, taken: Taken) -> (OutWord, Option<InWord>) {
        let out = self.node.hears(taken);
        self.look(at);
        let input = self.node.step(at, out, &self.around);
        if input.is_none() {
            // The memory's power cut took the supply with it.
            self.around.supply_mv = 0;
            self.node.supply(at, 0);
        }
        (out, input)
    }

    /// Says where the shaft is of which an encoder learns at `at`.
    pub(super) fn look(&mut self, at: Instant) {
        let moment = self.node.device().looks_at(at);
        let raw = match self.looked {
            Some((looked, raw)) if looked == moment => raw,
            _ => self.raw(moment),
        };
        self.looked = Some((moment, raw));
        self.around.terminals.raw = raw;
    }

    pub(super) fn run_ssi(&mut self, until: Instant) {
        let mut ssi = std::mem::replace(&mut self.ssi, SsiLine::new(0));
        ssi.run(until, self);
        self.ssi = ssi;
    }

    /// The reader on its SSI.
    #[must_use]
    pub fn ssi(&self) -> Option<&SsiReader> {
        self.ssi.reader()
    }

    /// Whether its chip works in the present cycle.
    pub(super) const fn condition(&self) -> Condition {
        match (self.dipped || !self.is_supplied(), self.chip) {
            (true, _) => Condition::Off,
            (false, Chip::Held) => Condition::Held,
            (false, Chip::Running) => Condition::Running,
        }
    }

    /// Whether the reset input of its chip is held.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.chip == Chip::Held
    }

    /// The device here.
    #[must_use]
    pub const fn node(&self) -> &Node {
        &self.node
    }

    /// What surrounds it, as it was told last.
    #[must_use]
    pub const fn around(&self) -> &Surroundings {
        &self.around
    }

    /// Where the shaft or magnet is at `at`.
    #[must_use]
    pub fn raw(&self, at: Instant) -> i64 {
        match &self.earlier {
            Some((motion, since)) if at < self.motion_since => motion.at(at.since(*since)),
            _ => self.motion.at(at.since(self.motion_since)),
        }
    }

    /// Whether its supply suffices.
    #[must_use]
    pub const fn is_supplied(&self) -> bool {
        self.around.is_supplied()
    }
}

impl Clocked for Place {
    fn ssi_clock(&mut self, at: Instant, clock: Level) {
        self.look(at);
        let was_off = self.node.encoder().is_none();
        self.node.ssi_clock(at, clock, &self.around);
        if was_off && self.node.encoder().is_some() {
            let Surroundings { terminals: Terminals { raw, .. }, supply_mv } = self.around;
            let (kind, time_ns) = (RowKind::SsiEdge, at.as_nanos());
            self.switched_on = Some(Row { kind, time_ns, raw, supply_mv, ..Row::default() });
        }
    }

    fn ssi_level(&self, at: Instant) -> (Level, Option<Instant>) {
        self.node.encoder().map_or((Level::Low, None), |encoder| encoder.ssi_level(at))
    }

    fn ssi_format(&self) -> SsiFormat {
        let unit = self.node.unit();
        let factory = || ParameterSet::factory(unit.model(), unit.sensor()).ssi_values();
        let new = || SsiFormat::new(factory(), unit.firmware);
        self.node.encoder().map_or_else(new, Encoder::ssi_format)
    }
}
