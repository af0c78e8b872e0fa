//! A program at its controller, a ring and an encoder, seen from all four places at once.

use encoring_host::referee::{Finding, LineSeen, Observed, Referee, Ruling, Vantage};
use encoring_words::{InWord, Instant, Model, OutWord, Written};

/// Chance with a seed.
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn of(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1))
    }

    pub(crate) fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    pub(crate) fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }
}

/// What a finding is called here: equal writes share the name of the others.
pub(crate) fn name(finding: &Finding) -> &'static str {
    match (finding.rule.name(), finding.verdict) {
        ("memory_wear", Ruling::Note) => "memory_wear, a note",
        (name, _) => name,
    }
}

/// The cycle of a ring of 1 to 128 encoders.
pub(crate) fn cycle_us(chance: &mut Chance) -> u64 {
    460 + chance.below(128) * 1_066 / 10
}

/// The four places, in the order of [`Plant::referees`].
pub(crate) const PLACES: [Vantage; 4] = [Vantage::Writes, Vantage::Cycles, Vantage::Exchanges, Vantage::Log];

/// An encoder: it latches the word of the rise, and answers after its time.
pub(crate) struct Device {
    request: Option<(u32, u64)>,
    pub(crate) error: bool,
    pub(crate) slow_us: u64,
    pub(crate) position: u32,
    /// Steps that it turns a cycle.
    pub(crate) turns: u32,
    /// It answers the next write with another value: another master wrote between.
    pub(crate) foreign: bool,
    /// A service bit stood through a stop of the ring.
    stale: bool,
}

impl Device {
    fn normal(&self) -> u32 {
        self.position & 0xFF_FFFF | u32::from(self.error) << 29
    }

    /// A good cycle at `now` brings `out`; gives what the chip hands on, and IN of the next.
    fn cycle(&mut self, now: u64, out: u32) -> (u32, u32) {
        self.position = (self.position + self.turns) % 5_000;
        self.stale &= out >> 31 == 1;
        let heard = if self.stale { out & 0x7FFF_FFFF } else { out };
        if heard >> 31 == 0 {
            self.request = None;
            return (heard, self.normal());
        }
        let (word, due) = *self.request.get_or_insert((heard, now + self.slow_us));
        (heard, if now < due { self.normal() } else { self.reply(word) })
    }

    fn reply(&mut self, word: u32) -> u32 {
        let (number, write) = (word >> 24 & 0xF, word >> 30 & 1 == 1);
        let refused = matches!((number, write), (6, false) | (8, true) | (7, _))
            || (number, write) == (2, true) && word & 0xFF_FFFF == 0;
        if (number, write) == (8, false) {
            self.error = false;
            return 0x8800_0000;
        }
        self.error |= refused;
        let data = if write { word & 0xFF_FFFF ^ u32::from(self.foreign) } else { 0x270F };
        word & 0xCF00_0000 | data | u32::from(self.error) << 29
    }
}

/// How a program writes a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// In one request.
    Whole,
    /// The low half, and then the one with the service bit.
    LowFirst,
}

pub(crate) struct Plant {
    pub(crate) model: Model,
    chance: Chance,
    style: Style,
    /// Of so many cycles one fails; 0 for none.
    bad_of: u64,
    pub(crate) now: u64,
    next_cycle: u64,
    next_row: u64,
    pub(crate) cycle_us: u64,
    pub(crate) scan_us: u64,
    /// The longest way from a program to the image, and from the image to a program.
    latency_us: u64,
    log_us: u64,
    pub(crate) out: u32,
    /// IN as the image shows it.
    pub(crate) input: u32,
    answer: u32,
    pub(crate) device: Device,
    pub(crate) silent: bool,
    pub(crate) referees: [Referee; 4],
    /// What the first place has seen.
    pub(crate) seen: Vec<Observed>,
}

impl Plant {
    /// On a ring of any length.
    pub(crate) fn new(chance: &mut Chance, model: Model) -> Self {
        let cycle_us = cycle_us(chance);
        Self::on(cycle_us, chance, model)
    }

    /// One of a ring with this cycle.
    pub(crate) fn on(cycle_us: u64, chance: &mut Chance, model: Model) -> Self {
        Self {
            model,
            now: 0,
            next_cycle: 1_000,
            next_row: 500,
            cycle_us,
            scan_us: chance.between(1_000, 100_000),
            latency_us: chance.below(20_000),
            log_us: chance.between(1_000, 100_000),
            style: if chance.below(2) == 0 { Style::Whole } else { Style::LowFirst },
            bad_of: chance.below(2) * chance.between(20, 500),
            chance: Chance(chance.below(u64::MAX)),
            out: 0,
            input: 0x64,
            answer: 0x64,
            device: Device {
                request: None,
                error: false,
                slow_us: chance.below(20_000),
                position: 0x64,
                turns: 0,
                foreign: false,
                stale: false,
            },
            silent: false,
            referees: PLACES.map(|vantage| Referee::new(vantage, Some(model))),
            seen: Vec::new(),
        }
    }

