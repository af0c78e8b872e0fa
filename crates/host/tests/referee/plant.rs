//! A program at its controller, a ring and an encoder, seen from all four places at once.

use encoring_host::referee::{LineSeen, Observed, Referee, Vantage};
use encoring_words::{InWord, Instant, Model, OutWord, Written};

/// Chance with a seed.
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    pub(crate) fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }
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

pub(crate) struct Plant {
    pub(crate) now: u64,
    next_cycle: u64,
    next_row: u64,
    pub(crate) cycle_us: u64,
    pub(crate) scan_us: u64,
    /// From a program to the image, and from the image to a program.
    latency_us: u64,
    log_us: u64,
    pub(crate) out: u32,
    /// IN as the image shows it.
    pub(crate) input: u32,
    answer: u32,
    pub(crate) device: Device,
    pub(crate) silent: bool,
    pub(crate) referees: [Referee; 4],
}

impl Plant {
    pub(crate) fn new(chance: &mut Chance, model: Model) -> Self {
        Self {
            now: 0,
            next_cycle: 1_000,
            next_row: 500,
            cycle_us: chance.between(460, 14_000),
            scan_us: chance.between(1_000, 100_000),
            latency_us: chance.below(20_000),
            log_us: chance.between(1_000, 100_000),
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
        }
    }

    pub(crate) fn told(&self) -> String {
        let Self { cycle_us, scan_us, latency_us, log_us, .. } = self;
        format!("cycle {cycle_us} us, scan {scan_us} us, latency {latency_us} us, a row each {log_us} us")
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
            let seen = self.seen((self.out, self.input), LineSeen::Silent);
            self.referees[..2].iter_mut().for_each(|referee| referee.observe(seen));
            return;
        }
        // The ring brings what the encoder put out at the end of the cycle before.
        self.input = self.answer;
        let seen = self.seen((self.out, self.input), LineSeen::Good);
        self.referees[..2].iter_mut().for_each(|referee| referee.observe(seen));
        let (heard, answer) = self.device.cycle(self.now, self.out);
        self.answer = answer;
        let seen = self.seen((heard, answer), LineSeen::Untold);
        self.referees[2].observe(seen);
    }

    pub(crate) fn wait(&mut self, time_us: u64) {
        self.run(self.now + time_us);
    }

    /// Until the next cycle has taken what stands there.
    pub(crate) fn past_next_cycle(&mut self) {
        self.run(self.next_cycle + 1);
    }

    pub(crate) fn write(&mut self, written: Written) {
        self.out = OutWord(self.out).after(written).0;
        let seen = Observed::Write { at: Instant(self.now * 1_000), client: 1, written };
        self.referees[0].observe(seen);
    }

    pub(crate) fn put(&mut self, word: u32) {
        self.write(Written::Both(OutWord(word)));
    }

    /// A scan, and long enough for a cycle to be seen.
    pub(crate) fn scan(&mut self) {
        self.wait(self.scan_us.max(2 * self.cycle_us));
    }

    /// Scans until a program sees IN bit 31 as `bit`; what it sees is as old as its way is long.
    pub(crate) fn until(&mut self, bit: u32) {
        for _ in 0..1_000 {
            self.scan();
            let seen = self.input;
            self.wait(2 * self.latency_us);
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
