//! The referee: which rule of the handshake a PLC program broke.
//!
//! It looks on and never takes part. It is told what was [`Observed`] of one encoder and keeps, for each [`HandshakeRule`], when
//! it was broken first and last, and how often. What can be judged depends on the [`Vantage`]; [`rule`] has the table,
//! [`Referee::not_judged`] what could not be judged. It needs no allocator and takes anything in any order: what runs
//! backwards in time is left out and counted, and across a gap nothing is judged.
//!
//! "Position used while bit 31 is up" is not on the bus, so there is no such rule.

use encoring_words::model::{Effect, MODELS};
use encoring_words::word::{DATA, ERROR_BIT, Out, RESERVE_BIT, ServiceFields, ServiceNumber};
use encoring_words::{Access, Duration, InWord, Instant, Model, OutWord, Service, Written};

pub mod rule;

mod cadence;
mod finding;
mod habits;
mod limits;
mod movement;
mod preparation;
mod request;
#[cfg(test)]
mod tests;

use self::cadence::Cadence;
pub use self::finding::{Finding, Flaws, Ruling, WRITES_ASSUMED};
use self::habits::Habits;
use self::limits::NEVER;
use self::movement::Movement;
use self::preparation::Preparations;
use self::rule::{BUS_RESET, ERROR_SEEN};
pub use self::rule::{HandshakeRule, ORDER, RULES, RuleCertainty, Severity, Vantage, WITHDRAWAL};

/// How a cycle went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineSeen {
    /// The data came whole.
    Good,
    /// Data came and was wrong.
    Bad,
    /// Nothing came.
    Silent,
    /// Nobody said.
    Untold,
}

/// Something that was seen of one encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observed {
    /// A cycle, an exchange, or a row of a log.
    Cycle {
        /// When.
        at: Instant,
        /// What stood on OUT.
        out: OutWord,
        /// What stood on IN; `None` if the encoder had no supply, or nobody said.
        input: Option<InWord>,
        /// How it went.
        line: LineSeen,
    },
    /// A write by a client of the master.
    Write {
        /// When.
        at: Instant,
        /// Who, by any number.
        client: u32,
        /// What.
        written: Written,
    },
}

/// How OUT came to hold what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    /// A cycle showed it.
    Cycle,
    /// One write of both halves.
    Whole,
    High(u32),
    Low(u32),
}

/// A request whose service bit stands.
#[derive(Clone, Copy, Debug)]
struct Standing {
    /// OUT when the bit rose.
    word: OutWord,
    rose: Instant,
    by: By,
    /// Number or data changed with the bit.
    together: bool,
    /// When its own reply was seen first.
    own: Option<Instant>,
    /// When another reply was seen first.
    foreign: Option<Instant>,
    /// Its beginning was not seen, or a rule was broken that explains all that follows.
    spoiled: bool,
    /// The ring stopped meanwhile: the encoder takes it for no request.
    stopped: bool,
    /// What it asks for has been judged.
    settled: bool,
    /// That it stands too long has been told.
    told: bool,
}

/// A set error bit.
#[derive(Clone, Copy, Debug)]
struct ErrorSeen {
    /// Since when it stands in normal mode.
    normal: Option<Instant>,
    /// A reply had it.
    replied: bool,
    /// 08 was requested, or it was told that it was not.
    over: bool,
}

/// The referee of one encoder.
#[derive(Clone, Debug)]
pub struct Referee {
    vantage: Vantage,
    model: Option<Model>,
    withdrawal: Duration,
    /// When the observation before was made.
    before: Instant,
    now: Instant,
    /// Nothing that stands has stood for too long before this.
    due: Instant,
    out: Option<OutWord>,
    input: Option<InWord>,
    standing: Option<Standing>,
    /// The reply to the service before has not ended yet.
    ending: bool,
    error: Option<ErrorSeen>,
    /// A reply had bit 29 then, and 08 was not requested yet.
    status_due: Option<Instant>,
    silent_since: Option<Instant>,
    habits: Habits,
    movement: Movement,
    cadence: Cadence,
    preparations: Preparations,
    /// A reply may have stood between two rows of a log.
    reply_overlooked: bool,
    findings: [Option<Finding>; RULES.len()],
    /// A bit for each rule, by its place: found first, or more surely, since somebody asked.
    news: u32,
    flaws: Flaws,
    services: u64,
    input_seen: bool,
    line_seen: bool,
}