    pub(crate) fn told(&self) -> String {
        let Self { cycle_us, scan_us, latency_us, log_us, style, bad_of, .. } = self;
        format!(
            "cycle {cycle_us} us, one of {bad_of} bad, scan {scan_us} us, latency up to {latency_us} us, a row each {log_us} us, {style:?}"
        )
    }

    /// Lets the ring run until `until`.
    pub(crate) fn run(&mut self, until: u64) {
        while self.next_cycle.min(self.next_row) <= until {
            if self.next_row < self.next_cycle {
                self.now = self.next_row;
                self.row();
                self.next_row += self.log_us;
            } else {
                self.now = self.next_cycle;
                self.cycle();
                self.next_cycle += self.cycle_us;
            }
        }
        self.now = until;
    }

    fn seen(&self, (out, input): (u32, u32), line: LineSeen) -> Observed {
        let (out, input) = (OutWord(out), Some(InWord(input)));
        Observed::Cycle { at: Instant(self.now * 1_000), out, input, line }
    }

    fn row(&mut self) {
        let line = if self.silent { LineSeen::Silent } else { LineSeen::Good };
        let seen = self.seen((self.out, self.input), line);
        self.referees[3].observe(seen);
    }

    fn cycle(&mut self) {
        if self.silent {
            self.device.stale = true;
            return self.at_the_master(LineSeen::Silent);
        }
        if self.bad_of > 0 && self.chance.below(self.bad_of) == 0 {
            return self.at_the_master(LineSeen::Bad);
        }
        // The ring brings what the encoder put out at the end of the cycle before.
        self.input = self.answer;
        self.at_the_master(LineSeen::Good);
        let (heard, answer) = self.device.cycle(self.now, self.out);
        self.answer = answer;
        let seen = self.seen((heard, answer), LineSeen::Untold);
        self.referees[2].observe(seen);
    }

    fn at_the_master(&mut self, line: LineSeen) {
        let seen = self.seen((self.out, self.input), line);
        self.seen.push(seen);
        self.referees[..2].iter_mut().for_each(|referee| referee.observe(seen));
    }

    pub(crate) fn wait(&mut self, time_us: u64) {
        self.run(self.now + time_us);
    }

    /// Until the next cycle has taken what stands there.
    pub(crate) fn past_next_cycle(&mut self) {
        self.run(self.next_cycle + 1);
    }

    pub(crate) fn write_as(&mut self, client: u32, written: Written) {
        self.out = OutWord(self.out).after(written).0;
        let seen = Observed::Write { at: Instant(self.now * 1_000), client, written };
        self.seen.push(seen);
        self.referees[0].observe(seen);
    }

    pub(crate) fn write(&mut self, written: Written) {
        self.write_as(1, written);
    }

    pub(crate) fn put_whole(&mut self, word: u32) {
        self.write(Written::Both(OutWord(word)));
    }

    /// As the program writes words.
    pub(crate) fn put(&mut self, word: u32) {
        match self.style {
            Style::Whole => self.put_whole(word),
            Style::LowFirst => {
                self.write(Written::Low(word as u16));
                let pause = self.chance.below(2_000);
                self.wait(pause);
                self.write(Written::High((word >> 16) as u16));
            }
        }
    }

    /// A scan, and long enough for a cycle to be seen.
    pub(crate) fn scan(&mut self) {
        let late = self.chance.below(self.scan_us / 4 + 1);
        self.wait((self.scan_us + late).max(2 * self.cycle_us));
    }

    /// A way there and one back.
    fn ways(&mut self) {
        let ways = [0; 2].map(|_| self.chance.below(self.latency_us + 1));
        self.wait(ways.iter().sum());
    }

    /// Scans until a program sees IN bit 31 as `bit`; what it sees is as old as its way is long.
    pub(crate) fn until(&mut self, bit: u32) {
        for _ in 0..1_000 {
            self.scan();
            let seen = self.input;
            self.ways();
            if seen >> 31 == bit {
                break;
            }
        }
    }

    pub(crate) fn request(&mut self, word: u32) {
        self.put(word & 0x7FFF_FFFF);
        self.scan();
        self.put(word);
    }

    pub(crate) fn end(&mut self, word: u32) {
        self.until(1);
        self.put(word & 0x7FFF_FFFF);
        self.until(0);
    }

    pub(crate) fn serve(&mut self, word: u32) {
        self.request(word);
        self.end(word);
    }
}
