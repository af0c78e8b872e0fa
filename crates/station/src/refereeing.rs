//! The referees that look on while a ring runs.

use std::str::FromStr;

use encoring_bus::Referees;
use encoring_host::referee::{LineSeen, ORDER, Observed, Vantage};
use encoring_sim::World;
use encoring_sim::world::Place;
use encoring_trace::bus::{BusEvent, BusRow};
use encoring_trace::{CycleSeen, Input};
use encoring_words::{InWord, Instant, OutWord};
use serde::Serialize;

use crate::bus_seen::BusSeen;
use crate::finding::FindingView;

/// Whether programs are judged while a ring runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RefereeMode {
    /// Nobody looks on.
    #[default]
    Off,
    /// What is found is an event, and stands in the view.
    On,
    /// The same, and the ring stops when a rule of severity error was certainly broken.
    Strict,
}

/// It is no mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it must be on, off or strict")]
pub struct NotARefereeMode;

impl FromStr for RefereeMode {
    type Err = NotARefereeMode;

    fn from_str(text: &str) -> Result<Self, NotARefereeMode> {
        match text {
            "off" => Ok(Self::Off),
            "on" => Ok(Self::On),
            "strict" => Ok(Self::Strict),
            _ => Err(NotARefereeMode),
        }
    }
}

/// What the referees of a ring say.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RefereeView {
    /// Requests that were seen.
    pub services: u64,
    /// What was found, by position.
    pub findings: Vec<FindingView>,
    /// The rules that could not be judged so far.
    pub not_judged: Vec<&'static str>,
    /// From where they look.
    pub seen_from: &'static str,
}

impl RefereeView {
    /// `true` if a rule of severity error was certainly broken.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.findings.iter().any(FindingView::is_error)
    }
}

/// The referees of a running ring.
#[derive(Debug)]
pub(crate) struct Refereeing {
    referees: Referees,
    mode: RefereeMode,
}

impl Refereeing {
    /// Referees for the encoders of a world; `None` if nobody shall look on.
    pub(crate) fn new(world: &World, mode: RefereeMode) -> Option<Self> {
        if mode == RefereeMode::Off {
            return None;
        }
        let mut referees = Referees::new(Vantage::Writes, None);
        for (position, node) in (0..).zip(world.places().iter().map(Place::node)) {
            referees.place(position, node.unit().model());
        }
        Some(Self { referees, mode })
    }

    /// Takes what the master saw of a cycle.
    pub(crate) fn cycled(&mut self, seen: &BusSeen) {
        seen.rows().for_each(|row| self.referees.observe(row.position, observed(&row)));
    }

    /// Nothing more comes.
    pub(crate) fn finish(&mut self) {
        self.referees.finish();
    }

    /// What was found first, or has become certain, since the last call.
    pub(crate) fn news(&mut self) -> impl Iterator<Item = FindingView> {
        let vantage = self.referees.vantage();
        self.referees
            .take_news()
            .map(move |(position, finding)| FindingView::new(position, &finding, vantage))
    }

    /// What a strict one has seen of a master that does not keep the order of the handshake.
    pub(crate) fn breaks_the_order(&self) -> Option<FindingView> {
        let mut findings = self.referees.findings().filter(|(_, finding)| ORDER.contains(&finding.rule));
        let (position, finding) = findings.next().filter(|_| self.mode == RefereeMode::Strict)?;
        Some(FindingView::new(position, finding, self.referees.vantage()))
    }

    /// `true` if a strict one has seen enough.
    pub(crate) fn ends(&self) -> bool {
        self.mode == RefereeMode::Strict && self.referees.is_broken()
    }

    pub(crate) fn view(&self) -> RefereeView {
        let vantage = self.referees.vantage();
        let view = |(position, finding)| FindingView::new(position, finding, vantage);
        RefereeView {
            services: self.referees.services(),
            findings: self.referees.findings().map(view).collect(),
            not_judged: self.referees.not_judged().iter().map(|rule| rule.name()).collect(),
            seen_from: vantage.letter(),
        }
    }
}

/// A row of what was seen on a bus, as a referee takes it.
#[must_use]
pub fn observed(row: &BusRow) -> Observed {
    let at = Instant(row.time_ns);
    match row.event {
        BusEvent::Write { client, written } => Observed::Write { at, client, written },
        BusEvent::Cycle { out, input, line } => {
            let input = input.and_then(Input::word).map(InWord);
            Observed::Cycle { at, out: OutWord(out), input, line: line.map_or(LineSeen::Untold, line_seen) }
        }
    }
}

/// How a cycle of a trace went, as a referee takes it.
#[must_use]
pub const fn line_seen(cycle: CycleSeen) -> LineSeen {
    match cycle {
        CycleSeen::Good => LineSeen::Good,
        CycleSeen::Bad => LineSeen::Bad,
        CycleSeen::Silent => LineSeen::Silent,
    }
}