impl Referee {
    /// A referee that has seen nothing. Without a model it judges what holds for every one.
    #[must_use]
    pub const fn new(vantage: Vantage, model: Option<Model>) -> Self {
        Self {
            vantage,
            model,
            withdrawal: WITHDRAWAL,
            before: Instant::ZERO,
            now: Instant::ZERO,
            due: NEVER,
            out: None,
            input: None,
            standing: None,
            ending: false,
            error: None,
            status_due: None,
            silent_since: None,
            habits: Habits::NEW,
            movement: Movement::NEW,
            cadence: Cadence::NEW,
            preparations: Preparations::NEW,
            reply_overlooked: false,
            findings: [None; RULES.len()],
            news: 0,
            flaws: Flaws { backwards: 0, gaps: 0, unseen_writes: 0, lone_halves: 0 },
            services: 0,
            input_seen: false,
            line_seen: false,
        }
    }

    /// The same for a program that gives up after another time than [`WITHDRAWAL`]: it may drop a request that got no reply
    /// so long after its rise.
    #[must_use]
    pub const fn with_withdrawal(mut self, after: Duration) -> Self {
        self.withdrawal = after;
        self
    }

    /// From now on every write is seen too.
    pub const fn sees_writes(&mut self) {
        self.vantage = Vantage::Writes;
    }

    /// Takes what was seen.
    pub fn observe(&mut self, seen: Observed) {
        let (Observed::Cycle { at, .. } | Observed::Write { at, .. }) = seen;
        if at < self.now {
            self.flaws.backwards = self.flaws.backwards.saturating_add(1);
            return;
        }
        (self.before, self.now) = (self.now, at);
        match seen {
            Observed::Write { client, written, .. } => self.write(at, client, written),
            Observed::Cycle { out, input, line, .. } => {
                if self.cadence.is_gap(at) {
                    self.gap();
                }
                self.cycle(at, out, input, line);
            }
        }
        if at >= self.due {
            self.stands_too_long(at);
        }
    }

    /// Nothing more comes: what stands at the end is judged.
    pub fn finish(&mut self) {
        self.stands_long(self.now, WITHDRAWAL);
        self.settle();
    }

    /// What was found, in the order of the rules.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().flatten()
    }

    /// What was found first, or has become certain, since the last call.
    pub fn take_news(&mut self) -> impl Iterator<Item = Finding> {
        let news = core::mem::take(&mut self.news);
        let findings = if news == 0 { &[][..] } else { &self.findings };
        findings.iter().flatten().filter(move |finding| news >> finding.rule as u32 & 1 == 1).copied()
    }

    /// The rules that could not be judged.
    pub fn not_judged(&self) -> impl Iterator<Item = HandshakeRule> + '_ {
        RULES.into_iter().filter(|rule| {
            let unseen = match rule {
                HandshakeRule::StaleServiceBit => !self.line_seen,
                HandshakeRule::DataWithServiceBit
                | HandshakeRule::TornWords
                | HandshakeRule::OutOfRange
                | HandshakeRule::UnknownService
                | HandshakeRule::WrongDirection
                | HandshakeRule::PresetRepeated => false,
                _ => !self.input_seen,
            };
            let overlooked = match rule {
                HandshakeRule::DataWithServiceBit => self.preparations.was_overlooked(),
                HandshakeRule::DroppedBeforeAcknowledgement => self.reply_overlooked,
                _ => false,
            };
            let found = self.findings.get(*rule as usize).is_some_and(Option::is_some);
            unseen || overlooked && !found || rule.certainty(self.vantage) == RuleCertainty::NotJudged
        })
    }

    /// What was wrong with what was observed.
    #[must_use]
    pub const fn flaws(&self) -> Flaws {
        self.flaws
    }

    /// Requests that were seen.
    #[must_use]
    pub const fn services(&self) -> u64 {
        self.services
    }

    /// From where it looks.
    #[must_use]
    pub const fn vantage(&self) -> Vantage {
        self.vantage
    }

    /// `true` if a rule of severity error was certainly broken.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.findings()
            .any(|finding| finding.rule.severity() == Severity::Error && finding.verdict == Ruling::Broken)
    }

    fn models(&self) -> impl Iterator<Item = Model> + use<> {
        let known = self.model;
        MODELS.into_iter().filter(move |model| known.is_none_or(|known| known == *model))
    }

    /// Notes a break that happened at `at`.
    fn found(&mut self, rule: HandshakeRule, at: Instant, out: OutWord) {
        self.found_as(rule, rule.certainty(self.vantage), at, out);
    }

    /// The same, no surer than `sure`.
    fn found_as(&mut self, rule: HandshakeRule, sure: RuleCertainty, at: Instant, out: OutWord) {
        let verdict = match (rule.certainty(self.vantage), sure) {
            (RuleCertainty::NotJudged, _) | (_, RuleCertainty::NotJudged) => return,
            _ if rule.severity() == Severity::Note => Ruling::Note,
            (RuleCertainty::Certain, RuleCertainty::Certain) => Ruling::Broken,
            _ => Ruling::Suspected,
        };
        let input = self.input;
        let Some(slot) = self.findings.get_mut(rule as usize) else { return };
        let known = slot.map(|finding| finding.verdict);
        let finding =
            slot.get_or_insert(Finding { rule, verdict, first: at, last: at, count: 0, out, input });
        finding.last = at;
        finding.count = finding.count.saturating_add(1);
        if verdict == Ruling::Broken {
            finding.verdict = verdict;
        }
        if known != Some(finding.verdict) {
            self.news |= 1 << rule as u32;
        }
    }

    /// What was suspected is explained by now.
    fn take_back(&mut self, rule: HandshakeRule) {
        if let Some(slot) = self.findings.get_mut(rule as usize) {
            *slot = None;
        }
        self.news &= !(1 << rule as u32);
    }

    #[cold]
    fn gap(&mut self) {
        self.flaws.gaps = self.flaws.gaps.saturating_add(1);
        self.forget();
    }

    /// What is not known any more after a gap.
    #[cold]
    fn forget(&mut self) {
        (self.out, self.input, self.standing) = (None, None, None);
        (self.error, self.status_due, self.silent_since) = (None, None, None);
        self.ending = false;
        self.movement = Movement::NEW;
        self.habits.forget();
        self.preparations.forget();
    }

    // Apart, like all that happens seldom: a cycle in which nothing happens must cost little.
    #[inline(never)]
    fn write(&mut self, at: Instant, client: u32, written: Written) {
        let (before, by) = match (written, self.out) {
            (Written::Both(word), _) => (word, By::Whole),
            (Written::High(_), Some(out)) => (out, By::High(client)),
            (Written::Low(_), Some(out)) => (out, By::Low(client)),
            _ => {
                self.flaws.lone_halves = self.flaws.lone_halves.saturating_add(1);
                return;
            }
        };
        self.out_is(at, before.after(written), by);
    }

    fn cycle(&mut self, at: Instant, out: OutWord, input: Option<InWord>, line: LineSeen) {
        self.line_seen |= line != LineSeen::Untold;
        if self.out != Some(out) {
            self.image_is(at, out, input);
        }
        match line {
            LineSeen::Silent => return self.silent(at),
            LineSeen::Bad => return,
            LineSeen::Good | LineSeen::Untold if self.silent_since.is_some() => self.runs_again(at, out),
            LineSeen::Good | LineSeen::Untold => {}
        }
        match input {
            Some(input) => self.input_is(at, input),
            None if self.vantage == Vantage::Exchanges => self.forget(),
            None => {}
        }
    }

    /// A cycle shows another OUT than before.
    #[inline(never)]
    fn image_is(&mut self, at: Instant, out: OutWord, input: Option<InWord>) {
        if self.vantage == Vantage::Writes && self.out.is_some() {
            self.flaws.unseen_writes = self.flaws.unseen_writes.saturating_add(1);
            (self.out, self.standing) = (None, None);
        }
        let reply = input.filter(|input| input.service_bit() && self.standing.is_some());
        if let (Vantage::Log, Some(reply)) = (self.vantage, reply) {
            // It may have been there before OUT changed.
            self.input_is(at, reply);
        }
        self.out_is(at, out, By::Cycle);
    }

    #[cold]
    fn silent(&mut self, at: Instant) {
        self.silent_since.get_or_insert(at);
        if self.is_stopped(at) {
            self.stop();
        }
    }

    /// The ring has been silent for so long that the bus was reset.
    fn is_stopped(&self, at: Instant) -> bool {
        self.silent_since.is_some_and(|since| at.since(since) >= BUS_RESET)
    }

    fn stop(&mut self) {
        if let Some(standing) = &mut self.standing {
            (standing.stopped, standing.spoiled) = (true, true);
        }
    }

    #[cold]
    fn runs_again(&mut self, at: Instant, out: OutWord) {
        let stopped = self.is_stopped(at);
        self.silent_since = None;
        if !stopped {
            return;
        }
        self.stop();
        if out.service_bit() {
            self.found(HandshakeRule::StaleServiceBit, at, out);
        }
    }

    /// OUT holds this from now on.
    fn out_is(&mut self, at: Instant, after: OutWord, by: By) {
        let Some(before) = self.out.replace(after) else {
            if after.service_bit() {
                self.standing = Some(Standing::unseen(after, at));
            }
            return;
        };
        match (before.service_bit(), after.service_bit()) {
            (false, true) => self.rises(at, before, after, by),
            (true, false) => {
                self.falls(at, after);
                self.rests(at, before, after);
            }
            (true, true) => self.changes(at, before, after, by),
            (false, false) => self.rests(at, before, after),
        }
    }
}
